#include "springs/sweep/sweep_scheme.hpp"

#include <algorithm>
#include <cmath>

// Sweeps solve, with s the sub-step,
//   lambda = the force along a spring times t^2,   C = r - l,   lambda = -(kappa C + eta n.(moved by h v))
// by moving particles. Theta and generalized alpha make the motion of the sub-step from the total shift S, the force times t^2.
//
// Theta: t = e = h = theta s, the part of the sub-step that has passed. Over the whole sub-step
//   v += S / (theta^2 s),   x += (2 theta - 1) / theta^2 S
// before the flow over the rest of it. theta = 1/2: the springs act in a pulse at the middle, which depends on the positions
// there alone. So the step is its own inverse with -s, and of second order. With a forward and a backward sweep its matrix is
// symmetric and below 4/s^2, so linear networks are stable at every step. theta = 1 and forward sweeps: extended position-based
// dynamics in small steps (Macklin et al. 2019), of first order and damped. Below 0.7 a cloth that crumples may gain energy:
// the sweeps' error turns with the springs, which no linear network shows.
//
// Generalized alpha (Chung and Hulbert, J. Appl. Mech. 60 (1993) 371) is of second order. It damps motion that the sub-step
// does not resolve, by rho a sub-step. With a, b the springs' accelerations at the sub-step's start and end, and f their mean:
//   alpha b + (1 - alpha) a = f(x_f, v_f)                    alpha = (2 - rho) / (1 + rho)
//   v' = v + s ((1 - gamma) a + gamma b)                     gamma = (3 - rho) / (2 (1 + rho))
//   x' = x + s v + s^2 ((1/2 - beta) a + beta b)             beta  = 1 / (1 + rho)^2
// f is taken at the point 1/(1 + rho) of the way from x to x'. Here all other motion flows over s/2 before the springs and over
// s/2 after them. These flows move x by s v and by s/2 times the change of v. From the middle the point x_f is
//   x + sigma s v + tau s^2 a + T f,   sigma = (1 - rho) / (2 (1 + rho)),   T = s^2 / ((1 + rho)^2 (2 - rho)),
//   tau = (1/2 - 1 / ((1 + rho) (2 - rho))) / (1 + rho)
// So t^2 = T. The sweeps begin with the shift P = sigma s v + tau s^2 a, and add S = T f to it. The rest of x' is
// x += sigma^2 s^2 (b - a). The velocity at that point is v + nu s a + e/T S,  e = gamma s / (2 - rho),
// nu = 1 / (1 + rho) - gamma / (2 - rho). Damping sees the path (T/e) (v + nu s a) + S. In terms of shift = P + S it is
//   h (v + u_a a) + shift,   h = T/e - sigma s,   u_a = ((T/e) nu s - tau s^2) / h
// rho = 1 is theta 1/2. Undamped linear springs are stable at every step: sweeps to and fro leave S = -G x_f with a symmetric
// G between 0 and 1, like softer springs that are solved exactly.
//
// Steps that change. Springs that the sweeps do not solve have a G that hardly depends on T, and so the stiffness G/T. If each
// sub-step had its own T, the stiffness would change by the square of the steps' ratio: a chain whose steps alternate 1:2 grows
// by up to 1.012 a sub-step, 1:4 by 1.46, and its rest would depend on the step. So all sub-steps take T and e of the longest
// sub-step s_ref. kappa = k T and eta = c e_ref are made once, and f = S/T is one force law. The scheme is then the explicit
// generalized alpha (Hulbert and Chung, Comput. Methods Appl. Mech. Eng. 137 (1996) 175) on springs no stiffer than it takes at
// s_ref. All other terms follow the sub-step s that is taken. With q = T/e_ref,
//   h = q - sigma s,   u_a = (q (nu s + e - e_ref) - tau s^2) / h
// where e - e_ref keeps damping of second order. No sub-step is longer than s_ref: a longer step is cut into more sub-steps.
// If steps vary, T is 1.5 times as long: in a search of all patterns of 1 to 5 sub-steps of 0.12 to 1 s_ref the worst mode of
// rho 0 grows by 1.089 a sub-step at 1, by 1.018 at 1.5. And rho then has no shelf, on which soft sheets would gain energy.
//
// A sub-step without an a to start from is a theta scheme with 0.7, in the same form: a = 0, T = theta^2 s_ref^2,
// P = (theta - 1/2) s v, v += s b and x += (theta - 1/2) s^2 b. It gains energy in 2 of 420 runs if every sub-step is one. A
// force made from the positions cannot replace a: it holds k times what the sweeps left unsolved.

