// A character jumps between two steps: pins, collider, skin and tethers jump with it, and only places change.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"

namespace jumps_test {

using namespace dvdx;
using test::apart;
using test::Batch;
using test::Joined;
using test::Layout;

constexpr std::size_t rows = 9, columns = 12;

Vec3 plus(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

// A sheet on a walking and swaying character: group 0 is the first row, motion 1 carries a ball, skin 0 holds the lower half.
struct Character {
  Joined joined = test::sheet(rows, columns, 400);
  std::vector<std::size_t> pins, skinned;

  Character() {
    Scene& scene = joined.scene;
    scene.fixed.clear();
    for (std::size_t i = 0; i < columns; ++i) pins.push_back(i);
    for (std::size_t i = columns * (rows / 2); i < columns * rows; ++i) skinned.push_back(i);
    scene.add(Motion{.keys = {{.time = 0}}});
    scene.add(Motion{.keys = {{.time = 0}}});
    scene.add(Kinematic{.particles = pins, .motion = 0});
    scene.add(Sphere{.center = {0.5, -0.18, 0.5}, .radius = 0.2, .friction = 0.3, .motion = 1});
    scene.add(Skin{
        .particles = skinned, .at_most = 0.04, .backstop = Backstop{.normals = {{0, 1, 0}}, .offset = 0.01, .radius = 0.3}});
    scene.add(Tethers{.network = 0, .stretch = 1.02});
  }

  // The character's position at time t, m.
  static Vec3 place(double t) { return {1.5 * t, 0.02 * std::sin(9 * t), 0.4 * t * t}; }
  [[nodiscard]] std::vector<Vec3> at(const std::vector<std::size_t>& particles, const Vec3& place) const {
    std::vector<Vec3> points;
    for (const std::size_t i : particles) points.push_back(plus(joined.x[i], place));
    return points;
  }
  template <class Driven>
  void tell(Driven& driven, const Vec3& place, Arrival arrival) const {
    REQUIRE(driven.set_places(0, at(pins, place), arrival).has_value());
    REQUIRE(driven.set_pose(1, {.translation = place}, arrival).has_value());
    REQUIRE(driven.set_skin(0, at(skinned, place), {}, arrival).has_value());
  }

  // The states after each of `frames` frames; `jump` displaces the character before frame `when`.
  [[nodiscard]] std::vector<double> run(const Coupling& coupling, bool is_grid, std::size_t frames, std::size_t when,
                                        const Vec3& jump) const {
    Joined scene = is_grid ? joined : test::as_list(joined);
    scene.scene.coupling = coupling;
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(scene, batch.view());
    Plan<double> plan = test::plan_of(scene, {.isa = best_isa()}, batch.view());
    const auto time = [&](std::size_t frame) { return static_cast<double>(frame) * joined.step; };
    Vec3 carried{};
    for (std::size_t frame = 0; frame < frames; ++frame) {
      if (frame == when) {
        carried = jump;
        State<double> state = batch.view();
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (std::size_t i = 0; i < state.count; ++i) state.x[axis][i] += jump[axis];
        }
        tell(plan, plus(place(time(frame)), carried), Arrival::jump);
      }
      tell(plan, plus(place(time(frame + 1)), carried), Arrival::moving);
      REQUIRE(plan.step(batch.view()) == StepResult::done);
    }
    std::vector<double> values = test::values_of(batch.view());
    for (std::size_t i = 0; i < values.size(); i += 6) {
      for (std::size_t axis = 0; axis < 3; ++axis) values[i + axis] -= carried[axis];
    }
    return values;
  }
};

TEST_CASE("jumps: a character that is carried 100 m or 1000 km away changes nothing but its place, in every scheme") {
  const Character character;
  for (const Coupling& coupling : test::couplings()) {
    for (const bool is_grid : {true, false}) {
      CAPTURE(static_cast<int>(coupling.scheme));
      CAPTURE(is_grid);
      const auto wanted = character.run(coupling, is_grid, 24, 24, {});
      // Places there are rounded by 1.4e-14 and 1.2e-10 m. Springs of 400 N/m on 1 g turn that into velocities.
      CHECK(apart(wanted, character.run(coupling, is_grid, 24, 12, {100, 0, -30})) < 1e-8);
      CHECK(apart(wanted, character.run(coupling, is_grid, 24, 12, {1e6, 50, 0})) < 1e-5);
      CHECK(apart(wanted, character.run(coupling, is_grid, 24, 0, {100, 0, -30})) < 1e-8);  // before any motion
    }
  }
}

TEST_CASE("jumps: pins that jump rest there through the next step, and drop the target that waited") {
  const Character character;
  Batch<double> batch(Layout::soa, character.joined.x.size());
  test::place(character.joined, batch.view());
  Plan<double> plan = test::plan_of(character.joined, {.isa = best_isa()}, batch.view());
  const Vec3 there{0.001, 0.002, 0};
  character.tell(plan, {5, 5, 5}, Arrival::moving);
  character.tell(plan, there, Arrival::jump);
  REQUIRE(plan.step(batch.view()) == StepResult::done);
  const auto values = test::values_of(batch.view());
  for (const std::size_t pin : character.pins) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(values[6 * pin + axis] == character.joined.x[pin][axis] + there[axis]);
      CHECK(values[6 * pin + 3 + axis] == 0);
    }
  }
}

