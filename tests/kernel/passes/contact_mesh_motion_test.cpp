// Meshes as contacts: particles at rest on them, and moving meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "dvdx/plan.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/triangle_meshes.hpp"
#include "math/rotation.hpp"
#include "math/vec3.hpp"
#include "scene/signed_distance.hpp"
#include "support/batch.hpp"

namespace triangle_meshes::motion_test {

using test::plan_of;
using test::Run;
using test::stepped;

TEST_CASE_TEMPLATE("meshes: a particle rests on a face, friction holds it there, and on a slope it lies still", T, float,
                   double) {
  for (const Vec3& rotation : {Vec3{}, Vec3{0, 0, 0.3}, Vec3{0.2, 0.1, -0.2}}) {
    TriangleMesh box = box_of_triangles({0, -1, 0}, {1.2, 1, 1.2});
    for (Vec3& v : box.vertices) v = turned(quaternion(rotation), v);
    box.friction = 0.8;
    box.cell = 0.11;
    Joined joined;
    joined.name = "rest on a mesh";
    for (const double x : {-0.5, 0.0, 0.25}) joined.x.push_back({x, 0.9, 0});
    joined.v.resize(3);
    joined.scene.add(Constant{.acceleration = gravity});
    joined.scene.add(box);
    const Run run{.isa = best_isa()};
    const Plan<T> plan = plan_of<T>(joined, run);
    const auto settled = stepped<T>(joined, plan, run, 600);
    const auto later = stepped<T>(joined, plan, run, 1500);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 at{double{later[6 * i]}, double{later[6 * i + 1]}, double{later[6 * i + 2]}};
      CHECK(std::abs(dot(at, turned(quaternion(rotation), {0, 1, 0}))) < (sizeof(T) == 4 ? 1e-5 : 1e-12));
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(std::abs(double{later[6 * i + k]} - double{settled[6 * i + k]}) < (sizeof(T) == 4 ? 1e-5 : 1e-12));
        CHECK(std::abs(later[6 * i + 3 + k]) < (sizeof(T) == 4 ? 1e-5 : 1e-12));
      }
    }
  }
}

TEST_CASE("meshes: a particle that falls into an inward edge stays out of the body and comes to rest") {
  TriangleMesh angle = angle_of_triangles();
  angle.cell = 0.04;
  angle.friction = 0.2;
  const Quaternion turn = quaternion({0, 0, 0.7});
  for (Vec3& v : angle.vertices) v = turned(turn, v);
  Joined joined;
  joined.name = "crease";
  for (std::size_t i = 0; i < 20; ++i) {
    joined.x.push_back(
        turned(turn, {1.3 + 0.2 * test::scatter(i, 0), 1.4 + 0.2 * test::scatter(i, 1), 0.3 * test::scatter(i, 2)}));
  }
  joined.v.resize(20);
  joined.scene.add(Constant{.acceleration = gravity});
  joined.scene.add(angle);
  const SignedDistance exact(angle);
  const Run run{.isa = best_isa()};
  const Plan<double> plan = plan_of<double>(joined, run);
  for (const std::size_t steps : {std::size_t{30}, std::size_t{120}, std::size_t{1200}}) {
    const auto values = stepped<double>(joined, plan, run, steps);
    for (std::size_t i = 0; i < values.size(); i += 6) {
      CHECK(exact.at({values[i], values[i + 1], values[i + 2]}) > -0.25 * angle.cell);
      if (steps == 1200) CHECK(length({values[i + 3], values[i + 4], values[i + 5]}) < 0.05);
    }
  }
}

TEST_CASE("meshes: swept at 20 m/s and turned at 30 rad/s through resting particles they leave none inside, and pass none") {
  constexpr double seconds = 0.2;
  constexpr double inscribed = 0.06;
  const Vec3 half{0.2, 0.06, 0.1};
  TriangleMesh ball = ball_of_triangles({}, 0.1, 2);  // 320 faces
  ball.cell = 0.016;
  TriangleMesh box = box_of_triangles({}, half);
  box.cell = 0.016;
  const auto check = [&]<class T>(T, const TriangleMesh& mesh, bool is_box, double h, Isa isa, std::size_t count) {
    Joined joined;
    joined.name = is_box ? "swept box" : "swept ball";
    joined.step = h;
    for (std::size_t i = 0; i < count; ++i) {
      joined.x.push_back({0.35 * test::scatter(i, 0), 0.35 * test::scatter(i, 1), 1.6 + 1.3 * test::scatter(i, 2)});
    }
    joined.v.resize(count);
    TriangleMesh body = mesh;
    body.motion = 0;
    const double cell = cell_of(body);
    joined.scene.add(body);
    Motion motion{.center = {}, .keys = {}};
    const double turn = 30 / std::sqrt(3.0);
    for (int k = 0; k <= 4; ++k) {
      const double t = seconds * k / 4;
      motion.keys.push_back({.time = t, .translation = {0, 0, -0.5 + 20 * t}, .rotation = {turn * t, turn * t, turn * t}});
    }
    joined.scene.add(motion);
    const SignedDistance exact(mesh);
    test::Batch<T> batch(test::Layout::soa, count);
    place(joined, batch.view());
    const auto plan = test::plan_of(joined, {.isa = isa}, batch.view());
    for (int n = 1; n * h < seconds; ++n) {
      REQUIRE(plan.step(batch.view()) == StepResult::done);
      const double t = n * h;
      const Quaternion back = conjugate(quaternion({turn * t, turn * t, turn * t}));
      std::size_t inside = 0;
      std::size_t passed = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3 r{double{batch.view().x[0][i]}, double{batch.view().x[1][i]},
                     double{batch.view().x[2][i]} - (-0.5 + 20 * t)};
        // The cells cost this much at an edge. No corner is farther from the middle than 0.24 m.
        inside += static_cast<std::size_t>(length(r) < 0.25 && exact.at(turned(back, r)) < -0.5 * cell);
        const bool was_in_the_way =
            std::hypot(joined.x[i][0], joined.x[i][1]) < 0.95 * inscribed && joined.x[i][2] < -0.5 + 20 * t;
        passed += static_cast<std::size_t>(was_in_the_way && double{batch.view().v[2][i]} == 0);
      }
      CHECK_MESSAGE(inside == 0, joined.name << ", h " << h << ", " << 8 * sizeof(T) << " bits, step " << n << ": " << inside);
      CHECK(passed == 0);
    }
  };
  for (const double h : {1.0 / 30, 1.0 / 120}) {
    for (const Isa isa : available_isas()) {
      const std::size_t count = isa == best_isa() ? 600 : 200;
      check(float{}, ball, false, h, isa, count);
      check(float{}, box, true, h, isa, count);
      check(double{}, ball, false, h, isa, count);
      check(double{}, box, true, h, isa, count);
    }
  }
}

TEST_CASE("meshes: a scene that moves at one velocity acts as at rest, apart from the way travelled") {
  for (const double drag : {0.0, 0.4}) {
    Joined still = cloud(60);
    TriangleMesh ball = touched(ball_of_triangles({0.1, -0.2, 0}, 0.4, 2));
    ball.cell = 0.1;
    still.scene.add(ball);
    TriangleMesh box = touched(box_of_triangles({0.1, -1, 0}, {1, 0.2, 1}));
    box.cell = 0.1;
    still.scene.add(box);
    test::check_in_moving_frame(still, drag);
  }
}

}  // namespace triangle_meshes::motion_test
