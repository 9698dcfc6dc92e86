// Moving bodies and emitters with particles that come and go: the same as with a plan of particles that are all present.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/openmp.hpp"

namespace live_motions_test {

using namespace dvdx;

constexpr std::size_t count = 300;
constexpr double h = 1.0 / 64;

template <class T>
struct Sparks {
  explicit Sparks(std::size_t room = count) : memory(room), ages(room) {
    const State<T> of_ages = ages.view();
    live = {.state = memory.view(), .age = of_ages.x[0], .lifetime = of_ages.x[1]};
    live.state.count = 0;
  }

  Soa<T> memory, ages;
  LiveState<T> live;
};

template <class T>
void scatter(State<T>& state) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto a = static_cast<double>(i);
    state.x[0][i] = static_cast<T>(std::sin(a));
    state.x[1][i] = static_cast<T>(1.2 + std::cos(3 * a));
    state.x[2][i] = static_cast<T>(std::sin(7 * a));
    for (std::size_t axis = 0; axis < 3; ++axis) state.v[axis][i] = static_cast<T>(std::sin(a + static_cast<double>(axis)));
  }
  state.count = count;
}

// A plane, a sphere on motion 0, and a box on motion 1, which turns by keys.
Scene moving_bodies() {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Motion{});
  scene.add(
      Motion{.center = {0.3, 0.8, 0}, .keys = {{.time = 0}, {.time = 2, .translation = {0.5, 0, 0}, .rotation = {0, 0, 2}}}});
  scene.add(Plane{.restitution = 0.5});
  scene.add(Sphere{.center = {0, 1, 0}, .radius = 0.4, .restitution = 0.3, .friction = 0.2, .motion = 0});
  scene.add(OrientedBox{.center = {0.3, 0.8, 0}, .half_extents = {0.4, 0.1, 0.3}, .friction = 0.4, .motion = 1});
  return scene;
}
Pose hand(double time) { return {.translation = {std::sin(3 * time), 0.2 * std::sin(5 * time), 0}, .rotation = {0, time, 0}}; }

template <class T>
LifecyclePlan<T> live_plan(const Scene& scene, const Lifecycle& turnover, double step = h) {
  auto plan = compile<T>(scene, turnover, {.step = step});
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

TEST_CASE_TEMPLATE("live motions: driven and keyed bodies have the bits of a plan of the same particles", T, float, double) {
  const Scene scene = moving_bodies();
  Soa<T> memory(count);
  State<T> state = memory.view();
  Sparks<T> sparks;
  scatter(state);
  scatter(sparks.live.state);
  std::fill_n(sparks.live.lifetime.base, count, std::numeric_limits<T>::infinity());
  std::fill_n(sparks.live.age.base, count, T(0));
  auto plan = compile<T>(scene, {.step = h}, state);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  LifecyclePlan<T> live = live_plan<T>(scene, {.capacity = count});
  ContactReport report(scene.contacts.size()), of_live(scene.contacts.size());
  for (int n = 1; n <= 60; ++n) {
    if (n % 3 != 0) {
      const Arrival arrival = n == 31 ? Arrival::jump : Arrival::moving;
      REQUIRE(plan->set_pose(0, hand(n * h), arrival).has_value());
      REQUIRE(live.set_pose(0, hand(n * h), arrival).has_value());
    }
    if (n == 40) {
      REQUIRE(plan->set_step(h / 2).has_value());
      REQUIRE(live.set_step(h / 2).has_value());
    }
    const std::size_t steps = n % 5 == 0 ? 3 : 1;
    REQUIRE(plan->step(state, report, steps) == StepResult::done);
    REQUIRE(live.step(sparks.live, of_live, steps) == StepResult::done);
  }
  CHECK(state_hash(sparks.live.state) == state_hash(state));
  CHECK(report.of(1).hits > 0);
  CHECK(std::equal(report.words().begin(), report.words().end(), of_live.words().begin()));
  REQUIRE(plan->teleport(state, {.translation = {3, 0, 1}}).has_value());
  REQUIRE(live.teleport(sparks.live, {.translation = {3, 0, 1}}).has_value());
  REQUIRE(plan->step(state, 20) == StepResult::done);
  REQUIRE(live.step(sparks.live, 20) == StepResult::done);
  CHECK(state_hash(sparks.live.state) == state_hash(state));
}

TEST_CASE_TEMPLATE("live motions: a body that is carried along passes no particle, and pushes it on", T, float, double) {
  Scene scene;
  scene.add(Motion{});
  scene.add(Sphere{.radius = 0.1, .motion = 0});
  LifecyclePlan<T> plan = live_plan<T>(scene, {.capacity = count});
  Sparks<T> sparks;
  sparks.live.state.count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) sparks.live.state.x[axis][0] = sparks.live.state.v[axis][0] = 0;
  sparks.live.state.x[0][0] = T(0.5);
  sparks.live.age[0] = 0;
  sparks.live.lifetime[0] = 100;
  REQUIRE(plan.set_pose(0, {.translation = {1, 0, 0}}).has_value());  // ten radii in one step
  REQUIRE(plan.step(sparks.live) == StepResult::done);
  CHECK(sparks.live.state.x[0][0] >= T(1.0999));
  CHECK(sparks.live.state.v[0][0] == doctest::Approx(1 / h));
}

