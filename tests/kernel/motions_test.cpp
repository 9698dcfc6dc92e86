// Followers of a motion: kinematic particles, and surfaces that move.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "motion/pose_track.hpp"
#include "support/close.hpp"

namespace motions_test {

using namespace dvdx;
using test::apart;
using test::Joined;
using test::Run;
using test::stepped;

constexpr double pi = 3.14159265358979323846;

Motion along(const Vec3& velocity) {
  const double T = 16;
  return {.center = {}, .keys = {{.time = 0}, {.time = T, .translation = {T * velocity[0], T * velocity[1], T * velocity[2]}}}};
}

// The fixed particles follow a motion instead.
Joined carried(Joined joined, Motion motion) {
  joined.scene.add(Kinematic{.particles = std::exchange(joined.scene.fixed, {}), .motion = joined.scene.motions.size()});
  joined.scene.add(std::move(motion));
  return joined;
}

std::vector<Coupling> couplings() {
  return {{.scheme = Scheme::leapfrog},
          {.scheme = Scheme::fourth_order},
          {.scheme = Scheme::sequential, .substeps = 4},
          {.scheme = Scheme::sequential, .substeps = 4, .theta = 0.5},
          {.scheme = Scheme::sequential, .substeps = 4, .theta = 1, .sweeps = SweepOrder::forward},
          {.scheme = Scheme::accumulate, .method = Method::combined}};
}

constexpr Vec3 boost{1.5, -0.75, 2.25};

// The sheet, its pins and the wind all move on at one velocity.
Joined boosted(const Joined& still) {
  Joined moving = carried(still, along(boost));
  for (Vec3& v : moving.v) {
    for (std::size_t k = 0; k < 3; ++k) v[k] += boost[k];
  }
  for (Force& force : moving.scene.forces) {
    if (auto* drag = std::get_if<Drag>(&force)) drag->wind = boost;
  }
  return moving;
}

// How far the two are apart, but for the way that the boost takes in the time t.
double furthest(const std::vector<double>& still, const std::vector<double>& moving, double t) {
  double most = 0;
  for (std::size_t i = 0; i < still.size(); i += 6) {
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(moving[i + k] - t * boost[k] - still[i + k]));
  }
  return most;
}

// ---- a pendulum: 0.5 kg on a spring of 1 m and 200 N/m, whose pivot sways ---------------------------------------------------

constexpr double sway_step = 0.02;  // s, from key to key
constexpr std::size_t sway_steps = 50;

// 0.3 m sin(4 t) at the keys.
Motion sway() {
  Motion motion{.center = {}, .keys = {}};
  for (std::size_t k = 0; k <= sway_steps; ++k) {
    const double t = static_cast<double>(k) * sway_step;
    motion.keys.push_back({.time = t, .translation = {0.3 * std::sin(4 * t), 0, 0.1 * std::sin(6 * t)}});
  }
  return motion;
}

Joined pendulum() {
  Joined joined;
  joined.name = "a pendulum on a pivot that sways";
  joined.step = sway_step;
  joined.x = {{0, 0, 0}, {0.6, -0.8, 0}};
  joined.v = {{}, {}};
  joined.scene.mass = 0.5;
  joined.scene.fixed = {0};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 200.0, .rest_length = 1.0}));
  return carried(joined, sway());
}

struct Bob {
  Vec3 x, v;
};

