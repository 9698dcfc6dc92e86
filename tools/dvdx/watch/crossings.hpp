// Counts how often cloth goes through cloth: edges of its triangles through other triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/cloth.hpp"
#include "dvdx/drawing.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::tool {

// Returns the triangles of grids (cells cut from (row, column) to (row + 1, column + 1)) and of meshes; none of nets.
[[nodiscard]] std::vector<Triangle> cloth_triangles(const Scene& scene);
// Returns the particles joined by springs of rest length 0: the ends of seams.
[[nodiscard]] std::vector<Pair> sewn_pairs(const Scene& scene);

// A tree of boxes around the triangles, in which an edge of any length finds all triangles that it may go through.
class Crossings {
 public:
  // sewn: pairs of particles that count as one corner.
  explicit Crossings(std::vector<Triangle> triangles, std::span<const Pair> sewn = {});

  // Counts pairs of an edge and a triangle without a common corner: the edge's ends are on different sides of the triangle, and
  // the line between them passes inside it or through its border. Computed in double: an edge nearer to a corner, an edge or
  // the plane than some 1e-15 of the coordinates may count either way. Triangles and edges that are not finite are left out.
  template <class T>
  [[nodiscard]] std::size_t count(const State<T>& state);
  // From now on measures each triangle's side relative to its side at the positions place(particle).
  template <class Place>
  void measure_by(const Place& place) {
    units_.clear();
    for (const Triangle& of : triangles_) units_.push_back(side_of({place(of[0]), place(of[1]), place(of[2])}));
  }
  // Returns the longest side of the triangles counted last, m or as measure_by() measures. A triangle counts by its second
  // longest side, so that a cell's diagonal does not count beside its sides.
  [[nodiscard]] double longest_side() const noexcept { return longest_side_; }

 private:
  struct Box {
    Vec3 least{}, most{};
    void add(const Box& other) noexcept;
    [[nodiscard]] bool meets(const Box& other) const noexcept;
  };
  struct Node {
    Box box{};
    std::size_t from = 0, to = 0;  // of order_
    std::size_t second = 0;        // the node of the second half; the first half's is the next one; 0: a leaf
  };

  [[nodiscard]] std::size_t count();
  [[nodiscard]] static double side_of(const std::array<Vec3, 3>& corners) noexcept;
  void build();
  std::size_t build(std::size_t from, std::size_t to);
  [[nodiscard]] Box box_of(std::span<const std::uint32_t> corners) const noexcept;
  [[nodiscard]] std::size_t through(const Pair& edge);

  [[nodiscard]] std::uint32_t corner_of(std::uint32_t i) const noexcept { return corner_.empty() ? i : corner_[i]; }

  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> corner_;  // of each particle, the lowest one that is sewn to it; empty: nothing is sewn
  std::vector<Pair> edges_;
  std::vector<double> units_;  // of each triangle's side; empty: 1 m
  std::vector<Vec3> x_;
  std::vector<Box> boxes_;            // of triangles
  std::vector<std::uint32_t> order_;  // of triangles, as the tree has them
  std::vector<Node> nodes_;
  double longest_side_ = 0;
  std::vector<std::size_t> open_;  // nodes that an edge has still to look at
};

extern template std::size_t Crossings::count(const State<float>&);
extern template std::size_t Crossings::count(const State<double>&);

}  // namespace dvdx::tool
