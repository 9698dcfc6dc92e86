#include "plan/compiled_network.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "scene/particle_values.hpp"
#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {
namespace {

std::size_t count_grid_springs(const Scene& scene) {
  std::size_t count = 0;
  for (const Network& network : scene.networks) count += count_springs(std::get<Grid>(network));
  return count;
}

}  // namespace

template <class T>
CompiledNetwork<T>::CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start)
    : CompiledNetwork(scene, options, start, nullptr, Changed::springs,
                      JoinedScene(scene, start, constrained_pairs(scene), options.elsewhere)) {}

template <class T>
CompiledNetwork<T>::CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start,
                                    const CompiledNetwork& kept, Changed changed)
    : CompiledNetwork(scene, options, start, &kept, changed,
                      JoinedScene(scene, start, constrained_pairs(scene), options.elsewhere, kept.topology)) {}

template <class T>
CompiledNetwork<T>::CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start,
                                    const CompiledNetwork* kept, Changed changed, const JoinedScene& joined)
    : SubstepChoice(scene, options, start, joined.topology),
      splitting(!scene.networks.empty() ? dvdx::splitting(coupling) : Splitting{.a = {1.0}, .b = {}, .beta = {}}),
      order(topology->order()),
      memory_(options.memory),
      columns_(options.memory) {
  const Grid* const grid = joined.stepped.get();
  const std::vector<JoinedPair>& pairs = joined.pairs;
  springs = grid != nullptr ? count_grid_springs(scene) : pairs.size();
  is_damped_ = grid != nullptr ? grid->damping != 0 && springs != 0 : is_any_damped(pairs);
  is_damped_ = is_damped_ || options.elsewhere.springs_damp;
  if (coupling.scheme == Scheme::sequential) sweeps_ = options.elsewhere.sweeps;
  closes_in_whole_ = options.elsewhere.closes_substeps;
  std::optional<SweptNet> net;
  choose(scene, pairs, start, kept, changed, net);
  if (is_generalized_alpha(coupling)) order_fingerprint = order.fingerprint();
  make_fixed(scene, start);
  make_inverse_masses();
  NetworkInput in = input(pairs);
  in.start = start;
  form = make_form(in, joined.stepped, topology->list_sheet(), w, columns_);
  may_take_rho_ = sweeps_list();
  choose_line_forces(scene, start, net);
  make_halo_schedule(options.elsewhere.exchange);
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

// net: the scene's if it has been made.
template <class T>
void CompiledNetwork<T>::choose_line_forces(const Scene& scene, std::span<const Vec3> start,
                                            const std::optional<SweptNet>& net) {
  visit_form(form, [&](auto& of) {
    if (!of.has_lines() || !of.line_forces()) return;
    if (!coupling.line_forces) coupling.line_forces = line_forces(turning(scene, start, net));
    of.set_line_forces(*coupling.line_forces);
  });
}

template <class T>
NetworkLimit CompiledNetwork<T>::limit(const Scene& scene, std::span<const Vec3> start) const {
  NetworkLimit limit = limit_of_springs(scene, start);
  const bool stays = visit_form(form, [](const auto& of) { return of.line_forces() == LineForces::stay; });
  const bool has_changed = stays && line_forces(limit.estimate.turning) != LineForces::stay;
  if (has_changed) limit.estimate.most_turning = most_turning_that_stays;
  return limit;
}

template <class T>
void CompiledNetwork<T>::make_fixed(const Scene& scene, std::span<const Vec3> start) {
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
void CompiledNetwork<T>::make_inverse_masses() {
  T* const column = columns_.add(order.size, T(0), column_margin);
  for (std::size_t i = 0; i < particles(); ++i) column[order.of[i]] = static_cast<T>(w_of[i]);
  w = column;
}

template <class T>
void CompiledNetwork<T>::make_halo_schedule(const Exchange& exchange) {
  if (exchange.start == nullptr) return;
  if (visit_form(form, [](const auto& of) { return of.has_records; })) {
    for (const std::uint32_t element : order.of) halo.records.push_back(static_cast<std::uint32_t>(record * element));
  }
  const std::size_t unit = visit_form(form, [](const auto& of) { return of.unit(); });  // particles
  std::vector<std::uint8_t> is_told(order.size / unit, exchange.is_told == nullptr);
  for (std::size_t i = 0; i < particles() && exchange.is_told != nullptr; ++i) {
    if (exchange.is_told[i] != 0) is_told[order.of[i] / unit] = 1;
  }
  const std::size_t most = std::max<std::size_t>(1, particles_per_task / unit);
  for (std::size_t n = 0; n < is_told.size(); ++n) {
    std::vector<UnitRange>& ranges = is_told[n] != 0 ? halo.outer : halo.inside;
    if (ranges.empty() || ranges.back().to != n || n - ranges.back().from == most) ranges.push_back({n, n});
    ranges.back().to = n + 1;
  }
}

template <class T>
NetworkInput CompiledNetwork<T>::input(std::span<const JoinedPair> pairs) const {
  const SubstepLength length{.taken = substep(), .longest = chosen.longest, .pace = chosen.pace};
  return {coupling, pairs, is_damped_, w_of, order, length, chosen.rho, sweeps_, {}, list_rates()};
}

template <class T>
bool CompiledNetwork<T>::sweeps_list() const noexcept {
  return act_of(form) == SpringsAct::in_sweeps && edited(form) == Edited::by_spring;
}

template <class T>
bool CompiledNetwork<T>::can_change_in_place() const noexcept {
  // If fewer sub-steps than are safe were asked for, only eigenvalues tell whether they still suffice.
  // Tethers follow whole springs to what is fixed.
  if (constraints || has_tethers_ || !chosen.is_safe) return false;
  if (edited(form) == Edited::by_row && air && !air->is_grid()) return false;
  return edited(form) != Edited::never;
}

template <class T>
bool CompiledNetwork<T>::can_change_step(const Options& options) const noexcept {
  const auto then = [&](const HighestRates& highest) { return substeps_by(highest, options.step, options.longest_step); };
  if (constraints || edited(form) == Edited::never) return false;
  if (edited(form) == Edited::by_row && act_of(form) == SpringsAct::in_sweeps) {
    return is_generalized_alpha(coupling) && then(rates.most).solves_alike(chosen);
  }
  return then(rates.least) == then(rates.most);
}

template <class T>
void CompiledNetwork<T>::reserve_step(const Scene& scene, std::span<const Vec3> start) {
  if (sweeps_list()) reserve_rates(scene, start);
}

template <class T>
void CompiledNetwork<T>::change_step(const Options& options) noexcept {
  step = options.step;
  longest_step = options.longest_step;
  chosen = substeps_by(rates.most);
}

template <class T>
void CompiledNetwork<T>::take_step(const Substeps& before) noexcept {
  const bool are_alike = is_generalized_alpha(coupling) && chosen.solves_alike(before);
  visit_form(form, [&](auto& of) { of.set_step(input({}), are_alike ? Solves::alike : Solves::anew); });
}

template <class T>
void CompiledNetwork<T>::reserve_rates(const Scene& scene, std::span<const Vec3> start) {
  if (network_rates_.are_made()) return;
  if (edited(form) == Edited::by_row) {
    network_rates_ = NetworkRates(scene, w_of);
    return;
  }
  const std::vector<JoinedPair> pairs = joined_pairs(scene, start);
  NetworkRates made(pairs, w_of);
  NetworkInput in = input(pairs);
  in.rates = made.list();
  visit_form(form, [&](auto& of) { of.reserve_edits(in, memory_); });
  network_rates_ = std::move(made);
}

// Changes nothing if the springs would ask for other sub-steps: take_back() undoes put().
template <class T>
template <class Put, class TakeBack>
bool CompiledNetwork<T>::set_rates(const Put& put, const TakeBack& take_back) noexcept {
  put();
  const RateBounds bounds = seen(network_rates_.bounds());
  const bool is_right = keeps_substeps(bounds);
  is_right ? take_rates(bounds) : take_back();
  return is_right;
}

template <class T>
void CompiledNetwork<T>::take_rates(const RateBounds& bounds) noexcept {
  if (const std::optional<Substeps> before = take(bounds)) take_step(*before);
}

template <class T>
bool CompiledNetwork<T>::set_inverse_mass(std::size_t particle, double w_new) noexcept {
  const auto set = [&](double its) {
    w_of[particle] = its;
    network_rates_.set_mass(w_of, particle);
  };
  return visit_form(form, [&, before = w_of[particle]](auto& of) {
    if (!of.can_set_mass(input({}), particle, w_new)) return false;
    if (!set_rates([&] { set(w_new); }, [&] { set(before); })) return false;
    const_cast<T*>(w)[order.of[particle]] = static_cast<T>(w_new);  // our own memory
    of.set_mass(input({}), particle, w);
    if (air && air->is_grid()) air->set_inverse_mass(w_of, particle);
    if (air && !air->is_grid()) air->set_inverse_mass(w_of, particle, order);
    return true;
  });
}

template <class T>
bool CompiledNetwork<T>::break_springs(const Scene& scene, std::size_t network, std::span<const Pair> pairs) {
  if (list_rates() != nullptr) return break_list(scene, network, pairs);
  return break_grid(scene, network, pairs);
}

// A stack's networks are its sheets.
template <class T>
bool CompiledNetwork<T>::break_grid(const Scene& scene, std::size_t network, std::span<const Pair> pairs) {
  const auto& grid = std::get<Grid>(scene.networks[network]);
  const std::size_t first_row = network * grid.rows;
  std::vector<GridSpring> torn;
  for (const Pair& ends : pairs) torn.push_back(*spring_between(grid, ends));
  return visit_form(form, [&](auto& of) {
    network_rates_.reserve_broken(network);
    for (const GridSpring& spring : torn) of.reserve_torn(first_row + spring.row, columns_);
    const auto set = [&](SpringIs state) { network_rates_.set(w_of, network, torn, state); };
    if (!set_rates([&] { set(SpringIs::torn); }, [&] { set(SpringIs::whole); })) return false;
    for (GridSpring spring : torn) {
      if (air) air->tear(w_of, spring);
      spring.row += first_row;
      of.tear(input({}), spring);
    }
    return true;
  });
}

template <class T>
bool CompiledNetwork<T>::break_list(const Scene& scene, std::size_t network, std::span<const Pair> pairs) {
  const ListRates& list = *list_rates();
  const SourceRange own = sources_of(scene, network);
  std::vector<std::uint32_t> torn;
  for (const auto& [i, j] : pairs) {
    for (const std::uint32_t s : list.springs_at(i)) {
      if (list.other_end(s, i) == j && own.holds(list.source_of(s))) torn.push_back(s);
    }
  }
  const auto set = [&](SpringIs state) { network_rates_.set(w_of, torn, state); };
  if (!set_rates([&] { set(SpringIs::torn); }, [&] { set(SpringIs::whole); })) return false;
  visit_form(form, [&](auto& of) {
    for (const std::uint32_t s : torn) of.set_spring(input({}), s);
  });
  if (meets_air(scene.networks[network])) {
    const auto before = scene.networks.begin() + static_cast<std::ptrdiff_t>(network);
    const auto n = std::count_if(scene.networks.begin(), before, [](const Network& other) { return meets_air(other); });
    for (const Pair& ends : pairs) air->tear(w_of, air->networks()[static_cast<std::size_t>(n)], ends, order);
  }
  return true;
}

template <class T>
bool CompiledNetwork<T>::set_stiffness(const Scene& scene) {
  const bool is_grid = visit_form(form, [](const auto& of) { return of.grid_terms() != nullptr; });
  if (!is_grid || is_stack()) return false;
  const auto& grid = std::get<Grid>(scene.networks[0]);
  if ((grid.damping != 0 && springs != 0) != is_damped_ || count_springs(grid) != springs) return false;
  NetworkRates made(scene, w_of);
  const RateBounds bounds = made.bounds();
  if (!keeps_substeps(bounds)) return false;
  visit_form(form, [&](auto& of) { of.set_stiffness(grid); });
  take_rates(bounds);
  network_rates_ = std::move(made);
  return true;
}

template <class T>
bool CompiledNetwork<T>::set_stiffness(const Scene& scene, std::size_t network, const SpringsStiffness& before) noexcept {
  const auto& now = std::get<Springs>(scene.networks[network]);
  if ((now.damping != 0) != (before.damping != 0)) return false;  // other springs take part in the damping's passes
  const auto set = [&](const Scalars& k, double c) {
    network_rates_.list()->set_stiffness(w_of, sources_of(scene, network), k, c);
  };
  return set_springs([&] { set(now.stiffness, now.damping); }, [&] { set(before.stiffness, before.damping); });
}

template <class T>
bool CompiledNetwork<T>::set_zero_length(const Scene& scene, std::size_t network, const Scalars& before) noexcept {
  if (!visit_form(form, [](const auto& of) { return of.can_set_zero_length(); })) return false;
  const auto set = [&](const Scalars& q) { network_rates_.list()->set_zero_length(w_of, sources_of(scene, network), q); };
  return set_springs([&] { set(std::get<Springs>(scene.networks[network]).zero_length); }, [&] { set(before); });
}

template <class T>
template <class Put, class TakeBack>
bool CompiledNetwork<T>::set_springs(const Put& put, const TakeBack& take_back) noexcept {
  if (!set_rates(put, take_back)) return false;
  visit_form(form, [&](auto& of) { of.set_springs(input({})); });
  return true;
}

template <class T>
std::size_t CompiledNetwork<T>::bytes() const noexcept {
  const std::size_t of_form = visit_form(form, [](const auto& of) { return of.bytes(); });
  return columns_.bytes() + of_form + (constraints ? constraints->bytes() : 0) + (air ? air->bytes() : 0) +
         (balls ? balls->bytes() : 0) + (meet ? meet->bytes() : 0);
}

template class CompiledNetwork<float>;
template class CompiledNetwork<double>;

}  // namespace dvdx