// By the fourth-order Runge-Kutta method in steps of 10 us, the pivot linear from key to key.
Bob pendulum_by_runge_kutta() {
  const Motion motion = sway();
  const auto sum = [](const Vec3& a, double s, const Vec3& b) {
    return Vec3{a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
  };
  constexpr int parts = 2000;
  const double h = sway_step / parts;
  Bob bob{{0.6, -0.8, 0}, {}};
  for (std::size_t k = 0; k < sway_steps; ++k) {
    const Vec3& from = motion.keys[k].translation;
    const Vec3& to = motion.keys[k + 1].translation;
    const auto acceleration = [&](const Vec3& x, double part) {
      const Vec3 arm = sum(x, -1, sum(from, part, sum(to, -1, from)));
      const double r = std::hypot(arm[0], arm[1], arm[2]);
      return sum({0, -9.81, 0}, -200 / 0.5 * (r - 1) / r, arm);
    };
    for (int n = 0; n < parts; ++n) {
      const double at = static_cast<double>(n) / parts, half = at + 0.5 / parts, end = at + 1.0 / parts;
      const Vec3 a1 = acceleration(bob.x, at);
      const Vec3 v2 = sum(bob.v, h / 2, a1);
      const Vec3 a2 = acceleration(sum(bob.x, h / 2, bob.v), half);
      const Vec3 v3 = sum(bob.v, h / 2, a2);
      const Vec3 a3 = acceleration(sum(bob.x, h / 2, v2), half);
      const Vec3 v4 = sum(bob.v, h, a3);
      const Vec3 a4 = acceleration(sum(bob.x, h, v3), end);
      bob.x = sum(bob.x, h / 6, sum(sum(bob.v, 2, v2), 2, sum(v3, 0.5, v4)));
      bob.v = sum(bob.v, h / 6, sum(sum(a1, 2, a2), 2, sum(a3, 0.5, a4)));
    }
  }
  return bob;
}

TEST_CASE("motions: a pose is carried linearly, and turns about a fixed axis the short way round") {
  const PoseTrack track({.center = {0, 1, 0},
                         .keys = {{.time = 1},
                                  {.time = 3, .translation = {4, 0, 0}, .rotation = {0, pi / 2, 0}},
                                  {.time = 4, .translation = {4, 0, 0}, .rotation = {0, -3 * pi / 4, 0}}}});
  const auto at = [&](double t) { return track.at({.seconds = t}); };
  CHECK(at(0).place({1, 2, 3}) == Vec3{1, 2, 3});
  CHECK(at(0).velocity_of({1, 2, 3}) == Vec3{});
  const MovedPose middle = at(2);  // by 45 degrees about y, and 2 m on
  const Vec3 x = middle.place({1, 2, 0});
  CHECK(test::is_close(x[0], 2 + std::sqrt(0.5), 1e-15));
  CHECK(x[1] == 2);
  CHECK(test::is_close(x[2], -std::sqrt(0.5), 1e-15));
  const Vec3 v = middle.velocity_of({1, 2, 0});  // 2 m/s, and pi/4 rad/s about y
  CHECK(test::is_close(v[0], 2 - pi / 4 * std::sqrt(0.5), 1e-15));
  CHECK(test::is_close(v[2], -pi / 4 * std::sqrt(0.5), 1e-15));
  CHECK(test::is_close(at(3.5).angular_velocity[1], 3 * pi / 4, 1e-15));  // 225 degrees backwards are 135 forwards
  CHECK(at(9).velocity_of({1, 2, 3}) == Vec3{});
  CHECK(test::is_close(at(9).place({1, 0, 0})[2], std::sqrt(0.5), 1e-15));
}

TEST_CASE("motions: everything that moves at one velocity moves as at rest, but for that way") {
  constexpr std::size_t steps = 60;
  Joined still = test::sheet(7, 9, 40, 0.002);
  still.scene.add(Drag{.coefficient = 1e-3});
  Joined rodded = test::as_list(still);
  rodded.scene.add(Distance{.pairs = {{0, 9}, {9, 18}, {8, 17}}});
  rodded.name += ", with rods";
  for (const Joined& of : {still, test::as_list(still), rodded}) {
    for (const Coupling& coupling : couplings()) {
      Joined at_rest = of;
      at_rest.scene.coupling = coupling;
      const auto wanted = stepped<double>(at_rest, {.isa = best_isa()}, steps);
      const auto got = stepped<double>(boosted(at_rest), {.isa = best_isa()}, steps);
      const double apart = furthest(wanted, got, steps * of.step);
      CHECK_MESSAGE(apart < 1e-9, of.name << ", scheme " << static_cast<int>(coupling.scheme) << ": " << apart << " m");
    }
  }
}

TEST_CASE("motions: a pendulum whose pivot sways is as right as its scheme's order says") {
  const Bob wanted = pendulum_by_runge_kutta();
  const auto error = [&](const Coupling& coupling, int substeps) {
    Joined joined = pendulum();
    joined.scene.coupling = coupling;
    joined.scene.coupling.substeps = substeps;
    const auto got = stepped<double>(joined, {.isa = best_isa()}, sway_steps);
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(got[6 + k] - wanted.x[k]));
    return most;
  };
  struct Wanted {
    Coupling coupling;
    double order, error;  // m, of 16 sub-steps
  };
  const Wanted all[] = {{{.scheme = Scheme::leapfrog}, 2, 1e-5},
                        {{.scheme = Scheme::fourth_order}, 4, 1e-9},
                        {{.scheme = Scheme::sequential}, 2, 1e-4},
                        {{.scheme = Scheme::sequential, .theta = 0.5}, 2, 1e-4}};
  for (const Wanted& of : all) {
    CAPTURE(static_cast<int>(of.coupling.scheme));
    const double coarse = error(of.coupling, 8), fine = error(of.coupling, 16);
    CHECK(test::is_close(std::log2(coarse / fine), of.order, 0.05));
    CHECK(fine < of.error);
    MESSAGE(coarse << " and " << fine << " m by 8 and 16 sub-steps");
  }
}

