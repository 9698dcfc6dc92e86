// Balls that meet, and come and go: poured, piled up, drained.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/live.hpp"
#include "kernel/meeting.hpp"
#include "math/vec3.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace live_meet_test {

using namespace dvdx;
using test::Balls;
using test::Batch;
using test::Layout;

constexpr double h = 1.0 / 60;
constexpr double r = 0.01;  // m

// A state with its memory.
template <class T>
class Alive {
 public:
  explicit Alive(std::size_t capacity, Layout layout = Layout::soa) : batch_(layout, capacity), lives_(layout, capacity) {
    live.state = batch_.view();
    live.state.count = 0;
    live.age = lives_.view().x[0];
    live.lifetime = lives_.view().v[1];
  }
  Alive(const Alive&) = delete;
  Alive& operator=(const Alive&) = delete;

  void add(const Vec3& x, const Vec3& v = {}, double lifetime = std::numeric_limits<double>::infinity()) {
    const std::size_t i = live.state.count++;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      live.state.x[axis][i] = static_cast<T>(x[axis]);
      live.state.v[axis][i] = static_cast<T>(v[axis]);
    }
    live.age[i] = T(0);
    live.lifetime[i] = static_cast<T>(lifetime);
  }
  void add(const Balls& balls) {
    for (std::size_t i = 0; i < balls.size(); ++i) add(balls.x[i], balls.v[i]);
  }
  void take(const LiveState<T>& from) {
    for (std::size_t i = 0; i < from.state.count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        live.state.x[axis][i] = from.state.x[axis][i];
        live.state.v[axis][i] = from.state.v[axis][i];
      }
      live.age[i] = from.age[i];
      live.lifetime[i] = from.lifetime[i];
    }
    live.state.count = from.state.count;
    live.state.clock = from.state.clock;
    live.born = from.born;
    live.removed = from.removed;
    live.dropped = from.dropped;
  }
  [[nodiscard]] std::size_t count() const { return live.state.count; }
  [[nodiscard]] Vec3 x(std::size_t i) const { return at(live.state.x, i); }
  [[nodiscard]] Vec3 v(std::size_t i) const { return at(live.state.v, i); }
  [[nodiscard]] double fastest() const {
    double most = 0;
    for (std::size_t i = 0; i < count(); ++i) most = std::max(most, length(v(i)));
    return most;
  }
  [[nodiscard]] bool is_clean() const { return batch_.is_clean() && lives_.is_clean(); }
  // Everything that steps change.
  [[nodiscard]] std::string bytes() const {
    std::string all;
    const auto add = [&all](const auto& value) { all.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (std::size_t i = 0; i < count(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        add(T(live.state.x[axis][i]));
        add(T(live.state.v[axis][i]));
      }
      add(T(live.age[i]));
      add(T(live.lifetime[i]));
    }
    for (const std::uint64_t number : {live.born, live.removed, live.dropped}) add(number);
    add(live.state.clock.seconds);
    return all;
  }

  LiveState<T> live;

 private:
  static Vec3 at(const std::array<Column<T>, 3>& columns, std::size_t i) {
    return {double{columns[0][i]}, double{columns[1][i]}, double{columns[2][i]}};
  }
  Batch<T> batch_, lives_;
};

template <class T>
LifecyclePlan<T> made(const Scene& scene, const Lifecycle& turnover, Options options = {.step = h}) {
  auto plan = compile<T>(scene, turnover, options);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

// A box of 9 by 9 balls, open at the top, for balls of one radius.
Scene box() {
  Scene scene = test::box_of(0.18, 0.4);
  scene.mass = 0.02;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Meet{.radius = r, .friction = 0.4});
  return scene;
}

Emitter hose(double rate) {
  return {.shape = Disc{.center = {0.09, 0.3, 0.09}, .radius = 0.06},
          .rate = rate,
          .velocity = {0, -1.5, 0},
          .spread = 0.1,
          .seed = 5};
}

Lifecycle poured(std::size_t capacity, double rate) { return {.emitters = {hose(rate)}, .removal = {}, .capacity = capacity}; }

template <class T>
void step(const LifecyclePlan<T>& plan, Alive<T>& alive, std::size_t steps = 1) {
  REQUIRE(plan.step(alive.live, steps) == StepResult::done);
}

