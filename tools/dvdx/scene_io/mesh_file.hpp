// Surfaces from .obj files, and what joins their vertices.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx::tool {

struct MeshFile {
  std::vector<Vec3> vertices;                     // m, in file order
  std::vector<std::vector<std::uint32_t>> faces;  // polygons of three or more vertices, each its own
  std::vector<Pair> lines;                        // the pieces of the file's polylines
};

// The statements v, f (or fo, as it once was) and l, in letters of any case; all others are passed over. A line that ends with
// a backslash goes on in the next. A byte order mark is passed over. Indices are from 1 on, or count back from the last vertex
// read so far; what follows a slash is not looked at. Throws FileFault.
[[nodiscard]] MeshFile read_mesh(const std::filesystem::path& path);
[[nodiscard]] MeshFile parse_mesh(std::string_view text);

// All lists: each pair once, its smaller end first, sorted.

// The polygons' sides and the lines.
[[nodiscard]] std::vector<Pair> edges_of(const MeshFile& mesh);

// Both of a four-sided face, and of faces of more sides those of a fan about the first vertex: without them, they shear freely.
[[nodiscard]] std::vector<Pair> diagonals_of(const MeshFile& mesh);

// Across each side that two faces share: the vertices next to it in the one and in the other, so the two opposite ones of
// triangles, and those straight across, as in a grid, of four-sided faces. Triangles of a fan bend likewise.
[[nodiscard]] std::vector<Pair> bends_of(const MeshFile& mesh);

}  // namespace dvdx::tool
