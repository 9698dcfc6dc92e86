// A state's mesh as text: Wavefront's .obj.
#pragma once

#include <cstddef>
#include <string_view>

#include "dvdx/layouts/state.hpp"
#include "files/part_file.hpp"
#include "scene_io/topology.hpp"

namespace dvdx::tool {

inline constexpr std::string_view obj_mark = "# dvdx: ";  // how every .obj that is written here starts

// Writes vertices, faces and lines. all: the number of particles of all ranks.
template <class T>
void write_obj(PartFile& file, std::string_view title, const Topology& topology, std::size_t all, const State<T>& state);

}  // namespace dvdx::tool
