#include "scene/signed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/rotation.hpp"
#include "math/vec3.hpp"

namespace dvdx {
namespace {

constexpr std::size_t leaf = 4;      // triangles
constexpr double margin_cells = 3;   // around the mesh
constexpr double cells_a_side = 64;  // if the mesh gives no cell

struct Extent {
  Vec3 low, high;
  [[nodiscard]] Vec3 sides() const noexcept { return difference(high, low); }
};
Extent extent_of(const std::vector<Vec3>& vertices) {
  Extent extent{vertices.front(), vertices.front()};
  for (const Vec3& v : vertices) {
    for (std::size_t k = 0; k < 3; ++k) {
      extent.low[k] = std::min(extent.low[k], v[k]);
      extent.high[k] = std::max(extent.high[k], v[k]);
    }
  }
  return extent;
}

Vec3 area_of(const std::vector<Vec3>& vertices, const Triangle& t) noexcept {
  return cross(difference(vertices[t[1]], vertices[t[0]]), difference(vertices[t[2]], vertices[t[0]]));
}

// The angle between two directions, 0 to pi.
double angle_between(const Vec3& a, const Vec3& b) noexcept {
  const double s = length(cross(a, b));
  const double c = dot(a, b);
  const double scale = std::sqrt(s * s + c * c);
  if (!(scale > 0)) return 0;
  const double acute = angle_of(s / scale, std::abs(c) / scale);
  return c < 0 ? 2 * half_pi[0] - acute : acute;
}

double square_to(const Vec3& low, const Vec3& high, const Vec3& x) noexcept {
  double square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double away = std::max({low[k] - x[k], x[k] - high[k], 0.0});
    square += away * away;
  }
  return square;
}

// An edge of a triangle, in the triangle's direction.
struct HalfEdge {
  std::uint32_t from, to;
  std::uint32_t triangle, corner;  // the corner where it starts
};
bool is_before(const HalfEdge& a, const HalfEdge& b) noexcept { return a.from != b.from ? a.from < b.from : a.to < b.to; }

// The half-edges of all triangles, sorted by their ends.
class HalfEdges {
 public:
  explicit HalfEdges(const std::vector<Triangle>& triangles) : triangles_(triangles) {
    edges_.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k) edges_.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t, k});
    }
    std::sort(edges_.begin(), edges_.end(), is_before);
  }

  [[nodiscard]] const std::vector<HalfEdge>& all() const noexcept { return edges_; }
  [[nodiscard]] bool has_double() const noexcept {
    const auto same = [](const HalfEdge& a, const HalfEdge& b) { return a.from == b.from && a.to == b.to; };
    return std::adjacent_find(edges_.begin(), edges_.end(), same) != edges_.end();
  }
  // The same edge in the neighbouring triangle, or null.
  [[nodiscard]] const HalfEdge* reverse_of(const HalfEdge& edge) const noexcept { return find(edge.to, edge.from); }
  // Whether the triangles about each vertex of a closed surface form one fan: going around the vertex from triangle to triangle
  // meets all edges that start there.
  [[nodiscard]] bool are_fans() const noexcept {
    for (std::size_t first = 0, end = 0; first < edges_.size(); first = end) {
      while (end < edges_.size() && edges_[end].from == edges_[first].from) ++end;
      std::size_t met = 0;
      const HalfEdge* edge = &edges_[first];
      do {
        const Triangle& beside = triangles_[reverse_of(*edge)->triangle];
        const std::uint32_t corner = reverse_of(*edge)->corner;  // where the reverse edge starts
        edge = find(edge->from, beside[(corner + 2) % 3]);
        ++met;
      } while (edge != &edges_[first] && met <= end - first);
      if (met != end - first) return false;
    }
    return true;
  }

 private:
  [[nodiscard]] const HalfEdge* find(std::uint32_t from, std::uint32_t to) const noexcept {
    const HalfEdge edge{from, to, 0, 0};
    const auto at = std::lower_bound(edges_.begin(), edges_.end(), edge, is_before);
    return at != edges_.end() && !is_before(edge, *at) ? &*at : nullptr;
  }

  const std::vector<Triangle>& triangles_;
  std::vector<HalfEdge> edges_;
};

}  // namespace

MeshFault fault_of(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return MeshFault::no_triangles;
  double volume = 0;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      if (v >= mesh.vertices.size()) return MeshFault::no_such_vertex;
    }
    if (!(length(area_of(mesh.vertices, t)) > 0)) return MeshFault::no_area;
    const Vec3& from = mesh.vertices[mesh.triangles[0][0]];
    volume += dot(difference(mesh.vertices[t[0]], from), area_of(mesh.vertices, t));
  }
  const HalfEdges edges(mesh.triangles);
  if (edges.has_double()) return MeshFault::folded;
  const auto is_open = [&](const HalfEdge& edge) { return edges.reverse_of(edge) == nullptr; };
  if (std::any_of(edges.all().begin(), edges.all().end(), is_open)) return MeshFault::open;
  if (!edges.are_fans()) return MeshFault::pinched;
  return volume > 0 ? MeshFault::none : MeshFault::inwards;
}

