// compile(), set_step() and replace(): accepted input, refusals and their messages.
#include "dvdx/plan.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <string>
#include <vector>

#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace plan_test {

using namespace dvdx;
using test::Batch;
using test::Layout;
using test::NamedScene;

constexpr std::size_t count = 5;
constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

struct Bad {
  const char* field;
  const char* value;
  const char* valid;
  Scene scene;
};

Scene with_force(Force force) {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return scene.add(std::move(force));
}
Scene with_contact(Contact contact) { return Scene{}.add(std::move(contact)); }
Scene with_mass(Scalars mass) {
  Scene scene;
  scene.mass = std::move(mass);
  return scene;
}
Scene with_fixed(std::vector<std::size_t> fixed) {
  Scene scene;
  scene.fixed = std::move(fixed);
  return scene;
}

constexpr const char* positive = "a finite number > 0";
constexpr const char* non_negative = "a finite number >= 0";
constexpr const char* finite = "a finite number";
constexpr const char* unit = "a number from 0 to 1";
constexpr const char* each = "one for each of the 5 particles";

std::vector<Bad> bad_scenes() {
  std::vector<Bad> list = {
      {"mass", "0", positive, with_mass(0.0)},
      {"mass", "-1.5", positive, with_mass(-1.5)},
      {"mass", "nan", positive, with_mass(quiet_nan)},
      {"mass", "inf", positive, with_mass(inf)},
      {"mass[3]", "0", positive, with_mass(std::vector<double>{1, 2, 3, 0, 5})},
      {"mass", "4 values", each, with_mass(std::vector<double>{1, 2, 3, 4})},
      {"forces[1].acceleration[1]", "nan", finite, with_force(Constant{.acceleration = {0, quiet_nan, 0}})},
      {"forces[1].acceleration", "0 terms", "1 to 8 terms", with_force(Polynomial{})},
      {"forces[1].acceleration", "9 terms", "1 to 8 terms", with_force(Polynomial{.acceleration = std::vector<Vec3>(9)})},
      {"forces[1].acceleration[1][2]", "-inf", finite, with_force(Polynomial{.acceleration = {{}, {0, 0, -inf}}})},
      {"forces[1].acceleration[0]", "inf", finite, with_force(Sinusoid{.acceleration = {inf, 0, 0}})},
      {"forces[1].angular_frequency", "nan", finite, with_force(Sinusoid{.angular_frequency = quiet_nan})},
      {"forces[1].phase", "inf", finite, with_force(Sinusoid{.phase = inf})},
      {"forces[1].stiffness", "-40", non_negative, with_force(Spring{.stiffness = -40.0})},
      {"forces[1].stiffness", "inf", non_negative, with_force(Spring{.stiffness = inf})},
      {"forces[1].stiffness[2]", "-1", non_negative, with_force(Spring{.stiffness = {1, 2, -1}})},
      {"forces[1].stiffness[4]", "nan", non_negative,
       with_force(Spring{.stiffness = std::vector<double>{1, 2, 3, 4, quiet_nan}})},
      {"forces[1].stiffness", "1 values", each, with_force(Spring{.stiffness = std::vector<double>{1}})},
      {"forces[1].damping", "-0.1", non_negative, with_force(Spring{.damping = -0.1})},
      {"forces[1].anchor[0]", "nan", finite, with_force(Spring{.anchor = Vec3{quiet_nan, 0, 0}})},
      {"forces[1].anchor", "2 values", each, with_force(Spring{.anchor = std::vector<Vec3>(2)})},
      {"forces[1].anchor[1][2]", "inf", finite, with_force(Spring{.anchor = std::vector<Vec3>{{}, {0, 0, inf}, {}, {}, {}}})},
      {"forces[1].stiffness", "-2", non_negative, with_force(RadialSpring{.stiffness = -2.0})},
      {"forces[1].damping", "nan", non_negative, with_force(RadialSpring{.damping = quiet_nan})},
      {"forces[1].rest_length", "-1", non_negative, with_force(RadialSpring{.rest_length = -1.0})},
      {"forces[1].coefficient", "-0.5", non_negative, with_force(Drag{.coefficient = -0.5})},
      {"forces[1].coefficient[0]", "inf", non_negative, with_force(Drag{.coefficient = {inf, 0, 0}})},
      {"forces[1].wind[2]", "nan", finite, with_force(Drag{.wind = {0, 0, quiet_nan}})},
      {"contacts[0].normal", "[0, 0, 0]", "a vector of finite length > 0", with_contact(Plane{.normal = {0, 0, 0}})},
      {"contacts[0].normal[0]", "nan", finite, with_contact(Plane{.normal = {quiet_nan, 0, 0}})},
      {"contacts[0].offset", "inf", finite, with_contact(Plane{.offset = inf})},
      {"contacts[0].restitution", "1.5", unit, with_contact(Plane{.restitution = 1.5})},
      {"contacts[0].restitution", "-0.5", unit, with_contact(Sphere{.restitution = -0.5})},
      {"contacts[0].friction", "-1", "a number >= 0", with_contact(Plane{.friction = -1})},
      {"contacts[0].viscosity", "nan", "a number >= 0", with_contact(Plane{.viscosity = quiet_nan})},
      {"contacts[0].normal_viscosity", "-3", "a number >= 0", with_contact(Sphere{.normal_viscosity = -3})},
      {"contacts[0].radius", "0", positive, with_contact(Sphere{.radius = 0})},
      {"contacts[0].center[1]", "nan", finite, with_contact(Sphere{.center = {0, quiet_nan, 0}})},
      {"fixed[1]", "2", "particle ids in ascending order", with_fixed({2, 2})},
      {"fixed[0]", "5", "a particle id below 5", with_fixed({5})},
  };
  return list;
}

