// Meshes as contacts: the signed distance of triangles, what its grid costs, against spheres and boxes, the scalar twin.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/joined_run.hpp"
#include "math/rotation.hpp"
#include "math/vec3.hpp"
#include "scene/signed_distance.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace contact_mesh_test {

using namespace dvdx;
using test::Joined;
using test::plan_of;
using test::Run;
using test::stepped;

constexpr Vec3 gravity{0, -9.81, 0};

TriangleMesh box_of_triangles(const Vec3& center, const Vec3& half) {
  TriangleMesh mesh;
  for (std::size_t n = 0; n < 8; ++n) {
    mesh.vertices.push_back({center[0] + ((n & 1) != 0 ? half[0] : -half[0]), center[1] + ((n & 2) != 0 ? half[1] : -half[1]),
                             center[2] + ((n & 4) != 0 ? half[2] : -half[2])});
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// 20 * 4^levels triangles, whose corners are on the sphere.
TriangleMesh ball_of_triangles(const Vec3& center, double radius, int levels) {
  constexpr double t = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) {
        Vec3 v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = (mesh.vertices[a][k] + mesh.vertices[b][k]) / 2;
        mesh.vertices.push_back(v);
      }
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  for (Vec3& v : mesh.vertices) {
    const double scale = radius / length(v);
    for (std::size_t k = 0; k < 3; ++k) v[k] = center[k] + scale * v[k];
  }
  return mesh;
}

// A box of which a quarter is missing along z: an edge that looks inwards.
TriangleMesh angle_of_triangles() {
  TriangleMesh mesh;
  const std::vector<std::array<double, 2>> outline = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {-0.5, 0.5}) {
    for (const auto& [x, y] : outline) mesh.vertices.push_back({x, y, z});
  }
  for (std::uint32_t k = 0; k < 6; ++k) {
    const std::uint32_t next = (k + 1) % 6;
    mesh.triangles.push_back({k, next, next + 6});
    mesh.triangles.push_back({k, next + 6, k + 6});
  }
  for (const auto& [a, b, c] : std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({a + 6, b + 6, c + 6});
    mesh.triangles.push_back({a, c, b});
  }
  return mesh;
}

template <class C>
C touched(C contact) {
  contact.restitution = 0.5;
  contact.friction = 0.3;
  contact.viscosity = 0.1;
  return contact;
}

Joined cloud(std::size_t count) {
  Joined joined;
  joined.name = "cloud";
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({test::scatter(i, 0), 0.3 + 0.7 * test::scatter(i, 1), test::scatter(i, 2)});
    joined.v.push_back({2 * test::scatter(i, 3), test::scatter(i, 4), test::scatter(i, 5)});
  }
  joined.scene.add(Constant{.acceleration = gravity});
  return joined;
}

double distance_to_box(const Vec3& y, const Vec3& half) {
  Vec3 out{};
  double most = -1e9;
  for (std::size_t k = 0; k < 3; ++k) {
    const double q = std::abs(y[k]) - half[k];
    most = std::max(most, q);
    out[k] = std::max(q, 0.0);
  }
  return most > 0 ? length(out) : most;
}

struct Throw {
  Vec3 x, way;
};
struct Hit {
  Vec3 x, n;
};

// Where throws first touch the mesh, and its normal there: from what a bounce leaves of them.
std::vector<Hit> touched_by(TriangleMesh mesh, const std::vector<Throw>& throws) {
  mesh.restitution = 1;
  Joined joined;
  joined.name = "throws";
  joined.step = 1;
  for (const Throw& of : throws) {
    joined.x.push_back(of.x);
    joined.v.push_back(of.way);
  }
  joined.scene.add(Constant{.acceleration = {}});
  joined.scene.add(mesh);
  const auto values = stepped<double>(joined, {.isa = best_isa()}, 1);
  std::vector<Hit> hits;
  for (std::size_t i = 0; i < throws.size(); ++i) {
    const auto& [x, way] = throws[i];
    const double* const after = values.data() + 6 * i;
    const Vec3 change = difference({after[3], after[4], after[5]}, way);
    REQUIRE(length(change) > 0);
    // It ends at x + way + (1 - f) change.
    const double left = dot(difference(difference({after[0], after[1], after[2]}, x), way), change) / dot(change, change);
    hits.push_back({{x[0] + (1 - left) * way[0], x[1] + (1 - left) * way[1], x[2] + (1 - left) * way[2]}, unit(change)});
  }
  return hits;
}