TEST_CASE("motions: the bits depend neither on the instruction set, nor on threads, nor on how many steps a call takes") {
  Joined joined = carried(test::sheet(7, 9, 40, 0.002), along({0.3, 0.1, 0}));
  joined.scene.motions[0].keys.push_back({.time = 17, .rotation = {0, 2, 0}});
  joined.scene.motions[0].keys[1].time = 0.03;
  const auto check = [&]<class T>(T, const Joined& of) {
    const std::vector<T> wanted = stepped<T>(of, {}, 5);
    for (const Isa isa : available_isas()) {
      CHECK(test::difference(wanted, stepped<T>(of, {.isa = isa, .layout = test::Layout::aos, .threads = 2}, 5)) == "");
    }
    test::Batch<T> batch(test::Layout::soa, of.x.size());
    place(of, batch.view());
    const auto plan = test::plan_of(of, {}, batch.view());
    for (int n = 0; n < 5; ++n) REQUIRE(plan.step(batch.view()) == StepResult::done);
    CHECK(test::difference(wanted, test::values_of(batch.view())) == "");
  };
  for (const Joined& form : {joined, test::as_list(joined)}) {
    for (const Coupling& coupling : couplings()) {
      Joined of = form;
      of.scene.coupling = coupling;
      check(float{}, of);
      check(double{}, of);
    }
  }
}

TEST_CASE("motions: a pin that moves at 1 m/s gives the sheet the speeds of the converged motion, one call a frame") {
  Joined joined = test::sheet(16, 16, 500);
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    joined.x[i] = {static_cast<double>(i % 16) / 15, 0, static_cast<double>(i / 16) / 15};
    joined.v[i] = {};
  }
  joined = carried(std::move(joined), along({1, 0, 0}));
  const auto rms_speed = [](const std::vector<double>& values) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); i += 6) {
      for (std::size_t k = 3; k < 6; ++k) sum += values[i + k] * values[i + k];
    }
    return std::sqrt(6 * sum / static_cast<double>(values.size()));
  };
  const auto speed = [&](double step, std::size_t steps) {
    joined.step = step;
    return rms_speed(stepped<double>(joined, {.isa = best_isa()}, steps));
  };
  const double converged = speed(1.0 / 1920, 384);
  CHECK(test::is_close(speed(1.0 / 60, 12), converged, 0.02));
}

TEST_CASE("motions: kinematic particles are where the motion has them, whatever acts on them") {
  Joined joined =
      carried(test::sheet(5, 6, 40),
              {.center = {0.5, 0, 0}, .keys = {{.time = 0}, {.time = 0.5, .translation = {0, 1, 0}, .rotation = {0, 0, 1}}}});
  joined.scene.add(RadialSpring{.stiffness = 3.0, .anchor = Vec3{0, 3, 0}, .rest_length = 0.5});
  const auto values = stepped<double>(joined, {.isa = best_isa()}, 15);
  const MovedPose pose = PoseTrack(joined.scene.motions[0]).at({.seconds = 0.25});
  for (const std::size_t i : {std::size_t{0}, std::size_t{5}}) {
    const Vec3 x = pose.place(joined.x[i]);
    const Vec3 v = pose.velocity_of(joined.x[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::abs(values[6 * i + k] - x[k]) < 1e-15);
      CHECK(std::abs(values[6 * i + 3 + k] - v[k]) < 1e-15);
    }
  }
}

TEST_CASE("motions: without networks too, particles follow them") {
  Joined joined;
  joined.name = "three alone";
  joined.x = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  joined.v = {{0, 0, 0}, {1, 2, 3}, {0, 0, 0}};
  joined.scene.add(Constant{.acceleration = {0, -10, 0}});
  joined.scene.add(along({0, 0, 5}));
  joined.scene.add(Kinematic{.particles = {2}, .motion = 0});
  const auto values = stepped<double>(joined, {.isa = best_isa()}, 60);
  CHECK(test::is_close(values[1], -5, 1e-12));
  CHECK(test::is_close(values[6 + 1], 2 - 5, 1e-12));
  CHECK(test::is_close(values[12 + 2], 5, 1e-15));
  CHECK(values[12 + 5] == 5);
}

