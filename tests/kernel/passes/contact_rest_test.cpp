// Particles held by one, two or three surfaces, with friction, and bounces of held particles.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/particles.hpp"
#include "math/vec3.hpp"
#include "support/batch.hpp"

namespace dvdx::test::contact_rest_test {

Plane plane(const Vec3& normal, double offset, double restitution, double friction) {
  return {.normal = normal, .offset = offset, .restitution = restitution, .friction = friction};
}

// The point nearest to d in front of three planes through the origin.
Vec3 nearest_in_front(const std::array<Vec3, 3>& n, const Vec3& d) {
  std::vector<Vec3> candidates = {d, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    candidates.push_back(dvdx::difference(d, scaled(n[k], dot(n[k], d))));
    const Vec3 edge = unit(cross(n[k], n[(k + 1) % 3]));
    candidates.push_back(scaled(edge, dot(edge, d)));
  }
  Vec3 nearest{};
  for (const Vec3& x : candidates) {
    const bool is_in_front = std::all_of(n.begin(), n.end(), [&](const Vec3& of) { return dot(of, x) >= -1e-14; });
    if (is_in_front && length(dvdx::difference(x, d)) < length(dvdx::difference(nearest, d))) nearest = x;
  }
  return nearest;
}

// A past defect: the two walls hit alternately at the start of the step until all impacts of the step were used.
TEST_CASE_TEMPLATE("a particle pressed onto two walls keeps its bounce on a third surface", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const double restitution : {0.4, 1.0}) {
      Particles<T> particles(kernels, hz60, {4, 0, -3});
      particles.add(plane({-1, 0, 0}, -20, 0.3, 0));
      particles.add(plane({0, 0, 1}, -20, 0.3, 0));
      particles.add(plane({0, 1, 0}, 0, restitution, 0));
      particles.set_all(state<T>({20, 0.01, -20}, {0, -2, 0}));
      particles.step();
      const auto end = particles.at(3);
      CHECK(std::abs(static_cast<double>(end.v[1]) - 2 * restitution) <= 8 * eps<T>);
      CHECK(std::abs(static_cast<double>(end.x[1]) - 2 * restitution * (hz60 - 0.005)) <= 8 * eps<T>);
      CHECK(end.x[0] == T(20));
      CHECK(end.x[2] == T(-20));
      CHECK(end.v[0] == T(0));
      CHECK(end.v[2] == T(0));
    }
  });
}

TEST_CASE_TEMPLATE("particles that wind presses into a corner of three planes come to rest exactly and stay", T, float,
                   double) {
  const std::vector<std::array<Vec3, 3>> corners = {{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}},
                                                    {{{0.2, 1, 0.1}, {-1, 0.3, 0.2}, {-0.1, 0.2, 1}}},
                                                    {{{0, 1, 0}, {-1, -0.4, 0}, {0.1, -0.3, 1}}}};
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const auto& normals : corners) {
      Particles<T> particles(kernels, hz60, {8, -9.81, -6}, 32);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 n = unit(normals[k]);
        particles.add(plane(n, dot(n, {20, 1, -20}), k == 0 ? 0.4 : 0.3, k == 0 ? 0.3 : 0.2));
      }
      for (std::size_t i = 0; i < 32; ++i) {
        const double d = static_cast<double>(i);
        particles.set(i, state<T>({19.5 - 0.01 * d, 1.5 + 0.05 * d, -19.5 + 0.01 * d}, {0.2 * d, -3, -0.1 * d}));
      }
      particles.step(900);
      std::vector<State3<T>> settled;
      for (std::size_t i = 0; i < 32; ++i) settled.push_back(particles.at(i));
      particles.step(1000);
      for (std::size_t i = 0; i < 32; ++i) {
        const auto end = particles.at(i);
        CAPTURE(i);
        CHECK(end.v == std::array<T, 3>{});
        CHECK(end.x == settled[i].x);
        for (const auto& surface : particles.surfaces) {
          CHECK(dot(wide(surface.n), wide(end.x)) - static_cast<double>(surface.d) >= -4 * eps<T> * length(wide(end.x)));
        }
      }
    }
  });
}

