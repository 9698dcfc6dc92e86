// The report's reference, compared with external results of 20 digits.
#include "closed_form/closed_form.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "support/close.hpp"
#include "support/oracle.hpp"

namespace closed_form_test {

using dvdx::test::is_close;
using dvdx::test::Oracle;
using dvdx::tool::AxisEquation;
using dvdx::tool::AxisState;
using dvdx::tool::BounceEquation;
using dvdx::tool::solve;

// The largest error over a file: that of the position relative to the size of the motion, that of the velocity relative to the
// corresponding speed.
struct Worst {
  double error = 0;
  void take(long double value, double expected, double scale) {
    const auto off = static_cast<double>(std::abs(value - static_cast<long double>(expected))) / (std::abs(expected) + scale);
    error = std::max(error, std::isnan(off) ? 1 : off);
  }
};

TEST_CASE("linear motion in closed form") {
  const Oracle oracle("linear1d.csv");
  Worst worst;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const long double c = row["c_m"];
    AxisEquation equation{.W = row["W_1_s2"], .g = row["g_1_s"], .polynomial = {}, .sines = {}};
    equation.polynomial = {row["a_m_s2"] + equation.g * row["u_m_s"]};
    const auto end = solve(equation, {row["x0_m"] - c, row["v0_m_s"]}, row["t_s"]);
    worst.take(end.x + c, row["x_m"], 1);
    worst.take(end.v, row["v_m_s"], 1);
  }
  CHECK(worst.error < 3e-14);  // after 1e5 radians; a phase has no more digits
}

TEST_CASE("forced motion in closed form, at resonance and beside it") {
  const Oracle oracle("sinusoid1d.csv");
  Worst worst;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const AxisEquation equation{.W = row["W_1_s2"],
                                .g = row["g_1_s"],
                                .polynomial = {},
                                .sines = {{row["A_m_s2"], row["Omega_1_s"], row["phase_rad"]}}};
    const auto end = solve(equation, {row["x0_m"], row["v0_m_s"]}, row["t_s"]);
    worst.take(end.x, row["x_m"], 1);
    worst.take(end.v, row["v_m_s"], 1);
  }
  CHECK(worst.error < 1e-14);
}

TEST_CASE("polynomial forcing in closed form") {
  const Oracle oracle("poly1d.csv");
  Worst worst;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const AxisEquation equation{.W = row["W_1_s2"],
                                .g = row["g_1_s"],
                                .polynomial = {row["a0"], row["a1_per_s"], row["a2_per_s2"] / 2, row["a3_per_s3"] / 6.0L},
                                .sines = {}};
    const auto end = solve(equation, {row["x0_m"], row["v0_m_s"]}, row["t_s"]);
    worst.take(end.x, row["x_m"], 1);
    worst.take(end.v, row["v_m_s"], 1);
  }
  CHECK(worst.error < 1e-15);
}

dvdx::Vec3 vec3(const std::vector<double>& values) { return {values.at(0), values.at(1), values.at(2)}; }

// A row of multiforce3d.csv as a scene.
dvdx::tool::SceneFile scene_of(const Oracle::Row& row) {
  dvdx::tool::SceneFile file;
  file.particles = {.count = 1, .position = vec3(row.list("x0")), .velocity = vec3(row.list("v0"))};
  file.scene.mass = row["m_kg"];
  const auto stiffness = row.list("k_list");
  const auto anchors = row.list("anchors_m");
  for (std::size_t s = 0; s < stiffness.size(); ++s) {
    file.scene.add(dvdx::Spring{.stiffness = stiffness[s],
                                .anchor = dvdx::Vec3{anchors.at(3 * s), anchors.at(3 * s + 1), anchors.at(3 * s + 2)}});
  }
  file.scene.add(dvdx::Drag{.coefficient = row["drag_Ns_m"], .wind = vec3(row.list("wind_m_s"))});
  file.scene.add(dvdx::Constant{.acceleration = vec3(row.list("gravity_m_s2"))});
  file.scene.add(dvdx::Sinusoid{
      .acceleration = vec3(row.list("A_m_s2")), .angular_frequency = row["Omega_1_s"], .phase = row["phase_rad"]});
  return file;
}

TEST_CASE("many forces in space in closed form") {
  const Oracle oracle("multiforce3d.csv");
  Worst worst;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const auto state = exact_state(scene_of(row), 0, row["t_s"]);
    const std::array names{std::pair{"x", "vx"}, std::pair{"y", "vy"}, std::pair{"z", "vz"}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      worst.take(state[axis].x, row[names[axis].first], 1);
      worst.take(state[axis].v, row[names[axis].second], 1);
    }
  }
  CHECK(worst.error < 1e-15);
}