TEST_CASE("motions: what is wrong with them is named") {
  const Joined joined = test::sheet(3, 3, 40);
  const auto message = [&](auto change) {
    Scene scene = carried(joined, along({1, 0, 0})).scene;
    change(scene);
    test::Batch<double> batch(test::Layout::soa, joined.x.size());
    place(joined, batch.view());
    const auto plan = compile<double>(scene, {}, batch.view());
    return plan.has_value() ? std::string("accepted") : plan.error().message();
  };
  const double nan = std::nan("");
  CHECK(message([](Scene&) {}) == "accepted");
  CHECK(message([](Scene& s) { s.motions[0].keys[1].time = 0; }) ==
        "motions[0].keys[1].time is 0: must be later than the key before, at 0 s");
  CHECK(message([&](Scene& s) { s.motions[0].keys[1].time = nan; }).starts_with("motions[0].keys[1].time is nan"));
  CHECK(message([&](Scene& s) {
          s.motions[0].keys[1].translation[2] = nan;
        }).starts_with("motions[0].keys[1].translation[2] is nan: must be a finite number"));
  CHECK(message([&](Scene& s) { s.motions[0].keys[0].rotation[0] = INFINITY; }).starts_with("motions[0].keys[0].rotation[0]"));
  CHECK(message([&](Scene& s) { s.motions[0].center[1] = nan; }).starts_with("motions[0].center[1]"));
  CHECK(message([&](Scene& s) {
          s.motions[0].keys[1] = {.time = 1e-300, .translation = {1e300, 0, 0}};
        }) == "motions[0].keys[1] is too far from the key before: must be a pose that is reached at a finite speed");
  CHECK(message([](Scene& s) { s.kinematic[0].motion = 1; }) == "kinematic[0].motion is 1: must be a motion's index below 1");
  CHECK(message([](Scene& s) { s.kinematic[0].particles[1] = 9; }) ==
        "kinematic[0].particles[1] is 9: must be a particle id below 9");
  CHECK(message([](Scene& s) { s.kinematic[0].particles[1] = 0; }) ==
        "kinematic[0].particles[1] is 0: must be a particle that is not in kinematic[0].particles[0] already");
  CHECK(message([](Scene& s) { s.fixed = {2}; }) ==
        "kinematic[0].particles[1] is 2: must be a particle that is not in fixed[0] already");
  CHECK(message([](Scene& s) { s.add(Plane{.motion = 4}); }) == "contacts[0].motion is 4: must be a motion's index below 1");
}

// ---- surfaces that move ------------------------------------------------------------------------------------------------

Joined scattered(std::size_t count, const Vec3& least, const Vec3& most) {
  Joined joined;
  joined.name = std::to_string(count) + " particles";
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = least[k] + (most[k] - least[k]) * 0.5 * (1 + test::scatter(i, k));
    joined.x.push_back(x);
    joined.v.push_back({});
  }
  return joined;
}

Motion sweep(const Vec3& way, double seconds) {
  return {.center = {}, .keys = {{.time = 0}, {.time = seconds, .translation = way}}};
}

// Everything that a contact can do, at rest and moving.
Joined among_surfaces(double drag) {
  Joined joined = scattered(200, {-1, 0.05, -1}, {1, 1.5, 1});
  for (std::size_t i = 0; i < joined.v.size(); ++i)
    joined.v[i] = {2 * test::scatter(i, 3), test::scatter(i, 4), test::scatter(i, 5)};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  if (drag != 0) joined.scene.add(Drag{.coefficient = drag});
  joined.scene.add(Plane{.restitution = 0.6, .friction = 0.2});
  joined.scene.add(Plane{.normal = {1, 1, 0}, .offset = -1, .restitution = 0.3, .friction = 0.4, .viscosity = 0.1});
  joined.scene.add(Sphere{.center = {0.2, 0.4, 0}, .radius = 0.3, .restitution = 0.5, .friction = 0.1});
  joined.scene.add(Sphere{.center = {0, 0, 0}, .radius = 3, .side = Side::inside, .restitution = 0.8});
  return joined;
}

void let_follow(Scene& scene, std::size_t motion) {
  for (Contact& contact : scene.contacts) std::visit([&](auto& c) { c.motion = motion; }, contact);
}

TEST_CASE("motions: surfaces, particles and wind that move at one velocity act as at rest") {
  for (const double drag : {0.0, 0.4}) {
    const Joined still = among_surfaces(drag);
    Joined moving = boosted(still);
    let_follow(moving.scene, 0);
    for (const std::size_t steps : {std::size_t{10}, std::size_t{30}}) {
      const auto wanted = stepped<double>(still, {.isa = best_isa()}, steps);
      const auto got = stepped<double>(moving, {.isa = best_isa()}, steps);
      const double apart = furthest(wanted, got, static_cast<double>(steps) * still.step);
      CHECK_MESSAGE(apart < 1e-9, "drag " << drag << ", " << steps << " steps: " << apart << " m");
    }
  }
}

// Bodies whose tops lie at 0: what falls on them slides, and leaves them at an edge or where the surface bends away.
std::vector<Contact> bodies() {
  return {Sphere{.center = {0, -3, 0}, .radius = 3}, Sphere{.center = {0, 0.5, 0}, .radius = 2.5, .side = Side::inside},
          Capsule{.ends = {{{-1, -0.5, 0}, {1, -0.3, 0.2}}}, .radius = {0.5, 0.4}},
          OrientedBox{.center = {0, -0.5, 0}, .half_extents = {0.8, 0.5, 0.7}, .rotation = {0.1, 0.2, 0.15}},
          Convex{.planes = {{{0, 1, 0}, 0},
                            {{1, 0.3, 0}, 0.8},
                            {{-1, 0.2, 0.1}, 0.8},
                            {{0, 0.2, 1}, 0.8},
                            {{0, 0.1, -1}, 0.8},
                            {{0, -1, 0}, 1}}}};
}

