// Signed distance from a closed surface of triangles, and the grid to which a contact samples it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx {

using Triangle = std::array<std::uint32_t, 3>;

// The fault by which triangles bound no body. open: an edge belongs to only one triangle; folded: two triangles have an edge in
// the same direction, or more than two have it; pinched: surfaces share a corner but no edge there.
enum class MeshFault : std::uint8_t { none, no_triangles, no_such_vertex, no_area, open, folded, pinched, inwards };
[[nodiscard]] MeshFault fault_of(const TriangleMesh& mesh);

// m, the grid's spacing: the one that the mesh asks for, or the longest side / 64.
[[nodiscard]] double cell_of(const TriangleMesh& mesh);

// Valid spacings of a grid. With the least it has at most most_nodes; the most is half the shortest side with its thickness.
struct CellRange {
  double least, most;  // m
};
[[nodiscard]] CellRange cell_range_of(const TriangleMesh& mesh);

// Nodes along each axis, with a margin of cells around the mesh and its thickness.
[[nodiscard]] std::array<std::size_t, 3> nodes_of(const TriangleMesh& mesh);
inline constexpr std::size_t most_nodes = std::size_t{1} << 24;

// The signed distance of any point from a mesh without a fault.
//   distance  from the nearest triangle, by its regions of corners, edges and face; a tree of boxes finds it.
//   sign      of n.(x - p), where p is the nearest point and n its normal: the normal of a face; for an edge the sum of its two
//             faces' normals; for a corner the sum of its faces' normals, each times the face's angle there. The sign is right
//             wherever the surface does not cross itself.
// Source: J. A. Baerentzen and H. Aanaes, IEEE TVCG 11 (2005) 243 (sign); C. Ericson, Real-Time Collision Detection, 5.1.5.
class SignedDistance {
 public:
  explicit SignedDistance(const TriangleMesh& mesh);
  [[nodiscard]] double at(const Vec3& x) const;
  // nearest: the triangle with which the search starts, best a near one; gets the nearest triangle.
  [[nodiscard]] double at(const Vec3& x, std::uint32_t& nearest) const;

 private:
  struct Node {  // a node of the tree
    Vec3 low, high;
    std::uint32_t first, count;  // a leaf's triangles; otherwise the second child and 0
  };
  struct Nearest {
    double square;
    Vec3 way, normal;  // from the nearest point to x; the normal there
    std::uint32_t triangle;
  };
  void add_node(std::size_t first, std::size_t count);
  void look_at(std::uint32_t triangle, const Vec3& x, Nearest& nearest) const;

  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;  // in the order of the leaves
  std::vector<Node> nodes_;
  std::vector<Vec3> face_normals_;                 // of unit length
  std::vector<std::array<Vec3, 3>> edge_normals_;  // of the edge that starts at each corner
  std::vector<Vec3> vertex_normals_;
};

// The signed distance at the nodes of a grid, less the thickness, x fastest.
struct DistanceGrid {
  Vec3 center{};        // m: of the grid and of the box about the mesh
  Vec3 half_extents{};  // m: of that box, with the thickness
  Vec3 low{};           // m: the first node, relative to the center
  double cell = 0;
  std::array<std::size_t, 3> nodes{};
  std::vector<double> values;
  double steepness = 1;  // upper bound of the interpolated slope between the nodes; at least 1
};
[[nodiscard]] DistanceGrid sampled(const TriangleMesh& mesh);

}  // namespace dvdx
