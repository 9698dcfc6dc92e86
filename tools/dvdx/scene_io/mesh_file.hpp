// Surfaces from .obj files, and the pairs of vertices that springs may join.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx::tool {

struct MeshFile {
  std::vector<Vec3> vertices;                     // m, in file order
  std::vector<std::vector<std::uint32_t>> faces;  // polygons of three or more vertices, all different
  std::vector<Pair> lines;                        // the pieces of the file's polylines
};

// Reads the statements v, f (or fo, an older form) and l, in letters of any case, and skips all others. A line that ends with a
// backslash continues in the next. A byte order mark is skipped. Indices count from 1, or back from the last vertex read so
// far; text after a slash is ignored. Throws FileFault.
[[nodiscard]] MeshFile read_mesh(const std::filesystem::path& path);
[[nodiscard]] MeshFile parse_mesh(std::string_view text);

// All lists below have each pair once, its smaller end first, sorted.

// Returns the polygons' sides and the lines.
[[nodiscard]] std::vector<Pair> edges_of(const MeshFile& mesh);

// Returns both diagonals of four-sided faces, and a fan about the first vertex of larger ones. Without them faces shear freely.
[[nodiscard]] std::vector<Pair> diagonals_of(const MeshFile& mesh);

// Returns, across each side that two faces share, the vertices next to it in the one and in the other: the two opposite
// vertices of triangles, and those straight across, as in a grid, of four-sided faces. Triangles of a fan bend likewise.
[[nodiscard]] std::vector<Pair> bends_of(const MeshFile& mesh);

}  // namespace dvdx::tool
