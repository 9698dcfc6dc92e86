// Makes particles of a mesh's vertices: those that stand together become one, and unused ones may be left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scene_io/mesh_file.hpp"
#include "scene_io/numbering.hpp"

namespace dvdx::tool {

enum class Unreferenced { left_out, kept };

// How faces and lines hold a mesh together.
struct MeshFacts {
  std::size_t vertices = 0;      // of the file
  std::size_t particles = 0;     // that the vertices become
  std::size_t pieces = 0;        // parts that no side or line joins
  std::size_t unreferenced = 0;  // vertices in no face and no line, nor welded to one that is
  std::size_t left_out = 0;      // of these
  std::size_t polygons = 0;      // faces of more than four sides
  std::size_t near = 0;          // particles within a thousandth of a side of one of another piece
  double apart = 0;              // m: the greatest distance of these
};

struct WeldedMesh {
  MeshFile mesh;  // its vertices are the particles; the corners of a face differ, and no two faces have the same
  Numbering numbering;
  MeshFacts facts;
};

// weld: m, >= 0: vertices at most so far apart, directly or through others, become one particle at the place of the first;
// none: no vertices are welded. Particles are in the order of their first vertices. Faces that fall together become one; those
// that become a line are lines. A mesh without faces and lines keeps all vertices.
[[nodiscard]] WeldedMesh welded(const MeshFile& file, std::optional<double> weld, Unreferenced unreferenced);

}  // namespace dvdx::tool
