// Air on triangles, scalar: each particle sums the triangles around it.
#pragma once

#include "passes/air/air.hpp"
#include "passes/network/pull_reference.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
Vector<T> cross(const Vector<T>& d, const Vector<T>& f) noexcept {
  return {subtract_product<arithmetic>(d[1] * f[2], d[2], f[1]), subtract_product<arithmetic>(d[2] * f[0], d[0], f[2]),
          subtract_product<arithmetic>(d[0] * f[1], d[1], f[0])};
}

template <Arithmetic arithmetic, class T>
Vector<T> air_push(const AirPulse<T>& pulse, const Vector<T>& d, const Vector<T>& f, const Vector<T>& sum, T W) noexcept {
  if (!(W >= T(0))) return {};
  const T third = T(1) / T(3);
  const T D = pulse.drag, L = pulse.lift;
  const Vector<T> s = cross<arithmetic>(d, f);
  Vector<T> u{};
  for (std::size_t axis = 0; axis < 3; ++axis) u[axis] = subtract_product<arithmetic>(pulse.wind[axis], third, sum[axis]);
  const T U2 = inner<arithmetic>(u, u);
  const T P = inner<arithmetic>(s, s) * U2;
  if (!(P > least_square<T> && P < most_square<T>)) return {};
  const T sigma = inner<arithmetic>(s, u);
  const T r = inverse_root<arithmetic>(P);
  const T NU = P * r;
  const T c = std::abs(sigma) * r;
  const T rest = subtract_product<arithmetic>(T(1), c, c);
  const T z = rest < T(0) ? T(0) : rest;
  const T eta = (pulse.rate * W) * NU;
  if (!(eta < most_air<T>)) return {};
  const T x = L * eta;
  const T y = (D * c) * eta;
  const T xz = x * z;
  const T a = T(1) + xz;
  const T b = a + (y + y);
  const T below = multiply_add<arithmetic>(x * x, multiply_add<arithmetic>(T(1.5), z, T(0.5)), (a + xz) + y);
  const T l = ((L * c) * (T(1) + x)) / below;
  const T lambda = eta * l;
  const T m = multiply_add<arithmetic>(lambda * lambda, z, T(1));
  const T al = a * l;
  const T all = (pulse.push * NU) / (b * m);
  const T along_u = all * multiply_add<arithmetic>(al, lambda * z - c, (D * c) * m);
  const T along_n = (all * al) * (r * U2);
  const T along_s = sigma < T(0) ? -along_n : along_n;
  Vector<T> p{};
  for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = multiply_add<arithmetic>(along_u, u[axis], along_s * s[axis]);
  return p;
}

template <class T, Arithmetic arithmetic>
void add_air(const WorkColumns<T>& work, std::size_t i, const Vector<T>& sum) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    work.v[axis][i] = multiply_add<arithmetic>(work.w[i], sum[axis], work.v[axis][i]);
  }
}

template <class T, Arithmetic arithmetic>
struct AirCells {
  const GridAirTerms<T>& grid;
  const AirPulse<T>& pulse;
  const WorkColumns<T>& work;

  // The two triangles of the cell below and to the right of (row, column); beyond the borders there are none.
  [[nodiscard]] Vector<T> right(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return is_cell(row, column) ? push(at_(row, column), 1, grid.W_right) : Vector<T>{};
  }
  [[nodiscard]] Vector<T> below(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return is_cell(row, column) ? push(at_(row, column), grid.pitch, grid.W_below) : Vector<T>{};
  }
  [[nodiscard]] Vector<T> both(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return plus(right(row, column), below(row, column));
  }

 private:
  [[nodiscard]] bool is_cell(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return row >= 0 && column >= 0 && row + 1 < static_cast<std::ptrdiff_t>(grid.rows) &&
           column + 1 < static_cast<std::ptrdiff_t>(grid.columns);
  }
  [[nodiscard]] std::size_t at_(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return static_cast<std::size_t>(row) * grid.pitch + static_cast<std::size_t>(column);
  }
  [[nodiscard]] Vector<T> push(std::size_t i, std::size_t third, const T* W) const noexcept {
    const Vector<T> x = at(work.x, i);
    const std::size_t across = i + grid.pitch + 1;
    const Vector<T> v = plus(plus(at(work.v_next, i), at(work.v_next, across)), at(work.v_next, i + third));
    return air_push<arithmetic>(pulse, minus(at(work.x, across), x), minus(at(work.x, i + third), x), v, W[i]);
  }
};

template <class T, Arithmetic arithmetic>
void blow_grid(const GridAirTerms<T>& grid, const AirPulse<T>& pulse, const WorkColumns<T>& work, std::size_t from,
               std::size_t to) noexcept {
  const AirCells<T, arithmetic> cells{grid, pulse, work};
  for (std::size_t i = from; i < to; ++i) {
    const auto row = static_cast<std::ptrdiff_t>(i);
    for (std::size_t j = 0; j < grid.columns; ++j) {
      const auto column = static_cast<std::ptrdiff_t>(j);
      const Vector<T> above = plus(cells.both(row - 1, column - 1), cells.below(row - 1, column));
      add_air<T, arithmetic>(work, i * grid.pitch + j,
                             plus(plus(above, cells.right(row, column - 1)), cells.both(row, column)));
    }
  }
}

template <class T, Arithmetic arithmetic>
void blow_triangles(const TriangleTerms<T>& list, const AirPulse<T>& pulse, const WorkColumns<T>& work, std::size_t from,
                    std::size_t to) noexcept {
  for (std::size_t t = from; t < to; ++t) {
    const auto a = static_cast<std::size_t>(list.a[t]);
    const auto b = static_cast<std::size_t>(list.b[t]);
    const auto c = static_cast<std::size_t>(list.c[t]);
    Vector<T> d = minus(at(work.x, b), at(work.x, a));
    Vector<T> f = minus(at(work.x, c), at(work.x, a));
    if (work.origin[0] != nullptr) {
      d = plus(minus(at(work.origin, b), at(work.origin, a)), d);
      f = plus(minus(at(work.origin, c), at(work.origin, a)), f);
    }
    const Vector<T> v = plus(plus(at(work.v_next, a), at(work.v_next, b)), at(work.v_next, c));
    const Vector<T> p = air_push<arithmetic>(pulse, d, f, v, list.W[t]);
    for (std::size_t axis = 0; axis < 3; ++axis) list.p[axis][t] = p[axis];
  }
}

template <class T, Arithmetic arithmetic>
void gather_air(const TriangleTerms<T>& list, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; ++i) {
    Vector<T> sum{};
    for (std::size_t n = list.first_slot[i / slice]; n < list.first_slot[i / slice + 1]; ++n) {
      sum = plus(sum, at(list.p, static_cast<std::size_t>(list.slots[n * slice + i % slice])));
    }
    add_air<T, arithmetic>(work, i, sum);
  }
}

template <class T>
void middle_velocity(const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; ++i) work.v_next[axis][i] = T(0.5) * (work.v[axis][i] + work.v_next[axis][i]);
  }
}

}  // namespace dvdx::reference
