#include "checkpoint/kept_states.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <utility>

#include "checkpoint/files.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

// A state: step, time, particles, bytes of a number, whether ids follow; then x, y, z, vx, vy, vz of all particles, and ids.
class StateSink final : public Sink {
 public:
  explicit StateSink(const std::function<void(std::string_view)>& write) : write_(write) {}
  void write(std::string_view bytes) override {
    text_ += bytes;
    if (text_.size() >= most) flush();
  }
  void flush() {
    write_(text_);
    text_.clear();
  }

 private:
  static constexpr std::size_t most = std::size_t{1} << 20U;
  const std::function<void(std::string_view)>& write_;
  std::string text_;
};

}  // namespace

KeptStates::KeptStates(fs::path path, std::uint64_t every)
    : path_(std::move(path)), mark_{.file = path_.filename().string(), .every = every}, file_(path_, O_TRUNC) {}

KeptStates::KeptStates(fs::path path, const fs::path& from, const KeptStatesMark& mark)
    : path_(std::move(path)), mark_(mark), file_(path_, 0) {
  mark_.file = path_.filename().string();
  if (!fs::equivalent(path_, from)) {
    FileSource source(from, 0, mark.bytes);
    std::vector<char> some(std::size_t{1} << 18U);
    while (source.left() > 0) {
      const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(source.left(), some.size()));
      source.read(some.data(), now);
      write_all(file_.number(), path_, {some.data(), now});
    }
  }
  const int number = file_.number();
  if (ftruncate(number, static_cast<off_t>(mark.bytes)) != 0 || lseek(number, 0, SEEK_END) < 0) refuse_to_write(path_, errno);
}

void KeptStates::write(std::string_view bytes) {
  write_all(file_.number(), path_, bytes);
  mark_.crc = crc_of(bytes, mark_.crc);
  mark_.bytes += bytes.size();
}

template <class S>
void KeptStates::append(const Moment& moment, const State<S>& state, std::span<const std::uint32_t> ids) {
  const std::function<void(std::string_view)> write = [this](std::string_view bytes) { this->write(bytes); };
  StateSink sink(write);
  sink.put(moment.step);
  sink.put(moment.time);
  sink.put<std::uint64_t>(state.count);
  sink.put<std::uint32_t>(sizeof(S));
  sink.put<std::uint32_t>(ids.empty() ? 0 : 1);
  for (const auto* columns : {&state.x, &state.v}) {
    for (const auto& column : *columns) sink.put(column, state.count);
  }
  for (std::size_t i = 0; i < ids.size(); ++i) sink.put(ids[i]);
  sink.flush();
  ++mark_.count;
}

void KeptStates::sync() const { sync_file(file_.number(), path_); }

void check_kept_states(const fs::path& path, const KeptStatesMark& mark) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) {
    throw Fault(Exit::input_output,
                path.string() + ": cannot be read: " + error.message() + ". It belongs to the checkpoint beside it");
  }
  if (size < mark.bytes) {
    throw Fault(Exit::input_output, fmt::format("{}: is damaged: it has {} bytes, and its checkpoint counts on {}",
                                                path.string(), size, mark.bytes));
  }
  if (crc_of_file(path, 0, mark.bytes) != mark.crc) {
    throw Fault(Exit::input_output, path.string() + ": is damaged: its bytes are not those that its checkpoint counts on");
  }
}

template <class S>
void for_each_kept_state(const fs::path& path, const KeptStatesMark& mark, const UseKeptState<S>& use) {
  FileSource source(path, 0, mark.bytes);
  std::vector<std::uint32_t> ids;
  std::optional<Soa<S>> memory;
  for (std::uint64_t n = 0; n < mark.count; ++n) {
    Moment moment;
    source.get(moment.step);
    source.get(moment.time);
    const auto count = source.get<std::uint64_t>();
    const auto scalar = source.get<std::uint32_t>();
    const auto has_ids = source.get<std::uint32_t>();
    if (scalar != sizeof(S) || count > source.left() / (6 * sizeof(S))) source.fail();
    if (!memory || memory->view().count != count) memory.emplace(count);
    State<S> state = memory->view();
    state.clock.seconds = moment.time;
    for (const auto* columns : {&state.x, &state.v}) {
      for (const auto& column : *columns) source.get(column, count);
    }
    ids.resize(has_ids != 0 ? count : 0);
    for (auto& id : ids) source.get(id);
    use(moment, state, ids);
  }
}

template void KeptStates::append(const Moment&, const State<float>&, std::span<const std::uint32_t>);
template void KeptStates::append(const Moment&, const State<double>&, std::span<const std::uint32_t>);
template void for_each_kept_state<float>(const fs::path&, const KeptStatesMark&, const UseKeptState<float>&);
template void for_each_kept_state<double>(const fs::path&, const KeptStatesMark&, const UseKeptState<double>&);

}  // namespace dvdx::tool
