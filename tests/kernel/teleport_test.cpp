// A teleport carries a state with everything that moves it: the motion continues as at the old place.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/layouts/convert.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"

namespace teleport_test {

using namespace dvdx;
using test::apart;
using test::Batch;
using test::Joined;
using test::Layout;

constexpr std::size_t rows = 9, columns = 12;

// A teleport that turns about the y axis, the direction of gravity, with plain cosines.
struct Way {
  Vec3 translation{};
  double angle = 0;  // rad

  [[nodiscard]] Pose pose() const { return {.translation = translation, .rotation = {0, angle, 0}}; }
  [[nodiscard]] Vec3 direction(const Vec3& v) const {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]};
  }
  [[nodiscard]] Vec3 place(const Vec3& x) const {
    const Vec3 r = direction(x);
    return {r[0] + translation[0], r[1] + translation[1], r[2] + translation[2]};
  }
  [[nodiscard]] std::vector<Vec3> places(std::vector<Vec3> all) const {
    for (Vec3& x : all) x = place(x);
    return all;
  }
};
const std::vector<Way> near_ways{{{100, 0, -30}, 0}, {{100, 0, -30}, 2.1}};
const std::vector<Way> far_ways{{{1e6, 50, 0}, 0}, {{-1e6, 50, 2e5}, -1.3}};

// The values x, y, z, vx, vy, vz of each particle in turn, carried.
std::vector<double> carried(std::vector<double> values, const Way& way) {
  for (std::size_t i = 0; i < values.size(); i += 6) {
    const Vec3 x = way.place({values[i], values[i + 1], values[i + 2]});
    const Vec3 v = way.direction({values[i + 3], values[i + 4], values[i + 5]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      values[i + axis] = x[axis];
      values[i + 3 + axis] = v[axis];
    }
  }
  return values;
}

template <class T>
std::vector<double> values_of(const State<T>& state) {
  std::vector<double> values;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const auto* three : {&state.x, &state.v}) {
      const auto& rests = three == &state.x ? state.x_rest : state.v_rest;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double rest = state.has_rests() ? static_cast<double>(rests[axis][i]) : 0;
        values.push_back(static_cast<double>((*three)[axis][i]) + rest);
      }
    }
  }
  return values;
}

// The largest difference of the velocities, m/s, and of the vectors between neighbours in memory, m.
double apart_in_speed_and_shape(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool is_place = i % 6 < 3;
    const double before = is_place && i >= 6 ? a[i - 6] : 0;
    const double other = is_place && i >= 6 ? b[i - 6] : 0;
    if (is_place && i < 6) continue;
    most = std::max(most, std::abs((a[i] - before) - (b[i] - other)));
  }
  return most;
}

// A sheet with pins, a ball and a skin about its lower half on motion 0, which walks, turns and sways by keys.
struct Character {
  Joined joined = test::sheet(rows, columns, 400);
  std::vector<std::size_t> pins, skinned;

  Character() {
    Scene& scene = joined.scene;
    scene.fixed.clear();
    for (std::size_t i = 0; i < columns; ++i) pins.push_back(i);
    for (std::size_t i = columns * (rows / 2); i < columns * rows; ++i) skinned.push_back(i);
    scene.add(Motion{.center = {0.5, 0, 0},
                     .keys = {{.time = 0},
                              {.time = 0.2, .translation = {0.3, 0.02, 0.1}, .rotation = {0, 0.4, 0.1}},
                              {.time = 0.5, .translation = {0.2, 0, 0.3}, .rotation = {0.1, 0.2, 0}}}});
    scene.add(Kinematic{.particles = pins, .motion = 0});
    scene.add(Sphere{.center = {0.5, -0.18, 0.5}, .radius = 0.2, .friction = 0.3, .motion = 0});
    scene.add(Skin{.particles = skinned,
                   .at_most = 0.04,
                   .backstop = Backstop{.normals = {{0, 1, 0}}, .offset = 0.01, .radius = 0.3},
                   .motion = 0});
    scene.add(Tethers{.network = 0, .stretch = 1.1});
  }

