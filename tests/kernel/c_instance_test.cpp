// Instances, changes of live plans, and a plan's scene through C: the bits of C++, and refusals by name.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/instance.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"

namespace c_instance_test {

constexpr std::size_t count = 12;

// A rope of 12 particles that hangs by its first one, in six arrays.
struct Rope {
  std::array<std::vector<double>, 6> columns{};
  dvdx_state state{};

  Rope() {
    for (auto& column : columns) column.assign(count, 0);
    for (std::size_t i = 0; i < count; ++i) columns[0][i] = 0.1 * static_cast<double>(i);
    state = dvdx_soa(DVDX_FLOAT64, columns[0].data(), columns[1].data(), columns[2].data(), columns[3].data(),
                     columns[4].data(), columns[5].data(), count);
  }
};

struct Handles {
  dvdx_error error{};
  dvdx_scene* scene = nullptr;
  dvdx_plan* plan = nullptr;
  dvdx_instance* instance = nullptr;

  explicit Handles(const Rope& rope) {
    REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) == DVDX_DONE);
    const dvdx_constant gravity{.acceleration = {0, -9.81, 0}, .method = DVDX_METHOD_DEFAULT};
    REQUIRE(dvdx_scene_add_constant(scene, &gravity, &error) == DVDX_DONE);
    std::vector<std::uint32_t> pairs;
    for (std::uint32_t i = 0; i + 1 < count; ++i) pairs.insert(pairs.end(), {i, i + 1});
    dvdx_springs springs{};
    springs.pairs = pairs.data();
    springs.count = count - 1;
    springs.stiffness.all = 500;
    springs.damping = 0.1;
    REQUIRE(dvdx_scene_add_springs(scene, &springs, &error) == DVDX_DONE);
    const dvdx_motion rests{};  // no keys
    REQUIRE(dvdx_scene_add_motion(scene, &rests, &error) == DVDX_DONE);
    const std::size_t first = 0;
    const dvdx_kinematic pins{.particles = &first, .count = 1, .motion = 0};
    REQUIRE(dvdx_scene_add_kinematic(scene, &pins, &error) == DVDX_DONE);
    dvdx_options options{};
    options.step = 1.0 / 60;
    options.precision = DVDX_FLOAT64;
    REQUIRE(dvdx_plan_create(scene, &options, &rope.state, &plan, &error) == DVDX_DONE);
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    dvdx_instance_destroy(instance);
    dvdx_plan_destroy(plan);
    dvdx_scene_destroy(scene);
  }
};

