// Balls that particles stay inside or outside: the twins' bits, the pendulum's closed form, and no gain of energy.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "isa/passes.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/close.hpp"

namespace ball_test {

using namespace dvdx;
using test::Joined;
using test::scatter;
using test::stepped;

constexpr double pi = 3.14159265358979323846;
constexpr double infinite = std::numeric_limits<double>::infinity();

// ---- the pass by itself -------------------------------------------------------------------------------------------------

// The columns of a pass over 96 balls, of which the last ten belong to no particle.
template <class T>
struct Columns {
  static constexpr std::size_t balls = 96, particles = 86, size = 128;

  std::vector<std::vector<T>> memory = std::vector<std::vector<T>>(17, std::vector<T>(size, T(0)));
  std::vector<std::int32_t> element;
  WorkColumns<T> work;
  BallTerms<T> terms;

  // With `in_a_row` the elements are contiguous, except for two that are swapped.
  Columns(double per_step, bool in_a_row) {
    const auto axes = [&](std::size_t first) {
      return std::array<T*, 3>{memory[first].data(), memory[first + 1].data(), memory[first + 2].data()};
    };
    work.x = axes(0);
    work.v = axes(3);
    work.w = memory[6].data();
    terms.c = axes(7);
    terms.u = axes(10);
    terms.n = axes(13);
    terms.r = memory[16].data();
    for (std::size_t s = 0; s < balls; ++s) {
      const std::size_t i = in_a_row ? (s == 1 ? 33 : s == 33 ? 1 : s) : (7 * s) % particles;
      element.push_back(static_cast<std::int32_t>(s < particles ? i : size - 16));
    }
    terms.element = element.data();
    terms.per_step = static_cast<T>(per_step);
  }
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

  // Particles far inside, on the ball, beyond it, and passing right through it, with bad and held ones among them.
  void fill(std::size_t seed) {
    for (std::size_t s = 0; s < balls; ++s) {
      const auto i = static_cast<std::size_t>(element[s]);
      const auto number = [&](std::size_t k) { return static_cast<T>(scatter(s + 1000 * seed, k)); };
      memory[6][i] = s < particles && s % 11 != 3 ? T(1) : T(0);
      memory[16][s] = s % 13 == 5 ? T(0) : (s % 13 == 6 ? std::numeric_limits<T>::infinity() : T(0.5) + T(0.4) * number(0));
      const T near = s % 3 == 0 ? T(1) : (s % 3 == 1 ? T(1.3) : T(0.4));
      T n2 = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        memory[7 + axis][s] = number(1 + axis);
        memory[10 + axis][s] = number(4 + axis);
        memory[13 + axis][s] = number(7 + axis);
        n2 += number(7 + axis) * number(7 + axis);
      }
      const T r = std::isinf(memory[16][s]) ? T(1) : memory[16][s];
      const T way = s % 4 == 0 ? T(3) : T(0.1);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        memory[13 + axis][s] *= near * r / std::sqrt(n2);
        memory[axis][i] = memory[7 + axis][s] + memory[13 + axis][s] + way * number(10 + axis);
        memory[3 + axis][i] = T(20) * number(13 + axis);
      }
      if (s % 17 == 2) memory[s % 3][i] = std::numeric_limits<T>::quiet_NaN();
      if (s % 17 == 4) memory[3 + s % 3][i] = std::numeric_limits<T>::infinity();
      if (s % 19 == 7) memory[13][s] = std::numeric_limits<T>::quiet_NaN();
      if (s % 23 == 9) memory[13][s] = memory[14][s] = memory[15][s] = T(0);
    }
  }

  // All particles are far from the bound, except for one that passes right through its ball and, for at_most, out of it.
  void keep_calm(Bound bound, std::size_t one) {
    for (std::size_t s = 0; s < balls; ++s) {
      const auto i = static_cast<std::size_t>(element[s]);
      memory[16][s] = T(1);
      const T n = bound == Bound::at_most ? T(0.5) : T(3);
      const T end = s == one ? -T(1.5) : n + T(0.1) * static_cast<T>(scatter(s, 1));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        memory[13 + axis][s] = axis == 1 ? n : T(0.01);
        memory[axis][i] = memory[7 + axis][s] + (axis == 1 ? end : T(0.02));
        memory[3 + axis][i] = static_cast<T>(scatter(s, 2 + axis));
      }
      memory[6][i] = s < particles ? T(1) : T(0);
    }
  }
};

template <class T>
std::string difference(const Columns<T>& a, const Columns<T>& b) {
  for (std::size_t c = 0; c < a.memory.size(); ++c) {
    for (std::size_t i = 0; i < a.size; ++i) {
      const bool is_any_nan = std::isnan(a.memory[c][i]) && std::isnan(b.memory[c][i]);
      if (is_any_nan || std::memcmp(&a.memory[c][i], &b.memory[c][i], sizeof(T)) == 0) continue;
      return "column " + std::to_string(c) + ", element " + std::to_string(i) + ": " + std::to_string(a.memory[c][i]) +
             " and " + std::to_string(b.memory[c][i]);
    }
  }
  return "";
}

