#include "output/obj_text.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

// Text that goes to its file piece by piece.
class ObjText {
 public:
  explicit ObjText(PartFile& file) : file_(file) {}

  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
    if (text_.size() > chunk) flush();
  }

  template <class Shapes>
  void add_all(char element, const Shapes& shapes) {
    for (const auto& shape : shapes) {
      text_ += element;
      for (const std::size_t corner : shape) add(" {}", corner + 1);
      text_ += '\n';
    }
  }

  void flush() {
    file_.write(text_);
    text_.clear();
  }

 private:
  static constexpr std::size_t chunk = 1 << 20;
  PartFile& file_;
  std::string text_;
};

// Blender's importer drops a vertex that no element uses, and a cache of another count than the mesh's moves nothing. A line
// from such a vertex to itself keeps it. A mesh of vertices alone needs no such lines.
std::vector<std::array<std::size_t, 2>> holding_lines(const Topology& topology, std::size_t count) {
  std::vector<std::array<std::size_t, 2>> lines;
  if (topology == no_topology) return lines;
  for (const auto& [particle] : loose_particles(topology, count)) lines.push_back({particle, particle});
  return lines;
}

template <class T>
void write_vertices(const PartFile::Put& put, const State<T>& state) {
  constexpr std::size_t chunk = 1 << 20;
  std::string text;
  for (std::size_t i = 0; i < state.count; ++i) {
    fmt::format_to(std::back_inserter(text), "v {} {} {}\n", state.x[0][i], state.x[1][i], state.x[2][i]);
    if (text.size() <= chunk) continue;
    put(text);
    text.clear();
  }
  put(text);
}

}  // namespace

template <class T>
void write_obj(PartFile& file, std::string_view title, const Topology& topology, std::size_t all, const State<T>& state) {
  ObjText text(file);
  text.add("{}{}\n", obj_mark, title);
  text.flush();
  file.write_in_turn([&](const PartFile::Put& put) { write_vertices(put, state); });
  text.add_all('f', topology.faces);
  text.add_all('l', topology.lines);
  text.add_all('l', holding_lines(topology, all));
  text.flush();
}

template void write_obj(PartFile&, std::string_view, const Topology&, std::size_t, const State<float>&);
template void write_obj(PartFile&, std::string_view, const Topology&, std::size_t, const State<double>&);

}  // namespace dvdx::tool