TEST_CASE("a path through several times has the states computed straight from the start") {
  const Oracle oracle("multiforce3d.csv");
  const auto file = scene_of(oracle[oracle.size() - 1]);
  const std::vector<std::uint64_t> counts{0, 3, 6, 10, 13, 1000};
  const auto path = dvdx::tool::exact_path(file, 0.01, counts);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const auto state = exact_state(file, 0, 0.01L * static_cast<long double>(counts[k]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(is_close(static_cast<double>(path.x[path.index(k, 0, axis)]), static_cast<double>(state[axis].x), 1e-13));
    }
  }
}

TEST_CASE("bounces in closed form, to the rest and beyond") {
  const Oracle oracle("bounce1d_states.csv");
  Worst worst;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const auto end = solve(BounceEquation{.acceleration = -row["g_m_s2"], .restitution = row["restitution"]},
                           {row["y0_m"], row["v0_m_s"]}, row["t_s"]);
    worst.take(end.x, row["y_m"], 1);
  }
  CHECK(worst.error < 1e-15);
}

TEST_CASE("only scenes with a closed form are said to have one") {
  using dvdx::tool::ClosedForm;
  dvdx::tool::SceneFile file;
  file.particles = {.count = 1, .position = dvdx::Vec3{0, 1, 0}, .velocity = dvdx::Vec3{}};
  file.scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  CHECK(dvdx::tool::closed_form_of(file) == ClosedForm::affine);
  file.scene.add(dvdx::Plane{.restitution = 0.5});
  CHECK(dvdx::tool::closed_form_of(file) == ClosedForm::bounce);
  auto rough = file;
  std::get<dvdx::Plane>(rough.scene.contacts[0]).friction = 0.1;
  CHECK(dvdx::tool::closed_form_of(rough) == ClosedForm::none);
  auto inside = file;
  inside.particles.position = dvdx::Vec3{0, -1, 0};
  CHECK(dvdx::tool::closed_form_of(inside) == ClosedForm::none);
  auto radial = file;
  radial.scene.contacts.clear();
  radial.scene.add(dvdx::RadialSpring{.stiffness = 1.0});
  CHECK(dvdx::tool::closed_form_of(radial) == ClosedForm::none);
}

dvdx::tool::SceneFile swinging_pair() {
  dvdx::tool::SceneFile file;
  file.particles.count = 2;
  file.particles.position = std::vector<dvdx::Vec3>{{1, 2, 0}, {1, 2, 3}};
  file.particles.velocity = std::vector<dvdx::Vec3>{{5, 0, 1}, {5, 0, -1}};
  file.scene.mass = std::vector<double>{1, 3};
  file.scene.add(dvdx::Network(dvdx::Springs{.pairs = {{1, 0}}, .stiffness = 12.0, .rest_length = 2.5}));
  file.scene.add(dvdx::Constant{.acceleration = {0, -2, 0}});
  return file;
}

TEST_CASE("two bodies on one spring swing about their centre of mass, which flies") {
  const auto file = swinging_pair();
  REQUIRE(closed_form_of(file) == dvdx::tool::ClosedForm::pair);
  const double t = 0.7;
  const double omega = 4;  // sqrt(12 (1 + 1/3))
  const double r = 2.5 + 0.5 * std::cos(omega * t) - 2 / omega * std::sin(omega * t);
  const double centre = 2.25 - 0.5 * t;
  const auto first = exact_state(file, 0, t);
  const auto second = exact_state(file, 1, t);
  CHECK(is_close(static_cast<double>(first[0].x), 1 + 5 * t, 1e-12));
  CHECK(is_close(static_cast<double>(second[1].x), 2 - t * t, 1e-12));
  CHECK(is_close(static_cast<double>(first[2].x), centre - 0.75 * r, 1e-12));
  CHECK(is_close(static_cast<double>(second[2].x), centre + 0.25 * r, 1e-12));
}

TEST_CASE("other networks have no closed form") {
  auto file = swinging_pair();
  SUBCASE("off its line") { file.particles.velocity = std::vector<dvdx::Vec3>{{1, 0, 0}, {0, 0, 0}}; }
  SUBCASE("through one another") { file.particles.velocity = std::vector<dvdx::Vec3>{{0, 0, 99}, {0, 0, 0}}; }
  SUBCASE("damped") { std::get<dvdx::Springs>(file.scene.networks[0]).damping = 1; }
  SUBCASE("one of them fixed") { file.scene.fixed = {0}; }
  SUBCASE("a constraint") { file.scene.add(dvdx::Constraint(dvdx::OnPoint{.particle = 0, .at = {1, 2, 0}})); }
  SUBCASE("a floor") { file.scene.add(dvdx::Plane{.offset = -9}); }
  CHECK(closed_form_of(file) == dvdx::tool::ClosedForm::none);
}

dvdx::tool::SceneFile balls(std::vector<dvdx::Vec3> x, std::vector<dvdx::Vec3> v, dvdx::Meet meet) {
  dvdx::tool::SceneFile file;
  file.particles = {.count = x.size(), .position = std::move(x), .velocity = std::move(v)};
  file.scene.add(std::move(meet));
  return file;
}