TEST_CASE("c: an instance has the bits of the plan that it was made of") {
  Rope one, two;
  Handles h(one);
  REQUIRE(dvdx_instance_create(h.plan, &one.state, &h.instance, &h.error) == DVDX_DONE);
  const std::array<double, 3> away{7, 0, 0};
  REQUIRE(dvdx_instance_teleport(h.instance, away.data(), nullptr, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_teleport(h.plan, &two.state, away.data(), nullptr, &h.error) == DVDX_DONE);
  for (int frame = 1; frame <= 9; ++frame) {
    const double step = frame % 2 == 0 ? 1.0 / 50 : 1.0 / 90;
    const std::array<double, 3> pin{7, 0.02 * frame, 0};
    REQUIRE(dvdx_instance_move_pins(h.instance, 0, pin.data(), 1, DVDX_MOVING, &h.error) == DVDX_DONE);
    REQUIRE(dvdx_instance_step(h.instance, step, nullptr, &h.error) == DVDX_DONE);
    REQUIRE(dvdx_plan_set_places(h.plan, 0, pin.data(), 1, &h.error) == DVDX_DONE);
    REQUIRE(dvdx_plan_set_step(h.plan, step, &h.error) == DVDX_DONE);
    REQUIRE(dvdx_plan_step(h.plan, &two.state, 1, nullptr, &h.error) == DVDX_DONE);
    CHECK(one.columns == two.columns);
  }
  CHECK(dvdx_instance_clock(h.instance).seconds == two.state.clock.seconds);
  CHECK(dvdx_instance_step_size(h.instance) == 1.0 / 90);
  dvdx_state_check found{}, wanted{};
  REQUIRE(dvdx_instance_check(h.instance, &found, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_check(h.plan, &two.state, &wanted, &h.error) == DVDX_DONE);
  CHECK((found.stretch == wanted.stretch && found.kinetic == wanted.kinetic));
  std::size_t steps = 0;
  REQUIRE(dvdx_instance_advance(h.instance, 0.05, 8, &steps, nullptr, &h.error) == DVDX_DONE);
  CHECK(steps == 4);
  REQUIRE(dvdx_instance_blend(h.instance, &two.state, &h.error) == DVDX_DONE);
  CHECK(std::abs(two.columns[1][count - 1] - one.columns[1][count - 1]) < 0.1);
}

TEST_CASE("c: an instance refuses null pointers and wrong values by name") {
  Rope rope;
  Handles h(rope);
  CHECK(dvdx_instance_create(nullptr, &rope.state, &h.instance, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instance_create(h.plan, nullptr, &h.instance, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instance_create(h.plan, &rope.state, nullptr, &h.error) == DVDX_INVALID);
  dvdx_state few = rope.state;
  few.count = 3;
  CHECK(dvdx_instance_create(h.plan, &few, &h.instance, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "state.count");
  REQUIRE(dvdx_instance_create(h.plan, &rope.state, &h.instance, &h.error) == DVDX_DONE);
  const std::array<double, 3> at{};
  CHECK(dvdx_instance_move_body(h.instance, 4, at.data(), nullptr, DVDX_MOVING, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "motions[4]");
  CHECK(dvdx_instance_move_body(h.instance, 0, nullptr, nullptr, DVDX_JUMP, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instance_move_pins(h.instance, 0, nullptr, 1, DVDX_JUMP, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "places");
  CHECK(dvdx_instance_move_skin(h.instance, 0, at.data(), nullptr, 1, DVDX_JUMP, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instance_step(h.instance, NAN, nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "step");
  CHECK(dvdx_instance_advance(h.instance, -1, 8, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instance_set_wind(h.instance, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instance_step(nullptr, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "instance");
  CHECK(std::isnan(dvdx_instance_step_size(nullptr)));
  dvdx_instance_destroy(nullptr);
}

TEST_CASE("c: a plan made of a plan's scene has its bits, and a workspace does not ignore poses of the plan") {
  Rope one, two;
  Handles h(one);
  const dvdx_scalars stiffer{.all = 900, .each = nullptr, .count = 0};
  REQUIRE(dvdx_plan_set_springs_stiffness(h.plan, 0, &stiffer, 0.2, &h.error) == DVDX_DONE);
  dvdx_scene* copy = nullptr;
  REQUIRE(dvdx_plan_scene(h.plan, &copy, &h.error) == DVDX_DONE);
  dvdx_options options{};
  options.step = 1.0 / 60;
  options.precision = DVDX_FLOAT64;
  dvdx_plan* other = nullptr;
  REQUIRE(dvdx_plan_create(copy, &options, &two.state, &other, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_step(h.plan, &one.state, 9, nullptr, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_step(other, &two.state, 9, nullptr, &h.error) == DVDX_DONE);
  CHECK(one.columns == two.columns);
  dvdx_workspace* workspace = nullptr;
  REQUIRE(dvdx_workspace_create(other, &workspace, &h.error) == DVDX_DONE);
  const std::array<double, 3> at{};
  REQUIRE(dvdx_plan_set_pose(other, 0, at.data(), nullptr, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_step_in(other, workspace, &two.state, 1, nullptr, nullptr, &h.error) == DVDX_DRIVEN_ELSEWHERE);
  CHECK(std::string(h.error.message).find("tell the workspace") != std::string::npos);
  dvdx_scene* none = nullptr;
  CHECK(dvdx_plan_scene(nullptr, &none, &h.error) == DVDX_INVALID);
  dvdx_scene_destroy(copy);
  dvdx_workspace_destroy(workspace);
  dvdx_plan_destroy(other);
}

TEST_CASE("c: instances step at once as each does alone, and a refusal names the instance that is wrong") {
  Rope one, two;
  Handles h(one);
  REQUIRE(dvdx_instance_create(h.plan, &one.state, &h.instance, &h.error) == DVDX_DONE);
  dvdx_instance* other = nullptr;
  REQUIRE(dvdx_instance_create(h.plan, &two.state, &other, &h.error) == DVDX_DONE);
  const std::array<dvdx_instance*, 2> both{h.instance, other};
  const std::array<double, 2> times{1.0 / 60, 1.0 / 60};
  REQUIRE(dvdx_instances_step(both.data(), 2, times.data(), 2, nullptr, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_instances_step(both.data(), 2, times.data(), 1, nullptr, &h.error) == DVDX_DONE);
  CHECK(one.columns == two.columns);
  Rope alone;
  REQUIRE(dvdx_plan_step(h.plan, &alone.state, 2, nullptr, &h.error) == DVDX_DONE);
  CHECK(one.columns == alone.columns);
  CHECK(dvdx_instances_step(nullptr, 0, times.data(), 1, nullptr, &h.error) == DVDX_DONE);
  CHECK(dvdx_instances_step(nullptr, 2, times.data(), 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_instances_step(both.data(), 2, nullptr, 1, nullptr, &h.error) == DVDX_INVALID);
  const std::array<double, 3> three{};
  CHECK(dvdx_instances_step(both.data(), 2, three.data(), 3, nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "frame_times");
  const std::array<dvdx_instance*, 2> twice{other, other}, none{other, nullptr};
  CHECK(dvdx_instances_step(twice.data(), 2, times.data(), 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "instances[1]");
  CHECK(dvdx_instances_step(none.data(), 2, times.data(), 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "instances[1]");
  dvdx_instance_destroy(other);
}

}  // namespace c_instance_test
