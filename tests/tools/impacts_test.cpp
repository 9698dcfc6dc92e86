// The report's reference for contacts, compared with results of 20 digits, with formulas of slides, and with the kernel.
#include "closed_form/impacts.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "closed_form/motion.hpp"
#include "closed_form/surface.hpp"
#include "dvdx/layouts/soa.hpp"
#include "report/build.hpp"
#include "report/json.hpp"
#include "report/measure.hpp"
#include "report/reference.hpp"
#include "report/sample.hpp"
#include "report/summary.hpp"
#include "scene_io/scene_reader.hpp"
#include "support/oracle.hpp"
#include "support/paths.hpp"

namespace impacts_test {

using dvdx::Vec3;
using dvdx::test::Oracle;
using dvdx::tool::ImpactPath;
using dvdx::tool::NoImpactPath;
using dvdx::tool::SceneFile;

SceneFile one_particle(Vec3 x, Vec3 v) {
  SceneFile file;
  file.particles = {.count = 1, .position = x, .velocity = v};
  return file;
}

ImpactPath covered(const SceneFile& file, double unit, const std::vector<std::uint64_t>& counts) {
  auto found = dvdx::tool::impact_path(file, unit, counts);
  const auto* none = std::get_if<NoImpactPath>(&found);
  CAPTURE((none == nullptr ? std::string() : none->why));
  REQUIRE(none == nullptr);
  return std::get<ImpactPath>(std::move(found));
}

std::string reason(const SceneFile& file, double duration) {
  const auto found = dvdx::tool::impact_path(file, duration, std::vector<std::uint64_t>{0, 1});
  const auto* none = std::get_if<NoImpactPath>(&found);
  return none == nullptr ? "" : none->why;
}

struct At {
  std::array<double, 3> x{}, v{};
};

// The state of the particle after t seconds.
At after(const SceneFile& file, double t) {
  const auto found = covered(file, t, {0, 1});
  At at;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    at.x[axis] = static_cast<double>(found.path.x[found.path.index(1, 0, axis)]);
    at.v[axis] = static_cast<double>(found.path.v[found.path.index(1, 0, axis)]);
  }
  return at;
}

double off(double value, double expected) { return std::abs(value - expected) / (1 + std::abs(expected)); }

SceneFile ball_over_floor(const Oracle::Row& row) {
  auto file = one_particle({0, row["y0_m"], 0}, {0, row["v0_m_s"], 0});
  file.scene.add(dvdx::Constant{.acceleration = {0, -row["g_m_s2"], 0}});
  file.scene.add(dvdx::Plane{.normal = {0, 1, 0}, .restitution = row["restitution"]});
  return file;
}

TEST_CASE("from impact to impact: heights of bounces, to the rest and beyond") {
  const Oracle oracle("bounce1d_states.csv");
  double worst = 0;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    worst = std::max(worst, off(after(ball_over_floor(row), row["t_s"]).x[1], row["y_m"]));
  }
  CHECK(worst < 2e-16);
}

TEST_CASE("from impact to impact: every impact comes at its time") {
  const Oracle oracle("bounce1d_times.csv");
  for (std::size_t i = 0; i + 1 < oracle.size(); ++i) {
    const auto row = oracle[i];
    const auto next = oracle[i + 1];
    if (next.text("case") != row.text("case")) continue;
    const double t = row["t_bounce_s"];
    const double until = next["t_bounce_s"];
    if (!(until - t > 1e-12 * t)) continue;  // no double lies clearly between them
    CAPTURE(i);
    CHECK(covered(ball_over_floor(row), (t + until) / 2, {0, 1}).most_impacts == static_cast<std::uint64_t>(row["bounce"]) + 1);
    CHECK(std::abs(after(ball_over_floor(row), t).x[1]) < 2e-16 * (1 + row["impact_speed_m_s"]) * (1 + t));
  }
}

TEST_CASE("from impact to impact: an oblique plane that brakes along itself") {
  const Oracle oracle("bounce3d.csv");
  double worst = 0;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    auto file = one_particle({row["x0"], row["y0"], row["z0"]}, {row["vx0"], row["vy0"], row["vz0"]});
    const Vec3 n{row["nx"], row["ny"], row["nz"]};
    const double g = row["g_along_minus_n"];
    const double length = std::hypot(n[0], n[1], n[2]);
    file.scene.add(dvdx::Constant{.acceleration = {-g * n[0] / length, -g * n[1] / length, -g * n[2] / length}});
    file.scene.add(dvdx::Plane{
        .normal = n, .offset = row["d_m"], .restitution = row["restitution"], .viscosity = -std::log(row["tangential_keep"])});
    const auto at = after(file, row["t_s"]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name(1, "xyz"[axis]);
      worst = std::max({worst, off(at.x[axis], row[name]), off(at.v[axis], row["v" + name])});
    }
  }
  CHECK(worst < 1e-14);
}