  [[nodiscard]] Joined with(const Coupling& coupling, bool is_grid) const {
    Joined scene = is_grid ? joined : test::as_list(joined);
    scene.scene.coupling = coupling;
    return scene;
  }
  [[nodiscard]] std::vector<Vec3> at(const std::vector<std::size_t>& particles, const Vec3& by) const {
    std::vector<Vec3> points;
    for (const std::size_t i : particles) {
      const Vec3& x = joined.x[i];
      points.push_back({x[0] + by[0], x[1] + by[1], x[2] + by[2]});
    }
    return points;
  }
};

// Whether a program gives its targets before or after the teleport, in the frame that has one.
enum class Told { before, after };

struct Teleport {
  std::size_t frame = 0;
  Way way{};
  Told told = Told::after;
};

// The values after `frames` frames. drive(plan, frame, way) sets a program's targets; `way` is the teleport so far.
template <class T, class Drive>
std::vector<double> run(const Joined& scene, std::size_t frames, const Teleport& teleport, const Drive& drive,
                        const Options& options = {}, Layout layout = Layout::soa) {
  Batch<T> batch(layout, scene.x.size());
  Batch<T> rests(layout, scene.x.size());
  test::place(scene, batch.view());
  State<T> state = batch.view();
  const bool is_compensated = options.rounding == Rounding::compensated;
  if (is_compensated) {
    for (auto* of : {&rests.view().x, &rests.view().v}) {
      for (const Column<T>& column : *of) {
        for (std::size_t i = 0; i < state.count; ++i) column[i] = 0;
      }
    }
    state = compensated(state, rests.view());
  }
  Options of = options;
  of.step = scene.step;
  of.isa = best_isa();
  Plan<T> plan = compile<T>(scene.scene, of, state).value();
  Way way;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const bool is_due = frame == teleport.frame;
    if (!is_due || teleport.told == Told::before) drive(plan, frame, way);
    if (is_due) {
      const auto before = values_of(state);
      REQUIRE(plan.teleport(state, teleport.way.pose()).has_value());
      way = teleport.way;
      const double rounding = is_compensated ? 0x1p-46 : 4 * double{std::numeric_limits<T>::epsilon()};
      const double farthest = 4 + std::abs(way.translation[0]) + std::abs(way.translation[2]);
      CHECK(apart(carried(before, way), values_of(state)) < rounding * farthest);
    }
    if (is_due && teleport.told == Told::after) drive(plan, frame, way);
    REQUIRE(plan.step(state) == StepResult::done);
  }
  CHECK(batch.is_clean());
  return values_of(state);
}

const auto by_keys = [](auto& /*plan*/, std::size_t /*frame*/, const Way& /*way*/) {};

TEST_CASE("teleport: particles that keys move go on at the new place as at the old one, in every scheme, grid and list") {
  const Character character;
  for (const Coupling& coupling : test::couplings()) {
    for (const bool is_grid : {true, false}) {
      CAPTURE(static_cast<int>(coupling.scheme));
      CAPTURE(is_grid);
      const Joined scene = character.with(coupling, is_grid);
      const auto stays = run<double>(scene, 14, {.frame = 14}, by_keys);
      const auto off = [&](std::size_t frame, const Way& way) {
        return apart_in_speed_and_shape(carried(stays, way), run<double>(scene, 14, {frame, way}, by_keys));
      };
      // Places there are rounded by 1.4e-14 and 1.2e-10 m. Springs of 400 N/m on 1 g turn that into velocities.
      CHECK(off(7, near_ways[0]) < 1e-8);
      CHECK(off(7, near_ways[1]) < 1e-8);
      CHECK(off(0, near_ways[1]) < 1e-8);  // before any motion
      CHECK(off(7, far_ways[0]) < 1e-4);
      CHECK(off(7, far_ways[1]) < 1e-4);
    }
  }
}

