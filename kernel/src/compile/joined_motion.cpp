#include "compile/joined_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "forces/radial_spring.hpp"
#include "forces/spring.hpp"
#include "math/elementary.hpp"

namespace dvdx {
namespace {

// Elements before and after a working column: slots at one offset read so far beyond the particles.
constexpr std::size_t margin = slice;

// Springs turn, and their frequency with them: what may be asked for leaves so much between the start's and the limit.
constexpr double start_margin = 1 / 0.93;

// Rows of a grid that a sweep takes together, all springs of one direction before the next: enough independent work for a core,
// and little enough to stay in first-level cache. A multiple of 4, so that rows of equal number mod 4 mean the same in each.
std::size_t rows_of_band(std::size_t columns) { return std::clamp<std::size_t>(512 / columns / 4 * 4, 4, 32); }

Scalars arranged(const Scalars& values, const Places& places) {
  if (values.is_uniform()) return values;
  std::vector<double> each(places.size, values[0]);
  for (std::size_t i = 0; i < places.of.size(); ++i) each[places.of[i]] = values[i];
  return each;
}

std::vector<Vec3> arranged(const std::vector<Vec3>& values, const Places& places) {
  if (values.empty()) return {};
  std::vector<Vec3> each(places.size, values[0]);
  for (std::size_t i = 0; i < places.of.size(); ++i) each[places.of[i]] = values[i];
  return each;
}

enum class Contacts { kept, left_out };

// The scene without what joins particles, its values in the order of the working columns.
Scene arranged(const Scene& scene, const Places& places, Contacts contacts) {
  Scene flow = scene;
  flow.networks.clear();
  flow.constraints.clear();
  flow.fixed.clear();
  if (contacts == Contacts::left_out) flow.contacts.clear();
  flow.mass = arranged(scene.mass, places);
  const auto arrange = [&](auto& force) {
    if constexpr (requires { force.stiffness.scalars(); }) {
      if (force.stiffness.is_isotropic()) force.stiffness = arranged(force.stiffness.scalars(), places);
    } else if constexpr (requires { force.stiffness; }) {
      force.stiffness = arranged(force.stiffness, places);
    }
    if constexpr (requires { force.coefficient; }) {
      if (force.coefficient.is_isotropic()) force.coefficient = arranged(force.coefficient.scalars(), places);
    }
    if constexpr (requires { force.rest_length; }) force.rest_length = arranged(force.rest_length, places);
    if constexpr (requires { force.anchor; }) {
      if (auto* each = std::get_if<std::vector<Vec3>>(&force.anchor)) *each = arranged(*each, places);
    }
  };
  for (Force& force : flow.forces) std::visit(arrange, force);
  return flow;
}

std::vector<double> weights(const Scene& scene, std::size_t count) {
  std::vector<double> w(count);
  for (std::size_t i = 0; i < count; ++i) w[i] = 1 / scene.mass[i];
  for (const std::size_t i : scene.fixed) w[i] = 0;
  return w;
}

// A sheet that hangs free reaches its bound only where it folds onto a line, and is left to its user below that; sheets that
// land and other springs are not (curtain and net-stiff blew up between the two).
NetworkLimit limit_of(const Coupling& coupling, const Frequencies& frequencies, double h, bool hangs_free) {
  NetworkLimit limit;
  limit.frequency = frequencies.start;
  limit.bound = frequencies.bound;
  limit.particle = frequencies.particle;
  limit.limit = scheme_limit(coupling);
  // A pair's own contribution stands any step where its particles have no other.
  const bool is_alone = coupling.scheme == Scheme::accumulate && frequencies.is_isolated;
  if (is_alone) limit.limit = std::numeric_limits<double>::infinity();
  if (is_alone) limit.substeps = coupling.substeps.value_or(1);
  if (is_alone) return limit;
  limit.safe = substeps_for(limit.limit, h, frequencies.bound, frequencies.damping);
  limit.fewest = limit.safe;
  if (hangs_free) limit.fewest = std::min(limit.safe, substeps_for(limit.limit, h, frequencies.start * start_margin, 0));
  const int calm = substeps_for(calm_limit(coupling), h, frequencies.bound, frequencies.damping);
  limit.substeps = coupling.substeps.value_or(calm);
  return limit;
}

bool is_linear(const JoinedPair& s) { return s.l == 0 && s.c == 0; }

bool is_any_damped(const std::vector<JoinedPair>& pairs) {
  return std::any_of(pairs.begin(), pairs.end(), [](const JoinedPair& s) { return s.c != 0; });
}

}  // namespace

template <class T>
NetworkProgram<T>::NetworkProgram(const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start)
    : coupling_(scene.coupling),
      h_(options.step),
      source_(options.memory),
      kernels_(find_network_kernels<T>(isa, options.arithmetic)),
      pairs_(joined_pairs(scene, start)),
      spring_count_(pairs_.size()),
      particles_(start.size()),
      w_(weights(scene, start.size())),
      splitting_(!scene.networks.empty() ? splitting(coupling_) : Splitting{.a = {1.0}, .b = {}}) {
  const Grid* grid = only_grid(scene, particles_);
  frequencies_ = frequencies(pairs_, grid, w_, start);
  limit_ = limit_of(coupling_, frequencies_, h_, grid != nullptr && scene.contacts.empty());
  const bool is_sequential = coupling_.scheme == Scheme::sequential;
  const bool is_filtered = coupling_.scheme == Scheme::accumulate && coupling_.method == Method::combined;
  const bool is_summed = coupling_.scheme == Scheme::accumulate && !is_filtered;
  if (grid != nullptr && is_sequential) {
    form_ = Form::strands;
    places_ = places_in_grid(*grid, grid->bend != 0 ? 4 : 2);
  } else if (grid != nullptr && coupling_.scheme != Scheme::accumulate) {
    form_ = Form::grid;
    places_ = places_in_grid(*grid, 1);
  } else {
    form_ = is_sequential ? Form::colours : (is_summed ? Form::pairs : Form::graph);
    std::vector<JoinedPair> near = pairs_;
    for (const JoinedPair& pair : constrained_pairs(scene)) near.push_back(pair);
    places_ = places_in_graph(near, particles_);
  }
  if (!scene.constraints.empty()) {
    constraints_ = std::make_unique<ConstraintProgram<T>>(scene, start, w_, places_, substep(), kernels_->constraint, source_);
    bytes_ += constraints_->bytes();
  }
  make_sheet(scene.fixed);
  make_flows(scene, options, isa, start);
  if (form_ == Form::strands) make_strands(*grid);
  if (form_ == Form::grid) make_grid(*grid);
  if (form_ == Form::graph || form_ == Form::pairs) make_graph();
  if (form_ == Form::colours) make_colours();
  pairs_ = {};
}

template <class T>
std::optional<Error> NetworkProgram<T>::refusal(Unstable unstable) const {
  const std::string field = "network.substeps";
  if (limit_.substeps > 1000000) {
    return Error{field, std::to_string(limit_.safe), "at most 1000000: a smaller step, less stiffness, or scheme sequential"};
  }
  if (limit_.substeps >= limit_.fewest || unstable == Unstable::allowed) return std::nullopt;
  return Error{field, std::to_string(limit_.substeps),
               "at least " + std::to_string(limit_.fewest) + " for this scheme, or the springs are unstable (" +
                   std::to_string(limit_.safe) + " are stable in any position); scheme sequential takes any"};
}

template <class T>
T* NetworkProgram<T>::column(std::size_t size, T fill) {
  const std::size_t elements = size + 2 * margin;
  memory_.push_back(aligned_array<T>(elements, source_));
  bytes_ += elements * sizeof(T);
  std::fill_n(memory_.back().get(), elements, fill);
  return memory_.back().get() + margin;
}

template <class T>
std::array<T*, 3> NetworkProgram<T>::columns(T fill) {
  const std::size_t pitch = column_pitch<T>(places_.size + 2 * margin);
  memory_.push_back(aligned_array<T>(3 * pitch, source_));
  bytes_ += 3 * pitch * sizeof(T);
  std::fill_n(memory_.back().get(), 3 * pitch, fill);
  T* const first = memory_.back().get() + margin;
  return {first, first + pitch, first + 2 * pitch};
}

// Padding holds NaN: nothing may read it, and a test would see who does.
template <class T>
void NetworkProgram<T>::make_sheet(const std::vector<std::size_t>& fixed) {
  constexpr T nothing = std::numeric_limits<T>::quiet_NaN();
  sheet_.x = columns(nothing);
  sheet_.v = columns(nothing);
  const bool reads_velocities = (form_ == Form::grid || form_ == Form::graph) && is_any_damped(pairs_);
  sheet_.v_next = reads_velocities ? columns(nothing) : sheet_.v;
  if (form_ == Form::strands || form_ == Form::colours) sheet_.shift = columns(0);
  if (form_ == Form::pairs) {
    sheet_.dx = columns(0);
    sheet_.dv = columns(0);
  }
  T* const w = column(places_.size, 0);
  for (std::size_t i = 0; i < particles_; ++i) w[places_.of[i]] = static_cast<T>(w_[i]);
  sheet_.w = w;
  for (const std::size_t i : fixed) fixed_.push_back({.particle = static_cast<std::uint32_t>(i), .element = places_.of[i]});
  std::sort(fixed_.begin(), fixed_.end(), [](const Held& a, const Held& b) { return a.element < b.element; });
}

// ---- flows -------------------------------------------------------------------------------------------------------------

template <class T>
std::size_t NetworkProgram<T>::flow_over(double part, const Scene& scene, const Options& options, Isa isa,
                                         const std::vector<Vec3>& start) {
  const double duration = part * substep();
  for (std::size_t f = 0; f < flows_.size(); ++f) {
    if (durations_[f] == duration) return f;
  }
  // The fourth-order scheme goes back a little between two pulses: an impact has no inverse.
  const auto contacts = part > 0 ? Contacts::kept : Contacts::left_out;
  Options of_flow = options;
  of_flow.step = duration;
  flows_.push_back(
      std::make_unique<Program<T>>(arranged(scene, places_, contacts), of_flow, isa, places_.size, arranged(start, places_)));
  durations_.push_back(duration);
  return flows_.size() - 1;
}

template <class T>
void NetworkProgram<T>::make_flows(const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start) {
  const std::vector<Vec3> anchors = stands_at_start(scene) ? start : std::vector<Vec3>{};
  const auto over = [&](double part) { return flow_over(part, scene, options, isa, anchors); };
  const auto& [a, b] = splitting_;
  if (form_ == Form::pairs) {
    first_ = {over(1)};
    again_ = first_;
    return;
  }
  for (std::size_t k = 0; k < b.size(); ++k) first_.push_back(over(a[k]));
  again_ = first_;
  if (a.size() > b.size()) {
    // One flow where two would follow each other, but for constraints, which stand between them.
    if (constraints_ == nullptr) again_[0] = over(a.back() + a.front());
    last_ = over(a.back());
  }
  const bool is_free = std::all_of(flows_.begin(), flows_.end(),
                                   [](const auto& flow) { return is_drift(flow->flow) && flow->extra == Extras::none; });
  // Where nothing asks for the position itself, it is counted from the step's start.
  is_relative_ = coupling_.scheme == Scheme::sequential && is_free && constraints_ == nullptr;
  if (!is_relative_ || origin_[0] != nullptr) return;
  origin_ = columns(0);
  sheet_.origin = {origin_[0], origin_[1], origin_[2]};
}

template <class T>
bool NetworkProgram<T>::replace_forces(const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start) {
  const bool was_relative = is_relative_;
  auto kept = std::tuple(std::exchange(flows_, {}), std::exchange(durations_, {}), std::exchange(first_, {}), again_, last_);
  try {
    make_flows(scene, options, isa, start);
  } catch (...) {  // no memory: the plan goes on as it was
    std::tie(flows_, durations_, first_, again_, last_) = std::move(kept);
    is_relative_ = was_relative;
    throw;
  }
  return is_relative_ == was_relative;
}

// ---- springs by owner --------------------------------------------------------------------------------------------------

template <class T>
void NetworkProgram<T>::make_grid(const Grid& grid) {
  grid_.rows = grid.rows;
  grid_.columns = grid.columns;
  grid_.pitch = places_.pitch;
  for (const GridDirection& d : directions_of(grid)) {
    Family<T> family{.k = static_cast<T>(d.k), .kl = static_cast<T>(d.k * d.l), .c = static_cast<T>(grid.damping)};
    if (!family.is_there()) family = {};  // in T
    auto& along = grid_.along;
    if (d.down == 0) (d.right == 1 ? along.right : along.right2) = family;
    if (d.down == 1) (d.right < 0 ? along.left_below : (d.right == 0 ? along.below : along.right_below)) = family;
    if (d.down == 2) along.below2 = family;
  }
  grid_.damping = grid.damping != 0 ? Damping::along : Damping::none;
}

namespace {

struct Neighbour {
  std::ptrdiff_t offset;
  std::size_t nth;     // of the springs that join the same two
  std::size_t spring;  // index of the list
  std::size_t owner;   // particle
};

// One slot of a slice: the neighbours of some of its lanes.
using SlotLanes = std::array<std::optional<Neighbour>, slice>;

struct SliceSlots {
  std::vector<SlotLanes> slots;
  bool is_at_offsets = false;
};

// At fixed offsets where that takes few slots more than the lane with most neighbours has.
SliceSlots slots_of(const std::array<std::vector<Neighbour>, slice>& lanes) {
  std::map<std::pair<std::ptrdiff_t, std::size_t>, SlotLanes> at_offset;
  std::size_t most = 0;
  for (std::size_t lane = 0; lane < slice; ++lane) {
    most = std::max(most, lanes[lane].size());
    for (const Neighbour& n : lanes[lane]) at_offset[{n.offset, n.nth}][lane] = n;
  }
  SliceSlots made;
  made.is_at_offsets = at_offset.size() <= most + 4;
  if (made.is_at_offsets) {
    for (const auto& entry : at_offset) made.slots.push_back(entry.second);
    return made;
  }
  made.slots.resize(most);
  for (std::size_t lane = 0; lane < slice; ++lane) {
    for (std::size_t n = 0; n < lanes[lane].size(); ++n) made.slots[n][lane] = lanes[lane][n];
  }
  return made;
}

}  // namespace

template <class T>
void NetworkProgram<T>::make_graph() {
  std::vector<std::vector<Neighbour>> of(places_.size);
  for (std::size_t s = 0; s < pairs_.size(); ++s) {
    const auto a = static_cast<std::ptrdiff_t>(places_.of[pairs_[s].a]);
    const auto b = static_cast<std::ptrdiff_t>(places_.of[pairs_[s].b]);
    if (w_[pairs_[s].a] == 0 && w_[pairs_[s].b] == 0) continue;
    of[static_cast<std::size_t>(a)].push_back({b - a, 0, s, pairs_[s].a});
    of[static_cast<std::size_t>(b)].push_back({a - b, 0, s, pairs_[s].b});
  }
  std::vector<SliceSlots> slices;
  for (std::size_t first = 0; first < places_.size; first += slice) {
    std::array<std::vector<Neighbour>, slice> lanes;
    for (std::size_t lane = 0; lane < slice; ++lane) {
      lanes[lane] = std::move(of[first + lane]);
      std::stable_sort(lanes[lane].begin(), lanes[lane].end(),
                       [](const Neighbour& m, const Neighbour& n) { return m.offset < n.offset; });
      for (std::size_t n = 1; n < lanes[lane].size(); ++n) {
        if (lanes[lane][n].offset == lanes[lane][n - 1].offset) lanes[lane][n].nth = lanes[lane][n - 1].nth + 1;
      }
    }
    slices.push_back(slots_of(lanes));
  }
  std::size_t slots = 0;
  for (const SliceSlots& made : slices) slots += made.slots.size();
  SlotColumns to;
  const auto slot_column = [&](const T*& view) { return (view = column(slots * slice, 0), const_cast<T*>(view)); };
  if (form_ == Form::pairs) {
    to = {.A = slot_column(graph_.A),
          .B = slot_column(graph_.B),
          .C = slot_column(graph_.C),
          .D = slot_column(graph_.D),
          .l = slot_column(graph_.l)};
    if (std::any_of(pairs_.begin(), pairs_.end(), is_linear)) to.linear = slot_column(graph_.linear);
  } else {
    to = {.k = slot_column(graph_.k), .kl = slot_column(graph_.kl)};
  }
  graph_.damping = is_any_damped(pairs_) ? Damping::along : Damping::none;
  if (form_ == Form::graph && graph_.damping == Damping::along) to.c = slot_column(graph_.c);

  for (std::size_t n = 0; n < slices.size(); ++n) {
    first_slot_.push_back(static_cast<std::uint32_t>(slots_.size()));
    for (const SlotLanes& lanes : slices[n].slots) add_slot(n * slice, lanes, slices[n].is_at_offsets, to);
  }
  first_slot_.push_back(static_cast<std::uint32_t>(slots_.size()));
  graph_.first_slot = first_slot_.data();
  graph_.slots = slots_.data();
  graph_.indices = indices_.data();
  graph_.drift = static_cast<T>(coupling_.axis == PairAxis::midpoint ? substep() / 2 : 0);
  bytes_ += slots_.size() * sizeof(Slot) + indices_.size() * sizeof(std::int32_t);
}

template <class T>
void NetworkProgram<T>::add_slot(std::size_t first, const auto& lanes, bool is_at_offset, const SlotColumns& to) {
  const std::size_t s = slots_.size();
  Slot slot;
  if (!is_at_offset) slot.indices = static_cast<std::int32_t>(indices_.size());
  for (std::size_t lane = 0; lane < slice; ++lane) {
    const auto& n = lanes[lane];
    const std::ptrdiff_t offset = n ? n->offset : 0;
    if (!is_at_offset) {
      indices_.push_back(static_cast<std::int32_t>(static_cast<std::ptrdiff_t>(first + lane) + offset));
    } else if (n) {
      slot.offset = static_cast<std::int32_t>(offset);
    }
    if (n) put_spring(pairs_[n->spring], w_[n->owner], s * slice + lane, to);
  }
  slots_.push_back(slot);
}

namespace {

// What T cannot tell from no spring is none, in every loop: a length that is infinite in T would make 0 times it not a number.
template <class T>
T unless_empty(bool is_empty, double value) noexcept {
  return is_empty ? T(0) : static_cast<T>(value);
}

}  // namespace

// The seed's methods and the filtered pulse treat each pair as if it were alone: W = k (w_a + w_b), of whose motion the owner
// has the share w / (w_a + w_b).
template <class T>
void NetworkProgram<T>::put_spring(const JoinedPair& s, double w, std::size_t lane, const SlotColumns& to) const {
  const double both = w_[s.a] + w_[s.b];
  if (form_ == Form::pairs) {
    const Contribution alone = spring(s.k * both, s.c * both, substep(), coupling_.method);
    const double share = w / both;
    to.A[lane] = static_cast<T>(share * alone.A);
    to.B[lane] = static_cast<T>(share * alone.B);
    to.C[lane] = static_cast<T>(share * alone.C);
    to.D[lane] = static_cast<T>(share * alone.D);
    const bool is_empty = to.A[lane] == 0 && to.B[lane] == 0 && to.C[lane] == 0 && to.D[lane] == 0;
    to.l[lane] = unless_empty<T>(is_empty, s.l);
    if (to.linear != nullptr) to.linear[lane] = is_linear(s) ? T(1) : T(0);
    return;
  }
  double k = s.k;
  double c = s.c;
  if (coupling_.scheme == Scheme::accumulate) {
    const RadialKick kick = radial_kick(s.k * both, s.c * both, substep());
    k = kick.kappa / (both * substep());
    c = (1 - kick.E * kick.E) / (both * substep());
  }
  to.k[lane] = static_cast<T>(k);
  if (to.c != nullptr) to.c[lane] = static_cast<T>(c);
  to.kl[lane] = unless_empty<T>(to.k[lane] == 0 && (to.c == nullptr || to.c[lane] == 0), k * s.l);
}

// ---- springs in sweeps -------------------------------------------------------------------------------------------------

// Sequential: with h the part theta of the sub-step s that has passed when the springs act,
//   lambda = the force along a spring times h^2,   C = r - l,   lambda = -(k h^2 C + c h n.(moved by h))
// solved for all springs by sweeps that visit one after the other, each of which moves its ends by  -+ w n d_lambda:
//   d_lambda = -(kappa C + eta n.moved + lambda) / (1 + (kappa + eta) (w_a + w_b)),   kappa = k h^2, eta = c h
// The total shift S of the sweeps is what the force moves x by within h, so that over the whole sub-step
//   v += S / (theta^2 s),   x += (2 theta - 1) / theta^2 S
// before the flow over the rest of it. theta = 1/2: a pulse at the middle that depends on the positions there alone, so that
// the step is its own inverse with -s, hence of second order; with a forward and a backward sweep its matrix is symmetric and
// below 4/s^2, so that linear networks are stable at every step. theta = 1 and forward sweeps: extended position-based dynamics
// in small steps (Macklin et al. 2019), of first order and damped.
template <class T>
void NetworkProgram<T>::make_sweeps() {
  const double theta = coupling_.theta;
  const double h = theta * substep();
  sweep_.h = static_cast<T>(h);
  sweep_.damping = is_any_damped(pairs_) ? Damping::along : Damping::none;
  sweep_.origin = origin_[0] != nullptr ? CountedFrom::step : CountedFrom::zero;
  shift_to_v_ = static_cast<T>(1 / (theta * theta * substep()));
  shift_to_x_ = static_cast<T>((2 * theta - 1) / (theta * theta));
}

template <class T>
Compliances NetworkProgram<T>::compliances(double k, double c, double w) const {
  const double h = coupling_.theta * substep();
  const double kappa = k * h * h;
  const double eta = c * h;
  return {kappa, eta, 1 / (1 + (kappa + eta) * w)};
}

// What a visit of a spring leaves for the next.
template <class T>
void NetworkProgram<T>::keep_sweeps(std::size_t springs) {
  sweep_.lambda = column(springs, 0);
  if (coupling_.sweeps == Sweeps::symmetric) sweep_.apart = {column(springs, 0), column(springs, 0), column(springs, 0)};
}

// Bands of rows, and in each the directions one after the other, in groups of strands that share no particle.
template <class T>
void NetworkProgram<T>::make_strands(const Grid& grid) {
  make_sweeps();
  const std::vector<GridDirection> directions = directions_of(grid);
  for (const GridDirection& d : directions) {
    const Compliances k = compliances(d.k, grid.damping, 0);
    families_.push_back({static_cast<T>(k.kappa), static_cast<T>(k.eta), static_cast<T>(d.l)});
  }
  std::size_t springs = 0;
  const std::size_t band = rows_of_band(grid.columns);
  for (std::size_t from = 0; from < grid.rows; from += band) {
    bands_.push_back(strands_.size());
    const std::size_t to = std::min(from + band, grid.rows);
    for (std::size_t f = 0; f < directions.size(); ++f) add_strands(grid, directions[f], f, from, to, springs);
  }
  bands_.push_back(strands_.size());
  T* const inverse = column(springs, 0);
  for (const Strand& strand : strands_) {
    const GridDirection& d = directions[strand.family];
    for (std::size_t k = 0; k < strand.count; ++k) {
      const double w = static_cast<double>(sheet_.w[strand.a + k]) + static_cast<double>(sheet_.w[strand.b + k]);
      inverse[strand.springs + k] = static_cast<T>(compliances(d.k, grid.damping, w).inverse);
    }
  }
  sweep_.strands = strands_.data();
  sweep_.families = families_.data();
  sweep_.inverse = inverse;
  keep_sweeps(springs);
}

template <class T>
void NetworkProgram<T>::add_strands(const Grid& grid, const GridDirection& d, std::size_t family, std::size_t from,
                                    std::size_t to, std::size_t& springs) {
  const auto phases = static_cast<std::ptrdiff_t>(places_.phases);
  const auto columns = static_cast<std::ptrdiff_t>(grid.columns);
  const auto add = [&](std::size_t row, std::ptrdiff_t phase) {
    if (row + d.down >= grid.rows) return;
    const std::ptrdiff_t other = (phase + d.right + phases) % phases;
    const std::ptrdiff_t shift = (phase + d.right - other) / phases;
    const std::ptrdiff_t first = shift < 0 ? -shift : 0;
    // columns phases k + phase, and phases (k + shift) + other of the other end, both in the grid
    const std::ptrdiff_t end_a = (columns - phase + phases - 1) / phases;
    const std::ptrdiff_t end_b = (columns - other + phases - 1) / phases - shift;
    const std::ptrdiff_t count = std::min(end_a, end_b) - first;
    if (count <= 0) return;
    const auto line = [&](std::size_t r, std::ptrdiff_t p) {
      return static_cast<std::ptrdiff_t>((r * places_.phases + static_cast<std::size_t>(p)) * places_.pitch);
    };
    strands_.push_back({.a = static_cast<std::uint32_t>(line(row, phase) + first),
                        .b = static_cast<std::uint32_t>(line(row + d.down, other) + first + shift),
                        .count = static_cast<std::uint32_t>(count),
                        .springs = static_cast<std::uint32_t>(springs),
                        .family = static_cast<std::uint32_t>(family)});
    springs += (static_cast<std::size_t>(count) + slice - 1) / slice * slice;
  };
  // Along a row phases that are `right` apart take turns; down the columns rows that are `down` apart do.
  const std::size_t turns = 2;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    for (std::size_t row = from; row < to; ++row) {
      if (d.down != 0 && row / d.down % 2 != turn) continue;
      for (std::ptrdiff_t phase = 0; phase < phases; ++phase) {
        if (d.down == 0 && static_cast<std::size_t>(phase / d.right) % 2 != turn) continue;
        add(row, phase);
      }
    }
  }
}