// A ball that a program has put at (1, 0, 0), and one that its keys have at (2, 0, 0). A particle falls on each.
TEST_CASE("live motions: a teleport carries the bodies on motions along, so that particles meet them at the new place") {
  Scene scene;
  scene.add(Motion{});
  scene.add(Motion{.keys = {{.time = 0, .translation = {2, 0, 0}}}});
  for (const std::size_t motion : {std::size_t{0}, std::size_t{1}}) scene.add(Sphere{.radius = 0.1, .motion = motion});
  LifecyclePlan<double> plan = live_plan<double>(scene, {.capacity = count});
  Sparks<double> sparks;
  State<double>& state = sparks.live.state;
  state.count = 2;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = state.v[axis][i] = 0;
    state.x[0][i] = i == 0 ? 1 : 2;
    state.x[1][i] = 0.5;
    state.v[1][i] = -1;
    sparks.live.age[i] = 0;
    sparks.live.lifetime[i] = 100;
  }
  REQUIRE(plan.set_pose(0, {.translation = {1, 0, 0}}, Arrival::jump).has_value());
  REQUIRE(plan.step(sparks.live) == StepResult::done);
  REQUIRE(plan.teleport(sparks.live, {.translation = {3, 0, 5}}).has_value());
  REQUIRE(plan.step(sparks.live, 64) == StepResult::done);  // 1 s
  for (std::size_t i = 0; i < 2; ++i) CHECK(state.x[1][i] == doctest::Approx(0.1));
}

TEST_CASE("live motions: an emitter on a motion makes its births on the way, aimed as it is turned") {
  constexpr double rate = 8 / h;
  Scene scene;
  scene.add(Motion{});
  const Emitter nozzle{.shape = Vec3{0, 1, 0}, .rate = rate, .velocity = {0, 0, 2}, .motion = 0};
  for (const SurvivorOrder order : {SurvivorOrder::kept, SurvivorOrder::any}) {
    LifecyclePlan<double> plan =
        live_plan<double>(scene, {.emitters = {nozzle}, .removal = {.order = order}, .capacity = count});
    Sparks<double> sparks;
    REQUIRE(plan.set_pose(0, {.translation = {3, 0, 0}}).has_value());
    REQUIRE(plan.step(sparks.live) == StepResult::done);
    const State<double>& state = sparks.live.state;
    REQUIRE(state.count == 8);
    for (std::size_t i = 0; i < 8; ++i) {
      // The particle was born at (3 born / h, 1, 0), and moves with the nozzle's velocity plus its own.
      CHECK(state.x[0][i] == doctest::Approx(3));
      CHECK(state.x[1][i] == doctest::Approx(1));
      CHECK(state.x[2][i] == doctest::Approx(2 * sparks.live.age[i]));
      CHECK(state.v[0][i] == doctest::Approx(3 / h));
      CHECK(state.v[2][i] == doctest::Approx(2));
    }
    // A quarter turn about y, by a jump, aims along x. A burst is born at the motion's present place.
    REQUIRE(plan.set_pose(0, {.translation = {0, 0, 5}, .rotation = {0, std::acos(0.0), 0}}, Arrival::jump).has_value());
    REQUIRE(plan.step(sparks.live) == StepResult::done);
    REQUIRE(plan.burst(sparks.live, 0, 4).has_value());
    REQUIRE(state.count == 20);
    for (std::size_t i = 8; i < 20; ++i) {
      CHECK(state.v[0][i] == doctest::Approx(2));
      CHECK(std::abs(state.v[2][i]) < 1e-12);
      CHECK(state.x[0][i] == doctest::Approx(2 * sparks.live.age[i]));
      CHECK(state.x[2][i] == doctest::Approx(5));
    }
  }
}

