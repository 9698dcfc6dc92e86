// The claims of `explain` about accuracy and stability. accuracy_test.cpp measures whether the orders are true.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "dvdx/constrain.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"

namespace dvdx::test::explain_accuracy_test {

std::string words(const Scene& scene, double step = 1.0 / 60) {
  const auto plan = compile<double>(scene, {.step = step, .isa = Isa::reference});
  REQUIRE(plan.has_value());
  return plan->explain();
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

const std::string exact = "exact for any step";
const Constant gravity{.acceleration = {0, -9.81, 0}};

TEST_CASE("explain: one linear system is exact for any step, and stable") {
  Scene scene;
  scene.add(gravity).add(Spring{.stiffness = 40.0}).add(Drag{.coefficient = 0.5});
  CHECK(says(words(scene), "accuracy     exact for any step\n"));
  CHECK(says(words(scene), "stability    stable at any step\n"));
}

TEST_CASE("explain: stiff radial springs are of second order, and unstable where their kicks add up") {
  Scene scene;
  for (int i = 0; i < 3; ++i) {
    scene.add(RadialSpring{.stiffness = 900.0, .anchor = Vec3{0, 0, 0}, .rest_length = 1.0});
  }
  // z = 30 h for each spring. Three kicks together amount to 12 sin^2(z/2), which exceeds 4 from z = 1.23 on.
  const std::string slow = words(scene, 0.03);
  CHECK_FALSE(says(slow, exact));
  CHECK(says(slow, "accuracy     order 2 in the step\n"));
  CHECK(says(slow, "highest frequency x step is 0.9;"));
  CHECK(says(slow, ": stable\n"));
  const std::string fast = words(scene, 0.05);
  CHECK(says(fast, "highest frequency x step is 1.5;"));
  CHECK(says(fast, "UNSTABLE"));
  CHECK(says(fast, "a step of at most 0.0410"));
  // The claim is true: near the rest length a particle diverges at one step and not at the other.
  for (const double step : {0.03, 0.05}) {
    Batch<double> batch(Layout::soa, 1);
    batch.view().x[0][0] = 1.001;
    const auto plan = compile<double>(scene, {.step = step, .isa = Isa::reference});
    REQUIRE(plan->step(batch.view(), 12) == StepResult::done);
    CHECK((std::abs(batch.view().x[0][0] - 1) > 0.1) == (step == 0.05));
  }
}

TEST_CASE("explain: forces of time alone are exact by the exact method, and of order 1 by pulse and symplectic Euler") {
  for (const Method method : {Method::pulse, Method::symplectic_euler}) {
    Scene scene;
    scene.method = method;
    scene.add(gravity).add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 3});
    CHECK_FALSE(says(words(scene), exact));
    CHECK(says(words(scene), "accuracy     order 1 in the step\n"));
    CHECK(says(words(scene), "             forces[0] is "));
    scene.method = Method::exact;
    CHECK(says(words(scene), exact));
  }
}

TEST_CASE("explain: contacts are exact under linear forces, and not beside radial springs") {
  Scene scene;
  scene.add(gravity).add(Plane{.restitution = 0.5});
  CHECK(says(words(scene), "accuracy     exact for any step\n"));
  CHECK(says(words(scene), "as long as no particle has more than 32 impacts in a step"));
  CHECK_FALSE(says(words(scene), "on a sphere"));
  scene.add(Sphere{.center = {0, -3, 0}});
  CHECK(says(words(scene), "what slides on a sphere is of order 1"));
  scene.add(Spring{.stiffness = 4.0}).add(Drag{.coefficient = 0.1});
  CHECK(says(words(scene), "accuracy     exact for any step\n"));
  scene.add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 3});
  CHECK(says(words(scene), "order 5 in the step\n             contacts[0, 1]: impacts are looked for on the cubic"));
  scene.add(RadialSpring{.stiffness = 4.0, .damping = 0.1, .rest_length = 1.0});
  CHECK(says(words(scene), "order 1 in the step\n             contacts[0, 1]: what damps"));
}

TEST_CASE("explain: contacts of one law are told of in one line, with their numbers") {
  Scene scene;
  scene.add(gravity);
  for (std::size_t i = 0; i < 9; ++i) {
    scene.add(Capsule{.ends = {{{0, -1.0 * static_cast<double>(i), 0}, {1, 0, 0}}},
                      .friction = i == 1 || (i > 2 && i < 7) ? 0.5 : 0.0,
                      .response = i == 8 ? Response::end_on_surface : Response::resume});
  }
  CHECK(says(words(scene),
             "order 1 in the step\n"
             "             contacts[8] ends the step of an impact on the surface (response seed)\n"
             "             contacts[1, 3 to 6] take the direction of friction from the ends of steps\n"
             "             as long as"));
}

TEST_CASE("explain: a mesh is listed with its nodes, its bytes and the rounding of its edges") {
  Scene scene;
  scene.add(gravity).add(Plane{});
  CHECK_FALSE(says(words(scene), "meshes"));
  scene.add(TriangleMesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}},
                         .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
                         .cell = 0.125});
  // 8, 8 and 16 cells, with 3 added on each side.
  CHECK(says(words(scene),
             "meshes       contacts[1]: 16 x 16 x 24 nodes, 49152 bytes, cells of 0.125 m: edges are rounded by up to"));
  CHECK(says(words(scene), "and what slides on a mesh is of order 1"));
}

TEST_CASE("explain: networks and constraints are of their scheme's order") {
  Joined sheet = test::sheet(9, 9, 50, 0.001);
  const auto of = [&] {
    Batch<double> batch(Layout::soa, sheet.x.size());
    place(sheet, batch.view());
    const auto plan = compile<double>(sheet.scene, {.step = sheet.step, .isa = Isa::reference}, batch.view());
    REQUIRE(plan.has_value());
    return plan->explain();
  };
  CHECK_FALSE(says(of(), exact));
  CHECK(says(of(), " in the step\n"));
  CHECK(says(of(), "without what joins it to others"));
  CHECK(says(of(), "frequency x sub-step is "));
}

}  // namespace dvdx::test::explain_accuracy_test
