// The affine pass, wide. forces/ derives the formulas; the scalar twin is affine_reference.hpp.
// A flow moves (x, v) of one axis to the end of the step. `i` is the index of the first lane in the plan's columns.
#pragma once

#include <array>
#include <cstddef>

#include "flow/terms.hpp"
#include "simd/lanes.hpp"

namespace dvdx {
namespace {

template <class V>
struct AxisState {
  V x, v;
};

template <class V, Arithmetic arithmetic>
AxisState<V> drift(V x, V v, V B, V S, V P, V Q) noexcept {
  return {x + multiply_add<arithmetic>(S, v, Q), v + subtract_product<arithmetic>(P, B, v)};
}

template <class V, Arithmetic arithmetic>
AxisState<V> fused(V x, V v, V c, V A, V B, V C, V S) noexcept {
  const V e = x - c;
  return {x + subtract_product<arithmetic>(S * v, C, e), v - multiply_add<arithmetic>(B, v, A * e)};
}

template <class V, Arithmetic arithmetic>
AxisState<V> driven_fused(V x, V v, V c, V A, V B, V C, V S, V P, V Q) noexcept {
  const V e = x - c;
  return {x + multiply_add<arithmetic>(S, v, subtract_product<arithmetic>(Q, C, e)),
          v + subtract_product<arithmetic>(subtract_product<arithmetic>(P, A, e), B, v)};
}

// Returns the increment of e and the new v, of the turned state if the sign is -1.
template <class V, Arithmetic arithmetic>
AxisState<V> three_shears(V e, V v, V t1, V s, V t2, V kappa) noexcept {
  const V p = t1 * v;
  const V u = v - multiply_add<arithmetic>(s, e + p, kappa * v);
  return {multiply_add<arithmetic>(t2, u, p), u};
}

template <class V, Turn turn, Arithmetic arithmetic>
AxisState<V> shear(V x, V v, V c, const ShearAxis<V>& k) noexcept {
  const V e = x - c;
  const AxisState<V> d = three_shears<V, arithmetic>(e, v, k.t1, k.s, k.t2, k.kappa);
  if constexpr (turn == Turn::none) {
    return {x + d.x, d.v};
  } else {
    return {x + multiply_add<arithmetic>(k.sign, d.x, (k.sign - V(1)) * e), k.sign * d.v};
  }
}

template <class V, Turn turn, Arithmetic arithmetic>
AxisState<V> driven_shear(V x, V v, V c, const ShearAxis<V>& k, V P, V Q) noexcept {
  const V e = x - c;
  const AxisState<V> d = three_shears<V, arithmetic>(e, v, k.t1, k.s, k.t2, k.kappa);
  if constexpr (turn == Turn::none) {
    return {x + (d.x + Q), d.v + P};
  } else {
    return {x + (multiply_add<arithmetic>(k.sign, d.x, (k.sign - V(1)) * e) + Q), multiply_add<arithmetic>(k.sign, d.v, P)};
  }
}

// Adds sources to P and Q of one axis, if particles respond differently to the same acceleration.
template <class V, Arithmetic arithmetic>
void add_sources(const Rates<Scalar<V>>& rates, const Offsets<Scalar<V>>& offsets, std::size_t axis, std::size_t i, V& P,
                 V& Q) noexcept {
  for (std::size_t k = 0; k < rates.sources; ++k) {
    const V amplitude(offsets.amplitude[k][axis]);
    P = multiply_add<arithmetic>(load_lanes<V>(rates.gain_v[k][axis] + i), amplitude, P);
    Q = multiply_add<arithmetic>(load_lanes<V>(rates.gain_x[k][axis] + i), amplitude, Q);
  }
}

// Moves one axis. Uniform coefficients are copied into registers once a block: by reference they could alias the particles.
template <class V, Flow flow, Turn turn, Arithmetic arithmetic>
class AxisFlow {
  using T = Scalar<V>;

 public:
  AxisFlow(const Terms<T>& terms, const Offsets<T>& offsets, std::size_t axis) noexcept
      : terms_(terms), offsets_(offsets), axis_(axis) {
    if constexpr (is_driven(flow)) {
      P_ = V(offsets.P[axis]);
      Q_ = V(offsets.Q[axis]);
    }
    if constexpr (is_rate(flow)) return;
    if constexpr (!has_anchor_each(flow)) c_ = V(terms.anchor[axis]);
    const auto& f = terms.fused[axis];
    const auto& s = terms.shear[axis];
    if constexpr (is_shear(flow)) {
      shear_ = {V(s.sign), V(s.t1), V(s.s), V(s.t2), V(s.kappa)};
    } else {
      fused_ = {V(f.A), V(f.B), V(f.C), V(f.S)};
    }
  }

  [[nodiscard]] AxisState<V> operator()(V x, V v, std::size_t i) const noexcept {
    const auto& [A, B, C, S] = fused_;
    if constexpr (is_rate(flow)) {
      return rate(x, v, i);
    } else if constexpr (is_drift(flow)) {
      return drift<V, arithmetic>(x, v, B, S, P_, Q_);
    } else if constexpr (is_shear(flow) && is_driven(flow)) {
      return driven_shear<V, turn, arithmetic>(x, v, anchor(i), shear_, P_, Q_);
    } else if constexpr (is_shear(flow)) {
      return shear<V, turn, arithmetic>(x, v, anchor(i), shear_);
    } else if constexpr (is_driven(flow)) {
      return driven_fused<V, arithmetic>(x, v, anchor(i), A, B, C, S, P_, Q_);
    } else {
      return fused<V, arithmetic>(x, v, anchor(i), A, B, C, S);
    }
  }

 private:
  [[nodiscard]] V each(const AxisColumns<T>& columns, std::size_t i) const noexcept {
    return load_lanes<V>(columns[axis_] + i);
  }

