// Balls that hit each other, compared with closed forms and conserved sums.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "kernel/meeting.hpp"

namespace meet_impacts_test {

using namespace dvdx;
using test::Balls;
using test::Stepped;

using Real = long double;
using Real3 = std::array<Real, 3>;
Real inner(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real3 along(const Real3& a, Real s, const Real3& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }
Real3 real(const Vec3& a) { return {Real{a[0]}, Real{a[1]}, Real{a[2]}}; }

struct Two {
  std::array<Real3, 2> x, v;
};

// Both balls after the time t; their radii sum to d.
Two hit(Two two, Real t, Real d, Real e, Real mu, Real w0, Real w1) {
  const Real3 q = along(two.x[0], -1, two.x[1]);
  const Real3 u = along(two.v[0], -1, two.v[1]);
  const Real a = inner(u, u);
  const Real b = inner(q, u);
  const Real square = b * b - a * (inner(q, q) - d * d);
  Real at = t;
  if (b < 0 && square > 0) at = std::min(t, (-b - std::sqrt(square)) / a);
  for (std::size_t k = 0; k < 2; ++k) two.x[k] = along(two.x[k], at, two.v[k]);
  if (at < t) {
    Real3 n = along(q, at, u);
    for (Real& component : n) component /= d;
    const Real normal = inner(n, u);
    const Real push = -(1 + e) * normal / (w0 + w1);
    const Real3 slide = along(u, -normal, n);
    const Real speed = std::sqrt(inner(slide, slide));
    Real3 pulse{push * n[0], push * n[1], push * n[2]};
    if (speed > 0) pulse = along(pulse, -std::min(speed / (w0 + w1), mu * push) / speed, slide);
    two.v[0] = along(two.v[0], w0, pulse);
    two.v[1] = along(two.v[1], -w1, pulse);
  }
  for (std::size_t k = 0; k < 2; ++k) two.x[k] = along(two.x[k], t - at, two.v[k]);
  return two;
}

double uniform(std::uint64_t stream, std::uint64_t index, double from, double to) {
  return from + (to - from) * test::uniform(stream, index);
}

TEST_CASE("two balls do what the closed form says, whatever the step") {
  std::size_t hits = 0;
  double worst_x = 0;
  double worst_v = 0;
  for (std::uint64_t n = 0; n < 300; ++n) {
    const double e = n % 5 == 0 ? static_cast<double>(n / 5 % 2) : uniform(0, n, 0, 1);
    const double mu = n % 7 == 0 ? 0 : uniform(1, n, 0, 1.5);
    const double mass = std::pow(10, uniform(2, n, -3, 3));
    const double radius = uniform(3, n, 0.2, 0.8);
    Balls balls;
    balls.add({uniform(4, n, -3, -1.2), uniform(5, n, 0, 0.8), uniform(6, n, 0, 0.3)}, {uniform(7, n, 2, 3), 0.125, 0});
    balls.add({}, {-uniform(8, n, 0, 1), 0, 0.25});
    Scene scene;
    scene.mass = std::vector<double>{1, mass};
    scene.add(Meet{.radius = std::vector<double>{radius, 1 - radius}, .restitution = e, .friction = mu});
    const unsigned steps = 1U << n % 6;
    Stepped<double> stepped(scene, balls, {.step = 2.0 / steps});
    Two expected{{real(balls.x[0]), real(balls.x[1])}, {real(balls.v[0]), real(balls.v[1])}};
    expected = hit(expected, 2, 1, Real{e}, Real{mu}, 1, 1 / Real{mass});
    hits += expected.v[0] != real(balls.v[0]) ? 1U : 0U;
    stepped.step(static_cast<std::size_t>(steps));
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        worst_x = std::max(worst_x, std::abs(stepped.x(k)[axis] - static_cast<double>(expected.x[k][axis])));
        worst_v = std::max(worst_v, std::abs(stepped.v(k)[axis] - static_cast<double>(expected.v[k][axis])));
      }
    }
  }
  CHECK(hits > 200);
  CHECK(worst_x < 1e-14);
  CHECK(worst_v < 1e-14);
}

// A row of touching balls. The first ones approach from `apart` away.
Balls row(std::size_t count, std::size_t moving, double apart) {
  Balls balls;
  for (std::size_t i = 0; i < count; ++i) {
    const bool moves = i < moving;
    balls.add({static_cast<double>(i) - (moves ? apart : 0), 0, 0}, {moves ? 1.0 : 0.0, 0, 0});
  }
  return balls;
}

