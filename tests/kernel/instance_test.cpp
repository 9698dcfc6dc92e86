// Instances: a state with its own data has the bits of a plan of its own. Each is carried, driven and stepped separately.
#include "dvdx/instance.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "dvdx/cloth.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/threads.hpp"

namespace instance_test {

using namespace dvdx;

constexpr std::size_t rows = 6, columns = 7, count = rows * columns;
constexpr double frame = 1.0 / 60;

struct Cape {
  Scene scene;
  PinsId pins{};
  MotionId arm{};
  SkinId skin{};
};

Cape cape(Scheme scheme = Scheme::leapfrog) {
  Cape c;
  c.scene.mass = 0.01;
  c.scene.coupling.scheme = scheme;
  c.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  c.scene.add(Network(Grid{.rows = rows,
                           .columns = columns,
                           .edge_u = {0.6, 0, 0},
                           .edge_v = {0, 0, 0.5},
                           .structural = 40,
                           .shear = 10,
                           .damping = 0.01,
                           .aerodynamics = Aerodynamics{}}));
  std::vector<std::size_t> top;
  for (std::size_t i = 0; i < columns; ++i) top.push_back(i);
  c.pins = add_pins(c.scene, top);
  c.arm = add_body(c.scene, Sphere{.center = {0.3, -0.3, 0.25}, .radius = 0.1, .friction = 0.3});
  c.skin = add_skin(c.scene, Skin{.particles = {count - 1}, .at_most = 0.3});
  return c;
}

template <class T>
void place(State<T>& state, double x = 0) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<double, 3> at{x + 0.1 * static_cast<double>(i % columns), 0, 0.1 * static_cast<double>(i / columns)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(at[axis]);
      state.v[axis][i] = 0;
    }
  }
}

template <class T>
Plan<T> plan_of(const Scene& scene) {
  Soa<T> memory(count);
  State<T> state = memory.view();
  place(state);
  auto plan = compile<T>(scene, {.step = frame}, state);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

std::vector<Vec3> pins_at(double time) {
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < columns; ++i)
    places.push_back({0.1 * static_cast<double>(i) + 0.2 * std::sin(5 * time), 0.1 * time, 0});
  return places;
}
Pose arm_at(double time) { return {.translation = {0, 0.2 * time, 0}, .rotation = {0, time, 0}}; }

const std::array<double, 6> frames{1.0 / 60, 1.0 / 45, 1.0 / 60, 1.0 / 90, 1.0 / 45, 1.0 / 33};

TEST_CASE_TEMPLATE("instance: driven by frames that vary it has the bits of a plan of its own", T, float, double) {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential}) {
    const Cape c = cape(scheme);
    const Plan<T> shared = plan_of<T>(c.scene);
    Plan<T> alone = plan_of<T>(c.scene);
    Soa<T> one(count), two(count);
    State<T> state = one.view(), other = two.view();
    place(state);
    place(other);
    auto instance = shared.instance(state);
    REQUIRE(instance.has_value());
    double time = 0;
    for (const double h : frames) {
      time += h;
      const std::vector<Vec3> places = pins_at(time);
      REQUIRE(instance->move(c.pins, places).has_value());
      REQUIRE(instance->move(c.arm, arm_at(time)).has_value());
      REQUIRE(instance->step(h).has_value());
      REQUIRE(alone.set_places(0, places).has_value());
      REQUIRE(alone.set_pose(static_cast<std::size_t>(c.arm), arm_at(time)).has_value());
      REQUIRE(alone.set_step(h).has_value());
      REQUIRE(alone.step(other) == StepResult::done);
      CHECK(state_hash(instance->state()) == state_hash(other));
    }
    CHECK(instance->state().clock.seconds == other.clock.seconds);
  }
}

