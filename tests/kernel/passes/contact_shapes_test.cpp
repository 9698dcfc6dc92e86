// Capsules, boxes and convex bodies, compared with planes and spheres, closed forms and the scalar twin.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/falling_cloud.hpp"
#include "kernel/passes/joined_run.hpp"
#include "math/rotation.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace contact_shapes_test {

using namespace dvdx;
using test::cloud;
using test::gravity;
using test::Joined;
using test::stepped;
using test::touched;

Convex cube(const Vec3& center, const Vec3& half) {
  Convex convex;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      Face face{.normal = {}, .offset = side * center[axis] + half[axis]};
      face.normal[axis] = side;
      convex.planes.push_back(face);
    }
  }
  return convex;
}

// Every body besides a plane and a sphere, all within the volume that a cloud falls through.
void add_bodies(Scene& scene) {
  scene.add(touched(Plane{.offset = -1}));
  scene.add(touched(Sphere{.center = {0.6, 0.1, 0.5}, .radius = 0.2, .thickness = 0.05}));
  scene.add(touched(Capsule{.ends = {{{-0.6, 0, -0.5}, {0.4, 0.2, -0.6}}}, .radius = {0.2, 0.1}}));
  scene.add(touched(Capsule{.ends = {{{-0.5, -0.4, 0.6}, {-0.5, 0.3, 0.4}}}, .radius = {0.15, 0.15}, .thickness = 0.02}));
  scene.add(touched(OrientedBox{.center = {0.5, -0.4, -0.1}, .half_extents = {0.3, 0.2, 0.25}, .rotation = {0.3, 0.2, -0.4}}));
  scene.add(touched(
      OrientedBox{.center = {-0.6, -0.5, 0}, .half_extents = {0.2, 0.1, 0.2}, .sweep = ContactPath::line, .thickness = 0.03}));
  scene.add(touched(OrientedBox{.half_extents = {1.2, 1.5, 1.3}, .rotation = {0, 0.2, 0}, .side = Side::inside}));
  Convex wedge = cube({0, -0.6, 0.1}, {0.2, 0.3, 0.2});
  wedge.planes.push_back({.normal = {1, 1, 1}, .offset = -0.2});
  wedge.response = Response::end_on_surface;
  scene.add(touched(wedge));
}

template <class T>
double furthest(const std::vector<T>& a, const std::vector<T>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
  }
  return most;
}

std::vector<double> after(const Joined& cloud, const Contact& contact, std::size_t steps) {
  Joined joined = cloud;
  joined.scene.add(contact);
  return stepped<double>(joined, {.isa = best_isa()}, steps);
}

// The state of one particle.
struct Point {
  Vec3 x, v;
};

Point thrown(const Contact& contact, const Vec3& x, const Vec3& v, double h, const Vec3& acceleration = {}) {
  Joined joined;
  joined.name = "one";
  joined.step = h;
  joined.x = {x};
  joined.v = {v};
  joined.scene.add(Constant{.acceleration = acceleration});
  joined.scene.add(contact);
  const auto values = stepped<double>(joined, {.isa = best_isa()}, 1);
  return {{values[0], values[1], values[2]}, {values[3], values[4], values[5]}};
}

TEST_CASE("bodies: a capsule of equal ends is a sphere, and so is one that its larger end holds") {
  const Joined of = cloud(300);
  const Vec3 center{0.1, -0.2, 0.05};
  const auto sphere = after(of, touched(Sphere{.center = center, .radius = 0.4}), 60);
  CHECK(furthest(sphere, after(of, touched(Capsule{.ends = {{center, center}}, .radius = {0.4, 0.4}}), 60)) < 1e-9);
  const Capsule swallowed{.ends = {{center, {0.1, 0.05, 0.05}}}, .radius = {0.4, 0.1}};
  CHECK(furthest(sphere, after(of, touched(swallowed), 60)) < 1e-9);
  CHECK(furthest(sphere, after(of, touched(Sphere{.center = center, .radius = 0.3, .thickness = 0.1}), 60)) < 1e-9);
}

