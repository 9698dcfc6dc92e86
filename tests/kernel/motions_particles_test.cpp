// Motions that carry particles: closed forms, orders and bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/moving.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "motion/pose_track.hpp"
#include "support/close.hpp"

namespace moving::particles_test {

using test::apart;
using test::stepped;

constexpr double pi = 3.14159265358979323846;

constexpr double sway_step = 0.02;  // s, between keys
constexpr std::size_t sway_steps = 50;

// Follows 0.3 m sin(4 t) at the keys.
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

// Fourth-order Runge-Kutta in steps of 10 us, with the pivot linear between keys.
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
  const MovedPose middle = at(2);  // by 45 degrees about y, and by 2 m
  const Vec3 x = middle.place({1, 2, 0});
  CHECK(test::is_close(x[0], 2 + std::sqrt(0.5), 1e-15));
  CHECK(x[1] == 2);
  CHECK(test::is_close(x[2], -std::sqrt(0.5), 1e-15));
  const Vec3 v = middle.velocity_of({1, 2, 0});  // 2 m/s, and pi/4 rad/s about y
  CHECK(test::is_close(v[0], 2 - pi / 4 * std::sqrt(0.5), 1e-15));
  CHECK(test::is_close(v[2], -pi / 4 * std::sqrt(0.5), 1e-15));
  CHECK(test::is_close(at(3.5).angular_velocity[1], 3 * pi / 4, 1e-15));  // 225 degrees backwards equal 135 forwards
  CHECK(at(9).velocity_of({1, 2, 3}) == Vec3{});
  CHECK(test::is_close(at(9).place({1, 0, 0})[2], std::sqrt(0.5), 1e-15));
}

TEST_CASE("motions: a scene that moves at one velocity moves as at rest, apart from the way travelled") {
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

TEST_CASE("motions: a pendulum whose pivot sways converges by its scheme's order") {
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
    double order, error;  // m, with 16 sub-steps
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

TEST_CASE("motions: particles follow a motion without networks, too") {
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

TEST_CASE("motions: wrong motions and followers are refused by name") {
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

}  // namespace moving::particles_test
