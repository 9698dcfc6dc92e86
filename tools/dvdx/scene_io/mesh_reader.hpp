// Meshes: their file, and the springs, limits and faces that follow from it.
#pragma once

#include <cstddef>

#include "scene_io/fields.hpp"
#include "scene_io/mesh_file.hpp"
#include "scene_io/mesh_welding.hpp"
#include "scene_io/scene_file.hpp"
#include "scene_io/scene_folder.hpp"

namespace dvdx::tool {

// Reads the .obj file that the node names.
[[nodiscard]] MeshFile mesh_of(const Node& node, SceneFolder& folder);
// Welds a mesh as the keys `weld` and `unreferenced` say.
[[nodiscard]] WeldedMesh welded(const Fields& fields, const MeshFile& file);

// Makes springs: sides and diagonals of faces with stiffness `edge`, bends with stiffness `bend`.
[[nodiscard]] Springs springs_of(const MeshFile& mesh, std::size_t first, double edge, double bend);
// Adds bending by angles as the key `bending` says. A mesh whose faces are in one plane is flat at rest; any other flattens.
void bend_by_angles(const Fields& fields, const MeshFile& mesh, std::size_t first, Springs& springs);
// Limits the sides of its faces to 1 + limit times their length in the file.
[[nodiscard]] Distance limit_of(const MeshFile& mesh, std::size_t first, double limit);
[[nodiscard]] Topology topology_of(const MeshFile& mesh, std::size_t first);

}  // namespace dvdx::tool