TEST_CASE("two balls meet once and share their momentum, and friction at most stops their slide") {
  // The heavier ball comes from the left, half a diameter off the other's centre line: the normal is at 30 degrees.
  auto file = balls({{-2, 0, 0}, {0, 0.5, 0}}, {{4, 0, 0}, {0, 0, 0}}, {.radius = 0.5, .restitution = 0.5});
  file.scene.mass = std::vector<double>{3, 1};
  file.scene.add(dvdx::Constant{.acceleration = {0, -2, 0}});
  REQUIRE(closed_form_of(file) == dvdx::tool::ClosedForm::balls);
  const double hit = (2 - std::sqrt(0.75)) / 4;
  const double c = std::sqrt(0.75), s = 0.5;            // the normal, from the first ball to the second
  const double pulse = 1.5 * 4 * c / (1.0 / 3 + 1);     // kg m/s
  const auto check = [&](double rub_x, double rub_y) {  // m/s, of the first; three times as much of the second
    const double t = 1.25;
    const auto first = exact_state(file, 0, t);
    const auto second = exact_state(file, 1, t);
    const double vx = 4 - pulse * c / 3 + rub_x, vy = -pulse * s / 3 + rub_y;
    CHECK(is_close(static_cast<double>(first[0].v), vx, 1e-14));
    CHECK(is_close(static_cast<double>(first[1].v), vy - 2 * t, 1e-14));
    CHECK(is_close(static_cast<double>(first[0].x), -2 + 4 * hit + vx * (t - hit), 1e-14));
    CHECK(is_close(static_cast<double>(first[1].x), vy * (t - hit) - t * t, 1e-14));
    CHECK(is_close(static_cast<double>(second[0].v), pulse * c - 3 * rub_x, 1e-14));
    CHECK(is_close(static_cast<double>(second[1].v), pulse * s - 3 * rub_y - 2 * t, 1e-14));
  };
  check(0, 0);
  const double slide = 4 * s;  // speed of the first ball against the second, along (s, -c)
  file.scene.meet->friction = 0.1;
  check(-0.1 * pulse / 3 * s, 0.1 * pulse / 3 * c);
  file.scene.meet->friction = 9;
  check(-slide / 4 * s, slide / 4 * c);
}

TEST_CASE("balls that pass one another have no impact") {
  const auto file = balls({{0, 0, 0}, {5, 2, 0}}, {{1, 0, 0}, {-1, 0, 0}}, {.radius = 0.5});
  CHECK(static_cast<double>(exact_state(file, 0, 8)[0].x) == 8);
  CHECK(static_cast<double>(exact_state(file, 1, 8)[0].v) == -1);
}

TEST_CASE("a cradle sends out as many balls as come in") {
  for (std::size_t coming = 1; coming <= 3; ++coming) {
    CAPTURE(coming);
    std::vector<dvdx::Vec3> x, v;
    for (std::size_t i = 0; i < 5; ++i) {
      x.push_back({static_cast<double>(i) - (i < coming ? 1 : 0), 0, 0});
      v.push_back({i < coming ? 2.0 : 0.0, 0, 0});
    }
    const auto file = balls(x, v, {.radius = 0.5, .restitution = 1});
    REQUIRE(closed_form_of(file) == dvdx::tool::ClosedForm::balls);
    for (std::size_t i = 0; i < 5; ++i) {
      const bool leaves = i + coming >= 5;
      const auto state = exact_state(file, i, 2);  // the impact is at 0.5 s
      CHECK(static_cast<double>(state[0].v) == (leaves ? 2 : 0));
      CHECK(is_close(static_cast<double>(state[0].x), static_cast<double>(i) + (leaves ? 3 : 0), 1e-15));
    }
  }
}

TEST_CASE("other balls have no closed form") {
  auto file = balls({{0, 0, 0}, {2, 0, 0}, {4, 0, 0}}, {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {.radius = 0.5, .restitution = 1});
  REQUIRE(closed_form_of(file) == dvdx::tool::ClosedForm::balls);
  SUBCASE("three that lose energy") { file.scene.meet->restitution = 0.9; }
  SUBCASE("three of several masses") { file.scene.mass = std::vector<double>{1, 1, 2}; }
  SUBCASE("one beside the row") { file.particles.position = std::vector<dvdx::Vec3>{{0, 0, 0}, {2, 0.1, 0}, {4, 0, 0}}; }
  SUBCASE("overlapping") { file.particles.position = std::vector<dvdx::Vec3>{{0, 0, 0}, {0.9, 0, 0}, {4, 0, 0}}; }
  SUBCASE("groups") { file.scene.meet->groups.emplace(); }
  SUBCASE("drag") { file.scene.add(dvdx::Drag{.coefficient = 1.0}); }
  SUBCASE("a floor") { file.scene.add(dvdx::Plane{.offset = -9}); }
  CHECK(closed_form_of(file) == dvdx::tool::ClosedForm::none);
}

}  // namespace closed_form_test
