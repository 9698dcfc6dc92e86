// dvdx.h: forces, contacts, networks, constraints and air, each with the result of C++.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::scene_test {

dvdx::Scene same_forces() {
  using namespace dvdx;
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Polynomial{.acceleration = {{0.1, 0, 0}, {0, 0, 0.2}}});
  scene.add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 3, .phase = 0.5});
  scene.add(Spring{.stiffness = {10, 20, 30}, .damping = 0.3, .anchor = at_start});
  scene.add(RadialSpring{.stiffness = 5.0, .rest_length = 0.5});
  scene.add(Drag{.coefficient = 0.02, .wind = {3, 0, 0}, .method = Method::exact});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  scene.add(Sphere{.radius = 50, .side = Side::inside});
  scene.add(Capsule{.ends = {{{4, 0, 0}, {0, 2, 0}}}, .radius = {0.5, 0.25}, .thickness = 0.125, .push_out = 0.75});
  scene.add(OrientedBox{.center = {0, -3, 0}, .half_extents = {2, 2, 2}, .rotation = {0, 0, 0.5}});
  scene.add(
      Convex{.planes = {{{1, 0, 0}, 9}, {{-1, 0, 0}, -8}, {{0, 1, 0}, 1}, {{0, -1, 0}, 0}, {{0, 0, 1}, 1}, {{0, 0, -1}, 0}}});
  scene.add(TriangleMesh{.vertices = {{-6, 0, 0}, {-5, 0, 0}, {-6, 1, 0}, {-6, 0, 1}},
                         .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
                         .cell = 0.125,
                         .restitution = 0.5});
  return scene;
}

TEST_CASE_TEMPLATE("c: every force and contact moves particles as C++ does, bit by bit", T, float, double) {
  Handles h;
  add_forces(h);
  Arrays<T> by_c(100);
  Arrays<T> by_cpp(100);
  dvdx_state state = by_c.c();
  const auto options = options_of(1.0 / 60, state.precision);
  REQUIRE(h.make(options, &state) == DVDX_DONE);
  REQUIRE(dvdx_plan_step(h.plan, &state, 30, nullptr, &h.error) == DVDX_DONE);
  auto same = by_cpp.cpp();
  const auto plan = dvdx::compile<T>(same_forces(), {.step = 1.0 / 60}, same);
  REQUIRE(plan.has_value());
  (void)plan->step(same, 30);
  CHECK(by_c.memory == by_cpp.memory);
  CHECK(state.clock.seconds == same.clock.seconds);
  CHECK(dvdx_state_hash(&state) == dvdx::state_hash(same));
}

TEST_CASE("c: networks, constraints and fixed particles move as C++ moves them, and their limit is told") {
  Handles h;
  add_joints(h);
  Arrays<double> by_c(6);
  Arrays<double> by_cpp(6);
  dvdx_state state = by_c.c();
  REQUIRE(h.make(options_of(1.0 / 60, DVDX_FLOAT64), &state) == DVDX_DONE);
  REQUIRE(dvdx_plan_step(h.plan, &state, 20, nullptr, &h.error) == DVDX_DONE);
  auto same = by_cpp.cpp();
  const auto plan = dvdx::compile<double>(scene_of_joints(), {.step = 1.0 / 60}, same);
  REQUIRE(plan.has_value());
  (void)plan->step(same, 20);
  CHECK(by_c.memory == by_cpp.memory);
  dvdx_network_limit limit{};
  CHECK(dvdx_plan_network_limit(h.plan, &limit) == 1);
  CHECK(limit.substeps == 10);
  CHECK(limit.bound == plan->network_limit()->bound);
}