// ---- scenes -------------------------------------------------------------------------------------------------------------

// A particle in a ball about the origin.
Joined in_ball(const Vec3& x, const Vec3& v, double r, double step) {
  Joined joined;
  joined.name = "a particle in a ball";
  joined.x = {x};
  joined.v = {v};
  joined.step = step;
  joined.scene.add(Skin{.particles = {0}, .points = {{0, 0, 0}}, .at_most = r});
  return joined;
}

// s: the period of a pendulum of 1 m that starts at rest at `angle` from its lowest point, by the arithmetic-geometric mean.
double period(double angle, double g) {
  double a = 1, b = std::cos(angle / 2);
  for (int k = 0; k < 8; ++k) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * pi / std::sqrt(g) / a;
}

// m: the distance from the place on the other side where the pendulum must be at rest after half a period.
double pendulum_error(std::size_t steps) {
  const double g = 9.81, angle = 1.2;
  Joined joined = in_ball({std::sin(angle), -std::cos(angle), 0}, {}, 1, period(angle, g) / 2 / static_cast<double>(steps));
  joined.scene.add(Constant{.acceleration = {0, -g, 0}});
  const auto at = stepped<double>(joined, {.isa = best_isa()}, steps);
  CHECK(std::hypot(at[0], at[1], at[2]) <= 1 + 1e-15);
  return std::hypot(at[0] + std::sin(angle), at[1] + std::cos(angle), at[2]);
}

double energy(const std::vector<double>& at) { return at[3] * at[3] + at[4] * at[4] + at[5] * at[5]; }

TEST_CASE_TEMPLATE("ball: every instruction set gives the bits of the scalar twin", T, float, double) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    const auto& twin = find_passes(Isa::reference, arithmetic)->of<T>().ball;
    for (const Isa isa : available_isas(arithmetic)) {
      const auto& wide = find_passes(isa, arithmetic)->of<T>().ball;
      for (const Bound bound : {Bound::at_most, Bound::at_least}) {
        for (const double per_step : {60.0, -240.0}) {
          for (std::size_t seed = 0; seed < 20; ++seed) {
            Columns<T> a(per_step, seed % 2 == 1), b(per_step, seed % 2 == 1);
            a.fill(seed);
            b.fill(seed);
            twin.keep(a.terms, bound, a.work, 0, a.balls);
            wide.keep(b.terms, bound, b.work, 0, b.balls);
            CHECK_MESSAGE(difference(a, b) == "", name(isa) << ", seed " << seed);
            twin.prepare(a.terms, a.work, 0, a.balls);
            wide.prepare(b.terms, b.work, 0, b.balls);
            CHECK_MESSAGE(difference(a, b) == "", name(isa) << ", prepared, seed " << seed);
          }
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("ball: a particle that alone breaks its bound is found, on every instruction set", T, float, double) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    const auto& twin = find_passes(Isa::reference, arithmetic)->of<T>().ball;
    for (const Isa isa : available_isas(arithmetic)) {
      const auto& wide = find_passes(isa, arithmetic)->of<T>().ball;
      for (const Bound bound : {Bound::at_most, Bound::at_least}) {
        for (std::size_t one = 0; one < Columns<T>::particles; ++one) {
          Columns<T> a(60, one % 2 == 1), b(60, one % 2 == 1);
          a.keep_calm(bound, one);
          b.keep_calm(bound, one);
          const auto i = static_cast<std::size_t>(a.element[one]);
          const T before = a.memory[1][i];
          twin.keep(a.terms, bound, a.work, 0, a.balls);
          wide.keep(b.terms, bound, b.work, 0, b.balls);
          CHECK_MESSAGE(difference(a, b) == "", name(isa) << ", particle " << one);
          CHECK(b.memory[1][i] > before);
        }
      }
    }
  }
}

TEST_CASE("ball: every particle ends on the right side of its ball, and fixed and bad particles are left alone") {
  for (const Bound bound : {Bound::at_most, Bound::at_least}) {
    for (std::size_t seed = 0; seed < 200; ++seed) {
      Columns<double> before(120, false), after(120, false);
      before.fill(seed);
      after.fill(seed);
      find_passes(Isa::reference)->of<double>().ball.keep(after.terms, bound, after.work, 0, after.balls);
      for (std::size_t s = 0; s < Columns<double>::particles; ++s) {
        const auto i = static_cast<std::size_t>(before.element[s]);
        bool is_left_alone = before.memory[6][i] == 0;
        double e2 = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double x = before.memory[axis][i], v = before.memory[3 + axis][i], n = before.memory[13 + axis][s];
          is_left_alone = is_left_alone || !std::isfinite(x) || !std::isfinite(v) || !std::isfinite(n);
          e2 += std::pow(after.memory[axis][i] - before.memory[7 + axis][s], 2);
        }
        if (is_left_alone) {
          for (std::size_t c = 0; c < 6; ++c) CHECK(std::memcmp(&before.memory[c][i], &after.memory[c][i], 8) == 0);
          continue;
        }
        const double r = before.memory[16][s];
        if (bound == Bound::at_most) CHECK(std::sqrt(e2) <= r + 1e-14);
        if (bound == Bound::at_least && std::isfinite(r)) CHECK(std::sqrt(e2) >= r - 1e-14);
      }
    }
  }
}