TEST_CASE("from impact to impact: time and speed of an impact under gravity and drag") {
  using namespace dvdx::tool::impacts;
  const Oracle oracle("toi.csv");
  std::size_t rows = 0;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    if (row["W_1_s2"] != 0) continue;
    CAPTURE(i);
    ++rows;
    LinearMotion motion;
    const Real g = row["g_1_s"];
    motion.add({.along = {{0, 1, 0}}, .v = row["v0_m_s"], .a = row["a_m_s2"] - g * row["v0_m_s"], .g = g});
    Surface floor;
    floor.n = {{0, 1, 0}};
    const Vector x{{0, row["s0_m"], 0}};
    const auto t = first_impact(motion, floor, x, floor.gap(x), row["h_s"]);
    REQUIRE(t);
    CHECK(off(static_cast<double>(*t / row["h_s"]), row["f_exact"]) < 1e-15);
    CHECK(off(static_cast<double>(motion.velocity(*t)[1]), row["v_impact_m_s"]) < 1e-15);
  }
  CHECK(rows == 48);
}

TEST_CASE("a dip between two samples is an impact, on a plane and on a small sphere") {
  // A parabola with its lowest point 1e-9 m below the floor, inside for 3e-5 s, within a second.
  auto file = one_particle({0, 1.25 - 1e-9, 0}, {0, -5, 0});
  file.scene.add(dvdx::Constant{.acceleration = {0, 10, 0}});
  file.scene.add(dvdx::Plane{.normal = {0, 1, 0}, .restitution = 1});
  CHECK(covered(file, 1, {0, 1}).most_impacts == 1);
  // A shot at 1000 m/s through a sphere of a millimetre, 0.9 mm off its centre.
  auto shot = one_particle({-500, 0.0009, 0}, {1000, 0, 0});
  shot.scene.add(dvdx::Sphere{.radius = 0.001, .restitution = 1});
  CHECK(covered(shot, 1, {0, 1}).most_impacts == 1);
  shot.particles.position = Vec3{-500, 0.0011, 0};
  CHECK(covered(shot, 1, {0, 1}).most_impacts == 0);
}

// --- slides ------------------------------------------------------------------------------------------------------------------

SceneFile puck(Vec3 v, Vec3 a, double friction) {
  auto file = one_particle({0, 0, 0}, v);
  file.scene.add(dvdx::Constant{.acceleration = a});
  file.scene.add(dvdx::Plane{.normal = {0, 1, 0}, .friction = friction});
  return file;
}

TEST_CASE("a puck slides to a stop as the text book says, with drag and without") {
  const double stop = 3 / (0.5 * 10);
  const auto moving = after(puck({3, 0, 0}, {0, -10, 0}, 0.5), 0.4);
  CHECK(off(moving.x[0], 3 * 0.4 - 2.5 * 0.16) < 1e-15);
  CHECK(off(moving.v[0], 3 - 5 * 0.4) < 1e-15);
  const auto still = after(puck({3, 0, 0}, {0, -10, 0}, 0.5), 2 * stop);
  CHECK(off(still.x[0], 0.9) < 1e-15);
  CHECK(still.v == std::array<double, 3>{0, 0, 0});
  // v' = -M - g v stops at ln(1 + g v/M)/g, after v/g - M/g^2 ln(1 + g v/M).
  auto braked = puck({3, 0, 0}, {0, -10, 0}, 0.5);
  braked.scene.add(dvdx::Drag{.coefficient = 2.0});
  CHECK(off(after(braked, 1).x[0], 1.5 - 1.25 * std::log1p(6.0 / 5)) < 1e-15);
  // Up an incline (the floor is its plane, gravity is inclined), a stop, and down again if friction cannot hold.
  const auto back = after(puck({3, 0, 0}, {-6, -8, 0}, 0.25), 1);
  const double turn = 3.0 / 8;
  CHECK(off(back.x[0], 9.0 / 16 - 0.5 * 4 * (1 - turn) * (1 - turn)) < 1e-15);
  const auto held = after(puck({3, 0, 0}, {-6, -8, 0}, 0.8), 1);
  CHECK(off(held.x[0], 9 / (2 * (6 + 6.4))) < 1e-15);
  CHECK(held.v[0] == 0);
}

