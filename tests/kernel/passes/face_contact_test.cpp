// Cloth faces on bodies narrower than the cells: nearest points, weighted pulses, and sheets that are held.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "contact/faces/face.hpp"
#include "dvdx/contact_report.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/isas.hpp"
#include "topology/particle_order.hpp"

namespace face_contact_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;
using test::Run;
using test::scatter;
using test::stepped;

constexpr double side = 3;

double cell_of(std::size_t n) { return side / static_cast<double>(n - 1); }

// A flat sheet of 3 m by 3 m and 1 kg that falls from `drop` above the bodies' tops, slowed by drag.
Joined falling(std::size_t n, Scheme scheme = Scheme::leapfrog, double drop = 0.1, double slowed = 1) {
  Joined joined;
  Grid grid{.rows = n, .columns = n, .edge_u = {side, 0, 0}, .edge_v = {0, 0, side}, .structural = 400, .shear = 200};
  grid.bend = 20;
  const double mass = 1 / static_cast<double>(n * n);
  joined.scene.mass = mass;
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Drag{.coefficient = slowed * mass});
  joined.scene.add(Network(grid));
  joined.scene.coupling.scheme = scheme;
  if (scheme == Scheme::accumulate) joined.scene.coupling.method = Method::combined;
  for (std::size_t i = 0; i < n * n; ++i) {
    const double u = static_cast<double>(i % n) / static_cast<double>(n - 1);
    const double w = static_cast<double>(i / n) / static_cast<double>(n - 1);
    joined.x.push_back({side * u, drop, side * w});
    joined.v.push_back({});
  }
  joined.name = std::to_string(n) + " x " + std::to_string(n);
  return joined;
}

// Bodies with their top at y = 0, under the middle of the sheet, between its particles.
Capsule pole(std::size_t n, double part) {
  const double r = part * cell_of(n);
  const double z = side / 2 + 0.3 * cell_of(n);
  return {.ends = {{{-1, -r, z}, {4, -r, z}}}, .radius = {r, r}, .friction = 1};
}
Capsule taper(std::size_t n, double part) {
  const double r = part * cell_of(n);
  const double x = side / 2 + 0.2 * cell_of(n);
  return {.ends = {{{x, -3, x}, {x, -r, x}}}, .radius = {4 * r, r}, .friction = 1};
}
Sphere ball(std::size_t n, double part) {
  const double r = part * cell_of(n);
  return {.center = {side / 2 + 0.3 * cell_of(n), -r, side / 2 + 0.1 * cell_of(n)}, .radius = r, .friction = 1};
}
OrientedBox beam(std::size_t n, double part) {
  const double r = part * cell_of(n);
  return {.center = {side / 2, -r, side / 2 + 0.3 * cell_of(n)}, .half_extents = {2.5, r, r}, .friction = 1};
}
// Four planes to a tip, with a slope of four to one.
Convex spike(std::size_t n) {
  const Vec3 tip{side / 2 + 0.3 * cell_of(n), 0, side / 2 + 0.1 * cell_of(n)};
  Convex body{.planes = {{{0, -1, 0}, 2}}, .friction = 1};
  for (const Vec3 normal : {Vec3{4, 1, 0}, Vec3{-4, 1, 0}, Vec3{0, 1, 4}, Vec3{0, 1, -4}}) {
    const double along = normal[0] * tip[0] + normal[1] * tip[1] + normal[2] * tip[2];
    body.planes.push_back({normal, along / std::sqrt(17.0)});
  }
  return body;
}

double size_of(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }
Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double along(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 across(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// m, signed distance from the surface; negative inside.
double outside_of(const Sphere& of, const Vec3& x) { return size_of(minus(x, of.center)) - of.radius; }
double outside_of(const Capsule& of, const Vec3& x) {  // approximate for two radii: the balls along it
  double least = std::numeric_limits<double>::infinity();
  const int balls = of.radius[0] == of.radius[1] ? 1 : 200;
  for (int k = 0; k <= balls; ++k) {
    const double f = static_cast<double>(k) / balls;
    Vec3 at{};
    for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = of.ends[0][axis] + f * (of.ends[1][axis] - of.ends[0][axis]);
    if (balls == 1) at[0] = std::clamp(x[0], of.ends[0][0], of.ends[1][0]);
    least = std::min(least, size_of(minus(x, at)) - (of.radius[0] + f * (of.radius[1] - of.radius[0])));
  }
  return least;
}
double outside_of(const OrientedBox& of, const Vec3& x) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(x[k] - of.center[k]) - of.half_extents[k]);
  return most;
}
double outside_of(const Convex& of, const Vec3& x) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Face& face : of.planes) most = std::max(most, along(face.normal, x) / size_of(face.normal) - face.offset);
  return most;
}

