// dvdx.h: the information that a plan gives, and its changes while it runs.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::plan_test {

TEST_CASE("c: a plan tells the longest sub-step that sequential chose, and takes the one that a scene names") {
  const auto limit_by = [](dvdx_scheme scheme, double longest) {
    Handles h;
    add_joints(h);
    dvdx_constant gravity{};
    gravity.acceleration[1] = -9.81;
    dvdx_coupling coupling{};
    coupling.scheme = scheme;
    coupling.longest_substep = longest;
    CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
    CHECK(dvdx_scene_set_coupling(h.scene, &coupling, &h.error) == DVDX_DONE);
    Arrays<double> arrays(6);
    dvdx_state state = arrays.c();
    REQUIRE(h.make(options_of(1.0 / 60, DVDX_FLOAT64), &state) == DVDX_DONE);
    dvdx_network_limit limit{};
    CHECK(dvdx_plan_network_limit(h.plan, &limit) == 1);
    return limit;
  };
  const dvdx_network_limit chosen = limit_by(DVDX_SEQUENTIAL, 0);
  CHECK(chosen.longest_substep > 0);
  CHECK(limit_by(DVDX_SEQUENTIAL, chosen.longest_substep).substeps == chosen.substeps);
  const dvdx_network_limit asked_for = limit_by(DVDX_SEQUENTIAL, 1.0 / 60 / 6.5);
  CHECK(asked_for.substeps == 7);
  CHECK(asked_for.longest_substep == 1.0 / 60 / 6.5);
  CHECK(limit_by(DVDX_LEAPFROG, 0).longest_substep == 0);
}

