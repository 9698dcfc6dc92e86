// Normals and bounds, compared with closed forms and with sums over triangles, in every layout.
#include "dvdx/drawing.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"

namespace drawing_test {

using namespace dvdx;
using test::Batch;
using test::Layout;

std::vector<Triangle> faces_of(const Grid& grid) {
  std::vector<Triangle> all;
  for (std::size_t r = 0; r + 1 < grid.rows; ++r) {
    for (std::size_t c = 0; c + 1 < grid.columns; ++c) {
      const auto at = [&](std::size_t down, std::size_t right) {
        return static_cast<std::uint32_t>(grid.first + (r + down) * grid.columns + c + right);
      };
      all.push_back({at(0, 0), at(0, 1), at(1, 1)});
      all.push_back({at(0, 0), at(1, 1), at(1, 0)});
    }
  }
  return all;
}

// The sums in double, triangle by triangle.
template <class T>
std::vector<Vec3> summed(const std::vector<Triangle>& triangles, const State<T>& state) {
  std::vector<Vec3> n(state.count);
  const auto place = [&](std::size_t i) { return Vec3{double(state.x[0][i]), double(state.x[1][i]), double(state.x[2][i])}; };
  for (const auto& [a, b, c] : triangles) {
    const Vec3 p = place(a), q = place(b), r = place(c);
    const Vec3 u{q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
    for (const std::uint32_t i : {a, b, c}) {
      for (std::size_t k = 0; k < 3; ++k) n[i][k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
  }
  for (Vec3& each : n) {
    const double length = std::sqrt(each[0] * each[0] + each[1] * each[1] + each[2] * each[2]);
    for (double& x : each) x = length > 0 ? x / length : 0;
  }
  return n;
}

// A crumpled sheet that does not start at particle 0.
Grid crumpled(std::size_t rows, std::size_t columns) {
  return {.rows = rows, .columns = columns, .first = 5, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}};
}
template <class T>
void place(const Grid& grid, State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) state.x[k][i] = static_cast<T>(0.3 * test::scatter(i, k));
    if (i < grid.first) continue;
    state.x[0][i] += static_cast<T>((i - grid.first) % grid.columns);
    state.x[2][i] += static_cast<T>((i - grid.first) / grid.columns);
  }
}

TEST_CASE_TEMPLATE("normals of a grid are its triangles' sums, with the same bits in every layout", T, float, double) {
  const double bound = 32 * static_cast<double>(std::numeric_limits<T>::epsilon());
  for (const auto& [rows, columns] : {std::pair{2, 2}, {2, 3}, {5, 7}, {3, 255}, {3, 256}, {4, 257}, {3, 258}, {3, 600}}) {
    const Grid grid = crumpled(static_cast<std::size_t>(rows), static_cast<std::size_t>(columns));
    const std::size_t count = grid.rows * grid.columns;
    std::vector<T> expected;
    for (const Layout layout : test::layouts) {
      CAPTURE(grid.columns);
      CAPTURE(test::name(layout));
      Batch<T> batch(layout, grid.first + count), out(layout, count);
      place(grid, batch.view());
      normals(grid, batch.view(), out.view().x);
      CHECK(batch.is_clean());
      CHECK(out.is_clean());
      const auto sums = summed(faces_of(grid), batch.view());
      double worst = 0;
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          worst = std::max(worst, std::abs(static_cast<double>(out.view().x[k][i]) - sums[grid.first + i][k]));
        }
      }
      CHECK(worst <= bound);
      const auto values = test::values_of(out.view());
      if (expected.empty()) expected = values;
      std::size_t differing = 0;
      for (std::size_t n = 0; n < values.size(); ++n) differing += n % 6 < 3 && values[n] != expected[n] ? 1U : 0U;
      CHECK(differing == 0);
    }
  }
}

