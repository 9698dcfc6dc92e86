// Meshes as contacts: the bits on every instruction set, changes of a plan, and refusals.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "dvdx/plan.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/triangle_meshes.hpp"
#include "math/vec3.hpp"
#include "support/batch.hpp"

namespace triangle_meshes::plan_test {

using test::plan_of;
using test::stepped;

TEST_CASE("meshes: the bits are the scalar twin's on every instruction set, in every block, at rest and moving") {
  const std::size_t count = 90;
  const auto scene_of = [&](int variant) {
    Joined joined = cloud(count);
    TriangleMesh ball = touched(ball_of_triangles({0.1, -0.2, 0}, 0.4, 1));
    ball.cell = 0.1;
    joined.scene.add(ball);
    TriangleMesh box = touched(box_of_triangles({-0.5, -0.3, 0.2}, {0.2, 0.1, 0.3}));
    box.cell = 0.08;
    box.thickness = 0.02;
    if (variant == 1) box.sweep = ContactPath::line;
    if (variant == 3) box.response = Response::end_on_surface;
    joined.scene.add(box);
    TriangleMesh angle = touched(angle_of_triangles());
    angle.cell = 0.1;
    for (Vec3& v : angle.vertices) v = {0.3 * v[0], 0.3 * v[1] - 0.5, 0.3 * v[2] - 0.5};
    joined.scene.add(angle);
    joined.scene.add(touched(Plane{.offset = -0.8}));
    if (variant == 1) joined.scene.add(Drag{.coefficient = 0.4, .wind = {0.5, 0, 0}});
    if (variant == 2) joined.scene.add(Spring{.stiffness = 2000.0, .damping = 3});
    if (variant == 3) {
      joined.scene.add(
          Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0.3, 0.2, 0}, .rotation = {0.4, 1, 0}}}});
      for (std::size_t j = 0; j < 2; ++j) std::visit([](auto& c) { c.motion = 0; }, joined.scene.contacts[j]);
    }
    return joined;
  };
  const auto check = [&]<class T>(T, const Joined& joined, Arithmetic arithmetic) {
    const std::size_t steps = 25;
    const auto wanted = stepped<T>(joined, {.arithmetic = arithmetic}, steps);
    for (const Isa isa : available_isas(arithmetic)) {
      for (const std::size_t block : {std::size_t{16}, std::size_t{0}}) {
        test::Batch<T> batch(test::Layout::soa, count);
        place(joined, batch.view());
        const auto plan =
            compile<T>(joined.scene, {.step = joined.step, .isa = isa, .arithmetic = arithmetic, .block = block}, batch.view());
        REQUIRE(plan.has_value());
        REQUIRE(plan->step(batch.view(), steps) == StepResult::done);
        const std::string difference = test::difference(wanted, test::values_of(batch.view()));
        CHECK_MESSAGE(difference == "", name(isa) << ", block " << block << ": " << difference);
      }
    }
  };
  for (int variant = 0; variant < 4; ++variant) {
    CAPTURE(variant);
    const Joined joined = scene_of(variant);
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      check(float{}, joined, arithmetic);
      check(double{}, joined, arithmetic);
    }
  }
}

TEST_CASE("meshes: a plan that changes acts as one compiled anew") {
  Joined joined = cloud(64);
  TriangleMesh ball = touched(ball_of_triangles({0.1, -0.2, 0}, 0.4, 2));
  ball.cell = 0.1;
  joined.scene.add(ball);
  const auto run = [&](auto&& change, const Joined& of) {
    test::Batch<double> batch(test::Layout::soa, 64);
    place(joined, batch.view());
    auto plan = test::plan_of(of, {}, batch.view());
    change(plan);
    REQUIRE(plan.step(batch.view(), 40) == StepResult::done);
    return test::values_of(batch.view());
  };
  const auto none = [](auto&) {};
  TriangleMesh other = ball;
  other.restitution = 0.9;
  Joined wanted = joined;
  wanted.scene.contacts[0] = other;
  CHECK(test::difference(run(none, wanted), run([&](auto& plan) { REQUIRE(plan.set_contact(0, Contact(other))); }, joined)) ==
        "");
  other.vertices = ball_of_triangles({0.3, -0.2, 0}, 0.4, 2).vertices;
  wanted.scene.contacts[0] = other;
  CHECK(test::difference(run(none, wanted), run([&](auto& plan) { REQUIRE(plan.set_contact(0, Contact(other))); }, joined)) ==
        "");
  wanted = joined;
  wanted.step = joined.step / 2;
  CHECK(test::difference(run(none, wanted), run([&](auto& plan) { REQUIRE(plan.set_step(wanted.step)); }, joined)) == "");
}

TEST_CASE("meshes: a mesh that bounds no body is refused, and so is a cell out of range") {
  const auto refusal = [](TriangleMesh mesh) {
    Scene scene;
    scene.add(std::move(mesh));
    const auto plan = compile<float>(scene, {.step = 0.01});
    return plan.has_value() ? std::string() : plan.error().message();
  };
  const TriangleMesh box = box_of_triangles({0.1, -0.5, 0}, {2, 0.5, 2});
  const std::string closed = ": must be a closed surface, each edge of it between two triangles, with faces turned outwards";
  CHECK(refusal(box).empty());
  TriangleMesh other = box;
  other.triangles.pop_back();
  CHECK(refusal(other) == "contacts[0].triangles is of an edge that only one triangle has" + closed);
  other = box;
  std::swap(other.triangles[4][0], other.triangles[4][1]);
  CHECK(refusal(other) == "contacts[0].triangles is of an edge that two triangles have in the same direction" + closed);
  other = box;
  for (auto& t : other.triangles) std::swap(t[0], t[1]);
  CHECK(refusal(other) == "contacts[0].triangles is turned inwards" + closed);
  other = box;
  other.triangles[3][2] = 8;
  CHECK(refusal(other) == "contacts[0].triangles is of a vertex that is not there: must be numbers below 8");
  other = box;
  other.vertices[2] = other.vertices[0];
  CHECK(refusal(other) == "contacts[0].triangles is of a triangle without area" + closed);
  other = box;
  other.triangles.clear();
  CHECK(refusal(other) == "contacts[0].triangles is empty" + closed);
  // Two boxes that touch in opposite corners.
  other = box;
  const TriangleMesh beside = box_of_triangles({4.1, 0.5, 4}, {2, 0.5, 2});
  for (const Vec3& v : beside.vertices) other.vertices.push_back(v);
  for (const auto& [a, b, c] : beside.triangles) other.triangles.push_back({a + 8, b + 8, c + 8});
  CHECK(refusal(other).empty());
  for (auto& t : other.triangles) std::replace(t.begin(), t.end(), std::uint32_t{8}, std::uint32_t{7});
  CHECK(refusal(other) == "contacts[0].triangles is of surfaces that meet in a vertex alone" + closed);
  other = box;
  other.vertices[5][1] = NAN;
  CHECK(refusal(other) == "contacts[0].vertices[5][1] is nan: must be a finite number");
  for (const double cell : {-0.1, 0.001, 0.6}) {
    other = box;
    other.cell = cell;
    const std::string words = refusal(other);
    CHECK_MESSAGE(words.find("contacts[0].cell is ") == 0, words);
    if (cell > 0) {
      CHECK_MESSAGE(words.find(": must be from 0.0102") != std::string::npos, words);
      CHECK_MESSAGE(
          words.find("at most 16777216 nodes) to half the shortest side with its thickness, 0.5") != std::string::npos, words);
    }
  }
}

}  // namespace triangle_meshes::plan_test
