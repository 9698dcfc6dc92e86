// Meshes: their file, and the springs, limits and faces that follow from it.
#pragma once

#include <cstddef>

#include "scene_io/fields.hpp"
#include "scene_io/mesh_file.hpp"
#include "scene_io/mesh_welding.hpp"
#include "scene_io/scene_file.hpp"
#include "scene_io/scene_folder.hpp"

namespace dvdx::tool {

// The .obj file that the node names.
[[nodiscard]] MeshFile mesh_of(const Node& node, SceneFolder& folder);
// By the keys `weld` and `unreferenced`.
[[nodiscard]] WeldedMesh welded(const Fields& fields, const MeshFile& file);

// The sides and, of four-sided faces, the diagonals with one stiffness; the bends with another.
[[nodiscard]] Springs springs_of(const MeshFile& mesh, std::size_t first, double edge, double bend);
// By the key `bending`. The mesh is flat where its faces are in one plane; else it flattens.
void bend_by_angles(const Fields& fields, const MeshFile& mesh, std::size_t first, Springs& springs);
// The sides of its faces, none longer than 1 + limit times what it is in the file.
[[nodiscard]] Distance limit_of(const MeshFile& mesh, std::size_t first, double limit);
[[nodiscard]] Topology topology_of(const MeshFile& mesh, std::size_t first);

}  // namespace dvdx::tool