namespace dvdx {
namespace {

constexpr double theta_of_start = 0.7;

// rho resolves motion where z = frequency * sub-step is small, and gives no energy to crumpling cloth where it is large. Sheets
// that were thrown, kicked and bounced at a fixed rho gain energy from about z = 2 on at 0.7, 5 at 0.6, 7 at 0.5 and 10 at 0.4,
// and far beyond that at 0.3 too. Theta 1/2 is 1.25 times as accurate as rho 0.57 at z = 3.7. Hence rho falls twice, with a
// shelf in between. At 0.2 a sheet whose pins are driven hard keeps swinging for ever, at 0 it comes to rest.
constexpr double fine = 0.95;
constexpr double shelf = 0.6;
constexpr double end_of_fine = 1.4;
constexpr double end_of_shelf = 6.5;
constexpr double end_of_fine_uneven = 1;
constexpr double softening_uneven = 1.5;

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

bool solves_lines(const Coupling& coupling, SpringsAre springs) noexcept {
  const bool by_default = coupling.lines == Lines::rows && springs == SpringsAre::in_rows;
  return is_generalized_alpha(coupling) && (by_default || coupling.lines == Lines::whole);
}

bool leaves_substeps_open(const Coupling& coupling) noexcept {
  return coupling.scheme == Scheme::sequential && !coupling.substeps;
}

double theta_of(const Coupling& coupling) noexcept { return coupling.theta.value_or(1); }

// The bound of the frequency depends on no position. So a bad particle changes no bit of others, and one state's start no bit
// of another's. rho is in hundredths: the last digits of the bound may differ from machine to machine, but no state may.
double rho_of(double frequency, double longest, Pace pace) {
  const double z = frequency * longest;
  const double rho = pace == Pace::uneven ? fine * below(end_of_fine_uneven, z)
                                          : shelf * below(end_of_shelf, z) + (fine - shelf) * below(end_of_fine, z);
  return std::round(100 * rho) / 100;
}

GeneralizedAlpha generalized_alpha(double rho, const SubstepLength& substep) {
  const double s = substep.taken;
  const double s_ref = substep.longest;
  const double alpha = (2 - rho) / (1 + rho);
  const double gamma = (3 - rho) / (2 * (1 + rho));
  const double sigma = (1 - rho) / (2 * (1 + rho));
  const double tau = (0.5 - 1 / ((1 + rho) * (2 - rho))) / (1 + rho);
  const double nu = 1 / (1 + rho) - gamma / (2 - rho);
  const double softening = substep.pace == Pace::uneven ? softening_uneven : 1;
  const double t = std::sqrt(softening) * s_ref / ((1 + rho) * std::sqrt(2 - rho));
  const double e = gamma * s / (2 - rho);
  const double e_ref = gamma * s_ref / (2 - rho);
  const double q = t * t / e_ref;
  const double h = q - sigma * s;
  return {.implicitness = {t, e_ref, h},
          .terms = {.P_v = sigma * s,
                    .P_a = tau * s * s,
                    .u_a = (q * nu * s + q * (e - e_ref) - tau * s * s) / h,
                    .b_S = 1 / (alpha * t * t),
                    .b_a = (1 - alpha) / alpha,
                    .v_a = s * (1 - gamma),
                    .v_b = s * gamma,
                    .x_b = sigma * sigma * s * s}};
}

// The part that sweeps leave unsolved grows with T. T/s^2 grows with s, as rho falls. So a sub-step that is shorter by the
// ratio of the two t has a T that is no longer.
double as_stiff_where_uneven(double substep, double frequency) {
  if (std::isinf(substep)) return substep;
  const auto t_of = [&](Pace pace) {
    const SubstepLength length{.taken = substep, .longest = substep, .pace = pace};
    return generalized_alpha(rho_of(frequency, substep, pace), length).implicitness.t;
  };
  return substep * std::min(1.0, t_of(Pace::even) / t_of(Pace::uneven));
}

GeneralizedAlpha start_of_generalized_alpha(const SubstepLength& substep) {
  const double s = substep.taken;
  const double ahead = theta_of_start - 0.5;
  const double t = theta_of_start * substep.longest;
  return {.implicitness = {t, t, t - ahead * s},
          .terms = {.P_v = ahead * s, .b_S = 1 / (t * t), .v_b = s, .x_b = ahead * s * s}};
}

}  // namespace dvdx
