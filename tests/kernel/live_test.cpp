// Particles that come and go: against a plain model, whatever the instruction set, layout, threads and batching.
#include "dvdx/live.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/counter_random.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"
#include "turnover/lifecycle.hpp"
#include "work/tasks.hpp"

namespace live_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Layout;

constexpr double h = 1.0 / 64;

Scene fountain() {
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Drag{.coefficient = 0.002, .wind = {1, 0, 0}});
  scene.add(Sinusoid{.acceleration = {0, 0, 2}, .angular_frequency = 3});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  return scene;
}

Emitter jet(double rate, std::uint64_t seed) {
  return {.shape = Disc{.center = {0, 0.1, 0}, .radius = 0.05},
          .rate = rate,
          .velocity = {0, 3, 0},
          .spread = 0.5,
          .least_lifetime = 0.1,
          .most_lifetime = 0.4,
          .seed = seed};
}

// Where particle i is at the start.
template <class T>
T start(std::size_t i, std::size_t axis) {
  return static_cast<T>(2 * test::uniform(5 + axis, i) - 0.5);
}

// A state with its memory, and a number for each particle that goes with it.
template <class T>
class Living {
 public:
  Living(Layout layout, std::size_t capacity)
      : batch_(layout, capacity),
        lives_(layout == Layout::aos ? Layout::aos : layout, capacity),
        ids_(capacity),
        marks_(capacity) {
    live.state = batch_.view();
    live.state.count = 0;
    live.age = lives_.view().x[0];
    live.lifetime = lives_.view().v[1];
    carried_ = {Carried{ids_.data(), sizeof(std::uint32_t), sizeof(std::uint32_t)}, Carried{marks_.data(), 3, 3}};
    live.carried = carried_;
  }
  Living(const Living&) = delete;
  Living& operator=(const Living&) = delete;

  // At rest at places that are drawn, with lifetimes from 0.05 s on, or none.
  void fill(std::size_t count) {
    live.state.count = count;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        live.state.x[axis][i] = start<T>(i, axis);
        live.state.v[axis][i] = T(0);
      }
      live.age[i] = T(0);
      live.lifetime[i] = i % 3 == 0 ? std::numeric_limits<T>::infinity() : static_cast<T>(0.05 + test::uniform(8, i));
      ids_[i] = static_cast<std::uint32_t>(i + 1);
      marks_[i] = {static_cast<char>(i), static_cast<char>(i / 7), 'x'};
    }
  }
  // Every number of particle i says which it is.
  void name(std::size_t i) {
    const auto number = static_cast<T>(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      live.state.x[axis][i] = number + static_cast<T>(axis) / 8;
      live.state.v[axis][i] = -number - static_cast<T>(axis) / 8;
    }
    live.lifetime[i] = number + T(1);
    ids_[i] = static_cast<std::uint32_t>(i);
    marks_[i] = {static_cast<char>(i), static_cast<char>(i / 7), 'x'};
  }
  [[nodiscard]] bool is_named(std::size_t at, std::uint32_t i) const {
    const auto number = static_cast<T>(i);
    bool is_it = live.lifetime[at] == number + T(1) && ids_[at] == i && live.age[at] == T(0) &&
                 marks_[at] == std::array{static_cast<char>(i), static_cast<char>(i / 7), 'x'};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      is_it = is_it && live.state.x[axis][at] == number + static_cast<T>(axis) / 8 &&
              live.state.v[axis][at] == -number - static_cast<T>(axis) / 8;
    }
    return is_it;
  }
  [[nodiscard]] bool is_clean() const { return batch_.is_clean(); }
  [[nodiscard]] std::uint32_t id(std::size_t i) const { return ids_[i]; }
  [[nodiscard]] std::array<char, 3> mark(std::size_t i) const { return marks_[i]; }

  // All numbers of the live particles as bytes.
  [[nodiscard]] std::string bytes() const {
    const std::size_t count = live.state.count;
    const std::vector<T> values = test::values_of(live.state);
    std::vector<T> ages(2 * count);
    for (std::size_t i = 0; i < count; ++i) {
      ages[2 * i] = live.age[i];
      ages[2 * i + 1] = live.lifetime[i];
    }
    std::string all;
    const auto add_all = [&all](const auto* first, std::size_t n) {
      all.append(reinterpret_cast<const char*>(first), n * sizeof *first);
    };
    const auto add = [&](const auto& value) { add_all(&value, 1); };
    add_all(values.data(), values.size());
    add_all(ages.data(), ages.size());
    add_all(ids_.data(), count);
    add_all(marks_.data(), count);
    add(live.born);
    add(live.removed);
    add(live.dropped);
    add(live.state.clock.seconds);
    return all;
  }

  LiveState<T> live;

 private:
  Batch<T> batch_, lives_;
  std::vector<std::uint32_t> ids_;
  std::vector<std::array<char, 3>> marks_;
  std::array<Carried, 2> carried_{};
};

