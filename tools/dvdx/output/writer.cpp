#include "output/writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <span>
#include <string_view>

#include "dvdx/layouts/soa.hpp"
#include "files/part_file.hpp"
#include "files/part_name.hpp"
#include "ranks/agree.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

// The files that a format makes for a target.
enum class Files { one, one_or_series, series, indexed_series, pieces, mesh_beside };

// The states that are written unless others are asked for.
enum class Use { last_state, animation };

template <class T>
struct Format {
  std::string_view extension;
  std::unique_ptr<Writer<T>> (*make)(const Output&);
  Use use;
  Files files = Files::one;
  Counts counts = Counts::changing;  // that it can hold
};

template <class T>
constexpr std::array<Format<T>, 10> formats{{{".csv", make_csv_writer<T>, Use::last_state},
                                             {".npz", make_npz_writer<T>, Use::animation, Files::one, Counts::fixed},
                                             {".ply", make_ply_writer<T>, Use::last_state, Files::series},
                                             {".vtp", make_vtp_writer<T>, Use::animation, Files::indexed_series},
                                             {".pvtp", make_pvtp_writer<T>, Use::animation, Files::pieces},
                                             {".pc2", make_pc2_writer<T>, Use::animation, Files::mesh_beside, Counts::fixed},
                                             {".html", make_html_writer<T>, Use::animation},
                                             {".obj", make_obj_writer<T>, Use::last_state, Files::one_or_series},
                                             {".png", make_png_writer<T>, Use::last_state, Files::one_or_series},
                                             {".apng", make_apng_writer<T>, Use::animation}}};

fs::path renamed(fs::path target, const char* extension) { return target.replace_extension(extension); }

bool is_series(const Output& output, Files files) {
  if (files == Files::one_or_series) return output.states > 1;
  return files == Files::series || files == Files::indexed_series || files == Files::pieces;
}

// Files that go with the states.
std::vector<fs::path> beside_of(const fs::path& target, Files files) {
  if (files == Files::indexed_series || files == Files::pieces) return {renamed(target, ".pvd")};
  if (files == Files::mesh_beside) return {renamed(target, ".obj")};
  return {};
}

std::vector<fs::path> targets_of(const Output& output, Files files) {
  std::vector<fs::path> targets;
  const int rank = output.ranks == nullptr ? 0 : output.ranks->rank();
  if (is_series(output, files)) {
    for (std::uint64_t i = 0; i < output.states; ++i) targets.push_back(numbered(output.target, i));
  }
  for (std::uint64_t i = 0; files == Files::pieces && i < output.states; ++i) {
    targets.push_back(piece_of(output.target, i, rank));
  }
  if (!is_series(output, files) || files == Files::pieces) targets.push_back(output.target);
  for (const auto& beside : beside_of(output.target, files)) targets.push_back(beside);
  return targets;
}

// Refuses to write over or remove files that the scene was read from.
void check_targets(const Output& output, Files files) {
  const auto sources = output.scene != nullptr ? std::span<const fs::path>(output.scene->sources) : std::span<const fs::path>();
  for (const auto& target : targets_of(output, files)) {
    check_target(target);
    check_is_no_source(target, sources, output.target);
  }
  if (!is_series(output, files)) return;
  for (const auto& frame : old_frames(output)) check_is_no_source(frame, sources, output.target);
}

void check_targets_together(const Output& output, Files files) {
  together(output.ranks, [&] { check_targets(output, files); });
}

// A writer for formats that need whole states, which the first rank receives.
template <class T>
class WrittenByFirst final : public Writer<T> {
 public:
  WrittenByFirst(const Output& output, std::unique_ptr<Writer<T>> (*make)(const Output&))
      : output_(output), ranks_(*output.ranks), memory_(is_first() ? output.particles : 0) {
    Output alone = output;
    alone.ranks = nullptr;
    alone.first = 0;
    if (output.ids) alone.ids = [this](std::size_t) { return std::span<const std::uint32_t>(ids_); };
    together(ranks_, [&] {
      if (is_first()) writer_ = make(alone);
    });
  }