TEST_CASE("bodies: the faces of a large box and of a convex body act as a plane") {
  Joined of = cloud(300);
  for (Vec3& x : of.x) x[1] += 0.5;  // none of them starts inside
  const Vec3 rotation{0.1, 0, 0.2};
  const Vec3 normal = turned(quaternion(rotation), {0, 1, 0});
  const auto plane = after(of, touched(Plane{.normal = normal, .offset = -0.5}), 90);
  const OrientedBox box{.center = scaled(normal, -3), .half_extents = {20, 2.5, 20}, .rotation = rotation};
  CHECK(furthest(plane, after(of, touched(box), 90)) < 1e-9);
  const OrientedBox thick{
      .center = scaled(normal, -3), .half_extents = {20, 2.25, 20}, .rotation = rotation, .thickness = 0.25};
  CHECK(furthest(plane, after(of, touched(thick), 90)) < 1e-9);
  Convex body = cube({}, {40, 40, 40});
  body.planes.push_back({.normal = scaled(normal, 3), .offset = -0.5});
  CHECK(furthest(plane, after(of, touched(body), 90)) < 1e-9);
  body.planes.back().offset = -0.7;
  body.thickness = 0.2;
  CHECK(furthest(plane, after(of, touched(body), 90)) < 1e-9);
  CHECK(furthest(plane, after(of, touched(Plane{.normal = normal, .offset = -0.8, .thickness = 0.3}), 90)) < 1e-9);
}

TEST_CASE("bodies: a convex cube is a box") {
  const Joined of = cloud(400);
  const Vec3 center{0.1, -0.4, 0};
  const Vec3 half{0.5, 0.3, 0.4};
  const auto box = after(of, touched(OrientedBox{.center = center, .half_extents = half}), 60);
  CHECK(furthest(box, after(of, touched(cube(center, half)), 60)) < 1e-9);
  CHECK(furthest(box, after(of, touched(Plane{.offset = -100}), 60)) > 0.1);
}

TEST_CASE("bodies: the inside of a box is six planes") {
  const Joined of = cloud(300);
  Joined planes = of;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      Plane plane{.offset = -1.1};
      plane.normal = {};
      plane.normal[axis] = side;
      planes.scene.add(touched(plane));
    }
  }
  const OrientedBox box{.half_extents = {1.25, 1.25, 1.25}, .side = Side::inside, .thickness = 0.15};
  CHECK(furthest(stepped<double>(planes, {.isa = best_isa()}, 60), after(of, touched(box), 60)) < 1e-9);
}

