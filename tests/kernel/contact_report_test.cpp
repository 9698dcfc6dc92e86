// The report of how contacts act on particles: against closed forms, and the same on every way to step.
#include "dvdx/contact_report.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/oracle.hpp"
#include "support/threads.hpp"

namespace contact_report_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Joined;
using test::Layout;

constexpr double g = 9.81;
constexpr double h = 1.0 / 60;

double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double size(const Vec3& a) { return std::sqrt(product(a, a)); }

Scene falling(double mass = 2, const Vec3& acceleration = {0, -g, 0}) {
  Scene scene;
  scene.mass = mass;
  scene.add(Constant{.acceleration = acceleration});
  return scene;
}

// A few particles and the report of their steps.
template <class T>
struct Reported {
  Reported(const Scene& scene, const std::vector<std::array<Vec3, 2>>& start, std::size_t steps, double step = h,
           std::size_t capacity = 4096)
      : room(capacity), report(scene.contacts.size(), room), memory(start.size()) {
    State<T> state = memory.view();
    for (std::size_t i = 0; i < start.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state.x[axis][i] = static_cast<T>(start[i][0][axis]);
        state.v[axis][i] = static_cast<T>(start[i][1][axis]);
      }
    }
    auto plan = compile<T>(scene, {.step = step}, state);
    REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
    REQUIRE(plan->step(state, report, steps) == StepResult::done);
    end = state;
  }

  std::vector<ContactEvent> room;
  ContactReport report;
  Soa<T> memory;
  State<T> end;
};

// Every word and event of a report, as bytes.
std::string bytes_of(const ContactReport& report) {
  std::string bytes;
  const auto add = [&](const auto& of) { bytes.append(reinterpret_cast<const char*>(of.data()), of.size_bytes()); };
  for (std::size_t j = 0; j < report.contacts(); ++j) {
    const ContactSum sum = report.of(j);
    bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  }
  add(report.events());
  return bytes;
}

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

TEST_CASE_TEMPLATE("report: what rests on a surface presses with m g t, whatever else acts on it", T, float, double) {
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

TEST_CASE_TEMPLATE("report: what slides on a curved surface with friction meets no impact, and no viscosity at any step", T,
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
      // The angle's equation by Runge and Kutta, 0.4 s: speeds of 1.7449 and 1.2633 m/s, to first order in the step.
      const double within = 0.04 * 20 / static_cast<double>(steps);
      CHECK(std::abs(speed_of(bowl, in_bowl, steps) - 1.7449) < within);
      CHECK(std::abs(speed_of(ball, on_top, steps) - 1.2633) < within);
      CHECK(std::abs(speed_of(capsule, on_top, steps) - 1.2633) < within);
    }
  }
}

