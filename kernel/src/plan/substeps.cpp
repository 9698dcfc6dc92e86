#include "plan/substeps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <variant>

#include "constraint/constraints.hpp"
#include "dvdx/partition.hpp"
#include "math/vec3.hpp"
#include "meet/meet_rules.hpp"
#include "motion/pose_track.hpp"
#include "plan/validate.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"
#include "springs/network_rates.hpp"
#include "stability/scheme_choice.hpp"

namespace dvdx {
namespace {

// The margin between the start's frequency and the limit: springs turn, and their frequency changes with them.
constexpr double start_margin = 1 / 0.93;

struct Limited {
  NetworkLimit limit;
  LimitedBy by = LimitedBy::frequency;
};

// A sheet that hangs free reaches its bound only if it folds onto a line. Between the start's limit and the bound it is left
// to its user. Sheets that land and other springs are refused there (curtain and net-stiff blew up between the two).
Limited limit_of(const SubstepRule& rule, const Frequencies& frequencies, double h, int substeps, bool hangs_free) {
  Limited found;
  NetworkLimit& limit = found.limit;
  limit.substeps = substeps;
  limit.frequency = frequencies.start;
  limit.bound = frequencies.bound;
  limit.particle = frequencies.particle;
  limit.damping = frequencies.damping;
  limit.limit = rule.stable.frequency;
  limit.damping_limit = rule.stable.damping;
  if (rule.is_alone) return found;
  HighestRates rates{frequencies.bound, frequencies.damping};
  limit.safe = substeps_for(rule.stable, h, rates);
  limit.fewest = limit.safe;
  // K and C scale alike with position. K's margin is the square of the frequency's, and so is that of M^-1 C.
  const HighestRates at_start{frequencies.start * start_margin, frequencies.damping_start * start_margin * start_margin};
  if (hangs_free && substeps_for(rule.stable, h, at_start) < limit.safe) {
    limit.fewest = substeps_for(rule.stable, h, at_start);
    rates = at_start;
  }
  found.by = limited_by(rule.stable, h, rates);
  return found;
}

// rad/s, of the surfaces that follow a motion.
double fastest_turn_of(const Scene& scene) {
  double turn = 0;
  for (const Contact& contact : scene.contacts) {
    if (const auto& motion = motion_of(contact)) turn = std::max(turn, PoseTrack(scene.motions[*motion]).fastest_turn());
  }
  return turn;
}

int substeps_of_turn(double turn) { return static_cast<int>(std::clamp(std::ceil(turn / most_turn), 1.0, 1e6)); }

// fewest: lower limit if the scene leaves the number open.
Substeps substeps_of(const Coupling& coupling, const SubstepRule& rule, double h, const HighestRates& rates, int fewest) {
  if (rule.is_alone) return {.substeps = coupling.substeps.value_or(fewest)};
  Substeps found;
  found.substeps = coupling.substeps ? *coupling.substeps : std::max(fewest, substeps_for(rule.energy_bounded, h, rates));
  found.longest = h / found.substeps;
  if (is_generalized_alpha(coupling)) found.rho = rho_of(rates.frequency, std::abs(found.longest), Pace::even);
  found.is_safe = found.substeps >= substeps_for(rule.stable, h, rates);
  return found;
}

// s: the longest sub-step of sweeps that choose their number, for even steps or for those that vary.
double longest_of_sweeps(const Coupling& coupling, double frequency, Pace pace) noexcept {
  if (!leaves_substeps_open(coupling) || !coupling.longest_substep) return std::numeric_limits<double>::infinity();
  const bool varies = pace == Pace::uneven && is_generalized_alpha(coupling);
  return varies ? as_stiff_where_uneven(*coupling.longest_substep, frequency) : *coupling.longest_substep;
}

// Takes enough sub-steps that none is longer than those of the longest step, which `longest` has. A plan of more than
// most_substeps is refused.
Substeps cut(Substeps found, double h, const Substeps& longest) {
  found.substeps = std::max(found.substeps, substeps_within(longest.longest, h));
  found.longest = std::copysign(longest.longest, h);
  found.pace = Pace::uneven;
  return found;
}

}  // namespace

Options with_other_step(const Options& options, double step) {
  Options other = options;
  other.step = step;
  const bool is_other = options.step != 0 && step != 0 && std::abs(step) != std::abs(options.step);
  if (is_other && !options.longest_step) other.longest_step = std::abs(options.step);
  return other;
}

SubstepRule::SubstepRule(const Coupling& coupling, bool is_isolated)
    : is_alone(coupling.scheme == Scheme::accumulate && is_isolated),
      stable(is_alone ? StableRange{} : scheme_limit(coupling)),
      energy_bounded(is_alone ? StableRange{} : bounded_energy_limit(coupling)) {}

SubstepChoice::SubstepChoice(const Scene& scene, const Options& options, std::span<const Vec3> start,
                             std::shared_ptr<const Topology> topology_)
    : coupling(scene.coupling),
      step(options.step),
      longest_step(options.longest_step),
      w_of(inverse_masses(scene, start.size())),
      topology(std::move(topology_)),
      rho_of_whole_(options.elsewhere.rho),
      fastest_turn_(fastest_turn_of(scene)),
      rods_rate_(scene.constraints.empty() ? 0 : swept_rods_rate(scene, start, w_of)),
      rods_frequency_(std::sqrt(length(constant_acceleration(scene)) * rods_rate_)),
      meeting_rate_(meeting_rate(scene, start)) {}

// Uses sums if they determine the number of sub-steps, and eigenvalues only if these may save some.
void SubstepChoice::choose(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const Vec3> start,
                           const SubstepChoice* kept, Changed changed, std::optional<SweptNet>& net) {
  const auto by = [&](const HighestRates& highest) { return substeps_by(highest); };
  const bool has_rule = kept != nullptr && coupling.scheme != Scheme::accumulate;
  rule = has_rule ? kept->rule : SubstepRule(coupling, are_isolated(pairs, w_of));
  if (kept != nullptr && changed == Changed::step) {
    rates = kept->rates;
    found_ = kept->found_;
  } else {
    rates = are_grids(scene) ? NetworkRates(scene, w_of).bounds() : rate_bounds(pairs, w_of);
  }
  rates = seen(rates);
  if (by(rates.least) != by(rates.most)) rates.least = rates.most = highest_rates(pairs, w_of);
  if (!scene.networks.empty() && leaves_substeps_open(coupling) && !coupling.longest_substep) {
    net.emplace(pairs.empty() ? swept_net(scene, start) : SweptNet(scene, pairs, w_of, start, topology->walk()));
    coupling.longest_substep = net->longest_substep(coupling, rates.most);
  }
  chosen = by(rates.most);
}

Substeps SubstepChoice::substeps_by(const HighestRates& highest, double h, std::optional<double> longest) const noexcept {
  const auto at = [&](double step_) {
    const double of_sweeps = longest_of_sweeps(coupling, highest.frequency, longest ? Pace::uneven : Pace::even);
    const int fewest = std::max({substeps_of_turn(fastest_turn_ * std::abs(step_)), substeps_within(of_sweeps, step_),
                                 substeps_of_rods(rods_frequency_, step_), substeps_of_meetings(meeting_rate_, step_)});
    return substeps_of(coupling, rule, step_, highest, fewest);
  };
  Substeps found = at(h);
  if (coupling.scheme == Scheme::sequential && longest) {
    found = cut(found, h, at(*longest));
    if (is_generalized_alpha(coupling)) found.rho = rho_of(highest.frequency, std::abs(found.longest), found.pace);
  }
  if (is_generalized_alpha(coupling)) found.rho = rho_of_whole_.value_or(found.rho);
  return found;
}

double SubstepChoice::step_within_limit(const Options& options) const noexcept {
  const auto is_within = [&](double h) {
    return substeps_by(rates.most, h, options.longest_step).substeps <= coupling.most_substeps.value_or(most_substeps);
  };
  if (!coupling.most_substeps || is_within(options.step)) return options.step;
  double within = 0;
  double beyond = options.step;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = within + (beyond - within) / 2;
    (is_within(middle) ? within : beyond) = middle;
  }
  return within;
}