  [[nodiscard]] V anchor(std::size_t i) const noexcept {
    if constexpr (has_anchor_each(flow)) {
      return each(terms_.anchor_each, i);
    } else {
      return c_;
    }
  }

  [[nodiscard]] AxisState<V> rate(V x, V v, std::size_t i) const noexcept {
    V P = P_;
    V Q = Q_;
    add_sources<V, arithmetic>(terms_.rates, offsets_, axis_, i, P, Q);
    const auto& k = terms_.rates;
    if constexpr (flow == Flow::rate_drift) {
      return drift<V, arithmetic>(x, v, each(k.B, i), each(k.S, i), P, Q);
    } else if constexpr (flow == Flow::rate_fused) {
      return driven_fused<V, arithmetic>(x, v, anchor(i), each(k.A, i), each(k.B, i), each(k.C, i), each(k.S, i), P, Q);
    } else {
      const ShearAxis<V> shear{each(k.sign, i), each(k.t1, i), each(k.s, i), each(k.t2, i), V(0)};
      return driven_shear<V, turn, arithmetic>(x, v, anchor(i), shear, P, Q);
    }
  }

  const Terms<T>& terms_;
  const Offsets<T>& offsets_;
  std::size_t axis_;
  V P_, Q_, c_;
  FusedAxis<V> fused_;
  ShearAxis<V> shear_;
};

// Moves one axis by any flow of a kind, fused or shear (kind_of() of flow/terms.hpp). It serves one batch, and reads the flow's
// coefficients from `terms`.
template <class V, Flow kind, Arithmetic arithmetic>
class AxisFlowOfKind {
  using T = Scalar<V>;

 public:
  AxisFlowOfKind(const Terms<T>& terms, const Offsets<T>& offsets, std::size_t axis) noexcept
      : terms_(terms), offsets_(offsets), axis_(axis) {}

  [[nodiscard]] AxisState<V> operator()(V x, V v, std::size_t i) const noexcept {
    const T* const each = terms_.anchor_each[axis_];
    const V c = each != nullptr ? load_lanes<V>(each + i) : V(terms_.anchor[axis_]);
    V x1 = x;
    V v1 = v;
    if constexpr (is_shear(kind)) {
      const auto& k = terms_.shear[axis_];
      const V e = x - c;
      const AxisState<V> d = three_shears<V, arithmetic>(e, v, V(k.t1), V(k.s), V(k.t2), V(k.kappa));
      V dx = d.x;
      v1 = d.v;
      if (terms_.turn == Turn::turned) {
        const V sign(k.sign);
        dx = multiply_add<arithmetic>(sign, dx, (sign - V(1)) * e);
        v1 = sign * v1;
      }
      if (is_driven(terms_.flow)) {
        dx = dx + V(offsets_.Q[axis_]);
        v1 = v1 + V(offsets_.P[axis_]);
      }
      x1 = x + dx;
    } else {
      const auto& k = terms_.fused[axis_];
      if (is_driven(terms_.flow)) {
        const AxisState<V> end =
            driven_fused<V, arithmetic>(x, v, c, V(k.A), V(k.B), V(k.C), V(k.S), V(offsets_.P[axis_]), V(offsets_.Q[axis_]));
        x1 = end.x;
        v1 = end.v;
      } else {
        const AxisState<V> end = fused<V, arithmetic>(x, v, c, V(k.A), V(k.B), V(k.C), V(k.S));
        x1 = end.x;
        v1 = end.v;
      }
    }
    return {x1, v1};
  }

 private:
  const Terms<T>& terms_;
  const Offsets<T>& offsets_;
  std::size_t axis_;
};

// The number of registers of particles that stay loaded through all steps of a call, so that each hides the latency of the
// others' chains. With 1024 particles, 16 steps a call, AVX-512, by 1 | 2 | 4 | 8: drift contracted 0.25 | 0.17 | 0.15 | 0.13
// ns a particle-step, shear 0.35 | 0.59 | 0.41 | 0.34. With the 16 registers of AVX2 every group was slower than none.
inline constexpr std::size_t group_registers = 8;
// Whether a group pays. With 16 registers it spills, and pays only if steps are repeated.
template <class V>
bool is_worth_groups(std::size_t repeats) noexcept {
  constexpr bool has_32_registers = sizeof(V) == 64;
  return has_32_registers || repeats > 1;
}

// Registers of a column side by side.
template <class V>
struct Columns {
  [[nodiscard]] V load(const Scalar<V>* group, std::size_t k) const noexcept { return load_lanes<V>(group + k * V::size); }
  void store(Scalar<V>* group, std::size_t k, V value) const noexcept { store_lanes(group + k * V::size, value); }
};

// Moves one axis of the group at x and v through all steps, which are alike. i: the index of its first particle.
template <class V, class OneAxis, class Rows>
[[gnu::always_inline]] inline void run_group(const OneAxis& affine, const Rows& rows, Scalar<V>* x, Scalar<V>* v, std::size_t i,
                                             std::size_t steps) noexcept {
  V at[group_registers], speed[group_registers];
  for (std::size_t k = 0; k < group_registers; ++k) {
    at[k] = rows.load(x, k);
    speed[k] = rows.load(v, k);
  }
  for (std::size_t n = 0; n < steps; ++n) {
    for (std::size_t k = 0; k < group_registers; ++k) {
      const AxisState<V> end = affine(at[k], speed[k], i + k * V::size);
      at[k] = end.x;
      speed[k] = end.v;
    }
  }
  for (std::size_t k = 0; k < group_registers; ++k) {
    rows.store(x, k, at[k]);
    rows.store(v, k, speed[k]);
  }
}

}  // namespace
}  // namespace dvdx
