#include "compile/joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "compile/particle_values.hpp"
#include "compile/pose_track.hpp"

namespace dvdx {
namespace {

// Springs turn, and their frequency changes with them: the margin between the start's frequency and the limit.
constexpr double start_margin = 1 / 0.93;

std::vector<double> inverse_masses(const Scene& scene, std::size_t count) {
  std::vector<double> w(count);
  for (std::size_t i = 0; i < count; ++i) w[i] = 1 / scene.mass[i];
  for (const std::size_t i : scene.fixed) w[i] = 0;
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) w[i] = 0;
  }
  return w;
}

// A sheet that hangs free reaches its bound only where it folds onto a line, and is left to its user below that; sheets that
// land and other springs are not (curtain and net-stiff blew up between the two).
struct Limited {
  NetworkLimit limit;
  LimitedBy by = LimitedBy::frequency;
};

Limited limit_of(const Coupling& coupling, const Frequencies& frequencies, double h, bool hangs_free) {
  Limited found;
  NetworkLimit& limit = found.limit;
  limit.frequency = frequencies.start;
  limit.bound = frequencies.bound;
  limit.particle = frequencies.particle;
  limit.damping = frequencies.damping;
  // A pair's own contribution is stable at any step where its particles have no other spring.
  const bool is_alone = coupling.scheme == Scheme::accumulate && frequencies.is_isolated;
  const StableRange stable = is_alone ? StableRange{} : scheme_limit(coupling);
  limit.limit = stable.frequency;
  limit.damping_limit = stable.damping;
  if (is_alone) limit.substeps = coupling.substeps.value_or(1);
  if (is_alone) return found;
  HighestRates rates{frequencies.bound, frequencies.damping};
  limit.safe = substeps_for(stable, h, rates);
  limit.fewest = limit.safe;
  // Of the matrix M^-1 K the margin is the square of the frequency's, and so it is of M^-1 C.
  const HighestRates at_start{frequencies.start * start_margin, frequencies.damping_start * start_margin * start_margin};
  if (hangs_free && substeps_for(stable, h, at_start) < limit.safe) {
    limit.fewest = substeps_for(stable, h, at_start);
    rates = at_start;
  }
  found.by = limited_by(stable, h, rates);
  limit.substeps = coupling.substeps.value_or(substeps_for(calm_limit(coupling), h, {frequencies.bound, frequencies.damping}));
  return found;
}

// A surface that turns by theta in a flow sees a path that bends by theta^3 where the pass has a parabola: half a radian at
// most.
int substeps_of_turns(const Scene& scene, double h) {
  constexpr double most_turn = 0.5;  // rad
  double turn = 0;
  for (const Contact& contact : scene.contacts) {
    if (const auto& motion = motion_of(contact)) {
      turn = std::max(turn, PoseTrack(scene.motions[*motion]).fastest_turn() * std::abs(h));
    }
  }
  return static_cast<int>(std::clamp(std::ceil(turn / most_turn), 1.0, 1e6));
}

// A sum of pairs' own contributions takes other coefficients than a pulse; the filtered pulse is one.
bool sums_pairs(const Coupling& coupling) {
  return coupling.scheme == Scheme::accumulate && coupling.method != Method::combined;
}

template <class Element>
std::size_t bytes_of(const std::vector<Element>& list) {
  return list.size() * sizeof(Element);
}

template <class T>
std::size_t bytes_of(const GridForm<T>& /*form*/) {
  return 0;
}
template <class T>
std::size_t bytes_of(const GraphForm<T>& form) {
  std::size_t bytes = 0;
  for (const SlotLists* lists : {&form.lists, &form.damped_lists}) {
    bytes += bytes_of(lists->first_slot) + bytes_of(lists->slots) + bytes_of(lists->indices);
  }
  return bytes;
}
template <class T>
std::size_t bytes_of(const StrandsForm<T>& form) {
  return bytes_of(form.strands) + bytes_of(form.families) + bytes_of(form.families_of_start) + bytes_of(form.bands);
}
template <class T>
std::size_t bytes_of(const ColoursForm<T>& form) {
  return bytes_of(form.a) + bytes_of(form.b) + bytes_of(form.coefficients_of) + bytes_of(form.coefficients_of_start) +
         bytes_of(form.ranges) + bytes_of(form.tasks) + bytes_of(form.stages);
}

}  // namespace