TEST_CASE("a slide that friction bends: |v| (M + b cos phi) falls by M^2 - b^2 a second") {
  // Along the force b the speed and its component give r' = b cos phi - M and (r cos phi)' = b - M cos phi.
  const double M = 5;
  for (const double b : {3.0, 4.999, 7.0}) {
    CAPTURE(b);
    const auto file = puck({-2, 0, 1.5}, {b, -10, 0}, 0.5);
    const auto invariant = [&](const At& at) { return M * std::hypot(at.v[0], at.v[2]) + b * at.v[0]; };
    const At start{{0, 0, 0}, {-2, 0, 1.5}};
    for (const double t : {0.01, 0.1, 0.2, 0.3}) {
      const auto at = after(file, t);
      CHECK(off(invariant(at), invariant(start) - (M * M - b * b) * t) < 1e-15);
      // tan(phi/2)^(M/b) / (r sin phi) is conserved: it gives the direction of the velocity.
      const auto constant = [&](const At& p) {
        const double r = std::hypot(p.v[0], p.v[2]);
        return std::pow((r - p.v[0]) / p.v[2], M / b) / p.v[2];
      };
      CHECK(off(constant(at), constant(start)) < 1e-12);
    }
    // Friction and the force together move the particle: v - v0 = b t - M (sum of directions). It stops at the time of rest.
    if (b > M) continue;
    const double stop = invariant(start) / (M * M - b * b);
    CHECK(after(file, stop * (1 + 1e-9)).v == std::array<double, 3>{0, 0, 0});
    CHECK(std::hypot(after(file, stop * (1 - 1e-6)).v[0], after(file, stop * (1 - 1e-6)).v[2]) > 0);
  }
}

TEST_CASE("a particle that settles slides on with the friction of all its impacts") {
  // The impacts and the slide after them remove mu times the floor's impulse: m g t and the speed of the fall.
  auto file = one_particle({0, 1, 0}, {40, 0, 0});
  file.scene.add(dvdx::Constant{.acceleration = {0, -10, 0}});
  file.scene.add(dvdx::Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.3});
  const auto at = after(file, 3);
  CHECK(off(at.v[0], 40 - 0.3 * 10 * 3) < 1e-15);
  CHECK(std::abs(at.x[1]) < 1e-18);
  CHECK(at.v[1] == 0);
  // With a viscosity, infinitely many impacts leave no tangential velocity; a single impact leaves exp(-viscosity).
  std::get<dvdx::Plane>(file.scene.contacts.front()) = {.normal = {0, 1, 0}, .restitution = 0.5, .viscosity = 0.1};
  CHECK(after(file, 3).v[0] == 0);
  std::get<dvdx::Plane>(file.scene.contacts.front()) = {.normal = {0, 1, 0}, .restitution = 0, .viscosity = 0.1};
  CHECK(off(after(file, 3).v[0], 40 * std::exp(-0.1)) < 1e-15);
  CHECK(after(file, 30).v[0] == after(file, 3).v[0]);
}

TEST_CASE("a particle that is pressed into a corner bounces off the third surface, and rests there in the end") {
  auto file = one_particle({0, 2, 0}, {});
  file.scene.add(dvdx::Constant{.acceleration = {-1, -10, -1}});
  for (const Vec3 n : {Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{0, 0, 1}}) {
    file.scene.add(dvdx::Plane{.normal = n, .restitution = 0.5});
  }
  const double fall = std::sqrt(2 * 2 / 10.0);
  CHECK(off(after(file, 1.5 * fall).x[1], 0.5) < 1e-15);  // at the top of the first bounce
  const auto end = after(file, 10);
  CHECK(std::hypot(end.x[0], end.x[1], end.x[2]) < 1e-18);
  CHECK(end.v == std::array<double, 3>{0, 0, 0});
}

// --- spheres -----------------------------------------------------------------------------------------------------------------