// The deepest penetration of all pairs, relative to a pair's wanted distance.
template <class T>
double deepest(const Alive<T>& alive) {
  double deepest = 0;
  for (std::size_t i = 0; i < alive.count(); ++i) {
    for (std::size_t j = 0; j < i; ++j) deepest = std::max(deepest, 1 - distance(alive.x(i), alive.x(j)) / (2 * r));
  }
  return deepest;
}

// ---- bits -----------------------------------------------------------------------------------------------------------------

TEST_CASE_TEMPLATE("balls of a live plan without births or removals step as a plan's do, to the bit", T, float, double) {
  const Scene scene = box();
  Balls balls;
  for (std::size_t n = 0; n < 9; ++n) {
    balls.add({0.03 + 0.021 * static_cast<double>(n % 3), 0.012 + 0.05 * static_cast<double>(n / 3), 0.05},
              {0.3 * static_cast<double>(n % 2), 0, 0});
  }
  test::Stepped<T> expected(scene, balls, {.step = h});
  const auto plan = made<T>(scene, {.emitters = {}, .removal = {}, .capacity = 40});
  Alive<T> alive(40);
  alive.add(balls);
  expected.step(12);
  step(plan, alive, 12);
  CHECK(test::values_of(alive.live.state) == test::values_of(expected.state()));
  CHECK(plan.meetings().touching > 0);
}

// Births, deaths in the middle and at the edge, a full capacity.
Lifecycle with_deaths() {
  Lifecycle turnover = poured(130, 450);
  turnover.emitters[0].least_lifetime = 0.2;
  turnover.emitters[0].most_lifetime = 0.7;
  turnover.removal.boundaries = {{.normal = {-1, 0, 0}, .offset = -0.155}};
  return turnover;
}

TEST_CASE_TEMPLATE("pours have the same bits on every ISA, in every layout and by any calls", T, float, double) {
  const Scene scene = box();
  constexpr std::size_t steps = 52, capacity = 130;
  Alive<T> expected(capacity);
  step(made<T>(scene, with_deaths(), {.step = h, .isa = Isa::reference}), expected, steps);
  CHECK(expected.live.removed > 50);
  CHECK(expected.live.dropped > 0);
  const auto isas = available_isas();
  std::size_t turn = 0;
  for (const Layout layout : test::layouts) {
    const std::size_t call = std::array<std::size_t, 3>{1, 13, 52}[turn % 3];
    const Options options{.step = h, .isa = isas[(turn + turn / 3) % isas.size()], .block = turn % 2 == 0 ? 16U : 0U};
    const auto plan = made<T>(scene, with_deaths(), options);
    Alive<T> alive(capacity, layout);
    for (std::size_t done = 0; done < steps; done += call) step(plan, alive, call);
    CHECK(alive.bytes() == expected.bytes());
    CHECK(alive.is_clean());
    ++turn;
  }
}

TEST_CASE("threads change no bit of a batch large enough for them to take part") {
  constexpr std::size_t capacity = 18'000, first = 16'300;
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.4});
  scene.add(Meet{.radius = r});
  scene.coupling.substeps = 2;
  Lifecycle turnover = poured(capacity, 6000);
  turnover.emitters[0].shape = Box{.min = {-1, 1, -1}, .max = {1, 2, 1}};
  const auto plan = made<float>(scene, turnover);
  const auto fill = [](Alive<float>& alive) {
    for (std::size_t i = 0; i < first; ++i) {
      const auto place = [&](std::size_t k) { return 0.0205 * static_cast<double>(k); };
      alive.add({place(i % 40), 0.0105 + place(i / 1600), place(i / 40 % 40)}, {}, i % 97 == 0 ? 1.5 * h : 10.0);
    }
  };
  Alive<float> alone(capacity), together(capacity);
  fill(alone);
  fill(together);
  LiveWorkspace<float> workspace = plan.workspace();
  test::Threads threads(3);
  step(plan, alone, 4);
  REQUIRE(plan.step(together.live, workspace, 4, threads.parallel_for()) == StepResult::done);
  CHECK(alone.count() > 16'384);
  CHECK(alone.live.removed > 100);
  CHECK(threads.calls() > 10);
  CHECK(alone.bytes() == together.bytes());
}