// A groove of two planes slopes down. The pressure on each is g cos/(2 cos of half the opening angle).
TEST_CASE_TEMPLATE("a particle that lies in a groove slides along it with the friction of both its walls", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double slope = 0.5;
    const double side = 1.0;  // of the walls against the vertical
    const double friction = 0.2;
    Particles<T> particles(kernels, hz60, {0, -9.81 * std::cos(slope), 9.81 * std::sin(slope)});
    particles.add(plane({std::cos(side), std::sin(side), 0}, 0, 0.3, friction));
    particles.add(plane({-std::cos(side), std::sin(side), 0}, 0, 0.3, friction));
    particles.set_all(state<T>({0, 0, 0}, {0, 0, 0}));
    particles.step(60);
    const double pressure = std::cos(slope) / (2 * std::sin(side));
    const double pull = 9.81 * (std::sin(slope) - 2 * friction * pressure);
    CHECK(std::abs(static_cast<double>(particles.at(1).v[2]) - pull) <= 200 * eps<T>);
    CHECK(std::abs(static_cast<double>(particles.at(1).x[2]) - pull / 2) <= 0.02 * pull);
    CHECK(std::abs(static_cast<double>(particles.at(1).x[0])) <= 8 * eps<T>);
    CHECK(std::abs(static_cast<double>(particles.at(1).x[1])) <= 8 * eps<T>);
  });
}

// A past defect: a particle crossed the groove's edge as often as a step has impacts, and left with the speed gained from
// gravity.
TEST_CASE_TEMPLATE("particles that slide from wall to wall of a wide groove come to rest in it", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const double friction : {0.12, 0.2}) {
      Particles<T> particles(kernels, T(0.01), {0, -9.81, 0}, 32);
      particles.add(plane(unit({0.324, 0.946, 0.1018}), 0, 0, friction));
      particles.add(plane(unit({-0.218, 0.976, 0.1018}), 0, 0, friction));
      for (std::size_t i = 0; i < 32; ++i) {
        const double d = static_cast<double>(i);
        particles.set(i, state<T>({0.02 - 0.002 * d, 0.4 + 0.01 * d, 0}, {0.01 * d, 0, 0}));
      }
      particles.step(400);
      std::vector<State3<T>> settled;
      for (std::size_t i = 0; i < 32; ++i) settled.push_back(particles.at(i));
      particles.step(200);
      for (std::size_t i = 0; i < 32; ++i) {
        const auto end = particles.at(i);
        for (std::size_t k = 0; k < 3; ++k) {
          CHECK(end.v[k] == T(0));
          CHECK(end.x[k] == settled[i].x[k]);
        }
      }
    }
  });
}

TEST_CASE_TEMPLATE("a particle pressed from the tip of three walls goes where the nearest point in front of them is", T, float,
                   double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (std::size_t i = 0; i < 500; ++i) {  // cases 383 and 461 leave the first surface, 22 others the second
      std::array<Vec3, 3> n;
      for (std::size_t k = 0; k < 3; ++k) n[k] = unit({scatter(i, 3 * k), scatter(i, 3 * k + 1), scatter(i, 3 * k + 2)});
      if (std::abs(dot(n[0], cross(n[1], n[2]))) < 0.3) continue;
      CAPTURE(i);
      const Vec3 a{10 * scatter(i, 9), 10 * scatter(i, 10), 10 * scatter(i, 11)};
      Particles<T> particles(kernels, hz60, a);
      for (const Vec3& of : n) particles.add(plane(of, 0, 0, 0));
      particles.set_all(state<T>({}, {}));
      particles.step();
      const double half_square = hz60 * hz60 / 2;
      const Vec3 wanted = nearest_in_front(n, scaled(a, half_square));
      const auto end = particles.at(0);
      CHECK(length(dvdx::difference(wide(end.x), wanted)) <= 64 * eps<T> * half_square * length(a));
      CHECK(length(dvdx::difference(wide(end.v), scaled(wanted, 2 / hz60))) <= 64 * eps<T> * hz60 * length(a));
    }
  });
}

TEST_CASE_TEMPLATE("a particle that a third surface stops on one edge goes on along another", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    // The particle is pressed onto the floor and a wall, and pushed along the wall towards a second one that deflects it.
    Particles<T> particles(kernels, hz60, {6, -9.81, -1});
    particles.add(plane({0, 1, 0}, 0, 0, 0));
    particles.add(plane({0, 0, 1}, 0, 0, 0));
    particles.add(plane({-0.6, 0, 0.8}, 0, 0, 0));  // along (0.8, 0, 0.6)
    particles.set_all(state<T>({0, 0, 0}, {0, 0, 0}));
    particles.step(60);
    const double pull = 0.8 * 6 - 0.6;
    const auto end = particles.at(2);
    CHECK(std::abs(static_cast<double>(end.x[0]) - 0.8 * pull / 2) <= 200 * eps<T>);
    CHECK(std::abs(static_cast<double>(end.x[2]) - 0.6 * pull / 2) <= 200 * eps<T>);
    CHECK(std::abs(static_cast<double>(end.x[1])) <= 8 * eps<T>);
  });
}

