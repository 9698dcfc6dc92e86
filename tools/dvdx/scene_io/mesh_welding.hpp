// A mesh's vertices as particles: those that stand together are one, and those that nothing uses may be left out.
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
  std::size_t particles = 0;     // that they are
  std::size_t pieces = 0;        // that no side or line joins
  std::size_t unreferenced = 0;  // vertices of no face and no line, and one with none that is
  std::size_t left_out = 0;      // of these
  std::size_t polygons = 0;      // faces of more than four sides
  std::size_t near = 0;          // particles that stand a thousandth of a side or less from one of another piece
  double apart = 0;              // m: of these, the most that one is
};

struct WeldedMesh {
  MeshFile mesh;  // its vertices are the particles; every face has corners that differ, and no two have the same
  Numbering numbering;
  MeshFacts facts;
};

// weld: m, >= 0: vertices at most so far apart are one particle, which stands where the first of them does, and so are those
// that others join so; none: no two are. Particles are in the order of their first vertices. Faces that fall together are one;
// those that become a line are lines. A mesh without faces and lines keeps all vertices.
[[nodiscard]] WeldedMesh welded(const MeshFile& file, std::optional<double> weld, Unreferenced unreferenced);

}  // namespace dvdx::tool
