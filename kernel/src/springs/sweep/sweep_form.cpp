#include "springs/sweep/sweep_form.hpp"

// The equation that the sweeps solve, and the use of its solution: springs/sweep/sweep_scheme.cpp. Sweeps visit one spring
// after the other. A visit moves the spring's ends by  -+ w n d_lambda:
//   d_lambda = -(kappa C + eta n.moved + lambda) / (1 + (kappa + eta) (w_a + w_b))

namespace dvdx {

SweepImplicitness implicitness(const NetworkInput& in) {
  const Implicitness start = start_of_generalized_alpha(in.substep).implicitness;
  if (!is_generalized_alpha(in.coupling)) return {theta_scheme(theta_of(in.coupling), in.substep.taken), start};
  return {generalized_alpha(in.rho, in.substep).implicitness, start};
}

SweptSpring swept_spring(const NetworkInput& in, std::size_t spring) noexcept {
  if (in.rates != nullptr) {
    const auto [a, b] = in.rates->ends(spring);
    return {a, b, in.rates->pulls()[spring], in.rates->drags()[spring]};
  }
  const JoinedPair& s = in.springs[spring];
  return {s.a, s.b, s.is_broken ? 0 : s.k, damping_of(s)};
}

namespace {

template <class T>
ShiftTerms<T> shift_terms(const NetworkInput& in) {
  if (is_generalized_alpha(in.coupling)) return {};
  const double theta = theta_of(in.coupling);
  return {.to_x = static_cast<T>((2 * theta - 1) / (theta * theta)),
          .to_v = static_cast<T>(1 / (theta * theta * in.substep.taken))};
}

template <class T>
AlphaTerms<T> rounded(const AlphaTerms<double>& of, Damping damping) {
  const auto in_T = [](double value) { return static_cast<T>(value); };
  return {.P_v = in_T(of.P_v),
          .P_a = in_T(of.P_a),
          .u_a = in_T(of.u_a),
          .b_S = in_T(of.b_S),
          .b_a = in_T(of.b_a),
          .v_a = in_T(of.v_a),
          .v_b = in_T(of.v_b),
          .x_b = in_T(of.x_b),
          .damping = damping};
}

}  // namespace

template <class T>
SweepForm<T>::SweepForm(const NetworkInput& in)
    : shift(shift_terms<T>(in)), edited_(in.sweeps == nullptr ? Edited::by_spring : Edited::never) {
  terms.h = static_cast<T>(implicitness(in).on.h);
  terms.damping = in.is_damped ? Damping::along : Damping::none;
}

template <class T>
void SweepForm<T>::make_alpha(const NetworkInput& in) {
  if (!is_generalized_alpha(in.coupling)) return;
  alpha.emplace().sweeps_of_start = terms;
  set_scheme(in);
}

template <class T>
void SweepForm<T>::set_scheme(const NetworkInput& in) noexcept {
  terms.h = static_cast<T>(implicitness(in).on.h);
  shift = shift_terms<T>(in);
  if (!alpha) return;
  const GeneralizedAlpha start = start_of_generalized_alpha(in.substep);
  alpha->on = rounded<T>(generalized_alpha(in.rho, in.substep).terms, terms.damping);
  alpha->start = rounded<T>(start.terms, terms.damping);
  alpha->sweeps_of_start.h = static_cast<T>(start.implicitness.h);
}

template class SweepForm<float>;
template class SweepForm<double>;

}  // namespace dvdx
