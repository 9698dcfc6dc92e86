#include "forces/combined.hpp"

#include <cstddef>

#include "math/psi.hpp"
#include "math/two_double_flow.hpp"

// Equation      x'' = f - W (x - c) - g x' + a(tau);  w = W h^2, q = g h;  e = x - c
//               W, g, c and f gather every spring, drag, wind and constant acceleration of the particle before integration.
// Solution      with psi_k = psi_k(w,q), the responses of a damped oscillator (psi.hpp; by math/two_double_flow.hpp)
// Step          dv = -A e - B v + f h psi_1        A = W h psi_1        B = q psi_1 + w psi_2        (= 1 - psi_0)
//               dx = -C e - D v + f h^2 psi_2      C = w psi_2          D = h (q psi_2 + w psi_3)    (= h - S)
//               S = h psi_1: x' = x + S v - C e + ... keeps its digits where v h - D v would cancel (omega h >> 1)
//               a = tau^k:            dv += k! h^(k+1) psi_{k+1},  dx += k! h^(k+2) psi_{k+2}
//               a = exp(i Omega tau): dv += h K',  dx += h^2 K, the response from e = v = 0 in forced_flow
// Limits        g = 0: the undamped spring. W = 0: drag; unlike separate drag it brakes a constant force's motion too.
//               W = g = 0: free flight. Resonance is no special case: K is never divided by w - theta^2 + i q theta.
// Coefficients  every line is a sum of terms of one sign for small arguments, made in two doubles and rounded once.
// Back in time  h < 0 makes q < 0 in the same functions; the result inverts the step |h| to the same accuracy.
// Source        Hochbruck and Ostermann, Acta Numerica 2010 (phi functions, here of the 2x2 companion matrix); Brown's
//               kinematic integrator leaves this accumulation of position-dependent forces open.

namespace dvdx {

Combined combined(double W, double g, double h) noexcept {
  const TwoDouble w = stiffness_number(W, h), q = damping_number(g, h);
  const PsiTable psi = flow(w, q);
  Combined step;
  step.A = (two_product(W, h) * psi[1]).value();
  step.B = (q * psi[1] + w * psi[2]).value();
  step.C = (w * psi[2]).value();
  step.D = (h * (q * psi[2] + w * psi[3])).value();
  step.S = (h * psi[1]).value();
  step.constant = {step.S, (two_product(h, h) * psi[2]).value()};
  return step;
}

Combined combined_in_lanes(double W, double g, double h) noexcept {
  const double w = (W * h) * h;
  const double q = g * h < psi_huge_root ? g * h : psi_huge_root;
  const Psi at = psi(w, q);
  Combined step;
  step.A = (W * h) * at.psi1;
  step.B = q * at.psi1 + w * at.psi2;
  step.C = w * at.psi2;
  step.D = h * (q * at.psi2 + w * at.psi3);
  step.S = h * at.psi1;
  step.constant = {step.S, (h * h) * at.psi2};
  return step;
}

Gain combined_monomial(int k, double W, double g, double h) noexcept {
  const PsiTable psi = flow(stiffness_number(W, h), damping_number(g, h), k + 2 > 3 ? k + 2 : 3);
  TwoDouble power = h;  // k! h^(k+1)
  for (int i = 1; i <= k; ++i) power = power * h * static_cast<double>(i);
  const auto at = static_cast<std::size_t>(k);
  return {(power * psi[at + 1]).value(), (power * h * psi[at + 2]).value()};
}

SinusoidGains combined_sinusoid(double W, double g, double angular_frequency, double h) noexcept {
  const TwoDouble theta = two_product(angular_frequency, h);
  const Forced unit = forced_flow(stiffness_number(W, h), damping_number(g, h), theta);
  const TwoDouble h2 = two_product(h, h);
  return {{(h * unit.velocity.re).value(), (h2 * unit.position.re).value()},
          {(h * unit.velocity.im).value(), (h2 * unit.position.im).value()}};
}

}  // namespace dvdx