TEST_CASE("instance: many share one plan on two threads, each with its own wind, pins and clock") {
  const Cape c = cape();
  const Plan<float> plan = plan_of<float>(c.scene);
  constexpr std::size_t many = 8;
  const auto run = [&](std::size_t threads) {
    std::vector<Soa<float>> memory;
    std::vector<Instance<float>> instances;
    for (std::size_t k = 0; k < many; ++k) {
      State<float> state = memory.emplace_back(count).view();
      place(state);
      auto made = plan.instance(state);
      REQUIRE(made.has_value());
      if (k % 2 == 1) REQUIRE(made->set_wind({.mean = {static_cast<double>(k), 0, 0}}).has_value());
      REQUIRE(made->teleport({.translation = {static_cast<double>(k), 0, 0}}).has_value());
      instances.push_back(std::move(*made));
    }
    const auto work = [&](std::size_t first) {
      for (const double h : frames) {
        for (std::size_t k = first; k < many; k += threads) {
          if (!instances[k].step(h).has_value()) return;
        }
      }
    };
    std::vector<std::thread> team;
    for (std::size_t n = 0; n < threads; ++n) team.emplace_back(work, n);
    for (std::thread& one : team) one.join();
    std::vector<std::uint64_t> hashes;
    for (const auto& instance : instances) hashes.push_back(state_hash(instance.state()));
    return hashes;
  };
  const auto alone = run(1);
  CHECK(alone == run(2));
  CHECK(alone[1] != alone[3]);
}

TEST_CASE("instance: a character that is teleported before its first step is neither pulled nor stretched") {
  const Cape c = cape();
  const Plan<double> plan = plan_of<double>(c.scene);
  Soa<double> memory(count);
  State<double> state = memory.view();
  place(state);
  auto instance = plan.instance(state);
  REQUIRE(instance.has_value());
  REQUIRE(instance->teleport({.translation = {50, 3, -20}}).has_value());
  REQUIRE(instance->step(frame).has_value());
  double fastest = 0;
  for (std::size_t i = 0; i < count; ++i) fastest = std::max(fastest, std::abs(state.v[1][i]) + std::abs(state.v[0][i]));
  CHECK(fastest < 1);  // m/s
  CHECK(state.x[0][0] == doctest::Approx(50));
  CHECK(instance->check().stretch < 1.01);
}

TEST_CASE("instance: advance takes whole steps, and moves pins evenly through the frame") {
  Scene scene;
  scene.mass = 1;
  scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 1.0, .rest_length = Scalars(1.0)}));
  const PinsId pins = add_pins(scene, {0});
  Soa<double> memory(2);
  State<double> state = memory.view();
  for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][0] = state.x[axis][1] = state.v[axis][0] = state.v[axis][1] = 0;
  state.x[0][1] = 1;
  const auto plan = compile<double>(scene, {.step = 0.125}, state);
  REQUIRE(plan.has_value());
  auto instance = plan->instance(state);
  REQUIRE(instance.has_value());
  const auto at = [](double y) { return std::vector<Vec3>{{0, y, 0}}; };
  REQUIRE(instance->move(pins, at(0)).has_value());
  CHECK(*instance->advance(0.125) == 1);
  REQUIRE(instance->move(pins, at(3)).has_value());
  CHECK(*instance->advance(0.1875) == 1);  // 0.0625 s remain, a third of the frame
  CHECK(state.x[1][0] == doctest::Approx(2));
  CHECK(instance->state().clock.seconds == 0.25);
  Soa<double> drawn(2);
  State<double> drawing = drawn.view();
  REQUIRE(instance->blend(drawing).has_value());
  CHECK(drawing.x[1][0] == doctest::Approx(1));  // half a step after the last step but one
  REQUIRE(instance->move(pins, at(4)).has_value());
  CHECK(*instance->advance(0.0625) == 1);
  CHECK(state.x[1][0] == doctest::Approx(4));
  CHECK(*instance->advance(100, 3) == 3);  // the remaining time is skipped
  CHECK(instance->advance(-1).error().field == "frame_time");
}

