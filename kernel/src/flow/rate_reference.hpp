// The rate pass, scalar: the hand-written twin of rate.inl.hpp is combined_in_lanes() with psi() and elementary.cpp.
#pragma once

#include <cstddef>

#include "flow/rate.hpp"
#include "forces/combined.hpp"
#include "math/psi.hpp"

namespace dvdx::reference {

inline void rate(const RateRun& run) noexcept {
  for (std::size_t i = 0; i < run.count; ++i) {
    const Combined k = combined_in_lanes(run.W[i], run.g[i], run.h);
    run.A[i] = k.A;
    run.B[i] = k.B;
    run.C[i] = k.C;
    run.S[i] = k.S;
    run.X[i] = k.constant.x;
  }
}

// Equation   x'' = exp(i Omega tau) - W x - g x' from x = v = 0
// Solution   dv = h K', dx = h^2 K with K = sum_m c_m / (m+2)!, K' = sum_m c_m / (m+1)!, where c_m collects the terms of
//            order m of psi's own series and of exp(i theta s):  c_0 = d_0,  c_{m+1} = i theta c_m + d_{m+1}
inline void rate_sinusoid(const RateSinusoid& run) noexcept {
  for (std::size_t i = 0; i < run.count; ++i) {
    const double w = (run.W[i] * run.h) * run.h;
    const double q = run.g[i] * run.h;
    double d = 1;
    double next = -q;
    double re = 1, im = 0;
    double v_re = 0, v_im = 0, x_re = 0, x_im = 0;
    for (std::size_t m = 0; m < psi_taylor_terms; ++m) {
      v_re = v_re + re * inverse_factorials[m + 1];
      v_im = v_im + im * inverse_factorials[m + 1];
      x_re = x_re + re * inverse_factorials[m + 2];
      x_im = x_im + im * inverse_factorials[m + 2];
      const double turned = next - run.theta * im;
      im = run.theta * re;
      re = turned;
      const double after = -(q * next + w * d);
      d = next;
      next = after;
    }
    run.in_v[i] = run.h * v_re;
    run.quad_v[i] = run.h * v_im;
    run.in_x[i] = (run.h * run.h) * x_re;
    run.quad_x[i] = (run.h * run.h) * x_im;
  }
}

}  // namespace dvdx::reference
