// Measures the claims of `explain` about a scene's accuracy, by the differences of a path at h, h/2 and h/4.
#include "stability/accuracy.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dvdx/constrain.hpp"
#include "dvdx/plan.hpp"
#include "support/batch.hpp"

namespace dvdx::test::accuracy_test {

struct Start {
  std::vector<Vec3> x, v;
};

// All positions and velocities at the time 1 s.
std::vector<double> path_end(const Scene& scene, const Start& start, int steps) {
  Batch<double> batch(Layout::soa, start.x.size());
  for (std::size_t i = 0; i < start.x.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.view().x[axis][i] = start.x[i][axis];
      batch.view().v[axis][i] = start.v[i][axis];
    }
  }
  const auto plan = compile<double>(scene, {.step = 1.0 / steps, .isa = Isa::reference}, batch.view());
  REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
  REQUIRE(plan->step(batch.view(), static_cast<std::size_t>(steps)) == StepResult::done);
  return values_of(batch.view());
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum);
}

// The difference made by halving the step, averaged over steps near 1/steps: impacts fall at different parts of a step.
double halved(const Scene& scene, const Start& start, int steps, int samples) {
  double sum = 0;
  for (int k = 0; k < samples; ++k) {
    const int n = steps + k * steps / (2 * samples);
    sum += difference(path_end(scene, start, n), path_end(scene, start, 2 * n));
  }
  return sum / samples;
}

struct Case {
  std::string name;
  Scene scene;
  Start start = {{{0.3, 0.7, -0.2}}, {{0.5, -0.4, 0.8}}};
  int steps = 256;
};

void check_claim(const Case& c, int expected) {
  CAPTURE(c.name);
  const System system(c.scene, c.start.x, 1.0 / c.steps);
  const Accuracy claim = accuracy(c.scene, system);
  std::string reasons;
  for (const std::string& reason : claim.reasons) reasons += reason + "; ";
  CAPTURE(reasons);
  CHECK(claim.order == expected);
  CHECK(claim.reasons.empty() == (claim.order == Accuracy::exact));
  const int samples = c.scene.contacts.empty() ? 1 : 12;
  const double coarse = halved(c.scene, c.start, c.steps, samples);
  if (claim.order == Accuracy::exact) {
    CHECK(coarse <= 1e-11);
    return;
  }
  const double fine = halved(c.scene, c.start, 8 * c.steps, samples);
  const double measured = std::log2(coarse / fine) / 3;
  CAPTURE(coarse);
  CHECK(measured >= claim.order - (samples == 1 ? 0.25 : 0.5));
  CHECK(measured <= claim.order + (samples == 1 ? 0.25 : 0.5));
}

Scene scene_of(std::vector<Force> forces, Method method = Method::combined) {
  Scene scene;
  scene.method = method;
  for (Force& force : forces) scene.add(std::move(force));
  return scene;
}

const Constant gravity{.acceleration = {0, -9.81, 0}};
const Polynomial ramp{.acceleration = {{10, 0, 5}, {0, 20, 10}}};
const Sinusoid shake{.acceleration = {1, 2, 0}, .angular_frequency = 5};
const Spring spring{.stiffness = 30.0};
const Spring second{.stiffness = 17.0, .anchor = Vec3{0.1, 0, 0}};
const Spring damped{.stiffness = 30.0, .damping = 0.8};
const Drag drag{.coefficient = 0.7, .wind = {1, 0, 0}};
const RadialSpring radial{.stiffness = 40.0, .rest_length = 0.5};
const RadialSpring damped_radial{.stiffness = 40.0, .damping = 0.8, .rest_length = 0.5};

constexpr int exact = Accuracy::exact;

