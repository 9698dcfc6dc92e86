// Normals and bounds: one code path for every instruction set, in loops that compilers vectorise.
#include "dvdx/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dvdx/layouts/convert.hpp"
#include "work/environment.hpp"

namespace dvdx {
namespace {

constexpr std::size_t most_columns = 256;  // columns of a grid, or particles, handled together

template <class T>
using Three = std::array<T, 3>;

// Numbers first, first + 1, ... of three columns, contiguous: in place or as a copy, with room for one before and one behind.
template <class T>
class Row {
 public:
  void take(const std::array<Column<T>, 3>& columns, std::size_t first, std::size_t count) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Column<T>& column = columns[axis];
      at_[axis] = column.is_contiguous() ? column.base + first : copy_[axis].data();
      if (!column.is_contiguous()) gather(column, first, count, copy_[axis].data());
    }
  }
  [[nodiscard]] const T* operator[](std::size_t axis) const noexcept { return at_[axis]; }

 private:
  std::array<const T*, 3> at_{};
  std::array<std::array<T, most_columns + 2>, 3> copy_;  // left uninitialised
};

template <class T>
T product(const Three<T>& a, const Three<T>& b) noexcept {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
template <class T>
Three<T> cross(const Three<T>& a, const Three<T>& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
Three<T> sum(const Three<T>& a, const Three<T>& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

// The largest component is taken out first, so that no square over- or underflows.
template <class T>
Three<T> unit(const Three<T>& n) noexcept {
  const T x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
  const T xy = x < y ? y : x;
  const T largest = xy < z ? z : xy;
  // A sum below the smallest normal number, infinite or not a number has no direction.
  const bool has_direction = (x + y) + z >= std::numeric_limits<T>::min() && largest <= std::numeric_limits<T>::max();
  const T scale = has_direction ? largest : T(1);
  const Three<T> w{n[0] / scale, n[1] / scale, n[2] / scale};
  const T length = std::sqrt(product(w, w));
  // Selected and not branched to, so that loops over it are vectorised.
  const T by = T(1) / (has_direction ? length : T(1));
  const Three<T> u{by * w[0], by * w[1], by * w[2]};
  return {has_direction ? u[0] : T(0), has_direction ? u[1] : T(0), has_direction ? u[2] : T(0)};
}

// The neighbours of a grid's particles to the right, below and so on. The particle itself stands in for a missing neighbour,
// and the triangles with that have no area.
template <class T>
struct Around {
  std::array<const T*, 3> here, right, right_below, below, left, left_above, above;

  [[nodiscard]] Three<T> normal(std::size_t c) const noexcept {
    const auto edge = [&](const std::array<const T*, 3>& to) {
      return Three<T>{to[0][c] - here[0][c], to[1][c] - here[1][c], to[2][c] - here[2][c]};
    };
    const Three<T> a = edge(right), b = edge(right_below), d = edge(below), e = edge(left), f = edge(left_above),
                   k = edge(above);
    return unit(sum(sum(sum(cross(a, b), cross(b, d)), sum(cross(d, e), cross(e, f))), sum(cross(f, k), cross(k, a))));
  }
};

// __restrict tells the compiler that the normals overlap nothing that is read. Otherwise it takes them one by one.
template <class T>
void fill(const Around<T>& around, std::size_t first, std::size_t end, const std::array<T*, 3>& to) noexcept {
  T* __restrict const x = to[0];
  T* __restrict const y = to[1];
  T* __restrict const z = to[2];
  const Around<T> at = around;
  for (std::size_t c = first; c < end; ++c) {
    const Three<T> n = at.normal(c);
    x[c] = n[0];
    y[c] = n[1];
    z[c] = n[2];
  }
}

template <class T>
std::array<const T*, 3> moved(const std::array<const T*, 3>& at, std::ptrdiff_t by) noexcept {
  return {at[0] + by, at[1] + by, at[2] + by};
}

// `width` columns of a grid's row from column `from` on, and their neighbours.
template <class T>
class GridRow {
 public:
  GridRow(const Grid& grid, const std::array<Column<T>, 3>& x, std::size_t row, std::size_t from, std::size_t width) noexcept
      : grid_(grid), from_(from), width_(width) {
    const std::size_t first = from == 0 ? 0 : from - 1;
    const std::size_t end = std::min(grid.columns, from + width + 1);
    const auto take = [&](Row<T>& to, std::size_t of) {
      to.take(x, grid.first + of * grid.columns + first, end - first);
      return std::array<const T*, 3>{to[0] + (from - first), to[1] + (from - first), to[2] + (from - first)};
    };
    around_.here = take(here_, row);
    around_.above = row == 0 ? around_.here : take(above_, row - 1);
    around_.below = row + 1 == grid.rows ? around_.here : take(below_, row + 1);
    around_.left = moved(around_.here, -1);
    around_.right = moved(around_.here, 1);
    around_.left_above = row == 0 ? around_.here : moved(around_.above, -1);
    around_.right_below = row + 1 == grid.rows ? around_.here : moved(around_.below, 1);
  }
  GridRow(const GridRow&) = delete;
  GridRow& operator=(const GridRow&) = delete;

  void write(std::array<T*, 3> to) const noexcept {
    std::size_t first = 0;
    std::size_t end = width_;
    if (from_ == 0) {
      Around<T> here = around_;
      here.left = here.left_above = around_.here;
      fill(here, first, first + 1, to);
      ++first;
    }
    if (from_ + width_ == grid_.columns) {
      Around<T> here = around_;
      here.right = here.right_below = around_.here;
      --end;
      fill(here, end, end + 1, to);
    }
    fill(around_, first, end, to);
  }

 private:
  const Grid& grid_;
  std::size_t from_, width_;
  Row<T> here_, above_, below_;
  Around<T> around_{};
};

// The least and the most of all numbers added, lane by lane. With so many lanes compilers make loops over registers, and
// unroll none of them into single numbers. +0 and -0 count as equal.
template <class T>
class Extent {
 public:
  Extent() noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least_[axis].fill(std::numeric_limits<T>::infinity());
      most_[axis].fill(-std::numeric_limits<T>::infinity());
    }
  }

  void add(const Row<T>& row, std::size_t count) noexcept {
    if (is_finite(row, count)) {
      for (std::size_t axis = 0; axis < 3; ++axis) add(axis, row[axis], count);
      particles_ += count;
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Three<T> x{row[0][i], row[1][i], row[2][i]};
      if (!(zero_or_nan(x[0], x[1], x[2]) == 0)) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) add(axis, &x[axis], 1);
      ++particles_;
    }
  }

  [[nodiscard]] Bounds bounds() const noexcept {
    Bounds bounds{.particles = particles_};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.least[axis] = static_cast<double>(*std::min_element(least_[axis].begin(), least_[axis].end()) + T(0));
      bounds.most[axis] = static_cast<double>(*std::max_element(most_[axis].begin(), most_[axis].end()) + T(0));
    }
    return bounds;
  }

 private:
  static constexpr std::size_t lanes = 64;
  using Lanes = std::array<T, lanes>;

  // 0 if all are finite, otherwise NaN.
  static T zero_or_nan(T x, T y, T z) noexcept { return (T(0) * x + T(0) * y) + T(0) * z; }

  static bool is_finite(const Row<T>& row, std::size_t count) noexcept {
    Lanes sum{};
    for (std::size_t first = 0; first < count; first += lanes) {
      const std::size_t now = std::min(lanes, count - first);
      const T *const x = row[0] + first, *const y = row[1] + first, *const z = row[2] + first;
      for (std::size_t k = 0; k < now; ++k) sum[k] += zero_or_nan(x[k], y[k], z[k]);
    }
    return std::all_of(sum.begin(), sum.end(), [](T lane) { return lane == 0; });
  }
  void add(std::size_t axis, const T* x, std::size_t count) noexcept {
    T* __restrict const least = least_[axis].data();
    T* __restrict const most = most_[axis].data();
    for (std::size_t first = 0; first < count; first += lanes) {
      const std::size_t now = std::min(lanes, count - first);
      for (std::size_t k = 0; k < now; ++k) {
        least[k] = x[first + k] < least[k] ? x[first + k] : least[k];
        most[k] = x[first + k] > most[k] ? x[first + k] : most[k];
      }
    }
  }

  std::array<Lanes, 3> least_, most_;
  std::size_t particles_ = 0;
};

