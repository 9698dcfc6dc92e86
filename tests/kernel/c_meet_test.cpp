// dvdx.h: particles that meet, with the results of C++.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::meet_test {

TEST_CASE("c: a part of cells outside 0 to 1 is refused when the plan is made") {
  Handles h;
  dvdx_meet meet{};
  meet.part_of_cells = 1.5;
  CHECK(dvdx_scene_set_meet(h.scene, &meet, &h.error) == DVDX_DONE);
  Arrays<double> particles(3);
  dvdx_state state = particles.c();
  CHECK(h.make(options_of(0.125, DVDX_FLOAT64), &state) == DVDX_INVALID);
  CHECK(h.message() == "meet.part_of_cells is 1.5: must be a number > 0 and < 1");
}

TEST_CASE("c: balls meet as in C++, in the groups that the caller names") {
  Handles h;
  const double radii[] = {0.125, 0.25, 0.125};
  const dvdx_scalars radius{0, &radii[0], 3};
  dvdx_meet meet{};
  meet.radius = &radius;
  meet.restitution = 0.5;
  meet.friction = 0.25;
  const std::uint16_t of[] = {0, 1, 2};
  const std::uint16_t pairs[] = {0, 1};
  const dvdx_meet_groups groups{&of[0], 3, &pairs[0], 1};
  CHECK(dvdx_scene_set_meet_groups(h.scene, &groups, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "groups is 3 particles: must be set after what meets");
  CHECK(dvdx_scene_set_meet(h.scene, nullptr, &h.error) == DVDX_INVALID);
  meet.near_at_start = static_cast<dvdx_near_at_start>(3);
  CHECK(dvdx_scene_set_meet(h.scene, &meet, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "meet.near_at_start");
  meet.near_at_start = DVDX_NEAR_AT_START_BY_KIND;
  CHECK(dvdx_scene_set_meet(h.scene, &meet, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_meet_groups(h.scene, &groups, &h.error) == DVDX_DONE);

  dvdx::Scene scene;
  scene.add(dvdx::Meet{.radius = std::vector<double>{0.125, 0.25, 0.125},
                       .restitution = 0.5,
                       .friction = 0.25,
                       .groups = dvdx::MeetGroups{.of = {0, 1, 2}, .meet = {{0, 1}}}});
  Arrays<double> by_c(3);
  Arrays<double> by_cpp(3);
  for (Arrays<double>* by : {&by_c, &by_cpp}) {  // the first meets the second, and passes through the third
    for (std::size_t i = 0; i < 3; ++i) {
      by->column(0)[i] = i == 2 ? 0.5 : static_cast<double>(i);
      by->column(1)[i] = i == 1 ? 0.125 : 0;
      by->column(3)[i] = i == 0 ? 2 : 0;
    }
  }
  dvdx_state in_c = by_c.c();
  auto in_cpp = by_cpp.cpp();
  REQUIRE(h.make(options_of(0.125, DVDX_FLOAT64), &in_c) == DVDX_DONE);
  auto plan = dvdx::compile<double>(scene, {.step = 0.125}, in_cpp);
  REQUIRE(plan.has_value());
  CHECK(dvdx_plan_step(h.plan, &in_c, 8, nullptr, &h.error) == DVDX_DONE);
  CHECK(plan->step(in_cpp, 8) == dvdx::StepResult::done);
  CHECK(by_c.memory == by_cpp.memory);
  CHECK(by_c.column(3)[1] > 0);
  CHECK(by_c.column(3)[2] == 0);
  dvdx_meetings by_plan{};
  CHECK(dvdx_plan_meetings(h.plan, nullptr, &by_plan, &h.error) == DVDX_DONE);
  CHECK(by_plan.substeps == plan->meetings().substeps);
  CHECK(by_plan.substeps >= 8);
  CHECK(dvdx_plan_meetings(h.plan, nullptr, nullptr, &h.error) == DVDX_INVALID);
}

}  // namespace c_handles::meet_test
