// Blender's mesh cache: every state's positions in one .pc2, and beside it the .obj that they move. Blender matches the two by
// the vertices' order alone.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "files/bytes.hpp"
#include "files/part_file.hpp"
#include "output/obj_text.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

fs::path obj_beside(fs::path target) { return target.replace_extension(".obj"); }

std::string header(const Output& output) {
  constexpr std::uint64_t most = std::numeric_limits<std::int32_t>::max();
  if (output.particles > most || output.states > most) {
    throw Fault(Exit::input_output, fmt::format("{}: cannot be written: {} states of {} particles: a .pc2 holds {} of either",
                                                output.target.string(), output.states, output.particles, most));
  }
  std::string bytes("POINTCACHE2\0", 12);
  append_bytes<std::int32_t>(bytes, 1);  // version
  append_bytes(bytes, static_cast<std::int32_t>(output.particles));
  append_bytes(bytes, 0.0F);  // the first state's frame
  append_bytes(bytes, 1.0F);  // frames from one state to the next
  append_bytes(bytes, static_cast<std::int32_t>(output.states));
  return bytes;
}

template <class T>
void put_points(const State<T>& state, const PartFile::Put& put) {
  constexpr std::size_t chunk = std::size_t{1} << 16U;
  std::string bytes;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const auto& column : state.x) append_bytes(bytes, static_cast<float>(column[i]));
    if (bytes.size() < chunk) continue;
    put(bytes);
    bytes.clear();
  }
  put(bytes);
}

// The user named only the .pc2: an existing .obj that dvdx did not write may be the scene's own mesh, and is not replaced.
fs::path checked_obj(const fs::path& target) {
  auto path = obj_beside(target);
  check_target(path);
  if (!fs::exists(path)) return path;
  std::string start(obj_mark.size(), '\0');
  std::ifstream(path, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  if (start == obj_mark) return path;
  throw Fault(Exit::input_output,
              fmt::format("{}: cannot be written: {} goes with it, and one that dvdx did not write is there", target.string(),
                          path.string()));
}

template <class T>
class Pc2Writer final : public Writer<T> {
 public:
  explicit Pc2Writer(const Output& output) : output_(output) {
    std::string start;
    fs::path obj;
    together(output.ranks, [&] {
      start = header(output);
      obj = checked_obj(output.target);
    });
    files_.reserve(2);
    files_.emplace_back(output.target, output.ranks).write(start);
    files_.emplace_back(std::move(obj), output.ranks);
  }

  void write(const Moment&, const State<T>& state) override {
    if (is_first_)
      write_obj(files_[1], "the first state, whose vertices a .pc2 moves", *output_.topology,
                stretch_of(output_, state.count).all, state);
    is_first_ = false;
    constexpr std::size_t element = 3 * sizeof(float);
    files_[0].write_share(output_.first * element, output_.particles * element,
                          [&](const PartFile::Put& put) { put_points(state, put); });
  }

  void finish() override { commit_all(files_); }

 private:
  Output output_;
  std::vector<PartFile> files_;  // the .pc2 and its .obj
  bool is_first_ = true;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_pc2_writer(const Output& output) {
  return std::make_unique<Pc2Writer<T>>(output);
}

template std::unique_ptr<Writer<float>> make_pc2_writer(const Output&);
template std::unique_ptr<Writer<double>> make_pc2_writer(const Output&);

}  // namespace dvdx::tool