TEST_CASE("instance: a change of one instance's plan changes no other instance") {
  const Cape c = cape();
  const Plan<float> plan = plan_of<float>(c.scene);
  Soa<float> one(count), two(count), three(count);
  State<float> a = one.view(), b = two.view(), alone = three.view();
  place(a);
  place(b);
  place(alone);
  auto first = plan.instance(a), second = plan.instance(b);
  REQUIRE((first.has_value() && second.has_value()));
  REQUIRE(first->plan().set_force(0, Constant{.acceleration = {0, 3, 0}}).has_value());
  for (const double h : frames) {
    REQUIRE(first->step(h).has_value());
    REQUIRE(second->step(h).has_value());
  }
  Scene other = c.scene;
  other.forces[0] = Constant{.acceleration = {0, 3, 0}};
  Plan<float> changed = plan_of<float>(other);
  for (const double h : frames) {
    REQUIRE(changed.set_step(h).has_value());
    REQUIRE(changed.step(alone) == StepResult::done);
  }
  CHECK(state_hash(first->state()) == state_hash(alone));
  CHECK(state_hash(first->state()) != state_hash(second->state()));
}

TEST_CASE("instance: many step at once on any threads with the bits of each by itself, and errors name the first") {
  const Cape c = cape(Scheme::sequential);
  const Plan<float> plan = plan_of<float>(c.scene);
  constexpr std::size_t many = 6;
  const std::array<double, many> lengths{frame, frame / 2, frame, frame * 1.5, frame, frame / 2};
  std::vector<Soa<float>> memory;
  const auto make = [&] {
    State<float> state = memory.emplace_back(count).view();
    place(state);
    auto made = plan.instance(state);
    REQUIRE(made.has_value());
    return std::move(*made);
  };
  memory.reserve(4 * many);
  std::vector<Instance<float>> alone, together, on_threads;
  for (std::size_t k = 0; k < many; ++k) {
    alone.push_back(make());
    together.push_back(make());
    on_threads.push_back(make());
  }
  test::Threads threads(3);
  for (int n = 0; n < 5; ++n) {
    for (std::size_t k = 0; k < many; ++k) REQUIRE(alone[k].step(lengths[k]).has_value());
    REQUIRE(step<float>(together, lengths).has_value());
    REQUIRE(step<float>(on_threads, lengths, threads.parallel_for()).has_value());
  }
  for (std::size_t k = 0; k < many; ++k) {
    CHECK(state_hash(together[k].state()) == state_hash(alone[k].state()));
    CHECK(state_hash(on_threads[k].state()) == state_hash(alone[k].state()));
  }
  std::vector<Instance<float>*> listed;
  for (Instance<float>& one : together) listed.push_back(&one);
  const double one_time[] = {frame};
  REQUIRE(step<float>(std::span<Instance<float>* const>(listed), one_time).has_value());
  for (std::size_t k = 0; k < many; ++k) REQUIRE(alone[k].step(frame).has_value());
  CHECK(state_hash(together[3].state()) == state_hash(alone[3].state()));

  const double clock = together[2].state().clock.seconds;
  const double two_times[] = {frame, frame};
  CHECK(step<float>(together, two_times).error().field == "frame_times");
  listed[4] = listed[1];
  CHECK(step<float>(std::span<Instance<float>* const>(listed), one_time).error().message() ==
        "instances[4] is listed before: must be each instance once");
  listed[4] = nullptr;
  CHECK(step<float>(std::span<Instance<float>* const>(listed), one_time).error().field == "instances[4]");
  CHECK(together[2].state().clock.seconds == clock);
  const double clock3 = together[3].state().clock.seconds;
  const std::array<double, many> one_wrong{frame, frame, frame, std::nan(""), frame, frame};
  CHECK(step<float>(together, one_wrong).error().field == "instances[3].step");
  CHECK(together[3].state().clock.seconds == clock3);
  CHECK(together[2].state().clock.seconds > clock);
  const Instance<float> gone = std::move(together[1]);
  CHECK(step<float>(together, one_time).error().field == "instances[1]");
}