TEST_CASE("motions: what slides along a body, and off it, does so alike whatever moves with it") {
  for (const Contact& body : bodies()) {
    for (const std::pair<double, double>& of : {std::pair(0.0, 0.0), std::pair(0.0, 0.5), std::pair(0.6, 0.2)}) {
      const double friction = of.first;
      const double drag = of.second;
      Joined still = scattered(200, {-1, 0.1, -1}, {1, 1.5, 1});
      for (std::size_t i = 0; i < still.v.size(); ++i) {
        still.v[i] = {test::scatter(i, 3), test::scatter(i, 4), test::scatter(i, 5)};
      }
      still.scene.add(Constant{.acceleration = {0, -9.81, 0}});
      if (drag != 0) still.scene.add(Drag{.coefficient = drag});
      Contact contact = body;
      std::visit([&](auto& c) { c.friction = friction, c.restitution = friction == 0 ? 0.5 : 0.9; }, contact);
      still.scene.contacts = {contact};
      Joined moving = boosted(still);
      let_follow(moving.scene, 0);
      const auto wanted = stepped<double>(still, {.isa = best_isa()}, 120);
      const auto got = stepped<double>(moving, {.isa = best_isa()}, 120);
      const double apart = furthest(wanted, got, 120 * still.step);
      CHECK_MESSAGE(apart < 1e-9,
                    "body " << body.index() << ", friction " << friction << ", drag " << drag << ": " << apart << " m");
    }
  }
}

TEST_CASE("motions: a floor that rises evenly throws a ball as one at rest does") {
  for (const double e : {1.0, 0.5, 0.0}) {
    Joined still;
    still.name = "ball";
    still.x = {{0.3, 1, 0}};
    still.v = {{0.5, 0, 0}};
    still.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    still.scene.add(Plane{.restitution = e});
    Joined rising = still;
    rising.v[0][1] = 2;
    rising.scene.add(along({0, 2, 0}));
    let_follow(rising.scene, 0);
    const auto wanted = stepped<double>(still, {.isa = best_isa()}, 120);
    const auto got = stepped<double>(rising, {.isa = best_isa()}, 120);
    CHECK(std::abs(got[1] - 2 * 2.0 - wanted[1]) < 1e-9);
    CHECK(std::abs(got[4] - 2 - wanted[4]) < 1e-9);
    CHECK(std::abs(got[0] - wanted[0]) < 1e-12);
  }
}

TEST_CASE("motions: a sphere swept through resting particles leaves none inside, and passes none") {
  const Joined of = scattered(2000, {-0.4, -0.4, 0}, {0.4, 0.4, 3});
  const auto check = [&]<class T>(T, double h, double e, Isa isa) {
    Joined joined = of;
    joined.step = h;
    joined.scene.add(Sphere{.center = {0, 0, -0.5}, .radius = 0.1, .restitution = e, .motion = 0});
    joined.scene.add(sweep({0, 0, 4}, 0.2));  // 20 m/s
    test::Batch<T> batch(test::Layout::soa, joined.x.size());
    place(joined, batch.view());
    // None that was inside already.
    const auto plan = test::plan_of(joined, {.isa = isa}, batch.view());
    for (int n = 1; n * h < 0.2; ++n) {
      REQUIRE(plan.step(batch.view()) == StepResult::done);
      const double z = -0.5 + 20 * h * n;
      std::size_t inside = 0;
      std::size_t passed = 0;
      for (std::size_t i = 0; i < joined.x.size(); ++i) {
        const double r =
            std::hypot(double{batch.view().x[0][i]}, double{batch.view().x[1][i]}, double{batch.view().x[2][i]} - z);
        inside += r < 0.1 * (1 - 1e-5) ? 1 : 0;
        const bool was_in_the_way = std::hypot(joined.x[i][0], joined.x[i][1]) < 0.0999 && joined.x[i][2] < z;
        const bool is_unmoved =
            double{batch.view().x[2][i]} == double{static_cast<T>(joined.x[i][2])} && double{batch.view().v[2][i]} == 0;
        passed += was_in_the_way && is_unmoved ? 1 : 0;
      }
      CHECK(inside == 0);
      CHECK(passed == 0);
    }
  };
  for (const Isa isa : available_isas()) {
    for (const double h : {1.0 / 30, 1.0 / 120}) {
      for (const double e : {0.0, 0.5}) {
        check(float{}, h, e, isa);
        check(double{}, h, e, isa);
      }
    }
  }
}