TEST_CASE("as many balls of a cradle leave as come in") {
  for (const std::size_t count : {5U, 7U}) {
    for (const std::size_t moving : {1U, 2U, 3U}) {
      Scene scene;
      scene.add(Meet{.radius = 0.5, .restitution = 1});
      Stepped<double> stepped(scene, row(count, moving, 0.25), {.step = 0.0625});
      stepped.step(32);
      for (std::size_t i = 0; i < count; ++i) {
        const bool leaves = i >= count - moving;
        CAPTURE(i);
        CHECK(stepped.v(i)[0] == doctest::Approx(leaves ? 1.0 : 0.0).epsilon(1e-12));
        const double home = static_cast<double>(i);
        CHECK(stepped.x(i)[0] == doctest::Approx(leaves ? home + 1.75 : (i < moving ? home : home)).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("a ball that is hit from both sides at once stays, and both come back") {
  Balls balls;
  balls.add({-1.5, 0, 0}, {1, 0, 0});
  balls.add({});
  balls.add({1.5, 0, 0}, {-1, 0, 0});
  Scene scene;
  scene.add(Meet{.radius = 0.5, .restitution = 1});
  Stepped<double> stepped(scene, balls, {.step = 0.125});
  stepped.step(8);
  CHECK(stepped.v(0)[0] == -1);
  CHECK(stepped.v(1)[0] == 0);
  CHECK(stepped.v(2)[0] == 1);
}

struct Sums {
  double energy = 0;
  Vec3 momentum{};
};
template <class T>
Sums sums(Stepped<T>& stepped, std::size_t count) {
  Sums of;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 v = stepped.v(i);
    of.energy += 0.5 * dot(v, v);
    of.momentum = sum(of.momentum, v);
  }
  return of;
}

TEST_CASE("a cloud of balls keeps its momentum, and its energy where impacts are elastic") {
  Balls balls;
  constexpr std::size_t side = 6;
  for (std::size_t n = 0; n < side * side * side; ++n) {
    const auto at = [&](std::size_t k) { return 1.25 * static_cast<double>(k); };
    const auto speed = [&](std::uint64_t axis) { return uniform(axis, n, -2, 2); };
    balls.add({at(n % side), at(n / side % side), at(n / side / side)}, {speed(0), speed(1), speed(2)});
  }
  for (const double e : {1.0, 0.5, 0.0}) {
    Scene scene;
    scene.add(Meet{.radius = 0.5, .restitution = e, .friction = e == 1 ? 0 : 0.25});
    Stepped<double> stepped(scene, balls, {.step = 1.0 / 64});
    const Sums before = sums(stepped, balls.size());
    double energy = before.energy;
    double rise = 0;
    for (int n = 0; n < 64; ++n) {
      stepped.step();
      const Sums now = sums(stepped, balls.size());
      rise = std::max(rise, now.energy / energy - 1);
      energy = now.energy;
      CHECK(length(difference(now.momentum, before.momentum)) < 1e-11);
    }
    CHECK(rise < 1e-13);
    if (e == 1) CHECK(energy == doctest::Approx(before.energy).epsilon(1e-13));
    if (e < 1) CHECK(energy < 0.9 * before.energy);
  }
}

// The gas is so dense that a ball has several impacts in a sub-step, and one may bring it before another ball.
TEST_CASE("an elastic gas that is pressed together keeps its energy and its momentum") {
  Balls balls;
  constexpr std::size_t side = 10;
  constexpr double spacing = 1.25;
  for (std::size_t n = 0; n < side * side * side; ++n) {
    const std::array<std::size_t, 3> at{n % side, n / side % side, n / side / side};
    Vec3 x, v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from_middle = static_cast<double>(at[axis]) + 0.5 - 0.5 * static_cast<double>(side);
      x[axis] = spacing * from_middle;
      v[axis] = uniform(axis, n, -1, 1) - 0.3 * from_middle;
    }
    balls.add(x, v);
  }
  Scene scene;
  scene.add(Meet{.radius = 0.5, .restitution = 1});
  Stepped<double> stepped(scene, balls, {.step = 0.01});
  const Sums before = sums(stepped, balls.size());
  for (int n = 0; n < 10; ++n) {
    stepped.step(20);
    const Sums now = sums(stepped, balls.size());
    CHECK(now.energy == doctest::Approx(before.energy).epsilon(1e-13));
    CHECK(length(difference(now.momentum, before.momentum)) < 1e-11);
  }
}

// The balls move up to 2.5 cm in a sub-step, off walls and each other. Pushes along their chords gave 3900 times the energy.
TEST_CASE("two elastic balls of 1 cm in a box of 10 cm gain little energy in 100 s, however coarse the step") {
  Balls balls;
  balls.add({-0.03, 0.001, 0}, {1, 0.3, -0.4});
  balls.add({0.02, 0, 0.002}, {-0.2, 0.5, 0.7});
  Scene scene;
  for (const double side : {-1.0, 1.0}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3 normal{};
      normal[axis] = side;
      scene.add(Contact{Plane{.normal = normal, .offset = -0.05, .restitution = 1}});
    }
  }
  scene.add(Meet{.radius = 0.01, .restitution = 1});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
  const double before = sums(stepped, balls.size()).energy;
  stepped.step(6000);
  CHECK(sums(stepped, balls.size()).energy < 1.2 * before);
  CHECK(sums(stepped, balls.size()).energy > 0.9 * before);
}

}  // namespace meet_impacts_test