Lifecycle fountain(SurvivorOrder order) {
  return {.emitters = {{.shape = Disc{.center = {0, 1.5, 0}, .radius = 0.2},
                        .rate = 4000,
                        .velocity = {0, 2, 0},
                        .spread = 0.5,
                        .least_lifetime = 0.3,
                        .most_lifetime = 0.6,
                        .seed = 3,
                        .motion = 0}},
          .removal = {.boundaries = {{.normal = {0, 1, 0}, .offset = -0.1}}, .order = order},
          .capacity = 4000};
}

TEST_CASE_TEMPLATE("live motions: neither threads, instruction sets nor steps a call change a bit", T, float, double) {
  Scene scene = moving_bodies();
  scene.motions[0].keys = {{.time = 0}, {.time = 1, .translation = {1, 0, 0}, .rotation = {0, 3, 0}}};
  const OpenMpTeam team(3);
  for (const SurvivorOrder order : {SurvivorOrder::kept, SurvivorOrder::any}) {
    std::vector<std::uint64_t> hashes;
    for (const Isa isa : available_isas(Arithmetic::separate)) {
      for (const std::size_t call : {std::size_t{1}, std::size_t{7}, std::size_t{64}}) {
        auto plan = compile<T>(scene, fountain(order), {.step = h, .isa = isa});
        REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
        Sparks<T> sparks(4000);
        for (std::size_t done = 0; done < 64; done += call) {
          const std::size_t steps = std::min(call, 64 - done);
          REQUIRE(plan->step(sparks.live, steps, call == 7 ? team.parallel_for() : ParallelFor{}) == StepResult::done);
        }
        CHECK(sparks.live.state.count > 1000);
        hashes.push_back(state_hash(sparks.live.state));
      }
    }
    for (const std::uint64_t hash : hashes) CHECK(hash == hashes[0]);
  }
}

TEST_CASE("live motions: states in workspaces of their own are driven by themselves, on threads of their own") {
  Scene scene = moving_bodies();
  LifecyclePlan<float> plan = live_plan<float>(scene, fountain(SurvivorOrder::kept));
  const auto play = [&](LifecyclePlan<float>& by, double phase) {
    Sparks<float> sparks(4000);
    for (int n = 1; n <= 40; ++n) {
      if (!by.set_pose(0, hand(phase + n * h)) || by.step(sparks.live) != StepResult::done) return std::uint64_t{0};
    }
    return state_hash(sparks.live.state);
  };
  const auto play_in_workspace = [&](double phase, std::uint64_t& hash) {
    Sparks<float> sparks(4000);
    LiveWorkspace<float> workspace = plan.workspace();
    for (int n = 1; n <= 40; ++n) {
      if (!workspace.set_pose(0, hand(phase + n * h)) || plan.step(sparks.live, workspace) != StepResult::done) return;
    }
    hash = state_hash(sparks.live.state);
  };
  std::uint64_t one = 0, two = 0;
  std::thread other(play_in_workspace, 0.5, std::ref(one));
  play_in_workspace(1.0, two);
  other.join();
  LifecyclePlan<float> first = plan.clone(), second = plan.clone();
  CHECK(one == play(first, 0.5));
  CHECK(two == play(second, 1.0));
  CHECK(one != two);

  Sparks<float> sparks(4000);
  LiveWorkspace<float> early = plan.workspace();
  CHECK(early.bytes() > 0);
  REQUIRE(plan.set_pose(0, hand(1)).has_value());
  CHECK(plan.step(sparks.live, early) == StepResult::driven_elsewhere);
  LiveWorkspace<float> late = plan.workspace();
  REQUIRE(plan.step(sparks.live, late) == StepResult::done);
  Sparks<float> own(4000);
  REQUIRE(plan.step(own.live) == StepResult::done);
  CHECK(state_hash(own.live.state) == state_hash(sparks.live.state));
}

TEST_CASE("live motions: explain says that calls take one step at a time") {
  Lifecycle still = fountain(SurvivorOrder::kept);
  still.emitters[0].motion.reset();
  const std::string words = "one step while a chunk of 8192 particles is in cache: what follows a motion has one pose a step";
  CHECK(live_plan<float>(moving_bodies(), still).explain().find(words) != std::string::npos);
  Scene scene;
  scene.add(Motion{});
  CHECK(live_plan<float>(scene, fountain(SurvivorOrder::kept)).explain().find(words) != std::string::npos);
  CHECK(live_plan<float>(scene, still).explain().find(words) == std::string::npos);
}