struct BadOptions {
  const char* field;
  const char* value;
  const char* valid;
  Options options;
};

template <class T>
std::vector<T> stepped(const Plan<T>& plan, std::size_t steps = 4) {
  Batch<T> batch(Layout::soa, count);
  test::place(batch.view());
  REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
  return test::values_of(batch.view());
}

template <class T>
Expected<Plan<T>> compiled(const Scene& scene, const Options& options) {
  Batch<T> batch(Layout::soa, count);
  test::place(batch.view());
  return compile<T>(scene, options, batch.view());
}

// The same force with different numbers.
Force changed(Force force) {
  if (auto* spring = std::get_if<Spring>(&force)) {
    spring->damping *= 1.25;
    if (spring->stiffness.is_uniform() && spring->stiffness.is_isotropic())
      spring->stiffness = 1.5 * spring->stiffness.at(0, 0);
    if (auto* anchor = std::get_if<Vec3>(&spring->anchor)) (*anchor)[1] += 0.3;
  }
  if (auto* spring = std::get_if<RadialSpring>(&force)) spring->rest_length = 0.7;
  if (auto* drag = std::get_if<Drag>(&force)) drag->wind[1] += 2;
  if (auto* constant = std::get_if<Constant>(&force)) constant->acceleration[1] = -3.7;
  if (auto* sinusoid = std::get_if<Sinusoid>(&force)) sinusoid->angular_frequency = 5.5;
  if (auto* polynomial = std::get_if<Polynomial>(&force)) polynomial->acceleration.back() = {1, 2, 3};
  return force;
}

TEST_CASE("a bad scene is refused with the field, its value and what is valid") {
  for (const Bad& bad : bad_scenes()) {
    const auto plan = compiled<double>(bad.scene, {});
    REQUIRE_MESSAGE(!plan.has_value(), bad.field << " = " << bad.value);
    CHECK(plan.error().field == bad.field);
    CHECK(plan.error().value == bad.value);
    CHECK(plan.error().valid == bad.valid);
    CHECK(plan.error().message() == std::string(bad.field) + " is " + bad.value + ": must be " + bad.valid);
    CHECK_FALSE(compiled<float>(bad.scene, {}).has_value());
  }
}

TEST_CASE("bad options are refused in the same way") {
  constexpr const char* step = "a finite number";
  constexpr const char* block = "a multiple of 16 up to 1024, or 0";
  constexpr const char* impacts = "a whole number from 1 to 1000";
  const BadOptions bads[] = {{"step", "nan", step, {.step = quiet_nan}}, {"step", "-inf", step, {.step = -inf}},
                             {"block", "8", block, {.block = 8}},        {"block", "1040", block, {.block = 1040}},
                             {"impacts", "0", impacts, {.impacts = 0}},  {"impacts", "1001", impacts, {.impacts = 1001}}};
  for (const BadOptions& bad : bads) {
    const auto plan = compiled<float>(Scene{}, bad.options);
    REQUIRE_FALSE(plan.has_value());
    CHECK(plan.error().field == bad.field);
    CHECK(plan.error().value == bad.value);
    CHECK(plan.error().valid == bad.valid);
  }
}