template <class T>
Vec3 place_of(const std::vector<T>& values, std::size_t i) {
  return {double{values[6 * i]}, double{values[6 * i + 1]}, double{values[6 * i + 2]}};
}

// The least outside_of() over sample points of all triangles.
template <class Body, class T>
double nearest(const Body& body, const Grid& grid, const std::vector<T>& values) {
  constexpr int parts = 6;
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles_of(grid)) {
    const Vec3 a = place_of(values, t[0]), b = place_of(values, t[1]), c = place_of(values, t[2]);
    for (int i = 0; i <= parts; ++i) {
      for (int j = 0; i + j <= parts; ++j) {
        Vec3 x{};
        for (std::size_t k = 0; k < 3; ++k) x[k] = a[k] + (i * (b[k] - a[k]) + j * (c[k] - a[k])) / parts;
        least = std::min(least, outside_of(body, x));
      }
    }
  }
  return least;
}
template <class T>
double highest(const std::vector<T>& values) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < values.size() / 6; ++i) most = std::max(most, double{values[6 * i + 1]});
  return most;
}
const Grid& grid_of(const Joined& joined) { return std::get<Grid>(joined.scene.networks[0]); }

// ---- the nearest point ------------------------------------------------------------------------------------------------------

Vec3 anywhere(std::size_t i, std::size_t k, double size) {
  return {size * scatter(i, k), size * scatter(i, k + 1), size * scatter(i, k + 2)};
}

TEST_CASE("faces: the separating plane that is found parts triangle and core by the distance that is found") {
  int apart = 0;
  for (std::size_t i = 0; i < 600; ++i) {
    const Vec3 off = anywhere(i, 100, 1.5);
    std::array<Vec3, 3> triangle{anywhere(i, 0, 1), anywhere(i, 3, 1), anywhere(i, 6, 1)};
    for (Vec3& x : triangle) x = {x[0] + off[0], x[1] + off[1], x[2] + off[2]};
    std::vector<CoreBall> core;
    const std::size_t balls = std::array<std::size_t, 4>{1, 2, 8, 30}[i % 4];
    for (std::size_t k = 0; k < balls; ++k) core.push_back({anywhere(i, 10 + 3 * k, 0.5), balls == 2 && k == 1 ? 0.2 : 0});
    const Closest found = closest(triangle, core, 100);
    if (found.how == Proximity::pierced) continue;
    REQUIRE(found.how == Proximity::apart);
    ++apart;
    double near = std::numeric_limits<double>::infinity();
    double far = -near;
    for (const Vec3& x : triangle) near = std::min(near, along(found.n, x));
    for (const CoreBall& ball : core) far = std::max(far, along(found.n, ball.at) + ball.radius);
    CHECK(near - far == doctest::Approx(found.distance).epsilon(1e-5));
    Vec3 point{};
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(found.weight[k] >= 0);
      for (std::size_t axis = 0; axis < 3; ++axis) point[axis] += found.weight[k] * triangle[k][axis];
    }
    CHECK(found.weight[0] + found.weight[1] + found.weight[2] == doctest::Approx(1));
    CHECK(along(found.n, point) - far == doctest::Approx(found.distance).epsilon(1e-5));
    CHECK(closest(triangle, core, 0.9 * found.distance).how == Proximity::far);
  }
  CHECK(apart > 400);
}