TEST_CASE("bodies: a throw hits a cylinder, a cone and a box's edge where their formulas have them") {
  // A cylinder of radius 0.5 about the y axis, hit from z = 2 along -z at x = 0.3.
  const Capsule cylinder{.ends = {{{0, -10, 0}, {0, 10, 0}}}, .radius = {0.5, 0.5}, .restitution = 1};
  const double z = 0.4;  // sqrt(0.25 - 0.09)
  const Vec3 n{0.6, 0, 0.8};
  const Point end = thrown(cylinder, {0.3, 1, 2}, {0, 0.5, -4}, 1);
  const double t = (2 - z) / 4;
  const Vec3 v{2 * 4 * n[2] * n[0], 0.5, -4 + 2 * 4 * n[2] * n[2]};
  CHECK(test::is_close(end.x[0], 0.3 + (1 - t) * v[0], 1e-12));
  CHECK(test::is_close(end.x[1], 1.5, 1e-12));
  CHECK(test::is_close(end.x[2], z + (1 - t) * v[2], 1e-12));
  CHECK(test::is_close(end.v[0], v[0], 1e-12));

  // The hull of spheres of radii 1 and 2, 4 m apart: sin a = 1/4, rho cos a = 1 + z sin a.
  const Capsule cone{.ends = {{{}, {0, 0, 4}}}, .radius = {1, 2}, .friction = std::numeric_limits<double>::infinity()};
  const Point stuck = thrown(cone, {3, 0, 2}, {-8, 0, 0}, 1);
  CHECK(test::is_close(stuck.x[0], (1 + 2 * 0.25) / std::sqrt(1 - 0.0625), 1e-12));
  CHECK(std::abs(stuck.x[2] - 2) < 1e-12);
  CHECK(std::abs(stuck.v[0]) < 1e-12);

  // A rounded edge: thickness 0.1 about the edge (1, 1) of a box, hit from above at x = 1.06.
  const OrientedBox box{.half_extents = {1, 1, 1}, .restitution = 1, .thickness = 0.1};
  const Point off = thrown(box, {1.06, 3.08, 0}, {0, -2, 0}, 2);
  CHECK(test::is_close(off.x[1], 1.08 + (-2 + 2 * 2 * 0.8 * 0.8) * 1, 1e-12));
  CHECK(test::is_close(off.x[0], 1.06 + 2 * 2 * 0.8 * 0.6, 1e-12));

  // Past the corner of a box without thickness, nothing is hit.
  const Point past = thrown(OrientedBox{.half_extents = {1, 1, 1}}, {1.05, 3, 0}, {0, -2, 0}, 2);
  CHECK(past.x == Vec3{1.05, -1, 0});
  // A parabola passes over the edge and falls onto the next face within a step.
  const Point over = thrown(OrientedBox{.half_extents = {1, 1, 1}}, {-1.5, 0.5, 0}, {1, 4, 0}, 1, {0, -8, 0});
  CHECK(test::is_close(over.x[1], 1, 1e-12));
}

TEST_CASE("bodies: paths bent by springs and drag meet bodies as they meet a sphere and a plane") {
  Joined of = cloud(200);
  of.scene.add(Spring{.stiffness = 60.0, .damping = 0.5, .anchor = Vec3{0, -1, 0}});
  of.scene.add(Drag{.coefficient = 0.3, .wind = {1, 0, 0}});
  const Vec3 center{0, -0.8, 0};
  const auto sphere = after(of, touched(Sphere{.center = center, .radius = 0.5}), 60);
  CHECK(furthest(sphere, after(of, touched(Capsule{.ends = {{center, center}}, .radius = {0.5, 0.5}}), 60)) < 1e-9);
  // A plane finds dips that end outside their first step by their lowest point, bodies find them by the first guess.
  const auto plane = after(of, touched(Plane{.offset = -0.4}), 60);
  CHECK(furthest(plane, after(of, touched(OrientedBox{.center = {0, -10.4, 0}, .half_extents = {50, 10, 50}}), 60)) < 5e-3);
}

TEST_CASE_TEMPLATE("bodies: a particle rests on a box's face and on a capsule, and friction holds it", T, float, double) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Vec3 rotation{0, 0, 0.3};
  const std::vector<Contact> contacts = {
      OrientedBox{.center = {0, -1, 0}, .half_extents = {3, 1, 3}, .friction = 0.2},
      OrientedBox{.center = {0, -1, 0}, .half_extents = {3, 1, 3}, .rotation = rotation, .friction = 0.5},
      OrientedBox{.center = {0, -1, 0}, .half_extents = {3, 0.9, 3}, .rotation = rotation, .friction = 0.5, .thickness = 0.1},
      Capsule{.ends = {{{-3, -1, 0}, {3, -1, 0}}}, .radius = {1, 1}, .friction = 0.2},
      Capsule{.ends = {{{-3, -1, 0}, {3, -1, 0}}}, .radius = {1, 1.5}, .friction = infinity}};
  for (const Contact& contact : contacts) {
    Joined joined;
    joined.name = "rest on " + std::to_string(contact.index());
    for (const double x : {-0.5, 0.0, 0.25}) joined.x.push_back({x, 0.9, 0});
    joined.v.resize(3);
    joined.scene.add(Constant{.acceleration = gravity});
    joined.scene.add(contact);
    const auto settled = stepped<T>(joined, {.isa = best_isa()}, 600);
    const auto later = stepped<T>(joined, {.isa = best_isa()}, 10600);
    CHECK_MESSAGE(furthest(settled, later) < 40 * double{std::numeric_limits<T>::epsilon()},
                  joined.name << ": " << furthest(settled, later));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 3; k < 6; ++k) CHECK(later[6 * i + k] == 0);
    }
  }
}

