#include "scene_io/mesh_welding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <span>

namespace dvdx::tool {
namespace {

using Face = std::vector<std::uint32_t>;

double distance(const Vec3& a, const Vec3& b) { return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]); }

// Sets that are joined two by two, each named by its lowest member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t members) : up_(members) { std::iota(up_.begin(), up_.end(), 0U); }
  std::uint32_t of(std::uint32_t member) {
    while (up_[member] != member) member = up_[member] = up_[up_[member]];
    return member;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    const auto [low, high] = std::minmax({of(a), of(b)});
    up_[high] = low;
  }

 private:
  std::vector<std::uint32_t> up_;
};

// Returns m: positions that differ by less may differ by the rounding of their coordinates alone.
double rounding_of(std::span<const Vec3> places) {
  double largest = 0;
  for (const Vec3& place : places) largest = std::max({largest, std::abs(place[0]), std::abs(place[1]), std::abs(place[2])});
  return 4 * std::numeric_limits<double>::epsilon() * largest;
}

// Calls close(a, b, distance) once for any two of `some` that are at most `reach` > 0 apart.
template <class Close>
void for_each_close_pair(std::span<const Vec3> places, std::span<const std::uint32_t> some, double reach, const Close& close) {
  using Cell = std::array<double, 3>;
  struct Member {
    Cell cell;
    std::uint32_t vertex;
  };
  std::vector<Member> members;
  members.reserve(some.size());
  for (const auto i : some) {
    Cell cell;
    for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] = std::floor(places[i][axis] / reach);
    members.push_back({cell, i});
  }
  std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.cell < b.cell; });
  const auto look_at = [&](const Member& member, const Cell& first, const Cell& last) {
    auto other = std::lower_bound(members.begin(), members.end(), first,
                                  [](const Member& of, const Cell& cell) { return of.cell < cell; });
    for (; other != members.end() && other->cell <= last; ++other) {
      if (other->vertex <= member.vertex) continue;
      const double apart = distance(places[member.vertex], places[other->vertex]);
      if (apart <= reach) close(member.vertex, other->vertex, apart);
    }
  };
  for (const Member& member : members) {
    const auto& [x, y, z] = member.cell;
    for (const double dx : {-1.0, 0.0, 1.0}) {
      for (const double dy : {-1.0, 0.0, 1.0}) look_at(member, {x + dx, y + dy, z - 1}, {x + dx, y + dy, z + 1});
    }
  }
}

std::vector<std::uint32_t> all_of(std::size_t count) {
  std::vector<std::uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

// Returns for each vertex the first of those that stand together with it.
std::vector<std::uint32_t> firsts(std::span<const Vec3> places, std::optional<double> weld) {
  auto order = all_of(places.size());
  if (!weld) return order;
  DisjointSets together(places.size());
  if (*weld > 0) {
    for_each_close_pair(places, order, *weld + rounding_of(places),
                        [&](std::uint32_t a, std::uint32_t b, double) { together.join(a, b); });
  } else {
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return places[a] < places[b]; });
    for (std::size_t k = 1; k < order.size(); ++k) {
      if (places[order[k - 1]] == places[order[k]]) together.join(order[k - 1], order[k]);
    }
  }
  for (std::uint32_t i = 0; i < places.size(); ++i) order[i] = together.of(i);
  return order;
}

// Returns whether a face or a line uses each particle, by the particle's first vertex.
std::vector<bool> used_in(const MeshFile& file, std::span<const std::uint32_t> first) {
  std::vector<bool> is_used(first.size(), false);
  for (const auto& face : file.faces) {
    for (const auto vertex : face) is_used[first[vertex]] = true;
  }
  for (const auto& line : file.lines) {
    for (const auto vertex : line) is_used[first[vertex]] = true;
  }
  return is_used;
}

// Collects the faces and lines that are left when their corners have become particles.
class Reduced {
 public:
  explicit Reduced(MeshFile& mesh) : mesh_(mesh) {}

