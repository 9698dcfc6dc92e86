// The report of contacts' effects on particles, compared with closed forms.
#include "dvdx/contact_report.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/contact_reports.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/close.hpp"
#include "support/oracle.hpp"

namespace contact_reports::contact_report_test {

using test::is_close;

double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double size(const Vec3& a) { return std::sqrt(product(a, a)); }

TEST_CASE("report: a bouncing ball's impacts have the times and impulses of the closed form") {
  const test::Oracle oracle("bounce1d_times.csv");
  constexpr double mass = 2;
  std::size_t compared = 0;
  std::unique_ptr<Reported<double>> run;
  std::string last;
  std::size_t index = 0;
  for (std::size_t n = 0; n < oracle.size(); ++n) {
    const auto row = oracle[n];
    const double e = row["restitution"];
    const double gravity = row["g_m_s2"];
    if (row.text("case") != last) {
      last = row.text("case");
      index = 0;
      Scene scene = falling(mass, {0, -gravity, 0});
      scene.add(Plane{.normal = {0, 1, 0}, .restitution = e});
      const std::array<Vec3, 2> start{Vec3{0.5, row["y0_m"], 0}, Vec3{0, row["v0_m_s"], 0}};
      run = std::make_unique<Reported<double>>(scene, std::vector{start}, 240);
    }
    const double speed = row["impact_speed_m_s"];
    const double time = row["t_bounce_s"];
    const bool settles = e < 1 && 2 * e * speed <= gravity * (1 - e) * h;
    if (settles || time > 239 * h || index >= run->report.events().size()) {
      CHECK((settles || time > 239 * h));
      index = run->report.events().size();
      continue;
    }
    const ContactEvent& event = run->report.events()[index++];
    CAPTURE(last);
    CAPTURE(index);
    CHECK(std::abs(event.time - time) <= 1e-10);
    CHECK(std::abs(event.impulse[1] + mass * (1 + e) * speed) <= 1e-9);
    CHECK(event.step == static_cast<std::uint64_t>(std::ceil(event.time / h)));
    CHECK(std::abs(event.x[1]) <= 1e-12);
    CHECK(event.n == Vec3{0, 1, 0});
    ++compared;
  }
  CHECK(compared > 100);
}

TEST_CASE_TEMPLATE("report: a particle that rests on a surface presses with m g t, whatever else acts on it", T, float,
                   double) {
  constexpr std::size_t steps = 600;
  constexpr double weight = 2 * g * h * steps;
  const double eps = std::is_same_v<T, float> ? 1e-5 : 1e-12;
  const std::vector<std::array<Vec3, 2>> at_rest{{Vec3{1, 0, 0}, Vec3{}}};
  SUBCASE("a plane; the torque is about the origin") {
    Scene scene = falling();
    scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5});
    const Reported<T> run(scene, at_rest, steps);
    const ContactSum sum = run.report.of(0);
    CHECK(sum.hits == 0);
    CHECK(run.report.events().empty());
    CHECK(is_close(sum.impulse[1], -weight, eps));
    CHECK(is_close(sum.torque_impulse[2], -weight, eps));
    CHECK(sum.impulse[0] == 0);
    CHECK(sum.torque_impulse[0] == 0);
  }
  SUBCASE("inside of a sphere, at its lowest point; the torque is about its center") {
    Scene scene = falling();
    scene.add(Sphere{.center = {1, 2, 0}, .radius = 2, .side = Side::inside});
    const Reported<T> run(scene, at_rest, steps);
    CHECK(is_close(run.report.of(0).impulse[1], -weight, eps));
    CHECK(run.report.events().empty());
    CHECK(size(run.report.of(0).torque_impulse) <= 1e-12 * weight);
  }
  SUBCASE("drag and a spring bend the paths") {
    Scene scene = falling();
    scene.add(Drag{.coefficient = 3.0});
    scene.add(Spring{.stiffness = 50, .damping = 0.3, .anchor = Vec3{1, 0.25, 0}});
    scene.add(Plane{.normal = {0, 1, 0}});
    const Reported<T> run(scene, at_rest, steps);
    CHECK(is_close(run.report.of(0).impulse[1], -(2 * g - 50 * 0.25) * h * steps, 10 * eps));
  }
  SUBCASE("a corner of three planes: each takes its part") {
    Scene scene = falling(2, {-1, -2, -3});
    scene.add(Plane{.normal = {1, 0, 0}, .offset = 1});
    scene.add(Plane{.normal = {0, 1, 0}});
    scene.add(Plane{.normal = {0, 0, 1}});
    const Reported<T> run(scene, at_rest, steps);
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double expected = j == axis ? -2 * static_cast<double>(j + 1) * h * steps : 0;
        CHECK(std::abs(run.report.of(j).impulse[axis] - expected) <= eps * weight);
      }
    }
  }
}