TEST_CASE("bodies: a scene that moves at one velocity acts as at rest, apart from the way travelled") {
  for (const double drag : {0.0, 0.4}) {
    Joined still = cloud(100);
    still.scene.add(touched(Capsule{.ends = {{{-0.6, 0, -0.5}, {0.4, 0.2, -0.6}}}, .radius = {0.2, 0.1}}));
    still.scene.add(touched(OrientedBox{.center = {0.1, -1, 0}, .half_extents = {1, 0.2, 1}, .rotation = {0.1, 0.2, -0.15}}));
    test::check_in_moving_frame(still, drag);
  }
}

// The distance from a body centred at the origin.
double distance_to(const Contact& contact, const Vec3& y) {
  if (const auto* sphere = std::get_if<Sphere>(&contact)) return length(y) - sphere->radius;
  if (const auto* box = std::get_if<OrientedBox>(&contact)) {
    double most = -1e9;
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(y[k]) - box->half_extents[k]);
    return most;
  }
  const auto& capsule = std::get<Capsule>(contact);
  const double end = capsule.ends[1][0];
  return length({y[0] - std::clamp(y[0], -end, end), y[1], y[2]}) - capsule.radius[0];
}

TEST_CASE("bodies: swept at 20 m/s and turned at 30 rad/s through resting particles they leave none inside, and pass none") {
  constexpr double seconds = 0.2;
  constexpr double inscribed = 0.06;
  const std::vector<Contact> bodies = {Sphere{.radius = 0.1},
                                       Capsule{.ends = {{{-0.2, 0, 0}, {0.2, 0, 0}}}, .radius = {0.06, 0.06}},
                                       OrientedBox{.half_extents = {0.2, 0.06, 0.1}}};
  const auto check = [&]<class T>(T, const Contact& contact, double h, Isa isa, std::size_t count) {
    Joined joined;
    joined.name = "swept " + std::to_string(contact.index());
    joined.step = h;
    for (std::size_t i = 0; i < count; ++i) {
      joined.x.push_back({0.35 * test::scatter(i, 0), 0.35 * test::scatter(i, 1), 1.6 + 1.3 * test::scatter(i, 2)});
    }
    joined.v.resize(count);
    Contact body = contact;
    std::visit([](auto& c) { c.motion = 0; }, body);
    joined.scene.add(body);
    Motion motion{.center = {}, .keys = {}};
    const double turn = 30 / std::sqrt(3.0);
    for (int k = 0; k <= 4; ++k) {
      const double t = seconds * k / 4;
      motion.keys.push_back({.time = t, .translation = {0, 0, -0.5 + 20 * t}, .rotation = {turn * t, turn * t, turn * t}});
    }
    joined.scene.add(motion);
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
        inside += static_cast<std::size_t>(length(r) < 0.3 && distance_to(contact, turned(back, r)) < -1e-5);
        const bool was_in_the_way =
            std::hypot(joined.x[i][0], joined.x[i][1]) < 0.999 * inscribed && joined.x[i][2] < -0.5 + 20 * t;
        passed += static_cast<std::size_t>(was_in_the_way && double{batch.view().v[2][i]} == 0);
      }
      CHECK_MESSAGE(inside == 0, joined.name << ", h " << h << ", " << 8 * sizeof(T) << " bits, step " << n << ": " << inside);
      CHECK(passed == 0);
    }
  };
  for (const Contact& contact : bodies) {
    for (const double h : {1.0 / 30, 1.0 / 120}) {
      for (const Isa isa : available_isas()) {
        check(float{}, contact, h, isa, isa == best_isa() ? 2000 : 200);
        check(double{}, contact, h, isa, isa == best_isa() ? 2000 : 200);
      }
    }
  }
}