TEST_CASE_TEMPLATE("report: what meets a surface and gets no impulse from it is no impact", T, float, double) {
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
  // Without forces it goes straight to the sphere's top, at 4 m/s along and 1 m/s onto it.
  const Reported<double> run(scene, {{Vec3{4, 2.25, 0}, Vec3{4, -1, 0}}}, 30);
  REQUIRE(run.report.events().size() == 1);
  const ContactEvent& event = run.report.events()[0];
  const ContactSum sum = run.report.of(0);
  const double pressed = size(event.impulse);
  CHECK(sum.hits == 1);
  CHECK(sum.impulse == event.impulse);
  // By the closed form: where the line meets the sphere, and what remains of the velocity there.
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

// Pulses of springs press and pull what stands still, two walls take them at once, and in no scheme is one of them lost.
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

TEST_CASE("report: a moving surface is told of impulses as one at rest, and of torque about its moved center") {
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

// ---- the same on every way to step ---------------------------------------------------------------------------------------

struct Way {
  Isa isa;
  Layout layout;
  std::size_t threads, block, together;
};

std::vector<Way> ways(Arithmetic arithmetic) {
  std::vector<Way> all{{Isa::reference, Layout::soa_padded, 1, 0, 30}};
  for (const Isa isa : available_isas(arithmetic)) {
    all.push_back({isa, Layout::soa_padded, 1, 16, 1});
    all.push_back({isa, Layout::aos, 3, 0, 30});
    all.push_back({isa, Layout::aosoa8, 2, 64, 7});
  }
  return all;
}

// In sweeps: a plan goes through them one after the other, all steps of a call at a time.
Joined two_sheets() {
  Joined joined = test::sheet(12, 17, 30);
  joined.scene.coupling.scheme = Scheme::sequential;
  const std::size_t count = joined.x.size();
  Grid second = std::get<Grid>(joined.scene.networks[0]);
  second.first = count;
  joined.scene.networks.emplace_back(second);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({joined.x[i][0], joined.x[i][1] + 0.02, joined.x[i][2]});
    joined.v.push_back(joined.v[i]);
  }
  return joined;
}

template <class T, class Place>
void compare_ways(const Scene& scene, std::size_t count, double step, Arithmetic arithmetic, const Place& place) {
  constexpr std::size_t steps = 20;
  std::string expected;
  std::vector<T> unreported;  // where a plan leads that reports nothing
  for (const Way& way : ways(arithmetic)) {
    CAPTURE(name(way.isa));
    CAPTURE(test::name(way.layout));
    CAPTURE(way.block);
    Batch<T> batch(way.layout, count);
    place(batch.view());
    const auto plan =
        compile<T>(scene, {.step = step, .isa = way.isa, .arithmetic = arithmetic, .block = way.block}, batch.view());
    REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
    std::vector<ContactEvent> room(1 << 16);
    ContactReport report(scene.contacts.size(), room);
    test::Threads threads(way.threads);
    for (std::size_t done = 0; done < steps; done += way.together) {
      const std::size_t now = std::min(way.together, steps - done);
      REQUIRE(plan->step(batch.view(), report, now, threads.parallel_for()) == StepResult::done);
    }
    CHECK(report.lost() == 0);
    CHECK(report.steps() == steps);
    if (expected.empty()) {
      Batch<T> plain(way.layout, count);
      place(plain.view());
      REQUIRE(plan->step(plain.view(), steps) == StepResult::done);
      unreported = test::values_of(plain.view());
      expected = bytes_of(report);
      CHECK(report.events().size() > 60);
    }
    CHECK(test::difference(test::values_of(batch.view()), unreported) == "");
    CHECK(bytes_of(report) == expected);
    CHECK(std::is_sorted(report.events().begin(), report.events().end(), [](const ContactEvent& a, const ContactEvent& b) {
      return std::tie(a.step, a.particle, a.time) < std::tie(b.step, b.particle, b.time);
    }));
  }
}

TEST_CASE_TEMPLATE(
    "report: the same on every instruction set, layout, block and number of threads, and no bit of the state is "
    "another",
    T, float, double) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    CAPTURE(name(arithmetic));
    SUBCASE("free particles, some of them fixed") {
      Scene scene = falling(0.1);
      scene.add(Drag{.coefficient = 0.02});
      scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.2});
      scene.add(Plane{.normal = {1, 2, 0}, .offset = -0.2, .friction = 0.4});
      scene.add(Sphere{.center = {0, 0.1, 0}, .radius = 0.5, .restitution = 0.7});
      scene.fixed = {3, 40, 41};
      compare_ways<T>(scene, 219, h, arithmetic, [](State<T>& state) {
        for (std::size_t i = 0; i < state.count; ++i) {
          for (std::size_t k = 0; k < 3; ++k) {
            state.x[k][i] = static_cast<T>(1 + test::scatter(i, k));
            state.v[k][i] = static_cast<T>(3 * test::scatter(i, 3 + k));
          }
        }
      });
    }
    SUBCASE("particles rest on planes, slide, bounce and are pressed from one onto another, some of them fixed") {
      for (const std::size_t planes : {std::size_t{1}, std::size_t{3}}) {
        // Every pair of arithmetic, drag and number of planes.
        const double drag = (planes == 1) == (arithmetic == Arithmetic::separate) ? 0.0 : 0.05;
        Scene scene = falling(0.1, {3, -9.81, -2});
        std::vector<double> masses(219);
        for (std::size_t i = 0; i < masses.size(); ++i) masses[i] = 0.1 + 0.001 * static_cast<double>(i % 90);
        scene.mass = masses;
        if (drag > 0) scene.add(Drag{.coefficient = drag});
        scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.2});
        if (planes > 1) scene.add(Plane{.normal = {-1, 0.2, 0}, .offset = -1, .restitution = 0.3, .friction = 0.4});
        if (planes > 1) scene.add(Plane{.normal = {0, 0.1, 1}, .offset = -1});
        scene.fixed = {3, 40, 41};
        compare_ways<T>(scene, 219, h, arithmetic, [](State<T>& state) {
          for (std::size_t i = 0; i < state.count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
              state.x[k][i] = static_cast<T>(0.9 * test::scatter(i, k));
              state.v[k][i] = static_cast<T>(i % 3 == 0 ? 0 : test::scatter(i, 3 + k));
            }
            if (i % 2 == 0) state.x[1][i] = 0;
            if (i % 4 == 0) state.v[1][i] = 0;
          }
        });
      }
    }
    SUBCASE("a sheet that falls on a sphere") {
      for (Joined cloth : {test::sheet(12, 17, 30), test::as_list(test::sheet(12, 17, 30)), two_sheets()}) {
        cloth.scene.add(Sphere{.center = {0.5, -0.12, 0.5}, .radius = 0.1, .friction = 0.5});
        cloth.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.06, .restitution = 0.3});
        compare_ways<T>(cloth.scene, cloth.x.size(), cloth.step, arithmetic,
                        [&](State<T>& state) { test::place(cloth, state); });
      }
    }
  }
}

