// Meshes as contacts: their distance, and the place and time of impacts.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/triangle_meshes.hpp"
#include "math/rotation.hpp"
#include "math/vec3.hpp"
#include "scene/signed_distance.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace triangle_meshes::impact_test {

using test::stepped;

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

// The places where throws first touch the mesh, and its normals there, derived from the bounces.
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
    // The end is x + way + (1 - f) change.
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
  // Beside a concave edge, and beyond its end.
  const SignedDistance angle(angle_of_triangles());
  CHECK(std::abs(angle.at({1.2, 1.3, 0}) - 0.2) < 1e-15);
  CHECK(std::abs(angle.at({0.9, 0.9, 0}) + std::sqrt(0.02)) < 1e-15);
  CHECK(std::abs(angle.at({0.5, 0.8, 0.7}) - 0.2) < 1e-15);
}

// One face of a steep spike is cut into four, so that more of the triangles at its tip belong to that side.
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
    const double size = i % 2 == 0 ? 1.5 : 0.2;  // around the whole spike, and around its tip
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

TEST_CASE("meshes: an impact is where the interpolated distance is 0, to a millionth of a cell") {
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

TEST_CASE("meshes: a particle that leaves a body from inside meets a wall beyond it in the same step") {
  TriangleMesh box = box_of_triangles({}, {0.5, 0.5, 0.5});
  box.cell = 0.1;
  for (const Isa isa : {Isa::reference, best_isa()}) {
    Joined joined;
    joined.step = 0.1;
    joined.x = {{0.45, 0, 0}};
    joined.v = {{10, 0, 0}};
    joined.scene.add(box);
    joined.scene.add(Plane{.normal = {-1, 0, 0}, .offset = -1, .restitution = 1});
    const auto after = stepped<double>(joined, {.isa = isa}, 1);
    CHECK(test::is_close(after[0], 0.55, 1e-12));
    CHECK(test::is_close(after[3], -10, 1e-12));
  }
}

TEST_CASE("meshes: a particle that starts inside is put where the interpolated distance is 0, to a millionth of a cell") {
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

TEST_CASE("meshes: a particle thrown up inside that falls back before it is out is put on the surface at rest") {
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

TEST_CASE("meshes: a hit on a ball of triangles has place and normal within the errors of its cell and its faces") {
  constexpr double radius = 0.5;
  // 5120 faces: each lies up to half a millimetre inside the sphere, and its normal deviates by up to 0.03 rad.
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
    std::vector<Throw> throws;  // at a face and at an edge in turn
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

}  // namespace triangle_meshes::impact_test