TEST_CASE("bodies: the bits are the scalar twin's on every instruction set, in every layout, block and thread") {
  const std::size_t count = 150;
  const auto scene_of = [&](int variant) {
    Joined joined = cloud(count);
    add_bodies(joined.scene);
    if (variant == 1) joined.scene.add(Drag{.coefficient = 0.4, .wind = {0.5, 0, 0}});
    if (variant == 2) joined.scene.add(Spring{.stiffness = 2000.0, .damping = 3});
    if (variant == 3) {
      joined.scene.add(Sinusoid{.acceleration = {3, 2, 0}, .angular_frequency = 9});
      std::vector<double> masses;
      for (std::size_t i = 0; i < count; ++i) masses.push_back(1.25 + 0.75 * test::scatter(i, 6));
      joined.scene.mass = Scalars(masses);
      joined.scene.add(Drag{.coefficient = 0.4});
    }
    return joined;
  };
  const auto check = [&]<class T>(T, int variant, Arithmetic arithmetic) {
    const Joined joined = scene_of(variant);
    const std::size_t steps = 25;
    const auto wanted = stepped<T>(joined, {.arithmetic = arithmetic}, steps);
    std::size_t turn = 0;
    for (const Isa isa : available_isas(arithmetic)) {
      for (const std::size_t block : {std::size_t{16}, std::size_t{64}, std::size_t{0}}) {
        const test::Layout layout = test::layouts[turn++ % test::layouts.size()];
        test::Batch<T> batch(layout, count);
        place(joined, batch.view());
        auto plan =
            compile<T>(joined.scene, {.step = joined.step, .isa = isa, .arithmetic = arithmetic, .block = block}, batch.view());
        REQUIRE(plan.has_value());
        test::Threads workers(1 + turn % 3);
        REQUIRE(plan->step(batch.view(), steps, workers.parallel_for()) == StepResult::done);
        const std::string difference = test::difference(wanted, test::values_of(batch.view()));
        CHECK_MESSAGE(difference == "", name(isa) << ", variant " << variant << ", block " << block << ": " << difference);
      }
    }
  };
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (int variant = 0; variant < 4; ++variant) {
      check(float{}, variant, arithmetic);
      check(double{}, variant, arithmetic);
    }
  }
}

TEST_CASE("bodies: moving bodies have the scalar twin's bits, too") {
  Joined joined = cloud(200);
  add_bodies(joined.scene);
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 16, .translation = {1, 2, 0.5}}}});
  joined.scene.add(
      Motion{.center = {0, 1, 0},
             .keys = {{.time = 0}, {.time = 0.1, .rotation = {0.4, 0.2, 0.6}}, {.time = 1, .translation = {0, 0.4, 0.2}}}});
  for (std::size_t j = 1; j < joined.scene.contacts.size(); ++j) {
    std::visit([&](auto& c) { c.motion = j % 2; }, joined.scene.contacts[j]);
  }
  const auto check = [&]<class T>(T) {
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      const auto wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 30);
      for (const Isa isa : available_isas(arithmetic)) {
        CHECK(test::difference(wanted, stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic}, 30)) == "");
      }
    }
  };
  check(float{});
  check(double{});
}

TEST_CASE("bodies: a particle that is not a number stays alone") {
  Joined joined = cloud(64);
  add_bodies(joined.scene);
  const auto wanted = stepped<float>(joined, {.isa = best_isa()}, 30);
  joined.x[21][1] = std::nan("");
  joined.v[40][0] = INFINITY;
  const auto got = stepped<float>(joined, {.isa = best_isa()}, 30);
  for (std::size_t i = 0; i < 64; ++i) {
    if (i == 21 || i == 40) continue;
    for (std::size_t k = 0; k < 6; ++k) CHECK(got[6 * i + k] == wanted[6 * i + k]);
  }
}