TEST_CASE("motions: a ball lies on a turntable that holds it, and is carried round") {
  Joined joined;
  joined.name = "turntable";
  joined.x = {{0.5, 0, 0}, {0, 0, -0.25}};
  joined.v = {{0, 0, -1}, {-0.5, 0, 0}};  // 2 rad/s about y
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Plane{.friction = 2, .motion = 0});
  joined.scene.add(
      Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .rotation = {0, 2, 0}}, {.time = 2, .rotation = {0, 4, 0}}}});
  const auto values = stepped<double>(joined, {.isa = best_isa()}, 60);
  CHECK(std::abs(values[0] - 0.5 * std::cos(2.0)) < 1e-9);
  CHECK(std::abs(values[2] + 0.5 * std::sin(2.0)) < 1e-9);
  CHECK(values[1] == 0);
  CHECK(std::abs(values[3] + std::sin(2.0)) < 1e-9);
  CHECK(std::abs(values[6] + 0.25 * std::sin(2.0)) < 1e-9);
}

TEST_CASE("motions: what slips on a turntable speeds up by friction against it") {
  // mu g = 0.981 m/s^2 for the first moments, against 1 m/s of the table.
  Joined joined;
  joined.name = "slipping";
  joined.x = {{0.5, 0, 0}};
  joined.v = {{}};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Plane{.friction = 0.1, .motion = 0});
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .rotation = {0, 2, 0}}}});
  const auto values = stepped<double>(joined, {.isa = best_isa()}, 6);
  CHECK(test::is_close(values[5], -0.0981, 0.01));
  CHECK(std::abs(values[3]) < 0.01);
}

TEST_CASE("motions: moving surfaces have the same bits on every instruction set, in every arithmetic") {
  for (const double drag : {0.0, 0.4}) {
    Joined joined = among_surfaces(drag);
    joined.scene.add(along({0.5, 0.3, 0}));
    joined.scene.add(
        Motion{.center = {0, 1, 0},
               .keys = {{.time = 0}, {.time = 0.05, .rotation = {0.2, 0.1, 0.3}}, {.time = 1, .translation = {0, 0.4, 0.2}}}});
    std::size_t j = 0;
    for (Contact& contact : joined.scene.contacts) {
      if (j != 0) std::visit([&](auto& c) { c.motion = j % 2; }, contact);
      ++j;
    }
    const auto check = [&]<class T>(T) {
      for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
        const auto wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 20);
        for (const Isa isa : available_isas(arithmetic)) {
          CHECK(test::difference(wanted, stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic}, 20)) == "");
        }
      }
    };
    check(float{});
    check(double{});
  }
}

// ---- what the caller drives --------------------------------------------------------------------------------------------

template <class Ask>
std::vector<double> driven(const Joined& joined, std::size_t steps, const Ask& ask) {
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  place(joined, batch.view());
  auto plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  for (std::size_t n = 1; n <= steps; ++n) {
    ask(plan, static_cast<double>(n) * joined.step);
    REQUIRE(plan.step(batch.view()) == StepResult::done);
  }
  return test::values_of(batch.view());
}

TEST_CASE("motions: a pose asked for each step moves pins and surfaces as keys at the steps do") {
  for (const Coupling& coupling : couplings()) {
    Joined keyed = carried(test::sheet(5, 6, 40, 0.002), {});
    keyed.scene.coupling = coupling;
    keyed.scene.add(Sphere{.center = {0.5, -0.3, 0.6}, .radius = 0.2, .friction = 0.2, .motion = 0});
    const auto pose = [](double t) { return Pose{.translation = {0.3 * t, 0.5 * t, 0}, .rotation = {0, 0.8 * t, 0}}; };
    keyed.scene.motions[0] = {.center = {0.5, 0, 0}, .keys = {}};
    for (int n = 0; n <= 20; ++n) {
      const Pose at = pose(n * keyed.step);
      keyed.scene.motions[0].keys.push_back({.time = n * keyed.step, .translation = at.translation, .rotation = at.rotation});
    }
    Joined asked = keyed;
    asked.scene.motions[0].keys.resize(1);
    const auto wanted = driven(keyed, 12, [](auto&, double) {});
    const auto got = driven(asked, 12, [&](auto& plan, double t) { REQUIRE(plan.set_pose(0, pose(t)).has_value()); });
    CHECK_MESSAGE(apart(wanted, got) < 1e-11, "scheme " << static_cast<int>(coupling.scheme) << ": " << apart(wanted, got));
  }
}

TEST_CASE("motions: places asked for each step move each pin, and where none is asked for they rest") {
  const Joined keyed = carried(test::sheet(5, 6, 40, 0.002), along({1, 0, 0.5}));
  Joined asked = keyed;
  asked.scene.motions[0].keys.resize(1);
  const auto places = [&](double t) {
    std::vector<Vec3> list;
    for (const std::size_t i : asked.scene.kinematic[0].particles) {
      list.push_back({asked.x[i][0] + t, asked.x[i][1], asked.x[i][2] + 0.5 * t});
    }
    return list;
  };
  const auto wanted = driven(keyed, 12, [](auto&, double) {});
  const auto got = driven(asked, 12, [&](auto& plan, double t) { REQUIRE(plan.set_places(0, places(t)).has_value()); });
  CHECK(apart(wanted, got) < 1e-11);

  const auto stopped = driven(asked, 3, [&](auto& plan, double t) {
    if (t < 1.5 * asked.step) REQUIRE(plan.set_places(0, places(0.01)).has_value());
  });
  const std::size_t pin = asked.scene.kinematic[0].particles[1];
  CHECK(stopped[6 * pin] == places(0.01)[1][0]);
  CHECK(stopped[6 * pin + 3] == 0);
}