TEST_CASE("values each, and anchors at the start, need a state to compile for") {
  const auto values = compile<float>(with_mass(std::vector<double>{1, 2}), {});
  REQUIRE_FALSE(values.has_value());
  CHECK(values.error().message() == "mass is 2 values: must be values each need the state: compile(scene, options, state)");
  const auto anchors = compile<float>(with_force(Spring{.stiffness = 1.0, .anchor = at_start}), {});
  REQUIRE_FALSE(anchors.has_value());
  CHECK(anchors.error().field == "forces[1].anchor");
}

TEST_CASE_TEMPLATE("lengths are taken from a start that is finite, and not all at one place", T, float, double) {
  const auto refusal = [](const auto& part, std::size_t particle, double value) {
    test::Batch<T> batch(test::Layout::soa, 4);
    for (std::size_t i = 0; i < 4; ++i) batch.view().x[0][i] = value == 0 ? T(2) : static_cast<T>(i);
    if (value != 0) batch.view().x[1][particle] = static_cast<T>(value);
    Scene scene;
    scene.add(part);
    const auto plan = compile<T>(scene, {.step = 0.01}, batch.view());
    return plan ? std::string() : plan.error().message();
  };
  const Springs springs{.pairs = {{0, 1}, {1, 2}}, .stiffness = 1.0};
  const Distance rods{.pairs = {{0, 1}, {1, 2}}};
  const Distance ropes{.pairs = {{0, 1}, {1, 2}}, .bound = Bound::at_most};
  const auto check = [&](const auto& part, const std::string& field) {
    for (const double bad : {quiet_nan, inf, -inf}) {
      CHECK(refusal(part, 1, bad).starts_with("state.x[1][1] is "));
      CHECK(refusal(part, 1, bad).ends_with("must be a finite number where " + field + " is taken from the start"));
      CHECK(refusal(part, 3, bad).empty());  // no spring joins it
    }
    CHECK(refusal(part, 0, 0) ==
          field +
              " is 0 at the start between all pairs: must be above 0 between some: fill positions before "
              "compile(), or give the lengths");
  };
  check(springs, "networks[0].rest_length");
  check(rods, "constraints[0].length");
  check(ropes, "constraints[0].length");
  // Given lengths need no start.
  CHECK(refusal(Springs{.pairs = {{0, 1}}, .stiffness = 1.0, .rest_length = 1.0}, 1, quiet_nan).empty());
  CHECK(refusal(Springs{.pairs = {{0, 1}}, .stiffness = 1.0, .rest_length = 1.0}, 0, 0).empty());
}

TEST_CASE("coefficients beyond the scalar type are refused, at compile and at set_step") {
  Scene scene = with_force(Spring{.stiffness = 1e30, .method = Method::symplectic_euler});
  CHECK(compiled<float>(scene, {.step = 1e10}).error().field == "step");
  auto plan = compiled<float>(scene, {.step = 0.1});
  REQUIRE(plan.has_value());
  const std::vector<float> before = stepped(*plan);
  const auto refused = plan->set_step(1e10);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().field == "step");
  CHECK(plan->step_size() == 0.1);
  CHECK(test::difference(before, stepped(*plan)).empty());
}

TEST_CASE("a single particle's coefficient beyond the scalar type is refused too") {
  Scene scene = with_force(Spring{.stiffness = std::vector<double>{1, 1, 1, 1, 1e30}, .method = Method::symplectic_euler});
  CHECK_FALSE(compiled<float>(scene, {.step = 1e10}).has_value());
}

TEST_CASE_TEMPLATE("set_step makes the plan that compile makes, bit by bit", T, float, double) {
  for (const NamedScene& scene : test::all_scenes(count)) {
    auto plan = compiled<T>(scene.scene, {.step = scene.step});
    REQUIRE(plan.has_value());
    for (const double h : {0.004, -0.03, 0.75, scene.step}) {
      REQUIRE(plan->set_step(h).has_value());
      CHECK(plan->step_size() == h);
      const auto fresh = compiled<T>(scene.scene, {.step = h, .longest_step = plan->longest_step()});
      const std::string difference = test::difference(stepped(*fresh), stepped(*plan));
      CHECK_MESSAGE(difference.empty(), scene.name << ", step " << h << ": " << difference);
    }
  }
}