  void write(const Moment& moment, const State<T>& state) override {
    State<T> whole = memory_.view();
    whole.count = take(stretch_of(output_, state.count).all, state, whole);
    together(ranks_, [&] {
      if (is_first()) writer_->write(moment, whole);
    });
  }
  void finish() override {
    together(ranks_, [&] {
      if (is_first()) writer_->finish();
    });
  }

 private:
  [[nodiscard]] bool is_first() const noexcept { return ranks_.rank() == 0; }

  // Receives the state into `whole`: all particles on the first rank, none on others. Returns their number.
  std::size_t take(std::size_t all, const State<T>& state, State<T>& whole) {
    std::vector<std::uint32_t> numbers(is_first() ? all : 0);
    std::iota(numbers.begin(), numbers.end(), 0U);
    RangeExchange exchange(ranks_, all, numbers);
    exchange.from_ranges(state, whole);
    ids_.resize(output_.ids ? numbers.size() : 0);
    if (output_.ids) exchange.from_ranges(output_.ids(state.count), ids_);
    return numbers.size();
  }

  Output output_;
  Ranks& ranks_;
  Soa<T> memory_;
  std::vector<std::uint32_t> ids_;
  std::unique_ptr<Writer<T>> writer_;  // the first rank's
};

template <class T>
const Format<T>* format_for(const std::filesystem::path& target) {
  const auto found = std::find_if(formats<T>.begin(), formats<T>.end(),
                                  [&](const auto& format) { return target.extension() == format.extension; });
  return found == formats<T>.end() ? nullptr : &*found;
}

template <class T>
std::unique_ptr<Writer<T>> make_for_target_by_number(const Output& output) {
  return make_writer_by_number<T>(output, format_for<T>(output.target)->make);
}

}  // namespace

void check_extension(const std::filesystem::path& target) {
  if (format_for<float>(target) != nullptr) return;
  throw Fault(Exit::usage, "--out " + target.string() + ": must end in " + written_extensions());
}

bool is_animation(const std::filesystem::path& target) {
  const auto* const format = format_for<float>(target);
  return format != nullptr && format->use == Use::animation;
}

std::string written_extensions() {
  std::string text;
  for (const auto& format : formats<float>) {
    const bool is_last = &format == &formats<float>.back();
    text += (text.empty() ? "" : is_last ? " or " : ", ") + std::string(format.extension);
  }
  return text;
}

std::vector<WrittenFile> files_of(const Output& output) {
  const Files files = format_for<float>(output.target)->files;
  std::vector<WrittenFile> written;
  if (is_series(output, files)) {
    const auto last = output.states > 1 ? numbered(output.target, output.states - 1) : fs::path();
    written.push_back({.file = numbered(output.target, 0), .last = last, .states = output.states});
  } else {
    written.push_back({.file = output.target, .states = output.states});
  }
  for (const auto& beside : beside_of(output.target, files)) written.push_back({.file = beside});
  return written;
}

bool is_page(const std::filesystem::path& target) { return target.extension() == ".html"; }

bool is_drawn(const std::filesystem::path& target) {
  return is_page(target) || target.extension() == ".png" || target.extension() == ".apng";
}

bool is_in_pieces(const std::filesystem::path& target) { return target.extension() == ".pvtp"; }