template <class T>
LifecyclePlan<T> make(const Scene& scene, const Lifecycle& turnover, Isa isa = Isa::reference) {
  auto plan = compile<T>(scene, turnover, {.step = h, .isa = isa});
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

template <class T>
void step_all(const LifecyclePlan<T>& plan, LiveState<T>& live, std::size_t steps, std::size_t threads = 1) {
  test::Threads workers(threads);
  REQUIRE(plan.step(live, steps, threads > 1 ? workers.parallel_for() : ParallelFor{}) == StepResult::done);
}

constexpr std::array<SurvivorOrder, 2> orders = {SurvivorOrder::kept, SurvivorOrder::any};

Lifecycle everything(std::size_t capacity, double rate, SurvivorOrder order = SurvivorOrder::kept) {
  Lifecycle turnover{.emitters = {jet(rate, 1), jet(rate / 3, 2)}, .removal = {}, .capacity = capacity};
  turnover.emitters[1].shape = Box{.min = {-1, 0, -1}, .max = {-0.5, 1, -1}};
  turnover.emitters[1].start = 5 * h;
  turnover.removal = {.boundaries = {{.normal = {1, 0, 0}, .offset = -0.7}},
                      .outside = Box{.min = {-9, -9, -9}, .max = {9, 1.2, 9}},
                      .not_finite = NotFinite::removed,
                      .order = order};
  return turnover;
}

// ---- a plain model: one step after another, one particle after another --------------------------------------------------

template <class T>
struct One {
  std::array<T, 3> x{}, v{};
  T age{}, lifetime{};
  std::uint32_t id = 0;
};

// Places of which some are empty.
template <class One>
using Places = std::vector<std::optional<One>>;

template <class One>
void fill_holes(Places<One>& places, std::size_t first, std::size_t last) {
  std::size_t new_end = first;
  for (std::size_t i = first; i < last; ++i) new_end += places[i].has_value() ? 1U : 0U;
  std::size_t hole = first;
  for (std::size_t i = new_end; i < last; ++i) {
    if (!places[i]) continue;
    while (places[hole]) ++hole;
    std::swap(places[hole], places[i]);
  }
}

constexpr std::size_t run = 16384;  // places

// Removes from `all`, from `first` on, without order, as docs/scene.md says. Returns which births found no hole.
template <class One, class IsToGo>
std::vector<One> remove_in_any_order(std::vector<One>& all, std::size_t first, const IsToGo& is_to_go,
                                     const std::vector<One>& births = {}) {
  Places<One> places;
  for (std::size_t i = first; i < all.size(); ++i) {
    places.push_back(is_to_go(all[i]) ? std::nullopt : std::optional<One>(all[i]));
  }
  const std::size_t count = places.size();
  std::vector<One> waiting;
  if (count == 0) waiting = births;
  for (std::size_t i = 0; i < count; i += run) {
    const std::size_t end = std::min(i + run, count);
    std::size_t hole = i;
    for (std::size_t b = births.size() * i / count; b < births.size() * end / count; ++b) {
      while (hole < end && places[hole]) ++hole;
      if (hole == end) {
        waiting.push_back(births[b]);
      } else if (!is_to_go(births[b])) {
        places[hole] = births[b];
      }
    }
    fill_holes(places, i, end);
  }
  std::size_t next = 0;
  for (std::size_t i = 0; i < count && next < waiting.size(); ++i) {
    while (!places[i] && next < waiting.size()) {
      if (!is_to_go(waiting[next])) places[i] = waiting[next];
      ++next;
    }
  }
  waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(next));
  fill_holes(places, 0, places.size());
  all.resize(first);
  for (const auto& place : places) {
    if (place) all.push_back(*place);
  }
  return waiting;
}

template <class T>
class Model {
 public:
  Model(const Scene& scene, const Lifecycle& turnover)
      : plan_(*compile<T>(scene, {.step = h, .isa = Isa::reference})),
        turnover_(turnover),
        compiled_(*compile<T>(scene, {.step = h}), turnover, {}) {}