TEST_CASE("c: a limit of the sub-steps cuts a hitch, and a state is checked") {
  Handles h;
  add_joints(h);
  dvdx_coupling coupling{};
  coupling.most_substeps = 40;
  CHECK(dvdx_scene_set_coupling(h.scene, &coupling, &h.error) == DVDX_DONE);
  Arrays<double> arrays(6);
  dvdx_state state = arrays.c();
  REQUIRE(h.make(options_of(1.0 / 60, DVDX_FLOAT64), &state) == DVDX_DONE);
  CHECK(dvdx_plan_set_step(h.plan, 100, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_step_size(h.plan) > 1.0 / 60);
  CHECK(dvdx_plan_step_size(h.plan) < 100);

  auto plan = dvdx::compile<double>(scene_of_joints(), {.step = 1.0 / 60}, arrays.cpp());
  REQUIRE(plan.has_value());
  const dvdx::StateCheck wanted = plan->check(arrays.cpp());
  dvdx_state_check found{};
  CHECK(dvdx_plan_check(h.plan, &state, &found, &h.error) == DVDX_DONE);
  CHECK(found.stretch == wanted.stretch);
  CHECK(found.spring[1] == wanted.spring[1]);
  CHECK(found.elastic == wanted.elastic);
  CHECK(found.kinetic == wanted.kinetic);
  CHECK(found.off == wanted.off);
  CHECK(found.not_finite == 0);
  state.count = 5;
  CHECK(dvdx_plan_check(h.plan, &state, &found, &h.error) == DVDX_COUNT_DIFFERS);
  CHECK(dvdx_plan_check(h.plan, &state, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_check(h.plan, nullptr, &found, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_check(nullptr, &state, &found, &h.error) == DVDX_INVALID);
}

TEST_CASE("c: a plan tells a sheet's fewest sub-steps apart from those safe in any position") {
  using namespace dvdx;
  constexpr std::size_t rows = 5, columns = 8;
  Handles h;
  dvdx_grid grid{};
  grid.rows = rows;
  grid.columns = columns;
  grid.edge_u[0] = grid.edge_v[2] = 1;
  grid.structural = 50;
  CHECK(dvdx_scene_add_grid(h.scene, &grid, &h.error) == DVDX_DONE);
  Soa<double> memory(rows * columns);
  State<double> flat = memory.view();
  for (std::size_t i = 0; i < flat.count; ++i) {
    flat.x[0][i] = static_cast<double>(i % columns) / (columns - 1);
    flat.x[1][i] = 0;
    flat.x[2][i] = static_cast<double>(i / columns) / (rows - 1);
    for (auto& column : flat.v) column[i] = 0;
  }
  const dvdx_state state = dvdx_soa(DVDX_FLOAT64, &flat.x[0][0], &flat.x[1][0], &flat.x[2][0], &flat.v[0][0], &flat.v[1][0],
                                    &flat.v[2][0], flat.count);
  REQUIRE(h.make(options_of(1, DVDX_FLOAT64), &state) == DVDX_DONE);
  Scene scene;
  scene.add(Network(Grid{.rows = rows, .columns = columns, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 50}));
  const auto plan = compile<double>(scene, {.step = 1}, flat);
  REQUIRE(plan.has_value());
  const NetworkLimit wanted = *plan->network_limit();
  REQUIRE(wanted.fewest != wanted.safe);
  dvdx_network_limit limit{};
  CHECK(dvdx_plan_network_limit(h.plan, &limit) == 1);
  CHECK(limit.fewest == wanted.fewest);
  CHECK(limit.safe == wanted.safe);
  CHECK(limit.substeps == wanted.substeps);
  CHECK(limit.frequency == wanted.frequency);
}

TEST_CASE("c: a plan tells the instruction set that was asked for, and refuses too many impacts") {
  Handles h;
  dvdx_options options = options_of(0.01);
  options.isa = DVDX_ISA_REFERENCE;
  REQUIRE(h.make(options) == DVDX_DONE);
  CHECK(dvdx_plan_isa(h.plan) == DVDX_ISA_REFERENCE);
  Handles other;
  options.impacts = 1001;
  CHECK(other.make(options) == DVDX_INVALID);
  CHECK(other.field() == "impacts");
}

TEST_CASE("c: seek goes where steps go, and a plan takes another step and force and describes itself") {
  Handles h;
  dvdx_spring spring{};
  spring.stiffness.all = 40;
  CHECK(dvdx_scene_add_spring(h.scene, &spring, &h.error) == DVDX_DONE);
  REQUIRE(h.make(options_of(0.01, DVDX_FLOAT64)) == DVDX_DONE);
  Arrays<double> walked(3);
  Arrays<double> sought(3);
  dvdx_state a = walked.c();
  dvdx_state b = sought.c();
  CHECK(dvdx_plan_step(h.plan, &a, 100, nullptr, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_seek(h.plan, &b, 100, &h.error) == DVDX_DONE);
  for (std::size_t i = 0; i < walked.memory.size(); ++i) CHECK(std::abs(walked.memory[i] - sought.memory[i]) < 1e-12);
  CHECK(b.clock.seconds == a.clock.seconds);
  CHECK(dvdx_plan_set_step(h.plan, 0.02, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_step_size(h.plan) == 0.02);
  CHECK(dvdx_plan_precision(h.plan) == DVDX_FLOAT64);
  CHECK(dvdx_plan_isa(h.plan) != DVDX_ISA_BEST);
  CHECK(dvdx_plan_replace(h.plan, 0, h.scene, 0, &h.error) == DVDX_DONE);
  dvdx_network_limit limit{};
  CHECK(dvdx_plan_network_limit(h.plan, &limit) == 0);
  const std::size_t length = dvdx_plan_explain(h.plan, nullptr, 0);
  std::string text(length + 1, '?');
  CHECK(dvdx_plan_explain(h.plan, text.data(), text.size()) == length);
  CHECK(text.back() == '\0');
  char few[5];
  CHECK(dvdx_build_info(&few[0], sizeof few) > 20);
  CHECK(std::string(&few[0]) == "dvdx");
  CHECK(dvdx_abi_version() == DVDX_ABI_VERSION);
  CHECK(std::string(dvdx_version()) == DVDX_VERSION);
}

TEST_CASE("c: a plan is changed while it runs as in C++") {
  Handles h;
  const std::vector<uint32_t> pairs = {0, 1, 1, 2, 2, 3};
  dvdx_springs springs{};
  springs.pairs = pairs.data();
  springs.count = 3;
  springs.stiffness.all = 40;
  CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_DONE);
  dvdx_plane floor{};
  floor.normal[1] = 1;
  floor.offset = -5;
  floor.surface.restitution = 0.5;
  CHECK(dvdx_scene_add_plane(h.scene, &floor, &h.error) == DVDX_DONE);
  Arrays<double> arrays(4), other(4);
  dvdx_state start = arrays.c();
  REQUIRE(h.make(options_of(0.01, DVDX_FLOAT64), &start) == DVDX_DONE);
  const dvdx_scalars stiffness{.all = 30, .each = nullptr, .count = 0};
  CHECK(dvdx_plan_set_springs_stiffness(h.plan, 0, &stiffness, 0.1, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_set_mass(h.plan, 1, 2, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_fix(h.plan, 0, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_fix(h.plan, 3, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_release(h.plan, 3, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_break_spring(h.plan, 0, 2, 1, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_replace_contact(h.plan, 0, h.scene, 0, &h.error) == DVDX_DONE);
  dvdx_state a = arrays.c();
  CHECK(dvdx_plan_step(h.plan, &a, 5, nullptr, &h.error) == DVDX_DONE);

  dvdx::Scene scene;
  scene.mass = std::vector<double>{1, 2, 1, 1};
  scene.fixed = {0};
  scene.add(dvdx::Springs{.pairs = {{0, 1}, {1, 2}, {2, 3}}, .stiffness = 30.0, .damping = 0.1, .broken = {{1, 2}}});
  scene.add(dvdx::Plane{.offset = -5, .restitution = 0.5});
  dvdx::State<double> b = other.cpp();
  const auto plan = dvdx::compile<double>(scene, {.step = 0.01}, b);
  REQUIRE(plan.has_value());
  REQUIRE(plan->step(b, 5) == dvdx::StepResult::done);
  CHECK(arrays.memory == other.memory);

  CHECK(dvdx_plan_set_grid_stiffness(h.plan, 0, 1, 1, 1, 0, &h.error) == DVDX_INVALID);
  CHECK(std::string(&h.error.field[0]) == "networks[0]");
  CHECK(dvdx_plan_break_spring(h.plan, 0, 2, 1, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_tear(h.plan, 0, 1e9, &a, nullptr, &h.error) == DVDX_DONE);
  std::size_t torn = 9;
  for (std::size_t i = 0; i < 4; ++i) arrays.column(0)[i] = 0.01 * static_cast<double>(i);
  arrays.column(0)[3] += 9;
  CHECK(dvdx_plan_tear(h.plan, 0, 1.5, &a, &torn, &h.error) == DVDX_DONE);
  CHECK(torn == 1);
  CHECK(dvdx_plan_tear(h.plan, 0, 1.5, &a, nullptr, &h.error) == DVDX_DONE);
  CHECK(dvdx_plan_tear(h.plan, 0, 1, &a, &torn, &h.error) == DVDX_INVALID);
  CHECK(std::string(&h.error.field[0]) == "stretch");
  CHECK(dvdx_plan_tear(h.plan, 0, 1.5, nullptr, &torn, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_tear(nullptr, 0, 1.5, &a, &torn, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_mass(h.plan, 4, 1, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_replace_contact(h.plan, 1, h.scene, 0, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_replace_contact(h.plan, 0, h.scene, 1, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_springs_stiffness(h.plan, 0, nullptr, 0, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_release(nullptr, 0, &h.error) == DVDX_INVALID);
}

TEST_CASE("c: how a mesh bends is changed while it runs, as in C++") {
  const std::vector<double> flat{0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.5, -1, 0};
  const std::vector<std::uint32_t> triangles{0, 1, 2, 1, 0, 3};
  const std::vector<std::uint32_t> pairs{0, 1};
  const auto bending_of = [&](double modulus) {
    dvdx_bending bending{};
    bending.modulus = modulus;
    bending.triangles = triangles.data();
    bending.triangle_count = 2;
    bending.flat = flat.data();
    bending.count = 4;
    return bending;
  };
  dvdx_springs springs{};
  springs.pairs = pairs.data();
  springs.count = 1;
  std::vector<std::vector<double>> ends;
  for (const double modulus : {0.0, 0.02}) {  // changed later, or given from the start
    Handles h;
    CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_DONE);
    const dvdx_bending first = bending_of(modulus);
    CHECK(dvdx_scene_add_bending(h.scene, &first, &h.error) == DVDX_DONE);
    Arrays<double> arrays(4);
    dvdx_state state = arrays.c();
    REQUIRE(h.make(options_of(0.01, DVDX_FLOAT64), &state) == DVDX_DONE);
    dvdx_bending bending = bending_of(0.02);
    if (modulus == 0) CHECK(dvdx_plan_set_bending(h.plan, &bending, &h.error) == DVDX_DONE);
    arrays.column(2)[2] = arrays.column(2)[3] = 0.1;
    CHECK(dvdx_plan_step(h.plan, &state, 9, nullptr, &h.error) == DVDX_DONE);
    ends.push_back(arrays.memory);

    bending.network = 1;
    CHECK(dvdx_plan_set_bending(h.plan, &bending, &h.error) == DVDX_INVALID);
    CHECK(h.message() == "networks[1] is not there: must be an index below 1");
    bending = bending_of(-1);
    CHECK(dvdx_plan_set_bending(h.plan, &bending, &h.error) == DVDX_INVALID);
    CHECK(h.field() == "bending.modulus");
    bending = bending_of(1);
    bending.count = 3;
    CHECK(dvdx_plan_set_bending(h.plan, &bending, &h.error) == DVDX_INVALID);
    CHECK(h.field() == "bending.triangles[1]");
    bending.flat = nullptr;
    CHECK(dvdx_plan_set_bending(h.plan, &bending, &h.error) == DVDX_INVALID);
    CHECK(dvdx_plan_set_bending(h.plan, nullptr, &h.error) == DVDX_INVALID);
    CHECK(dvdx_plan_set_bending(nullptr, &first, &h.error) == DVDX_INVALID);
  }
  CHECK(ends[0] == ends[1]);
  CHECK(std::abs(ends[0][20]) > 1e-6);  // it has moved
}

}  // namespace c_handles::plan_test