TEST_CASE("faces: a triangle that the core goes through is pierced") {
  const std::array<Vec3, 3> triangle{{{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}}};
  const std::vector<CoreBall> through{{{0, -1, 0}, 0}, {{0.1, 1, 0}, 0}};
  const std::vector<CoreBall> beside{{{2, -1, 0}, 0}, {{2, 1, 0}, 0}};
  CHECK(closest(triangle, through, 10).how == Proximity::pierced);
  CHECK(closest(triangle, beside, 10).how == Proximity::apart);
}

// ---- one pulse --------------------------------------------------------------------------------------------------------------

FaceBody round_body(double radius) {
  return {.core = {CoreBall{}}, .radius = radius, .low = {-radius, -radius, -radius}, .high = {radius, radius, radius}};
}

// A triangle in the plane y that has moved down by `down` in this part.
FaceCorners coming(double y, double down, const Vec3& v) {
  FaceCorners corners{.w = {2, 1, 0.5}, .now = {{{-0.3, y, -0.2}, {0.4, y, -0.2}, {0, y, 0.5}}}, .v = {v, v, v}};
  corners.to = corners.now;
  corners.was = corners.now;
  for (Vec3& x : corners.was) x[1] += down;
  return corners;
}

TEST_CASE(
    "faces: a pulse takes from the corners what the body gets, leaves the point on the surface and keeps no speed inwards") {
  const FaceBody body = round_body(0.1);
  const Vec3 v{0.3, -2, 0.1};
  const FaceCorners corners = coming(0.08, 0.02, v);
  FacePulse pulse;
  REQUIRE(may_meet(body, {}, corners.now));
  REQUIRE(find_pulse(body, {}, corners, {1, 1, 0.01}, pulse));
  Vec3 momentum{}, turn{}, speed{}, point{};
  // The origin projects onto this point of the triangle: the weights are ratios of areas.
  const double whole = 0.7 * 0.7;
  const std::array<double, 3> weight{(0.4 * 0.5) / whole, (0.3 * 0.5) / whole, (0.7 * 0.2) / whole};
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3 gained{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gained[axis] = pulse.share[i] * pulse.dv[axis] / corners.w[i];
      momentum[axis] += gained[axis];
      speed[axis] += weight[i] * (v[axis] + pulse.share[i] * pulse.dv[axis]);
      point[axis] += weight[i] * (corners.now[i][axis] + pulse.share[i] * pulse.move[axis]);
    }
    const Vec3 arm = across(corners.now[i], gained);
    for (std::size_t axis = 0; axis < 3; ++axis) turn[axis] += arm[axis];
  }
  const Vec3 of_point = across(pulse.x, momentum);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(momentum[axis] == doctest::Approx(-pulse.impulse[axis]));
    CHECK(std::abs(turn[axis] - of_point[axis]) < 1e-12);
  }
  CHECK(std::abs(speed[1]) < 1e-12);
  CHECK(speed[0] == doctest::Approx(v[0]));
  CHECK(point[1] == doctest::Approx(0.1));
  CHECK(std::abs(point[0]) < 1e-12);
}

TEST_CASE("faces: impacts have restitution, friction and viscosity; fixed corners do not move, resting faces do not bounce") {
  FaceBody body = round_body(0.1);
  body.e = 0.5;
  body.mu = 0.2;
  body.tau = 0.9;
  FacePulse pulse;
  const auto found = [&](const FaceCorners& corners, double h) { return find_pulse(body, {}, corners, {1, 1, h}, pulse); };
  REQUIRE(found(coming(0.08, 0.02, {1, -2, 0}), 0.01));  // at -2 m/s all the way
  CHECK(pulse.is_impact);
  CHECK(pulse.dv[1] == doctest::Approx(3));  // from -2 to e 2
  CHECK(pulse.dv[0] == doctest::Approx(0.9 - 1 - 0.2 * 3));
  REQUIRE(found(coming(0.1 - 0.018, 0.018, {0, -2, 0}), 0.01));  // from -1.6 m/s at the surface, evenly
  CHECK(pulse.dv[1] == doctest::Approx(2 + 0.5 * 1.6));
  REQUIRE(found(coming(0.1 - 0.0004905, 0.0004905, {0, -0.0981, 0}), 0.01));  // fallen from rest
  CHECK_FALSE(pulse.is_impact);
  CHECK(pulse.dv[1] == doctest::Approx(0.0981));
  FaceCorners held = coming(0.08, 0.02, {0, -2, 0});
  held.w = {0, 0, 0};
  CHECK_FALSE(found(held, 0.01));
  held.w = {0, 0, 3};
  REQUIRE(found(held, 0.01));
  CHECK(pulse.share[0] == 0);
  CHECK(pulse.share[2] > 1);  // the point moves as much
  FaceCorners broken = coming(0.08, 0.02, {0, -2, 0});
  broken.now[1][2] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(may_meet(body, {}, broken.now));
  CHECK_FALSE(found(coming(0.101, 0.02, {0, -2, 0}), 0.01));  // not there yet
}