TEST_CASE("a particle without forces inside a sphere flies chord after chord") {
  // The inscribed square, from the middle of a side: after four impacts the particle is back at its start.
  const double side = std::numbers::sqrt2;
  auto file = one_particle({0, -side / 2, 0}, {side, 0, 0});
  file.scene.add(dvdx::Sphere{.radius = 1, .side = dvdx::Side::inside, .restitution = 1});
  const auto found = covered(file, 1, {0, 1, 2, 3, 4, 100});
  const auto at = [&](std::size_t k, std::size_t axis) {
    return static_cast<double>(found.path.x[found.path.index(k, 0, axis)]);
  };
  CHECK(std::abs(at(1, 0) - side / 2) < 1e-15);
  CHECK(std::abs(at(2, 1) - side / 2) < 1e-15);
  CHECK(std::abs(at(3, 0) + side / 2) < 1e-15);
  CHECK(std::abs(at(4, 1) + side / 2) < 1e-15);
  CHECK(std::abs(at(5, 1) + side / 2) < 1e-13);
  CHECK(found.most_impacts == 100);
}

TEST_CASE("a ball on top of a sphere or at the bottom of one bounces as on a floor, and rests") {
  for (const auto side : {dvdx::Side::outside, dvdx::Side::inside}) {
    auto sphere = one_particle({0, 1, 0}, {});
    sphere.scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
    auto floor = sphere;
    const double center = side == dvdx::Side::outside ? -3 : 3;
    sphere.scene.add(dvdx::Sphere{.center = {0, center, 0}, .radius = 3, .side = side, .restitution = 0.5});
    floor.scene.add(dvdx::Plane{.normal = {0, 1, 0}, .restitution = 0.5});
    for (const double t : {0.4, 0.7, 1.1, 1.3, 5.0}) {
      CAPTURE(t);
      CHECK(std::abs(after(sphere, t).x[1] - after(floor, t).x[1]) < 1e-17);
    }
  }
}

// --- motions not covered -----------------------------------------------------------------------------------------------------

TEST_CASE("a motion that is not followed is reported with its reason") {
  auto spring = puck({1, 0, 0}, {0, -10, 0}, 0);
  spring.scene.add(dvdx::Spring{.stiffness = 1.0});
  CHECK(reason(spring, 1).find("other forces") != std::string::npos);

  auto inside = puck({1, 0, 0}, {0, -10, 0}, 0);
  inside.particles.position = Vec3{0, -0.1, 0};
  CHECK(reason(inside, 1).find("starts inside") != std::string::npos);

  auto bowl = one_particle({0.5, 0, 0}, {});
  bowl.scene.add(dvdx::Constant{.acceleration = {0, -10, 0}});
  bowl.scene.add(dvdx::Sphere{.radius = 1, .side = dvdx::Side::inside});
  CHECK(reason(bowl, 1).find("slides on a sphere") != std::string::npos);
  CHECK(reason(bowl, 0.1).empty());  // still in the air

  auto oblique = one_particle({0, 1, 0}, {});
  oblique.scene.add(dvdx::Constant{.acceleration = {0, -10, 0}});
  oblique.scene.add(dvdx::Drag{.coefficient = dvdx::PerAxis(1.0, 2.0, 3.0)});
  oblique.scene.add(dvdx::Plane{.normal = {1, 1, 0}});
  CHECK(reason(oblique, 3).find("differs between axes") != std::string::npos);
}

// --- in the report -----------------------------------------------------------------------------------------------------------

using namespace dvdx::tool::report;

SceneFile shipped(const std::string& name) { return dvdx::tool::read_scene(dvdx::test::scenes() + "/" + name + ".json"); }

Setup on_one_thread() { return {.engine = {.isa = dvdx::best_isa()}, .parallel = {}}; }

// The root mean square error of method combined in float64 with steps of grid.coarsest / parts.
double kernel_error(const SceneFile& sample, const Grid& grid, std::uint64_t parts, const Reference& reference) {
  return measure_errors<double>(sample, sample.scene, grid, parts, reference, on_one_thread()).errors.position_rms;
}

Grid own_steps(const SceneFile& file) { return grid_of(file, 1, Effort::quick); }

// Sixteen of the million hailstones, evenly spread.
SceneFile hailstones() { return dvdx::tool::report::resized(shipped("hail"), 16); }

TEST_CASE("hail: the kernel's error against the impacts' closed form falls with the step, both ways of rounding agree") {
  const auto sample = hailstones();
  const auto grid = own_steps(sample);
  const auto reference = first_reference(sample, grid, on_one_thread());
  CHECK(reference.facts.kind == "closed_form");
  CHECK(reference.facts.source == ReferenceSource::impacts);
  CHECK(reference.facts.most_impacts > 20);
  CHECK(reference.facts.self_error < 1e-16);
  const double coarse = kernel_error(sample, grid, 32, reference);
  const double fine = kernel_error(sample, grid, 256, reference);
  CHECK(coarse < 6e-3 * reference.amplitude);
  CHECK(fine < coarse / 4);  // first order: drag does not act in the rest of a step after an impact
}