TEST_CASE_TEMPLATE("A slide along the floor bounces off a wall and slides on", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, {0, -9.81, 0});
    particles.add(plane({0, 1, 0}, 0, 0.5, 0));
    particles.add(plane({-1, 0, 0}, -1, 0.5, 0));
    particles.set_all(state<T>({0.99, 0, 0}, {2, 0, 1}));
    particles.step();
    const auto end = particles.at(0);
    CHECK(std::abs(static_cast<double>(end.v[0]) + 1) <= 4 * eps<T>);
    CHECK(std::abs(static_cast<double>(end.x[0]) - (1 - (hz60 - 0.005))) <= 4 * eps<T>);
    CHECK(std::abs(static_cast<double>(end.x[2]) - hz60) <= 4 * eps<T>);
    CHECK(end.x[1] == T(0));
    CHECK(end.v[1] == T(0));
  });
}

// A wall that leans back deflects a sliding particle upwards. The flight is as if the floor had never held it.
TEST_CASE_TEMPLATE("a particle that a wall throws off the floor flies", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, {0, -9.81, 0});
    particles.add(plane({0, 1, 0}, 0, 0, 0));
    particles.add(plane({-0.6, 0.8, 0}, -0.6, 1, 0));
    particles.set_all(state<T>({0.99, 0, 0}, {4, 0, 0}));
    particles.step();
    // reflected: v - 2 (n.v) n = (4 - 2 * 2.4 * 0.6, 2 * 2.4 * 0.8) = (1.12, 3.84), 0.0025 s after the start
    const double t = hz60 - 0.0025;
    const auto end = particles.at(0);
    CHECK(std::abs(static_cast<double>(end.v[0]) - 1.12) <= 16 * eps<T>);
    CHECK(std::abs(static_cast<double>(end.v[1]) - (3.84 - 9.81 * t)) <= 16 * eps<T>);
    CHECK(std::abs(static_cast<double>(end.x[1]) - (3.84 * t - 9.81 * t * t / 2)) <= 16 * eps<T>);
  });
}

TEST_CASE_TEMPLATE("Bounces that are over within a step are over at its end", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const double restitution : {0.1, 0.5, 0.9}) {
      Particles<T> particles(kernels, hz60, {0, -9.81, 0});
      particles.add(plane({0, 1, 0}, 0, restitution, 0));
      // The particle falls at 0.01 m/s for 1 ms. The bounces last 2 e v/(g (1 - e)).
      const double speed = 0.01;
      const bool is_over = 2 * restitution * (speed + 9.81e-3) / (9.81 * (1 - restitution)) < hz60 - 1e-3;
      particles.set_all(state<T>({0, speed * 1e-3 + 9.81e-6 / 2, 0}, {3, -speed, 0}));
      particles.step();
      const auto end = particles.at(0);
      CHECK((end.x[1] == T(0) && end.v[1] == T(0)) == is_over);
      CHECK(end.v[0] == T(3));
      CHECK(std::abs(static_cast<double>(end.x[0]) - 0.05) <= 4 * eps<T>);
    }
  });
}

// ---- registers with particles in different states --------------------------------------------------------------------------

// The states in turn: at rest on the floor, sliding on it, flying, about to strike it, at rest on a wall under wind, in the
// edge of both, in the corner of all three, and sliding from the floor into a wall. No two register halves among 16 in a row
// are alike.
State3<double> mixed_start(std::size_t i) {
  const double a = static_cast<double>(i % 37) / 37;
  switch ((i * 5 + i / 16) % 8) {
    case 0:
      return {{-2 - a, 0, 2 + a}, {}};
    case 1:
      return {{-2 - a, 0, 2 + a}, {3 * a, 0, -1}};
    case 2:
      return {{-3, 5 + a, 3}, {a, 1, -a}};
    case 3:
      return {{-2 + a, 0.01 + 0.1 * a, 2}, {1, -3 - a, a}};
    case 4:
      return {{0, 2 + a, 2}, {0, a, 0.5}};
    case 5:
      return {{0, 0, 3 + a}, {0, 0, -a}};
    case 6:
      return {{0, 0, 0}, {}};
    default:
      return {{-0.05 * a, 0, 1 + a}, {4, 0, 1}};
  }
}