template <class T>
std::unique_ptr<Writer<T>> make_writer(const Output& output) {
  check_extension(output.target);
  const Format<T>& format = *format_for<T>(output.target);
  if (output.counts == Counts::changing && format.counts == Counts::fixed) {
    throw Fault(Exit::usage,
                fmt::format("--out {}: a {} holds as many particles in every state, and those of this scene come and "
                            "go: .csv, .ply, .obj, .vtp, .pvtp, .html, .png and .apng hold them",
                            output.target.string(), format.extension));
  }
  check_targets_together(output, format.files);
  if (output.ranks == nullptr || output.ranks->rank() == 0) remove_stale_parts(output.target.parent_path());
  if (!output.numbering->is_own()) {
    if (output.ranks != nullptr) return std::make_unique<WrittenByFirst<T>>(output, make_for_target_by_number<T>);
    return make_for_target_by_number<T>(output);
  }
  if (output.ranks != nullptr && is_drawn(output.target)) return std::make_unique<WrittenByFirst<T>>(output, format.make);
  return format.make(output);
}

Stretch stretch_of(const Output& output, std::size_t here) {
  if (output.ranks == nullptr) return {.first = 0, .all = here};
  if (output.counts == Counts::fixed) return {.first = output.first, .all = output.particles};
  std::uint64_t all = here;
  output.ranks->sum(std::span(&all, 1));
  return {.first = share_of(*output.ranks).of(all).first, .all = all};
}

std::vector<fs::path> old_frames(const Output& output) {
  std::vector<fs::path> frames;
  std::error_code ignored;
  for (auto i = output.states; fs::is_regular_file(numbered(output.target, i), ignored); ++i) {
    frames.push_back(numbered(output.target, i));
  }
  return frames;
}

void commit_series(std::vector<PartFile>& files, const std::vector<fs::path>& old_frames) {
  const SignalsHeld held;
  commit_all(files);
  for (const auto& frame : old_frames) {
    std::error_code error;
    fs::remove(frame, error);
    if (error) throw Fault(Exit::input_output, frame.string() + ": an older frame cannot be removed: " + error.message());
  }
}

std::filesystem::path numbered(const std::filesystem::path& target, std::uint64_t index) {
  auto path = target;
  return path.replace_filename(fmt::format("{}-{:06}{}", target.stem().string(), index, target.extension().string()));
}

std::size_t tears_until(const Output& output, std::uint64_t step) {
  if (output.tears == nullptr) return 0;
  const auto is_later = [](std::uint64_t until, const Tear& tear) { return until < tear.step; };
  return static_cast<std::size_t>(std::upper_bound(output.tears->begin(), output.tears->end(), step, is_later) -
                                  output.tears->begin());
}

std::filesystem::path piece_of(const std::filesystem::path& target, std::uint64_t index, int rank) {
  auto path = target;
  return path.replace_filename(fmt::format("{}-{:06}-{:04}.vtp", target.stem().string(), index, rank));
}

std::vector<std::array<std::size_t, 1>> loose_particles(const Topology& topology, std::size_t count) {
  std::vector<bool> is_joined(count);
  const auto mark_held = [&](const auto& shapes) {
    for (const auto& shape : shapes) {
      for (const auto corner : shape) is_joined.at(corner) = true;
    }
  };
  mark_held(topology.lines);
  mark_held(topology.faces);
  std::vector<std::array<std::size_t, 1>> loose;
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_joined[i]) loose.push_back({i});
  }
  return loose;
}

template <class T>
void put_interleaved(std::span<const Column<T>> columns, std::size_t count, const std::function<void(std::string_view)>& put) {
  constexpr std::size_t at_once = 8192;
  std::string bytes;
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t end = std::min(count, first + at_once);
    bytes.resize((end - first) * columns.size() * sizeof(T));
    char* out = bytes.data();
    for (std::size_t i = first; i < end; ++i) {
      for (const auto& column : columns) {
        std::memcpy(out, column.at(i), sizeof(T));
        out += sizeof(T);
      }
    }
    put(bytes);
  }
}

template std::unique_ptr<Writer<float>> make_writer(const Output&);
template std::unique_ptr<Writer<double>> make_writer(const Output&);
template void put_interleaved(std::span<const Column<float>>, std::size_t, const std::function<void(std::string_view)>&);
template void put_interleaved(std::span<const Column<double>>, std::size_t, const std::function<void(std::string_view)>&);

}  // namespace dvdx::tool