TEST_CASE_TEMPLATE("a run goes on elsewhere from any step: no bit depends on when lists were built", T, float, double) {
  const Scene scene = box();
  Alive<T> expected(130);
  const auto plan = made<T>(scene, with_deaths());
  step(plan, expected, 30);
  auto before = std::make_unique<LifecyclePlan<T>>(made<T>(scene, with_deaths()));
  auto state = std::make_unique<Alive<T>>(130);
  Alive<T> forgetful(130);
  step(*before, *state, 10);
  forgetful.take(state->live);
  for (std::size_t n = 0; n < 20; ++n) {
    auto other = std::make_unique<Alive<T>>(130);
    other->take(state->live);
    auto next = std::make_unique<LifecyclePlan<T>>(made<T>(scene, with_deaths()));
    REQUIRE(next->restore(before->carried(state->live), other->live).has_value());
    step(*next, *other);
    std::swap(before, next);
    std::swap(state, other);
  }
  CHECK(state->bytes() == expected.bytes());
  step(made<T>(scene, with_deaths()), forgetful, 20);  // without the carried data
  CHECK(forgetful.bytes() != expected.bytes());
}

TEST_CASE("numbers that were carried from elsewhere are refused") {
  auto plan = made<double>(box(), poured(100, 400));
  Alive<double> alive(100);
  step(plan, alive, 40);
  std::vector<double> carried = plan.carried(alive.live);
  REQUIRE(carried.size() > 20);
  CHECK(plan.restore(carried, alive.live).has_value());
  --alive.live.state.count;
  CHECK(plan.carried(alive.live)[0] == 0);  // nothing: after a removal by hand, the remaining balls are unknown
  ++alive.live.state.count;
  Alive<double> few(100);
  few.add({0.05, 0.5, 0.05});
  CHECK_FALSE(plan.restore(carried, few.live).has_value());
  carried.pop_back();
  CHECK_FALSE(plan.restore(carried, alive.live).has_value());
  Lifecycle turnover = poured(100, 400);
  Scene scene = box();
  scene.meet.reset();
  CHECK(made<double>(scene, turnover).carried(alive.live).empty());
}

// ---- piles ----------------------------------------------------------------------------------------------------------------

TEST_CASE_TEMPLATE("a pile is poured, settles without overlap, and drains", T, float, double) {
  Lifecycle turnover = poured(300, 400);
  turnover.emitters[0].end = 0.6;
  turnover.removal.boundaries = {{.normal = {0, 1, 0}, .offset = -0.3}};
  Scene scene = box();
  auto plan = made<T>(scene, turnover);
  Alive<T> alive(300);
  step(plan, alive, 150);
  CHECK(alive.count() == 240);
  CHECK(alive.live.dropped == 0);
  CHECK(deepest(alive) < 0.02);
  CHECK(alive.fastest() < 0.1);
  for (std::size_t i = 0; i < alive.count(); ++i) CHECK(alive.x(i)[1] > 0.98 * r);
  Plane sunk = std::get<Plane>(scene.contacts[0]);
  sunk.offset = -9;
  REQUIRE(plan.set_contact(0, sunk).has_value());
  step(plan, alive, 40);
  CHECK(alive.count() == 0);
  CHECK(alive.live.removed == 240);
}

TEST_CASE("a full capacity drops births and keeps the living balls") {
  Lifecycle turnover = poured(50, 2000);
  const auto plan = made<double>(box(), turnover);
  Alive<double> alive(50);
  step(plan, alive, 60);
  CHECK(alive.count() == 50);
  CHECK(alive.live.born == 50);
  CHECK(alive.live.dropped == 1950);
  CHECK(alive.is_clean());
  step(plan, alive, 60);
  CHECK(deepest(alive) < 0.02);
}