// The distance between the nodes about x, written out as a sum over the cell's corners, m.
double between(const DistanceGrid& grid, const Vec3& x) {
  std::array<std::size_t, 3> at{};
  std::array<double, 3> part{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double cells = (x[k] - grid.center[k] - grid.low[k]) / grid.cell;
    at[k] = static_cast<std::size_t>(cells);
    part[k] = cells - static_cast<double>(at[k]);
  }
  double sum = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t node = 0;
    for (std::size_t k = 3; k-- > 0;) {
      const std::size_t up = corner >> k & 1U;
      weight *= up != 0 ? part[k] : 1 - part[k];
      node = node * grid.nodes[k] + at[k] + up;
    }
    sum += weight * grid.values[node];
  }
  return sum;
}

TEST_CASE("meshes: the signed distance of triangles is that of the box, outside, inside, beside edges and corners") {
  const Vec3 half{0.5, 0.3, 0.2};
  const SignedDistance box(box_of_triangles({}, half));
  for (std::size_t i = 0; i < 1000; ++i) {
    const Vec3 x{test::scatter(i, 0), 0.7 * test::scatter(i, 1), 0.6 * test::scatter(i, 2)};
    CHECK(std::abs(box.at(x) - distance_to_box(x, half)) < 1e-14);
  }
  const SignedDistance ball(ball_of_triangles({1, 2, 3}, 0.5, 3));
  for (std::size_t i = 0; i < 300; ++i) {
    const Vec3 x{1 + test::scatter(i, 0), 2 + test::scatter(i, 1), 3 + test::scatter(i, 2)};
    const double wanted = length(difference(x, {1, 2, 3})) - 0.5;
    // Faces of 1280 triangles lie up to 1.7 mm inside the sphere.
    CHECK(ball.at(x) > wanted - 1e-14);
    CHECK(ball.at(x) < wanted + 2.5e-3);
  }
  // Beside an edge that looks inwards, and beyond its end.
  const SignedDistance angle(angle_of_triangles());
  CHECK(std::abs(angle.at({1.2, 1.3, 0}) - 0.2) < 1e-15);
  CHECK(std::abs(angle.at({0.9, 0.9, 0}) + std::sqrt(0.02)) < 1e-15);
  CHECK(std::abs(angle.at({0.5, 0.8, 0.7}) - 0.2) < 1e-15);
}

// One face of a steep spike is cut into four, so that the triangles about its tip lean to that side.
TEST_CASE("meshes: inside and outside are told apart about sharp edges and a tip, however the faces are cut") {
  const Vec3 tip{0, 4, 0};
  const auto corner = [](double angle) { return Vec3{std::cos(angle), 0, std::sin(angle)}; };
  const double third = 2 * std::numbers::pi / 3;
  TriangleMesh spike;
  spike.vertices = {tip, corner(0), corner(third), corner(2 * third)};
  for (int n = 1; n < 4; ++n) {
    const double part = n / 4.0;
    spike.vertices.push_back({(1 - part) * corner(0)[0] + part * corner(third)[0], 0, part * corner(third)[2]});
  }
  spike.triangles = {{0, 4, 1}, {0, 5, 4}, {0, 6, 5}, {0, 2, 6}, {0, 3, 2},
                     {0, 1, 3}, {3, 1, 4}, {3, 4, 5}, {3, 5, 6}, {3, 6, 2}};
  const SignedDistance distance(spike);
  const auto is_below = [](const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
    return dot(cross(difference(b, a), difference(c, a)), difference(x, a)) < 0;
  };
  std::size_t inside = 0;
  for (std::size_t i = 0; i < 4000; ++i) {
    const double size = i % 2 == 0 ? 1.5 : 0.2;  // about all of it, and about its tip
    const Vec3 middle = i % 2 == 0 ? Vec3{0, 2, 0} : tip;
    const Vec3 x{middle[0] + size * test::scatter(i, 0), middle[1] + 1.6 * size * test::scatter(i, 1),
                 middle[2] + size * test::scatter(i, 2)};
    const bool is_inside = x[1] > 0 && is_below(x, tip, corner(third), corner(0)) &&
                           is_below(x, tip, corner(2 * third), corner(third)) && is_below(x, tip, corner(0), corner(2 * third));
    inside += is_inside ? 1 : 0;
    CAPTURE(i);
    CHECK((distance.at(x) < 0) == is_inside);
  }
  CHECK(inside > 100);
  CHECK(inside < 2000);
}

