// The affine pass, scalar: written by hand beside affine.inl.hpp, the same letters in the same order of operations.
#pragma once

#include <cstddef>

#include "flow/terms.hpp"
#include "simd/particle.hpp"

namespace dvdx::reference {

// Moves one axis of one particle, whose index in the plan's columns is i, through the plan's flow.
template <Arithmetic arithmetic, class T>
void affine(const Terms<T>& terms, const Offsets<T>& offsets, std::size_t axis, std::size_t i, T& x, T& v) noexcept {
  const Flow flow = terms.flow;
  T P = is_driven(flow) ? offsets.P[axis] : T(0);
  T Q = is_driven(flow) ? offsets.Q[axis] : T(0);
  if (is_rate(flow)) {
    for (std::size_t k = 0; k < terms.rates.sources; ++k) {
      P = multiply_add<arithmetic>(terms.rates.gain_v[k][axis][i], offsets.amplitude[k][axis], P);
      Q = multiply_add<arithmetic>(terms.rates.gain_x[k][axis][i], offsets.amplitude[k][axis], Q);
    }
  }

  if (is_drift(flow)) {
    const T B = is_rate(flow) ? terms.rates.B[axis][i] : terms.fused[axis].B;
    const T S = is_rate(flow) ? terms.rates.S[axis][i] : terms.fused[axis].S;
    x = x + multiply_add<arithmetic>(S, v, Q);
    v = v + subtract_product<arithmetic>(P, B, v);
    return;
  }

  const T c = has_anchor_each(flow) ? terms.anchor_each[axis][i] : terms.anchor[axis];
  if (is_shear(flow)) {
    const T sign = is_rate(flow) ? terms.rates.sign[axis][i] : terms.shear[axis].sign;
    const T t1 = is_rate(flow) ? terms.rates.t1[axis][i] : terms.shear[axis].t1;
    const T s = is_rate(flow) ? terms.rates.s[axis][i] : terms.shear[axis].s;
    const T t2 = is_rate(flow) ? terms.rates.t2[axis][i] : terms.shear[axis].t2;
    const T kappa = is_rate(flow) ? T(0) : terms.shear[axis].kappa;
    const T e = x - c;
    const T p = t1 * v;
    const T u = v - multiply_add<arithmetic>(s, e + p, kappa * v);
    T d = multiply_add<arithmetic>(t2, u, p);
    if (terms.turn == Turn::turned) d = multiply_add<arithmetic>(sign, d, (sign - T(1)) * e);
    x = is_driven(flow) ? x + (d + Q) : x + d;
    if (terms.turn == Turn::turned) {
      v = is_driven(flow) ? multiply_add<arithmetic>(sign, u, P) : sign * u;
    } else {
      v = is_driven(flow) ? u + P : u;
    }
  } else {
    const T A = is_rate(flow) ? terms.rates.A[axis][i] : terms.fused[axis].A;
    const T B = is_rate(flow) ? terms.rates.B[axis][i] : terms.fused[axis].B;
    const T C = is_rate(flow) ? terms.rates.C[axis][i] : terms.fused[axis].C;
    const T S = is_rate(flow) ? terms.rates.S[axis][i] : terms.fused[axis].S;
    const T e = x - c;
    if (is_driven(flow)) {
      x = x + multiply_add<arithmetic>(S, v, subtract_product<arithmetic>(Q, C, e));
      v = v + subtract_product<arithmetic>(subtract_product<arithmetic>(P, A, e), B, v);
    } else {
      x = x + subtract_product<arithmetic>(S * v, C, e);
      v = v - multiply_add<arithmetic>(B, v, A * e);
    }
  }
}

}  // namespace dvdx::reference