TEST_CASE("motions: a pose asked for is reached in the next step, with as many calls as the caller likes") {
  Joined joined = carried(test::sheet(5, 6, 40, 0.002), along({0, 0, 0}));
  joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 3};
  test::Batch<float> one(test::Layout::soa, joined.x.size());
  test::Batch<float> many(test::Layout::soa, joined.x.size());
  for (auto* batch : {&one, &many}) place(joined, batch->view());
  auto plan = test::plan_of(joined, {.isa = best_isa()}, one.view());
  auto other = plan.clone();
  for (auto* of : {&plan, &other}) REQUIRE(of->set_pose(0, {.translation = {0.1, 0, 0}, .rotation = {}}).has_value());
  REQUIRE(plan.step(one.view(), 4) == StepResult::done);
  for (int n = 0; n < 4; ++n) REQUIRE(other.step(many.view()) == StepResult::done);
  CHECK(test::difference(test::values_of(one.view()), test::values_of(many.view())) == "");
  const std::size_t pin = joined.scene.kinematic[0].particles[1];
  CHECK(test::is_close(double{one.view().x[0][pin]}, joined.x[pin][0] + 0.1, 1e-6));
  CHECK(one.view().v[0][pin] == 0);  // there it rests
}

TEST_CASE("motions: a target that is wrong is refused, and changes nothing") {
  const Joined joined = carried(test::sheet(3, 3, 40), along({1, 0, 0}));
  const std::vector<Vec3> two(2);
  const auto wanted = driven(joined, 3, [](auto&, double) {});
  const auto got = driven(joined, 3, [&](auto& plan, double) {
    CHECK(plan.set_pose(1, {}).error().message() == "motions[1] is not there: must be an index below 1");
    CHECK(plan.set_pose(0, {.translation = {0, std::nan(""), 0}, .rotation = {}}).error().message() ==
          "pose.translation[1] is nan: must be a finite number");
    CHECK(plan.set_pose(0, {.translation = {}, .rotation = {INFINITY, 0, 0}}).error().field == "pose.rotation[0]");
    CHECK(plan.set_places(1, two).error().message() == "kinematic[1] is not there: must be an index below 1");
    CHECK(plan.set_places(0, {}).error().message() ==
          "places is 0 points: must be one for each of the 2 particles of kinematic[0]");
    const std::vector<Vec3> bad{{0, 0, 0}, {0, 0, std::nan("")}};
    CHECK(plan.set_places(0, bad).error().message() == "places[1][2] is nan: must be a finite number");
  });
  CHECK(test::difference(wanted, got) == "");
}

// Roundings of where two faces are used to add up until one of them let go.
TEST_CASE("motions: grains that friction holds in a groove or a box move with it as they lie in one at rest") {
  constexpr std::size_t count = 16;
  constexpr double seconds = 40;
  OrientedBox box{.center = {0, 0.7, 0}, .half_extents = {0.5, 1, 0.5}, .rotation = {-0.42, 0.28, -0.06}};
  box.side = Side::inside;
  box.friction = 0.1;
  box.restitution = 0.5;
  const Plane one{.normal = unit({0.324, 0.946, 0.1018}), .friction = 0.2};
  const Plane other{.normal = unit({-0.218, 0.976, 0.1018}), .friction = 0.2};
  const auto after = [&](const std::vector<Contact>& contacts, const Vec3& u) {
    Joined joined;
    joined.name = "held";
    joined.step = 0.01;
    joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = seconds, .translation = scaled(u, seconds)}}});
    for (Contact contact : contacts) {
      std::visit([](auto& of) { of.motion = 0; }, contact);
      joined.scene.add(contact);
    }
    for (std::size_t i = 0; i < count; ++i) {
      joined.x.push_back({0.15 * test::scatter(i, 0), 0.1, 0.15 * test::scatter(i, 1)});
      joined.v.push_back(u);
    }
    return test::stepped<double>(joined, {.isa = best_isa()}, 4000);
  };
  for (const std::vector<Contact>& contacts : {std::vector<Contact>{box}, std::vector<Contact>{one, other}}) {
    CAPTURE(contacts.size());
    const auto rest = after(contacts, {});
    for (const Vec3& u : {Vec3{-1.4, 0, 1.1}, Vec3{2.6, -2.9, 0.6}}) {
      const auto moved = after(contacts, u);
      for (std::size_t i = 0; i < rest.size(); ++i) {
        const bool is_place = i % 6 < 3;
        CHECK(std::abs(moved[i] - rest[i] - (is_place ? seconds : 1) * u[i % 3]) < 1e-9);
      }
    }
  }
}

