// The reference that a scene's runs are compared with.
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
  Picks picks;  // the particles of the path
  Path path;
  std::size_t horizon = 0;     // sample times up to which positions are compared, including the start
  std::vector<double> energy;  // J, at every sample time
  double amplitude = 0;        // m, until the horizon
  double whole_amplitude = 0;  // m, of the whole run
  double energy_scale = 0;     // J: the largest kinetic energy
  bool keeps_energy = false;
};

// The closed form if the scene has one, for the whole run or from impact to impact. Otherwise method combined in float64 with
// steps far below the smallest of the grid.
[[nodiscard]] Reference first_reference(const SceneFile& sample, const Grid& grid, const Setup& setup);

// Halves the step of an extrapolated reference until halving moves it by less than a hundredth of `smallest_error` (m), or
// until the work is too large. Records which of the two ended it. Returns true if the path changed.
bool refine(Reference& reference, const SceneFile& sample, const Grid& grid, const Setup& setup, double smallest_error,
            Effort effort);

// The required accuracy of a stepped reference of joined particles.
struct Fineness {
  int substeps = 1;                                        // in the coarsest step, at the start
  double most_seconds = 0;                                 // limit of its runs
  std::function<double(const Reference&)> smallest_error;  // m, of the runs shown, relative to the present reference
  Growth growth{};                                         // growth of a difference of the start
};

// The reference of joined particles: the closed form if the scene has one, otherwise scheme fourth_order in float64. Its
// sub-steps are halved while that moves it by more than a hundredth of the smallest error, is affordable, and helps. The
// horizon ends when a difference of the start has grown too much, or at the last sample time at which the reference is not in
// doubt. If setup.end comes first, the path has the sample times reached.
[[nodiscard]] Reference joined_reference(const SceneFile& file, const Grid& grid, const Picks& picks, const Fineness& fineness,
                                         const Setup& setup);

// A run by the reference's scheme, with the sub-steps that it chooses.
[[nodiscard]] Trace reference_trace(const SceneFile& file, const Grid& grid, const Picks& picks, const Nudge& nudge,
                                    const Setup& setup);

// The distance of each particle from its own mean position over the first `times` sample times of the path, root mean square;
// m.
[[nodiscard]] double amplitude_of(const Path& path, std::size_t times);

// Root mean square over particles and all times, or the first `times` of them (at least one); m.
[[nodiscard]] double distance(const Path& a, const Path& b);
[[nodiscard]] double distance(const Path& a, const Path& b, std::size_t times);

// Returns true if nothing in the scene takes or gives energy.
[[nodiscard]] bool keeps_energy(const Scene& scene);

}  // namespace dvdx::tool::report