  // Cuts the face in two where it passes a particle twice.
  void add(Face face) {  // NOLINT(misc-no-recursion): each part is shorter
    for (std::size_t k = 1; k < face.size(); ++k) {
      const auto at = face.begin() + static_cast<std::ptrdiff_t>(k);
      const auto before = std::find(face.begin(), at, *at);
      if (before == at) continue;
      add(Face(before, at));
      face.erase(before, at);
      return add(std::move(face));
    }
    if (face.size() == 2) return add(Pair{face[0], face[1]});
    if (face.size() < 2) return;
    Face corners = face;
    std::sort(corners.begin(), corners.end());
    if (faces_.insert(std::move(corners)).second) mesh_.faces.push_back(std::move(face));
  }
  void add(const Pair& line) {
    if (line[0] != line[1]) mesh_.lines.push_back(line);
  }

 private:
  MeshFile& mesh_;
  std::set<Face> faces_;
};

MeshFile reduced(const MeshFile& file, const Numbering& numbering) {
  MeshFile mesh;
  for (const auto vertex : numbering.numbers) mesh.vertices.push_back(file.vertices[vertex]);
  const auto particle = [&](std::uint32_t vertex) { return numbering.particles[vertex]; };
  Reduced left(mesh);
  for (const auto& [a, b] : file.lines) left.add(Pair{particle(a), particle(b)});
  for (const auto& face : file.faces) {
    Face corners(face.size());
    std::transform(face.begin(), face.end(), corners.begin(), particle);
    left.add(std::move(corners));
  }
  return mesh;
}

// Counts the pieces, and the particles where two pieces nearly meet.
void look_at_pieces(const MeshFile& mesh, MeshFacts& facts) {
  constexpr double near = 1e-3;  // of a side: seams that exporters write are far closer, and layers of cloth are farther apart
  const auto edges = edges_of(mesh);
  DisjointSets pieces(mesh.vertices.size());
  std::vector<bool> is_joined(mesh.vertices.size(), false);
  double sides = 0;
  for (const auto& [a, b] : edges) {
    pieces.join(a, b);
    is_joined[a] = is_joined[b] = true;
    sides += distance(mesh.vertices[a], mesh.vertices[b]);
  }
  std::vector<std::uint32_t> joined;
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!is_joined[i]) continue;
    joined.push_back(i);
    if (pieces.of(i) == i) ++facts.pieces;
  }
  const double reach = std::max(near * sides / static_cast<double>(edges.size()), rounding_of(mesh.vertices));
  if (facts.pieces < 2 || !(reach > 0)) return;
  std::vector<bool> is_near(mesh.vertices.size(), false);
  for_each_close_pair(mesh.vertices, joined, reach, [&](std::uint32_t a, std::uint32_t b, double apart) {
    if (pieces.of(a) == pieces.of(b)) return;
    is_near[a] = is_near[b] = true;
    facts.apart = std::max(facts.apart, apart);
  });
  facts.near = static_cast<std::size_t>(std::count(is_near.begin(), is_near.end(), true));
}

}  // namespace

WeldedMesh welded(const MeshFile& file, std::optional<double> weld, Unreferenced unreferenced) {
  const std::size_t vertices = file.vertices.size();
  const auto first = firsts(file.vertices, weld);
  const auto is_used = used_in(file, first);
  const bool has_joints = !file.faces.empty() || !file.lines.empty();
  const bool are_kept = unreferenced == Unreferenced::kept || !has_joints;
  WeldedMesh made{
      .mesh = {}, .numbering = {.particles = std::vector<std::uint32_t>(vertices)}, .facts = {.vertices = vertices}};
  auto& [particles, numbers, still] = made.numbering;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    if (!is_used[first[i]]) ++made.facts.unreferenced;
    if (!is_used[first[i]] && !are_kept) {
      particles[i] = Numbering::nobody;
      still.push_back(file.vertices[i]);
    } else if (first[i] != i) {
      particles[i] = particles[first[i]];
    } else {
      particles[i] = static_cast<std::uint32_t>(numbers.size());
      numbers.push_back(i);
    }
  }
  made.mesh = numbers.size() == vertices ? file : reduced(file, made.numbering);
  made.facts.particles = numbers.size();
  made.facts.left_out = still.size();
  const auto is_polygon = [](const Face& face) { return face.size() > 4; };
  made.facts.polygons = static_cast<std::size_t>(std::count_if(file.faces.begin(), file.faces.end(), is_polygon));
  look_at_pieces(made.mesh, made.facts);
  return made;
}

}  // namespace dvdx::tool
