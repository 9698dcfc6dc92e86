// A state as VTK XML PolyData with inline base64, streamed: no whole array, nor its text, is ever in memory.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>

#include "files/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {

// Adds the root of a VTK file of that type.
[[nodiscard]] pugi::xml_node add_vtk_root(pugi::xml_document& document, const char* type);
[[nodiscard]] std::string text_of(const pugi::xml_document& document);

template <class T>
[[nodiscard]] constexpr const char* vtk_type() noexcept {
  return sizeof(T) == 4 ? "Float32" : "Float64";
}

// Adds the state's time, which VTK reads from here.
void add_time(pugi::xml_node data, const Moment& moment);

// The array that is 1 for those points of a piece that another piece owns.
inline constexpr const char* vtk_ghosts = "vtkGhostType";

// Writes a whole .vtp. If output has ranks, each writes its part. If it is a piece whose particles have owners, points that
// another piece owns are marked.
template <class T>
void write_poly_data(PartFile& file, const Output& output, const Moment& moment, const State<T>& state);

// The .pvd gives files their times. It is written once all of them are known.
struct TimedFile {
  double time;  // s
  std::string file;
};
[[nodiscard]] std::string collection_of(const std::vector<TimedFile>& files);

}  // namespace dvdx::tool