TEST_CASE("instance: set functions of a plan take the handles of added parts instead of indices") {
  Scene scene;
  scene.mass = 0.1;
  const ForceId gravity = add_force(scene, Constant{.acceleration = {0, -9.81, 0}});
  const ContactId floor = add_contact(scene, Plane{.offset = -9});
  const ForceId drag = add_force(scene, Drag{.coefficient = 0.1});
  const NetworkId rope = add_network(scene, Springs{.pairs = {{0, 1}}, .stiffness = 10.0, .rest_length = Scalars(1.0)});
  const PinsId pins = add_pins(scene, {0});
  const MotionId body = add_body(scene, Sphere{.center = {5, 0, 0}});
  Soa<double> memory(2);
  State<double> state = memory.view();
  for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][0] = state.x[axis][1] = state.v[axis][0] = state.v[axis][1] = 0;
  state.x[0][1] = 1;
  auto plan = compile<double>(scene, {.step = frame}, state);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  CHECK(plan->set_force(gravity, Constant{.acceleration = {0, -1, 0}}).has_value());
  CHECK(plan->set_force(drag, Drag{.coefficient = 0.2}).has_value());
  CHECK(plan->set_contact(floor, Plane{.offset = -4}).has_value());
  CHECK(plan->set_stiffness(rope, SpringsStiffness{.stiffness = 20.0}).has_value());
  CHECK(plan->set_pose(body, {.translation = {1, 0, 0}}).has_value());
  CHECK(plan->set_places(pins, std::vector<Vec3>{{0, 1, 0}}).has_value());
  CHECK(std::get<Constant>(plan->scene().forces[0]).acceleration[1] == -1);
  CHECK(std::get<Drag>(plan->scene().forces[1]).coefficient == PerAxis(0.2));
  CHECK(std::get<Plane>(plan->scene().contacts[0]).offset == -4);
  CHECK(std::get<Springs>(plan->scene().networks[0]).stiffness == Scalars(20.0));
  CHECK(plan->set_contact(ContactId{7}, Plane{}).error().field == "contacts[7]");
}

TEST_CASE("instance: misuse is an error that names what is wrong") {
  const Cape c = cape();
  const Plan<float> plan = plan_of<float>(c.scene);
  Soa<float> memory(count), few(3);
  State<float> state = memory.view();
  place(state);
  CHECK(plan.instance(few.view()).error().field == "state.count");
  State<float> empty{.x = {}, .v = {}, .count = count};
  CHECK(plan.instance(empty).error().field == "state");
  for (Column<float>* const column : {&empty.x[0], &empty.x[1], &empty.x[2], &empty.v[0], &empty.v[1], &empty.v[2]})
    column->capacity = count;
  CHECK(plan.instance(empty).error().field == "state");
  auto instance = plan.instance(state);
  REQUIRE(instance.has_value());
  CHECK(instance->move(MotionId{7}, Pose{}).error().field == "motions[7]");
  CHECK(instance->move(PinsId{0}, std::vector<Vec3>(2)).error().field == "places");
  CHECK(instance->move(SkinId{3}, std::vector<Vec3>(2)).error().field == "skins[3]");
  CHECK(instance->move(c.arm, Matrix34{}).error().field == "matrix");
  CHECK(instance->move(c.arm, pose_of({}, {0, 0, 0, 0})).error().field == "pose.rotation[0]");
  CHECK(instance->step(std::numeric_limits<double>::quiet_NaN()).error().field == "step");
  Instance<float> taken = std::move(*instance);
  // The instance owns its plan exclusively: a plan assigned to it stays there.
  CHECK(instance->plan().set_step(frame).error().field == "plan");
  instance->plan() = plan.clone();
  CHECK(instance->plan().step_size() == plan.step_size());
  Instance<float> other_taken = std::move(*instance);
  CHECK(other_taken.plan().step(state) == StepResult::moved_from);
  CHECK(instance->step(frame).error().field == "instance");
  CHECK(instance->move(c.arm, Pose{}).error().field == "instance");
  CHECK(instance->check().result == StepResult::moved_from);
  CHECK(taken.step(frame).has_value());
}