TEST_CASE("bodies: a plan whose contact is replaced steps as one compiled with it") {
  Joined joined = cloud(100);
  add_bodies(joined.scene);
  const Contact replacements[] = {Capsule{.ends = {{{0, 0, 0}, {0.5, 0, 0}}}, .radius = {0.3, 0.2}},
                                  OrientedBox{.half_extents = {0.3, 0.3, 0.3}},
                                  OrientedBox{.half_extents = {1.1, 1.6, 1.4}, .side = Side::inside},
                                  cube({0, 0, 0}, {0.2, 0.2, 0.3}), Plane{.offset = -0.9}};
  for (std::size_t index = 0; index < joined.scene.contacts.size(); ++index) {
    for (const Contact& contact : replacements) {
      test::Batch<double> changed(test::Layout::soa, joined.x.size());
      place(joined, changed.view());
      auto plan = test::plan_of(joined, {.isa = best_isa()}, changed.view());
      REQUIRE(plan.set_contact(index, contact).has_value());
      REQUIRE(plan.step(changed.view(), 20) == StepResult::done);
      Joined other = joined;
      other.scene.contacts[index] = contact;
      CHECK(test::difference(stepped<double>(other, {.isa = best_isa()}, 20), test::values_of(changed.view())) == "");
    }
  }
}

TEST_CASE("bodies: wrong bodies are refused by name") {
  const auto refusal = [](const Contact& contact) {
    Scene scene;
    scene.add(contact);
    const auto plan = compile<float>(scene, {.step = 0.01});
    return plan.has_value() ? std::string() : plan.error().message();
  };
  CHECK(refusal(Capsule{.ends = {}, .radius = {1, 0}}) == "contacts[0].radius[1] is 0: must be a finite number > 0");
  CHECK(refusal(Capsule{.ends = {{{}, {0, NAN, 0}}}}) == "contacts[0].ends[1][1] is nan: must be a finite number");
  CHECK(refusal(OrientedBox{.half_extents = {1, -1, 1}}) == "contacts[0].half_extents[1] is -1: must be a finite number > 0");
  CHECK(refusal(OrientedBox{.rotation = {0, 0, INFINITY}}) == "contacts[0].rotation[2] is inf: must be a finite number");
  CHECK(refusal(OrientedBox{.half_extents = {2, 1, 2}, .side = Side::inside, .thickness = 1}) ==
        "contacts[0].thickness is 1: must be less than the least half extent, 1 m");
  CHECK(refusal(Sphere{.radius = 2, .side = Side::inside, .thickness = 2.5}) ==
        "contacts[0].thickness is 2.5: must be less than the radius, 2 m");
  CHECK(refusal(Plane{.thickness = -1}) == "contacts[0].thickness is -1: must be a finite number >= 0");
  Convex convex = cube({}, {1, 1, 1});
  CHECK(refusal(convex).empty());
  convex.planes.pop_back();
  CHECK(refusal(convex) == "contacts[0].planes is planes that bound no body: must be planes around a body of finite size");
  convex.planes.push_back({.normal = {0, 0, -1}, .offset = -3});
  CHECK(refusal(convex) ==
        "contacts[0].planes is planes that no body is behind: must be planes with normals outwards, and a body behind all");
  convex.planes.resize(3);
  CHECK(refusal(convex) == "contacts[0].planes is 3 planes: must be 4 to 64");
  convex.planes.assign(5, {.normal = {0, 0, 0}, .offset = 1});
  CHECK(refusal(convex) == "contacts[0].planes[0].normal is [0, 0, 0]: must be a vector of finite length > 0");
  CHECK(refusal(OrientedBox{.half_extents = {1e25, 1, 1}}).find("(the plan is of float32)") != std::string::npos);
  Scene many;
  for (int i = 0; i < 4097; ++i) many.add(Plane{});
  CHECK(compile<float>(many, {.step = 0.01}).error().message() == "contacts is 4097 contacts: must be at most 4096");
}

}  // namespace contact_shapes_test
