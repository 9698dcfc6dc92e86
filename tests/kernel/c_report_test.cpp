// dvdx.h: reports of contacts; normals and bounds for drawing.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "dvdx/dvdx.h"
#include "kernel/c_handles.hpp"

namespace c_handles::report_test {

TEST_CASE("C: a report tells impulses and events of contacts, in the caller's memory") {
  Handles h;
  dvdx_constant gravity{};
  gravity.acceleration[1] = -8;
  REQUIRE(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  dvdx_plane floor{};
  floor.normal[1] = 1;
  floor.surface.restitution = 0.5;
  REQUIRE(dvdx_scene_add_plane(h.scene, &floor, &h.error) == DVDX_DONE);
  REQUIRE(h.make(options_of(0.125, DVDX_FLOAT64)) == DVDX_DONE);
  double x[6] = {0, 0.81, 0, 0, 0, 0};
  dvdx_state state = dvdx_soa(DVDX_FLOAT64, &x[0], &x[1], &x[2], &x[3], &x[4], &x[5], 1);
  dvdx_contact_event room[2];
  dvdx_contact_report* report = nullptr;
  REQUIRE(dvdx_contact_report_create(1, &room[0], 2, &report, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_step_and_report(h.plan, &state, 6, nullptr, report, &h.error) == DVDX_DONE);
  CHECK(dvdx_contact_report_events(report) == 1);
  CHECK(dvdx_contact_report_lost(report) == 0);
  CHECK(room[0].step == 4);
  CHECK(std::abs(room[0].time - 0.45) < 1e-12);
  CHECK(room[0].n[1] == 1);
  CHECK(std::abs(room[0].impulse[1] + 5.4) < 1e-12);
  dvdx_contact_sum sum{};
  REQUIRE(dvdx_contact_report_sum(report, 0, &sum, &h.error) == DVDX_DONE);
  CHECK(sum.hits == 1);
  CHECK(sum.impulse[1] == room[0].impulse[1]);
  CHECK(dvdx_contact_report_sum(report, 1, &sum, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "contact");
  dvdx_contact_report_clear(report);
  CHECK(dvdx_contact_report_events(report) == 0);
  dvdx_contact_report_destroy(report);

  REQUIRE(dvdx_contact_report_create(2, nullptr, 0, &report, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_step_and_report(h.plan, &state, 1, nullptr, report, &h.error) == DVDX_REPORT_DIFFERS);
  CHECK(h.message() == dvdx_status_text(DVDX_REPORT_DIFFERS));
  CHECK(dvdx_plan_step_and_report(h.plan, &state, 1, nullptr, nullptr, &h.error) == DVDX_INVALID);
  dvdx_contact_report_destroy(report);
  CHECK(dvdx_contact_report_create(1, nullptr, 3, &report, &h.error) == DVDX_INVALID);
  CHECK(report == nullptr);
}

TEST_CASE("C: normals and bounds for drawing") {
  float x[18] = {0, 1, 0, 1, 5, 0, 0, 0, 1, 1, 5, 0, 0, 0, 0, 0, 5, 0};  // four corners of a cell, and one particle apart
  float v[18]{};
  dvdx_state state = dvdx_soa(DVDX_FLOAT32, &x[0], &x[6], &x[12], &v[0], &v[6], &v[12], 5);
  float n[15];
  for (float& each : n) each = 9;
  const dvdx_column to[3] = {{&n[0], 0, 0, 5}, {&n[5], 0, 0, 5}, {&n[10], 0, 0, 5}};
  dvdx_error error{};
  REQUIRE(dvdx_grid_normals(2, 2, 0, &state, &to[0], &error) == DVDX_DONE);
  for (std::size_t i = 0; i < 4; ++i) CHECK((n[i] == 0 && n[5 + i] == 0 && n[10 + i] == 1));
  CHECK(n[14] == 9);
  const std::uint32_t corners[] = {0, 2, 1};
  REQUIRE(dvdx_triangle_normals(&corners[0], 1, &state, &to[0], &error) == DVDX_DONE);
  CHECK(n[10] == -1);
  CHECK(n[13] == 0);
  CHECK(n[14] == 0);
  dvdx_bounds box{};
  REQUIRE(dvdx_state_bounds(&state, &box, &error) == DVDX_DONE);
  CHECK(box.particles == 5);
  CHECK(box.least[0] == 0);
  CHECK(box.most[2] == 5);

  CHECK(dvdx_grid_normals(3, 2, 0, &state, &to[0], &error) == DVDX_INVALID);
  CHECK(dvdx_grid_normals(2, 2, 2, &state, &to[0], &error) == DVDX_INVALID);
  const std::uint32_t beyond[] = {0, 5, 1};
  CHECK(dvdx_triangle_normals(&beyond[0], 1, &state, &to[0], &error) == DVDX_INVALID);
  CHECK(std::string(&error.field[0]) == "corners[1]");
  const dvdx_column small[3] = {{&n[0], 0, 0, 3}, {&n[5], 0, 0, 5}, {&n[10], 0, 0, 5}};
  CHECK(dvdx_grid_normals(2, 2, 0, &state, &small[0], &error) == DVDX_CAPACITY_TOO_SMALL);
  CHECK(dvdx_grid_normals(2, 2, 0, nullptr, &to[0], &error) == DVDX_INVALID);
  CHECK(dvdx_state_bounds(&state, nullptr, &error) == DVDX_INVALID);
}

}  // namespace c_handles::report_test