TEST_CASE("jumps: followers of a pose jump with it, and rest there") {
  const Character character;
  Batch<double> batch(Layout::soa, character.joined.x.size());
  test::place(character.joined, batch.view());
  Plan<double> plan = test::plan_of(character.joined, {.isa = best_isa()}, batch.view());
  REQUIRE(plan.set_pose(0, {.translation = {5, 5, 5}}).has_value());
  REQUIRE(plan.set_pose(0, {.translation = {0.25, 0, 0}}, Arrival::jump).has_value());
  REQUIRE(plan.step(batch.view()) == StepResult::done);
  for (const std::size_t pin : character.pins) {
    CHECK(batch.view().x[0][pin] == doctest::Approx(character.joined.x[pin][0] + 0.25));
    CHECK(batch.view().v[0][pin] == 0);
  }
}

TEST_CASE("jumps: a call of no steps puts pins where they have jumped to") {
  const Character character;
  Batch<float> batch(Layout::soa, character.joined.x.size());
  test::place(character.joined, batch.view());
  Plan<float> plan = test::plan_of(character.joined, {.isa = best_isa()}, batch.view());
  REQUIRE(plan.set_pose(0, {.translation = {8, 0, 0}}, Arrival::jump).has_value());
  REQUIRE(plan.step(batch.view(), 0) == StepResult::done);
  for (const std::size_t pin : character.pins) {
    CHECK(batch.view().x[0][pin] == static_cast<float>(character.joined.x[pin][0] + 8));
    CHECK(batch.view().v[0][pin] == 0);
  }
}

// A ball rests at x = -4 m until `jump`, is at 4 m from then on, and continues at 10 m/s: a stone at 0 is not swept, one at
// 4.75 m is pushed. The first particle is carried.
TEST_CASE("jumps: a key that jumps sweeps nothing, within a step or at its end, and the motion goes on from it") {
  for (const double jump : {0.1, 0.137}) {
    for (const Arrival arrival : {Arrival::moving, Arrival::jump}) {
      CAPTURE(jump);
      CAPTURE(static_cast<int>(arrival));
      Scene scene;
      scene.add(Motion{.keys = {{.time = 0, .translation = {-4, 0, 0}},
                                {.time = jump, .translation = {4, 0, 0}, .arrival = arrival},
                                {.time = jump + 0.1, .translation = {5, 0, 0}}}});
      scene.add(Kinematic{.particles = {0}, .motion = 0});
      scene.add(Sphere{.radius = 0.5, .restitution = 1, .motion = 0});
      Batch<double> batch(Layout::soa, 3);
      const std::array<Vec3, 3> x{Vec3{0.25, 3, 0}, Vec3{}, Vec3{4.75, 0, 0}};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < x.size(); ++i) {
          batch.view().x[axis][i] = x[i][axis];
          batch.view().v[axis][i] = 0;
        }
      }
      Plan<double> plan = compile<double>(scene, {.step = 0.025}, batch.view()).value();
      const auto step = [&](std::size_t steps) { REQUIRE(plan.step(batch.view(), steps) == StepResult::done); };
      step(3);
      CHECK((batch.view().x[0][0] == -3.75) == (arrival == Arrival::jump));
      step(3);
      CHECK(batch.view().x[0][0] == doctest::Approx(0.25 + 4 + 10 * (0.15 - jump)));
      CHECK(batch.view().v[0][0] == doctest::Approx(10));
      step(2);
      CHECK((batch.view().v[0][1] == 0) == (arrival == Arrival::jump));
      if (arrival == Arrival::jump) CHECK(batch.view().v[0][2] == doctest::Approx(20));
    }
  }
}

TEST_CASE("jumps: a jump that no step has begun with goes on in another plan") {
  const Character character;
  Batch<double> one(Layout::soa, character.joined.x.size()), two(Layout::soa, character.joined.x.size());
  for (auto* batch : {&one, &two}) test::place(character.joined, batch->view());
  Plan<double> plan = test::plan_of(character.joined, {.isa = best_isa()}, one.view());
  Plan<double> next = plan.clone();
  character.tell(plan, {0.01, 0, 0}, Arrival::jump);
  REQUIRE(plan.set_pose(0, {.translation = {0.02, 0, 0}, .rotation = {0, 0.1, 0}}, Arrival::jump).has_value());
  REQUIRE(next.restore(plan.carried(one.view()), two.view()).has_value());
  for (Batch<double>* batch : {&one, &two}) REQUIRE((batch == &one ? plan : next).step(batch->view(), 3) == StepResult::done);
  CHECK(state_hash(one.view()) == state_hash(two.view()));
}

}  // namespace jumps_test
