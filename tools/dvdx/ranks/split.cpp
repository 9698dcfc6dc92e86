#include "ranks/split.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "dvdx/layouts/convert.hpp"
#include "ranks/agree.hpp"
#include "run/start.hpp"
#include "scale/cut.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/plan_fault.hpp"

namespace dvdx::tool {

HaloExchange::HaloExchange(Ranks& ranks, const Part& part) : ranks_(ranks), part_(part) {
  for (const Neighbour& neighbour : part_.neighbours) {
    buffers_.push_back({std::vector<double>(3 * neighbour.sent.size()), std::vector<double>(3 * neighbour.received.size())});
  }
}

namespace {

// As many numbers as the buffer holds of double.
template <class A>
std::span<A> numbers(std::vector<double>& room) noexcept {
  return {static_cast<A*>(static_cast<void*>(room.data())), room.size()};
}

}  // namespace

template <class A>
void HaloExchange::send(const HaloColumns& columns) noexcept {
  const std::vector<Neighbour>& neighbours = part_.neighbours;
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    ranks_.start_receive(static_cast<int>(neighbours[n].part), std::as_writable_bytes(numbers<A>(buffers_[n].received)));
  }
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    const auto sent = numbers<A>(buffers_[n].sent);
    std::size_t next = 0;
    for (const auto* column : columns.columns) {
      for (const std::uint32_t i : neighbours[n].sent) sent[next++] = static_cast<const A*>(column)[columns.element[i]];
    }
    ranks_.start_send(static_cast<int>(neighbours[n].part), std::as_bytes(sent));
  }
}

template <class A>
void HaloExchange::receive(const HaloColumns& columns) noexcept {
  const std::vector<Neighbour>& neighbours = part_.neighbours;
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    const auto received = numbers<A>(buffers_[n].received);
    std::size_t next = 0;
    for (auto* column : columns.columns) {
      for (const std::uint32_t i : neighbours[n].received) static_cast<A*>(column)[columns.element[i]] = received[next++];
    }
  }
}

void HaloExchange::start(void* context, const HaloColumns& columns) noexcept {
  auto& self = *static_cast<HaloExchange*>(context);
  columns.scalar_bytes == sizeof(float) ? self.send<float>(columns) : self.send<double>(columns);
}

void HaloExchange::finish(void* context, const HaloColumns& columns) noexcept {
  auto& self = *static_cast<HaloExchange*>(context);
  const auto before = std::chrono::steady_clock::now();
  self.ranks_.finish();
  self.waited_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  columns.scalar_bytes == sizeof(float) ? self.receive<float>(columns) : self.receive<double>(columns);
}