TEST_CASE("meshes: particles stay as far off a face as it is thick") {
  TriangleMesh box = box_of_triangles({}, {1, 0.5, 1});
  box.thickness = 0.05;
  box.cell = 0.1;
  for (const Hit& hit : touched_by(box, {{{0.1, 3, 0.2}, {0, -6, 0}}, {{0.3, -2, -0.1}, {0, 4, 0}}})) {
    CHECK(test::is_close(std::abs(hit.x[1]), 0.55, 1e-12));
    CHECK(test::is_close(std::abs(hit.n[1]), 1, 1e-12));
  }
}

TEST_CASE("meshes: an impact is where what lies between the nodes is 0, to a millionth of a cell") {
  TriangleMesh ball = ball_of_triangles({}, 0.5, 3);
  ball.cell = 0.1;
  const DistanceGrid grid = sampled(ball);
  std::vector<Throw> throws;
  for (std::size_t i = 0; i < 300; ++i) {
    const Vec3 d = unit({test::scatter(i, 0), test::scatter(i, 1), test::scatter(i, 2)});
    throws.push_back({scaled(d, 0.8), difference(scaled(unit({d[1], d[2], d[0]}), 0.3), scaled(d, 0.7))});
  }
  for (const Hit& hit : touched_by(ball, throws)) CHECK(std::abs(between(grid, hit.x)) < 1e-6 * grid.cell);
}

TEST_CASE("meshes: what starts inside is put where what lies between the nodes is 0, to a millionth of a cell") {
  TriangleMesh ball = ball_of_triangles({}, 0.5, 3);
  ball.cell = 0.1;
  const DistanceGrid grid = sampled(ball);
  Joined joined;
  joined.name = "inside";
  for (std::size_t i = 0; i < 300; ++i) {
    const Vec3 d = unit({test::scatter(i, 0), test::scatter(i, 1), test::scatter(i, 2)});
    joined.x.push_back(scaled(d, 0.5 - 0.05 * (1.2 + test::scatter(i, 3))));
    joined.v.push_back(scaled(d, -0.1));
  }
  joined.scene.add(Constant{.acceleration = {}});
  joined.scene.add(ball);
  for (const Isa isa : {Isa::reference, best_isa()}) {
    const auto values = stepped<double>(joined, {.isa = isa}, 1);
    double most = 0;
    for (std::size_t i = 0; i < values.size(); i += 6) {
      most = std::max(most, std::abs(between(grid, {values[i], values[i + 1], values[i + 2]})));
    }
    CHECK(most < 1e-6 * grid.cell);
  }
}

TEST_CASE(
    "meshes: what is thrown up inside and falls back before it is out has met nothing, and is put on the surface at rest") {
  TriangleMesh box = box_of_triangles({}, {1, 0.5, 1});
  box.restitution = 1;
  box.cell = 0.1;
  Joined joined;
  joined.name = "thrown up inside";
  joined.step = 1.0 / 30;
  joined.x = {{0.1, 0.49, 0.2}, {-0.4, 0.48, 0.3}};
  joined.v = {{0, 0.1, 0}, {0, 0.2, 0}};
  joined.scene.add(Constant{.acceleration = gravity});
  joined.scene.add(box);
  for (const Isa isa : {Isa::reference, best_isa()}) {
    const auto values = stepped<double>(joined, {.isa = isa}, 1);
    for (std::size_t i = 0; i < values.size(); i += 6) {
      CHECK(test::is_close(values[i + 1], 0.5, 1e-12));
      CHECK(std::abs(values[i + 4]) < 1e-12);
    }
  }
}

TEST_CASE("meshes: where a ball of triangles is hit, and its normal, are off by what its cell and its faces cost") {
  constexpr double radius = 0.5;
  // 5120 faces: each lies up to half a millimetre inside the sphere, and is turned against it by up to 0.03 rad.
  constexpr double faces = 6e-4;
  constexpr double facets = 0.03;
  for (const double cell : {0.1, 0.05}) {
    TriangleMesh ball = ball_of_triangles({}, radius, 4);
    ball.cell = cell;
    std::vector<Throw> throws;
    for (std::size_t i = 0; i < 300; ++i) {
      const Vec3 d = unit({test::scatter(i, 0), test::scatter(i, 1), test::scatter(i, 2)});
      throws.push_back({scaled(d, 0.8), scaled(d, -0.7)});
    }
    double place = 0;
    double angle = 0;
    for (const Hit& hit : touched_by(ball, throws)) {
      place = std::max(place, std::abs(length(hit.x) - radius));
      angle = std::max(angle, length(cross(hit.n, unit(hit.x))));
    }
    CHECK_MESSAGE(place < faces + cell * cell / (4 * radius), "cell " << cell << ": " << place << " m");
    CHECK_MESSAGE(place > 0.3 * cell * cell / (4 * radius), "cell " << cell << ": " << place << " m");
    CHECK_MESSAGE(angle < facets + cell / radius, "cell " << cell << ": " << angle << " rad");
  }
}