TEST_CASE(
    "report: on an incline friction takes mu m g cos(alpha) t while a ball slides, and all of its weight while it sticks") {
  constexpr double alpha = 0.5;
  constexpr std::size_t steps = 120;
  constexpr double impulse = 2 * g * h * steps;
  const Vec3 n{std::sin(alpha), std::cos(alpha), 0};
  const Vec3 down{std::cos(alpha), -std::sin(alpha), 0};
  for (const double mu : {0.0, 0.25, 1.0}) {
    CAPTURE(mu);
    Scene scene = falling();
    scene.add(Plane{.normal = n, .friction = mu});
    const Reported<double> run(scene, {{Vec3{}, Vec3{}}}, steps);
    const Vec3 on_surface = run.report.of(0).impulse;
    const double friction = mu < std::tan(alpha) ? mu * std::cos(alpha) : std::sin(alpha);
    CHECK(is_close(product(on_surface, n), -impulse * std::cos(alpha), 1e-10));
    CHECK(std::abs(product(on_surface, down) - impulse * friction) <= 1e-10 * impulse);
  }
}

TEST_CASE_TEMPLATE("report: a particle that slides on a curved surface with friction has no impact and feels no viscosity", T,
                   float, double) {
  const std::array<Vec3, 2> in_bowl{Vec3{0.8, 0.4, 0}, Vec3{}};
  const std::array<Vec3, 2> on_top{Vec3{0.5, std::sqrt(0.75), 0}, Vec3{}};
  const auto speed_of = [](const Contact& contact, const std::array<Vec3, 2>& start, std::size_t steps) {
    Scene scene = falling(1);
    scene.add(contact);
    const Reported<T> run(scene, {start}, steps, 0.4 / static_cast<double>(steps));
    CHECK(run.report.of(0).hits == 0);
    return size({run.end.v[0][0], run.end.v[1][0], run.end.v[2][0]});
  };
  for (const std::size_t steps : {20U, 40U, 160U}) {
    CAPTURE(steps);
    for (const double viscosity : {0.0, 0.5}) {
      const Sphere bowl{.center = {0, 1, 0}, .radius = 1, .side = Side::inside, .friction = 0.3, .viscosity = viscosity};
      const Sphere ball{.center = {}, .radius = 1, .friction = 0.3, .viscosity = viscosity};
      const Capsule capsule{.ends = {Vec3{0, 0, -1}, Vec3{0, 0, 1}}, .radius = {1, 1}, .friction = 0.3, .viscosity = viscosity};
      // The equation of the angle by Runge-Kutta, 0.4 s: speeds of 1.7449 and 1.2633 m/s, accurate to first order in the step.
      const double within = 0.04 * 20 / static_cast<double>(steps);
      CHECK(std::abs(speed_of(bowl, in_bowl, steps) - 1.7449) < within);
      CHECK(std::abs(speed_of(ball, on_top, steps) - 1.2633) < within);
      CHECK(std::abs(speed_of(capsule, on_top, steps) - 1.2633) < within);
    }
  }
}