namespace {

// Stripes, or what METIS cuts of a list where that tells less and leaves no rank without particles.
std::vector<std::uint32_t> chosen_owners(const SceneFile& file, std::uint32_t ranks) {
  const std::size_t count = file.particles.count;
  auto owners = stripes(file.scene, count, ranks);
  if (only_sheet(file.scene, count) != nullptr || file.scene.coupling.scheme == Scheme::sequential) return owners;
  const auto pairs = joined(file.scene, count);
  auto by_metis = owners_by_metis(pairs, count, ranks);
  if (!by_metis) return owners;
  const Cut cut = cut_of_pairs(pairs, *by_metis, ranks);
  const bool tells_less = cut.all_halo < cut_of_pairs(pairs, owners, ranks).all_halo;
  return tells_less && cut.fewest > 0 ? std::move(*by_metis) : owners;
}

// The first rank's choice: another's library may cut otherwise.
Part part_here(const SceneFile& file, Ranks& ranks) {
  auto owners = together(ranks, [&] {
    return ranks.rank() == 0 ? chosen_owners(file, static_cast<std::uint32_t>(ranks.count()))
                             : std::vector<std::uint32_t>(file.particles.count);
  });
  ranks.broadcast(0, std::as_writable_bytes(std::span(owners)));
  return together(ranks, [&] { return part_of(file.scene, owners, static_cast<std::uint32_t>(ranks.rank())); });
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

// Air's pulses are told between the same parts as the springs' are: all of them must have some.
void check_air(const SceneFile& whole, const Part& part, const Scene& scene) {
  if (part.neighbours.empty() || !is_in_air(whole.scene) || is_in_air(scene)) return;
  throw Fault(Exit::bad_scene, whole.path +
                                   ": network.aerodynamics cannot be split over so many ranks: one of them would hold "
                                   "no triangle that meets air (docs/ranks.md)");
}

std::vector<std::uint32_t> own_places(const Part& part) {
  std::vector<std::uint32_t> places;
  for (std::size_t k = 0; k < part.particles.size(); ++k) {
    if (part.is_own[k] != 0) places.push_back(static_cast<std::uint32_t>(k));
  }
  return places;
}

// Of every rank, on the first one.
std::vector<std::vector<std::uint32_t>> owned_by_all(Ranks& ranks, const Part& part, std::span<const std::uint32_t> own) {
  std::vector<std::uint32_t> numbers;
  for (const std::uint32_t k : own) numbers.push_back(part.particles[k]);
  std::vector<std::uint64_t> sizes(static_cast<std::size_t>(ranks.count()), 0);
  sizes[static_cast<std::size_t>(ranks.rank())] = numbers.size();
  ranks.sum(sizes);
  if (ranks.rank() != 0) {
    ranks.send(0, std::as_bytes(std::span(numbers)));
    return {};
  }
  std::vector<std::vector<std::uint32_t>> all{std::move(numbers)};
  for (int rank = 1; rank < ranks.count(); ++rank) {
    all.emplace_back(sizes[static_cast<std::size_t>(rank)]);
    ranks.receive(rank, std::as_writable_bytes(std::span(all.back())));
  }
  return all;
}

template <class T>
State<T> started(const SceneFile& file, State<T> state) {
  place_at_start(file, state);
  return state;
}

}  // namespace

template <class T>
Split<T>::Split(const SceneFile& file, const Engine& engine, Ranks& ranks, const NetworkLimit& limit)
    : ranks_(ranks),
      part_(part_here(file, ranks)),
      own_(own_places(part_)),
      all_(file.particles.count),
      halo_(ranks, part_),
      file_(file_of(file, part_, limit.substeps)),
      memory_(engine.layout, part_.particles.size(), rounding_of(engine.precision)),
      state_(started(file_, memory_.view())),
      owned_(owned_by_all(ranks, part_, own_)) {
  Options options{
      .step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic, .rounding = rounding_of(engine.precision)};
  options.unstable = Unstable::allowed;  // the whole scene's plan was not refused
  options.elsewhere = elsewhere_of(file.scene, file.particles.count);
  options.elsewhere.springs_damp = is_any_damped(file.scene);
  options.elsewhere.rho = limit.rho;
  if (part_.sweeps) options.elsewhere.sweeps = &*part_.sweeps;
  options.elsewhere.exchange = halo_.exchange();
  together(ranks, [&] {
    if (part_.particles.empty()) return;
    check_air(file, part_, file_.scene);
    auto plan = compile<T>(file_.scene, options, state_);
    if (!plan) throw fault_of(file_, plan.error());
    plan_.emplace(std::move(*plan));
  });
}

template <class T>
void Split<T>::step(std::uint64_t steps, ContactReport* report, const ParallelFor& parallel) {
  if (!plan_) return state_.clock.advance(file_.step, static_cast<double>(steps));
  const StepResult result =
      report != nullptr ? plan_->step(state_, *report, steps, parallel) : plan_->step(state_, steps, parallel);
  if (result != StepResult::done) throw std::logic_error("the plan is for another state");
}

template <class T>
std::vector<const std::array<Column<T>, 3>*> Split<T>::columns(const State<T>& state) const {
  if (!state.has_rests()) return {&state.x, &state.v};
  return {&state.x, &state.v, &state.x_rest, &state.v_rest};
}

template <class T>
void Split<T>::gather(State<T>& whole) {
  const auto here = columns(state_);
  buffer_.clear();
  for (const auto* three : here) {
    for (const auto& column : *three) {
      for (const std::uint32_t k : own_) buffer_.push_back(column[k]);
    }
  }
  if (ranks_.rank() != 0) return ranks_.send(0, std::as_bytes(std::span(buffer_)));
  whole.clock = state_.clock;
  for (int rank = 0; rank < ranks_.count(); ++rank) {
    const auto& numbers = owned_[static_cast<std::size_t>(rank)];
    buffer_.resize(3 * here.size() * numbers.size());
    if (rank > 0) ranks_.receive(rank, std::as_writable_bytes(std::span(buffer_)));
    const T* next = buffer_.data();
    for (const auto* three : columns(whole)) {
      for (const auto& column : *three) {
        for (const std::uint32_t i : numbers) column[i] = *next++;
      }
    }
  }
}

// All of them are told all of it, some at a time, and take what they step.
template <class T>
void Split<T>::go_on(const State<T>& whole, std::vector<double>& carried) {
  std::uint64_t count = carried.size();
  ranks_.broadcast(0, writable_bytes_in(count));
  carried.resize(count);
  ranks_.broadcast(0, std::as_writable_bytes(std::span(carried)));
  Clock clock = whole.clock;
  ranks_.broadcast(0, writable_bytes_in(clock));
  state_.clock = clock;
  std::vector<std::uint32_t> in_order(part_.particles.size());
  std::iota(in_order.begin(), in_order.end(), 0U);
  std::sort(in_order.begin(), in_order.end(),
            [this](std::uint32_t a, std::uint32_t b) { return part_.particles[a] < part_.particles[b]; });
  constexpr std::size_t at_once = std::size_t{1} << 16U;
  std::vector<T> some(at_once);
  const auto from = columns(whole);
  const auto to = columns(state_);
  for (std::size_t n = 0; n < 3 * to.size(); ++n) {
    auto next = in_order.begin();
    for (std::size_t first = 0; first < all_; first += at_once) {
      const std::size_t end = std::min(all_, first + at_once);
      if (ranks_.rank() == 0) dvdx::gather((*from[n / 3])[n % 3], first, end - first, some.data());
      ranks_.broadcast(0, std::as_writable_bytes(std::span(some).first(end - first)));
      for (; next != in_order.end() && part_.particles[*next] < end; ++next) {
        (*to[n / 3])[n % 3][*next] = some[part_.particles[*next] - first];
      }
    }
  }
  together(ranks_, [&] {
    if (plan_ && !plan_->restore(carried_here(carried), state_))
      throw Fault(Exit::input_output, "the checkpoint is of another plan");
  });
}

template <class T>
std::vector<std::uint32_t> Split<T>::owner() const {
  std::vector<std::uint32_t> owner(ranks_.rank() == 0 ? all_ : 0);
  for (std::size_t rank = 0; rank < owned_.size(); ++rank) {
    for (const std::uint32_t i : owned_[rank]) owner[i] = static_cast<std::uint32_t>(rank);
  }
  return owner;
}

namespace {

// What a plan carries begins with whether it remembers accelerations, and three of each of its particles where it does
// (execute/carried.cpp); what else it carries is alike on all ranks.
bool remembers(std::span<const double> carried) { return !carried.empty() && carried[0] != 0; }

}  // namespace

template <class T>
std::vector<double> Split<T>::carried() {
  const std::vector<double> here = plan_ ? plan_->carried(state_) : std::vector<double>();
  std::array<double, 1> any_remembers{remembers(here) ? 1.0 : 0.0};
  ranks_.highest(any_remembers);
  if (any_remembers[0] == 0) return here;
  std::vector<double> own;
  for (const std::uint32_t k : own_) {
    for (std::size_t axis = 0; axis < 3; ++axis) own.push_back(here[1 + 3 * std::size_t{k} + axis]);
  }
  if (ranks_.rank() != 0) {
    ranks_.send(0, std::as_bytes(std::span(own)));
    return {};
  }
  std::vector<double> whole(1 + 3 * all_, 1);
  whole.insert(whole.end(), here.begin() + static_cast<std::ptrdiff_t>(1 + 3 * part_.particles.size()), here.end());
  for (int rank = 0; rank < ranks_.count(); ++rank) {
    const auto& numbers = owned_[static_cast<std::size_t>(rank)];
    own.resize(3 * numbers.size());
    if (rank > 0) ranks_.receive(rank, std::as_writable_bytes(std::span(own)));
    const double* next = own.data();
    for (const std::uint32_t i : numbers) {
      for (std::size_t axis = 0; axis < 3; ++axis) whole[1 + 3 * std::size_t{i} + axis] = *next++;
    }
  }
  return whole;
}

// Of what the whole scene's plan would carry, this part's.
template <class T>
std::vector<double> Split<T>::carried_here(std::span<const double> whole) const {
  if (!remembers(whole) || whole.size() < 1 + 3 * all_) return {whole.begin(), whole.end()};
  std::vector<double> here{1};
  for (const std::uint32_t i : part_.particles) {
    const auto of = whole.subspan(1 + 3 * std::size_t{i}, 3);
    here.insert(here.end(), of.begin(), of.end());
  }
  const auto rest = whole.subspan(1 + 3 * all_);
  here.insert(here.end(), rest.begin(), rest.end());
  return here;
}

template class Split<float>;
template class Split<double>;

}  // namespace dvdx::tool