TEST_CASE("meshes: a box of triangles is exact but beside its edges, which are rounded by a part of a cell") {
  const Vec3 half{0.5, 0.4, 0.3};
  for (const Vec3& rotation : {Vec3{}, Vec3{0.3, -0.2, 0.5}}) {
    const Quaternion turn = quaternion(rotation);
    TriangleMesh box = box_of_triangles({}, half);
    for (Vec3& v : box.vertices) v = turned(turn, v);
    box.cell = 0.05;
    const double along = std::sqrt(0.5);
    std::vector<Throw> throws;  // at a face and at an edge by turns
    for (std::size_t i = 0; i < 300; ++i) {
      const double a = 0.95 * half[0] * test::scatter(i, 0);
      const double b = 0.95 * half[2] * test::scatter(i, 1);
      throws.push_back({turned(turn, {a, 1, b}), turned(turn, {0, -1, 0})});
      throws.push_back({turned(turn, {half[0] + along, half[1] + along, b}), turned(turn, {-2 * along, -2 * along, 0})});
    }
    double face = 0;
    double face_normal = 0;
    double edge = 0;
    for (const Hit& hit : touched_by(box, throws)) {
      const Vec3 y = turned(conjugate(turn), hit.x);
      const double off = std::abs(distance_to_box(y, half));
      if (half[0] - std::abs(y[0]) > 2 * box.cell && half[2] - std::abs(y[2]) > 2 * box.cell) {
        face = std::max(face, off);
        face_normal = std::max(face_normal, length(cross(hit.n, turned(turn, {0, 1, 0}))));
      } else {
        edge = std::max(edge, off);
      }
    }
    CHECK_MESSAGE(face < 1e-9, face << " m");
    CHECK_MESSAGE(face_normal < 1e-9, face_normal << " rad");
    CHECK_MESSAGE(edge < 0.5 * box.cell, edge << " m");
    CHECK(edge > 0.01 * box.cell);
  }
}

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

TEST_CASE("meshes: what falls into an edge that looks inwards stays out of the body, and comes to lie") {
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
        // By what the cells cost at an edge; no corner is farther from the middle than 0.24 m.
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

TEST_CASE("meshes: all that moves at one velocity acts as at rest, but for that way") {
  constexpr Vec3 boost{1.5, -0.75, 2.25};
  for (const double drag : {0.0, 0.4}) {
    Joined still = cloud(60);
    TriangleMesh ball = touched(ball_of_triangles({0.1, -0.2, 0}, 0.4, 2));
    ball.cell = 0.1;
    still.scene.add(ball);
    TriangleMesh box = touched(box_of_triangles({0.1, -1, 0}, {1, 0.2, 1}));
    box.cell = 0.1;
    still.scene.add(box);
    if (drag != 0) still.scene.add(Drag{.coefficient = drag});
    Joined moving = still;
    for (Vec3& v : moving.v) {
      for (std::size_t k = 0; k < 3; ++k) v[k] += boost[k];
    }
    if (drag != 0) std::get<Drag>(moving.scene.forces.back()).wind = boost;
    for (Contact& contact : moving.scene.contacts) std::visit([](auto& c) { c.motion = 0; }, contact);
    moving.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 16, .translation = scaled(boost, 16)}}});
    const std::size_t steps = 120;  // 2 s
    const auto wanted = stepped<double>(still, {.isa = best_isa()}, steps);
    const auto got = stepped<double>(moving, {.isa = best_isa()}, steps);
    const double t = static_cast<double>(steps) * still.step;
    double most = 0;
    for (std::size_t i = 0; i < wanted.size(); i += 6) {
      for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(got[i + k] - t * boost[k] - wanted[i + k]));
    }
    CHECK_MESSAGE(most < 1e-9, "drag " << drag << ": " << most << " m");
  }
}

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

TEST_CASE("meshes: what bounds no body is refused, and so is a cell that does not hold it") {
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
  // Two boxes, one corner to the other's opposite corner.
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

}  // namespace contact_mesh_test
