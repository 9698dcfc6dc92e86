// The functions of dvdx.h: what they step, what they refuse and in which words, and whose memory they use.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"

namespace c_api_test {

struct Handles {  // a scene, a plan, and what was last said
  dvdx_scene* scene = nullptr;
  dvdx_plan* plan = nullptr;
  dvdx_error error{};

  Handles() { REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) == DVDX_DONE); }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    dvdx_plan_destroy(plan);
    dvdx_scene_destroy(scene);
  }
  [[nodiscard]] std::string field() const { return &error.field[0]; }
  [[nodiscard]] std::string message() const { return &error.message[0]; }
  dvdx_status make(const dvdx_options& options, const dvdx_state* start = nullptr) {
    return dvdx_plan_create(scene, &options, start, &plan, &error);
  }
};

dvdx_options options_of(double step, dvdx_precision precision = DVDX_FLOAT32) {
  dvdx_options options{};
  options.step = step;
  options.precision = precision;
  return options;
}

// Six arrays, started alike each time.
template <class T>
struct Arrays {
  std::vector<T> memory;
  std::size_t count;

  explicit Arrays(std::size_t n) : memory(6 * n), count(n) {
    for (std::size_t i = 0; i < n; ++i) {
      memory[i] = static_cast<T>(0.01 * static_cast<double>(i));
      memory[n + i] = 1;
      memory[3 * n + i] = static_cast<T>(0.5);
    }
  }
  T* column(std::size_t k) { return memory.data() + k * count; }
  dvdx_state c() {
    return dvdx_soa(sizeof(T) == 4 ? DVDX_FLOAT32 : DVDX_FLOAT64, column(0), column(1), column(2), column(3), column(4),
                    column(5), count);
  }
  dvdx::State<T> cpp() { return dvdx::soa(column(0), column(1), column(2), column(3), column(4), column(5), count); }
};