// Each spring gets the first colour that neither of its ends has.
template <class T>
void NetworkProgram<T>::make_colours() {
  make_sweeps();
  std::vector<std::vector<bool>> taken(particles_);
  std::vector<std::vector<std::size_t>> of_colour;
  const auto is_taken = [&](std::size_t i, std::size_t colour) { return colour < taken[i].size() && taken[i][colour]; };
  const auto take = [&](std::size_t i, std::size_t colour) {
    if (taken[i].size() <= colour) taken[i].resize(colour + 1, false);
    taken[i][colour] = true;
  };
  for (std::size_t s = 0; s < pairs_.size(); ++s) {
    const auto [a, b, k, l, c] = pairs_[s];
    if (w_[a] == 0 && w_[b] == 0) continue;
    std::size_t colour = 0;
    while (is_taken(a, colour) || is_taken(b, colour)) ++colour;
    take(a, colour);
    take(b, colour);
    if (of_colour.size() <= colour) of_colour.resize(colour + 1);
    of_colour[colour].push_back(s);
  }
  std::size_t springs = 0;
  for (const auto& list : of_colour) springs += (list.size() + slice - 1) / slice * slice;
  // Lanes without a spring join an element beyond the particles to itself.
  a_.assign(springs, static_cast<std::int32_t>(places_.size));
  b_ = a_;
  T* const kappa = column(springs, 0);
  T* const eta = column(springs, 0);
  T* const l = column(springs, 0);
  T* const inverse = column(springs, 0);
  T* const w_a = column(springs, 0);
  T* const w_b = column(springs, 0);
  std::size_t at = 0;
  for (const auto& list : of_colour) {
    colours_.push_back(at);
    for (const std::size_t s : list) {
      const JoinedPair& p = pairs_[s];
      const Compliances k = compliances(p.k, p.c, w_[p.a] + w_[p.b]);
      a_[at] = static_cast<std::int32_t>(places_.of[p.a]);
      b_[at] = static_cast<std::int32_t>(places_.of[p.b]);
      kappa[at] = static_cast<T>(k.kappa);
      eta[at] = static_cast<T>(k.eta);
      l[at] = static_cast<T>(p.l);
      inverse[at] = static_cast<T>(k.inverse);
      w_a[at] = static_cast<T>(w_[p.a]);
      w_b[at] = static_cast<T>(w_[p.b]);
      ++at;
    }
    at = (at + slice - 1) / slice * slice;
  }
  colours_.push_back(at);
  bytes_ += 2 * springs * sizeof(std::int32_t);
  sweep_.a = a_.data();
  sweep_.b = b_.data();
  sweep_.kappa = kappa;
  sweep_.eta = eta;
  sweep_.l = l;
  sweep_.inverse = inverse;
  sweep_.w_a = w_a;
  sweep_.w_b = w_b;
  keep_sweeps(springs);
}

template class NetworkProgram<float>;
template class NetworkProgram<double>;

}  // namespace dvdx