TEST_CASE("a step that cannot be is refused, and the plan stays as it was") {
  auto plan = compiled<double>(with_force(Spring{.stiffness = 3.0}), {.step = 0.1});
  const std::vector<double> before = stepped(*plan);
  for (const double h : {quiet_nan, inf, -inf}) CHECK(plan->set_step(h).error().field == "step");
  CHECK(plan->step_size() == 0.1);
  CHECK(test::difference(before, stepped(*plan)).empty());
}

TEST_CASE("friction and viscosities may be infinite") {
  const Plane sticky{.friction = inf, .viscosity = inf, .normal_viscosity = inf};
  CHECK(compiled<float>(with_contact(sticky), {}).has_value());
}

TEST_CASE_TEMPLATE("a radial spring without rest length and damping is the spring in every direction", T, float, double) {
  const std::vector<double> stiffness_each{1, 2, 300, 4, 5e6};
  const auto radial = compiled<T>(with_force(RadialSpring{.stiffness = stiffness_each, .anchor = at_start}), {});
  const auto spring = compiled<T>(with_force(Spring{.stiffness = stiffness_each, .anchor = at_start}), {});
  const std::string difference = test::difference(stepped(*spring), stepped(*radial));
  CHECK_MESSAGE(difference.empty(), difference);
}

TEST_CASE_TEMPLATE("replace makes the plan that compile makes, bit by bit", T, float, double) {
  for (const NamedScene& scene : test::all_scenes(count)) {
    for (std::size_t i = 0; i < scene.scene.forces.size(); ++i) {
      auto plan = compiled<T>(scene.scene, {.step = scene.step});
      Scene other = scene.scene;
      other.forces[i] = changed(other.forces[i]);
      REQUIRE(plan->set_force(i, other.forces[i]).has_value());
      CHECK(plan->scene() == other);
      const auto fresh = compiled<T>(other, {.step = scene.step});
      const std::string difference = test::difference(stepped(*fresh), stepped(*plan));
      CHECK_MESSAGE(difference.empty(), scene.name << ", force " << i << ": " << difference);
    }
  }
}

TEST_CASE("replace refuses what compile refuses, and leaves the plan as it was") {
  auto plan = compiled<float>(with_force(Spring{.stiffness = 3.0}), {.step = 0.1});
  const std::vector<float> before = stepped(*plan);
  CHECK(plan->set_force(2, Drag{}).error().field == "forces[2]");
  CHECK(plan->set_force(1, Spring{.stiffness = -3.0}).error().field == "forces[1].stiffness");
  CHECK_FALSE(plan->set_force(1, Spring{.stiffness = 1e300, .method = Method::symplectic_euler}).has_value());
  CHECK(plan->set_force(1, Spring{.anchor = at_start}).error().field == "forces[1].anchor");
  CHECK(test::difference(before, stepped(*plan)).empty());
}

TEST_CASE("more accelerations that act differently on each particle than a step holds are refused") {
  Scene scene = with_mass(std::vector<double>{1, 2, 3, 4, 5});
  scene.add(Spring{.stiffness = 3.0});
  for (int i = 0; i < 8; ++i) scene.add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 1.0 + i});
  CHECK(compiled<float>(scene, {}).has_value());
  scene.add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 0.5});
  const auto plan = compiled<float>(scene, {});
  REQUIRE_FALSE(plan.has_value());
  CHECK(plan.error().field == "forces");
}

TEST_CASE("a plan that is moved steps as before") {
  auto plan = compiled<float>(with_force(Spring{.stiffness = 3.0, .damping = 0.1}), {});
  const std::vector<float> before = stepped(*plan);
  Plan<float> moved = std::move(*plan);
  CHECK(test::difference(before, stepped(moved)).empty());
}

TEST_CASE("a plan explains itself") {
  for (const NamedScene& scene : test::all_scenes(count)) {
    const std::string text = compiled<float>(scene.scene, {.step = scene.step})->explain();
    for (const char* word : {"step", "passes", "flow", "cost", "stability", "seek"}) {
      CHECK_MESSAGE(text.find(word) != std::string::npos, scene.name << ": " << text);
    }
  }
}

}  // namespace plan_test