TEST_CASE_TEMPLATE("report: a contact without an impulse is not reported as an impact", T, float, double) {
  Scene scene = falling(1);
  scene.add(Capsule{.ends = {Vec3{-1, -0.3, 0}, Vec3{1, -0.3, 0}}, .radius = {0.3, 0.3}, .friction = 0.3});
  std::vector<std::array<Vec3, 2>> start;
  for (int i = 0; i < 800; ++i) {
    const auto drawn = [&](double ratio) { return std::fmod(i * ratio, 1.0) - 0.5; };
    start.push_back({Vec3{drawn(0.618), 0.1 + 0.2 * drawn(0.755), drawn(0.57)}, Vec3{1, -1, 0}});
  }
  const Reported<T> run(scene, start, 100, 0.01);
  CHECK(run.report.events().size() > 200);
  for (const ContactEvent& event : run.report.events()) CHECK(size(event.impulse) > 0);
}

TEST_CASE("report: cloth that lies and slides on a floor and a ball has one impact a particle, in every scheme") {
  constexpr std::size_t side = 6;
  const Sphere ball{.center = {0.25, -1, 0.25}, .radius = 1, .friction = 0.8, .viscosity = 0.5};
  const Plane floor{.normal = {0, 1, 0}, .viscosity = 0.5};
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
    CAPTURE(static_cast<int>(scheme));
    const auto hits_of = [&](const Contact& contact, double height, double vx, double* left) {
      Scene scene = falling(0.1 / (side * side));
      scene.coupling = {.scheme = scheme, .substeps = 16};
      Grid grid{.rows = side, .columns = side, .edge_u = {0.5, 0, 0}, .edge_v = {0, 0, 0.5}, .structural = 50, .shear = 20};
      grid.bend = 1;
      grid.damping = 0.02;
      scene.add(Network(grid));
      scene.add(contact);
      std::vector<std::array<Vec3, 2>> start;
      for (std::size_t i = 0; i < side * side; ++i) {
        start.push_back(
            {Vec3{0.1 * static_cast<double>(i % side), height, 0.1 * static_cast<double>(i / side)}, Vec3{vx, 0, 0}});
      }
      const Reported<double> run(scene, start, 30, 0.01);
      *left = run.end.v[0][7];
      return run.report.of(0).hits;
    };
    double left = 0;
    CHECK(hits_of(floor, 0, 1, &left) == 0);
    CHECK(is_close(left, 1, 1e-9));
    CHECK(hits_of(floor, 0.05, 1, &left) == side * side);
    CHECK(is_close(left, std::exp(-0.5), 1e-6));
    if (scheme == Scheme::fourth_order) continue;
    CHECK(hits_of(ball, 0.02, 0, &left) < (scheme == Scheme::leapfrog ? 2 : 10) * side * side);
  }
}

TEST_CASE("report: friction of an impact turns a sphere about its center") {
  constexpr double mu = 0.3;
  constexpr double e = 0.5;
  constexpr double m = 2;
  Scene scene;
  scene.mass = m;
  scene.add(Sphere{.center = {5, 1, 0}, .radius = 1, .restitution = e, .friction = mu});
  // Without forces the particle moves straight to the sphere's top, at 4 m/s along it and 1 m/s onto it.
  const Reported<double> run(scene, {{Vec3{4, 2.25, 0}, Vec3{4, -1, 0}}}, 30);
  REQUIRE(run.report.events().size() == 1);
  const ContactEvent& event = run.report.events()[0];
  const ContactSum sum = run.report.of(0);
  const double pressed = size(event.impulse);
  CHECK(sum.hits == 1);
  CHECK(sum.impulse == event.impulse);
  // The closed form: the intersection of the line with the sphere, and the remaining velocity there.
  const Vec3 r{event.x[0] - 5, event.x[1] - 1, event.x[2]};
  CHECK(is_close(size(r), 1, 1e-12));
  CHECK(is_close(event.x[1], 2.25 - event.time, 1e-12));
  const double vn = product(r, {4, -1, 0});
  const double along = std::sqrt(17 - vn * vn);
  const double N = m * (1 + e) * -vn;
  CHECK(mu * N < m * along);
  CHECK(is_close(pressed, N * std::sqrt(1 + mu * mu), 1e-12));
  CHECK(is_close(sum.torque_impulse[2], -mu * N, 1e-12));
}

