// A state as VTK XML PolyData with inline base64, streamed: never a whole array, nor its text, is in memory.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>

#include "files/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {

// The root of a VTK file of that type.
[[nodiscard]] pugi::xml_node add_vtk_root(pugi::xml_document& document, const char* type);
[[nodiscard]] std::string text_of(const pugi::xml_document& document);

template <class T>
[[nodiscard]] constexpr const char* vtk_type() noexcept {
  return sizeof(T) == 4 ? "Float32" : "Float64";
}

// The state's time, which VTK reads from here.
void add_time(pugi::xml_node data, const Moment& moment);

// The array that is 1 for a piece's points that are another piece's.
inline constexpr const char* vtk_ghosts = "vtkGhostType";

// All of a .vtp. Where output has ranks, each writes its part. Where it is of a piece whose particles have owners, the points
// that are another's are marked.
template <class T>
void write_poly_data(PartFile& file, const Output& output, const Moment& moment, const State<T>& state);

// The .pvd that gives files their times, written once all of them are known.
struct TimedFile {
  double time;  // s
  std::string file;
};
[[nodiscard]] std::string collection_of(const std::vector<TimedFile>& files);

}  // namespace dvdx::tool
