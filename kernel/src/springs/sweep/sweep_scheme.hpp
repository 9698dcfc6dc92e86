// The springs in a sub-step of `sequential`: how far ahead their force is taken, and how it changes the state.
#pragma once

#include <cstdint>

#include "dvdx/network.hpp"
#include "springs/network.hpp"
#include "topology/list_sheet.hpp"

namespace dvdx {

// The times of an implicit force along a spring: kappa = k t^2, eta = c e, and the path due to v is h v.
struct Implicitness {
  double t, e, h;  // s
};

// The coefficients by which sweeps solve a spring: d_lambda = -(kappa C + eta n.moved + lambda) inverse.
struct Compliances {
  double kappa, eta, inverse;
};
// w: w_a + w_b of its ends.
Compliances compliances(const Implicitness& of, double k, double c, double w) noexcept;

// By theta all three times are the part of the sub-step that has passed when the springs act.
Implicitness theta_scheme(double theta, double substep);

// Whether a coupling asks for generalized alpha.
bool is_generalized_alpha(const Coupling& coupling) noexcept;
// Whether a coupling solves lines of springs between its sweeps.
bool solves_lines(const Coupling& coupling, SpringsAre springs) noexcept;
// Whether the number of its sub-steps follows from Coupling::longest_substep.
bool leaves_substeps_open(const Coupling& coupling) noexcept;
// The theta of a coupling that asks for the theta scheme.
double theta_of(const Coupling& coupling) noexcept;

// Whether all steps of a plan have been of one length.
enum class Pace : std::uint8_t { even, uneven };

// A sub-step and the longest that the plan takes, both of one sign.
struct SubstepLength {
  double taken = 0, longest = 0;  // s
  Pace pace = Pace::even;
};

inline SubstepLength even(double substep) noexcept { return {.taken = substep, .longest = substep}; }

// Returns rho, the part of a motion that stiff springs keep from a sub-step to the next. frequency: rad/s, of the springs in
// any position; longest: s, the longest sub-step.
double rho_of(double frequency, double longest, Pace pace);

struct GeneralizedAlpha {
  Implicitness implicitness;
  AlphaTerms<double> terms;
};
GeneralizedAlpha generalized_alpha(double rho, const SubstepLength& substep);
// Returns, in s, the longest sub-step of uneven steps that leaves springs at least as stiff as `substep` of even steps does.
double as_stiff_where_uneven(double substep, double frequency);
// A sub-step whose a is not known: the column of a holds 0.
GeneralizedAlpha start_of_generalized_alpha(const SubstepLength& substep);

}  // namespace dvdx