TEST_CASE("report: events tell of particles by the caller's numbers, in whichever order sweeps walk them") {
  Joined sheet = test::as_list(test::sheet(12, 37, 30));
  sheet.scene.coupling = {.scheme = Scheme::sequential, .substeps = 2};
  sheet.scene.add(Sphere{.center = {0.5, -0.12, 0.5}, .radius = 0.1, .friction = 0.5});
  const std::vector<std::uint32_t> place = test::shuffled_behind_first(sheet.x.size());
  const auto events = [](const Joined& joined) {
    std::vector<std::array<Vec3, 2>> start;
    for (std::size_t i = 0; i < joined.x.size(); ++i) start.push_back({joined.x[i], joined.v[i]});
    const Reported<double> run(joined.scene, start, 60, h, 1 << 16);
    return std::vector<ContactEvent>(run.report.events().begin(), run.report.events().end());
  };
  std::vector<ContactEvent> expected = events(sheet);
  CHECK(expected.size() > 100);
  for (ContactEvent& event : expected) event.particle = place[event.particle];
  std::sort(expected.begin(), expected.end(), [](const ContactEvent& a, const ContactEvent& b) {
    return std::tie(a.step, a.particle, a.time) < std::tie(b.step, b.particle, b.time);
  });
  const std::vector<ContactEvent> found = events(test::in_order(sheet, place));
  REQUIRE(found.size() == expected.size());
  for (std::size_t n = 0; n < found.size(); ++n) {
    CHECK(found[n].particle == expected[n].particle);
    CHECK(found[n].time == expected[n].time);
    CHECK(found[n].x == expected[n].x);
    CHECK(found[n].impulse == expected[n].impulse);
  }
}