// Sweeps are stable at any rate, so eigenvalues save no sub-step. Their rho is that of the sums.
RateBounds SubstepChoice::seen(RateBounds bounds) const noexcept {
  if (coupling.scheme == Scheme::sequential) bounds.least = bounds.most;
  return bounds;
}

// Returns false as well if sums do not determine the number of sub-steps: no eigenvalues are computed here.
bool SubstepChoice::keeps_substeps(const RateBounds& bounds) const noexcept {
  Substeps least = substeps_by(bounds.least);
  Substeps most = substeps_by(bounds.most);
  if (may_take_rho_) least.rho = most.rho = chosen.rho;
  return least == chosen && most == chosen;
}

std::optional<Substeps> SubstepChoice::take(const RateBounds& bounds) noexcept {
  found_.reset();
  rates = bounds;
  const Substeps now = substeps_by(rates.most);
  if (now == chosen) return std::nullopt;
  return std::exchange(chosen, now);
}

double SubstepChoice::turning(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net) const {
  const double longest = std::abs(chosen.longest);
  if (net) return net->turning(coupling, longest);
  if (!is_stack()) return swept_net(scene, start).turning(coupling, longest);
  double most = 0;
  for (const Network& sheet : scene.networks) {  // one by one: a tenth of the time that their springs take together
    most = std::max(most, SweptNet(scene, std::get<Grid>(sheet)).turning(coupling, longest));
  }
  return most;
}

SweptNet SubstepChoice::swept_net(const Scene& scene, std::span<const Vec3> start) const {
  const Grid* const sheet = topology->one_grid(scene);
  return sheet != nullptr ? SweptNet(scene, *sheet)
                          : SweptNet(scene, joined_pairs(scene, start), w_of, start, topology->walk());
}