template <class T>
void put(const Three<T>& n, const std::array<Column<T>, 3>& to, std::size_t i) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) to[axis][i] = n[axis];
}

}  // namespace

template <class T>
void normals(const Grid& grid, const State<T>& state, const std::array<Column<T>, 3>& to) noexcept {
  const StepEnvironment environment;
  std::array<std::array<T, most_columns>, 3> made;  // left uninitialised
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t from = 0; from < grid.columns; from += most_columns) {
      const std::size_t width = std::min(most_columns, grid.columns - from);
      GridRow<T>(grid, state.x, row, from, width).write({made[0].data(), made[1].data(), made[2].data()});
      for (std::size_t axis = 0; axis < 3; ++axis) scatter(made[axis].data(), row * grid.columns + from, width, to[axis]);
    }
  }
}

template <class T>
void normals(std::span<const Triangle> triangles, const State<T>& state, const std::array<Column<T>, 3>& to) noexcept {
  const StepEnvironment environment;
  for (std::size_t i = 0; i < state.count; ++i) put<T>({}, to, i);
  const auto place = [&](std::size_t i) { return Three<T>{state.x[0][i], state.x[1][i], state.x[2][i]}; };
  for (const Triangle& triangle : triangles) {
    const Three<T> p = place(triangle[0]), q = place(triangle[1]), r = place(triangle[2]);
    const Three<T> n = cross(Three<T>{q[0] - p[0], q[1] - p[1], q[2] - p[2]}, Three<T>{r[0] - p[0], r[1] - p[1], r[2] - p[2]});
    for (const std::uint32_t corner : triangle) {
      for (std::size_t axis = 0; axis < 3; ++axis) to[axis][corner] = to[axis][corner] + n[axis];
    }
  }
  for (std::size_t i = 0; i < state.count; ++i) put(unit<T>({to[0][i], to[1][i], to[2][i]}), to, i);
}

template <class T>
Bounds bounds(const State<T>& state) noexcept {
  const StepEnvironment environment;
  Extent<T> extent;
  Row<T> row;
  for (std::size_t first = 0; first < state.count; first += most_columns) {
    const std::size_t count = std::min(most_columns, state.count - first);
    row.take(state.x, first, count);
    extent.add(row, count);
  }
  return extent.bounds();
}

template void normals(const Grid&, const State<float>&, const std::array<Column<float>, 3>&) noexcept;
template void normals(const Grid&, const State<double>&, const std::array<Column<double>, 3>&) noexcept;
template void normals(std::span<const Triangle>, const State<float>&, const std::array<Column<float>, 3>&) noexcept;
template void normals(std::span<const Triangle>, const State<double>&, const std::array<Column<double>, 3>&) noexcept;
template Bounds bounds(const State<float>&) noexcept;
template Bounds bounds(const State<double>&) noexcept;

}  // namespace dvdx
