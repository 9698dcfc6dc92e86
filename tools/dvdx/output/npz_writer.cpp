// NumPy's archive: steps (int64), times (float64), positions and velocities (states, particles, 3) in the run's precision.
#include <fmt/format.h>
#include <zip.h>

#include <array>
#include <vector>

#include "output/bytes.hpp"
#include "output/part_file.hpp"
#include "output/temporary.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

// Format version 1.0: the header is padded so that the data starts at a multiple of 64 bytes.
std::string npy_header(std::string_view type, const std::string& shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, shape);
  constexpr std::size_t fixed = 10;
  text.append(63 - (fixed + text.size()) % 64, ' ');
  text += '\n';
  const auto length = static_cast<std::uint16_t>(text.size());
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(length & 0xFFU);
  header += static_cast<char>(length >> 8U);
  return header + text;
}

// The archive that libzip builds. Members are stored as they are: numbers of a simulation hardly compress.
class Archive {
 public:
  explicit Archive(const std::filesystem::path& path) : path_(path) {
    int error = 0;
    zip_ = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
    if (zip_ == nullptr) throw Fault(Exit::input_output, path.string() + ": cannot be written");
  }
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;
  ~Archive() {
    if (zip_ != nullptr) zip_discard(zip_);
  }

  void add_file(const char* name, const std::filesystem::path& file) {
    add(name, zip_source_file(zip_, file.c_str(), 0, to_its_end));
  }
  // bytes must live until close().
  void add_bytes(const char* name, const std::string& bytes) {
    add(name, zip_source_buffer(zip_, bytes.data(), bytes.size(), 0));
  }

  // libzip writes to a file of a name of its own choice, which it removes itself where it is cancelled.
  void close() {
    const SignalsHeld held;
    zip_register_cancel_callback_with_state(
        zip_, [](zip_t*, void*) { return SignalsHeld::is_one_waiting() ? 1 : 0; }, nullptr, nullptr);
    if (zip_close(zip_) != 0) fail();
    zip_ = nullptr;
  }

 private:
  static constexpr zip_int64_t to_its_end = -1;

  [[noreturn]] void fail() const {
    throw Fault(Exit::input_output, path_.string() + ": cannot be written: " + zip_strerror(zip_));
  }

  void add(const char* name, zip_source_t* source) {
    if (source == nullptr) fail();
    const zip_int64_t index = zip_file_add(zip_, name, source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      fail();
    }
    const auto member = static_cast<zip_uint64_t>(index);
    zip_set_file_compression(zip_, member, ZIP_CM_STORE, 0);
    // The same run gives the same bytes: the time is that of no clock, 1 January 1980.
    constexpr zip_uint16_t first_date = (1U << 5U) | 1U;
    zip_file_set_dostime(zip_, member, 0, first_date, 0);
  }

  std::filesystem::path path_;
  zip_t* zip_ = nullptr;
};

template <class T>
class NpzWriter final : public Writer<T> {
 public:
  // Positions and velocities grow side by side while the states come, but stand one after the other in the archive: they wait
  // in files of their own.
  explicit NpzWriter(const Output& output)
      : ranks_(output.ranks),
        first_(output.first),
        particles_(output.particles),
        archive_(output.target, ranks_),
        positions_(beside(output.target, "positions"), ranks_),
        velocities_(beside(output.target, "velocities"), ranks_) {
    const auto header = npy_header(type, fmt::format("{}, {}, 3", output.states, output.particles));
    positions_.write(header);
    velocities_.write(header);
  }

  void write(const Moment& moment, const State<T>& state) override {
    write(positions_, state.x, state.count);
    write(velocities_, state.v, state.count);
    steps_.push_back(static_cast<std::int64_t>(moment.step));
    times_.push_back(moment.time);
  }

  void finish() override {
    positions_.close();
    velocities_.close();
    archive_.close();
    together(ranks_, [this] {
      if (ranks_ == nullptr || ranks_->rank() == 0) fill_archive();
    });
    archive_.commit();
  }

 private:
  void write(PartFile& file, const std::array<Column<T>, 3>& columns, std::size_t count) {
    constexpr std::size_t element = 3 * sizeof(T);
    file.write_share(first_ * element, particles_ * element,
                     [&](const PartFile::Put& put) { put_interleaved<T>(columns, count, put); });
  }

  void fill_archive() {
    const std::string shape = fmt::format("{},", steps_.size());
    const std::string steps = npy_header("<i8", shape) + bytes_of(steps_);
    const std::string times = npy_header("<f8", shape) + bytes_of(times_);
    Archive archive(archive_.part());
    archive.add_bytes("steps.npy", steps);
    archive.add_bytes("times.npy", times);
    archive.add_file("positions.npy", positions_.part());
    archive.add_file("velocities.npy", velocities_.part());
    archive.close();
  }

  static constexpr const char* type = sizeof(T) == 4 ? "<f4" : "<f8";

  static std::filesystem::path beside(std::filesystem::path target, std::string_view name) {
    return target.replace_filename(fmt::format("{}-{}", target.filename().string(), name));
  }

  Ranks* ranks_;
  std::size_t first_, particles_;
  PartFile archive_;
  PartFile positions_;   // never renamed into place
  PartFile velocities_;  // neither
  std::vector<std::int64_t> steps_;
  std::vector<double> times_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_npz_writer(const Output& output) {
  return std::make_unique<NpzWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_npz_writer(const Output&);
template std::unique_ptr<Writer<double>> make_npz_writer(const Output&);

}  // namespace dvdx::tool