enum class Masses { alike, each };

// The walls lean, so that no two normals are perpendicular.
Scene mixed_scene(std::size_t walls, std::size_t count, Masses masses, double drag) {
  Scene scene;
  scene.add(Constant{.acceleration = {6, -9.81, -5}});
  if (masses == Masses::each) {
    std::vector<double> each(count);
    for (std::size_t i = 0; i < count; ++i) each[i] = 1 + 0.01 * static_cast<double>(i % 50);
    scene.mass = each;
  }
  if (drag > 0) scene.add(Drag{.coefficient = drag, .wind = {2, 0, -1}});
  const std::array planes = {plane({0, 1, 0}, 0, 0.4, 0.3), plane({-1, 0.1, 0}, 0, 0.3, 0.2), plane({0, -0.05, 1}, 0, 0, 0.9),
                             plane({1, 1, 0}, -9, 0.5, 0), plane({0, 0, -1}, -9, 1, 0.1)};
  for (std::size_t k = 0; k < walls; ++k) scene.add(planes[k]);
  return scene;
}

// Replaces all NaNs by one number: the NaN that an operation returns depends on the machine.
template <class T>
std::vector<T> with_one_nan(std::vector<T> values) {
  for (T& value : values) value = value == value ? value : T(-12345);
  return values;
}

template <class T>
std::vector<T> mixed_run(const Scene& scene, std::size_t count, const Options& options, std::size_t a_call, std::size_t calls,
                         std::size_t nan_every) {
  Batch<T> batch(Layout::soa_padded, count);
  const auto state = batch.view();
  for (std::size_t i = 0; i < count; ++i) {
    const State3<double> start = mixed_start(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.view().x[axis][i] = static_cast<T>(start.x[axis]);
      batch.view().v[axis][i] = static_cast<T>(start.v[axis]);
    }
    if (nan_every != 0 && i % nan_every == 3) batch.view().x[i % 3][i] = std::numeric_limits<T>::quiet_NaN();
    if (nan_every != 0 && i % nan_every == 4) batch.view().v[i % 3][i] = std::numeric_limits<T>::infinity();
  }
  const auto plan = compile<T>(scene, options, state);
  REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
  for (std::size_t n = 0; n < calls; ++n) REQUIRE(plan->step(batch.view(), a_call) == StepResult::done);
  CHECK(batch.is_clean());
  return with_one_nan(values_of(batch.view()));
}