// m: the character's place at the start of a frame.
Vec3 place_at(std::size_t frame) {
  const double t = static_cast<double>(frame) / 60;
  return {1.5 * t, 0.02 * std::sin(9 * t), 0.4 * t * t};
}

TEST_CASE("teleport: particles that a program drives go on at the new place, and targets that wait are carried along") {
  Character character;
  character.joined.scene.motions[0].center = {};
  character.joined.scene.skins[0].motion.reset();
  const auto drive = [&](auto& plan, std::size_t frame, const Way& way) {
    const Vec3 to = place_at(frame + 1);
    REQUIRE(plan.set_pose(0, {.translation = way.place(to), .rotation = {0, way.angle, 0}}).has_value());
    REQUIRE(plan.set_places(0, way.places(character.at(character.pins, to))).has_value());
    REQUIRE(plan.set_skin(0, way.places(character.at(character.skinned, to))).has_value());
  };
  for (const Coupling& coupling : test::couplings()) {
    CAPTURE(static_cast<int>(coupling.scheme));
    const Joined scene = character.with(coupling, true);
    const Way& way = near_ways[1];
    const auto wanted = carried(run<double>(scene, 16, {.frame = 16}, drive), way);
    for (const Told told : {Told::before, Told::after}) {
      CHECK(apart_in_speed_and_shape(wanted, run<double>(scene, 16, {8, way, told}, drive)) < 1e-8);
      CHECK(apart_in_speed_and_shape(wanted, run<double>(scene, 16, {0, way, told}, drive)) < 1e-8);
    }
  }
}

TEST_CASE("teleport: a resting skin, its normals and fixed particles are carried, also if the skin has just jumped") {
  Character character;
  Scene& sheet = character.joined.scene;
  sheet.kinematic.clear();
  sheet.fixed = {0, columns - 1};
  sheet.skins[0].motion.reset();
  const Joined scene = character.with({.scheme = Scheme::leapfrog}, true);
  const Vec3 near{0.01, 0.005, 0};
  const auto jump = [&](auto& plan, std::size_t frame, const Way& way) {
    if (frame != 8) return;
    REQUIRE(plan.set_skin(0, way.places(character.at(character.skinned, near)), {}, Arrival::jump).has_value());
  };
  const Way& way = near_ways[1];
  for (const Told told : {Told::before, Told::after}) {
    const auto wanted = carried(run<double>(scene, 16, {.frame = 16}, jump), way);
    CHECK(apart_in_speed_and_shape(wanted, run<double>(scene, 16, {8, way, told}, jump)) < 1e-8);
  }
  const auto rests = carried(run<double>(scene, 16, {.frame = 16}, by_keys), way);
  CHECK(apart_in_speed_and_shape(rests, run<double>(scene, 16, {8, way}, by_keys)) < 1e-8);
  CHECK(apart_in_speed_and_shape(rests, run<double>(scene, 16, {0, way}, by_keys)) < 1e-8);
}

TEST_CASE("teleport: it takes any layout, and compensated states 1000 km away") {
  const Character character;
  const Joined scene = character.with({.scheme = Scheme::leapfrog}, true);
  const auto stays = run<double>(scene, 8, {.frame = 8}, by_keys);
  for (const Layout layout : {Layout::aos, Layout::aosoa8}) {
    const auto carried_off = run<double>(scene, 8, {4, near_ways[1]}, by_keys, {}, layout);
    CHECK(apart_in_speed_and_shape(carried(stays, near_ways[1]), carried_off) < 1e-8);
  }
  const Options compensated{.rounding = Rounding::compensated};
  const auto as_float = run<float>(scene, 8, {.frame = 8}, by_keys, compensated);
  // Residuals resolve places there to 3.6e-9 m.
  const auto far = run<float>(scene, 8, {4, far_ways[1]}, by_keys, compensated);
  CHECK(apart_in_speed_and_shape(carried(as_float, far_ways[1]), far) < 2e-3);
  const auto in_float = run<float>(scene, 8, {.frame = 8}, by_keys);
  CHECK(apart_in_speed_and_shape(carried(in_float, near_ways[0]), run<float>(scene, 8, {4, near_ways[0]}, by_keys)) < 1);
}

