#include "run/split.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "ranks/agree.hpp"
#include "ranks/cut.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/start.hpp"

namespace dvdx::tool {

namespace {

// Returns stripes, or the METIS cut of a spring list if it has a smaller halo and leaves no rank without particles.
std::vector<std::uint32_t> chosen_owners(const SceneFile& file, std::uint32_t ranks) {
  const std::size_t count = file.particles.count;
  auto owners = stripes(file.scene, count, ranks);
  if (file.scene.networks.empty()) return owners;
  if (only_sheet(file.scene, count) != nullptr || file.scene.coupling.scheme == Scheme::sequential) return owners;
  const auto pairs = joined(file.scene, count);
  auto by_metis = owners_by_metis(pairs, count, ranks);
  if (!by_metis) return owners;
  const Cut cut = cut_of_pairs(pairs, *by_metis, ranks);
  const bool tells_less = cut.all_halo < cut_of_pairs(pairs, owners, ranks).all_halo;
  return tells_less && cut.fewest > 0 ? std::move(*by_metis) : owners;
}

// The first rank chooses the owners for all: another rank's METIS may cut differently.
Part part_here(const SceneFile& file, Ranks& ranks) {
  const auto rank = static_cast<std::uint32_t>(ranks.rank());
  const auto count = static_cast<std::uint32_t>(ranks.count());
  if (auto part = together(ranks, [&] { return part_of_sheet(file.scene, file.particles.count, count, rank); })) {
    return std::move(*part);
  }
  auto owners = together(ranks, [&] {
    return ranks.rank() == 0 ? chosen_owners(file, static_cast<std::uint32_t>(ranks.count()))
                             : std::vector<std::uint32_t>(file.particles.count);
  });
  ranks.broadcast(0, std::as_writable_bytes(std::span(owners)));
  return together(ranks, [&] {
    auto part = part_of(file.scene, owners, static_cast<std::uint32_t>(ranks.rank()));
    if (!part) throw std::logic_error("owners of the ranks' own: " + part.error().message());
    return std::move(*part);
  });
}

Vectors taken(const Vectors& vectors, std::span<const std::uint32_t> particles) {
  if (std::holds_alternative<Vec3>(vectors)) return vectors;
  std::vector<Vec3> each;
  each.reserve(particles.size());
  for (const std::uint32_t i : particles) each.push_back(value_of(vectors, i));
  return each;
}

SceneFile file_of(const SceneFile& whole, const Part& part, int substeps) {
  SceneFile file{.path = whole.path, .name = whole.name, .about = {}, .particles = {}, .scene = scene_of(whole.scene, part)};
  file.step = whole.step;
  file.scene.coupling.substeps = substeps;
  file.particles = {.count = part.particles.size(),
                    .position = taken(whole.particles.position, part.particles),
                    .velocity = taken(whole.particles.velocity, part.particles)};
  return file;
}

bool is_any_damped(const Scene& scene) {
  for (const Network& network : scene.networks) {
    if (std::visit([](const auto& springs) { return springs.damping != 0; }, network)) return true;
  }
  return false;
}

bool is_in_air(const Scene& scene) {
  return std::any_of(scene.networks.begin(), scene.networks.end(), [](const Network& network) {
    return std::visit([](const auto& springs) { return springs.aerodynamics.has_value(); }, network);
  });
}

// Ranks exchange pulses of the air with the same neighbours as those of springs, so all of these parts must have some.
void check_air(const SceneFile& whole, const Part& part, const Scene& scene) {
  if (part.neighbours.empty() || !is_in_air(whole.scene) || is_in_air(scene)) return;
  throw Fault(Exit::bad_scene, whole.path +
                                   ": network.aerodynamics cannot be split over so many ranks: one of them would hold "
                                   "no triangle that meets air (docs/ranks.md)");
}

// A sweep's colours are chosen from the unbroken springs. A part of sheets side by side has only some of them, with its own
// numbers.
void check_tearing(const SceneFile& whole, const Part& part) {
  const bool is_swept = whole.scene.coupling.scheme == Scheme::sequential;
  if (whole.tears_at.empty() || !is_swept || (!part.sweeps && whole.scene.networks.size() == 1)) return;
  throw Fault(Exit::bad_scene, whole.path +
                                   ": network.tears_at by scheme sequential cannot be split over ranks, but of one sheet: must "
                                   "run on one, or by leapfrog (docs/ranks.md)");
}

// Returns the indices in part.particles, sorted by the scene's numbers.
std::vector<std::uint32_t> by_number(const Part& part) {
  std::vector<std::uint32_t> places(part.particles.size());
  std::iota(places.begin(), places.end(), 0U);
  std::sort(places.begin(), places.end(),
            [&](std::uint32_t a, std::uint32_t b) { return part.particles[a] < part.particles[b]; });
  return places;
}

std::vector<std::uint32_t> own_places(const Part& part) {
  std::vector<std::uint32_t> places;
  for (std::size_t k = 0; k < part.particles.size(); ++k) {
    if (part.is_own[k] != 0) places.push_back(static_cast<std::uint32_t>(k));
  }
  return places;
}

std::vector<std::uint32_t> numbers_of(const Part& part, std::span<const std::uint32_t> places) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(places.size());
  for (const std::uint32_t k : places) numbers.push_back(part.particles[k]);
  return numbers;
}

template <class T>
State<T> started(const SceneFile& file, State<T> state) {
  place_at_start(file, state);
  return state;
}

// Returns the start of all particles, m from the scene's origin, as the plan of the whole scene would find it.
template <class T>
std::vector<Vec3> places_at_start(const SceneFile& file, Rounding rounding) {
  StateMemory<T> memory(Layout::soa, file.particles.count, rounding);
  const State<T> state = started(file, memory.view());
  std::vector<Vec3> start(state.count);
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      start[i][axis] = static_cast<double>(state.x[axis][i]);
      if (rounding == Rounding::compensated) start[i][axis] += static_cast<double>(state.x_rest[axis][i]);
    }
  }
  return start;
}

}  // namespace