// Every force and contact, by C and by C++.
void add_forces(Handles& h) {
  dvdx_constant gravity{};
  gravity.acceleration[1] = -9.81;
  dvdx_sinusoid shake{};
  shake.acceleration[0] = 1;
  shake.angular_frequency = 3;
  shake.phase = 0.5;
  const double terms[] = {0.1, 0, 0, 0, 0, 0.2};
  const dvdx_polynomial push{terms, 2, DVDX_METHOD_DEFAULT};
  const double axes[] = {10, 20, 30};
  dvdx_spring spring{};
  spring.stiffness.axes = &axes[0];
  spring.damping = 0.3;
  spring.anchor.from = DVDX_ANCHOR_AT_START;
  dvdx_radial_spring radial{};
  radial.stiffness.all = 5;
  radial.rest_length.all = 0.5;
  dvdx_drag drag{};
  drag.coefficient.all = 0.02;
  drag.wind[0] = 3;
  drag.method = DVDX_EXACT;
  dvdx_plane plane{};
  plane.normal[1] = 1;
  plane.surface.restitution = 0.4;
  dvdx_sphere sphere{};
  sphere.radius = 50;
  sphere.side = DVDX_INSIDE;
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_polynomial(h.scene, &push, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_sinusoid(h.scene, &shake, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_spring(h.scene, &spring, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_radial_spring(h.scene, &radial, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_drag(h.scene, &drag, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_plane(h.scene, &plane, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_sphere(h.scene, &sphere, &h.error) == DVDX_DONE);
  dvdx_capsule capsule{};
  capsule.ends[0][0] = 4;
  capsule.ends[1][1] = 2;
  capsule.radius[0] = 0.5;
  capsule.radius[1] = 0.25;
  capsule.surface.thickness = 0.125;
  capsule.surface.push_out = 0.75;
  dvdx_box box{};
  box.center[1] = -3;
  for (double& half : box.half_extents) half = 2;
  box.rotation[2] = 0.5;
  const double planes[] = {1, 0, 0, 9, -1, 0, 0, -8, 0, 1, 0, 1, 0, -1, 0, 0, 0, 0, 1, 1, 0, 0, -1, 0};
  dvdx_convex convex{};
  convex.planes = planes;
  convex.count = 6;
  CHECK(dvdx_scene_add_capsule(h.scene, &capsule, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_box(h.scene, &box, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_convex(h.scene, &convex, &h.error) == DVDX_DONE);
  const double corners[] = {-6, 0, 0, -5, 0, 0, -6, 1, 0, -6, 0, 1};
  const std::uint32_t triangles[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  dvdx_mesh mesh{};
  mesh.vertices = corners;
  mesh.count = 4;
  mesh.triangles = triangles;
  mesh.triangle_count = 4;
  mesh.cell = 0.125;
  mesh.surface.restitution = 0.5;
  CHECK(dvdx_scene_add_mesh(h.scene, &mesh, &h.error) == DVDX_DONE);
}

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

// A hanging row of springs, and what holds some of its particles.
void add_joints(Handles& h) {
  const std::uint32_t pairs[] = {0, 1, 1, 2, 2, 3};
  dvdx_springs springs{};
  springs.pairs = &pairs[0];
  springs.count = 3;
  springs.stiffness.all = 100;
  springs.damping = 0.1;
  dvdx_distance rod{};
  rod.pairs = &pairs[0];
  rod.count = 1;
  const dvdx_on_point point{4, {0.04, 1, 0}};
  const dvdx_on_line line{5, {0, 1, 0}, {1, 0, 0}};
  dvdx_coupling coupling{};
  coupling.substeps = 10;
  const std::size_t fixed[] = {3};
  CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_distance(h.scene, &rod, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_on_point(h.scene, &point, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_on_line(h.scene, &line, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_coupling(h.scene, &coupling, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_fixed(h.scene, &fixed[0], 1, &h.error) == DVDX_DONE);
}

dvdx::Scene scene_of_joints() {
  using namespace dvdx;
  Scene scene;
  scene.add(Network(Springs{.pairs = {{0, 1}, {1, 2}, {2, 3}}, .stiffness = 100.0, .damping = 0.1}));
  scene.add(Constraint(Distance{.pairs = {{0, 1}}})).add(Constraint(OnPoint{.particle = 4, .at = {0.04, 1, 0}}));
  scene.add(Constraint(OnLine{.particle = 5, .through = {0, 1, 0}}));
  scene.coupling.substeps = 10;
  scene.fixed = {3};
  return scene;
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

TEST_CASE("c: the longest sub-step that sequential chose is told, and a scene that names it has it") {
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

TEST_CASE("c: a grid, values each and an origin") {
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

TEST_CASE("c: the fewest sub-steps of a sheet that hangs free, and those safe in any position, are told apart") {
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

TEST_CASE("c: the instruction set that was asked for is told, and impacts are counted as asked") {
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

TEST_CASE("c: seek, another step, another force, and what a plan says of itself") {
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
  for (const double modulus : {0.0, 0.02}) {  // changed, or from the first
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

TEST_CASE("c: an error names the field, the value and the range, and changes nothing") {
  Handles h;
  dvdx_spring spring{};
  spring.stiffness.all = -40;
  CHECK(dvdx_scene_add_spring(h.scene, &spring, &h.error) == DVDX_DONE);
  CHECK(h.make(options_of(0.01)) == DVDX_INVALID);
  CHECK(h.plan == nullptr);
  CHECK(h.message() == "forces[0].stiffness is -40: must be a finite number >= 0");
  CHECK(h.field() == "forces[0].stiffness");
  CHECK(std::string(&h.error.value[0]) == "-40");
  CHECK(std::string(&h.error.valid[0]) == "a finite number >= 0");
  CHECK(dvdx_plan_create(h.scene, nullptr, nullptr, &h.plan, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "options");
  CHECK(h.make(options_of(0.01), nullptr) == DVDX_INVALID);
  dvdx_options options = options_of(0.01);
  options.isa = static_cast<dvdx_isa>(7);
  CHECK(h.make(options) == DVDX_INVALID);
  CHECK(h.field() == "isa");
}

TEST_CASE("c: choices that do not exist and pointers to nothing are refused at once") {
  Handles h;
  dvdx_drag drag{};
  drag.method = static_cast<dvdx_method>(7);
  CHECK(dvdx_scene_add_drag(h.scene, &drag, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "forces[0].method is 7: must be a choice from 0 to 5");
  CHECK(dvdx_scene_add_drag(h.scene, nullptr, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "forces");
  CHECK(dvdx_scene_add_drag(nullptr, &drag, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "scene");
  dvdx_springs springs{};
  springs.count = 2;
  CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "networks[0].pairs");
  CHECK(dvdx_scene_set_fixed(h.scene, nullptr, 2, &h.error) == DVDX_INVALID);
  CHECK(dvdx_scene_set_mass(h.scene, nullptr, nullptr) == DVDX_INVALID);  // an error that nobody asks for
  dvdx_scene* other = nullptr;
  CHECK(dvdx_scene_create(DVDX_ABI_VERSION + 1, &other, &h.error) == DVDX_ABI_DIFFERS);
  CHECK(other == nullptr);
  CHECK(h.message() == dvdx_status_text(DVDX_ABI_DIFFERS));
}

TEST_CASE("c: a state that does not fit is refused, and not stepped") {
  Handles h;
  REQUIRE(h.make(options_of(0.01)) == DVDX_DONE);
  Arrays<float> arrays(4);
  const auto before = arrays.memory;
  const auto step = [&](dvdx_state state) { return dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error); };
  dvdx_state state = arrays.c();
  state.precision = DVDX_FLOAT64;
  CHECK(step(state) == DVDX_PRECISION_DIFFERS);
  state = arrays.c();
  state.v[2].base = nullptr;
  CHECK(step(state) == DVDX_INVALID);
  CHECK(h.field() == "v[2]");
  state = arrays.c();
  state.x[0].base = reinterpret_cast<char*>(arrays.column(0)) + 1;
  CHECK(step(state) == DVDX_INVALID);
  state = arrays.c();
  state.x[1].run = 3;
  CHECK(step(state) == DVDX_INVALID);
  state = arrays.c();
  state.x[1].run = 1;
  state.x[1].stride = 3;
  CHECK(step(state) == DVDX_INVALID);
  state = arrays.c();
  state.x[1].capacity = 3;
  CHECK(step(state) == DVDX_CAPACITY_TOO_SMALL);
  for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    state = arrays.c();
    state.clock.seconds = wrong;
    const std::string words = std::isnan(wrong) ? "nan" : wrong > 0 ? "inf" : "-inf";
    CHECK(step(state) == DVDX_INVALID);
    CHECK(h.message() == "state.clock is " + words + ": must be a finite time");
    CHECK(dvdx_plan_seek(h.plan, &state, 1, &h.error) == DVDX_INVALID);
    CHECK(h.message() == "state.clock is " + words + ": must be a finite time");
    state.clock = {0, wrong};
    CHECK(step(state) == DVDX_INVALID);
    CHECK(h.message() == "state.clock is " + words + ": must be a finite time");
  }
  CHECK(dvdx_plan_step(nullptr, &state, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_step(h.plan, nullptr, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_step(h.plan, HUGE_VAL, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_replace(h.plan, 0, h.scene, 0, &h.error) == DVDX_INVALID);
  CHECK(arrays.memory == before);
}

TEST_CASE("c: structs of the caller's and the caller's threads") {
  struct Particle {
    char name;
    double position[3];
    float age;
    double velocity[3];
  };
  std::vector<Particle> particles(100'000, Particle{'p', {1, 2, 3}, 4, {0, 0, 0}});
  Handles h;
  dvdx_constant gravity{};
  gravity.acceleration[1] = -10;
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  REQUIRE(h.make(options_of(0.5, DVDX_FLOAT64)) == DVDX_DONE);
  dvdx_state state =
      dvdx_aos(DVDX_FLOAT64, &particles[0].position[0], &particles[0].velocity[0], sizeof(Particle), particles.size());
  std::size_t calls = 0;
  dvdx_parallel backwards{};
  backwards.context = &calls;
  backwards.run = [](void* context, std::size_t count, dvdx_body body, void* task) {
    ++*static_cast<std::size_t*>(context);
    for (std::size_t i = count; i-- > 0;) body(task, i);
  };
  CHECK(dvdx_plan_step(h.plan, &state, 2, &backwards, &h.error) == DVDX_DONE);
  CHECK(calls == 1);
  const bool is_right = std::all_of(particles.begin(), particles.end(), [](const Particle& p) {
    return p.name == 'p' && p.age == 4 && p.position[1] == -3 && p.velocity[1] == -10;
  });
  CHECK(is_right);
}

// Gives memory out until it is told to stop, and counts what is out.
struct Heap {
  long left;
  long out = 0, most = 0;
  static void* allocate(void* context, std::size_t bytes, std::size_t alignment) {
    auto& heap = *static_cast<Heap*>(context);
    if (heap.left-- <= 0) return nullptr;
    heap.most = std::max(heap.most, ++heap.out);
    return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  }
  static void release(void* context, void* memory, std::size_t /*bytes*/, std::size_t /*alignment*/) {
    --static_cast<Heap*>(context)->out;
    std::free(memory);
  }
};

// A live plan by C, with memory for its particles: structs with an age, and a name that goes along with each.
class Living {
 public:
  static constexpr std::size_t capacity = 3000;
  struct Drop {
    double position[3], velocity[3], age, lifetime;
    std::uint32_t name;
  };

  explicit Living(Handles& handles) : h(handles), drops(capacity) {
    live.state = dvdx_aos(DVDX_FLOAT64, &drops[0].position[0], &drops[0].velocity[0], sizeof(Drop), capacity);
    live.state.count = 0;
    live.age = {&drops[0].age, sizeof(Drop), 1, capacity};
    live.lifetime = {&drops[0].lifetime, sizeof(Drop), 1, capacity};
    live.carried = &carried;
    live.carried_count = 1;
    emitters[0].shape = DVDX_EMIT_DISC;
    emitters[0].normal[1] = emitters[0].radius = emitters[0].at[1] = 1;
    emitters[0].rate = 2000;
    emitters[0].velocity[1] = 3;
    emitters[0].spread = 0.5;
    emitters[0].least_lifetime = 0.2;
    emitters[0].most_lifetime = 0.6;
    emitters[0].seed = 7;
    emitters[1].shape = DVDX_EMIT_BOX;
    emitters[1].most[0] = emitters[1].most[1] = 2;
    emitters[1].rate = 500;
    emitters[1].start = 0.1;
    emitters[1].duration = 0.25;
    emitters[1].spread_box = &sides[0];
    turnover.emitters = &emitters[0];
    turnover.emitter_count = 2;
    turnover.boundaries = &ground;
    turnover.boundary_count = 1;
    turnover.inside = &inside[0];
    turnover.capacity = capacity;
  }
  Living(const Living&) = delete;
  Living& operator=(const Living&) = delete;
  ~Living() { dvdx_live_plan_destroy(plan); }

  dvdx_status make() {
    const dvdx_options options = options_of(1.0 / 64, DVDX_FLOAT64);
    return dvdx_live_plan_create(h.scene, &turnover, &options, &plan, &h.error);
  }
  dvdx_status step(std::size_t steps) { return dvdx_live_plan_step(plan, &live, steps, nullptr, &h.error); }

  Handles& h;
  std::vector<Drop> drops;
  dvdx_carried carried{&drops[0].name, sizeof(Drop), sizeof(std::uint32_t)};
  dvdx_emitter emitters[2]{};
  dvdx_boundary ground{{0, 2, 0}, -0.5};
  double sides[3] = {1, 0, 1}, inside[6] = {-9, -9, -9, 1.75, 9, 0.8};
  dvdx_turnover turnover{};
  dvdx_live live{};
  dvdx_live_plan* plan = nullptr;
};

void check_live(dvdx::SurvivorOrder order) {
  using namespace dvdx;
  Handles h;
  dvdx_constant gravity{};
  gravity.acceleration[1] = -9.81;
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  Living by_c(h);
  by_c.turnover.order = static_cast<dvdx_survivor_order>(order);
  REQUIRE_MESSAGE(by_c.make() == DVDX_DONE, h.message());
  for (int call = 0; call < 5; ++call) REQUIRE(by_c.step(10) == DVDX_DONE);

  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const Lifecycle turnover{.emitters = {{.shape = Disc{.center = {0, 1, 0}, .normal = {0, 1, 0}, .radius = 1},
                                         .rate = 2000,
                                         .velocity = {0, 3, 0},
                                         .spread = 0.5,
                                         .least_lifetime = 0.2,
                                         .most_lifetime = 0.6,
                                         .seed = 7},
                                        {.shape = Box{.min = {0, 0, 0}, .max = {2, 2, 0}},
                                         .rate = 500,
                                         .start = 0.1,
                                         .end = 0.1 + 0.25,
                                         .spread = Vec3{1, 0, 1}}},
                           .removal = {.boundaries = {{.normal = {0, 2, 0}, .offset = -0.5}},
                                       .outside = Box{.min = {-9, -9, -9}, .max = {1.75, 9, 0.8}},
                                       .order = order},
                           .capacity = Living::capacity};
  const auto plan = compile<double>(scene, turnover, {.step = 1.0 / 64});
  REQUIRE(plan.has_value());
  Soa<double> memory(Living::capacity), lives(Living::capacity);
  LiveState<double> live{.state = memory.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
  live.state.count = 0;
  REQUIRE(plan->step(live, 50) == StepResult::done);

  CHECK(by_c.live.state.count == live.state.count);
  CHECK(by_c.live.born == live.born);
  CHECK(by_c.live.removed == live.removed);
  CHECK(by_c.live.state.clock.seconds == live.state.clock.seconds);
  CHECK(live.removed > 300);
  CHECK(live.state.count > 300);
  CHECK(dvdx_state_hash(&by_c.live.state) == state_hash(live.state));
  CHECK(by_c.drops[0].age == live.age[0]);
  const std::size_t length = dvdx_live_plan_explain(by_c.plan, nullptr, 0);
  std::string text(length + 1, '?');
  CHECK(dvdx_live_plan_explain(by_c.plan, text.data(), text.size()) == length);
  CHECK(text.find("at most 3000 particles live at once; 2 emitters") != std::string::npos);
}

TEST_CASE("c: particles come and go as they do by C++, bit by bit, in their order and in any") {
  check_live(dvdx::SurvivorOrder::kept);
  check_live(dvdx::SurvivorOrder::any);
}

TEST_CASE("c: a column of the caller's goes along, and what the caller marks is removed") {
  Handles h;
  Living living(h);
  living.turnover.emitter_count = living.turnover.boundary_count = 0;
  living.turnover.inside = nullptr;
  REQUIRE(living.make() == DVDX_DONE);
  living.live.state.count = 5;
  for (std::uint32_t i = 0; i < 5; ++i) living.drops[i] = {{0, 0, 0}, {0, 0, 0}, i == 2 ? HUGE_VAL : 0, HUGE_VAL, i};
  CHECK(dvdx_live_plan_remove(living.plan, &living.live, nullptr, &h.error) == DVDX_DONE);
  CHECK(living.live.state.count == 4);
  CHECK(living.live.removed == 1);
  CHECK(living.drops[2].name == 3);
  CHECK(living.drops[3].name == 4);
  const double away[] = {10, 0, 0};
  const double half_turn[] = {0, 3.14159265358979323846, 0};
  living.drops[0].velocity[0] = 2;
  CHECK(dvdx_live_plan_teleport(living.plan, &living.live, &away[0], &half_turn[0], &h.error) == DVDX_DONE);
  CHECK(living.drops[0].position[0] == doctest::Approx(10));
  CHECK(living.drops[0].velocity[0] == doctest::Approx(-2));
  CHECK(dvdx_live_plan_teleport(living.plan, &living.live, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_teleport(living.plan, nullptr, &away[0], nullptr, &h.error) == DVDX_INVALID);
}

TEST_CASE("c: balls that come and go meet, and a call that ends too early tells how far it came") {
  Handles h;
  const double size = 0.04;
  const dvdx_scalars radius{size, nullptr, 0};
  dvdx_meet meet{};
  meet.radius = &radius;
  meet.most_neighbours = 2;
  REQUIRE(dvdx_scene_set_meet(h.scene, &meet, &h.error) == DVDX_DONE);
  Living by_c(h);
  by_c.turnover.order = DVDX_SURVIVOR_ORDER_ANY;
  CHECK(by_c.make() == DVDX_INVALID);
  CHECK(h.message() == "removal.order is any: must be kept where particles meet");
  by_c.turnover.order = DVDX_SURVIVOR_ORDER_KEPT;
  REQUIRE_MESSAGE(by_c.make() == DVDX_DONE, h.message());
  REQUIRE(by_c.step(50) == DVDX_TOO_MANY_NEIGHBOURS);
  const std::size_t count = by_c.live.state.count;
  CHECK(count > 30);
  CHECK(by_c.live.born >= count);
  const double time = by_c.live.state.clock.seconds;
  CHECK(time > 0);
  CHECK(by_c.step(50) == DVDX_TOO_MANY_NEIGHBOURS);
  CHECK(by_c.live.state.count == count);
  CHECK(by_c.live.state.clock.seconds == time);
}

TEST_CASE("c: a body and a nozzle on a motion are driven in a live plan and in workspaces as by C++") {
  using namespace dvdx;
  Handles h;
  const dvdx_motion rests{};
  REQUIRE(dvdx_scene_add_motion(h.scene, &rests, &h.error) == DVDX_DONE);
  dvdx_sphere ball{};
  ball.center[1] = 1;
  ball.radius = 0.5;
  REQUIRE(dvdx_scene_add_sphere(h.scene, &ball, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_scene_set_contact_motion(h.scene, 0, 0, &h.error) == DVDX_DONE);
  Living one(h), two(h);
  one.turnover.emitter_count = two.turnover.emitter_count = 1;
  one.turnover.inside = two.turnover.inside = nullptr;
  one.emitters[0].follows = two.emitters[0].follows = 1;
  REQUIRE_MESSAGE(one.make() == DVDX_DONE, h.message());
  REQUIRE(two.make() == DVDX_DONE);
  dvdx_live_workspace* workspace = nullptr;
  REQUIRE(dvdx_live_workspace_create(two.plan, &workspace, &h.error) == DVDX_DONE);
  CHECK(dvdx_live_workspace_bytes(workspace) > 0);

  Scene scene;
  scene.add(Motion{}).add(Sphere{.center = {0, 1, 0}, .radius = 0.5, .motion = 0});
  const Emitter nozzle{.shape = Disc{.center = {0, 1, 0}, .normal = {0, 1, 0}, .radius = 1},
                       .rate = 2000,
                       .velocity = {0, 3, 0},
                       .spread = 0.5,
                       .least_lifetime = 0.2,
                       .most_lifetime = 0.6,
                       .seed = 7,
                       .motion = 0};
  const Lifecycle turnover{
      .emitters = {nozzle}, .removal = {.boundaries = {{.normal = {0, 2, 0}, .offset = -0.5}}}, .capacity = Living::capacity};
  auto plan = compile<double>(scene, turnover, {.step = 1.0 / 64});
  REQUIRE(plan.has_value());
  Soa<double> memory(Living::capacity), lives(Living::capacity);
  LiveState<double> live{.state = memory.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
  live.state.count = 0;
  for (int n = 1; n <= 30; ++n) {
    const std::array<double, 3> at{0.05 * n, 0, 0}, turn{0, 0, 0.02 * n};
    const auto set_plan = n == 20 ? dvdx_live_plan_jump_pose : dvdx_live_plan_set_pose;
    const auto set_own = n == 20 ? dvdx_live_workspace_jump_pose : dvdx_live_workspace_set_pose;
    REQUIRE(set_plan(one.plan, 0, at.data(), turn.data(), &h.error) == DVDX_DONE);
    REQUIRE(set_own(workspace, 0, at.data(), turn.data(), &h.error) == DVDX_DONE);
    const Arrival arrival = n == 20 ? Arrival::jump : Arrival::moving;
    REQUIRE(plan->set_pose(0, {.translation = at, .rotation = turn}, arrival).has_value());
    REQUIRE(one.step(1) == DVDX_DONE);
    REQUIRE(dvdx_live_plan_step_in(two.plan, workspace, &two.live, 1, nullptr, nullptr, &h.error) == DVDX_DONE);
    REQUIRE(plan->step(live) == StepResult::done);
  }
  REQUIRE(dvdx_live_plan_burst_in(two.plan, workspace, &two.live, 0, 9, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_burst(one.plan, &one.live, 0, 9, &h.error) == DVDX_DONE);
  REQUIRE(plan->burst(live, 0, 9).has_value());
  const std::array<double, 3> away{4, 0, 1};
  REQUIRE(dvdx_live_plan_teleport_in(two.plan, workspace, &two.live, away.data(), nullptr, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_teleport(one.plan, &one.live, away.data(), nullptr, &h.error) == DVDX_DONE);
  REQUIRE(plan->teleport(live, {.translation = away}).has_value());
  REQUIRE(one.step(5) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_step_in(two.plan, workspace, &two.live, 5, nullptr, nullptr, &h.error) == DVDX_DONE);
  REQUIRE(plan->step(live, 5) == StepResult::done);
  CHECK(live.state.count > 300);
  CHECK(dvdx_state_hash(&one.live.state) == state_hash(live.state));
  CHECK(dvdx_state_hash(&two.live.state) == state_hash(live.state));
  dvdx_state_check check{};
  REQUIRE(dvdx_live_plan_check(one.plan, &one.live, &check, &h.error) == DVDX_DONE);
  CHECK(check.kinetic == plan->check(live).kinetic);
  CHECK(dvdx_live_plan_step_size(one.plan) == 1.0 / 64);

  REQUIRE(dvdx_live_plan_set_pose(two.plan, 0, away.data(), nullptr, &h.error) == DVDX_DONE);
  dvdx_live_workspace* late = nullptr;
  REQUIRE(dvdx_live_workspace_create(two.plan, &late, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_set_pose(two.plan, 0, away.data(), nullptr, &h.error) == DVDX_DONE);
  CHECK(dvdx_live_plan_step_in(two.plan, late, &two.live, 1, nullptr, nullptr, &h.error) == DVDX_DRIVEN_ELSEWHERE);
  CHECK(dvdx_live_plan_set_pose(one.plan, 1, away.data(), nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "motions[1]");
  CHECK(dvdx_live_plan_set_pose(one.plan, 0, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_workspace_set_pose(nullptr, 0, away.data(), nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_step_in(one.plan, nullptr, &one.live, 1, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_burst_in(one.plan, nullptr, &one.live, 0, 1, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_teleport_in(one.plan, workspace, &one.live, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_check(one.plan, nullptr, &check, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_set_wind(one.plan, nullptr, &h.error) == DVDX_INVALID);
  const dvdx_wind air{{1, 0, 0}, nullptr, 0};
  CHECK(dvdx_live_plan_set_wind(one.plan, &air, &h.error) == DVDX_DONE);
  CHECK(std::isnan(dvdx_live_plan_step_size(nullptr)));
  CHECK(dvdx_live_workspace_bytes(nullptr) == 0);
  dvdx_live_workspace_destroy(workspace);
  dvdx_live_workspace_destroy(late);
  CHECK(dvdx_live_workspace_create(nullptr, &late, &h.error) == DVDX_INVALID);
  CHECK(late == nullptr);
}

TEST_CASE("c: what cannot come and go is refused, and nothing is stepped") {
  Handles h;
  Living living(h);
  living.emitters[0].rate = -1;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.message() == "emitters[0].rate is -1: must be a finite number >= 0");
  CHECK(living.plan == nullptr);
  living.emitters[0].rate = 2000;
  living.emitters[1].duration = -1;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "emitters[1].duration");
  living.emitters[1].duration = 0;
  living.emitters[1].shape = static_cast<dvdx_emit>(3);
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "emitters[1].shape");
  living.emitters[1].shape = DVDX_EMIT_POINT;
  living.turnover.emitters = nullptr;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "emitters");
  living.turnover.emitters = &living.emitters[0];
  living.turnover.capacity = 0;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "capacity");
  living.turnover.capacity = Living::capacity;
  REQUIRE(living.make() == DVDX_DONE);

  const dvdx_live good = living.live;
  const auto step = [&](dvdx_live live) { return dvdx_live_plan_step(living.plan, &live, 1, nullptr, &h.error); };
  dvdx_live live = good;
  live.state.x[1].base = nullptr;  // although there is no particle yet
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.field() == "x[1]");
  live = good;
  live.age.base = nullptr;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.field() == "age");
  live = good;
  live.lifetime.capacity = Living::capacity - 1;
  CHECK(step(live) == DVDX_CAPACITY_TOO_SMALL);
  live = good;
  live.state.clock.seconds = HUGE_VAL;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.message() == "state.clock is inf: must be a finite time");
  live = good;
  live.carried = nullptr;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.field() == "carried");
  live = good;
  live.carried_count = 33;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.message() == "carried_count is 33: must be at most 32");
  live = good;
  live.state.precision = DVDX_FLOAT32;
  CHECK(step(live) == DVDX_PRECISION_DIFFERS);
  CHECK(dvdx_live_plan_step(nullptr, &live, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_remove(living.plan, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(living.live.born == 0);
}

TEST_CASE("c: digits that float32 cannot hold are kept in the rests, and rests without memory are refused") {
  Handles h;
  const double origin[] = {10'000, 0, 0};
  CHECK(dvdx_scene_set_origin(h.scene, &origin[0], 1, &h.error) == DVDX_DONE);
  dvdx_options options = options_of(1e-3);
  options.rounding = DVDX_COMPENSATED;
  REQUIRE(h.make(options) == DVDX_DONE);
  Arrays<float> arrays(4), rests(4);
  std::fill(rests.memory.begin(), rests.memory.end(), 0.0F);
  dvdx_state state = arrays.c();
  CHECK(dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error) == DVDX_CAPACITY_TOO_SMALL);
  const dvdx_state of_rests = rests.c();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x_rest[axis] = of_rests.x[axis];
    state.v_rest[axis] = of_rests.v[axis];
  }
  state.v_rest[1].base = nullptr;
  CHECK(dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "v_rest[1]");
  state.v_rest[1] = of_rests.v[1];
  CHECK(dvdx_plan_step(h.plan, &state, 1'000'000, nullptr, &h.error) == DVDX_DONE);
  // x + v t over 1000 s: 0.01 i + 500.
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = static_cast<double>(arrays.column(0)[i]) + static_cast<double>(rests.column(0)[i]);
    CHECK(std::abs(x - (static_cast<double>(static_cast<float>(0.01 * static_cast<double>(i))) + 500)) < 1e-7);
  }
}

TEST_CASE("c: wherever the allocator has no memory left, making a plan fails and leaks nothing") {
  Handles h;
  add_forces(h);
  add_joints(h);
  Arrays<float> arrays(6);
  const dvdx_state state = arrays.c();
  for (long given = 0;; ++given) {
    REQUIRE(given < 1000);
    Heap heap{given};
    dvdx_options options = options_of(1.0 / 60);
    options.allocator = {Heap::allocate, Heap::release, &heap};
    const dvdx_status status = h.make(options, &state);
    if (status == DVDX_DONE) {
      CHECK(given > 5);
      CHECK(heap.out == given);
      // Nor does a change that fails for want of memory: the plan steps on as it was.
      heap.left = 0;
      CHECK(dvdx_plan_set_step(h.plan, 0.01, &h.error) == DVDX_OUT_OF_MEMORY);
      CHECK(dvdx_plan_replace(h.plan, 0, h.scene, 0, &h.error) == DVDX_OUT_OF_MEMORY);
      CHECK(heap.out == given);
      dvdx_state moving = arrays.c();
      CHECK(dvdx_plan_step(h.plan, &moving, 1, nullptr, &h.error) == DVDX_DONE);
      dvdx_plan_destroy(h.plan);
      h.plan = nullptr;
      CHECK(heap.out == 0);
      return;
    }
    CHECK(status == DVDX_OUT_OF_MEMORY);
    CHECK(h.plan == nullptr);
    CHECK(heap.out == 0);
  }
}

TEST_CASE("C: a report tells what contacts do, in the caller's room") {
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
  float x[18] = {0, 1, 0, 1, 5, 0, 0, 0, 1, 1, 5, 0, 0, 0, 0, 0, 5, 0};  // four corners of a cell, and one apart
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

TEST_CASE("c: air on a grid and on triangles, and a wind that changes") {
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

TEST_CASE("c: cloth meets by a part of its cells") {
  Handles h;
  dvdx_meet meet{};
  meet.part_of_cells = 1.5;
  CHECK(dvdx_scene_set_meet(h.scene, &meet, &h.error) == DVDX_DONE);
  Arrays<double> particles(3);
  dvdx_state state = particles.c();
  CHECK(h.make(options_of(0.125, DVDX_FLOAT64), &state) == DVDX_INVALID);
  CHECK(h.message() == "meet.part_of_cells is 1.5: must be a number > 0 and < 1");
}

TEST_CASE("c: balls meet as C++ has them, and groups say which") {
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
  for (Arrays<double>* by : {&by_c, &by_cpp}) {  // the first meets the second, and goes through the third
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

}  // namespace c_api_test