TEST_CASE("faces: a pulse on cloth and a body that move at one velocity is that on cloth before a body at rest") {
  constexpr Vec3 V{3, -4, 5};
  constexpr double h = 0.01;
  FaceBody body = round_body(0.1);
  body.e = 0.5;
  body.mu = 0.2;
  FaceCorners corners = coming(0.08, 0.02, {1, -2, 0});
  FacePulse at_rest, moving;
  REQUIRE(find_pulse(body, {}, corners, {1, 1, h}, at_rest));
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      corners.v[i][axis] += V[axis];
      corners.was[i][axis] -= h * V[axis];
    }
  }
  REQUIRE(find_pulse(body, {.velocity = V}, corners, {1, 1, h}, moving));
  CHECK(moving.is_impact == at_rest.is_impact);
  CHECK(size_of(minus(moving.dv, at_rest.dv)) < 1e-12);
  CHECK(size_of(minus(moving.move, at_rest.move)) < 1e-12);
  CHECK(size_of(minus(moving.move_on, at_rest.move_on)) < 1e-12);
}

TEST_CASE("faces: a body with push_out moves corners inside it no faster, and keeps out those that come in") {
  FaceBody body = round_body(0.1);
  body.push_out = 0.5;
  const auto moved = [&](double y, double way, double speed) {
    FacePulse pulse;
    REQUIRE(find_pulse(body, {}, coming(y, way, {0, speed, 0}), {1, 1, 0.01}, pulse));
    return pulse.move[1];
  };
  CHECK(moved(0.04, 0, 0) == doctest::Approx(0.5 * 0.01));
  CHECK(moved(0.098, 0, 0) == doctest::Approx(0.002));  // no farther than to the surface
  CHECK(moved(0.08, 0.02, -2) == doctest::Approx(0.02));
  CHECK(moved(0.04, 0.02, -2) == doctest::Approx(0.02 + 0.5 * 0.01));
}

// ---- sheets -----------------------------------------------------------------------------------------------------------------

template <class Body>
void check_held(Joined joined, const Body& body, double depth, std::size_t steps = 60) {
  joined.scene.add(Contact(body));
  const std::vector<float> end = stepped<float>(joined, {}, steps);
  CHECK(highest(end) > -0.5 * cell_of(grid_of(joined).rows));
  CHECK(nearest(body, grid_of(joined), end) > -depth);
}

TEST_CASE("faces: a pole from a twentieth of a cell on holds a sheet, whose faces stay out of it") {
  for (const double part : {0.05, 0.1, 0.3, 0.5}) {
    CAPTURE(part);
    check_held(falling(10), pole(10, part), 0.1 * part * cell_of(10));
  }
}

TEST_CASE("faces: a pole holds a sheet by every scheme") {
  for (const Scheme scheme : {Scheme::fourth_order, Scheme::sequential, Scheme::accumulate}) {
    CAPTURE(static_cast<int>(scheme));
    check_held(falling(10, scheme), pole(10, 0.1), 0.02 * cell_of(10));
  }
  Joined forward = falling(10, Scheme::sequential);
  forward.scene.coupling.theta = 1;
  forward.scene.coupling.substeps = 4;
  check_held(forward, pole(10, 0.1), 0.02 * cell_of(10));
}