TEST_CASE("report: momentum is kept between particles, surfaces and gravity") {
  constexpr std::size_t count = 500;
  constexpr std::size_t steps = 240;
  constexpr double mass = 0.25;
  Scene scene = falling(mass, {0.5, -g, 0.25});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4, .friction = 0.3, .viscosity = 0.1});
  scene.add(Plane{.normal = {1, 1, 0}, .offset = -0.5, .restitution = 0.8});
  scene.add(Plane{.normal = {-1, 0.2, 0.1}, .offset = -1, .friction = 0.5});
  scene.add(Sphere{.center = {0, 0.2, 0}, .radius = 0.5, .restitution = 0.6, .friction = 0.2});
  scene.add(Sphere{.center = {0, 0, 0}, .radius = 1.8, .side = Side::inside, .restitution = 0.2});
  std::vector<std::array<Vec3, 2>> start(count);
  Vec3 before{};
  for (std::size_t i = 0; i < count; ++i) {
    start[i] = {Vec3{test::scatter(i, 0), 1.2 + test::scatter(i, 1), test::scatter(i, 2)},
                Vec3{test::scatter(i, 3), test::scatter(i, 4), test::scatter(i, 5)}};
    for (std::size_t k = 0; k < 3; ++k) before[k] += mass * start[i][1][k];
  }
  const Reported<double> run(scene, start, steps, h, 1 << 20);
  Vec3 given{};
  std::uint64_t hits = 0;
  for (std::size_t j = 0; j < scene.contacts.size(); ++j) {
    const ContactSum sum = run.report.of(j);
    CAPTURE(j);
    CHECK(sum.hits > 0);
    hits += sum.hits;
    for (std::size_t k = 0; k < 3; ++k) given[k] += sum.impulse[k];
  }
  CHECK(run.report.events().size() == hits);
  CHECK(run.report.lost() == 0);
  const Vec3 a{0.5, -g, 0.25};
  for (std::size_t k = 0; k < 3; ++k) {
    double after = 0;
    for (std::size_t i = 0; i < count; ++i) after += mass * run.end.v[k][i];
    const double of_gravity = static_cast<double>(count) * mass * a[k] * h * steps;
    CHECK(std::abs((before[k] + of_gravity) - (after + given[k])) <= 1e-10 * static_cast<double>(count) * mass * g * h * steps);
  }
}

// Pulses of springs press and pull resting particles, two walls take them up at once, and no scheme loses a pulse.
TEST_CASE("report: momentum is kept between a ring of springs, an edge that it falls into, and gravity") {
  constexpr std::size_t count = 12;
  constexpr std::size_t steps = 150;
  constexpr double mass = 0.01;
  constexpr Vec3 u{0.3, 0.1, -0.2};  // m/s, of the surfaces
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential, Scheme::accumulate}) {
    for (const double friction : {0.0, 0.4}) {
      for (const bool moves : {false, true}) {
        CAPTURE(static_cast<int>(scheme));
        CAPTURE(friction);
        CAPTURE(moves);
        Scene scene = falling(mass);
        scene.coupling.scheme = scheme;
        if (scheme == Scheme::accumulate) scene.coupling.method = Method::combined;
        Springs springs{.pairs = {}, .stiffness = 20.0, .damping = 0.02};
        std::vector<std::array<Vec3, 2>> start(count);
        for (std::size_t i = 0; i < count; ++i) {
          const double turn = 6.2831853 * static_cast<double>(i) / count;
          start[i] = {Vec3{0.1 + 0.3 * std::cos(turn), 0.5 + 0.3 * std::sin(turn), 0.02 * test::scatter(i, 0)}, Vec3{}};
          for (const std::size_t apart : {std::size_t{1}, count / 2}) {
            const std::size_t j = (i + apart) % count;
            if (apart == 1 || i < j) springs.pairs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
          }
        }
        scene.add(Network(springs));
        scene.add(Plane{.normal = {0.5, 0.8660254, 0}, .friction = friction});
        scene.add(Plane{.normal = {-0.5, 0.8660254, 0}, .friction = friction});
        if (moves) {
          scene.add(Motion{.keys = {{.time = 0}, {.time = 10, .translation = {10 * u[0], 10 * u[1], 10 * u[2]}}}});
          for (Contact& contact : scene.contacts) std::get<Plane>(contact).motion = 0;
        }
        const Reported<double> run(scene, start, steps);
        Vec3 given{};
        for (std::size_t j = 0; j < scene.contacts.size(); ++j) {
          for (std::size_t k = 0; k < 3; ++k) given[k] += run.report.of(j).impulse[k];
        }
        CHECK(run.report.of(0).hits > 0);
        const double weight = count * mass * g * h * steps;
        for (std::size_t k = 0; k < 3; ++k) {
          double after = 0;
          for (std::size_t i = 0; i < count; ++i) after += mass * run.end.v[k][i];
          CHECK(std::abs(after + given[k] + (k == 1 ? weight : 0)) <= 1e-10 * weight);
        }
      }
    }
  }
}