  std::vector<One<T>> all;
  std::uint64_t dropped = 0;

  void step() {
    Clock next = clock_;
    next.advance(h, 1);
    move();
    if (turnover_.removal.order == SurvivorOrder::any && all.size() + wanted(next) <= turnover_.capacity) {
      step_in_any_order(next);
    } else {
      remove(0);
      const std::size_t survivors = all.size();
      for (std::size_t e = 0; e < turnover_.emitters.size(); ++e) bear(e, next);
      remove(survivors);
    }
    clock_ = next;
  }

 private:
  [[nodiscard]] std::uint64_t until(std::size_t e, const Clock& end) const {
    const Emitter& emitter = turnover_.emitters[e];
    return static_cast<std::uint64_t>(std::max(0.0, end.seconds - emitter.start) * emitter.rate);
  }
  [[nodiscard]] std::uint64_t wanted(const Clock& end) const {
    std::uint64_t births = 0;
    for (std::size_t e = 0; e < turnover_.emitters.size(); ++e) births += until(e, end) - born_[e];
    return births;
  }
  // Newborn particles take the places of those that go. The rest of the newborn follow behind.
  void step_in_any_order(const Clock& end) {
    const auto goes = [this](const One<T>& one) { return is_to_go(one); };
    std::vector<One<T>> before;
    before.swap(all);
    for (std::size_t e = 0; e < turnover_.emitters.size(); ++e) bear(e, end);
    const std::vector<One<T>> births = std::exchange(all, before);
    const std::vector<One<T>> waiting = remove_in_any_order(all, 0, goes, births);
    const std::size_t survivors = all.size();
    all.insert(all.end(), waiting.begin(), waiting.end());
    remove(survivors);
  }
  void remove(std::size_t first) {
    const auto goes = [this](const One<T>& one) { return is_to_go(one); };
    if (turnover_.removal.order == SurvivorOrder::any) {
      remove_in_any_order(all, first, goes);
      return;
    }
    std::erase_if(all, goes);
  }
  void move() {
    if (all.empty()) return;
    State<T> state = aos(all[0].x.data(), all[0].v.data(), sizeof(One<T>), all.size());
    state.clock = clock_;
    REQUIRE(plan_.step(state) == StepResult::done);
    for (One<T>& one : all) one.age += static_cast<T>(h);
  }
  [[nodiscard]] bool is_to_go(const One<T>& one) const {
    bool goes = one.age >= one.lifetime;
    for (const auto& [normal, offset] : turnover_.removal.boundaries) {
      T at = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) at += static_cast<T>(normal[axis]) * one.x[axis];
      goes = goes || at < static_cast<T>(offset);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (const auto& box = turnover_.removal.outside) {
        goes = goes || one.x[axis] < static_cast<T>(box->min[axis]) || one.x[axis] > static_cast<T>(box->max[axis]);
      }
      const bool is_finite = std::isfinite(one.x[axis]) && std::isfinite(one.v[axis]);
      goes = goes || (turnover_.removal.not_finite == NotFinite::removed && !is_finite);
    }
    return goes;
  }
  void bear(std::size_t e, const Clock& end) {
    const Emitter& emitter = turnover_.emitters[e];
    const double since = std::max(0.0, end.seconds - emitter.start);
    const std::uint64_t last = until(e, end);
    for (std::uint64_t& n = born_[e]; n < last; ++n) {
      if (all.size() == turnover_.capacity) {
        ++dropped;
        continue;
      }
      const double lead = since * emitter.rate - (static_cast<double>(n) + 1);
      reference_separate.emit(compiled_.emitters[e], {.first = n, .count = 1, .lead = lead, .step = h}, *born_values_);
      One<T> one;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        one.x[axis] = static_cast<T>(born_values_->x[axis][0]);
        one.v[axis] = static_cast<T>(born_values_->v[axis][0]);
      }
      one.age = static_cast<T>(born_values_->age[0]);
      one.lifetime = static_cast<T>(born_values_->lifetime[0]);
      all.push_back(one);
    }
  }

  Plan<T> plan_;
  Lifecycle turnover_;
  CompiledLifecycle<T> compiled_;
  Clock clock_{};
  std::array<std::uint64_t, 2> born_{};
  std::unique_ptr<Born> born_values_ = std::make_unique<Born>();
};