TEST_CASE("c: a grid of unlike masses with an origin is stepped, and another count is refused") {
  Handles h;
  dvdx_grid grid{};
  grid.rows = grid.columns = 2;
  grid.edge_u[0] = grid.edge_v[2] = 1;
  grid.structural = 10;
  const std::vector<double> masses = {1, 2, 3, 4};
  const dvdx_scalars mass{0, masses.data(), masses.size()};
  const double origin[] = {100, 0, 0};
  CHECK(dvdx_scene_add_grid(h.scene, &grid, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_mass(h.scene, &mass, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_origin(h.scene, &origin[0], 1, &h.error) == DVDX_DONE);
  Arrays<float> arrays(4);
  dvdx_state state = arrays.c();
  REQUIRE(h.make(options_of(0.01), &state) == DVDX_DONE);
  CHECK(dvdx_plan_step(h.plan, &state, 3, nullptr, &h.error) == DVDX_DONE);
  CHECK(std::isfinite(arrays.memory[0]));
  state.count = 3;
  CHECK(dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error) == DVDX_COUNT_DIFFERS);
}

TEST_CASE("c: air on a grid and on triangles moves particles as in C++, also after the wind changes") {
  const double gusts[] = {0, 1, 0, 3, 0.5};
  const dvdx_wind wind{{1, 2, 3}, &gusts[0], 1};
  const dvdx_wind calm{{0, 0.5, 0}, nullptr, 0};
  const std::uint32_t corners[] = {0, 1, 2, 1, 2, 3};
  const std::uint32_t ends[] = {0, 1, 1, 3, 3, 2, 2, 0};
  for (const bool is_list : {false, true}) {
    Handles h;
    dvdx_grid grid{};
    grid.rows = grid.columns = 2;
    grid.edge_u[0] = grid.edge_v[2] = 1;
    grid.structural = 5;
    dvdx_springs springs{};
    springs.pairs = &ends[0];
    springs.count = 4;
    springs.stiffness.all = 5;
    dvdx_aerodynamics air{0, 1.2, 1, 0.5, nullptr, 0};
    CHECK(dvdx_scene_set_aerodynamics(h.scene, &air, &h.error) == DVDX_INVALID);
    CHECK(h.message() == "aerodynamics.network is 0: must be below the scene's 0 networks");
    CHECK((is_list ? dvdx_scene_add_springs(h.scene, &springs, &h.error) : dvdx_scene_add_grid(h.scene, &grid, &h.error)) ==
          DVDX_DONE);
    air.count = 2;
    air.triangles = is_list ? nullptr : &corners[0];
    CHECK(dvdx_scene_set_aerodynamics(h.scene, &air, &h.error) == DVDX_INVALID);
    if (is_list) air.triangles = &corners[0];
    if (!is_list) air = {0, 1.2, 1, 0.5, nullptr, 0};
    CHECK(dvdx_scene_set_aerodynamics(h.scene, &air, &h.error) == DVDX_DONE);
    CHECK(dvdx_scene_set_wind(h.scene, &wind, &h.error) == DVDX_DONE);

    dvdx::Scene scene;
    if (is_list) {
      scene.add(dvdx::Network(dvdx::Springs{.pairs = {{0, 1}, {1, 3}, {3, 2}, {2, 0}}, .stiffness = 5.0}));
      std::get<dvdx::Springs>(scene.networks[0]).triangles = {{0, 1, 2}, {1, 2, 3}};
    } else {
      scene.add(dvdx::Network(dvdx::Grid{.rows = 2, .columns = 2, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 5}));
    }
    std::visit([](auto& of) { of.aerodynamics = dvdx::Aerodynamics{}; }, scene.networks[0]);
    scene.wind = {.mean = {1, 2, 3}, .gusts = {{{0, 1, 0}, 3, 0.5}}};
    Arrays<double> by_c(4);
    Arrays<double> by_cpp(4);
    for (Arrays<double>* by : {&by_c, &by_cpp}) by->column(2)[2] = by->column(2)[3] = 1;
    dvdx_state in_c = by_c.c();
    auto in_cpp = by_cpp.cpp();
    REQUIRE(h.make(options_of(0.125, DVDX_FLOAT64), &in_c) == DVDX_DONE);
    auto plan = dvdx::compile<double>(scene, {.step = 0.125}, in_cpp);
    REQUIRE(plan.has_value());
    CHECK(dvdx_plan_step(h.plan, &in_c, 3, nullptr, &h.error) == DVDX_DONE);
    CHECK(plan->step(in_cpp, 3) == dvdx::StepResult::done);
    CHECK(by_c.memory == by_cpp.memory);
    CHECK(dvdx_plan_set_wind(h.plan, &calm, &h.error) == DVDX_DONE);
    CHECK(plan->set_wind({.mean = {0, 0.5, 0}}).has_value());
    CHECK(dvdx_plan_step(h.plan, &in_c, 3, nullptr, &h.error) == DVDX_DONE);
    CHECK(plan->step(in_cpp, 3) == dvdx::StepResult::done);
    CHECK(by_c.memory == by_cpp.memory);
    CHECK(dvdx_plan_set_wind(h.plan, nullptr, &h.error) == DVDX_INVALID);
  }
}

}  // namespace c_handles::scene_test
