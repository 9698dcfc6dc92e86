#include "forces/polynomial.hpp"

#include <cstddef>

#include "math/two_double.hpp"

// Equation      x'' = tau^k, tau the time since the step's start
// Solution      v = tau^(k+1)/(k+1),  x = tau^(k+2)/((k+1)(k+2))
// Step          exact: both at tau = h. Average acceleration: dx = dv h/2. Pulse: dx = dv h.
//               Symplectic Euler sees the force at the step's start, where only tau^0 is not 0.
// Coefficients  A polynomial of the scene's time is expanded about the step's start by Horner's rule repeated (Taylor shift),
//               in two doubles: at late times its terms nearly cancel.
// Source        Brown's kinematic integrator (time-only forces are exact in any number); Knuth, TAOCP 2, 4.6.4.

namespace dvdx {

Polynomial8 shift(const Polynomial8& coefficients, const Clock& clock) noexcept {
  const TwoDouble start = two_sum(clock.seconds, clock.carry);
  std::array<TwoDouble, polynomial_terms> local;
  for (std::size_t k = 0; k < local.size(); ++k) local[k] = coefficients[k];
  for (std::size_t done = 0; done + 1 < local.size(); ++done) {
    for (std::size_t k = local.size() - 1; k-- > done;) local[k] += start * local[k + 1];
  }
  Polynomial8 rounded;
  for (std::size_t k = 0; k < rounded.size(); ++k) rounded[k] = local[k].value();
  return rounded;
}

Gain monomial(int k, double h, Method method) noexcept {
  if (method == Method::symplectic_euler) return k == 0 ? Gain{h, h * h} : Gain{};
  double power = h;
  for (int i = 0; i < k; ++i) power *= h;
  const double dv = power / (k + 1);
  if (method == Method::average_acceleration) return {dv, 0.5 * h * dv};
  if (method == Method::pulse) return {dv, h * dv};
  return {dv, h * power / ((k + 1) * (k + 2))};
}

}  // namespace dvdx