std::optional<NetworkLimit> limit_by_rows(const SceneFile& file, Ranks& ranks) {
  const Grid* const sheet = only_sheet(file.scene, file.particles.count);
  if (sheet == nullptr || !sheet->broken.empty() || sheet->aerodynamics) return std::nullopt;
  if (!file.tears_at.empty() || !file.scene.skins.empty()) return std::nullopt;
  if (!file.scene.constraints.empty() || file.scene.meet) return std::nullopt;  // these ask for sub-steps of their own
  const SheetRates mine = together(ranks, [&] {
    const Run rows = share_of(ranks).of(sheet->rows);
    return rates_of_rows(file.scene, rows.first, rows.first + rows.count);
  });
  std::array<double, 3> highest{mine.of_k, mine.of_c, mine.w};
  ranks.highest(highest);
  return limit_of_sheet(file.scene, file.step, {.of_k = highest[0], .of_c = highest[1], .w = highest[2]});
}

template <class T>
Split<T>::Split(const SceneFile& file, const Engine& engine, Ranks& ranks, const NetworkLimit& limit)
    : ranks_(ranks),
      part_(part_here(file, ranks)),
      own_(own_places(part_)),
      all_(file.particles.count),
      halo_(ranks, part_),
      file_(file_of(file, part_, limit.substeps)),
      layout_(engine.layout),
      options_{
          .step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic, .rounding = rounding_of(engine.precision)},
      memory_(layout_, part_.particles.size(), options_.rounding),
      state_(started(file_, memory_.view())),
      ranges_(ranks, all_, numbers_of(part_, own_), own_) {
  options_.unstable = Unstable::allowed;  // the whole scene's plan was not refused
  options_.elsewhere = elsewhere_of(file.scene, file.particles.count);
  options_.elsewhere.springs_damp = is_any_damped(file.scene);
  options_.elsewhere.rho = limit.rho;
  if (part_.sweeps) options_.elsewhere.sweeps = &*part_.sweeps;
  options_.elsewhere.exchange = halo_.exchange();
  if (file.scene.meet) {
    auto start = together(ranks, [&] { return places_at_start<T>(file, options_.rounding); });
    meetings_.emplace(ranks, file.scene, std::move(start), part_);
    options_.elsewhere.meetings = meetings_->shared();
  }
  if (!file.tears_at.empty()) by_number_ = by_number(part_);
  together(ranks, [&] {
    check_tearing(file, part_);
    if (part_.particles.empty()) return;
    check_air(file, part_, file_.scene);
    plan_.emplace(made(state_));
    (void)plan_->step(state_, 0);  // places kinematic particles where they are at the start
  });
  std::array<double, 1> driven{plan_ ? std::max(0.0, static_cast<double>(plan_->carried(state_).size()) - 1) : 0};
  ranks_.highest(driven);
  carried_shape_ = {.meets = file.scene.meet.has_value(), .driven = static_cast<std::size_t>(driven[0])};
}

template <class T>
Plan<T> Split<T>::made(const State<T>& start) const {
  auto plan = compile<T>(file_.scene, options_, start);
  if (!plan) throw fault_of(file_, plan.error());
  return std::move(*plan);
}

