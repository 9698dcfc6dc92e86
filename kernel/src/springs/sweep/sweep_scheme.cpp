#include "springs/sweep/sweep_scheme.hpp"

#include <algorithm>
#include <cmath>

// Sweeps solve, with s the sub-step,
//   lambda = the force along a spring times t^2,   C = r - l,   lambda = -(k t^2 C + c e n.(moved by h v))
// by moving particles. The rest is what theta and generalized alpha make of the total shift S, the force times t^2.
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
// so that t^2 = T, the sweeps begin with the shift P = sigma s v + tau s^2 a, and leave S = T f besides. The rest of x' is
// x += sigma^2 s^2 (b - a). The velocity at that point is v + nu s a + e/T S,  e = gamma s / (2 - rho),
// nu = 1 / (1 + rho) - gamma / (2 - rho): damping sees the path (T/e) (v + nu s a) + S, which counted with P is
//   h (v + u_a a) + shift,   h = T/e - sigma s,   u_a = ((T/e) nu s - tau s^2) / h
// rho = 1 is theta 1/2. Undamped linear springs are stable at every step: sweeps to and fro leave S = -G x_f with a symmetric
// G between 0 and 1, as softer springs would that were solved exactly.
//
// Steps that change. Springs that the sweeps do not solve have a G that hardly depends on T, and the stiffness G/T. With T of
// each sub-step it would change by the square of the step's ratio: a chain whose steps alternate 1:2 grows by up to 1.012 a
// sub-step, 1:4 by 1.46, and its rest would depend on the step. So T and e are those of the longest sub-step s_ref for every
// sub-step, kappa = k T, eta = c e_ref are made once, and f = S/T is one force law: the scheme is the explicit generalized
// alpha (Hulbert and Chung, Comput. Methods Appl. Mech. Eng. 137 (1996) 175) on springs no stiffer than it takes at s_ref. All
// else is of the sub-step s that is taken. With q = T/e_ref,
//   h = q - sigma s,   u_a = (q (nu s + e - e_ref) - tau s^2) / h
// where e - e_ref keeps damping of second order. Sub-steps longer than s_ref there are none: a longer step is cut into more.
// Where steps vary T is 1.5 times as long: in a search of all patterns of 1 to 5 sub-steps of 0.12 to 1 s_ref the worst mode of
// rho 0 grows by 1.089 a sub-step at 1, by 1.018 at 1.5; and rho has no shelf, on which soft sheets heat.
//
// A sub-step that has no a to start from is a theta scheme with 0.7, which heats in 2 of 420 runs if every sub-step is one, in
// the same form: a = 0, T = theta^2 s_ref^2, P = (theta - 1/2) s v, v += s b and x += (theta - 1/2) s^2 b. A force made from
// the positions would not do: they hold what the sweeps left unsolved, times k.

namespace dvdx {
namespace {

constexpr double theta_of_start = 0.7;

// The rho that gives no energy to crumpling cloth, and the one that resolves motion, by z = frequency * sub-step. Sheets that
// were thrown, kicked and bounced at a fixed rho heat from about z = 2 on at 0.7, 5 at 0.6, 7 at 0.5 and 10 at 0.4, far beyond
// that at 0.3 too; and theta 1/2 is 1.25 times as accurate where rho is 0.57 at z = 3.7. Hence two falls, with a shelf between
// them. At 0.2 a sheet whose pins are driven hard keeps swinging for ever, at 0 it comes to rest.
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

// From the bound of the frequency, which no position enters: a bad particle changes no bit of others, and one state's start
// none of another's. In hundredths: the last digits of the bound may differ from machine to machine, and no state may.
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

// The part that sweeps leave unsolved grows with T. T/s^2 grows with s, as rho falls: a sub-step that is shorter by the ratio
// of both t has a T that is no longer.
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
