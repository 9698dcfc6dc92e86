#include "compile/sweep_scheme.hpp"

#include <cmath>

// Sweeps solve, with s the sub-step,
//   lambda = the force along a spring times t^2,   C = r - l,   lambda = -(k t^2 C + c e n.(moved by h v))
// by moving particles. What is left is what theta and generalized alpha make of the total shift S, the force times t^2.
//
// Theta: t = e = h, the part theta s that has passed. Over the whole sub-step
//   v += S / (theta^2 s),   x += (2 theta - 1) / theta^2 S
// before the flow over what remains of it. theta = 1/2: a pulse at the middle that depends on the positions there alone, so
// that the step is its own inverse with -s, and so of second order; with a forward and a backward sweep its matrix is symmetric
// and below 4/s^2, so that linear networks are stable at every step. theta = 1 and forward sweeps: extended position-based
// dynamics in small steps (Macklin et al. 2019), of first order and damped. Below 0.7 a cloth that crumples may gain energy:
// the sweeps' error turns with the springs, which no linear network shows.
//
// Generalized alpha (Chung and Hulbert, J. Appl. Mech. 60 (1993) 371) is of second order and damps what the sub-step does not
// resolve, by rho a sub-step. With a, b the springs' accelerations at the sub-step's start and end, and both ends of the mean:
//   alpha b + (1 - alpha) a = f(x_f, v_f)                    alpha = (2 - rho) / (1 + rho)
//   v' = v + s ((1 - gamma) a + gamma b)                     gamma = (3 - rho) / (2 (1 + rho))
//   x' = x + s v + s^2 ((1/2 - beta) a + beta b)             beta  = 1 / (1 + rho)^2
// f is of the point 1/(1 + rho) of the way from x to x'. Here everything else flows over s/2 before the springs and s/2 after
// them, which makes s v and half of s^2 of the change of v. From the middle the point x_f is
//   x + sigma s v + tau s^2 a + T f,   sigma = (1 - rho) / (2 (1 + rho)),   T = s^2 / ((1 + rho)^2 (2 - rho)),
//   tau = (1/2 - 1 / ((1 + rho) (2 - rho))) / (1 + rho)
// so that t^2 = T, the sweeps begin with the shift P = sigma s v + tau s^2 a, and leave S = T f besides. What is left of x' is
// x += sigma^2 s^2 (b - a). The velocity at that point is v + nu s a + e/T S,  e = gamma s / (2 - rho),
// nu = 1 / (1 + rho) - gamma / (2 - rho): damping sees the path (T/e) (v + nu s a) + S, which counted with P is
//   h (v + u_a a) + shift,   h = T/e - sigma s,   u_a = ((T/e) nu s - tau s^2) / h
// rho = 1 is theta 1/2. Undamped linear springs are stable at every step: sweeps to and fro leave S = -G x_f with a symmetric
// G between 0 and 1, as softer springs would that were solved exactly.
//
// A sub-step that has no a to start from is a theta scheme with 0.7, which heats in 2 of 420 runs if every sub-step is one, in
// the same form: a = 0, T = theta^2 s^2, P = (theta - 1/2) s v, v += s b and x += (theta - 1/2) s^2 b. A force made from the
// positions would not do: they hold what the sweeps left unsolved, times k.

namespace dvdx {
namespace {

constexpr double theta_of_start = 0.7;

// What gives no energy to crumpling cloth, and what resolves motion, by z = frequency * sub-step. Sheets that were thrown,
// kicked and bounced at a fixed rho heat from about z = 2 on at 0.7, 5 at 0.6, 7 at 0.5 and 10 at 0.4, far beyond that at 0.3
// too, not at 0.2; and theta 1/2 is 1.25 times as accurate where rho is 0.57 at z = 3.7. Hence two falls, with a shelf between
// them.
constexpr double fine = 0.95;
constexpr double shelf = 0.6;
constexpr double coarse = 0.2;
constexpr double end_of_fine = 1.4;
constexpr double end_of_shelf = 6.5;

// 1 for z well below `end`, 0 well above.
double below(double end, double z) {
  const double square = (z / end) * (z / end);
  return 1 / (1 + square * square);
}

}  // namespace

Compliances compliances(const Implicitness& of, double k, double c, double w) noexcept {
  const double kappa = k * of.t * of.t;
  const double eta = c * of.e;
  return {kappa, eta, 1 / (1 + (kappa + eta) * w)};
}

Implicitness theta_scheme(double theta, double substep) { return {theta * substep, theta * substep, theta * substep}; }

bool is_generalized_alpha(const Coupling& coupling) noexcept {
  return coupling.scheme == Scheme::sequential && !coupling.theta && coupling.sweeps == SweepOrder::symmetric;
}

double theta_of(const Coupling& coupling) noexcept { return coupling.theta.value_or(1); }

// Of the bound of the frequency, which no position enters: a bad particle changes no bit of others, and one state's start none
// of another's. In hundredths: the last digits of the bound may differ from machine to machine, and no state may.
double rho_of(double frequency, double substep) {
  const double z = frequency * substep;
  const double rho = coarse + (shelf - coarse) * below(end_of_shelf, z) + (fine - shelf) * below(end_of_fine, z);
  return std::round(100 * rho) / 100;
}

GeneralizedAlpha generalized_alpha(double rho, double substep) {
  const double s = substep;
  const double alpha = (2 - rho) / (1 + rho);
  const double gamma = (3 - rho) / (2 * (1 + rho));
  const double sigma = (1 - rho) / (2 * (1 + rho));
  const double tau = (0.5 - 1 / ((1 + rho) * (2 - rho))) / (1 + rho);
  const double nu = 1 / (1 + rho) - gamma / (2 - rho);
  const double t = s / ((1 + rho) * std::sqrt(2 - rho));
  const double e = gamma * s / (2 - rho);
  const double h = t * t / e - sigma * s;
  return {.implicitness = {t, e, h},
          .terms = {.P_v = sigma * s,
                    .P_a = tau * s * s,
                    .u_a = (t * t / e * nu * s - tau * s * s) / h,
                    .b_S = 1 / (alpha * t * t),
                    .b_a = (1 - alpha) / alpha,
                    .v_a = s * (1 - gamma),
                    .v_b = s * gamma,
                    .x_b = sigma * sigma * s * s}};
}

GeneralizedAlpha start_of_generalized_alpha(double substep) {
  const double s = substep;
  const double ahead = theta_of_start - 0.5;
  const double t = theta_of_start * s;
  return {.implicitness = {t, t, t - ahead * s},
          .terms = {.P_v = ahead * s, .b_S = 1 / (t * t), .v_b = s, .x_b = ahead * s * s}};
}

}  // namespace dvdx