TEST_CASE("faces: balls, beams, spikes and poles on end hold a sheet") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential}) {
    CAPTURE(static_cast<int>(scheme));
    check_held(falling(10, scheme), ball(10, 0.2), 0.02 * cell_of(10));
    check_held(falling(10, scheme), beam(10, 0.2), 0.06 * cell_of(10));  // its edges count as rounded
    check_held(falling(10, scheme), taper(10, 0.1), 0.02 * cell_of(10));
    check_held(falling(10, scheme), spike(10), 0.1 * cell_of(10));  // as does its tip
  }
}

TEST_CASE("faces: a sheet that falls fast does not pass a thin pole in a coarse step") {
  Joined joined = falling(10, Scheme::sequential, 0.4);
  joined.scene.coupling.substeps = 1;
  for (Vec3& v : joined.v) v[1] = -12;  // 0.2 m a step, onto a pole of 6 cm
  check_held(joined, pole(10, 0.1), 0.05 * cell_of(10), 12);
}

TEST_CASE("faces: a pole, a ball and a spike go through a sheet without them") {
  const auto passes = [](const Contact& body) {
    Joined joined = falling(10);
    joined.scene.add(body);
    joined.scene.faces = Faces::never;
    return highest(stepped<float>(joined, {}, 60)) < -1.5 * cell_of(10);
  };
  CHECK(passes(pole(10, 0.1)));
  CHECK(passes(ball(10, 0.2)));
  CHECK(passes(taper(10, 0.1)));
}

TEST_CASE("faces: a scene without narrow bodies has no such pass, and has the bits without it") {
  Joined joined = falling(10);
  joined.scene.add(Contact(Sphere{.center = {1.5, -1, 1.5}, .radius = 0.9}));
  joined.scene.add(Contact(Plane{.offset = -1.5}));
  joined.scene.add(Contact(Sphere{.center = {1.5, 0, 1.5}, .radius = 20, .side = Side::inside}));
  Joined never = joined;
  never.scene.faces = Faces::never;
  const auto with = test::plan_of<float>(joined, {});
  CHECK(with.explain().find("faces ") == std::string::npos);
  CHECK(with.workspace().bytes() == test::plan_of<float>(never, {}).workspace().bytes());
  CHECK(stepped<float>(joined, {}, 30) == stepped<float>(never, {}, 30));
}

TEST_CASE("faces: explain says which contacts are narrower than which cells") {
  Joined joined = falling(10);
  joined.scene.add(Contact(Plane{.offset = -3}));
  joined.scene.add(Contact(pole(10, 0.1)));
  joined.scene.add(Contact(spike(10)));
  const std::string words = test::plan_of<float>(joined, {}).explain();
  CHECK(words.find("faces        contacts[1] is 0.0667 m wide where networks[0] has sides of up to 0.471 m") !=
        std::string::npos);
  CHECK(words.find("contacts[2] is pointed where networks[0]") != std::string::npos);
  CHECK(words.find("contacts[0] is") == std::string::npos);
}

TEST_CASE("faces: the same bits by every instruction set and number of threads, and call by call") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential}) {
    Joined joined = falling(12, scheme);
    joined.scene.add(Motion{.keys = {{.time = 0}, {.time = 1, .translation = {0.2, 0.1, 0.1}, .rotation = {0, 0.5, 0}}}});
    Capsule moving = pole(12, 0.1);
    moving.motion = 0;
    joined.scene.add(Contact(moving));
    joined.scene.add(Contact(ball(12, 0.3)));
    const std::vector<float> whole = stepped<float>(joined, {}, 20);
    for (const Isa isa : available_isas(Arithmetic::separate))
      CHECK(stepped<float>(joined, {.isa = isa, .threads = 3}, 20) == whole);
    Batch<float> batch(Layout::aosoa8, joined.x.size());
    test::place(joined, batch.view());
    const auto plan = test::plan_of(joined, {}, batch.view());
    for (int n = 0; n < 20; ++n) REQUIRE(plan.step(batch.view()) == StepResult::done);
    CHECK(test::values_of(batch.view()) == whole);
  }
}

TEST_CASE("faces: a grid and a list of the same springs and triangles are held alike") {
  Joined joined = falling(10);
  joined.scene.add(Contact(pole(10, 0.1)));
  const std::vector<double> grid = stepped<double>(joined, {}, 24);
  const std::vector<double> list = stepped<double>(test::as_list(joined), {}, 24);
  CHECK(test::apart(grid, grid) == 0);
  double most = 0;
  for (std::size_t i = 0; i < joined.x.size(); ++i) most = std::max(most, size_of(minus(place_of(grid, i), place_of(list, i))));
  CHECK(most < 0.02 * cell_of(10));
}

