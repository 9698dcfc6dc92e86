// The number of crossings of cloth by cloth, compared with a separate determinant test of every edge and every triangle.
#include "watch/crossings.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace crossings_test {

using namespace dvdx;
using dvdx::test::Batch;
using dvdx::test::Layout;
using dvdx::tool::cloth_triangles;
using dvdx::tool::Crossings;

std::size_t count_of(const std::vector<Vec3>& x, const std::vector<Triangle>& triangles) {
  Batch<double> batch(Layout::soa, x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) batch.view().x[axis][i] = x[i][axis];
  }
  return Crossings(triangles).count(batch.view());
}

// p + t (q - p) = a + u (b - a) + v (c - a), by Cramer's rule.
bool goes_through(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto by = [](const Vec3& m, const Vec3& n) { return Vec3{n[0] - m[0], n[1] - m[1], n[2] - m[2]}; };
  const auto det = [](const Vec3& m, const Vec3& n, const Vec3& o) {
    return m[0] * (n[1] * o[2] - n[2] * o[1]) - n[0] * (m[1] * o[2] - m[2] * o[1]) + o[0] * (m[1] * n[2] - m[2] * n[1]);
  };
  const Vec3 d = by(q, p), e = by(a, b), f = by(a, c), r = by(a, p);
  const double all = det(d, e, f);
  const double t = det(r, e, f) / all, u = det(d, r, f) / all, v = det(d, e, r) / all;
  return all != 0 && t > 0 && t < 1 && u >= 0 && v >= 0 && u + v <= 1;
}

std::size_t count_of_all(const std::vector<Vec3>& x, const std::vector<Triangle>& triangles) {
  std::size_t count = 0;
  for (const auto& [p, q] : edges(triangles)) {
    for (const auto& [a, b, c] : triangles) {
      const bool shares = p == a || p == b || p == c || q == a || q == b || q == c;
      if (!shares && goes_through(x[p], x[q], x[a], x[b], x[c])) ++count;
    }
  }
  return count;
}

// A grid of 1 m by 1 m with two columns.
Grid flat(std::size_t first, std::size_t rows) {
  return Grid{
      .rows = rows, .columns = 2, .first = first, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 1, .shear = 1};
}

TEST_CASE("an edge goes through a triangle where its ends are on both sides and it passes inside") {
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  const auto with = [&](const Vec3& p, const Vec3& q) {
    std::vector<Vec3> x = corners;
    x.insert(x.end(), {p, q, {5, 5, 5}});
    return count_of(x, {{0, 1, 2}, {3, 4, 5}});
  };
  // Two edges cross when two triangles intersect.
  CHECK(with({0.2, -1, 0.2}, {0.2, 1, 0.2}) == 2);
  CHECK(with({0.2, 1, 0.2}, {0.2, -1, 0.2}) == 2);
  CHECK(with({0.5, -1, 0.5}, {0.5, 1, 0.5}) == 2);           // through the border
  CHECK(with({0.2, -1e5, -1e5}, {0.2, 1e5, 1e5 + 1}) == 2);  // a long one
  CHECK(with({0.2, 1e-9, 0.2}, {0.2, 1, 0.2}) == 0);         // above
  CHECK(with({0.2, 0, 0.2}, {0.2, 1, 0.2}) == 0);            // touches
  CHECK(with({0.8, -1, 0.8}, {0.8, 1, 0.8}) == 0);           // beside
  CHECK(with({0.2, 0, 0.2}, {0.3, 0, 0.3}) == 0);            // in its plane
  CHECK(with({std::numeric_limits<double>::quiet_NaN(), -1, 0.2}, {0.2, 1, 0.2}) == 0);
  CHECK(with({0.2, -std::numeric_limits<double>::infinity(), 0.2}, {0.2, 1, 0.2}) == 0);
}

TEST_CASE("triangles with a common corner do not count") {
  // The second triangle crosses the first, but from its corner.
  CHECK(count_of({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 1, 1}, {1, -1, 1}}, {{0, 1, 2}, {0, 3, 4}}) == 1);
  CHECK(count_of({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 1, 1}, {1, -1, 1}, {0, 0.1, 0}}, {{0, 1, 2}, {5, 3, 4}}) == 2);
}

