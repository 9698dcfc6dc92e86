// The signed distance from a closed surface of triangles, and the grid that a contact samples it to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx {

using Triangle = std::array<std::uint32_t, 3>;

// The fault that keeps triangles from bounding a body. open: of an edge that only one triangle has; folded: of an edge that two
// triangles have in the same direction, or more than two; pinched: of surfaces that share a corner and no edge there.
enum class MeshFault : std::uint8_t { none, no_triangles, no_such_vertex, no_area, open, folded, pinched, inwards };
[[nodiscard]] MeshFault fault_of(const TriangleMesh& mesh);

// m, of the grid: the one asked for, or the longest side / 64.
[[nodiscard]] double cell_of(const TriangleMesh& mesh);

// The cells of a grid: at the least it has no more than most_nodes, and at the most two of them are within the shortest side.
struct CellRange {
  double least, most;  // m
};
[[nodiscard]] CellRange cell_range_of(const TriangleMesh& mesh);

// Nodes along each axis, with a margin of cells around the mesh and its thickness.
[[nodiscard]] std::array<std::size_t, 3> nodes_of(const TriangleMesh& mesh);
inline constexpr std::size_t most_nodes = std::size_t{1} << 24;

// The signed distance, at any point, from a mesh without a fault.
//   distance  that from the nearest triangle, by its regions of corners, edges and face; found in a tree of boxes.
//   sign      that of n.(x - p), p the nearest point, n the normal of its face; of an edge the sum of its two faces' normals,
//             of a corner the sum of its faces', each times the face's angle there. It is right wherever the surface does not
//             cross itself.
// Source: J. A. Baerentzen and H. Aanaes, IEEE TVCG 11 (2005) 243 (sign); C. Ericson, Real-Time Collision Detection, 5.1.5.
class SignedDistance {
 public:
  explicit SignedDistance(const TriangleMesh& mesh);
  [[nodiscard]] double at(const Vec3& x) const;
  // nearest: a triangle that is not far, from which the search starts; then the one that it found.
  [[nodiscard]] double at(const Vec3& x, std::uint32_t& nearest) const;

 private:
  struct Node {  // of the tree
    Vec3 low, high;
    std::uint32_t first, count;  // triangles of a leaf; of others the second child and 0
  };
  struct Nearest {
    double square;
    Vec3 way, normal;  // from it to the point
    std::uint32_t triangle;
  };
  void add_node(std::size_t first, std::size_t count);
  void look_at(std::uint32_t triangle, const Vec3& x, Nearest& nearest) const;

  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;  // in the order of the leaves
  std::vector<Node> nodes_;
  std::vector<Vec3> face_normals_;                 // of unit length
  std::vector<std::array<Vec3, 3>> edge_normals_;  // of the edge from each corner on
  std::vector<Vec3> vertex_normals_;
};

// Its values at the nodes of a grid, less the thickness, x fastest.
struct DistanceGrid {
  Vec3 center{};        // m: of the grid and of the box about the mesh
  Vec3 half_extents{};  // m: of that box, with the thickness
  Vec3 low{};           // m: the first node, from the center
  double cell = 0;
  std::array<std::size_t, 3> nodes{};
  std::vector<double> values;
  double steepness = 1;  // no slope of what lies between the nodes is steeper; at least 1
};
[[nodiscard]] DistanceGrid sampled(const TriangleMesh& mesh);

}  // namespace dvdx