TEST_CASE("faces: coarse cloth lies as fine cloth does, to a cell's width") {
  const auto lies = [](std::size_t n) {
    Joined joined = falling(n, Scheme::sequential, 0.1, 6);
    std::get<Grid>(joined.scene.networks[0]).bend = 0;  // its springs would be stiffer in larger cells
    Capsule rod = pole(10, 0.1);
    rod.ends[0][2] = rod.ends[1][2] = 1.6;
    joined.scene.add(Contact(rod));
    return stepped<float>(joined, {}, 90);
  };
  const std::vector<float> coarse = lies(10), fine = lies(28);  // each third particle of `fine` is in `coarse`
  // Averages rows along the pole, because single columns swing.
  double most = 0;
  for (std::size_t row = 0; row < 10; ++row) {
    Vec3 apart{};
    for (std::size_t column = 0; column < 10; ++column) {
      const Vec3 one = minus(place_of(coarse, 10 * row + column), place_of(fine, 84 * row + 3 * column));
      for (std::size_t axis = 0; axis < 3; ++axis) apart[axis] += one[axis] / 10;
    }
    most = std::max(most, size_of(apart));
  }
  CHECK(most < cell_of(10));
}

// J: kinetic energy, undamped springs, and weight.
double energy_of(const Joined& joined, const std::vector<double>& values) {
  double sum = 0;
  const double mass = joined.scene.mass[0];
  for (std::size_t i = 0; i < values.size() / 6; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum += mass / 2 * values[6 * i + 3 + axis] * values[6 * i + 3 + axis];
    sum += 9.81 * mass * values[6 * i + 1];
  }
  const Springs springs = springs_of(grid_of(joined));
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const double l = size_of(minus(place_of(values, springs.pairs[s][0]), place_of(values, springs.pairs[s][1])));
    const double over = l - (*springs.rest_length)[s];
    sum += springs.stiffness[s] / 2 * over * over;
  }
  return sum;
}

TEST_CASE("faces: a sheet on a pole never gains energy") {
  for (const double friction : {0.0, 0.5}) {
    Joined joined = falling(8, Scheme::leapfrog, 0.1, 0);
    Capsule rod = pole(8, 0.1);
    rod.friction = friction;
    joined.scene.add(Contact(rod));
    joined.scene.coupling.substeps = 32;
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    const auto plan = test::plan_of(joined, {}, batch.view());
    double least = energy_of(joined, test::values_of(batch.view()));
    for (int n = 0; n < 24; ++n) {
      REQUIRE(plan.step(batch.view(), 3) == StepResult::done);
      const double now = energy_of(joined, test::values_of(batch.view()));
      CHECK(now < least + 0.02);  // of 1 J at the start; leapfrog's energy oscillates by this much
      least = std::min(least, now);
    }
  }
}

TEST_CASE("faces: a sheet that lies on a ball presses it with its weight, and nothing else") {
  Joined joined = falling(8, Scheme::leapfrog, 0.05, 6);
  joined.scene.add(Contact(ball(8, 0.3)));
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = test::plan_of(joined, {}, batch.view());
  ContactReport settling(1), resting(1);
  REQUIRE(plan.step(batch.view(), settling, 240) == StepResult::done);
  REQUIRE(plan.step(batch.view(), resting, 120) == StepResult::done);
  const ContactSum sum = resting.of(0);
  CHECK(sum.impulse[1] == doctest::Approx(-9.81 * 2).epsilon(0.02));
  CHECK(std::abs(sum.impulse[0]) < 0.2);
  CHECK(std::abs(sum.impulse[2]) < 0.2);
  CHECK(settling.of(0).hits > 0);
}