TEST_CASE("plan: a moved-from plan or workspace, and columns without memory, are refused by a result") {
  Cape c = cape();
  Plan<float> plan = plan_of<float>(c.scene);
  Soa<float> memory(count);
  State<float> state = memory.view();
  place(state);
  Workspace<float> workspace = plan.workspace();
  Workspace<float> kept = std::move(workspace);
  CHECK(plan.step(state, workspace) == StepResult::workspace_differs);
  State<float> nowhere = state;
  nowhere.v[2].base = nullptr;
  CHECK(plan.step(nowhere) == StepResult::capacity_too_small);
  const Plan<float> other = std::move(plan);
  CHECK(plan.step(state) == StepResult::moved_from);
  CHECK(plan.step(state, kept) == StepResult::moved_from);
  CHECK(plan.set_step(frame).error().message() == "plan is moved from: must be one that was not moved from");
  CHECK(plan.set_mass(0, 1).error().field == "plan");
  CHECK(plan.set_pose(0, {}).error().field == "plan");
  CHECK(plan.teleport(state, {}).error().field == "plan");
  CHECK(plan.instance(state).error().field == "plan");
  CHECK(plan.check(state).result == StepResult::moved_from);
  CHECK(plan.scene().networks.empty());
  CHECK(std::isnan(plan.step_size()));
  CHECK(plan.clone().step(state) == StepResult::moved_from);
  CHECK(plan.workspace().bytes() == 0);
  CHECK(plan.explain() == "moved from\n");
  CHECK(plan.carried(state).empty());
  CHECK(plan.meetings().substeps == 0);
  CHECK(other.meetings(workspace).substeps == 0);
}

TEST_CASE("instance: a step with too many neighbours names the limit, and leaves the state unchanged") {
  Scene scene;
  scene.add(Meet{.radius = 0.5, .most_neighbours = 1});
  Soa<float> memory(3);
  State<float> state = memory.view();
  for (std::size_t i = 0; i < 3; ++i) {
    state.x[0][i] = static_cast<float>(i);
    for (Column<float>* const column : {&state.x[1], &state.x[2], &state.v[0], &state.v[1], &state.v[2]}) (*column)[i] = 0;
  }
  const auto plan = compile<float>(scene, {.step = frame}, state);
  REQUIRE(plan.has_value());
  auto instance = plan->instance(state);
  REQUIRE(instance.has_value());
  const auto before = state_hash(state);
  CHECK(instance->step(frame).error().field == "meet.most_neighbours");
  CHECK(state_hash(state) == before);
}

TEST_CASE("workspace: poses of the plan are not ignored in silence, and a fresh one starts where they are") {
  const Cape c = cape();
  Plan<double> plan = plan_of<double>(c.scene);
  Soa<double> one(count), two(count);
  State<double> state = one.view(), other = two.view();
  place(state);
  place(other);
  Workspace<double> before = plan.workspace();
  REQUIRE(plan.step(state, before) == StepResult::done);
  REQUIRE(plan.set_places(0, pins_at(frame)).has_value());
  CHECK(plan.step(state, before) == StepResult::driven_elsewhere);
  place(state);
  state.clock = {};
  Workspace<double> fresh = plan.workspace();
  REQUIRE(plan.step(state, fresh) == StepResult::done);
  REQUIRE(plan.step(other) == StepResult::done);
  CHECK(state_hash(state) == state_hash(other));
  REQUIRE(before.set_places(0, pins_at(frame)).has_value());
  CHECK(plan.step(state, before) == StepResult::done);
  REQUIRE(plan.set_step(frame / 3).has_value());  // other sub-steps: the workspace continues
  CHECK(plan.step(state, before) == StepResult::done);
}

TEST_CASE("plan: set_network changes all values of a network, and refuses another shape") {
  const Cape c = cape();
  Scene stiffer = c.scene;
  Grid& grid = std::get<Grid>(stiffer.networks[0]);
  grid.structural = 70;
  grid.bend = 3;
  grid.aerodynamics = Aerodynamics{.density = 2};
  Plan<float> plan = plan_of<float>(c.scene), wanted = plan_of<float>(stiffer);
  REQUIRE(plan.set_network(0, grid).has_value());
  Soa<float> one(count), two(count);
  State<float> state = one.view(), other = two.view();
  place(state);
  place(other);
  REQUIRE(plan.step(state, 9) == StepResult::done);
  REQUIRE(wanted.step(other, 9) == StepResult::done);
  CHECK(state_hash(state) == state_hash(other));
  Grid wider = grid;
  wider.columns = 6;
  CHECK(plan.set_network(0, wider).error().field == "networks[0]");
  CHECK(plan.set_network(0, Springs{}).error().field == "networks[0]");
  CHECK(plan.set_network(1, grid).error().field == "networks[1]");
  grid.shear = -1;
  CHECK(plan.set_network(0, grid).error().field == "networks[0].shear");
}