// The pulses of pairs (i, j), and births, as carried() lists them, with the indices after the dead have been removed.
std::vector<double> renumbered(const std::vector<double>& carried, const std::vector<double>& after) {
  std::vector<double> kept(carried.begin(), carried.begin() + 4);
  std::size_t next = 4;
  for (const std::size_t kind : {std::size_t{2}, std::size_t{3}}) {
    double count = 0;
    for (double k = 0; k < carried[kind]; ++k, next += 6) {
      const double i = after[static_cast<std::size_t>(carried[next])];
      const double j = kind == 2 ? after[static_cast<std::size_t>(carried[next + 1])] : carried[next + 1];
      if (i < 0 || j < 0) continue;
      kept.insert(kept.end(), {i, j});
      kept.insert(kept.end(), carried.begin() + static_cast<std::ptrdiff_t>(next) + 2,
                  carried.begin() + static_cast<std::ptrdiff_t>(next) + 6);
      ++count;
    }
    kept[kind] = count;
  }
  const std::size_t births = kept.size();
  kept.push_back(0);
  for (double k = 0; k < carried[next]; ++k) {
    const double i = after[static_cast<std::size_t>(carried[next + 1 + static_cast<std::size_t>(k)])];
    if (i < 0) continue;
    kept.push_back(i);
    ++kept[births];
  }
  return kept;
}

TEST_CASE_TEMPLATE("carried numbers of pairs stay with their balls when others before them die", T, float, double) {
  Lifecycle turnover = poured(1300, 0);
  const auto plan = made<T>(box(), turnover);
  Alive<T> alive(1300);
  alive.add(test::heap(1280, 8, 2 * r));  // more than a task
  step(plan, alive, 12);
  for (std::size_t n = 0; n < 10; ++n) alive.add({0.05, 0.5 + 0.003 * static_cast<double>(n), 0.09});  // overlapping
  step(plan, alive);
  const std::vector<double> before = plan.carried(alive.live);
  REQUIRE(before[2] > 1000);
  REQUIRE(before[3] > 20);
  std::vector<double> after(alive.count());
  double number = 0;
  for (std::size_t i = 0; i < alive.count(); ++i) {
    const bool dies = i % 7 == 2;
    if (dies) alive.live.age[i] = std::numeric_limits<T>::infinity();
    after[i] = dies ? -1 : number++;
  }
  REQUIRE(plan.remove(alive.live) == StepResult::done);
  CHECK(static_cast<double>(alive.count()) == number);
  CHECK(plan.carried(alive.live) == renumbered(before, after));
  CHECK(plan.meetings().touching > 1);  // those of the last sub-step that remain
  step(plan, alive, 3);
  CHECK(alive.fastest() < 1.5);
}

TEST_CASE("a ball that dies in a pile leaves a hole, and the others sink into it without a jolt") {
  const auto plan = made<double>(box(), poured(600, 0));
  Alive<double> alive(600);
  alive.add(test::heap(512, 8, 2 * r));
  step(plan, alive, 120);
  const std::size_t middle = 200;
  alive.live.age[middle] = std::numeric_limits<double>::infinity();
  step(plan, alive);
  CHECK(alive.count() == 511);
  step(plan, alive);
  CHECK(alive.fastest() < 0.6);
}

// ---- births ---------------------------------------------------------------------------------------------------------------

TEST_CASE_TEMPLATE("balls that are born within each other part slowly", T, float, double) {
  Lifecycle turnover = poured(40, 0);
  turnover.emitters[0].shape = Vec3{0.09, 0.02, 0.09};
  turnover.emitters[0].velocity = {};
  turnover.emitters[0].spread = 0.001;
  const auto plan = made<T>(box(), turnover);
  Alive<T> alive(40);
  alive.add({0.09, 0.011, 0.09});
  REQUIRE(plan.burst(alive.live, 0, 12).has_value());
  const double parting = 0.25 * std::sqrt(9.81 * r);
  double fastest = 0;
  for (int n = 0; n < 30; ++n) {
    step(plan, alive);
    fastest = std::max(fastest, alive.fastest());
  }
  CHECK(fastest > 0.5 * parting);
  CHECK(fastest < 20 * parting);  // several push one ball, and those above fall
  step(plan, alive, 90);
  CHECK(deepest(alive) < 0.02);
}

TEST_CASE("balls that all began apart are pushed apart as a plan's are, however deep they come") {
  Scene scene = box();
  scene.meet->rounds = 2;
  const Balls balls = test::heap(400, 8, 2 * r);
  test::Stepped<double> expected(scene, balls, {.step = h});
  const auto plan = made<double>(scene, poured(400, 0));
  Alive<double> alive(400);
  alive.add(balls);
  expected.step(40);
  step(plan, alive, 40);
  CHECK(plan.meetings().overlap_most > 0.03);
  CHECK(test::values_of(alive.live.state) == test::values_of(expected.state()));
}