TEST_CASE("report: a moving surface gets impulses as one at rest does, and torque about its moved center") {
  constexpr std::size_t steps = 60;
  constexpr double weight = 2 * g * h * steps;
  const Vec3 u{1.5, 0.75, 0};
  const auto carried = [&](Contact contact, const Vec3& center) {
    Scene scene = falling();
    scene.add(Motion{.center = center, .keys = {{.time = 0}, {.time = 4, .translation = {6, 3, 0}}}});
    std::visit([](auto& c) { c.motion = 0; }, contact);
    return scene.add(contact);
  };
  SUBCASE("a particle on a floor that goes along with it") {
    const Scene scene = carried(Plane{.normal = {0, 1, 0}, .friction = 1}, {0.25, 0, 0});
    const Reported<double> run(scene, {{Vec3{1, 0, 0}, u}}, steps);
    CHECK(run.report.of(0).hits == 0);
    CHECK(is_close(run.report.of(0).impulse[1], -weight, 1e-10));
    CHECK(is_close(run.report.of(0).torque_impulse[2], -0.75 * weight, 1e-10));
  }
  SUBCASE("particles on a slope that goes along with it: roundings are no impacts") {
    const Scene scene = carried(Plane{.normal = {0.6, 0.8, 0}, .friction = 1}, {0.25, 0, 0});
    std::vector<std::array<Vec3, 2>> start;
    for (int k = -32; k < 32; ++k) start.push_back({Vec3{0.48 * k, -0.36 * k, 0.1 * k}, u});
    CHECK(Reported<float>(scene, start, steps).report.of(0).hits == 0);
    CHECK(Reported<double>(scene, start, steps).report.of(0).hits == 0);
  }
  SUBCASE("a particle that falls onto it bounces as on one at rest") {
    const Plane floor{.normal = {0, 1, 0}, .restitution = 0.5};
    const Reported<double> moving(carried(floor, {0.25, 0, 0}), {{Vec3{1, 1, 0}, u}}, steps);
    Scene still = falling();
    still.add(floor);
    const Reported<double> resting(still, {{Vec3{1, 1, 0}, Vec3{}}}, steps);
    REQUIRE(moving.report.events().size() == resting.report.events().size());
    CHECK(resting.report.events().size() >= 2);
    for (std::size_t n = 0; n < resting.report.events().size(); ++n) {
      const ContactEvent& a = moving.report.events()[n];
      const ContactEvent& b = resting.report.events()[n];
      CHECK(std::abs(a.time - b.time) <= 1e-12);
      CHECK(std::abs(a.impulse[1] - b.impulse[1]) <= 1e-11);
      CHECK(std::abs(a.x[1] - u[1] * a.time) <= 1e-11);
    }
    CHECK(is_close(moving.report.of(0).torque_impulse[2], 0.75 * moving.report.of(0).impulse[1], 1e-10));
  }
}

}  // namespace contact_reports::contact_report_test
