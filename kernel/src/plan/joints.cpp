#include "plan/joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "math/vec3.hpp"
#include "motion/pose_track.hpp"
#include "plan/undo.hpp"
#include "plan/validate.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "stability/scheme_choice.hpp"

namespace dvdx {
namespace {

// Springs turn, and their frequency changes with them: the margin between the start's frequency and the limit.
constexpr double start_margin = 1 / 0.93;

struct Limited {
  NetworkLimit limit;
  LimitedBy by = LimitedBy::frequency;
};

// A sheet that hangs free reaches its bound only where it folds onto a line, and is left to its user below that; sheets that
// land and other springs are not (curtain and net-stiff blew up between the two).
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
  // K and C scale alike with position: K's margin is the square of the frequency's, and so it is of M^-1 C.
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

// fewest: lower limit where the scene leaves the number open.
Substeps substeps_of(const Coupling& coupling, const SubstepRule& rule, double h, const HighestRates& rates, int fewest) {
  if (rule.is_alone) return {.substeps = coupling.substeps.value_or(fewest)};
  Substeps found;
  found.substeps = coupling.substeps ? *coupling.substeps : std::max(fewest, substeps_for(rule.calm, h, rates));
  found.longest = h / found.substeps;
  if (is_generalized_alpha(coupling)) found.rho = rho_of(rates.frequency, std::abs(found.longest), Pace::even);
  found.is_safe = found.substeps >= substeps_for(rule.stable, h, rates);
  return found;
}

// s, of the even steps or of those that vary: no sub-step of sweeps that chooses their number is longer.
double longest_of_sweeps(const Coupling& coupling, double frequency, Pace pace) noexcept {
  if (!leaves_substeps_open(coupling) || !coupling.longest_substep) return std::numeric_limits<double>::infinity();
  const bool varies = pace == Pace::uneven && is_generalized_alpha(coupling);
  return varies ? as_stiff_where_uneven(*coupling.longest_substep, frequency) : *coupling.longest_substep;
}

// As many as make no sub-step longer than those of the longest step, which `longest` has: a plan of more than most_substeps is
// refused.
Substeps cut(Substeps found, double h, const Substeps& longest) {
  found.substeps = std::max(found.substeps, substeps_within(longest.longest, h));
  found.longest = std::copysign(longest.longest, h);
  found.pace = Pace::uneven;
  return found;
}

HighestRates higher(const HighestRates& a, const HighestRates& b) noexcept {
  return {std::max(a.frequency, b.frequency), std::max(a.damping, b.damping)};
}

// The bounds of a scene whose networks are grids that have no particle in common.
RateBounds rate_bounds_of_grids(const Scene& scene, std::span<const double> w) {
  HighestRates most;
  for (const Network& network : scene.networks) {
    const auto& grid = std::get<Grid>(network);
    most = higher(most, rate_bounds(GridRates(grid, w.subspan(grid.first, grid.rows * grid.columns))).most);
  }
  return {most, most};
}

std::size_t count_grid_springs(const Scene& scene) {
  std::size_t count = 0;
  for (const Network& network : scene.networks) count += count_springs(std::get<Grid>(network));
  return count;
}

// A sum of pairs' own contributions takes other coefficients than a pulse; the filtered pulse is one.
bool sums_pairs(const Coupling& coupling) {
  return coupling.scheme == Scheme::accumulate && coupling.method != Method::combined;
}

template <class T>
std::size_t bytes_of_form(const GridForm<T>& /*form*/) {
  return 0;
}
template <class T>
std::size_t bytes_of_form(const GraphForm<T>& form) {
  std::size_t bytes = 0;
  for (const SlotLists* lists : {&form.lists, &form.damped_lists}) {
    bytes += bytes_of(lists->first_slot) + bytes_of(lists->slots) + bytes_of(lists->indices);
  }
  return bytes;
}
template <class T>
std::size_t bytes_of_form(const StrandsForm<T>& form) {
  return bytes_of(form.strands) + bytes_of(form.families) + bytes_of(form.families_of_start) + bytes_of(form.bands) +
         bytes_of(form.spring_at) + form.lines.bytes();
}
template <class T>
std::size_t bytes_of_form(const ColoursForm<T>& form) {
  return bytes_of(form.a) + bytes_of(form.b) + bytes_of(form.coefficients_of) + bytes_of(form.coefficients_of_start) +
         bytes_of(form.ranges) + bytes_of(form.stand) + bytes_of(form.spring_at) + bytes_of(form.tasks) +
         bytes_of(form.stages) + form.lines.bytes();
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
      calm(is_alone ? StableRange{} : calm_limit(coupling)) {}

template <class T>
Joints<T>::Joints(const Scene& scene, const Options& options, std::span<const Vec3> start)
    : Joints(scene, options, start, nullptr, Changed::springs,
             JoinedScene(scene, start, constrained_pairs(scene), options.elsewhere)) {}

template <class T>
Joints<T>::Joints(const Scene& scene, const Options& options, std::span<const Vec3> start, const Joints& kept, Changed changed)
    : Joints(scene, options, start, &kept, changed,
             JoinedScene(scene, start, constrained_pairs(scene), options.elsewhere, kept.topology)) {}

template <class T>
Joints<T>::Joints(const Scene& scene, const Options& options, std::span<const Vec3> start, const Joints* kept, Changed changed,
                  const JoinedScene& joined)
    : coupling(scene.coupling),
      step(options.step),
      longest_step(options.longest_step),
      w_of(inverse_masses(scene, start.size())),
      splitting(!scene.networks.empty() ? dvdx::splitting(coupling) : Splitting{.a = {1.0}, .b = {}, .beta = {}}),
      topology(joined.topology),
      order(topology->order()),
      is_stack_(topology->walk() == Walk::stack),
      list_sheet_(topology->list_sheet()),
      memory_(options.memory),
      columns_(options.memory) {
  const Grid* const grid = joined.stepped.get();
  const std::vector<JoinedPair>& pairs = joined.pairs;
  springs = grid != nullptr ? count_grid_springs(scene) : pairs.size();
  is_damped_ = grid != nullptr ? grid->damping != 0 && springs != 0 : is_any_damped(pairs);
  is_damped_ = is_damped_ || options.elsewhere.springs_damp;
  rho_of_whole_ = options.elsewhere.rho;
  if (coupling.scheme == Scheme::sequential) sweeps_ = options.elsewhere.sweeps;
  closes_in_whole_ = options.elsewhere.closes_substeps;
  std::optional<SweptNet> net;
  choose(scene, pairs, start, kept, changed, net);
  if (is_generalized_alpha(coupling)) order_fingerprint = order.fingerprint();
  make_fixed(scene, start);
  make_inverse_masses();
  make_form(pairs, start, joined.stepped);
  choose_line_forces(scene, start, net);
  make_telling_order(options.elsewhere.exchange);
  if (meets_air(scene)) air = std::make_unique<Air<T>>(scene, grid, w_of, order, options.memory);
  auto kept_in = std::make_unique<Balls<T>>(scene, start, w_of, order, options.memory);
  if (kept_in->count() != 0) balls = std::move(kept_in);
  const SharedMeetings& all = options.elsewhere.meetings;
  if (scene.meet) {
    meet = all.whole != nullptr ? std::make_unique<MeetRules<T>>(*all.whole, all.start)
                                : std::make_unique<MeetRules<T>>(scene, start);
  }
  has_tethers_ = !scene.tethers.empty();
  if (!scene.constraints.empty()) constraints.emplace(scene, start, w_of, order, substep(), options.memory);
}

// By sums where they tell the number of sub-steps, by eigenvalues only where these would save some.
template <class T>
void Joints<T>::choose(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const Vec3> start, const Joints* kept,
                       Changed changed, std::optional<SweptNet>& net) {
  const bool is_grid = is_stack_ || topology->one_grid(scene) != nullptr;
  fastest_turn_ = fastest_turn_of(scene);
  meeting_rate_ = meeting_rate(scene, start);
  rods_rate_ = scene.constraints.empty() ? 0 : swept_rods_rate(scene, start, w_of);
  rods_frequency_ = std::sqrt(length(constant_acceleration(scene)) * rods_rate_);
  const auto by = [&](const HighestRates& highest) { return substeps_by(highest); };
  const bool has_rule = kept != nullptr && coupling.scheme != Scheme::accumulate;
  rule = has_rule ? kept->rule : SubstepRule(coupling, are_isolated(pairs, w_of));
  if (kept != nullptr && changed == Changed::step) {
    rates = kept->rates;
    found_ = kept->found_;
  } else {
    rates = is_grid ? rate_bounds_of_grids(scene, w_of) : rate_bounds(pairs, w_of);
  }
  // Sweeps are stable at any rate, and no sub-step is saved: their rho is that of the sums.
  if (coupling.scheme == Scheme::sequential) rates.least = rates.most;
  if (by(rates.least) != by(rates.most)) rates.least = rates.most = highest_rates(pairs, w_of);
  if (!scene.networks.empty() && leaves_substeps_open(coupling) && !coupling.longest_substep) {
    net.emplace(pairs.empty() ? swept_net(scene, start) : SweptNet(scene, pairs, w_of, start));
    coupling.longest_substep = net->longest_substep(coupling, rates.most);
  }
  chosen = by(rates.most);
}

// net: that of the scene, if it has been made.
template <class T>
void Joints<T>::choose_line_forces(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net) {
  auto* const strands = std::get_if<StrandsForm<T>>(&form);
  if (strands == nullptr || strands->lines.empty()) return;
  if (!coupling.line_forces) coupling.line_forces = line_forces(turning(scene, start, net));
  strands->lines.forces = *coupling.line_forces;
}

template <class T>
double Joints<T>::turning(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net) const {
  const double longest = std::abs(chosen.longest);
  if (net) return net->turning(coupling, longest);
  if (!is_stack_) return swept_net(scene, start).turning(coupling, longest);
  double most = 0;
  for (const Network& sheet : scene.networks) {  // one by one: a tenth of the time that their springs take together
    most = std::max(most, SweptNet(scene, std::get<Grid>(sheet)).turning(coupling, longest));
  }
  return most;
}

template <class T>
SweptNet Joints<T>::swept_net(const Scene& scene, std::span<const Vec3> start) const {
  const Grid* const sheet = topology->one_grid(scene);
  return sheet != nullptr ? SweptNet(scene, *sheet) : SweptNet(scene, joined_pairs(scene, start), w_of, start);
}

template <class T>
Frequencies Joints<T>::find(const Scene& scene, std::span<const Vec3> start) const {
  std::optional<HighestRates> of_grids;
  if (is_stack_ || topology->one_grid(scene) != nullptr) of_grids = rate_bounds_of_grids(scene, w_of).most;
  return frequencies(joined_pairs(scene, start), of_grids, w_of, start);
}

namespace {

bool hangs_free(const Scene& scene, const Topology& topology) {
  return topology.one_grid(scene) != nullptr && scene.contacts.empty();
}

}  // namespace

template <class T>
NetworkLimit Joints<T>::limit(const Scene& scene, std::span<const Vec3> start) const {
  const Frequencies of = found_ ? *found_ : find(scene, start);
  NetworkLimit limit = limit_of(rule, of, step, chosen.substeps, hangs_free(scene, *topology)).limit;
  limit.rho = chosen.rho;
  limit.scheme = coupling.scheme;
  if (coupling.scheme == Scheme::sequential) {
    const SubstepLength length{.taken = std::abs(substep()), .longest = std::abs(chosen.longest), .pace = chosen.pace};
    limit.estimate = swept_net(scene, start).estimate(coupling, rates.most.frequency, length);
    const auto* const strands = std::get_if<StrandsForm<T>>(&form);
    const bool stays = strands != nullptr && strands->lines.forces == LineForces::stay;
    const bool has_changed = stays && line_forces(limit.estimate.turning) != LineForces::stay;
    if (has_changed) limit.estimate.most_turning = most_turning_that_stays;
  }
  return limit;
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

template <class T>
void Joints<T>::make_fixed(const Scene& scene, std::span<const Vec3> start) {
  for (const std::size_t i : scene.fixed) fixed.push_back({.particle = static_cast<std::uint32_t>(i), .element = order.of[i]});
  const Vec3& origin = scene.origin.at(0);
  for (std::size_t group = 0; group < scene.kinematic.size(); ++group) {
    const Kinematic& followers = scene.kinematic[group];
    for (std::size_t k = 0; k < followers.particles.size(); ++k) {
      const std::size_t i = followers.particles[k];
      const Vec3& x = start[i];
      fixed.push_back({.particle = static_cast<std::uint32_t>(i),
                       .element = order.of[i],
                       .motion = static_cast<std::uint32_t>(followers.motion),
                       .group = static_cast<std::uint32_t>(group),
                       .index = static_cast<std::uint32_t>(k),
                       .place = {x[0] + origin[0], x[1] + origin[1], x[2] + origin[2]}});
    }
  }
  std::sort(fixed.begin(), fixed.end(), [](const FixedParticle& a, const FixedParticle& b) { return a.element < b.element; });
}

template <class T>
void Joints<T>::make_inverse_masses() {
  T* const column = columns_.add(order.size, T(0), column_margin);
  for (std::size_t i = 0; i < particles(); ++i) column[order.of[i]] = static_cast<T>(w_of[i]);
  w = column;
}

template <class T>
void Joints<T>::make_form(std::span<const JoinedPair> pairs, std::span<const Vec3> start, const SteppedGrid& stepped) {
  const Grid* const grid = stepped.get();
  NetworkInput in = input(pairs);
  in.start = start;
  const bool is_sequential = coupling.scheme == Scheme::sequential;
  if (grid != nullptr && is_sequential) {
    form = make_strands_form<T>(in, stepped.grid(), stepped.sheet_rows(), w, columns_);
  } else if (grid != nullptr) {
    form = make_grid_form<T>(in, *grid, columns_);
  } else if (list_sheet_) {
    form = make_strands_form<T>(in, *list_sheet_, columns_);
  } else if (is_sequential) {
    form = make_colours_form<T>(in, columns_);
  } else if (sums_pairs(coupling)) {
    form = make_pairs_form<T>(in, columns_);
  } else {
    form = make_graph_form<T>(in, columns_);
  }
}

template <class T>
void Joints<T>::make_telling_order(const Exchange& exchange) {
  if (exchange.start == nullptr) return;
  if (std::holds_alternative<ColoursForm<T>>(form)) {
    for (const std::uint32_t element : order.of) telling.records.push_back(static_cast<std::uint32_t>(record * element));
  }
  const auto* const grid = std::get_if<GridForm<T>>(&form);
  const std::size_t unit = grid != nullptr ? grid->terms.pitch : slice;  // particles
  std::vector<std::uint8_t> is_told(grid != nullptr ? grid->terms.rows : order.size / slice, exchange.is_told == nullptr);
  for (std::size_t i = 0; i < particles() && exchange.is_told != nullptr; ++i) {
    if (exchange.is_told[i] != 0) is_told[order.of[i] / unit] = 1;
  }
  const std::size_t most = std::max<std::size_t>(1, particles_per_task / unit);
  for (std::size_t n = 0; n < is_told.size(); ++n) {
    std::vector<UnitRange>& ranges = is_told[n] != 0 ? telling.told : telling.inside;
    if (ranges.empty() || ranges.back().to != n || n - ranges.back().from == most) ranges.push_back({n, n});
    ranges.back().to = n + 1;
  }
}

template <class T>
NetworkInput Joints<T>::input(std::span<const JoinedPair> pairs) const {
  const SubstepLength length{.taken = substep(), .longest = chosen.longest, .pace = chosen.pace};
  return {coupling, pairs, is_damped_, w_of, order, length, chosen.rho, sweeps_, {}};
}

template <class T>
StrandsForm<T>* Joints<T>::strands_of_list() noexcept {
  return list_sheet_ ? std::get_if<StrandsForm<T>>(&form) : nullptr;
}
template <class T>
bool Joints<T>::sweeps_list() const noexcept {
  return list_sheet_ || std::holds_alternative<ColoursForm<T>>(form);
}

template <class T>
bool Joints<T>::can_change_in_place() const noexcept {
  // Where fewer sub-steps than are safe were asked for, eigenvalues tell whether they still do.
  // Tethers lead along whole springs, to what is fixed.
  if (constraints || has_tethers_ || !chosen.is_safe) return false;
  if (std::holds_alternative<GraphForm<T>>(form)) return coupling.scheme != Scheme::accumulate;
  if (sweeps_list()) return sweeps_ == nullptr;
  if (air && !air->is_grid()) return false;
  return std::holds_alternative<GridForm<T>>(form) || std::holds_alternative<StrandsForm<T>>(form);
}

template <class T>
bool Joints<T>::can_change_step(const Options& options) const noexcept {
  const auto then = [&](const HighestRates& highest) { return substeps_by(highest, options.step, options.longest_step); };
  const bool is_graph = std::holds_alternative<GraphForm<T>>(form) && coupling.scheme != Scheme::accumulate;
  const bool is_list = is_graph || (sweeps_list() && sweeps_ == nullptr);
  if (constraints) return false;
  if (std::holds_alternative<StrandsForm<T>>(form) && !list_sheet_) {
    return is_generalized_alpha(coupling) && then(rates.most).solves_alike(chosen);
  }
  if (!(is_list || std::holds_alternative<GridForm<T>>(form))) return false;
  return then(rates.least) == then(rates.most);
}

template <class T>
void Joints<T>::reserve_step(const Scene& scene, std::span<const Vec3> start) {
  if (sweeps_list()) reserve_rates(scene, start);
}

template <class T>
void Joints<T>::change_step(const Options& options) noexcept {
  step = options.step;
  longest_step = options.longest_step;
  chosen = substeps_by(rates.most);
}

template <class T>
void Joints<T>::take_step(const Substeps& before) noexcept {
  const bool solves_alike = is_generalized_alpha(coupling) && chosen.solves_alike(before);
  if (auto* list = std::get_if<ColoursForm<T>>(&form)) {
    if (solves_alike) return set_scheme(*list, input({}));
    by_spring_->colours->set_scheme(*list, input({}));
  }
  if (auto* strands = std::get_if<StrandsForm<T>>(&form)) {
    if (solves_alike) return set_scheme(*strands, input({}));
    if (list_sheet_) by_spring_->strands->set_scheme(*strands, input({}));
  }
}

namespace {

// A scene that is stepped as a grid has one network, or some that are alike but for what is torn.
const Grid& grid_of(const Scene& scene) { return std::get<Grid>(scene.networks[0]); }

}  // namespace

template <class T>
void Joints<T>::reserve_rates(const Scene& scene, std::span<const Vec3> start) {
  auto* const colours = std::get_if<ColoursForm<T>>(&form);
  const auto* const graph = std::get_if<GraphForm<T>>(&form);
  const StrandsForm<T>* const strands = strands_of_list();
  if (colours == nullptr && graph == nullptr && strands == nullptr) {
    if (!by_row_.empty()) return;
    std::vector<GridRates> sheets;
    for (const Network& network : scene.networks) {
      const auto& grid = std::get<Grid>(network);
      sheets.emplace_back(grid, std::span(w_of).subspan(grid.first, grid.rows * grid.columns));
    }
    by_row_ = std::move(sheets);
  } else if (by_spring_ == nullptr) {
    const std::vector<JoinedPair> pairs = joined_pairs(scene, start);
    const NetworkInput in = input(pairs);
    auto made = std::make_unique<ListInPlace>(ListInPlace{ListRates(pairs, w_of), {}, {}, {}});
    if (graph != nullptr) made->lanes = lanes_of(*graph, in);
    if (colours != nullptr) made->colours.emplace(*colours, in, made->rates, memory_);
    if (strands != nullptr) made->strands.emplace(*strands, in, made->rates);
    by_spring_ = std::move(made);
    if (colours != nullptr) by_spring_->colours->take_over(*colours);
  }
}

template <class T>
Substeps Joints<T>::substeps_by(const HighestRates& highest, double h, std::optional<double> longest) const noexcept {
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

template <class T>
double Joints<T>::step_within_limit(const Options& options) const noexcept {
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

template <class T>
auto Joints<T>::sheet_of(std::size_t particle) const noexcept -> Sheet {
  const std::size_t each = particles() / by_row_.size();
  return {particle / each, particle / each * each, each};
}

template <class T>
std::span<const double> Joints<T>::w_of_sheet(std::size_t number) const noexcept {
  const std::size_t each = particles() / by_row_.size();
  return std::span(w_of).subspan(number * each, each);
}

template <class T>
RateBounds Joints<T>::rates_now() const noexcept {
  RateBounds bounds;
  if (by_spring_) {
    bounds = rate_bounds(by_spring_->rates);
    if (coupling.scheme == Scheme::sequential) bounds.least = bounds.most;  // as choose() has it
    return bounds;
  }
  for (const GridRates& sheet : by_row_) bounds.most = higher(bounds.most, rate_bounds(sheet).most);
  bounds.least = bounds.most;
  return bounds;
}

// Where sums do not tell the number of sub-steps, eigenvalues do, which are not looked for here. The rho of lists in sweeps may
// change.
template <class T>
bool Joints<T>::are_right(const RateBounds& bounds) const noexcept {
  Substeps least = substeps_by(bounds.least);
  Substeps most = substeps_by(bounds.most);
  if (sweeps_list()) least.rho = most.rho = chosen.rho;
  return least == chosen && most == chosen;
}

template <class T>
void Joints<T>::take(const RateBounds& bounds) noexcept {
  found_.reset();
  rates = bounds;
  const Substeps now = substeps_by(rates.most);
  if (now == chosen) return;
  const Substeps before = std::exchange(chosen, now);
  take_step(before);
}

template <class T>
bool Joints<T>::set_rates(std::size_t particle, double w_new) noexcept {
  const double before = std::exchange(w_of[particle], w_new);
  const auto look = [&] {
    if (by_spring_) return by_spring_->rates.set_mass(w_of, particle);
    const Sheet sheet = sheet_of(particle);
    by_row_[sheet.number].set_mass(w_of_sheet(sheet.number), particle - sheet.first);
  };
  look();
  const RateBounds bounds = rates_now();
  if (are_right(bounds)) {
    take(bounds);
    return true;
  }
  w_of[particle] = before;
  look();
  return false;
}

// Springs between fixed ends are left out of a graph and of colours, where others then have other colours. Strands hold them all.
template <class T>
bool Joints<T>::changes_left_out(std::size_t particle, double w_new) const noexcept {
  const auto& [rates_of, lanes, colours, strands] = *by_spring_;
  for (const std::uint32_t s : rates_of.springs_at(particle)) {
    if (lanes && lanes->of[s].a == SpringLanes::nowhere) return true;
    if (!colours) continue;
    if (colours->is_left_out(s) || (w_new == 0 && w_of[rates_of.other_end(s, particle)] == 0)) return true;
  }
  return false;
}

template <class T>
void Joints<T>::set_swept(std::uint32_t spring) noexcept {
  auto& [rates_of, lanes, colours, strands] = *by_spring_;
  if (colours && !colours->is_left_out(spring)) {
    colours->set_spring(std::get<ColoursForm<T>>(form), input({}), rates_of, spring);
  }
  if (strands) strands->set_spring(std::get<StrandsForm<T>>(form), input({}), rates_of, spring);
}

template <class T>
bool Joints<T>::set_inverse_mass(const Scene& scene, std::size_t particle, double w_new) noexcept {
  if (by_spring_ && changes_left_out(particle, w_new)) return false;
  if (!set_rates(particle, w_new)) return false;
  const std::uint32_t element = order.of[particle];
  const_cast<T*>(w)[element] = static_cast<T>(w_new);  // our own memory
  if (by_spring_) {
    for (const std::uint32_t s : by_spring_->rates.springs_at(particle)) set_swept(s);
  } else if (auto* strands = std::get_if<StrandsForm<T>>(&form)) {
    set_inverses(*strands, input({}), grid_of(scene), w, element);
  }
  if (air && air->is_grid()) air->set_inverse_mass(w_of, particle);
  if (air && !air->is_grid()) air->set_inverse_mass(w_of, particle, order);
  return true;
}

template <class T>
bool Joints<T>::break_springs(const Scene& scene, std::size_t network, std::span<const Pair> pairs) {
  if (by_spring_) return break_list(scene, network, pairs);
  std::vector<GridSpring> torn;
  for (const Pair& ends : pairs) torn.push_back(*spring_between(std::get<Grid>(scene.networks[network]), ends));
  return break_grid(scene, network, torn);
}

// A stack's networks are its sheets.
template <class T>
void Joints<T>::set(std::size_t network, std::span<const GridSpring> which, SpringIs state) noexcept {
  for (const GridSpring& spring : which) by_row_[network].set(w_of_sheet(network), spring, state);
}

template <class T>
bool Joints<T>::break_grid(const Scene& scene, std::size_t network, std::span<const GridSpring> torn) {
  const auto& grid = std::get<Grid>(scene.networks[network]);
  by_row_[network].reserve_broken();
  set(network, torn, SpringIs::torn);
  Undo undo([&] { set(network, torn, SpringIs::whole); });
  const RateBounds bounds = rates_now();
  if (!are_right(bounds)) return false;
  auto* const grid_form = std::get_if<GridForm<T>>(&form);
  const std::size_t first_row = network * grid.rows;
  for (const GridSpring& spring : torn) {
    if (grid_form != nullptr) reserve_torn_row(*grid_form, first_row + spring.row, columns_);
  }
  undo.dismiss();
  for (GridSpring spring : torn) {
    if (grid_form == nullptr) tear(std::get<StrandsForm<T>>(form), order, grid, spring);
    if (air) air->tear(w_of, spring);
    spring.row += first_row;
    if (grid_form != nullptr) tear(*grid_form, spring);
  }
  take(bounds);
  return true;
}

namespace {

std::size_t count_springs(const Network& network) {
  if (const auto* springs = std::get_if<Springs>(&network)) return springs->pairs.size();
  return count_springs(std::get<Grid>(network));
}

SourceRange sources_of(const Scene& scene, std::size_t network) {
  SourceRange range;
  for (std::size_t n = 0; n < network; ++n) range.first += count_springs(scene.networks[n]);
  range.end = range.first + count_springs(scene.networks[network]);
  return range;
}

}  // namespace

template <class T>
bool Joints<T>::break_list(const Scene& scene, std::size_t network, std::span<const Pair> pairs) {
  auto& [rates_of, lanes, colours, strands] = *by_spring_;
  const SourceRange own = sources_of(scene, network);
  std::vector<std::uint32_t> torn;
  for (const auto& [i, j] : pairs) {
    for (const std::uint32_t s : rates_of.springs_at(i)) {
      if (rates_of.other_end(s, i) == j && own.holds(rates_of.source_of(s))) torn.push_back(s);
    }
  }
  for (const std::uint32_t s : torn) rates_of.set(w_of, s, SpringIs::torn);
  const RateBounds bounds = rates_now();
  if (!are_right(bounds)) {
    for (const std::uint32_t s : torn) rates_of.set(w_of, s, SpringIs::whole);
    return false;
  }
  auto* const graph = std::get_if<GraphForm<T>>(&form);
  for (const std::uint32_t s : torn) {
    if (graph != nullptr) {
      set_spring(*graph, *lanes, s, rates_of.spring(s));
    } else {
      set_swept(s);
    }
  }
  if (meets_air(scene.networks[network])) {
    const auto before = scene.networks.begin() + static_cast<std::ptrdiff_t>(network);
    const auto n = std::count_if(scene.networks.begin(), before, [](const Network& other) { return meets_air(other); });
    for (const Pair& ends : pairs) air->tear(w_of, air->networks()[static_cast<std::size_t>(n)], ends, order);
  }
  take(bounds);
  return true;
}

template <class T>
bool Joints<T>::set_stiffness(const Grid& grid) {
  if (is_stack_ || !std::holds_alternative<GridForm<T>>(form) || (grid.damping != 0 && springs != 0) != is_damped_)
    return false;
  if (dvdx::count_springs(grid) != springs) return false;
  std::vector<GridRates> by_row;
  by_row.emplace_back(grid, w_of);
  const RateBounds bounds = rate_bounds(by_row[0]);
  if (!are_right(bounds)) return false;
  take(bounds);
  by_row_ = std::move(by_row);
  dvdx::set_stiffness(std::get<GridForm<T>>(form).terms, grid);
  return true;
}

template <class T>
bool Joints<T>::set_stiffness(const Scene& scene, std::size_t network, const SpringsStiffness& before) noexcept {
  const auto& list = std::get<Springs>(scene.networks[network]);
  if ((list.damping != 0) != (before.damping != 0)) return false;  // other springs take part in the damping's passes
  auto& [rates_of, lanes, colours, strands] = *by_spring_;
  const SourceRange own = sources_of(scene, network);
  rates_of.set_stiffness(w_of, own, list.stiffness, list.damping);
  const RateBounds bounds = rates_now();
  if (!are_right(bounds)) {
    rates_of.set_stiffness(w_of, own, before.stiffness, before.damping);
    return false;
  }
  if (lanes) set_springs(std::get<GraphForm<T>>(form), *lanes, rates_of);
  if (colours) colours->set_springs(std::get<ColoursForm<T>>(form), input({}), rates_of);
  if (strands) strands->set_springs(std::get<StrandsForm<T>>(form), input({}), rates_of);
  take(bounds);
  return true;
}

template <class T>
bool Joints<T>::set_zero_length(const Scene& scene, std::size_t network, const Scalars& before) noexcept {
  auto& [rates_of, lanes, colours, strands] = *by_spring_;
  if (!lanes) return false;
  const SourceRange own = sources_of(scene, network);
  rates_of.set_zero_length(w_of, own, std::get<Springs>(scene.networks[network]).zero_length);
  const RateBounds bounds = rates_now();
  if (!are_right(bounds)) {
    rates_of.set_zero_length(w_of, own, before);
    return false;
  }
  set_springs(std::get<GraphForm<T>>(form), *lanes, rates_of);
  take(bounds);
  return true;
}

template <class T>
std::size_t Joints<T>::bytes() const noexcept {
  const std::size_t of_form = std::visit([](const auto& f) { return bytes_of_form<T>(f); }, form);
  return columns_.bytes() + of_form + (constraints ? constraints->bytes() : 0) + (air ? air->bytes() : 0) +
         (balls ? balls->bytes() : 0) + (meet ? meet->bytes() : 0);
}

template <class T>
std::optional<Error> Joints<T>::refusal(const Scene& scene, std::span<const Vec3> start, Unstable unstable) {
  const std::string field = "coupling.substeps";
  const auto limited = [&] {
    if (!found_) found_ = find(scene, start);
    return limit_of(rule, *found_, step, chosen.substeps, hangs_free(scene, *topology));
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

template class Joints<float>;
template class Joints<double>;

}  // namespace dvdx