double cell_of(const TriangleMesh& mesh) {
  if (mesh.cell > 0) return mesh.cell;
  const Vec3 sides = extent_of(mesh.vertices).sides();
  return std::max({sides[0], sides[1], sides[2]}) / cells_a_side;
}

namespace {

std::array<std::size_t, 3> nodes_of(const TriangleMesh& mesh, double cell) {
  const Vec3 sides = extent_of(mesh.vertices).sides();
  std::array<std::size_t, 3> nodes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double cells = (sides[k] + 2 * mesh.thickness) / cell + 2 * margin_cells;
    nodes[k] = cells < 1e6 ? static_cast<std::size_t>(cells) + 2 : most_nodes;
  }
  return nodes;
}

bool is_too_many(const std::array<std::size_t, 3>& nodes) {
  double product = 1;
  for (const std::size_t n : nodes) product *= static_cast<double>(n);
  return product > static_cast<double>(most_nodes);
}

}  // namespace

std::array<std::size_t, 3> nodes_of(const TriangleMesh& mesh) { return nodes_of(mesh, cell_of(mesh)); }

CellRange cell_range_of(const TriangleMesh& mesh) {
  const Vec3 sides = extent_of(mesh.vertices).sides();
  double few = std::max({sides[0], sides[1], sides[2]}) + 2 * mesh.thickness;
  double many = 0;
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = (few + many) / 2;
    (is_too_many(nodes_of(mesh, middle)) ? many : few) = middle;
  }
  return {few, (std::min({sides[0], sides[1], sides[2]}) + 2 * mesh.thickness) / 2};
}

SignedDistance::SignedDistance(const TriangleMesh& mesh)
    : vertices_(mesh.vertices), triangles_(mesh.triangles), vertex_normals_(mesh.vertices.size()) {
  add_node(0, triangles_.size());
  for (const Triangle& t : triangles_) face_normals_.push_back(unit(area_of(vertices_, t)));
  edge_normals_.resize(triangles_.size());
  const HalfEdges edges(triangles_);
  for (const HalfEdge& edge : edges.all()) {
    edge_normals_[edge.triangle][edge.corner] =
        sum(face_normals_[edge.triangle], face_normals_[edges.reverse_of(edge)->triangle]);
    const Triangle& t = triangles_[edge.triangle];
    const Vec3& corner = vertices_[edge.from];
    const double angle =
        angle_between(difference(vertices_[edge.to], corner), difference(vertices_[t[(edge.corner + 2) % 3]], corner));
    vertex_normals_[edge.from] = sum(vertex_normals_[edge.from], scaled(face_normals_[edge.triangle], angle));
  }
}

// Halves the triangles by their middles along the longest side of their box.
void SignedDistance::add_node(std::size_t first, std::size_t count) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Node node{{infinity, infinity, infinity},
            {-infinity, -infinity, -infinity},
            static_cast<std::uint32_t>(first),
            static_cast<std::uint32_t>(count)};
  for (std::size_t i = first; i < first + count; ++i) {
    for (const std::uint32_t v : triangles_[i]) {
      for (std::size_t k = 0; k < 3; ++k) {
        node.low[k] = std::min(node.low[k], vertices_[v][k]);
        node.high[k] = std::max(node.high[k], vertices_[v][k]);
      }
    }
  }
  const std::size_t at = nodes_.size();
  nodes_.push_back(node);
  if (count <= leaf) return;
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (node.high[k] - node.low[k] > node.high[axis] - node.low[axis]) axis = k;
  }
  const auto middle = [&](const Triangle& t) {
    return (vertices_[t[0]][axis] + vertices_[t[1]][axis]) + vertices_[t[2]][axis];
  };
  const auto begin = triangles_.begin() + static_cast<std::ptrdiff_t>(first);
  std::stable_sort(begin, begin + static_cast<std::ptrdiff_t>(count),
                   [&](const Triangle& a, const Triangle& b) { return middle(a) < middle(b); });
  nodes_[at].count = 0;
  add_node(first, count / 2);
  nodes_[at].first = static_cast<std::uint32_t>(nodes_.size());
  add_node(first + count / 2, count - count / 2);
}