TEST_CASE_TEMPLATE("normals of triangles are their sums, and zero where there are none", T, float, double) {
  const Grid grid = crumpled(6, 9);
  for (const Layout layout : {Layout::soa, Layout::aos, Layout::aosoa8}) {
    Batch<T> batch(layout, grid.first + 54), out(layout, grid.first + 54);
    place(grid, batch.view());
    const auto triangles = faces_of(grid);
    normals(triangles, batch.view(), out.view().x);
    const auto sums = summed(triangles, batch.view());
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(std::abs(static_cast<double>(out.view().x[k][i]) - sums[i][k]) <= 32 * double(std::numeric_limits<T>::epsilon()));
        if (i < grid.first) CHECK(out.view().x[k][i] == 0);
      }
    }
  }
}

TEST_CASE_TEMPLATE("normals of an octahedron point away from its center, at any size", T, float, double) {
  const std::array<Vec3, 6> corners{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
  const std::vector<Triangle> faces{{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
  for (const double size : {1.0, 1e-15, 1e15}) {
    Batch<T> batch(Layout::soa, 6), out(Layout::soa, 6);
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < 3; ++k) batch.view().x[k][i] = static_cast<T>(size * corners[i][k]);
    }
    normals(faces, batch.view(), out.view().x);
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < 3; ++k) CHECK(out.view().x[k][i] == static_cast<T>(corners[i][k]));
    }
  }
}

TEST_CASE_TEMPLATE("a normal without a direction is zero", T, float, double) {
  const Grid grid{.rows = 4, .columns = 5};
  Batch<T> batch(Layout::soa, 20), out(Layout::soa, 20);
  const auto is_zero = [&](std::size_t i) {
    return out.view().x[0][i] == 0 && out.view().x[1][i] == 0 && out.view().x[2][i] == 0;
  };
  for (std::size_t i = 0; i < 20; ++i) {
    for (std::size_t k = 0; k < 3; ++k) batch.view().x[k][i] = 7;
  }
  normals(grid, batch.view(), out.view().x);
  for (std::size_t i = 0; i < 20; ++i) CHECK(is_zero(i));
  // A NaN spoils its neighbours' normals only.
  for (std::size_t i = 0; i < 20; ++i) {
    batch.view().x[0][i] = static_cast<T>(i % 5);
    batch.view().x[2][i] = static_cast<T>(i / 5);
  }
  batch.view().x[1][12] = std::numeric_limits<T>::quiet_NaN();
  normals(grid, batch.view(), out.view().x);
  for (std::size_t i = 0; i < 20; ++i) {
    const bool is_near = i == 12 || i == 11 || i == 13 || i == 7 || i == 17 || i == 6 || i == 18;
    CHECK(is_zero(i) == is_near);
    if (!is_near) CHECK(out.view().x[1][i] == -1);
  }
}

TEST_CASE_TEMPLATE("bounds hold every particle whose place is finite", T, float, double) {
  constexpr T infinity = std::numeric_limits<T>::infinity();
  for (const Layout layout : test::layouts) {
    Batch<T> batch(layout, 600);
    State<T>& state = batch.view();
    for (std::size_t i = 0; i < 600; ++i) {
      for (std::size_t k = 0; k < 3; ++k) state.x[k][i] = static_cast<T>(test::scatter(i, k));
    }
    state.x[0][17] = -8;
    state.x[1][300] = 9;
    state.x[2][599] = 10;
    state.x[1][40] = infinity;
    state.x[0][40] = 99;
    state.x[2][41] = std::numeric_limits<T>::quiet_NaN();
    state.x[0][41] = -99;
    const Bounds box = bounds(state);
    CHECK(box.particles == 598);
    CHECK(box.least[0] == -8);
    CHECK(box.most[1] == 9);
    CHECK(box.most[2] == 10);
    CHECK(box.most[0] <= 1);
    CHECK(box.least[1] >= -1);
    CHECK(batch.is_clean());
    state.count = 0;
    CHECK(bounds(state).particles == 0);
    CHECK(bounds(state).least[0] == static_cast<double>(infinity));
    CHECK(bounds(state).most[2] == -static_cast<double>(infinity));
  }
}

}  // namespace drawing_test