TEST_CASE("a wrong law shows in the report as an error of its own size") {
  const auto sample = hailstones();
  const auto grid = own_steps(sample);
  const auto right = first_reference(sample, grid, on_one_thread());
  constexpr std::uint64_t parts = 256;
  const double error = kernel_error(sample, grid, parts, right);
  const auto changed = [&](const auto& change) {
    auto wrong = sample;
    change(std::get<dvdx::Plane>(wrong.scene.contacts.front()));
    // The start, where the paths agree, counts in their mean but not in the error's.
    const auto moments = static_cast<double>(right.path.times);
    const double size =
        distance(first_reference(wrong, grid, on_one_thread()).path, right.path) * std::sqrt(moments / (moments - 1));
    const double shown = kernel_error(wrong, grid, parts, right);
    CAPTURE(size);
    CAPTURE(shown);
    CAPTURE(error);
    CHECK(size > 5 * error);
    CHECK(std::abs(shown - size) < 2 * error);
  };
  changed([](dvdx::Plane& floor) { floor.restitution = 0.41; });
  changed([](dvdx::Plane& floor) { floor.friction = 0.31; });
  changed([](dvdx::Plane& floor) { floor.normal_viscosity = 0.02; });
}

TEST_CASE("a ball on a floor of restitution 0.51 in place of 0.5 is off by what the law says") {
  auto file = shipped("bouncing-half");
  file.duration = 0.8;
  const auto grid = own_steps(file);
  const auto right = covered(file, grid.coarsest, grid.counts);
  const auto wrong = [&] {
    auto other = file;
    std::get<dvdx::Plane>(other.scene.contacts.front()).restitution = 0.51;
    return covered(other, grid.coarsest, grid.counts);
  }();
  const auto end = right.path.index(grid.counts.size() - 1, 0, 1);
  const double fall = std::sqrt(2 / 9.81);
  const double t = grid.coarsest * static_cast<double>(grid.counts.back());
  CHECK(off(static_cast<double>(wrong.path.x[end] - right.path.x[end]), 0.01 * 9.81 * fall * (t - fall)) < 1e-15);
}

TEST_CASE("a report without a closed form says that its reference is the same kernel, and why") {
  auto bowl = one_particle({0.5, 0, 0}, {});
  bowl.name = bowl.path = "bowl";
  bowl.step = 0.01;
  bowl.duration = 0.64;
  bowl.scene.add(dvdx::Constant{.acceleration = {0, -10, 0}});
  bowl.scene.add(dvdx::Sphere{.radius = 1, .side = dvdx::Side::inside});
  const MeasureOptions options{.precisions = {dvdx::tool::Precision::float64}, .effort = Effort::quick};
  const auto report = measure_scene(bowl, options, on_one_thread(), [](double, const std::string&) {});
  CHECK(report.reference.kind == "extrapolated");
  CHECK(reference_text(report).find("the same kernel at finer steps") != std::string::npos);
  CHECK(reference_text(report).find("particle 0 slides on a sphere") != std::string::npos);
  const auto json = to_json(Report{.machine = {}, .scenes = {report}})["scenes"][0]["reference"];
  CHECK(json["kind"] == "extrapolated");
  CHECK(json["made_of"] == "finer_steps");
  CHECK(json["no_closed_form"] == "particle 0 slides on a sphere");
}

TEST_CASE("plain loops race on scenes with contacts, and are worse than the contact pass") {
  auto file = shipped("bouncing");
  file.duration = 8;
  const MeasureOptions options{.precisions = {dvdx::tool::Precision::float64}, .effort = Effort::quick};
  const auto report = measure_scene(file, options, on_one_thread(), [](double, const std::string&) {});
  CHECK(report.reference.kind == "closed_form");
  const auto worst_of = [&](const std::string& method) {
    double worst = 0;
    for (const auto& run : report.runs) {
      if (run.method == method) worst = std::max(worst, run.errors.relative);
    }
    return worst;
  };
  CHECK(worst_of("combined") < 1e-10);
  for (const char* plain : {"baseline_rk4", "baseline_leapfrog"}) {
    CAPTURE(plain);
    CHECK(worst_of(plain) > 1e-3);
    CHECK(worst_of(plain) < 10);
  }
}

}  // namespace impacts_test
