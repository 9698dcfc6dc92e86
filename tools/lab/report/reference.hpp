// The reference that a scene's runs are held against.
#pragma once

#include <functional>

#include "closed_form/closed_form.hpp"
#include "report/grid.hpp"
#include "report/growth.hpp"
#include "report/results.hpp"
#include "report/simulation.hpp"
#include "report/trace.hpp"

namespace dvdx::tool::report {

struct Reference {
  ReferenceFacts facts;
  Picks picks;  // whose paths they are
  Path path;
  std::size_t horizon = 0;     // sample times until which positions are compared, the start counted
  std::vector<double> energy;  // J, at every sample time
  double amplitude = 0;        // m, until the horizon
  double whole_amplitude = 0;  // m, of the whole run
  double energy_scale = 0;     // J: the greatest kinetic energy
  bool keeps_energy = false;
};

// The closed form where the scene has one, of the whole run or from impact to impact; else method combined in float64 with
// steps far below the smallest of the grid.
[[nodiscard]] Reference first_reference(const SceneFile& sample, const Grid& grid, const Setup& setup);

// Halves the step of an extrapolated reference until halving moves it by less than a hundredth of `smallest_error` (m), or
// until the work is out of proportion, and says which. Returns whether the path changed.
bool refine(Reference& reference, const SceneFile& sample, const Grid& grid, const Setup& setup, double smallest_error,
            Effort effort);

// How fine a stepped reference of joined particles is to be.
struct Fineness {
  int substeps = 1;                                        // of the coarsest step, to begin with
  double most_seconds = 0;                                 // that its runs may take
  std::function<double(const Reference&)> smallest_error;  // m, of what is shown, against the reference as it stands
  Growth growth{};                                         // of a difference of the start
};

// For particles that are joined: the closed form where the scene has one; else scheme fourth_order in float64, with sub-steps
// halved while that moves it, until the horizon, by more than a hundredth of the smallest error, is affordable and helps. The
// horizon is where a difference of the start has grown too much; where the reference is then still in doubt, it is the last
// sample time until which it is not. Where setup.end comes first, the path has the sample times that were reached.
[[nodiscard]] Reference joined_reference(const SceneFile& file, const Grid& grid, const Picks& picks, const Fineness& fineness,
                                         const Setup& setup);

// A run by the reference's scheme, with sub-steps that it chooses by itself.
[[nodiscard]] Trace reference_trace(const SceneFile& file, const Grid& grid, const Picks& picks, const Nudge& nudge,
                                    const Setup& setup);

// The distance of each particle from its own mean position over the first `times` of the path, root mean square; m.
[[nodiscard]] double amplitude_of(const Path& path, std::size_t times);

// Root mean square over particles and times, or the first `times` of them, which are at least one; m.
[[nodiscard]] double distance(const Path& a, const Path& b);
[[nodiscard]] double distance(const Path& a, const Path& b, std::size_t times);

// Whether nothing in the scene takes or gives energy.
[[nodiscard]] bool keeps_energy(const Scene& scene);

}  // namespace dvdx::tool::report