bool SubstepChoice::are_grids(const Scene& scene) const { return is_stack() || topology->one_grid(scene) != nullptr; }
bool SubstepChoice::hangs_free(const Scene& scene) const {
  return topology->one_grid(scene) != nullptr && scene.contacts.empty();
}

Frequencies SubstepChoice::find(const Scene& scene, std::span<const Vec3> start) const {
  std::optional<HighestRates> of_grids;
  if (are_grids(scene)) of_grids = NetworkRates(scene, w_of).bounds().most;
  return frequencies(joined_pairs(scene, start), of_grids, w_of, start);
}

NetworkLimit SubstepChoice::limit_of_springs(const Scene& scene, std::span<const Vec3> start) const {
  const Frequencies of = found_ ? *found_ : find(scene, start);
  NetworkLimit limit = limit_of(rule, of, step, chosen.substeps, hangs_free(scene)).limit;
  limit.rho = chosen.rho;
  limit.scheme = coupling.scheme;
  if (coupling.scheme == Scheme::sequential) {
    const SubstepLength length{.taken = std::abs(substep()), .longest = std::abs(chosen.longest), .pace = chosen.pace};
    limit.estimate = swept_net(scene, start).estimate(coupling, rates.most.frequency, length);
  }
  return limit;
}

std::optional<Error> SubstepChoice::refusal(const Scene& scene, std::span<const Vec3> start, Unstable unstable) {
  const std::string field = "coupling.substeps";
  const auto limited = [&] {
    if (!found_) found_ = find(scene, start);
    return limit_of(rule, *found_, step, chosen.substeps, hangs_free(scene));
  };
  if (chosen.substeps > most_substeps && chosen.pace == Pace::uneven && std::abs(step) > *longest_step) {
    const double longest = std::abs(chosen.longest);
    return Error{"step", text(step, 6),
                 "at most " + text(most_substeps * longest, 4) + " s: " + std::to_string(most_substeps) + " sub-steps of " +
                     text(longest, 4) + " s, those of a longest step of " + text(*longest_step, 4) + " s"};
  }
  if (chosen.substeps > most_substeps) {
    return Error{field, std::to_string(limited().limit.safe),
                 "at most " + std::to_string(most_substeps) + ": a smaller step, less stiffness, or scheme sequential"};
  }
  if (coupling.most_substeps && chosen.substeps > *coupling.most_substeps) {
    const double within = step_within_limit({.step = step, .longest_step = longest_step});
    return Error{"coupling.most_substeps", std::to_string(*coupling.most_substeps),
                 "at least " + std::to_string(chosen.substeps) + " for a step of " + text(step, 6) +
                     " s, or a step of at most " + text(within, 4) + " s"};
  }
  if (chosen.is_safe || unstable == Unstable::allowed) return std::nullopt;
  const auto [limit, by] = limited();
  if (limit.substeps >= limit.fewest) return std::nullopt;
  return Error{field, std::to_string(limit.substeps),
               "at least " + std::to_string(limit.fewest) + " for this scheme, or the springs are unstable by their " +
                   (by == LimitedBy::damping ? "damping" : "frequency") + " (" + std::to_string(limit.safe) +
                   " are stable in any position); scheme sequential takes any"};
}

std::optional<NetworkLimit> limit_of_sheet(const Scene& scene, double step, const SheetRates& all) {
  const Grid* const sheet = sheet_of(scene);
  if (sheet == nullptr) return std::nullopt;
  const HighestRates highest = rates_of(*sheet, all);
  Coupling coupling = scene.coupling;
  std::optional<SweptNet> net;
  if (coupling.scheme == Scheme::sequential || coupling.scheme == Scheme::automatic) net.emplace(scene, *sheet);
  std::optional<SchemeChoice> choice;
  if (coupling.scheme == Scheme::automatic) {
    const Joined joined{sheet->rows * sheet->columns, count_springs(*sheet), SpringsLie::as_sheet, SpringsLie::as_sheet,
                        sheet->damping != 0};
    choice = take_scheme(coupling, step, highest, *net, joined);
  }
  const SubstepRule rule(coupling, false);
  const bool is_sequential = coupling.scheme == Scheme::sequential;
  int fewest = substeps_of_turn(fastest_turn_of(scene) * std::abs(step));
  if (leaves_substeps_open(coupling)) {
    if (!coupling.longest_substep) coupling.longest_substep = net->longest_substep(coupling, highest);
    fewest = std::max(fewest, substeps_within(*coupling.longest_substep, step));
  }
  const Substeps chosen = substeps_of(coupling, rule, step, highest, fewest);
  if (!chosen.is_safe || chosen.substeps > most_substeps) return std::nullopt;
  const Frequencies bound{.start = highest.frequency, .bound = highest.frequency, .damping = highest.damping};
  NetworkLimit limit = limit_of(rule, bound, step, chosen.substeps, false).limit;
  limit.rho = chosen.rho;
  limit.scheme = coupling.scheme;
  if (is_sequential) limit.estimate = net->estimate(coupling, highest.frequency, even(std::abs(step) / chosen.substeps));
  limit.choice = choice;
  return limit;
}

}  // namespace dvdx