TEST_CASE("two balls that begin within each other part at the documented speed, with and without a weight") {
  for (const double g : {9.81, 0.0}) {
    Scene scene;
    scene.add(Constant{.acceleration = {0, -g, 0}});
    scene.add(Meet{.radius = r});
    const auto plan = made<double>(scene, poured(2, 0));
    Alive<double> alive(2);
    alive.add({0, 0, 0});
    alive.add({0.5 * r, 0, 0});
    step(plan, alive, 2);
    const double parting = std::max(0.25 * std::sqrt(g * r), 0.1 * r / h);
    CHECK(alive.v(1)[0] - alive.v(0)[0] == doctest::Approx(parting));
  }
}

// ---- motions, reports, workspaces -------------------------------------------------------------------------------------------

TEST_CASE("a pile presses the floor with the weight of its balls, and one ball with its own") {
  constexpr std::size_t steps = 60;
  for (const std::size_t count : {std::size_t{200}, std::size_t{1}}) {
    const auto plan = made<double>(box(), poured(300, 0));
    Alive<double> alive(300);
    alive.add(test::heap(count, 8, 2 * r));
    step(plan, alive, 120);
    ContactReport report(5);
    REQUIRE(plan.step(alive.live, report, steps) == StepResult::done);
    const double weight = 0.02 * 9.81 * static_cast<double>(count);
    CHECK(report.of(0).impulse[1] == doctest::Approx(-weight * steps * h).epsilon(0.02));
  }
}

TEST_CASE_TEMPLATE("balls added after the caller cut the count inherit nothing that was kept of pairs", T, float, double) {
  const auto plan = made<T>(box(), poured(600, 0));
  Alive<T> alive(600), again(600);
  alive.add(test::heap(512, 8, 2 * r));
  alive.add({0.09, 0.1, 0.09}, {0, -4, 0});  // an impact
  step(plan, alive, 3);
  alive.live.state.count = 300;
  again.take(alive.live);
  step(plan, alive);
  const auto fresh = made<T>(box(), poured(600, 0));
  step(fresh, again);
  for (Alive<T>* each : {&alive, &again}) each->add({0.05, 0.2, 0.05}, {0, -4, 0});
  step(plan, alive, 3);
  step(fresh, again, 3);
  CHECK(alive.bytes() == again.bytes());
}

TEST_CASE("a lifted tray carries the balls on it, and a workspace must be driven by its own poses") {
  Scene scene;
  scene.mass = 0.02;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.motions.emplace_back();
  scene.add(Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.5, .motion = 0});
  scene.add(Meet{.radius = r});
  Lifecycle turnover = poured(20, 30);
  turnover.emitters[0].shape = Vec3{0.5, 0.2, 0};
  turnover.emitters[0].motion = 0;
  auto plan = made<double>(scene, turnover);
  Alive<double> own(20), other(20);
  LiveWorkspace<double> workspace = plan.workspace();
  for (Alive<double>* alive : {&own, &other}) {
    for (std::size_t n = 0; n < 6; ++n) alive->add({0.02 * static_cast<double>(n), 1.001 * r, 0});
  }
  for (int n = 1; n <= 30; ++n) {
    const Pose target{.translation = {0, 0.01 * n, 0}};
    REQUIRE(plan.set_pose(0, target).has_value());
    step(plan, own);
    CHECK(plan.step(other.live, workspace) == (n == 1 ? StepResult::driven_elsewhere : StepResult::done));
    REQUIRE(workspace.set_pose(0, target).has_value());
    if (n == 1) REQUIRE(plan.step(other.live, workspace) == StepResult::done);
    if (n != 1) continue;
    REQUIRE(workspace.set_pose(0, {.translation = {0, 0.02, 0}}).has_value());
  }
  for (std::size_t n = 0; n < 6; ++n) CHECK(own.x(n)[1] == doctest::Approx(0.3 + r).epsilon(0.005));
  CHECK(own.count() > 15);
}