TEST_CASE("teleport: a state in a workspace is carried there, once and again, and the plan's own is left alone") {
  const Character character;
  const Joined scene = character.with({.scheme = Scheme::sequential, .substeps = 4}, true);
  Batch<double> one(Layout::soa, scene.x.size()), two(Layout::soa, scene.x.size());
  for (auto* batch : {&one, &two}) test::place(scene, batch->view());
  Plan<double> plan = test::plan_of(scene, {.isa = best_isa()}, one.view());
  Workspace<double> workspace = plan.workspace();
  const auto step_both = [&](std::size_t steps) {
    REQUIRE(plan.step(one.view(), steps) == StepResult::done);
    REQUIRE(plan.step(two.view(), workspace, steps) == StepResult::done);
  };
  step_both(4);
  REQUIRE(plan.teleport(two.view(), workspace, near_ways[1].pose()).has_value());
  step_both(2);
  REQUIRE(plan.teleport(two.view(), workspace, near_ways[0].pose()).has_value());
  step_both(2);
  const auto stays = values_of(one.view());
  CHECK(stays == run<double>(scene, 8, {.frame = 8}, by_keys));
  CHECK(apart(carried(carried(stays, near_ways[1]), near_ways[0]), values_of(two.view())) < 1e-8);
  Workspace<double> other = test::plan_of<double>(test::sheet(4, 5, 100), {.isa = best_isa()}).workspace();
  CHECK(plan.teleport(two.view(), other, near_ways[1].pose()).error().field == "workspace");
}

TEST_CASE("teleport: a state stored after a teleport goes on in another plan with the same bits") {
  const Character character;
  const Joined scene = character.with({.scheme = Scheme::sequential, .substeps = 4}, true);
  Batch<double> one(Layout::soa, scene.x.size()), two(Layout::soa, scene.x.size());
  for (auto* batch : {&one, &two}) test::place(scene, batch->view());
  Plan<double> plan = test::plan_of(scene, {.isa = best_isa()}, one.view());
  Plan<double> next = plan.clone();
  REQUIRE(plan.step(one.view(), 3) == StepResult::done);
  REQUIRE(plan.teleport(one.view(), near_ways[1].pose()).has_value());
  REQUIRE(plan.teleport(one.view(), near_ways[0].pose()).has_value());
  copy(one.view(), two.view());
  REQUIRE(next.restore(plan.carried(one.view()), two.view()).has_value());
  for (Batch<double>* batch : {&one, &two}) REQUIRE((batch == &one ? plan : next).step(batch->view(), 3) == StepResult::done);
  CHECK(state_hash(one.view()) == state_hash(two.view()));
}

// A quarter turn about a point p near 1000 km: R x + (p - R p).
TEST_CASE("teleport: places counted from a far origin keep the digits that float32 has near it") {
  const Vec3 home{1e6, 0, 2e6};
  Batch<float> batch(Layout::soa, 2);
  const std::array<Vec3, 2> x{Vec3{0.25, 1, 0}, Vec3{0, 2, 0.125}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 2; ++i) {
      batch.view().x[axis][i] = static_cast<float>(x[i][axis]);
      batch.view().v[axis][i] = axis == 0 ? 1.0F : 0.0F;
    }
  }
  for (const bool is_each : {false, true}) {
    Scene scene;
    scene.origin = is_each ? Origin(std::vector<Vec3>{home, home}) : Origin(home);
    Plan<float> plan = compile<float>(scene, {}, batch.view()).value();
    const double quarter = std::numbers::pi / 2;
    const Pose by{.translation = {home[0] - home[2], 0, home[2] + home[0]}, .rotation = {0, quarter, 0}};
    REQUIRE(plan.teleport(batch.view(), by).has_value());
  }
  // Two quarter turns make a half turn.
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(batch.view().x[0][i] == doctest::Approx(-x[i][0]).epsilon(1e-6));
    CHECK(batch.view().x[1][i] == static_cast<float>(x[i][1]));
    CHECK(batch.view().x[2][i] == doctest::Approx(-x[i][2]).epsilon(1e-6));
    CHECK(batch.view().v[0][i] == doctest::Approx(-1));
  }
}