TEST_CASE("a cell's side counts, its diagonal does not") {
  Batch<double> batch(Layout::soa, 4);
  const std::array<double, 4> x{0, 3, 0, 0}, y{0, 0, 4, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    batch.view().x[0][i] = x[i];
    batch.view().x[1][i] = y[i];
    batch.view().x[2][i] = 0;
  }
  Crossings crossings({{0, 1, 2}, {0, 1, 3}});
  CHECK(crossings.longest_side() == 0);
  CHECK(crossings.count(batch.view()) == 0);
  CHECK(crossings.longest_side() == 4);
  batch.view().x[1][2] = std::numeric_limits<double>::quiet_NaN();
  CHECK(crossings.count(batch.view()) == 0);
  CHECK(crossings.longest_side() == 3);
}

// Two triangles share a side but not its ends: one side lies slightly beside the other.
TEST_CASE("cloth that is sewn does not cross itself at the seam") {
  Batch<double> batch(Layout::soa, 6);
  const std::array<Vec3, 6> at{{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0.3}, {0, 0.01, 0.01}, {1, 0, -0.01}, {0.5, 0.3, 1}}};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) batch.view().x[axis][i] = at[i][axis];
  }
  const std::vector<Triangle> triangles{{0, 1, 2}, {3, 4, 5}};
  CHECK(Crossings(triangles).count(batch.view()) > 0);
  const std::vector<dvdx::Pair> seam{{3, 0}, {4, 1}};
  CHECK(Crossings(triangles, seam).count(batch.view()) == 0);
  const std::vector<dvdx::Pair> around{{5, 4}, {3, 5}};  // none of them belongs to the other triangle
  CHECK(Crossings(triangles, around).count(batch.view()) > 0);
}

TEST_CASE("sides of cells are measured relative to their lengths at given positions") {
  Batch<double> batch(Layout::soa, 4);
  const std::array<double, 4> x{0, 3, 0, 0}, y{0, 0, 4, 3};
  for (std::size_t i = 0; i < 4; ++i) {
    batch.view().x[0][i] = x[i];
    batch.view().x[1][i] = y[i];
    batch.view().x[2][i] = 0;
  }
  Crossings crossings({{0, 1, 2}, {0, 1, 3}});
  const std::array<Vec3, 4> at_start{{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}, {0, 2, 0}}};
  crossings.measure_by([&](std::uint32_t i) { return at_start[i]; });
  CHECK(crossings.count(batch.view()) == 0);
  CHECK(crossings.longest_side() == 1.5);  // the second sheet's, although the first one's is longer
}

TEST_CASE("the tree finds every crossing of random triangles, small ones among long ones") {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  for (std::uint32_t t = 0; t < 300; ++t) {
    const double size = t % 10 == 0 ? 2 : 0.3;
    const Vec3 middle{test::uniform(0, t), test::uniform(1, t), test::uniform(2, t)};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t axis) { return middle[axis] + size * (test::uniform(3 + 3 * k + axis, t) - 0.5); };
      x.push_back({at(0), at(1), at(2)});
    }
    triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const std::size_t expected = count_of_all(x, triangles);
  CHECK(expected > 500);
  CHECK(count_of(x, triangles) == expected);
}

TEST_CASE("the cloth of a scene is its grids and meshes, without nets and ropes") {
  Scene scene;
  scene.add(Network{flat(0, 3)});
  Grid net = flat(6, 3);
  net.shear = 0;
  scene.add(Network{net});
  scene.add(Network{Springs{.pairs = {{12, 13}, {13, 14}, {14, 12}}, .stiffness = 1.0, .triangles = {{12, 13, 14}}}});
  scene.add(Network{Springs{.pairs = {{15, 16}}, .stiffness = 1.0}});
  const std::vector<Triangle> expected{{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}, {12, 13, 14}};
  CHECK(cloth_triangles(scene) == expected);
  CHECK(count_of({}, {}) == 0);
}

}  // namespace crossings_test