template <class T>
void check_same(const Model<T>& model, const Living<T>& living, std::size_t step) {
  CAPTURE(step);
  REQUIRE(living.live.state.count == model.all.size());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < model.all.size(); ++i) {
    const One<T>& one = model.all[i];
    bool is_same = living.live.age[i] == one.age && living.live.lifetime[i] == one.lifetime && living.id(i) == one.id;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      is_same = is_same && living.live.state.x[axis][i] == one.x[axis] && living.live.state.v[axis][i] == one.v[axis];
    }
    if (!is_same) ++wrong;
  }
  CHECK(wrong == 0);
  CHECK(living.live.dropped == model.dropped);
}

// Rates of which a step holds a whole number of 64ths, so that the model's plain products are exact.
// Particles from `dying` on, for a run, die in the first step.
void check_against_model(const Lifecycle& turnover, std::size_t steps, std::size_t dying = std::size_t(-1),
                         std::optional<std::size_t> at_start = std::nullopt) {
  const std::size_t capacity = turnover.capacity, count = at_start.value_or(capacity / 2);
  Model<float> model(fountain(), turnover);
  Living<float> living(Layout::soa, capacity);
  living.fill(count);
  for (std::size_t i = dying; i < count && i - dying < run; ++i) living.live.lifetime[i] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    One<float> one{.x = {}, .v = {}, .age = living.live.age[i], .lifetime = living.live.lifetime[i], .id = living.id(i)};
    for (std::size_t axis = 0; axis < 3; ++axis) one.x[axis] = living.live.state.x[axis][i];
    model.all.push_back(one);
  }
  const auto plan = make<float>(fountain(), turnover);
  for (std::size_t step = 0; step < steps; ++step) {
    model.step();
    step_all(plan, living.live, 1);
    check_same(model, living, step);
  }
  CHECK(living.live.removed > 0);
}

// All numbers after 24 steps, in calls of so many.
template <class T>
std::string after(Isa isa, Layout layout, std::size_t capacity, std::size_t call, SurvivorOrder order, double rate) {
  Living<T> living(layout, capacity);
  living.fill(capacity * 2 / 3);
  if (capacity > 20) living.live.state.v[1][17] = std::numeric_limits<T>::quiet_NaN();
  const auto plan = make<T>(fountain(), everything(capacity, rate, order), isa);
  for (std::size_t done = 0; done < 24; done += call) step_all(plan, living.live, std::min(call, 24 - done));
  CHECK(living.is_clean());
  return living.bytes();
}

TEST_CASE("births and removals are as a plain model says, with room and without") {
  for (const SurvivorOrder order : orders) {
    check_against_model(everything(600, 192, order), 40);
    check_against_model(everything(100, 384, order), 40);
  }
}

// The last of them take the places of the first, but of none that was there before.
TEST_CASE("births that are removed in their own step, three runs of them, leave the others as a plain model says") {
  Lifecycle turnover = everything(45'000, 64 * 36'000, SurvivorOrder::any);
  turnover.emitters.erase(turnover.emitters.begin());
  turnover.emitters[0].rate = 64 * 36'000;
  turnover.emitters[0].start = 0;
  check_against_model(turnover, 2, std::size_t(-1), 3000);
}

// Three runs: some have more births than holes, some fewer, and of the births some go at once.
TEST_CASE("births that find no hole in their run take the ends of others, as a plain model says") {
  for (const double births : {200.0, 2000.0, 9000.0}) {
    Lifecycle turnover = everything(5 * run, 64 * births, SurvivorOrder::any);
    turnover.emitters[1].start = 0;
    turnover.emitters[1].rate = 64 * std::floor(births / 3);
    check_against_model(turnover, births == 2000 ? 4 : 2);
  }
}

TEST_CASE("where all of one run goes, births that find no hole in the others take its end, and the last the rest of it") {
  Lifecycle turnover{.emitters = {jet(64 * 6000, 1)}, .removal = {.order = SurvivorOrder::any}, .capacity = 5 * run};
  check_against_model(turnover, 2, run);
}

