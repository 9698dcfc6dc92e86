// dvdx.h: motions and skins, with the results of C++, and driven by the caller.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::motion_test {

TEST_CASE("c: motions carry particles and contacts as C++ has them, and the caller drives them") {
  Handles h;
  const double keys[] = {0, 0, 0, 0, 0, 0, 0, 2, 4, 0, 0, 0, 1, 0};
  const dvdx_motion motion{{0, 0, 0}, &keys[0], 2};
  const std::size_t ids[] = {1};
  const dvdx_kinematic followers{&ids[0], 1, 0};
  dvdx_plane plane{};
  plane.normal[1] = 1;
  plane.offset = 0.5;
  CHECK(dvdx_scene_add_motion(h.scene, &motion, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_kinematic(h.scene, &followers, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_plane(h.scene, &plane, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_contact_motion(h.scene, 1, 0, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "contact is 1: must be below the scene's 1 contacts");
  CHECK(dvdx_scene_set_contact_motion(h.scene, 0, 0, &h.error) == DVDX_DONE);

  dvdx::Scene scene;
  scene.add(dvdx::Motion{.center = {}, .keys = {{.time = 0}, {.time = 2, .translation = {4, 0, 0}, .rotation = {0, 1, 0}}}});
  scene.add(dvdx::Kinematic{.particles = {1}, .motion = 0});
  scene.add(dvdx::Plane{.normal = {0, 1, 0}, .offset = 0.5, .motion = 0});
  Arrays<double> by_c(3);
  Arrays<double> by_cpp(3);
  dvdx_state in_c = by_c.c();
  auto in_cpp = by_cpp.cpp();
  REQUIRE(h.make(options_of(0.125, DVDX_FLOAT64), &in_c) == DVDX_DONE);
  auto plan = dvdx::compile<double>(scene, {.step = 0.125}, in_cpp);
  REQUIRE(plan.has_value());
  const auto step_both = [&] {
    CHECK(dvdx_plan_step(h.plan, &in_c, 1, nullptr, &h.error) == DVDX_DONE);
    CHECK(plan->step(in_cpp) == dvdx::StepResult::done);
    CHECK(by_c.memory == by_cpp.memory);
  };
  step_both();
  const double there[] = {1, 2, 3};
  const double turn[] = {0, 0.5, 0};
  CHECK(dvdx_plan_set_pose(h.plan, 0, &there[0], &turn[0], &h.error) == DVDX_DONE);
  CHECK(plan->set_pose(0, {.translation = {1, 2, 3}, .rotation = {0, 0.5, 0}}).has_value());
  step_both();
  CHECK(dvdx_plan_set_pose(h.plan, 0, &there[0], nullptr, &h.error) == DVDX_DONE);
  CHECK(plan->set_pose(0, {.translation = {1, 2, 3}, .rotation = {}}).has_value());
  step_both();
  CHECK(dvdx_plan_set_places(h.plan, 0, &there[0], 1, &h.error) == DVDX_DONE);
  const std::vector<dvdx::Vec3> place{{1, 2, 3}};
  CHECK(plan->set_places(0, place).has_value());
  step_both();
  CHECK(by_c.column(1)[1] == 2);
  CHECK(dvdx_plan_jump_pose(h.plan, 0, &turn[0], &there[0], &h.error) == DVDX_DONE);
  CHECK(plan->set_pose(0, {.translation = {0, 0.5, 0}, .rotation = {1, 2, 3}}, dvdx::Arrival::jump).has_value());
  step_both();
  CHECK(dvdx_plan_jump_places(h.plan, 0, &turn[0], 1, &h.error) == DVDX_DONE);
  CHECK(plan->set_places(0, std::vector<dvdx::Vec3>{{0, 0.5, 0}}, dvdx::Arrival::jump).has_value());
  step_both();
  CHECK(by_c.column(1)[1] == 0.5);
  CHECK(dvdx_plan_teleport(h.plan, &in_c, &there[0], &turn[0], &h.error) == DVDX_DONE);
  CHECK(plan->teleport(in_cpp, {.translation = {1, 2, 3}, .rotation = {0, 0.5, 0}}).has_value());
  step_both();
  CHECK(by_c.column(1)[1] == 2.5);
  CHECK(dvdx_plan_teleport(h.plan, &in_c, &there[0], nullptr, &h.error) == DVDX_DONE);
  CHECK(plan->teleport(in_cpp, {.translation = {1, 2, 3}, .rotation = {}}).has_value());
  step_both();
  CHECK(dvdx_plan_teleport(h.plan, &in_c, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "translation");
  CHECK(dvdx_plan_teleport(h.plan, nullptr, &there[0], nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_teleport(nullptr, &in_c, &there[0], nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_scene_set_jump(h.scene, 0, 0, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_jump(h.scene, 1, 0, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "motion is 1: must be below the scene's 1 motions");
  CHECK(dvdx_scene_set_jump(h.scene, 0, 5, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "key");
  CHECK(dvdx_plan_jump_pose(h.plan, 1, &there[0], nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_jump_places(h.plan, 0, nullptr, 1, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_pose(h.plan, 1, &there[0], nullptr, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "motions[1] is not there: must be an index below 1");
  CHECK(dvdx_plan_set_pose(h.plan, 0, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_places(h.plan, 0, &there[0], 0, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_places(h.plan, 0, nullptr, 1, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "places");
}

TEST_CASE("c: skins, back-stops and tethers hold as C++ has them, and the caller drives them") {
  Handles h;
  const size_t ids[] = {1, 2};
  const double points[] = {1, 0, 0, 2, 0, 0};
  const double limits[] = {0.25, 0.5};
  const dvdx_scalars at_most{0, &limits[0], 2};
  const dvdx_skin skin{&ids[0], 2, &points[0], &at_most};
  const double normal[] = {0, 2, 0};
  const dvdx_backstop backstop{0, &normal[0], 1, {0.125, nullptr, 0}, {0.5, nullptr, 0}};
  const std::uint32_t ends[] = {0, 1, 1, 2};
  dvdx_springs springs{};
  springs.pairs = &ends[0];
  springs.count = 2;
  const dvdx_tethers tethers{0, 1.5};
  const size_t fixed[] = {0};
  const dvdx_constant gravity{{0, -8, 0}, DVDX_METHOD_DEFAULT};
  CHECK(dvdx_scene_set_backstop(h.scene, &backstop, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "backstop.skin is 0: must be below the scene's 0 skins");
  CHECK(dvdx_scene_add_skin(h.scene, &skin, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_backstop(h.scene, &backstop, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_tethers(h.scene, &tethers, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_fixed(h.scene, &fixed[0], 1, &h.error) == DVDX_DONE);

  dvdx::Scene scene;
  scene.add(dvdx::Skin{.particles = {1, 2},
                       .points = {{1, 0, 0}, {2, 0, 0}},
                       .at_most = std::vector<double>{0.25, 0.5},
                       .backstop = dvdx::Backstop{.normals = {{0, 2, 0}}, .offset = 0.125, .radius = 0.5}});
  scene.add(dvdx::Network(dvdx::Springs{.pairs = {{0, 1}, {1, 2}}}));
  scene.add(dvdx::Tethers{.network = 0, .stretch = 1.5});
  scene.add(dvdx::Constant{.acceleration = {0, -8, 0}});
  scene.fixed = {0};
  Arrays<double> by_c(3);
  Arrays<double> by_cpp(3);
  for (Arrays<double>* by : {&by_c, &by_cpp}) {
    for (std::size_t i = 0; i < 3; ++i) by->column(0)[i] = static_cast<double>(i);
  }
  dvdx_state in_c = by_c.c();
  auto in_cpp = by_cpp.cpp();
  REQUIRE(h.make(options_of(0.125, DVDX_FLOAT64), &in_c) == DVDX_DONE);
  auto plan = dvdx::compile<double>(scene, {.step = 0.125}, in_cpp);
  REQUIRE(plan.has_value());
  const auto step_both = [&] {
    CHECK(dvdx_plan_step(h.plan, &in_c, 2, nullptr, &h.error) == DVDX_DONE);
    CHECK(plan->step(in_cpp, 2) == dvdx::StepResult::done);
    CHECK(by_c.memory == by_cpp.memory);
  };
  step_both();
  CHECK(std::hypot(by_c.column(0)[1] - 1, by_c.column(1)[1], by_c.column(2)[1]) <= 0.25 + 1e-12);
  const double there[] = {1, 1, 0, 2, 1, 0};
  const double normals[] = {0, 1, 0, 0, 1, 1};
  CHECK(dvdx_plan_set_skin(h.plan, 0, &there[0], &normals[0], 2, &h.error) == DVDX_DONE);
  CHECK(plan->set_skin(0, std::vector<dvdx::Vec3>{{1, 1, 0}, {2, 1, 0}}, std::vector<dvdx::Vec3>{{0, 1, 0}, {0, 1, 1}})
            .has_value());
  step_both();
  CHECK(dvdx_plan_set_skin(h.plan, 0, &points[0], nullptr, 2, &h.error) == DVDX_DONE);
  CHECK(plan->set_skin(0, std::vector<dvdx::Vec3>{{1, 0, 0}, {2, 0, 0}}).has_value());
  step_both();
  CHECK(dvdx_plan_set_skin(h.plan, 1, &points[0], nullptr, 2, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "skins[1] is not there: must be an index below 1");
  CHECK(dvdx_plan_set_skin(h.plan, 0, nullptr, nullptr, 2, &h.error) == DVDX_INVALID);
  CHECK(dvdx_scene_set_skin_motion(h.scene, 1, 0, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "skin is 1: must be below the scene's 1 skins");
}

}  // namespace c_handles::motion_test