template <class T>
void Split<T>::step(std::uint64_t steps, ContactReport* report, const ParallelFor& parallel) {
  const auto take = [&] {
    if (!plan_) return state_.clock.advance(file_.step, static_cast<double>(steps));
    const StepResult result =
        report != nullptr ? plan_->step(state_, *report, steps, parallel) : plan_->step(state_, steps, parallel);
    check_stepped(result, file_, state_.clock.seconds, static_cast<double>(steps) * file_.step);
  };
  // All ranks with particles stop alike. together() tells the ranks without particles.
  meetings_ ? together(ranks_, take) : take();
}

template <class T>
void Split<T>::to_ranges(State<T>& range) {
  ranges_.to_ranges(state_, range);
}

template <class T>
void Split<T>::go_on(const State<T>& range, const CarriedInRanges& carried) {
  RangeExchange(ranks_, all_, part_.particles).from_ranges(range, state_);
  const std::vector<double> here = carried_here(carried);
  together(ranks_, [&] {
    if (plan_ && !plan_->restore(here, state_)) throw Fault(Exit::input_output, "the checkpoint is of another plan");
  });
}

template <class T>
std::optional<std::uint32_t> Split<T>::place_of(std::uint32_t number) const {
  const auto found = std::lower_bound(by_number_.begin(), by_number_.end(), number,
                                      [&](std::uint32_t place, std::uint32_t n) { return part_.particles[place] < n; });
  if (found == by_number_.end() || part_.particles[*found] != number) return std::nullopt;
  return *found;
}