TEST_CASE("ball: a pendulum of an inextensible string has the closed form's period, to second order") {
  const double coarse = pendulum_error(60), fine = pendulum_error(120), finest = pendulum_error(240);
  CHECK(coarse < 2e-3);
  CHECK(coarse / fine > 3.5);
  CHECK(fine / finest > 3.5);
}

TEST_CASE("ball: a particle at rest below the center hangs at exactly its radius") {
  Joined joined = in_ball({0, -1, 0}, {}, 1, 1.0 / 60);
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const auto at = stepped<double>(joined, {.isa = best_isa()}, 1000);
  CHECK(at[0] == 0);
  CHECK(test::is_close(at[1], -1, 1e-15));
  CHECK(std::abs(at[4]) < 1e-15);
}

TEST_CASE("ball: a free flight that meets its ball keeps the tangential velocity, loses the normal one and gains none") {
  for (std::size_t k = 0; k < 200; ++k) {
    const Vec3 start{0.3 * scatter(k, 0), 0.3 * scatter(k, 1), 0.3 * scatter(k, 2)};
    const Vec3 v{4 * scatter(k, 3), 4 * scatter(k, 4), 4 * scatter(k, 5)};
    // The place where the path meets the ball of 1 m, and the part of v tangential to it there.
    const double sv = start[0] * v[0] + start[1] * v[1] + start[2] * v[2];
    const double vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const double ss = start[0] * start[0] + start[1] * start[1] + start[2] * start[2];
    const double t = (std::sqrt(sv * sv + vv * (1 - ss)) - sv) / vv;
    double pv = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) pv += (start[axis] + t * v[axis]) * v[axis];
    const double across = vv - pv * pv;
    // A remainder of less than 1/16 of a step after the impact is treated as a longer one.
    const double step = 1.0 / 30;
    const auto steps = static_cast<std::size_t>(t / step) + 1;
    const double left = static_cast<double>(steps) * step - t;
    if (left < step / 16 || across * step * step > 0.5) continue;
    const auto at = stepped<double>(in_ball(start, v, 1, step), {}, steps);
    CHECK(test::is_close(energy(at), across, 1e-9));
    // The particle then circles on the ball without gain or loss.
    const auto later = stepped<double>(in_ball(start, v, 1, step), {}, steps + 300);
    CHECK(test::is_close(energy(later), across, 1e-7));
    CHECK(test::is_close(std::hypot(later[0], later[1], later[2]), 1, 1e-12));
  }
}

TEST_CASE("ball: a particle beyond its ball is set onto it without gaining speed, and a radius of 0 pins it to the center") {
  const auto beyond = stepped<double>(in_ball({3, 0, 0}, {0, 0.1, 0}, 1, 0.01), {}, 1);
  CHECK(test::is_close(std::hypot(beyond[0], beyond[1], beyond[2]), 1, 1e-15));
  CHECK(energy(beyond) <= 0.01 * (1 + 1e-12));
  const auto held = stepped<double>(in_ball({0.2, 0, 0}, {5, 5, 5}, 0, 0.01), {}, 3);
  for (const double number : held) CHECK(number == 0);
}

TEST_CASE("ball: a limit that is infinite changes no bit") {
  for (const bool is_sheet : {true, false}) {
    Joined free = test::sheet(9, 12, 400);
    if (!is_sheet) {
      free.scene.networks.clear();
      free.scene.add(Spring{.stiffness = 0.2});
    }
    Joined limited = free;
    limited.scene.add(Skin{.particles = {3, 5, 8}, .at_most = infinite});
    CHECK(test::difference(stepped<float>(free, {}, 20), stepped<float>(limited, {}, 20)) == "");
    CHECK(test::difference(stepped<double>(free, {}, 20), stepped<double>(limited, {}, 20)) == "");
  }
}

TEST_CASE("ball: a bad particle stays alone") {
  Joined sheet = test::sheet(9, 12, 400);
  sheet.scene.fixed = {0, 11};
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < sheet.x.size(); ++i) all.push_back(i);
  sheet.scene.add(Skin{.particles = all, .at_most = 0.02, .backstop = Backstop{.normals = {{0, 1, 0}}, .offset = 0.005}});
  sheet.x[30][1] = std::nan("");
  const auto at = stepped<double>(sheet, {}, 30);
  for (std::size_t i = 0; i < at.size(); ++i) CHECK((std::isfinite(at[i]) || i / 6 == 30));
  CHECK(std::isnan(at[6 * 30 + 1]));
}

}  // namespace ball_test