// ---- a grip: two boxes close on what is between them, and lift it by 0.5 m in a second -------------------------------------

// Faces at 1 cm from the middle come so close in 0.2 s that they overlap by this much; from 1.2 s on they are at rest.
Joined in_grip(Joined joined, double overlap, double friction) {
  joined.name = "grip";
  for (const double side : {-1.0, 1.0}) {
    Motion motion{.center = {}, .keys = {{.time = 0}}};
    const double way = -side * (0.01 + overlap / 2);
    motion.keys.push_back({.time = 0.2, .translation = {0, 0, way}});
    motion.keys.push_back({.time = 1.2, .translation = {0, 0.5, way}});
    joined.scene.add(OrientedBox{.center = {0, 0, 0.02 * side},
                                 .half_extents = {0.6, 0.6, 0.01},
                                 .friction = friction,
                                 .motion = joined.scene.motions.size()});
    joined.scene.add(std::move(motion));
  }
  return joined;
}

Joined grain() {
  Joined joined;
  joined.x = {{0.1, 0.05, 0}};
  joined.v = {{}};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

// A square of 0.6 m.
Joined hung(std::size_t rows, const Coupling& coupling) {
  Joined joined;
  for (std::size_t i = 0; i < rows * rows; ++i) {
    const auto part = [&](std::size_t k) { return 0.6 * (static_cast<double>(k) / static_cast<double>(rows - 1) - 0.5); };
    joined.x.push_back({part(i % rows), part(i / rows), 0});
  }
  joined.v.assign(joined.x.size(), {});
  joined.scene.mass = 0.1 / static_cast<double>(rows * rows);
  joined.scene.add(
      Network(Grid{.rows = rows, .columns = rows, .edge_u = {0.6, 0, 0}, .edge_v = {0, 0.6, 0}, .structural = 50}));
  joined.scene.coupling = coupling;
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

template <class T>
double lowest_rise(const Joined& joined, const Run& run, double seconds) {
  const std::vector<T> end = stepped<T>(joined, run, static_cast<std::size_t>(std::lround(seconds / joined.step)));
  double rise = 1e9;
  for (std::size_t i = 0; i < joined.x.size(); ++i) rise = std::min(rise, static_cast<double>(end[6 * i + 1]) - joined.x[i][1]);
  return rise;
}

// It used to fall out of the grip as soon as the boxes came no closer, whatever the friction.
TEST_CASE_TEMPLATE("motions: a grain that two boxes squeeze is lifted by friction, and slides out where there is too little", T,
                   float, double) {
  for (const double step : {1.0 / 60, 1.0 / 200}) {
    Joined joined = in_grip(grain(), 0.004, 0.6);
    joined.step = step;
    for (const double seconds : {1.2, 4.0}) CHECK(lowest_rise<T>(joined, {.isa = best_isa()}, seconds) > 0.2);
    CHECK(std::abs(lowest_rise<T>(joined, {.isa = best_isa()}, 4) - lowest_rise<T>(joined, {.isa = best_isa()}, 2)) < 1e-6);
    joined = in_grip(grain(), 0.004, 0.001);
    joined.step = step;
    CHECK(lowest_rise<T>(joined, {.isa = best_isa()}, 1.2) < -1);
  }
}

TEST_CASE("motions: what two boxes squeeze has the twin's bits on every instruction set") {
  for (const double friction : {0.0, 0.05, 0.6}) {
    Joined joined = in_grip(grain(), 0.004, friction);
    joined.scene.contacts.push_back(Plane{.offset = -0.2, .restitution = 0.5});
    for (std::size_t i = 1; i < 21; ++i) {
      joined.x.push_back({0.3 * test::scatter(i, 0), 0.2 * test::scatter(i, 1), 0.012 * test::scatter(i, 2)});
      joined.v.push_back({test::scatter(i, 3), 0, 0});
    }
    const std::vector<double> wanted = stepped<double>(joined, {}, 30);
    for (const Isa isa : available_isas(Arithmetic::separate)) {
      CAPTURE(name(isa));
      CHECK(wanted == stepped<double>(joined, {.isa = isa}, 30));
    }
  }
}

TEST_CASE("motions: cloth that two boxes squeeze is lifted by friction") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential, Scheme::fourth_order}) {
    CAPTURE(static_cast<int>(scheme));
    const Joined joined = in_grip(hung(4, {.scheme = scheme}), 0.004, 0.6);
    CHECK(lowest_rise<double>(joined, {.isa = best_isa()}, 0.9) > 0.2);
    CHECK(lowest_rise<double>(in_grip(hung(4, {.scheme = scheme}), 0.004, 0), {.isa = best_isa()}, 0.65) < -1);
  }
}

}  // namespace motions_test
