// Easily made misuse: each call gives an error or a result that names the field as a program spells it, and changes nothing.
#include <doctest/doctest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "dvdx/cloth.hpp"
#include "dvdx/instance.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"

namespace misuse_test {

using namespace dvdx;

constexpr std::size_t count = 4;
constexpr double frame = 1.0 / 60;

struct Rope {
  Soa<double> memory{count};
  State<double> state = memory.view();

  Rope() {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = state.v[axis][i] = 0;
      state.x[0][i] = static_cast<double>(i);
    }
  }
};

Scene rope() {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Network(Springs{.pairs = {{0, 1}, {1, 2}, {2, 3}}, .stiffness = 50.0, .rest_length = Scalars(1.0)}));
  return scene;
}

template <class T>
State<T> without_memory(State<T> state, std::size_t axis = 2) {
  state.x[axis].base = nullptr;
  return state;
}

TEST_CASE("misuse: a state without memory is an error wherever it is read") {
  Rope own;
  const State<double> nowhere = without_memory(own.state);
  CHECK(compile<double>(rope(), {.step = frame}, nowhere).error().message() ==
        "state is columns without memory, or too short: must be columns for all of its particles");
  Scene anchored;
  anchored.add(Spring{.stiffness = 1.0, .anchor = at_start});
  CHECK(compile<double>(anchored, {.step = frame}, nowhere).error().field == "state");
  State<double> few = own.state;
  few.x[0].capacity = 1;
  CHECK(compile<double>(anchored, {.step = frame}, few).error().field == "state");
  auto plan = compile<double>(rope(), {.step = frame}, own.state);
  REQUIRE(plan.has_value());
  CHECK(plan->tear(0, 1.5, nowhere).error().field == "state");
  CHECK(plan->too_long(0, 1.5, nowhere).error().field == "state");
  CHECK(plan->check(nowhere).result == StepResult::capacity_too_small);
  State<double> moved = nowhere;
  CHECK(plan->step(moved) == StepResult::capacity_too_small);
  CHECK(plan->teleport(moved, {}).error().field == "state");
  CHECK(plan->instance(nowhere).error().field == "state");
  Scene flight;
  flight.add(Constant{.acceleration = {0, -9.81, 0}});
  auto free = compile<double>(flight, {.step = frame});
  REQUIRE(free.has_value());
  CHECK(free->seek(moved, 10).error().field == "state");
}

TEST_CASE("misuse: points without memory and columns to draw into without any are errors of an instance") {
  Scene scene = rope();
  const PinsId pins = add_pins(scene, {0});
  const SkinId skin = add_skin(scene, {.particles = {3}, .at_most = 1.0});
  Rope own;
  const auto plan = compile<double>(scene, {.step = frame}, own.state);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  auto instance = plan->instance(own.state);
  REQUIRE(instance.has_value());
  const Points nothing(static_cast<const Vec3*>(nullptr), 1);
  const std::vector<Vec3> one{{0, 0, 0}};
  CHECK(instance->move(pins, nothing).error().message() == "places is a null pointer: must be a pointer to the first of them");
  CHECK(instance->move(skin, nothing).error().field == "points");
  CHECK(instance->move(skin, one, nothing).error().field == "normals");
  Rope drawn;
  State<double> to = without_memory(drawn.state);
  CHECK(instance->blend(to).error().field == "to");
  CHECK(instance->blend(drawn.state).has_value());
  CHECK(instance->set_wind({.mean = {0, INFINITY, 0}}).error().field == "wind.mean[1]");
}

TEST_CASE("misuse: a report that was moved from takes nothing, and a plan says so") {
  Scene scene;
  scene.add(Plane{});
  Rope own;
  const auto plan = compile<double>(scene, {.step = frame});
  REQUIRE(plan.has_value());
  ContactReport report(1);
  ContactReport kept = std::move(report);
  CHECK(plan->step(own.state, report) == StepResult::report_differs);
  const auto live = compile<double>(scene, {.capacity = count}, {.step = frame});
  REQUIRE(live.has_value());
  LiveState<double> drops{.state = own.state};
  CHECK(live->step(drops, report) == StepResult::report_differs);
  CHECK(own.state.clock.seconds == 0);
  report.clear();
  report.set_steps(4);
  report.add(kept.words());
  CHECK(report.contacts() == 0);
  CHECK(report.of(0).hits == 0);
  CHECK(report.events().empty());
  CHECK(report.words().empty());
  CHECK(report.lost() + report.steps() == 0);
  CHECK(kept.of(7).hits == 0);
  CHECK(plan->step(own.state, kept) == StepResult::done);
}

TEST_CASE("misuse: live particles without ages for their lifetimes, or carried columns without memory, are not stepped") {
  const auto plan = compile<double>(Scene{}, {.capacity = count}, {.step = frame});
  REQUIRE(plan.has_value());
  Rope own, ages;
  LiveState<double> live{.state = own.state, .lifetime = ages.state.x[0]};
  CHECK(plan->step(live) == StepResult::capacity_too_small);
  const std::vector<Carried> nowhere{{.base = nullptr, .stride = 4, .bytes = 4}};
  live = {.state = own.state, .age = ages.state.x[0], .lifetime = ages.state.x[1], .carried = nowhere};
  CHECK(plan->step(live) == StepResult::capacity_too_small);
  CHECK(live.state.clock.seconds == 0);
  live.carried = {};
  CHECK(plan->step(live) == StepResult::done);
}

TEST_CASE("misuse: fields are named as a program spells them") {
  Rope own;
  const auto field = [&](const Scene& scene) {
    const auto plan = compile<double>(scene, {.step = frame}, own.state);
    return plan.has_value() ? std::string("none") : plan.error().field;
  };
  Scene scene = rope();
  scene.networks.push_back(Springs{.pairs = {{0, 9}}, .stiffness = 1.0});
  CHECK(field(scene).starts_with("networks[1].pairs[0]"));
  scene = rope();
  scene.coupling.iterations = 0;
  CHECK(field(scene) == "coupling.iterations");
  scene = rope();
  scene.coupling.substeps = 0;
  CHECK(field(scene) == "coupling.substeps");
  scene = rope();
  scene.kinematic.push_back({.particles = {0}, .motion = 3});
  CHECK(field(scene) == "kinematic[0].motion");
  scene = rope();
  scene.skins.push_back({.particles = {9}});
  CHECK(field(scene) == "skins[0].particles[0]");
  scene = rope();
  scene.add(Sphere{.radius = -1});
  CHECK(field(scene) == "contacts[0].radius");
  scene = rope();
  scene.tethers.push_back({.network = 4});
  CHECK(field(scene) == "tethers[0].network");
}

}  // namespace misuse_test