TEST_CASE("clones and workspaces step as the plan does") {
  const auto plan = made<double>(box(), with_deaths());
  const auto clone = plan.clone();
  LiveWorkspace<double> workspace = plan.workspace();
  CHECK(workspace.bytes() > 130 * 1000);
  Alive<double> by_plan(130), by_clone(130), by_workspace(130);
  step(plan, by_plan, 26);
  step(clone, by_clone, 26);
  REQUIRE(plan.step(by_workspace.live, workspace, 26) == StepResult::done);
  CHECK(by_clone.bytes() == by_plan.bytes());
  CHECK(by_workspace.bytes() == by_plan.bytes());
  CHECK(plan.meetings(workspace).touching == plan.meetings().touching);
}

TEST_CASE("a pile is teleported and checked") {
  const Scene scene = [] {
    Scene of;
    of.add(Meet{.radius = r});
    return of;
  }();
  const auto plan = made<double>(scene, poured(40, 0));
  Alive<double> alive(40);
  for (std::size_t n = 0; n < 20; ++n) alive.add({0.019 * static_cast<double>(n), 0, 0});
  step(plan, alive, 2);
  REQUIRE(plan.teleport(alive.live, {.translation = {0, 7, 0}}).has_value());
  CHECK(alive.x(3)[1] == doctest::Approx(7));
  alive.live.state.x[2][5] = std::numeric_limits<double>::quiet_NaN();
  const StateCheck found = plan.check(alive.live);
  CHECK(found.result == StepResult::done);
  step(plan, alive, 2);
  CHECK(alive.count() == 20);
}

TEST_CASE("too many neighbours end a call at a step's beginning") {
  Scene scene = box();
  scene.meet->most_neighbours = 3;
  const auto plan = made<double>(scene, poured(300, 400));
  Alive<double> alive(300), before(300);
  StepResult result = StepResult::done;
  std::size_t steps = 0;
  for (; steps < 200 && result == StepResult::done; ++steps) {
    before.take(alive.live);
    result = plan.step(alive.live);
  }
  CHECK(result == StepResult::too_many_neighbours);
  CHECK(alive.bytes() == before.bytes());
  Alive<double> at_once(300);  // the steps before the error are kept
  CHECK(made<double>(scene, poured(300, 400)).step(at_once.live, 200) == StepResult::too_many_neighbours);
  CHECK(at_once.bytes() == before.bytes());
}

TEST_CASE("balls that come and go and cannot meet are refused by name") {
  const auto refusal = [](const auto& change, Options options = {.step = h}) {
    Scene scene = box();
    Lifecycle turnover = poured(10, 10);
    change(scene, turnover);
    const auto plan = compile<double>(scene, turnover, options);
    return plan ? std::string() : plan.error().message();
  };
  CHECK(refusal([](Scene&, Lifecycle&) {}).empty());
  CHECK(refusal([](Scene& scene, Lifecycle&) { scene.meet->radius = Scalars(std::vector<double>(10, r)); }) ==
        "meet.radius is given for each particle: must be alike for all particles where they come and go");
  CHECK(refusal([](Scene& scene, Lifecycle&) { *scene.meet = Meet{.thickness = r}; }) ==
        "meet.thickness is there: must be left out where particles come and go: balls have a radius");
  CHECK(refusal([](Scene& scene, Lifecycle&) { scene.meet->groups = MeetGroups{}; }) ==
        "meet.groups is there: must be left out where particles come and go");
  CHECK(refusal([](Scene& scene, Lifecycle&) { scene.meet->near_at_start = NearAtStart::pass; }) ==
        "meet.near_at_start is pass: must be left out where particles come and go, or meet");
  CHECK(refusal([](Scene&, Lifecycle& turnover) { turnover.removal.order = SurvivorOrder::any; }) ==
        "removal.order is any: must be kept where particles meet");
  CHECK(refusal([](Scene& scene, Lifecycle&) { scene.meet->radius = -1.0; }) ==
        "meet.radius is -1: must be a finite number > 0");
  Options shared{.step = h};
  shared.elsewhere.births = {.part = 0, .parts = 2, .count_all = [](void*, std::uint64_t here) noexcept { return here; }};
  CHECK(refusal([](Scene&, Lifecycle&) {}, shared) == "meet is there: must be left out where parts share births");
}

}  // namespace live_meet_test
