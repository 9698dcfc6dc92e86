#include "stability/scheme_choice.hpp"

#include <algorithm>

#include "scene/particle_values.hpp"
#include "springs/network_forms.hpp"
#include "topology/topology.hpp"

namespace dvdx {
namespace {

// The cost in ns of a particle's and of a spring's sub-step. docs/stability.md tells how it was measured: on one machine, once,
// so that the same scene is stepped alike on all.
struct Cost {
  double particle = 0, spring = 0;
};
struct Costs {
  Cost of_sheet, of_list;
  [[nodiscard]] const Cost& of(SpringsLie lie) const noexcept { return lie == SpringsLie::as_sheet ? of_sheet : of_list; }
};
constexpr double times_of_lines = 3;
constexpr Costs leapfrog_costs{.of_sheet = {1.5, 1.5}, .of_list = {4.5, 1.7}};
constexpr Costs sequential_costs{.of_sheet = {6, 3.5}, .of_list = {3, 10}};

// ns a sub-step.
double cost(const Cost& of, const Joined& joined, std::size_t passes) {
  return of.particle * static_cast<double>(joined.particles) + of.spring * static_cast<double>(passes * joined.springs);
}

bool has_zero_length(const Network& network) {
  const auto* springs = std::get_if<Springs>(&network);
  return springs != nullptr && springs->zero_length != Scalars(0.0);
}

}  // namespace

SchemeChoice take_scheme(Coupling& coupling, double step, const HighestRates& rates, const SweptNet& net,
                         const Joined& joined) {
  const auto by = [&](Scheme scheme) {
    Coupling other = coupling;
    other.scheme = scheme;
    return other;
  };
  SchemeChoice choice;
  const int safe = substeps_for(scheme_limit(by(Scheme::leapfrog)), step, rates);
  choice.leapfrog = coupling.substeps.value_or(substeps_for(bounded_energy_limit(by(Scheme::leapfrog)), step, rates));
  const double longest = coupling.longest_substep.value_or(net.longest_substep(by(Scheme::sequential), rates));
  const int fewest = net.drapes() ? choice.leapfrog : 1;  // the error of a draped net is not known
  choice.sequential = coupling.substeps.value_or(std::max(fewest, substeps_within(longest, step)));
  const std::size_t passes = 1 + (joined.is_damped ? damping_passes(by(Scheme::leapfrog)) : 0);
  choice.leapfrog_cost = cost(leapfrog_costs.of(joined.lie), joined, passes) * choice.leapfrog;
  const double times = solves_lines(by(Scheme::sequential), net.springs_are()) ? times_of_lines : 1;
  choice.sequential_cost = times * cost(sequential_costs.of(joined.swept), joined, 1) * choice.sequential;
  // If the coupling asks for a number of sub-steps, it gets sweeps where these are too few for leapfrog.
  const bool is_beyond = coupling.most_substeps && choice.leapfrog > *coupling.most_substeps;
  const bool sweeps =
      coupling.substeps ? *coupling.substeps < safe : is_beyond || choice.sequential_cost < choice.leapfrog_cost;
  choice.scheme = coupling.scheme = sweeps ? Scheme::sequential : Scheme::leapfrog;
  if (leaves_substeps_open(coupling)) coupling.longest_substep = longest;
  return choice;
}

SchemeChoice take_scheme(Scene& scene, double step, std::span<const Vec3> start) {
  if (scene.networks.empty() || std::any_of(scene.networks.begin(), scene.networks.end(), has_zero_length)) {
    scene.coupling.scheme = Scheme::leapfrog;
    return {};
  }
  const std::vector<double> w = inverse_masses(scene, start.size());
  if (const Grid* sheet = only_grid(scene, start.size())) {
    const Joined joined{.particles = start.size(),
                        .springs = count_springs(*sheet),
                        .lie = SpringsLie::as_sheet,
                        .swept = SpringsLie::as_sheet,
                        .is_damped = sheet->damping != 0};
    return take_scheme(scene.coupling, step, rate_bounds(GridRates(*sheet, w)).most, SweptNet(scene, *sheet), joined);
  }
  const std::vector<JoinedPair> pairs = joined_pairs(scene, start);
  Joined joined{.particles = start.size(), .springs = pairs.size(), .is_damped = is_any_damped(pairs)};
  const Walk swept = swept_walk(scene, pairs, start.size());
  if (swept == Walk::stack) joined.lie = SpringsLie::as_sheet;
  if (swept != Walk::pieces) joined.swept = SpringsLie::as_sheet;
  return take_scheme(scene.coupling, step, rate_bounds(pairs, w).most, SweptNet(scene, pairs, w, start, swept), joined);
}

}  // namespace dvdx