// Takes the triangle's point nearest to x if it is nearer than `nearest`, by the regions of the triangle's corners, edges and
// face (C. Ericson, Real-Time Collision Detection).
void SignedDistance::look_at(std::uint32_t triangle, const Vec3& x, Nearest& nearest) const {
  const Triangle& t = triangles_[triangle];
  const Vec3 &a = vertices_[t[0]], &b = vertices_[t[1]], &c = vertices_[t[2]];
  const Vec3 ab = difference(b, a), ac = difference(c, a);
  const auto take = [&](const Vec3& point, const Vec3& normal) {
    const Vec3 way = difference(x, point);
    const double square = dot(way, way);
    if (square < nearest.square) nearest = {square, way, normal, triangle};
  };
  const auto along = [](const Vec3& from, const Vec3& way, double part) { return sum(from, scaled(way, part)); };
  const Vec3 ax = difference(x, a);
  const double d1 = dot(ab, ax), d2 = dot(ac, ax);
  if (d1 <= 0 && d2 <= 0) return take(a, vertex_normals_[t[0]]);
  const Vec3 bx = difference(x, b);
  const double d3 = dot(ab, bx), d4 = dot(ac, bx);
  if (d3 >= 0 && d4 <= d3) return take(b, vertex_normals_[t[1]]);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return take(along(a, ab, d1 / (d1 - d3)), edge_normals_[triangle][0]);
  const Vec3 cx = difference(x, c);
  const double d5 = dot(ab, cx), d6 = dot(ac, cx);
  if (d6 >= 0 && d5 <= d6) return take(c, vertex_normals_[t[2]]);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return take(along(a, ac, d2 / (d2 - d6)), edge_normals_[triangle][2]);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return take(along(b, difference(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))), edge_normals_[triangle][1]);
  }
  const double scale = 1 / (va + vb + vc);
  take(along(along(a, ab, vb * scale), ac, vc * scale), face_normals_[triangle]);
}

double SignedDistance::at(const Vec3& x) const {
  std::uint32_t any = 0;
  return at(x, any);
}

double SignedDistance::at(const Vec3& x, std::uint32_t& triangle) const {
  Nearest nearest{std::numeric_limits<double>::infinity(), {}, {}, triangle};
  look_at(triangle, x, nearest);
  std::array<std::uint32_t, 64> open{};
  std::size_t count = 1;
  while (count != 0) {
    const std::uint32_t number = open[--count];
    const Node& node = nodes_[number];
    if (square_to(node.low, node.high, x) >= nearest.square) continue;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) look_at(i, x, nearest);
    if (node.count != 0) continue;
    const std::uint32_t first = number + 1, second = node.first;
    const bool is_first_nearer =
        square_to(nodes_[first].low, nodes_[first].high, x) < square_to(nodes_[second].low, nodes_[second].high, x);
    open[count++] = is_first_nearer ? second : first;
    open[count++] = is_first_nearer ? first : second;
  }
  triangle = nearest.triangle;
  const double distance = std::sqrt(nearest.square);
  return dot(nearest.way, nearest.normal) < 0 ? -distance : distance;
}

namespace {

// Returns an upper bound of the slope between the nodes: along an axis it is at most the greatest difference of two neighbours.
double steepness_of(const DistanceGrid& grid) {
  const auto [nx, ny, nz] = grid.nodes;
  const std::array<std::size_t, 3> strides{1, nx, nx * ny};
  double steepest = 1;
  for (std::size_t k = 0; k + 1 < nz; ++k) {
    for (std::size_t j = 0; j + 1 < ny; ++j) {
      for (std::size_t i = 0; i + 1 < nx; ++i) {
        const double* const first = grid.values.data() + (k * ny + j) * nx + i;
        Vec3 most{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t a = strides[(axis + 1) % 3];
          const std::size_t b = strides[(axis + 2) % 3];
          for (const std::size_t from : {std::size_t{0}, a, b, a + b}) {
            most[axis] = std::max(most[axis], std::abs(first[from + strides[axis]] - first[from]));
          }
        }
        steepest = std::max(steepest, length(most) / grid.cell);
      }
    }
  }
  return steepest * (1 + 1e-4);  // the margin exceeds the values' rounding to float32
}

}  // namespace

DistanceGrid sampled(const TriangleMesh& mesh) {
  const SignedDistance distance(mesh);
  const Extent extent = extent_of(mesh.vertices);
  DistanceGrid grid;
  grid.cell = cell_of(mesh);
  grid.nodes = nodes_of(mesh);
  for (std::size_t k = 0; k < 3; ++k) {
    const double half = extent.sides()[k] / 2;
    grid.center[k] = extent.low[k] + half;
    grid.half_extents[k] = half + mesh.thickness;
    grid.low[k] = -grid.cell * static_cast<double>(grid.nodes[k] - 1) / 2;
  }
  const auto [nx, ny, nz] = grid.nodes;
  grid.values.reserve(nx * ny * nz);
  std::uint32_t nearest = 0;  // the triangle nearest to the node before
  for (std::size_t k = 0; k < nz; ++k) {
    for (std::size_t j = 0; j < ny; ++j) {
      for (std::size_t i = 0; i < nx; ++i) {
        const std::array<std::size_t, 3> at{i, j, k};
        Vec3 x;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          x[axis] = grid.center[axis] + (grid.low[axis] + grid.cell * static_cast<double>(at[axis]));
        }
        grid.values.push_back(distance.at(x, nearest) - mesh.thickness);
      }
    }
  }
  grid.steepness = steepness_of(grid);
  return grid;
}

}  // namespace dvdx