TEST_CASE_TEMPLATE("Registers of particles that rest, fly, strike or are not a number have the twin's bits", T, float, double) {
  constexpr std::size_t count = 93;
  std::size_t turn = 0;  // separate and contracted take turns, so that each meets every value of the other parameters
  for (const std::size_t walls : {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{5}}) {
    for (const auto& each : {std::pair{Masses::alike, 0.0}, std::pair{Masses::alike, 0.4}, std::pair{Masses::each, 0.3}}) {
      const double drag = each.second;
      const Scene scene = mixed_scene(walls, count, each.first, drag);
      for (const double h : {hz60, -hz60}) {
        for (const std::size_t nan_every : {std::size_t{0}, std::size_t{9}}) {
          const Arithmetic arithmetic = (turn / 4 + turn / 2 + turn) % 2 == 0 ? Arithmetic::separate : Arithmetic::contracted;
          ++turn;
          const Options twin{.step = h, .isa = Isa::reference, .arithmetic = arithmetic};
          const std::vector<T> wanted = mixed_run<T>(scene, count, twin, 1, 16, nan_every);
          for (const Isa isa : available_isas(arithmetic)) {
            CAPTURE(name(isa));
            CAPTURE(walls);
            CAPTURE(drag);
            CAPTURE(nan_every);
            CAPTURE(h);
            const Options small{.step = h, .isa = isa, .arithmetic = arithmetic, .block = 48};
            const Options large{.step = h, .isa = isa, .arithmetic = arithmetic};
            CHECK(difference(wanted, mixed_run<T>(scene, count, small, 1, 16, nan_every)) == "");
            CHECK(difference(wanted, mixed_run<T>(scene, count, large, 8, 2, nan_every)) == "");
          }
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("Every register rests on the floor that the twin takes where two floors coincide", T, float, double) {
  Scene scene = mixed_scene(1, 93, Masses::alike, 0.2);
  scene.add(plane({0, 1, 0}, 0, 0.4, 0.9));
  const std::vector<T> wanted = mixed_run<T>(scene, 93, {.step = hz60, .isa = Isa::reference}, 1, 16, 0);
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    CAPTURE(name(isa));
    CHECK(difference(wanted, mixed_run<T>(scene, 93, {.step = hz60, .isa = isa}, 8, 2, 0)) == "");
  }
}

TEST_CASE_TEMPLATE("a particle that is not a number stays alone among those that rest", T, float, double) {
  constexpr std::size_t count = 160;
  const Scene scene = mixed_scene(3, count, Masses::alike, 0.2);
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    CAPTURE(name(isa));
    const Options options{.step = hz60, .isa = isa};
    const std::vector<T> sound = mixed_run<T>(scene, count, options, 1, 24, 0);
    const std::vector<T> with = mixed_run<T>(scene, count, options, 1, 24, 9);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (i % 9 == 3 || i % 9 == 4) continue;
      ++compared;
      for (std::size_t n = 6 * i; n < 6 * i + 6; ++n) CHECK(sound[n] == with[n]);
    }
    CHECK(compared > 100);
  }
}

// ---- a call does not recompute steps without an effect ----------------------------------------------------------------------

// Scenes by the cause of motion: none, a floor under gravity; a force that grows until friction gives way; a floor that starts
// to move under resting particles; a capsule, and so many that blocks are halved; and a spring that kicks in the middle of
// steps.
enum class Mover { none, force, floor, capsule, capsules, spring };

Scene lying_scene(Mover mover) {
  Scene scene;
  scene.add(Constant{.acceleration = {6, -9.81, -5}});
  for (Plane wall : {plane({0, 1, 0}, 0, 0.4, 0.9), plane({-1, 0, 0}, 0, 0.3, 0.2), plane({0, 0, 1}, 0, 0.3, 0.2)}) {
    if (mover == Mover::floor) wall.motion = 0;
    scene.add(wall);
  }
  if (mover == Mover::force) scene.add(Sinusoid{.acceleration = {-8, 0, 0}, .angular_frequency = 1.6});
  if (mover == Mover::floor)
    scene.motions = {{.keys = {{.time = 0}, {.time = 1.5}, {.time = 2, .translation = {0.15, 0.1, 0}}}}};
  if (mover == Mover::capsule)
    scene.add(Capsule{.ends = {{{-4, 0.5, 2}, {-1, 0.5, 2}}}, .radius = {0.5, 0.5}, .friction = 0.3});
  for (int k = 0; mover == Mover::capsules && k < 40; ++k) {
    scene.add(Capsule{.ends = {{{-0.05 * k, 0.1, 0}, {-0.05 * k, 0.1, 9}}}, .radius = {0.05, 0.05}, .friction = 0.3});
  }
  if (mover == Mover::spring) {
    scene.add(RadialSpring{.stiffness = 0.5, .anchor = Vec3{-4, 0, 4}, .rest_length = 5.0, .method = Method::pulse});
  }
  return scene;
}

constexpr std::size_t lying_steps = 150;

template <class T>
std::vector<T> calls_of(const Scene& scene, std::size_t count, const Options& options, std::size_t a_call) {
  return mixed_run<T>(scene, count, options, a_call, lying_steps / a_call, 9);
}

TEST_CASE_TEMPLATE("particles that lie have the bits of single steps in calls of many", T, float, double) {
  constexpr std::size_t count = 61;
  for (const Mover mover : {Mover::none, Mover::force, Mover::floor, Mover::capsule, Mover::capsules, Mover::spring}) {
    const Scene scene = lying_scene(mover);
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      const std::vector<T> wanted =
          calls_of<T>(scene, count, {.step = hz60, .isa = Isa::reference, .arithmetic = arithmetic}, 1);
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(name(isa));
        CAPTURE(static_cast<int>(mover));
        const Options options{.step = hz60, .isa = isa, .arithmetic = arithmetic};
        CHECK(difference(wanted, calls_of<T>(scene, count, options, lying_steps)) == "");
        const Options small{.step = hz60, .isa = isa, .arithmetic = arithmetic, .block = 32};
        CHECK(difference(wanted, calls_of<T>(scene, count, small, 10)) == "");
      }
    }
  }
}

}  // namespace dvdx::test::contact_rest_test