template <class T>
Joints<T>::Joints(const Scene& scene, const Options& options, std::span<const Vec3> start)
    : coupling(scene.coupling),
      step(options.step),
      w_of(inverse_masses(scene, start.size())),
      splitting(!scene.networks.empty() ? dvdx::splitting(coupling) : Splitting{.a = {1.0}, .b = {}, .beta = {}}),
      columns_(options.memory) {
  const std::vector<JoinedPair> pairs = joined_pairs(scene, start);
  const Grid* grid = only_grid(scene, particles());
  springs = pairs.size();
  is_damped_ = is_any_damped(pairs);
  frequencies = dvdx::frequencies(pairs, grid, w_of, start);
  const Limited limited = limit_of(coupling, frequencies, step, grid != nullptr && scene.contacts.empty());
  limit = limited.limit;
  limited_by_ = limited.by;
  if (!coupling.substeps) limit.substeps = std::max(limit.substeps, substeps_of_turns(scene, step));
  make_order(scene, pairs, grid);
  make_fixed(scene, start);
  make_inverse_masses();
  make_form(pairs, grid);
  if (!scene.constraints.empty()) constraints.emplace(scene, start, w_of, order, substep(), options.memory);
}

template <class T>
void Joints<T>::make_order(const Scene& scene, std::span<const JoinedPair> pairs, const Grid* grid) {
  if (grid != nullptr && coupling.scheme != Scheme::accumulate) {
    const std::size_t phases = coupling.scheme != Scheme::sequential ? 1 : (grid->bend != 0 ? 4 : 2);
    order = grid_order(*grid, phases);
    return;
  }
  std::vector<JoinedPair> near(pairs.begin(), pairs.end());
  for (const JoinedPair& pair : constrained_pairs(scene)) near.push_back(pair);
  order = coupling.scheme == Scheme::sequential ? pieces_order(near, particles()) : graph_order(near, particles());
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
void Joints<T>::make_form(std::span<const JoinedPair> pairs, const Grid* grid) {
  const NetworkInput in{coupling, pairs, w_of, order, substep(), frequencies.bound};
  const bool is_sequential = coupling.scheme == Scheme::sequential;
  if (grid != nullptr && is_sequential) {
    form = make_strands_form<T>(in, *grid, w, columns_);
  } else if (grid != nullptr && coupling.scheme != Scheme::accumulate) {
    form = make_grid_form<T>(in, *grid);
  } else if (is_sequential) {
    form = make_colours_form<T>(in, columns_);
  } else if (sums_pairs(coupling)) {
    form = make_pairs_form<T>(in, columns_);
  } else {
    form = make_graph_form<T>(in, columns_);
  }
}

template <class T>
std::size_t Joints<T>::bytes() const noexcept {
  const std::size_t of_form = std::visit([](const auto& f) { return bytes_of<T>(f); }, form);
  return columns_.bytes() + of_form + (constraints ? constraints->bytes() : 0);
}

template <class T>
std::optional<Error> Joints<T>::refusal(Unstable unstable) const {
  const std::string field = "network.substeps";
  if (limit.substeps > 1000000) {
    return Error{field, std::to_string(limit.safe), "at most 1000000: a smaller step, less stiffness, or scheme sequential"};
  }
  if (limit.substeps >= limit.fewest || unstable == Unstable::allowed) return std::nullopt;
  return Error{field, std::to_string(limit.substeps),
               "at least " + std::to_string(limit.fewest) + " for this scheme, or the springs are unstable by their " +
                   (limited_by_ == LimitedBy::damping ? "damping" : "frequency") + " (" + std::to_string(limit.safe) +
                   " are stable in any position); scheme sequential takes any"};
}

template class Joints<float>;
template class Joints<double>;

}  // namespace dvdx
