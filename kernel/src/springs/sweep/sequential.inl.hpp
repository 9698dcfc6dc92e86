// One visit of Gauss-Seidel sweeps over springs, wide: the code that strands, ranges and lines of springs share. The scalar
// twin: sequential_reference.hpp; the method: springs/sweep/sweep_scheme.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include "springs/pull.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Spring {
  V kappa, eta, l, inverse;
};

// The values of a spring's two ends, Three or Records of V: their shifts, and d after these. path: the ends' path . d.
template <class V, class Axes>
struct Met {
  Axes shift_a, shift_b, d;
  V r2, path;
};

// more: of lambda. The shift of each end changes by -+ w t d. y: inverse length.
template <class V>
struct Pull {
  Mask<V> is_sound;
  V more, t, y;
};

// A visit has three parts: meet the ends, solve, move the ends. One spring's chain of roundings takes longer than its
// arithmetic, so the parts of several springs stand side by side to keep a core busy.
template <Damping damping, Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Pull<V> solve(const Spring<V>& spring, V r2, V path, V lambda) noexcept {
  using T = Scalar<V>;
  Mask<V> is_sound = (r2 > V(least_square<T>)) & (r2 < V(most_square<T>));
  const V y = inverse_root<arithmetic>(r2);
  V g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);  // -kappa C
  if constexpr (damping == Damping::along) {
    is_sound = is_sound & (magnitude(path) < V(most_square<T>));
    g = subtract_product<arithmetic>(g, spring.eta * y, path);
  }
  const V more = product_where<V>(is_sound, g - lambda, spring.inverse);
  return {is_sound, more, more * y, y};
}

// Returns the force that moves the ends of a spring at d when its line's force is redirected along it. w: w_a + w_b.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> redirected(const Three<V>& line_force, V line_force_d, const Three<V>& d, V w, V lambda,
                                                  const Pull<V>& pull) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V turned = (zero - lambda) * pull.y * w;
  const V eased =
      select<V>(turned > V(Scalar<V>(least_redirected)), quotient(one, one + select<V>(turned > zero, turned, zero)), zero);
  const V along = pull.y * line_force_d;
  const V s = multiply_add<arithmetic>(eased, along * pull.y, pull.t);
  Three<V> force;
  for (std::size_t axis = 0; axis < 3; ++axis) force[axis] = subtract_product<arithmetic>(s * d[axis], eased, line_force[axis]);
  return force;
}

template <class V>
[[gnu::always_inline]] inline Three<V> load_three(const Scalar<V>* p, std::ptrdiff_t pitch) noexcept {
  return {{load_lanes<V>(p), load_lanes<V>(p + pitch), load_lanes<V>(p + 2 * pitch)}};
}
template <class V>
[[gnu::always_inline]] inline void store_three(Scalar<V>* p, std::ptrdiff_t pitch, const Three<V>& value) noexcept {
  for (std::ptrdiff_t axis = 0; axis < 3; ++axis) store_lanes(p + axis * pitch, value.at[axis]);
}
// Stores the first n lanes.
template <class V>
[[gnu::always_inline]] inline void store_three(Scalar<V>* p, std::ptrdiff_t pitch, const Three<V>& value,
                                               std::size_t n) noexcept {
  for (std::ptrdiff_t axis = 0; axis < 3; ++axis) store_first_lanes(p + axis * pitch, n, value.at[axis]);
}

// The position of a register of springs: its ends, its columns, and how many of its lanes are springs.
struct Place {
  std::size_t a, b, s, count;
};

// The coefficients of the springs of a turn, all alike or each by itself.
template <class V, Damping damping>
class MadeAlike {
 public:
  [[gnu::always_inline]] MadeAlike(const SweepTerms<Scalar<V>>& sweep, std::uint32_t family) noexcept
      : kappa_(sweep.materials[family].kappa), eta_(sweep.materials[family].eta), l_(sweep.materials[family].l) {}
  [[gnu::always_inline]] Spring<V> at(std::size_t /*s*/, V inverse) const noexcept { return {kappa_, eta_, l_, inverse}; }

 private:
  V kappa_, eta_, l_;
};
template <class V, Damping damping>
class MadeEach {
 public:
  [[gnu::always_inline]] MadeEach(const SweepTerms<Scalar<V>>& sweep, std::uint32_t /*family*/) noexcept
      : kappa_(sweep.kappa), eta_(sweep.eta), l_(sweep.l) {}
  [[gnu::always_inline]] Spring<V> at(std::size_t s, V inverse) const noexcept {
    const V kappa = load_lanes<V>(kappa_ + s);
    V eta = kappa;  // not read without damping
    if constexpr (damping == Damping::along) eta = load_lanes<V>(eta_ + s);
    return {kappa, eta, load_lanes<V>(l_ + s), inverse};
  }

 private:
  const Scalar<V>*kappa_, *eta_, *l_;
};

// Calls with the template arguments that the terms ask for.
template <class Call>
void by_kind(Damping damping, const Call& call) noexcept {
  if (damping == Damping::along) return call.template operator()<Damping::along>();
  call.template operator()<Damping::none>();
}
template <class Call>
void by_kind(Damping damping, Visit visit, const Call& call) noexcept {
  by_kind(damping, [&]<Damping d>() {
    if (visit == Visit::first) return call.template operator()<d, Visit::first>();
    call.template operator()<d, Visit::again>();
  });
}

}  // namespace
}  // namespace dvdx