TEST_CASE("live motions: a state goes on in another plan with the same bits where bodies jump to where they stood") {
  const Scene scene = moving_bodies();
  const auto drive = [](LifecyclePlan<double>& plan, Sparks<double>& sparks, int from, int to) {
    for (int n = from; n <= to; ++n) {
      REQUIRE(plan.set_pose(0, hand(n * h)).has_value());
      REQUIRE(plan.step(sparks.live) == StepResult::done);
    }
  };
  LifecyclePlan<double> whole = live_plan<double>(scene, fountain(SurvivorOrder::kept));
  LifecyclePlan<double> first = whole.clone(), second = whole.clone();
  Sparks<double> one(4000), two(4000);
  drive(whole, one, 1, 40);
  drive(first, two, 1, 20);
  REQUIRE(second.set_pose(0, hand(20 * h), Arrival::jump).has_value());
  drive(second, two, 21, 40);
  CHECK(state_hash(one.live.state) == state_hash(two.live.state));
}

TEST_CASE("live motions: misuse is an error or a result that names what is wrong, and changes nothing") {
  Scene scene = moving_bodies();
  Sparks<float> sparks;
  LifecyclePlan<float> plan = live_plan<float>(scene, {.emitters = {{.rate = 1}}, .capacity = count});
  CHECK(plan.set_pose(2, {}).error().message() == "motions[2] is not there: must be an index below 2");
  CHECK(plan.set_pose(0, {.translation = {0, std::nan(""), 0}}).error().field == "pose.translation[1]");
  CHECK(plan.set_emitter(0, {.motion = 2}).error().message() == "emitters[0].motion is 2: must be a motion's index below 2");
  CHECK(plan.set_contact(1, Sphere{.motion = 2}).error().field == "contacts[1].motion");
  CHECK(plan.set_wind({.mean = {std::nan(""), 0, 0}}).error().field == "wind.mean[0]");
  CHECK(plan.set_step(0.6).error().field == "step");  // the box turns by 1 rad/s
  CHECK(plan.step_size() == h);
  CHECK(compile<float>(scene, {.capacity = count}, {.step = 0.6}).error().message() ==
        "step is 0.6: must be at most 0.5 s, in which contacts[2] turns by half a radian");
  CHECK(plan.plan().step(sparks.live.state) == StepResult::workspace_differs);  // it moves no body
  CHECK(compile<float>(scene, {.emitters = {{.motion = 4}}, .capacity = count}, {.step = h}).error().field ==
        "emitters[0].motion");
  Scene pinned = scene;
  pinned.add(Kinematic{.particles = {0}, .motion = 0});
  CHECK(compile<float>(pinned, {.capacity = count}, {.step = h}).error().field == "kinematic");
  CHECK(compile<float>(scene, {.step = h}).error().field == "contacts[1].motion");  // a plan without lifecycle

  LiveWorkspace<float> workspace = plan.workspace();
  LifecyclePlan<float> other = live_plan<float>(scene, {.capacity = count});
  CHECK(other.step(sparks.live, workspace) == StepResult::workspace_differs);
  CHECK(other.burst(sparks.live, workspace, 0, 1).error().field == "workspace");
  CHECK(other.teleport(sparks.live, workspace, {}).error().field == "workspace");
  CHECK(workspace.set_pose(5, {}).error().field == "motions[5]");
  LiveWorkspace<float> taken = std::move(workspace);
  CHECK(plan.step(sparks.live, workspace) == StepResult::workspace_differs);
  CHECK(plan.remove(sparks.live, workspace) == StepResult::workspace_differs);
  CHECK(plan.burst(sparks.live, workspace, 0, 1).error().field == "workspace");
  CHECK(plan.teleport(sparks.live, workspace, {}).error().field == "workspace");
  CHECK(workspace.set_pose(0, {}).error().field == "workspace");
  CHECK(workspace.bytes() == 0);
  const LifecyclePlan<float> kept = std::move(plan);
  CHECK(plan.set_pose(0, {}).error().field == "plan");
  CHECK(plan.set_wind({}).error().field == "plan");
  CHECK(plan.step(sparks.live, taken) == StepResult::moved_from);
  CHECK(plan.workspace().bytes() == 0);
  CHECK(plan.check(sparks.live).result == StepResult::moved_from);
  CHECK(plan.scene().motions.empty());
  CHECK(plan.turnover().capacity == 0);
  CHECK(plan.explain() == "moved from\n");
  CHECK(std::isnan(plan.step_size()));
  CHECK(kept.step(sparks.live, taken) == StepResult::done);
  CHECK(kept.check(sparks.live).not_finite == 0);
}

}  // namespace live_motions_test