// Each rank sends the springs whose lesser end it owns.
template <class T>
std::vector<Pair> Split<T>::too_long(std::size_t network, double stretch) const {
  std::vector<Pair> mine;
  if (plan_) {
    const auto found = plan_->too_long(network, stretch, state_);
    if (!found) throw std::logic_error(found.error().message());
    for (const auto& [i, j] : *found) {
      const bool is_turned = part_.particles[j] < part_.particles[i];
      const std::uint32_t a = is_turned ? j : i, b = is_turned ? i : j;
      if (part_.is_own[a] != 0) mine.push_back({part_.particles[a], part_.particles[b]});
    }
  }
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(ranks_.count()), 0);
  counts[static_cast<std::size_t>(ranks_.rank())] = mine.size();
  ranks_.sum(counts);
  std::vector<Pair> all;
  for (int rank = 0; rank < ranks_.count(); ++rank) {
    std::vector<Pair> some = rank == ranks_.rank() ? mine : std::vector<Pair>(counts[static_cast<std::size_t>(rank)]);
    if (some.empty()) continue;
    ranks_.broadcast(rank, std::as_writable_bytes(std::span(some)));
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

template <class T>
void Split<T>::break_springs(std::size_t network, std::span<const Pair> torn) {
  together(ranks_, [&] {
    if (!plan_) return;
    const bool has_all = std::holds_alternative<Grid>(plan_->scene().networks.at(network));
    std::vector<Pair> here;
    for (const auto& [i, j] : torn) {
      const auto a = place_of(i), b = place_of(j);
      if (a && b && (has_all || part_.is_own[*a] != 0 || part_.is_own[*b] != 0)) here.push_back({*a, *b});
    }
    if (here.empty()) return;
    if (const auto done = plan_->break_springs(network, here); !done) throw fault_of(file_, done.error());
  });
}

template <class T>
void Split<T>::take(const NetworkLimit& limit) {
  if (limit.substeps == file_.scene.coupling.substeps && limit.rho == options_.elsewhere.rho) return;
  file_.scene.coupling.substeps = limit.substeps;
  options_.elsewhere.rho = limit.rho;
  together(ranks_, [&] {
    if (!plan_) return;
    StateMemory<T> memory(layout_, part_.particles.size(), options_.rounding);
    file_.scene.networks = plan_->scene().networks;
    const auto carried = plan_->carried(state_);
    Plan<T> plan = made(started(file_, memory.view()));
    if (!plan.restore(carried, state_)) throw std::logic_error("the plan is for another state");
    plan_.emplace(std::move(plan));
  });
}

template <class T>
std::vector<std::uint32_t> Split<T>::owner() const {
  std::vector<std::uint32_t> owner(all_);
  for (int rank = 0; rank < ranks_.count(); ++rank) {
    auto numbers = rank == ranks_.rank() ? numbers_of(part_, own_) : std::vector<std::uint32_t>();
    std::uint64_t count = numbers.size();
    ranks_.broadcast(rank, writable_bytes_in(count));
    numbers.resize(count);
    ranks_.broadcast(rank, std::as_writable_bytes(std::span(numbers)));
    for (const std::uint32_t i : numbers) owner[i] = static_cast<std::uint32_t>(rank);
  }
  return owner;
}

namespace {

// A plan's carried numbers begin with a flag: whether anything is remembered. If so and particles meet, a time, the counts of
// pairs and of surfaces, and six numbers of each follow. Then come three of each particle if accelerations are remembered, and
// the rest (plan/carried.cpp). Returns how many come before the accelerations, by the first four; 0 if nothing is remembered.
double before_accelerations(std::span<const double> first, const CarriedShape& shape) {
  if (first.empty() || first[0] == 0) return 0;
  return shape.meets && first.size() >= 4 ? 4 + 6 * (first[2] + first[3]) : 1;
}

// Views one axis of the three numbers of each particle.
Column<double> axis_of(std::vector<double>& numbers, std::size_t axis) {
  return {.base = numbers.data() + axis, .stride = 3 * sizeof(double), .run = 1, .capacity = numbers.size() / 3};
}

}  // namespace

void CarriedInRanges::save(Sink& sink) const {
  if (!remembers) return sink.put(std::span<const double>(alike));
  sink.put<std::uint64_t>(before.size() + 3 * all + alike.size());
  for (const double number : before) sink.put(number);
  sink.put_part(std::span<const double>(range));
  for (const double number : alike) sink.put(number);
}

void CarriedInRanges::load(Source& source, std::size_t particles, const Run& mine, const CarriedShape& shape) {
  all = particles;
  const auto count = source.get<std::uint64_t>();
  if (count > source.left() / sizeof(double)) source.fail();
  const auto read_to = [&](std::vector<double>& list, std::size_t size) {
    for (std::size_t k = list.size(); k < size; ++k) list.push_back(source.get<double>());
  };
  read_to(before, std::min<std::size_t>(count, shape.meets ? 4 : 1));
  const double wanted = before_accelerations(before, shape);
  if (!(wanted <= static_cast<double>(count))) source.fail();
  read_to(before, static_cast<std::size_t>(wanted));
  remembers = wanted > 0 && count == before.size() + 3 * all + shape.driven;
  if (!remembers) {
    alike = std::move(before);
    return read_to(alike, count);
  }
  range.resize(3 * mine.count);
  source.skip(3 * mine.first * sizeof(double));
  for (double& number : range) source.get(number);
  source.skip(3 * (all - mine.first - mine.count) * sizeof(double));
  read_to(alike, shape.driven);
}

template <class T>
CarriedInRanges Split<T>::carried() {
  const std::vector<double> here = plan_ ? plan_->carried(state_) : std::vector<double>();
  const auto before = static_cast<std::size_t>(before_accelerations(here, carried_shape_));
  const std::size_t accelerations = 3 * part_.particles.size();
  const bool accelerates = before != 0 && here.size() == before + accelerations + carried_shape_.driven;
  std::array<double, 1> any_accelerates{accelerates ? 1.0 : 0.0};
  ranks_.highest(any_accelerates);
  CarriedInRanges carried{.remembers = any_accelerates[0] != 0, .all = all_};
  if (!carried.remembers) {
    carried.alike = here;
    return carried;
  }
  const auto first = here.begin() + static_cast<std::ptrdiff_t>(before);
  const auto behind = accelerates ? first + static_cast<std::ptrdiff_t>(accelerations) : first;
  carried.before.assign(here.begin(), first);
  carried.alike.assign(behind, here.end());
  std::vector<double> mine(first, behind);
  carried.range.resize(3 * share_of(ranks_).of(all_).count);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ranges_.to_ranges(axis_of(mine, axis), axis_of(carried.range, axis));
  }
  return carried;
}

// Returns the numbers that this part's plan carries.
template <class T>
std::vector<double> Split<T>::carried_here(const CarriedInRanges& carried) const {
  if (!carried.remembers) return carried.alike;
  RangeExchange exchange(ranks_, all_, part_.particles);
  std::vector<double> range = carried.range;
  std::vector<double> here(3 * part_.particles.size());
  for (std::size_t axis = 0; axis < 3; ++axis) exchange.from_ranges(axis_of(range, axis), axis_of(here, axis));
  here.insert(here.begin(), carried.before.begin(), carried.before.end());
  here.insert(here.end(), carried.alike.begin(), carried.alike.end());
  return here;
}

template class Split<float>;
template class Split<double>;

}  // namespace dvdx::tool