TEST_CASE("pose: quaternions and matrices give the rotation of axis times angle") {
  const double angle = 2.5;
  const Vec3 axis{2.0 / 3, -1.0 / 3, 2.0 / 3};
  const double s = std::sin(angle / 2);
  const Pose of_quaternion = pose_of({1, 2, 3}, {5 * s * axis[0], 5 * s * axis[1], 5 * s * axis[2], 5 * std::cos(angle / 2)});
  for (std::size_t k = 0; k < 3; ++k) CHECK(of_quaternion.rotation[k] == doctest::Approx(angle * axis[k]));
  for (const double turn : {0.1, 1.0, 2.0, 3.1}) {  // matrices by Rodrigues' formula, each part the largest once
    for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, axis}) {
      Matrix34 m{};
      const double c = std::cos(turn), d = std::sin(turn);
      const Matrix34 cross{{{0, -n[2], n[1], 0}, {n[2], 0, -n[0], 0}, {-n[1], n[0], 0, 0}}};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) m[i][j] = (i == j ? c : 0) + (1 - c) * n[i] * n[j] + d * cross[i][j];
        m[i][3] = static_cast<double>(i);
      }
      const auto pose = pose_of(m, {0.5, 0, 0});
      REQUIRE(pose.has_value());
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(pose->rotation[i] == doctest::Approx(turn * n[i]));
        CHECK(pose->translation[i] == doctest::Approx(m[i][3] + 0.5 * m[i][0] - (i == 0 ? 0.5 : 0)));
      }
      m[0][0] += 0.01;
      CHECK_FALSE(pose_of(m).has_value());
    }
  }
  const std::array<float, 16> columns_of{0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
  const auto turned = pose_of(matrix_of_columns(columns_of.data()));
  REQUIRE(turned.has_value());
  CHECK(turned->rotation[2] == doctest::Approx(1.5707963267948966));
  CHECK(turned->translation == Vec3{7, 8, 9});
}

TEST_CASE("points: vectors of floats or doubles at any stride are read where they lie") {
  struct Vertex {
    float u;
    std::array<float, 3> position;
    double v;
  };
  const std::vector<Vertex> vertices{{1, {2, 3, 4}, 5}, {6, {7, 8, 9}, 10}};
  const Points strided(&vertices[0].position, vertices.size(), sizeof(Vertex));
  CHECK(strided[1] == Vec3{7, 8, 9});
  const std::vector<Vec3> doubles{{1, 2, 3}};
  const Points points = doubles;
  CHECK((points.size() == 1 && points[0] == doubles[0] && Points().empty()));
}

TEST_CASE("cloth: edges, bend pairs and springs come from triangles, and blend() mixes two states") {
  const std::vector<Triangle> triangles{{0, 1, 2}, {2, 1, 3}, {4, 3, 1}};
  CHECK(edges(triangles) == std::vector<Pair>{{0, 1}, {0, 2}, {1, 2}, {1, 3}, {1, 4}, {2, 3}, {3, 4}});
  CHECK(bend_pairs(triangles) == std::vector<Pair>{{0, 3}, {2, 4}});
  const std::vector<Triangle> fin{{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};  // three triangles share a side
  CHECK(bend_pairs(fin).empty());
  const Springs springs = springs_of(triangles, {.stretch = 40, .bend = 2, .damping = 0.5});
  REQUIRE(springs.pairs.size() == 9);
  CHECK((springs.stiffness[6] == 40 && springs.stiffness[7] == 2 && springs.triangles == triangles));
  Soa<float> one(1), two(1), drawn(1);
  State<float> before = one.view(), after = two.view(), to = drawn.view();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    before.x[axis][0] = before.v[axis][0] = 1;
    after.x[axis][0] = after.v[axis][0] = 3;
  }
  blend(before, after, 0.25, to);
  CHECK((to.x[0][0] == 1.5F && to.v[2][0] == 1.5F));
}

}  // namespace instance_test