TEST_CASE_TEMPLATE("report: of particles that come and go", T, float, double) {
  Scene scene = falling(0.01);
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  for (const SurvivorOrder order : {SurvivorOrder::kept, SurvivorOrder::any}) {
    Lifecycle turnover;
    turnover.capacity = 1024;
    turnover.emitters = {{.shape = Disc{.center = {0, 0.1, 0}, .radius = 0.05},
                          .rate = 1500,
                          .velocity = {0, 1, 0},
                          .spread = 0.5,
                          .least_lifetime = 0.2,
                          .most_lifetime = 0.6,
                          .seed = 5}};
    turnover.removal.order = order;
    std::string expected;
    for (const Way& way : ways(Arithmetic::separate)) {
      Batch<T> batch(way.layout, turnover.capacity), plain(way.layout, turnover.capacity);
      Batch<T> lives(way.layout, turnover.capacity), plain_lives(way.layout, turnover.capacity);
      const auto living = [](Batch<T>& of, Batch<T>& ages) {
        LiveState<T> live{.state = of.view(), .age = ages.view().x[0], .lifetime = ages.view().x[1]};
        live.state.count = 0;
        return live;
      };
      LiveState<T> live = living(batch, lives);
      LiveState<T> same = living(plain, plain_lives);
      auto plan = compile<T>(scene, turnover, Options{.step = h, .isa = way.isa});
      REQUIRE(plan.has_value());
      std::vector<ContactEvent> room(1 << 16);
      ContactReport report(1, room);
      test::Threads threads(way.threads);
      for (std::size_t done = 0; done < 45; done += way.together) {
        REQUIRE(plan->step(live, report, std::min(way.together, 45 - done), threads.parallel_for()) == StepResult::done);
      }
      REQUIRE(plan->step(same, 45) == StepResult::done);
      REQUIRE(live.state.count == same.state.count);
      CHECK(state_hash(live.state) == state_hash(same.state));
      if (expected.empty()) expected = bytes_of(report);
      CHECK(report.events().size() > 100);
      CHECK(report.events().size() == report.of(0).hits);
      CHECK(bytes_of(report) == expected);
    }
  }
}

TEST_CASE("report: parts of a batch add up to the whole") {
  Scene scene = falling();
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.3});
  std::vector<std::array<Vec3, 2>> start(40);
  for (std::size_t i = 0; i < start.size(); ++i) {
    start[i] = {Vec3{test::scatter(i, 0), 1 + test::scatter(i, 1), 0}, Vec3{test::scatter(i, 2), 0, test::scatter(i, 3)}};
  }
  const Reported<double> whole(scene, start, 100);
  const Reported<double> a(scene, {start.begin(), start.begin() + 13}, 100);
  const Reported<double> b(scene, {start.begin() + 13, start.end()}, 100);
  ContactReport sum(1);
  sum.add(a.report.words());
  sum.add(b.report.words());
  CHECK(sum.of(0).hits == whole.report.of(0).hits);
  CHECK(sum.of(0).impulse == whole.report.of(0).impulse);
  CHECK(sum.of(0).torque_impulse == whole.report.of(0).torque_impulse);
  sum.clear();
  CHECK(sum.of(0).impulse == Vec3{});
}

TEST_CASE("report: events that find no room are counted, and a report of another scene is refused") {
  Scene scene = falling();
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 1});
  const std::vector<std::array<Vec3, 2>> start{{Vec3{0, 0.1, 0}, Vec3{}}};
  const Reported<double> all(scene, start, 120);
  const Reported<double> few(scene, start, 120, h, 3);
  REQUIRE(all.report.events().size() > 3);
  CHECK(few.report.events().size() == 3);
  CHECK(few.report.lost() == all.report.events().size() - 3);
  CHECK(few.report.of(0).hits == all.report.of(0).hits);

  Soa<double> memory(1);
  auto state = memory.view();
  state.x[1][0] = 0.1;
  const auto plan = compile<double>(scene, {.step = h});
  REQUIRE(plan.has_value());
  ContactReport other(2);
  CHECK(plan->step(state, other) == StepResult::report_differs);
  CHECK(state.x[1][0] == 0.1);
  CHECK(state.clock.seconds == 0);
  CHECK(other.steps() == 0);

  ContactReport numbered(1);
  numbered.set_steps(41);
  CHECK(plan->step(state, numbered, 2) == StepResult::done);
  CHECK(numbered.steps() == 43);
}

}  // namespace contact_report_test