TEST_CASE_TEMPLATE("same bits on every ISA, in every layout and in every batch of steps", T, float, double) {
  for (const SurvivorOrder order : orders) {
    for (const std::size_t capacity : {std::size_t{1}, std::size_t{40}, std::size_t{333}}) {
      const double rate = 4.0 * static_cast<double>(capacity);
      const std::string wanted = after<T>(Isa::reference, Layout::soa, capacity, 1, order, rate);
      constexpr std::array<std::size_t, 3> calls = {1, 5, 24};
      std::size_t turn = capacity;  // so that each ISA and each layout meets every call
      for (const Isa isa : available_isas()) {
        for (const Layout layout : test::layouts) {
          const std::size_t call = calls[turn++ % calls.size()];
          CAPTURE(name(isa));
          CAPTURE(test::name(layout));
          CAPTURE(call);
          CHECK(after<T>(isa, layout, capacity, call, order, rate) == wanted);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("same bits on any number of threads" * doctest::test_suite("threads"), T, float, double) {
  // Threads are worth their while from so many particles on in calls of 4, and in any order from so many at each step.
  constexpr std::size_t in_fours = steps_worth_threads / 4 + 700, each = steps_worth_threads + 700;
  const auto check = [](const Lifecycle& turnover, std::size_t count, std::size_t steps) {
    const auto bytes = [&](Layout layout, std::size_t call, std::size_t threads) {
      Living<T> living(layout, turnover.capacity);
      living.fill(count);
      const auto plan = make<T>(fountain(), turnover, best_isa());
      for (std::size_t done = 0; done < steps; done += call) step_all(plan, living.live, call, threads);
      CHECK(living.live.removed > 500);
      CHECK(living.live.born > 10000);
      return living.bytes();
    };
    const std::string wanted = bytes(Layout::soa, 1, 1);
    CHECK(bytes(Layout::soa, steps, 3) == wanted);
    CHECK(bytes(Layout::aosoa16, 4, 2) == wanted);
    CHECK(bytes(Layout::aos, 4, 5) == wanted);
  };
  const Lifecycle ordered = everything(in_fours * 2 + 3, 120'000);
  check({.emitters = ordered.emitters, .removal = {}, .capacity = ordered.capacity}, in_fours, 8);
  check(ordered, in_fours, 8);
  Lifecycle unordered = everything(each + 20'003, 160'000, SurvivorOrder::any);
  unordered.emitters[1].start = 0;
  check(unordered, each, 4);
}

// None, some and all particles go, up to three runs of them.
TEST_CASE("without order, hundreds of removals leave what a plain list says, and every column goes with its particle") {
  constexpr std::size_t capacity = 3 * run + 5;
  const auto plan = make<float>({}, {.removal = {.order = SurvivorOrder::any}, .capacity = capacity}, best_isa());
  Living<float> living(Layout::soa, capacity);
  test::Threads workers(2);
  std::size_t wrong = 0;
  for (std::uint32_t trial = 0; trial < 300; ++trial) {
    const auto drawn = [trial](std::uint64_t i, std::uint32_t what) { return unit_value(trial, i, what); };
    const std::size_t most = trial % 30 == 0 ? capacity : 300;
    const auto count = static_cast<std::size_t>(drawn(0, 8) * static_cast<double>(most + 1));
    const double share = std::max(0.0, 1.2 * drawn(0, 9) - 0.1);
    std::vector<std::uint32_t> wanted(count);
    std::vector<bool> goes(count);
    living.live.state.count = count;
    for (std::size_t i = 0; i < count; ++i) {
      wanted[i] = static_cast<std::uint32_t>(i);
      goes[i] = test::uniform(100 + trial, i) < share;
      living.name(i);
      living.live.age[i] = goes[i] ? std::numeric_limits<float>::infinity() : 0.0F;
    }
    remove_in_any_order(wanted, 0, [&](std::uint32_t i) { return goes[i]; });
    REQUIRE(plan.remove(living.live, workers.parallel_for()) == StepResult::done);
    REQUIRE(living.live.state.count == wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) wrong += living.is_named(i, wanted[i]) ? 0U : 1U;
  }
  CHECK(wrong == 0);
}

TEST_CASE("without order, births and then the last take the places of those that go; births not sure of room follow") {
  struct Case {
    std::size_t capacity;
    std::array<std::uint32_t, 7> wanted;  // a birth has no number
  };
  for (const auto& [capacity, wanted] : {Case{10, {1, 0, 9, 4, 5, 6, 7}}, Case{9, {1, 7, 9, 4, 5, 6, 0}}}) {
    const auto plan =
        make<double>({}, {.emitters = {{.rate = 64}}, .removal = {.order = SurvivorOrder::any}, .capacity = capacity});
    Living<double> living(Layout::soa, capacity);
    living.fill(9);
    for (const std::size_t i : {1U, 2U, 7U}) living.live.age[i] = std::numeric_limits<double>::infinity();
    step_all(plan, living.live, 1);
    REQUIRE(living.live.state.count == 7);
    for (std::size_t i = 0; i < wanted.size(); ++i) CHECK(living.id(i) == wanted[i]);
    CHECK(living.live.removed == 3);
    CHECK(living.live.born == 1);
  }
}

TEST_CASE("most that go at once find the spill too small, and the bits are the same") {
  constexpr std::size_t capacity = steps_worth_threads + 4;
  const auto bytes = [&](std::size_t threads) {
    Living<float> living(Layout::soa, capacity);
    living.fill(capacity);
    for (std::size_t i = 0; i < capacity; ++i) living.live.lifetime[i] = i % 4 == 3 ? 1.0F : 0.001F;
    const auto plan = make<float>(fountain(), {.emitters = {}, .removal = {}, .capacity = capacity});
    step_all(plan, living.live, 1, threads);
    CHECK(living.live.state.count == capacity / 4);
    CHECK(living.id(5) == 4 * 5 + 4);
    CHECK(living.mark(5) == std::array{char{23}, char{3}, 'x'});
    return living.bytes();
  };
  CHECK(bytes(2) == bytes(1));
}

TEST_CASE("births are exact over long times, whatever the decimals of rate and step") {
  struct Case {
    double rate, step;
    std::uint64_t steps, births;
  };
  for (const auto& [rate, step, steps, births] :
       {Case{60, 1.0 / 60, 1'000'000, 1'000'000}, Case{0.1, 0.001, 30'000'000, 3'000}, Case{1.0 / 3, 0.1, 3'000'000, 100'000},
        Case{1e6, 0.01, 777, 7'770'000}, Case{0, 0.01, 1000, 0}, Case{7, 1.0 / 60, 3600, 420}}) {
    Clock clock;
    clock.advance(step, static_cast<double>(steps));
    CHECK(births_by({.rate = rate}, clock).whole == births);
    Clock before;
    before.advance(step, static_cast<double>(steps) - 1);
    CHECK((rate == 0 || births_by({.rate = rate}, before).whole < births));
  }
}

TEST_CASE("an emitter works from its start to its end") {
  const Emitter emitter{.rate = 10, .start = 1, .end = 2.55};
  const auto by = [&](double seconds) { return births_by(emitter, {.seconds = seconds, .carry = 0}).whole; };
  CHECK(by(0) == 0);
  CHECK(by(1) == 0);
  CHECK(by(1.1) == 1);
  CHECK(by(2.5) == 15);
  CHECK(by(1e9) == 15);
  const Emitter burst{.rate = 160'000, .start = 1.2, .end = 1.25};  // the difference of which is not what its decimals say
  CHECK(births_by(burst, {.seconds = 2, .carry = 0}).whole == 8000);
}

// Times and rates are taken for what they are to 2^-50 of themselves: sums of that size are only right to their last bit.
TEST_CASE("a birth belongs to a time that is earlier by its rounding, and to none that is earlier than that") {
  const Emitter emitter{.rate = 1};
  const auto by = [&](double seconds) { return births_by(emitter, {.seconds = seconds, .carry = 0}).whole; };
  for (const double number : {1.0, 2.0, 1024.0}) {  // (1 - 2^-50) (1 + 2^-50) = 1 - 2^-100 is below 1
    const double early = number * (1 - 0x1p-50);
    CHECK(by(early) == static_cast<std::uint64_t>(number) - 1);
    CHECK(by(std::nextafter(early, 2 * number)) == static_cast<std::uint64_t>(number));
  }
}

TEST_CASE("a birth lies in its disc, and has a lifetime between the least and the most") {
  Emitter emitter = jet(64000, 5);
  emitter.shape = Disc{.center = {1, 2, 3}, .normal = {0, 1, 0}, .radius = 0.05};
  emitter.velocity = {};
  emitter.spread = 0.0;
  emitter.least_lifetime = 2;
  emitter.most_lifetime = 2.5;
  const auto plan = make<double>({}, {.emitters = {emitter}, .removal = {}, .capacity = 1000});
  Living<double> living(Layout::soa, 1000);
  step_all(plan, living.live, 1);
  REQUIRE(living.live.state.count == 1000);
  double most_x = 0, most_z = 0, shortest = 9, longest = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    const double dx = living.live.state.x[0][i] - 1, dz = living.live.state.x[2][i] - 3;
    CHECK(living.live.state.x[1][i] == 2);
    CHECK(dx * dx + dz * dz <= 0.0025 * (1 + 1e-12));
    most_x = std::max(most_x, std::abs(dx));
    most_z = std::max(most_z, std::abs(dz));
    shortest = std::min(shortest, living.live.lifetime[i]);
    longest = std::max(longest, living.live.lifetime[i]);
  }
  CHECK(most_x > 0.045);
  CHECK(most_z > 0.045);
  CHECK(shortest >= 2);
  CHECK(shortest < 2.05);
  CHECK(longest > 2.45);
  CHECK(longest <= 2.5);
}

// 2 m a step towards the box: a step after its birth each would be inside.
TEST_CASE("a particle born outside goes at its birth, in a call of many steps as in calls of one") {
  for (const SurvivorOrder order : orders) {
    const Lifecycle turnover{.emitters = {{.shape = Vec3{2, 0, 0}, .rate = 64, .velocity = {-128, 0, 0}}},
                             .removal = {.outside = Box{.min = {-1, -1, -1}, .max = {1, 1, 1}}, .order = order},
                             .capacity = 20};
    const auto plan = make<double>({}, turnover);
    for (const std::size_t each : {1U, 10U}) {
      Living<double> living(Layout::soa, 20);
      for (std::size_t done = 0; done < 10; done += each) step_all(plan, living.live, each);
      CHECK(living.live.born == 10);
      CHECK(living.live.removed == 10);
      CHECK(living.live.state.count == 0);
    }
  }
}

TEST_CASE("a full state drops births and counts them") {
  const auto plan = make<float>({}, {.emitters = {{.rate = 640, .seed = 3}}, .removal = {}, .capacity = 25});
  Living<float> living(Layout::soa, 25);
  step_all(plan, living.live, 10);
  CHECK(living.live.state.count == 25);
  CHECK(living.live.born == 25);
  CHECK(living.live.dropped == 75);
}

TEST_CASE("births within a step stand as far apart as the time between them") {
  const auto plan = make<double>({}, {.emitters = {{.rate = 256, .velocity = {2, 0, 0}}}, .removal = {}, .capacity = 100});
  Living<double> living(Layout::soa, 100);
  step_all(plan, living.live, 5);
  REQUIRE(living.live.state.count == 20);
  for (std::size_t i = 0; i < 20; ++i) {
    const double age = (19 - static_cast<double>(i)) / 256;
    CHECK(is_close(living.live.age[i], age, 1e-12));
    CHECK(is_close(living.live.state.x[0][i], 2 * age, 1e-12));
  }
}

TEST_CASE("particles that are not finite stay unless they are to be removed, and others are as they were") {
  for (const auto treatment : {NotFinite::kept, NotFinite::removed}) {
    const auto plan = make<float>({}, {.emitters = {}, .removal = {.not_finite = treatment}, .capacity = 50});
    Living<float> living(Layout::soa, 50);
    living.fill(50);
    for (std::size_t i = 0; i < 50; ++i) living.live.lifetime[i] = std::numeric_limits<float>::infinity();
    living.live.state.x[2][7] = std::numeric_limits<float>::quiet_NaN();
    living.live.state.v[0][31] = std::numeric_limits<float>::infinity();
    living.live.age[40] = std::numeric_limits<float>::quiet_NaN();
    step_all(plan, living.live, 1);
    CHECK(living.live.state.count == (treatment == NotFinite::kept ? 50 : 48));
    CHECK(living.id(6) == 7);
    CHECK(living.id(treatment == NotFinite::kept ? 49 : 47) == 50);
  }
}

TEST_CASE("remove takes away what the caller marked, and moves nothing on") {
  const auto plan = make<float>(fountain(), {.emitters = {jet(100, 1)}, .removal = {}, .capacity = 40});
  Living<float> living(Layout::aos, 40);
  living.fill(40);
  living.live.age[0] = living.live.age[39] = std::numeric_limits<float>::infinity();
  const float x = living.live.state.x[1][1];
  REQUIRE(plan.remove(living.live) == StepResult::done);
  CHECK(living.live.state.count == 38);
  CHECK(living.live.removed == 2);
  CHECK(living.id(0) == 2);
  CHECK(living.live.state.x[1][0] == x);
  CHECK(living.live.state.clock.seconds == 0);
}

TEST_CASE("one that goes is closed up behind, far from where it was and where no other goes, on any number of threads" *
          doctest::test_suite("threads")) {
  constexpr std::size_t capacity = steps_worth_threads + 1000;
  const auto plan = make<float>({}, {.emitters = {}, .removal = {}, .capacity = capacity});
  for (const std::size_t threads : {std::size_t{1}, std::size_t{3}}) {
    Living<float> living(Layout::soa, capacity);
    living.fill(capacity);
    for (std::size_t i = 0; i < capacity; ++i) living.live.lifetime[i] = std::numeric_limits<float>::infinity();
    living.live.lifetime[2] = 0;
    step_all(plan, living.live, 1, threads);
    REQUIRE(living.live.state.count == capacity - 1);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < capacity - 1; ++i) {
      const std::size_t was = i < 2 ? i : i + 1;
      const bool is_right = living.id(i) == was + 1 && living.mark(i)[1] == static_cast<char>(was / 7) &&
                            living.live.state.x[1][i] == start<float>(was, 1);
      wrong += is_right ? 0U : 1U;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("a column without room for all is said, and nothing is stepped") {
  const auto plan = make<float>({}, {.emitters = {}, .removal = {}, .capacity = 41});
  Living<float> living(Layout::soa, 40);
  living.fill(40);
  CHECK(plan.step(living.live) == StepResult::capacity_too_small);
  CHECK(living.live.state.clock.seconds == 0);
}

TEST_CASE("particles whose time is not finite neither come nor go") {
  const auto plan = make<float>({}, {.emitters = {Emitter{.rate = 1000}}, .removal = {}, .capacity = 40});
  Living<float> living(Layout::soa, 40);
  living.fill(20);
  living.live.state.clock.seconds = std::numeric_limits<double>::infinity();
  ContactReport report(0);
  CHECK(plan.step(living.live) == StepResult::time_not_finite);
  CHECK(plan.step(living.live, report) == StepResult::time_not_finite);
  CHECK(plan.remove(living.live) == StepResult::time_not_finite);
  CHECK(living.live.state.count == 20);
  CHECK(living.live.born == 0);
}

TEST_CASE("a scene whose particles cannot come and go is an error that names its field") {
  const auto message = [](const Scene& scene, const Lifecycle& turnover, double step = h) {
    const auto plan = compile<float>(scene, turnover, {.step = step});
    REQUIRE_FALSE(plan.has_value());
    return plan.error().message();
  };
  const Lifecycle some{.emitters = {jet(10, 1)}, .removal = {}, .capacity = 10};
  Scene masses;
  masses.mass = std::vector<double>{1, 2};
  CHECK(message(masses, some) == "mass is given for each particle: must be alike for all particles where they come and go");
  CHECK(message(Scene{}.add(Spring{.stiffness = 1.0, .anchor = at_start}), some).starts_with("forces[0].anchor is given"));
  CHECK(message(Scene{}.add(Drag{.coefficient = std::vector<double>{1}}), some).starts_with("forces[0].coefficient is given"));
  CHECK(message(Scene{}.add(Network(Grid{})), some).starts_with("networks is there"));
  CHECK(message(Scene{}, some, -0.1).starts_with("step is -0.1"));
  Scene far;
  far.origin = Vec3{1e6, 0, 0};
  CHECK(message(far, some).starts_with("origin is there"));
  CHECK_FALSE(compile<float>(Scene{}, some, {.step = h, .rounding = Rounding::compensated}).has_value());
  CHECK(message(Scene{}, {}).starts_with("capacity is 0"));
  const auto with = [&](auto change) {
    Lifecycle turnover = some;
    change(turnover);
    return message(Scene{}, turnover);
  };
  CHECK(with([](Lifecycle& t) { t.emitters[0].rate = -1; }) == "emitters[0].rate is -1: must be a finite number >= 0");
  CHECK(with([](Lifecycle& t) {
          t.emitters[0].shape = Disc{.normal = {}};
        }).starts_with("emitters[0].shape.normal is of length 0"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].least_lifetime = 0; }).starts_with("emitters[0].least_lifetime is 0"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].most_lifetime = 0.01; }).starts_with("emitters[0].most_lifetime is 0.01"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].end = -1; }).starts_with("emitters[0].end is -1"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].spread = -1.0; }).starts_with("emitters[0].spread is -1"));
  CHECK(with([](Lifecycle& t) { t.removal.boundaries.resize(9); }).starts_with("removal.boundaries is 9 of them"));
  CHECK(with([](Lifecycle& t) {
          t.removal.outside = Box{.min = {1, 0, 0}, .max = {}};
        }).starts_with("removal.outside.min[0] is 1"));
}

}  // namespace live_test
