// Constraints on single particles, C(x) = 0, that a program defines. A small functor returns C and its gradient for 16
// particles at a time, so that the program's own compiler and flags vectorise it.
//
//   struct OnTorus {
//     double ring, tube;
//     template <class R>
//     R operator()(const std::array<R, 3>& x, std::array<R, 3>& gradient) const {
//       const R around = sqrt(x[0] * x[0] + x[2] * x[2]);
//       const R out = around - ring;
//       gradient = {2.0 * out * x[0] / around, 2.0 * x[1], 2.0 * out * x[2] / around};
//       return out * out + x[1] * x[1] - tube * tube;
//     }
//   };
//   copy(state, before);                          // the positions at the start of the step
//   (void)plan.step(state);
//   dvdx::constrain(before, state, plan.step_size(), OnTorus{1.0, 0.3});
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "dvdx/layouts/convert.hpp"
#include "dvdx/layouts/state.hpp"

namespace dvdx {

// One number of each of 16 particles. Compilers turn loops over its lanes into registers.
template <class T>
struct Pack {
  static constexpr std::size_t lanes = 16;
  alignas(64) std::array<T, lanes> lane{};

  Pack() = default;
  Pack(double all) noexcept {  // NOLINT(google-explicit-constructor): so that 2.0 * x is a pack
    for (T& value : lane) value = static_cast<T>(all);
  }

  template <class F>
  static Pack of(const Pack& a, const Pack& b, const F& f) noexcept {
    Pack result;
    for (std::size_t k = 0; k < lanes; ++k) result.lane[k] = f(a.lane[k], b.lane[k]);
    return result;
  }
  friend Pack operator+(const Pack& a, const Pack& b) noexcept {
    return of(a, b, [](T p, T q) { return p + q; });
  }
  friend Pack operator-(const Pack& a, const Pack& b) noexcept {
    return of(a, b, [](T p, T q) { return p - q; });
  }
  friend Pack operator*(const Pack& a, const Pack& b) noexcept {
    return of(a, b, [](T p, T q) { return p * q; });
  }
  friend Pack operator/(const Pack& a, const Pack& b) noexcept {
    return of(a, b, [](T p, T q) { return p / q; });
  }
  friend Pack operator-(const Pack& a) noexcept {
    return of(a, a, [](T p, T) { return -p; });
  }
  friend Pack sqrt(const Pack& a) noexcept {
    return of(a, a, [](T p, T) { return std::sqrt(p); });
  }
};

namespace constraining {

template <class T>
using Pack3 = std::array<Pack<T>, 3>;

template <class T>
Pack<T> dot(const Pack3<T>& a, const Pack3<T>& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
void add(Pack3<T>& to, const Pack<T>& s, const Pack3<T>& direction) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = to[axis] + s * direction[axis];
}
// a / b, or 0 if that is not finite: a vanishing gradient, or a particle that is not finite, moves nothing.
template <class T>
Pack<T> safe_quotient(const Pack<T>& a, const Pack<T>& b) noexcept {
  constexpr T most = std::numeric_limits<T>::max();
  return Pack<T>::of(a, b, [](T p, T q) {
    const T value = p / q;
    return value >= -most && value <= most ? value : T(0);
  });
}

// Loads particles [first, first + count) of a column; further lanes repeat the last particle.
template <class T>
Pack<T> load(const Column<T>& column, std::size_t first, std::size_t count) noexcept {
  Pack<T> pack;
  gather(column, first, count, pack.lane.data());
  std::fill(pack.lane.begin() + static_cast<std::ptrdiff_t>(count), pack.lane.end(), pack.lane[count - 1]);
  return pack;
}
template <class T>
void store(const Pack<T>& pack, const Column<T>& column, std::size_t first, std::size_t count) noexcept {
  scatter(pack.lane.data(), first, count, column);
}

// Applies position pulses along the gradients at x_n until C = 0, each by Newton's steps along its own gradient, and adds the
// velocity that they amount to.
template <class T, class... C>
void place(const Pack3<T>& before, Pack3<T>& x, Pack3<T>& v, double h, int iterations, const C&... constraints) noexcept {
  std::array<Pack3<T>, sizeof...(C)> direction;
  std::array<Pack<T>, sizeof...(C)> sum;
  std::size_t c = 0;
  ((void)constraints(before, direction[c++]), ...);
  const auto newton = [&](const auto& constraint) {
    Pack3<T> gradient;
    const Pack<T> value = constraint(x, gradient);
    const Pack<T> s = safe_quotient<T>(-value, dot<T>(gradient, direction[c]));
    add<T>(x, s, direction[c]);
    sum[c] = sum[c] + s;
    ++c;
  };
  for (int n = 0; n < iterations; ++n) {
    c = 0;
    (newton(constraints), ...);
  }
  for (c = 0; c < sizeof...(C); ++c) add<T>(v, (1 / h) * sum[c], direction[c]);
}

// The velocity pulse: removes the part of v along all gradients at once (Gram and Schmidt).
template <class T, class... C>
void turn(const Pack3<T>& x, Pack3<T>& v, const C&... constraints) noexcept {
  std::array<Pack3<T>, sizeof...(C)> across;
  std::size_t c = 0;
  const auto project = [&](const auto& constraint) {
    (void)constraint(x, across[c]);
    for (std::size_t k = 0; k < c; ++k) {
      add<T>(across[c], -safe_quotient<T>(dot<T>(across[c], across[k]), dot<T>(across[k], across[k])), across[k]);
    }
    add<T>(v, -safe_quotient<T>(dot<T>(v, across[c]), dot<T>(across[c], across[c])), across[c]);
    ++c;
  };
  (project(constraints), ...);
}

}  // namespace constraining

// Moves every particle of `state` to a place where all constraints are 0, and turns its velocity along them. `state` has been
// stepped by h, s, from the positions in `before`; velocities of `before` are not read. A constraint is a functor (x, gradient)
// -> C that is called with Pack<T> and fills in the gradient. One constraint gives a surface, two a curve.
// The two pulses form RATTLE's pair: the first acts along the gradient at the step's start and also gives the velocity, the
// second at its end. This is second order if `before` was on the constraint. A particle's mass cancels. The position pulse
// takes at most `iterations` steps of Newton's; if the path is too bent within a step for them to converge, the particle ends
// beside the constraint, finite. Works on any layout and allocates nothing.
template <class T, class... C>
void constrain(const State<T>& before, State<T>& state, double h, int iterations, const C&... constraints) noexcept {
  static_assert(sizeof...(C) >= 1 && sizeof...(C) <= 3);
  using namespace constraining;
  for (std::size_t first = 0; first < state.count; first += Pack<T>::lanes) {
    const std::size_t count = std::min(Pack<T>::lanes, state.count - first);
    Pack3<T> start;
    Pack3<T> x;
    Pack3<T> v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      start[axis] = load(before.x[axis], first, count);
      x[axis] = load(state.x[axis], first, count);
      v[axis] = load(state.v[axis], first, count);
    }
    place<T>(start, x, v, h, iterations, constraints...);
    turn<T>(x, v, constraints...);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      store(x[axis], state.x[axis], first, count);
      store(v[axis], state.v[axis], first, count);
    }
  }
}
template <class T, class First, class... C>
requires(!std::is_arithmetic_v<First>) void constrain(const State<T>& before, State<T>& state, double h, const First& one,
                                                      const C&... more) noexcept {
  constrain(before, state, h, 8, one, more...);
}

}  // namespace dvdx
