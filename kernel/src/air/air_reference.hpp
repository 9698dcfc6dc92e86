// Air on triangles, scalar: each particle sums the triangles around it.
#pragma once

#include "air/air.hpp"
#include "springs/pull_reference.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
Vector<T> cross(const Vector<T>& d, const Vector<T>& f) noexcept {
  return {subtract_product<arithmetic>(d[1] * f[2], d[2], f[1]), subtract_product<arithmetic>(d[2] * f[0], d[0], f[2]),
          subtract_product<arithmetic>(d[0] * f[1], d[1], f[0])};
}

// p(u)/3 of a triangle with the normal s.
template <Arithmetic arithmetic, class T>
Vector<T> air_push(const AirPulse<T>& pulse, const Vector<T>& s, const Vector<T>& u, T W) noexcept {
  if (!(W >= T(0))) return {};
  const T D = pulse.drag, L = pulse.lift;
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

template <class T>
struct AirCorners {
  Vector<T> d, f, v, g;
};

// p/3 of a stage; before: p_1/3.
template <Arithmetic arithmetic, class T>
Vector<T> air_push(AirStage stage, const AirPulse<T>& pulse, const AirCorners<T>& of, const Vector<T>& before, T W) noexcept {
  const T third = T(1) / T(3);
  const Vector<T> s = cross<arithmetic>(of.d, of.f);
  Vector<T> u{};
  for (std::size_t axis = 0; axis < 3; ++axis) u[axis] = subtract_product<arithmetic>(pulse.wind[axis], third, of.v[axis]);
  if (stage == AirStage::first) return air_push<arithmetic>(pulse, s, u, W);
  const T half_W = T(1.5) * W;
  Vector<T> e{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    e[axis] = subtract_product<arithmetic>(third * of.g[axis], half_W, before[axis]);
  }
  const T U2 = inner<arithmetic>(u, u);
  const T part = U2 / multiply_add<arithmetic>(T(4), inner<arithmetic>(e, e), U2);
  Vector<T> shifted{};
  for (std::size_t axis = 0; axis < 3; ++axis) shifted[axis] = subtract_product<arithmetic>(u[axis], part, e[axis]);
  const Vector<T> p = air_push<arithmetic>(pulse, s, shifted, W);
  return inner<arithmetic>(p, u) >= half_W * inner<arithmetic>(p, p) ? p : before;
}

template <Arithmetic arithmetic, class T>
void leave_air(AirStage stage, const WorkColumns<T>& work, const std::array<T*, 3>& g, std::size_t i,
               const Vector<T>& sum) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (stage == AirStage::first) {
      g[axis][i] = (T(0.5) * work.w[i]) * sum[axis];
    } else {
      work.v[axis][i] = multiply_add<arithmetic>(work.w[i], sum[axis], work.v[axis][i]);
    }
  }
}

template <class T, Arithmetic arithmetic>
struct AirCells {
  const GridAirTerms<T>& grid;
  const AirPulse<T>& pulse;
  const WorkColumns<T>& work;
  AirStage stage;

  // The two triangles of the cell below and to the right of (row, column); beyond the borders there are none.
  [[nodiscard]] Vector<T> right(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return is_cell(row, column) ? push(at_(row, column), 1, grid.p_right, grid.W_right) : Vector<T>{};
  }
  [[nodiscard]] Vector<T> below(std::ptrdiff_t row, std::ptrdiff_t column) const noexcept {
    return is_cell(row, column) ? push(at_(row, column), grid.pitch, grid.p_below, grid.W_below) : Vector<T>{};
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
  [[nodiscard]] Vector<T> push(std::size_t i, std::size_t third, const std::array<T*, 3>& p, const T* W) const noexcept {
    const Vector<T> x = at(work.x, i);
    const std::size_t across = i + grid.pitch + 1;
    const auto sum = [&](const std::array<T*, 3>& columns) {
      return plus(plus(at(columns, i), at(columns, across)), at(columns, i + third));
    };
    AirCorners<T> of{minus(at(work.x, across), x), minus(at(work.x, i + third), x), sum(work.v_next), {}};
    if (stage == AirStage::second) of.g = sum(grid.g);
    return air_push<arithmetic>(stage, pulse, of, stage == AirStage::second ? at(p, i) : Vector<T>{}, W[i]);
  }
};

template <class T, Arithmetic arithmetic>
void blow_grid(const GridAirTerms<T>& grid, const AirPulse<T>& pulse, const WorkColumns<T>& work, AirStage stage,
               std::size_t from, std::size_t to) noexcept {
  const AirCells<T, arithmetic> cells{grid, pulse, work, stage};
  for (std::size_t i = from; i < to; ++i) {
    const auto row = static_cast<std::ptrdiff_t>(i);
    for (std::size_t j = 0; j < grid.columns; ++j) {
      const auto column = static_cast<std::ptrdiff_t>(j);
      const std::size_t element = i * grid.pitch + j;
      const Vector<T> right = cells.right(row, column), below = cells.below(row, column);
      for (std::size_t axis = 0; axis < 3 && stage == AirStage::first; ++axis) {
        grid.p_right[axis][element] = right[axis];
        grid.p_below[axis][element] = below[axis];
      }
      const Vector<T> above = plus(cells.both(row - 1, column - 1), cells.below(row - 1, column));
      const Vector<T> sum = plus(plus(above, cells.right(row, column - 1)), plus(right, below));
      leave_air<arithmetic>(stage, work, grid.g, element, sum);
    }
  }
}

template <class T, Arithmetic arithmetic>
void blow_triangles(const TriangleTerms<T>& list, const AirPulse<T>& pulse, const WorkColumns<T>& work, AirStage stage,
                    std::size_t from, std::size_t to) noexcept {
  for (std::size_t t = from; t < to; ++t) {
    const auto a = static_cast<std::size_t>(list.a[t]);
    const auto b = static_cast<std::size_t>(list.b[t]);
    const auto c = static_cast<std::size_t>(list.c[t]);
    const auto sum = [&](const std::array<T*, 3>& columns) {
      return plus(plus(at(columns, a), at(columns, b)), at(columns, c));
    };
    AirCorners<T> of{minus(at(work.x, b), at(work.x, a)), minus(at(work.x, c), at(work.x, a)), sum(work.v_next), {}};
    if (work.origin[0] != nullptr) {
      of.d = plus(minus(at(work.origin, b), at(work.origin, a)), of.d);
      of.f = plus(minus(at(work.origin, c), at(work.origin, a)), of.f);
    }
    if (stage == AirStage::second) of.g = sum(list.g);
    const Vector<T> p = air_push<arithmetic>(stage, pulse, of, at(list.p, t), list.W[t]);
    for (std::size_t axis = 0; axis < 3; ++axis) list.p[axis][t] = p[axis];
  }
}

template <class T, Arithmetic arithmetic>
void gather_air(const TriangleTerms<T>& list, const WorkColumns<T>& work, AirStage stage, std::size_t from,
                std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; ++i) {
    Vector<T> sum{};
    for (std::size_t n = list.first_slot[i / slice]; n < list.first_slot[i / slice + 1]; ++n) {
      sum = plus(sum, at(list.p, static_cast<std::size_t>(list.slots[n * slice + i % slice])));
    }
    leave_air<arithmetic>(stage, work, list.g, i, sum);
  }
}

template <class T>
void middle_velocity(const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; ++i) work.v_next[axis][i] = T(0.5) * (work.v[axis][i] + work.v_next[axis][i]);
  }
}

}  // namespace dvdx::reference
