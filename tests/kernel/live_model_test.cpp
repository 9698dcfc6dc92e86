// Particles that come and go, compared with a plain model.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "dvdx/counter_random.hpp"
#include "dvdx/live.hpp"
#include "kernel/living.hpp"
#include "lifecycle/compiled_lifecycle.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace living::model_test {

template <class T>
struct One {
  std::array<T, 3> x{}, v{};
  T age{}, lifetime{};
  std::uint32_t id = 0;
};

// Places, some of them empty.
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

// Removes from `all`, from `first` on, without order, as in docs/scene.md. Returns the births that found no hole.
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
  // Newborn particles take the places of removed ones. The remaining newborn ones follow behind.
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

// The rates give a whole number of 64ths in a step, so that the model's plain products are exact. Particles of one run from
// `dying` on die in the first step.
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

TEST_CASE("births and removals are as a plain model says, with room and without") {
  for (const SurvivorOrder order : orders) {
    check_against_model(everything(600, 192, order), 40);
    check_against_model(everything(100, 384, order), 40);
  }
}

// The last births take the places of the first ones removed, but of no particle that was there before.
TEST_CASE("births removed in their own step, in three runs, leave the others as a plain model does") {
  Lifecycle turnover = everything(45'000, 64 * 36'000, SurvivorOrder::any);
  turnover.emitters.erase(turnover.emitters.begin());
  turnover.emitters[0].rate = 64 * 36'000;
  turnover.emitters[0].start = 0;
  check_against_model(turnover, 2, std::size_t(-1), 3000);
}

// Three runs: some have more births than holes, some fewer, and some births are removed at once.
TEST_CASE("births without a hole in their run take the ends of others, as a plain model says") {
  for (const double births : {200.0, 2000.0, 9000.0}) {
    Lifecycle turnover = everything(5 * run, 64 * births, SurvivorOrder::any);
    turnover.emitters[1].start = 0;
    turnover.emitters[1].rate = 64 * std::floor(births / 3);
    check_against_model(turnover, births == 2000 ? 4 : 2);
  }
}

TEST_CASE("a whole run that goes is filled by births without a hole elsewhere and then by the last, as a plain model says") {
  Lifecycle turnover{.emitters = {jet(64 * 6000, 1)}, .removal = {.order = SurvivorOrder::any}, .capacity = 5 * run};
  check_against_model(turnover, 2, run);
}

// None, some and all particles are removed, up to three runs of them.
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

}  // namespace living::model_test
