// What a sub-step of `sequential` makes of the springs: how far ahead they are looked at, and what their force does.
#pragma once

#include "dvdx/network.hpp"
#include "passes/network/network.hpp"

namespace dvdx {

// A force along a spring that acts implicitly: kappa = k t^2, eta = c e, and the path that v makes is h v.
struct Implicitness {
  double t, e, h;  // s
};

// What sweeps solve a spring by: d_lambda = -(kappa C + eta n.moved + lambda) inverse.
struct Compliances {
  double kappa, eta, inverse;
};
// w: w_a + w_b of its ends.
Compliances compliances(const Implicitness& of, double k, double c, double w) noexcept;

// The part of the sub-step that has passed when the springs act.
Implicitness theta_scheme(double theta, double substep);

// Whether this is what a coupling asks for.
bool is_generalized_alpha(const Coupling& coupling) noexcept;
// Of a coupling that asks for the theta scheme.
double theta_of(const Coupling& coupling) noexcept;

// The part of a motion that stiff springs keep from a sub-step to the next. frequency: rad/s, of the springs in any position.
double rho_of(double frequency, double substep);

struct GeneralizedAlpha {
  Implicitness implicitness;
  AlphaTerms<double> terms;
};
GeneralizedAlpha generalized_alpha(double rho, double substep);
// A sub-step whose a is not known, and 0 in the column.
GeneralizedAlpha start_of_generalized_alpha(double substep);

}  // namespace dvdx