TEST_CASE("teleport: live particles are carried, and a particle that is not finite stays") {
  LiveState<double> live;
  Batch<double> batch(Layout::soa, 3);
  live.state = batch.view();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 3; ++i) {
      live.state.x[axis][i] = static_cast<double>(i + axis);
      live.state.v[axis][i] = static_cast<double>(2 * i) - static_cast<double>(axis);
    }
  }
  live.state.x[0][2] = std::numeric_limits<double>::infinity();
  const auto before = values_of(live.state);
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const LifecyclePlan<double> plan =
      compile<double>(scene, {.emitters = {}, .removal = {}, .capacity = 3}, {.step = 0.01}).value();
  REQUIRE(plan.teleport(live, far_ways[1].pose()).has_value());
  const auto after = values_of(live.state);
  const auto wanted = carried(before, far_ways[1]);
  for (std::size_t k = 0; k < 12; ++k) CHECK(after[k] == doctest::Approx(wanted[k]).epsilon(1e-12));
  CHECK(std::isinf(after[12]));
  REQUIRE(plan.step(live, 10) == StepResult::done);
  CHECK(live.state.v[0][1] == doctest::Approx(wanted[9]).epsilon(1e-12));
  CHECK(live.state.v[1][1] == doctest::Approx(wanted[10] - 9.81 * 0.1).epsilon(1e-12));
}

TEST_CASE("teleport: a state, a pose or a scene that cannot be carried is refused, and nothing changes") {
  const Character character;
  Joined scene = character.with({.scheme = Scheme::leapfrog}, true);
  Batch<float> batch(Layout::soa, scene.x.size());
  test::place(scene, batch.view());
  Plan<float> plan = test::plan_of(scene, {.isa = best_isa()}, batch.view());
  const std::uint64_t hash = state_hash(batch.view());
  const auto driven = plan.carried(batch.view());
  const auto refused = [&](State<float>& state, const Pose& by) { return plan.teleport(state, by).error().field; };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(refused(batch.view(), {.translation = {0, nan, 0}}) == "by.translation[1]");
  CHECK(refused(batch.view(), {.rotation = {0, 0, std::numeric_limits<double>::infinity()}}) == "by.rotation[2]");
  CHECK(refused(batch.view(), {.translation = {1e6, 0, 0}}) == "by.translation");
  CHECK(refused(batch.view(), {.translation = {1e300, 0, 0}}) == "by.translation");
  State<float> fewer = batch.view();
  fewer.count -= 1;
  CHECK(refused(fewer, {.translation = {1, 0, 0}}) == "state.count");
  CHECK(state_hash(batch.view()) == hash);
  CHECK(plan.carried(batch.view()) == driven);

  Scene pinned;
  pinned.add(Constraint(Distance{.pairs = {{0, 1}}})).add(Constraint(OnPoint{.particle = 0, .at = {}}));
  Batch<double> pendulum(Layout::soa, 2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 2; ++i) {
      pendulum.view().x[axis][i] = static_cast<double>(i);
      pendulum.view().v[axis][i] = 0;
    }
  }
  Plan<double> swings = compile<double>(pinned, {}, pendulum.view()).value();
  CHECK(swings.teleport(pendulum.view(), {.translation = {1, 0, 0}}).error().field == "constraints[1]");
  CHECK(pendulum.view().x[0][1] == 1);
}

}  // namespace teleport_test