TEST_CASE("A free particle has the order that accuracy() states") {
  check_claim({"all as one system", scene_of({gravity, ramp, shake, spring, second, damped, drag})}, exact);
  for (const Method method : {Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
    const bool is_exact = method == Method::exact;
    const bool is_pulse = method == Method::pulse || method == Method::symplectic_euler;
    CAPTURE(static_cast<int>(method));
    const auto order = [&](int of_exact, int of_average) { return is_pulse ? 1 : (is_exact ? of_exact : of_average); };
    check_claim({"gravity", scene_of({gravity}, method)}, order(exact, exact));
    check_claim({"ramp", scene_of({ramp}, method)}, order(exact, 2));
    check_claim({"shake", scene_of({shake, gravity}, method)}, order(exact, 2));
    check_claim({"spring", scene_of({spring}, method)}, order(exact, 2));
    check_claim({"two springs", scene_of({spring, second}, method)}, order(2, 2));
    check_claim({"spring and gravity", scene_of({spring, gravity}, method)}, order(2, 2));
    check_claim({"damped spring", scene_of({damped}, method)}, order(exact, 2));
    check_claim({"drag", scene_of({drag}, method)}, order(exact, 2));
    check_claim({"drag and gravity", scene_of({drag, gravity}, method)}, 1);
    check_claim({"drag and spring", scene_of({drag, spring}, method)}, 1);
    check_claim({"damped spring and ramp", scene_of({damped, ramp}, method)}, 1);
  }
  Spring apart = spring;
  apart.method = Method::exact;
  check_claim({"one apart from a system", scene_of({apart, second, gravity})}, 2);
  check_claim({"one apart from a damped system", scene_of({apart, drag})}, 1);
  check_claim({"one apart from gravity", scene_of({apart, gravity})}, 2);
  Constant push = gravity;
  push.method = Method::exact;
  check_claim({"gravity apart from a spring", scene_of({push, spring})}, 2);
  check_claim({"gravity apart from a drag", scene_of({push, drag})}, 1);
  Drag truncated = drag;
  truncated.expansion = Expansion::first_order;
  check_claim({"drag of first order", scene_of({truncated})}, 1);
}

TEST_CASE("Radial springs have the order that accuracy() states") {
  check_claim({"one", scene_of({radial})}, 2);
  check_claim({"two and gravity", scene_of({radial, RadialSpring{.stiffness = 20.0, .anchor = Vec3{1, 0, 0}}, gravity})}, 2);
  check_claim({"damped, with drag", scene_of({damped_radial, drag, gravity})}, 2);
  for (const Method method : {Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
    CAPTURE(static_cast<int>(method));
    const int order = method == Method::pulse || method == Method::symplectic_euler ? 1 : 2;
    check_claim({"one by a method", scene_of({radial}, method)}, order);
    check_claim({"with gravity", scene_of({radial, gravity}, method)}, order);
    check_claim({"damped", scene_of({damped_radial}, method)}, order);
    check_claim({"damped, with gravity", scene_of({damped_radial, gravity}, method)}, 1);
    check_claim({"with drag", scene_of({radial, drag}, method)}, 1);
    RadialSpring apart = radial;
    apart.method = method;
    check_claim({"beside a kick", scene_of({apart, radial})}, order);
  }
}

TEST_CASE("Impacts have the order that accuracy() states") {
  Plane floor;
  floor.restitution = 1;
  const Start start{{{0.3, 0.7, -0.2}}, {{0.5, -1.4, 0.8}}};
  const auto with = [&](Scene scene, const Contact& contact) {
    scene.add(contact);
    return scene;
  };
  check_claim({"elastic under gravity", with(scene_of({gravity}), floor), start}, exact);
  check_claim({"without force", with(scene_of({}), floor), start}, exact);
  Plane viscous = floor;
  viscous.viscosity = 0.3;
  viscous.normal_viscosity = 0.1;
  check_claim({"viscous", with(scene_of({gravity}), viscous), start}, exact);
  Sphere ball;
  ball.restitution = 1;
  check_claim({"a ball", with(scene_of({gravity}), ball), {{{0.3, 1.7, -0.2}}, {{0.5, -1.4, 0.8}}}}, exact);
  Plane seed = floor;
  seed.response = Response::end_on_surface;
  check_claim({"seed", with(scene_of({gravity}), seed), start}, 1);
  Plane line = floor;
  line.sweep = ContactPath::line;
  check_claim({"line", with(scene_of({gravity}), line), start}, 2);
  Plane rough = floor;
  rough.restitution = 0;
  rough.friction = 0.1;
  const Start oblique{{{0.3, 0.7, -0.2}}, {{2, -1.4, -0.5}}};  // slides on a curve: a straight slide is exact
  check_claim({"friction", with(scene_of({gravity, Constant{.acceleration = {-2, 0, -3}}}), rough), oblique}, 1);
  check_claim({"drag", with(scene_of({gravity, drag}), floor), start}, exact);
  check_claim({"spring", with(scene_of({gravity, second}), floor), start}, exact);
  check_claim({"damped spring, a ball", with(scene_of({gravity, damped}), ball), {{{0.3, 1.7, -0.2}}, {{0.5, -1.4, 0.8}}}},
              exact);
  check_claim({"ramp", with(scene_of({gravity, ramp}), floor), start}, exact);
  check_claim(
      {"shake", with(scene_of({gravity, Sinusoid{.acceleration = {1, 20, 0}, .angular_frequency = 25}}), floor), start, 64}, 5);
  check_claim({"radial", with(scene_of({gravity, radial}), floor), start}, 2);
}

TEST_CASE("Networks and constraints have the order that accuracy() states") {
  const Start start{{{0, 0, 0}, {1, 0, 0}, {1.8, 0.5, 0}}, {{0, 0, 0}, {0.3, 0.2, -0.5}, {0, 1, 0.4}}};
  const auto chain = [&](Coupling coupling, double damping, bool has_drag) {
    Scene scene = scene_of({gravity});
    if (has_drag) scene.add(drag);
    scene.add(Springs{.pairs = {{0, 1}, {1, 2}}, .stiffness = 50.0, .rest_length = 0.9, .damping = damping});
    scene.fixed = {0};
    scene.coupling = coupling;
    scene.coupling.substeps = 1;
    return scene;
  };
  const auto both = [&](const std::string& name, const Coupling& coupling, int plain, int damped_order) {
    for (const bool has_drag : {false, true}) {
      for (const double damping : {0.0, 0.5}) {
        CAPTURE(has_drag);
        CAPTURE(damping);
        const bool is_sum = coupling.scheme == Scheme::accumulate && coupling.method != Method::combined;
        check_claim({name, chain(coupling, damping, has_drag), start, 128},
                    damping > 0 || (has_drag && is_sum) ? damped_order : plain);
      }
    }
  };
  both("leapfrog", {.scheme = Scheme::leapfrog}, 2, 2);
  both("fourth order", {.scheme = Scheme::fourth_order}, 4, 4);
  both("sequential", {.scheme = Scheme::sequential}, 2, 2);
  both("sequential past the middle", {.scheme = Scheme::sequential, .theta = 0.55}, 1, 1);
  both("sequential forwards", {.scheme = Scheme::sequential, .sweeps = SweepOrder::forward}, 1, 1);
  both("sequential at the middle", {.scheme = Scheme::sequential, .theta = 0.5}, 2, 2);
  both("kicks", {.scheme = Scheme::accumulate, .method = Method::combined}, 2, 1);
  both("exact", {.scheme = Scheme::accumulate, .method = Method::exact}, 2, 1);
  both("average", {.scheme = Scheme::accumulate, .method = Method::average_acceleration}, 2, 1);
  both("pulse", {.scheme = Scheme::accumulate, .method = Method::pulse}, 1, 1);
  both("symplectic Euler", {.scheme = Scheme::accumulate, .method = Method::symplectic_euler}, 1, 1);
  both("axis at the start", {.scheme = Scheme::accumulate, .axis = PairAxis::start}, 1, 1);

  Scene pendulum = scene_of({gravity});
  pendulum.fixed = {0};
  pendulum.add(Distance{.pairs = {{0, 1}, {1, 2}}});
  check_claim({"rods", pendulum, start, 128}, 2);
}

}  // namespace dvdx::test::accuracy_test