TEST_CASE("faces: a bad particle stays alone") {
  Joined joined = falling(10);
  joined.scene.add(Contact(pole(10, 0.1)));
  joined.x[44][1] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<float> end = stepped<float>(joined, {}, 40);
  std::size_t bad = 0;
  for (std::size_t i = 0; i < joined.x.size(); ++i) bad += std::isfinite(size_of(place_of(end, i))) ? 0U : 1U;
  CHECK(bad == 1);
}

TEST_CASE("faces: torn faces hold nothing, torn from the start or in place, with the same bits") {
  // One cell around a ball.
  const auto cell = [](std::vector<Pair> broken) {
    Joined joined;
    Grid grid{.rows = 2, .columns = 2, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 100, .shear = 100};
    grid.broken = std::move(broken);
    joined.scene.add(Network(grid));
    joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    joined.scene.add(Contact(Sphere{.center = {0.5, -0.1, 0.5}, .radius = 0.1, .friction = 1}));
    for (const double w : {0.0, 1.0}) {
      for (const double u : {0.0, 1.0}) joined.x.push_back({u, 0.05, w});
    }
    joined.v.resize(4);
    return joined;
  };
  CHECK(highest(stepped<float>(cell({}), {}, 30)) > -0.6);
  const std::vector<float> torn = stepped<float>(cell({{0, 3}}), {}, 30);
  CHECK(highest(torn) < -1);
  const Joined whole = cell({});
  Batch<float> batch(Layout::soa, 4);
  test::place(whole, batch.view());
  auto plan = test::plan_of(whole, {}, batch.view());
  REQUIRE(plan.break_spring(0, {3, 0}).has_value());
  REQUIRE(plan.step(batch.view(), 30) == StepResult::done);
  CHECK(test::values_of(batch.view()) == torn);
}

TEST_CASE("faces: a pole that is swung up takes the sheet along, however fast it comes") {
  for (const double speed : {1.0, 15.0}) {
    CAPTURE(speed);
    Joined joined = falling(10, Scheme::sequential, 0);
    joined.scene.coupling.substeps = 2;
    joined.scene.add(Motion{.keys = {{.time = 0}, {.time = 1, .translation = {0, speed, 0}}}});
    Capsule rod = pole(10, 0.1);
    for (Vec3& end : rod.ends) end[1] -= 0.3;
    rod.motion = 0;
    joined.scene.add(Contact(rod));
    const std::size_t steps = speed > 10 ? 12 : 60;
    const std::vector<float> end = stepped<float>(joined, {}, steps);
    Capsule there = rod;
    for (Vec3& at : there.ends) at[1] += speed * static_cast<double>(steps) / 60;
    CHECK(highest(end) > there.ends[0][1]);
    CHECK(nearest(there, grid_of(joined), end) > -0.03 * cell_of(10));
  }
}

TEST_CASE("faces: a contact that is replaced is met as in a plan compiled anew") {
  const auto replaced = [](const Contact& before, const Contact& after) {
    Joined joined = falling(10);
    joined.scene.add(before);
    Batch<float> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    auto plan = test::plan_of(joined, {}, batch.view());
    REQUIRE(plan.set_contact(0, after).has_value());
    REQUIRE(plan.step(batch.view(), 20) == StepResult::done);
    Joined anew = falling(10);
    anew.scene.add(after);
    return test::values_of(batch.view()) == stepped<float>(anew, {}, 20);
  };
  const Sphere large{.center = {1.5, -1, 1.5}, .radius = 1};
  CHECK(replaced(Contact(pole(10, 0.3)), Contact(pole(10, 0.1))));
  CHECK(replaced(Contact(large), Contact(ball(10, 0.2))));
  CHECK(replaced(Contact(ball(10, 0.2)), Contact(large)));
  CHECK(replaced(Contact(ball(10, 0.2)), Contact(pole(10, 0.1))));
}

TEST_CASE("faces: a part of a larger scene is refused unless it asks for no faces") {
  Joined joined = falling(10);
  joined.scene.add(Contact(pole(10, 0.1)));
  Options options{.step = joined.step};
  options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
  options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto refused = compile<float>(joined.scene, options, batch.view());
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().field == "contacts[0]");
  joined.scene.faces = Faces::never;
  CHECK(compile<float>(joined.scene, options, batch.view()).has_value());
}

}  // namespace face_contact_test
