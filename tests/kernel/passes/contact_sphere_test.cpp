// The contact pass on spheres, inside and outside, by every table of every ISA.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/contacts.hpp"
#include "kernel/passes/particles.hpp"

namespace dvdx::test::contacts::sphere_test {

TEST_CASE("a throw onto a sphere hits it where the parabola does") {
  const Vec3 x{0.3, 1.5, 0}, v{0.2, -1, 0.1};
  const auto at = [&](double t) {
    Vec3 p{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = x[k] + t * v[k] + 0.5 * t * t * gravity[k];
    return p;
  };
  double low = 0, high = 0.4;
  for (int n = 0; n < 100; ++n) (length(at(0.5 * (low + high))) > 1 ? low : high) = 0.5 * (low + high);
  Scene scene;
  scene.add(Constant{.acceleration = gravity});
  scene.add(Sphere{.center = {}, .radius = 1, .response = Response::end_on_surface});  // ends at the impact
  Soa<double> memory(1);
  State<double> state = memory.view();
  for (std::size_t k = 0; k < 3; ++k) {
    state.x[k][0] = x[k];
    state.v[k][0] = v[k];
  }
  (void)compile<double>(scene, {.step = 0.5})->step(state);
  // The tangential displacement is kept. Only the part along the normal of the impact is removed.
  const Vec3 hit = at(low), end = at(0.5);
  double into = 0;
  for (std::size_t k = 0; k < 3; ++k) into += hit[k] * (end[k] - hit[k]);
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(state.x[k][0] - (end[k] - into * hit[k])) <= 1e-13);
}

// The particle starts beside a sphere along its tangent, and is pulled into it and out again: x = (1.05 - 2 f^2, sqrt(2.5) f)
// in a step of 1 s. |x| = 1 where 4 f^4 - 1.7 f^2 + 0.1025 = 0. The path's end is outside, and so is that of the straight line.
TEST_CASE("a path that bends into a sphere and out of it within a step hits it at its quartic's root") {
  const double u = std::sqrt(2.5);
  const double f = std::sqrt((1.7 - std::sqrt(1.7 * 1.7 - 16 * 0.1025)) / 8);
  const Vec3 n{1.05 - 2 * f * f, u * f, 0};
  CHECK(std::abs(length(n) - 1) < 1e-14);
  const double into = product(n, {-4 * f, u, 0});
  const Vec3 after{-4 * f - 2 * into * n[0], u - 2 * into * n[1], 0};
  const double rest = 1 - f;
  Scene scene;
  scene.add(Constant{.acceleration = {-4, 0, 0}});
  scene.add(Sphere{.center = {}, .radius = 1, .restitution = 1});
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      Soa<double> memory(1);
      State<double> state = memory.view();
      for (std::size_t k = 0; k < 3; ++k) state.x[k][0] = state.v[k][0] = 0;
      state.x[0][0] = 1.05;
      state.v[1][0] = u;
      (void)compile<double>(scene, {.step = 1, .isa = isa, .arithmetic = arithmetic})->step(state);
      CAPTURE(name(isa));
      CHECK(std::abs(state.x[0][0] - (n[0] + rest * after[0] - 2 * rest * rest)) <= 1e-12);
      CHECK(std::abs(state.x[1][0] - (n[1] + rest * after[1])) <= 1e-12);
      CHECK(std::abs(state.v[0][0] - (after[0] - 4 * rest)) <= 1e-12);
      CHECK(std::abs(state.v[1][0] - after[1]) <= 1e-12);
    }
  }
}

TEST_CASE_TEMPLATE("inside and outside of spheres", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    {  // billiards inside: the speed and the angular momentum are kept
      Particles<T> particles(kernels, hz60, still, 64);
      Sphere shell;
      shell.side = Side::inside;
      shell.restitution = 1;
      shell.radius = 0.5;
      particles.add(shell);
      for (std::size_t i = 0; i < 64; ++i) {
        particles.set(i, state<T>(0.2 * std::tanh(normal(random)), 0.2 * std::tanh(normal(random)), 0.1, 20 * normal(random),
                                  20 * normal(random), 20 * normal(random)));
      }
      std::vector<double> speeds;
      for (std::size_t i = 0; i < 64; ++i) speeds.push_back(length(wide(particles.at(i).v)));
      particles.step(300);
      for (std::size_t i = 0; i < 64; ++i) {
        CHECK(length(wide(particles.at(i).x)) <= 0.5 * (1 + 4 * eps<T>));
        CHECK(std::abs(length(wide(particles.at(i).v)) / speeds[i] - 1) <= (sizeof(T) == 4 ? 1e-3 : 1e-12));
      }
    }
    {  // rain on a ball: nothing enters, the energy is kept
      Particles<T> particles(kernels, hz60, gravity, 64);
      Sphere ball;
      ball.restitution = 1;
      particles.add(ball);
      std::vector<double> energies;
      for (std::size_t i = 0; i < 64; ++i) {
        const auto start = state<T>(0.6 * std::tanh(normal(random)), 2, 0.6 * std::tanh(normal(random)), 0, normal(random), 0);
        particles.set(i, start);
        energies.push_back(9.81 * 2 + std::pow(length(wide(start.v)), 2) / 2);
      }
      for (int n = 0; n < 60; ++n) {
        particles.step();
        for (std::size_t i = 0; i < 64; ++i) REQUIRE(length(wide(particles.at(i).x)) >= 1 - 4 * eps<T>);
      }
      for (std::size_t i = 0; i < 64; ++i) {
        const State3<T> end = particles.at(i);
        const double energy = 9.81 * static_cast<double>(end.x[1]) + std::pow(length(wide(end.v)), 2) / 2;
        CHECK(std::abs(energy / energies[i] - 1) <= (sizeof(T) == 4 ? 1e-4 : 1e-10));
      }
    }
    {  // the exact centre: pushed out, without NaN
      Particles<T> particles(kernels, hz60, still);
      Sphere ball;
      ball.restitution = 0.5;
      particles.add(ball);
      particles.set(1, state<T>(0, 0, 0, 0, -1, 0));
      particles.set(2, state<T>(0, 0, 0, 1, 0, 0));
      particles.step();
      for (std::size_t i = 0; i < 16; ++i) {
        CHECK(std::abs(length(wide(particles.at(i).x)) - 1) <= 4 * eps<T>);
        CHECK(std::isfinite(particles.at(i).v[0] + particles.at(i).v[1] + particles.at(i).v[2]));
      }
    }
    {  // at rest at the bottom of a bowl and on top of a ball
      Particles<T> particles(kernels, hz60, gravity);
      Sphere bowl;
      bowl.side = Side::inside;
      bowl.center = {0, 1, 0};
      particles.add(bowl);
      particles.set_all(state<T>(0, 0, 0, 0, 0, 0));
      particles.step(1000);
      CHECK(particles.at(5).x == std::array<T, 3>{});
      CHECK(particles.at(5).v == std::array<T, 3>{});
    }
  });
}

}  // namespace dvdx::test::contacts::sphere_test
