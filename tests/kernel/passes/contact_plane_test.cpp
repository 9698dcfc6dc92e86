// The contact pass on planes: rest, corners, and fast particles, by every table of every ISA.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "dvdx/plan.hpp"
#include "kernel/passes/contacts.hpp"
#include "kernel/passes/particles.hpp"

namespace dvdx::test::contacts::plane_test {

TEST_CASE_TEMPLATE("rest on an axis-aligned plane is exact for a million steps", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const bool is_long = words == "avx2 contracted";
    for (const double offset : {0.0, 7.3, -0.1}) {
      for (const double restitution : {0.0, 0.5, 1.0}) {
        Particles<T> particles(kernels, hz60, gravity);
        particles.add(plane({0, 1, 0}, offset, restitution));
        const auto start = state<T>(3, static_cast<double>(static_cast<T>(offset)), -2, 0, 0, 0);
        particles.set_all(start);
        particles.step(is_long && restitution == 0.5 && offset == 7.3 ? 1000000 : 500);
        CHECK(particles.at(0).x == start.x);
        CHECK(particles.at(15).v == start.v);
      }
    }
  });
}

TEST_CASE_TEMPLATE("rest on an oblique plane neither sinks nor creeps", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const bool is_long = words == "avx2 contracted";
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 12; ++trial) {
      const Vec3 n = unit({normal(random), normal(random), normal(random)});
      const double offset = trial % 3 == 0 ? 7.3 : normal(random);
      const Vec3 along{n[1], -n[0], 0};
      Particles<T> particles(kernels, hz60, {-9.81 * n[0], -9.81 * n[1], -9.81 * n[2]});
      particles.add(plane(n, offset, trial % 2 == 0 ? 0.5 : 0.0));
      const double reach = 2;
      const auto start = state<T>(offset * n[0] + reach * along[0], offset * n[1] + reach * along[1], offset * n[2], 0, 0, 0);
      particles.set_all(start);
      particles.step(100);
      const State3<T> settled = particles.at(3);
      particles.step(is_long && trial == 0 ? 300000 : 500);
      const State3<T> end = particles.at(3);
      const Vec3 x = wide(end.x);
      CHECK(std::abs(product(wide(particles.surfaces[0].n), x) - static_cast<double>(particles.surfaces[0].d)) <=
            4 * eps<T> * length(x));
      CHECK(std::abs(product(n, wide(end.v))) <= 1e-6);
      CHECK(length(wide(end.v)) <= 1e-6);
      CHECK(end.x == settled.x);
      for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(end.x[k] - start.x[k]) <= 16 * eps<T> * length(x));
    }
  });
}

TEST_CASE_TEMPLATE("grazing leaves the velocity as it is", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const double y : {0.0, 1e-7}) {
      Particles<T> particles(kernels, hz60, still);
      Plane ground = floor_with(0.5);
      ground.friction = 0.3;
      ground.viscosity = 1;
      particles.add(ground);
      const auto start = state<T>(0.1, y, 0.2, 1.1, 0, -2.3);
      particles.set_all(start);
      particles.step(1000);
      CHECK(particles.at(7).v == start.v);
    }
  });
}

TEST_CASE_TEMPLATE("starting inside and on the surface", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, still);
    particles.add(floor_with(0.5));
    particles.set(0, state<T>(0, -0.1, 0, 0, -5, 0));
    particles.set(1, state<T>(0, -0.1, 0, 0, 0, 0));
    particles.set(2, state<T>(0, -0.1, 0, 0, 5, 0));
    particles.set(3, state<T>(0, 0, 0, 0, 3, 0));
    particles.set(4, state<T>(0, 0, 0, 0, -3, 0));
    particles.step();
    const std::array<double, 3> left{2.5, 0, 5};
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(particles.at(i).x[1] >= 0);
      CHECK(particles.at(i).v[1] == static_cast<T>(left[i]));
    }
    CHECK(std::abs(static_cast<double>(particles.at(3).x[1]) - 0.05) <= 4 * eps<T> * 0.05);
    CHECK(std::abs(static_cast<double>(particles.at(4).x[1]) - 0.025) <= 4 * eps<T> * 0.025);
    CHECK(particles.at(3).v[1] == T(3));
    CHECK(particles.at(4).v[1] == T(1.5));
  });
}

TEST_CASE_TEMPLATE("corners of two and three planes hit at once", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const std::size_t walls : {2U, 3U}) {
      Particles<T> particles(kernels, hz60, still);
      particles.add(plane({1, 0, 0}, 0, 1));
      particles.add(plane({0, 1, 0}, 0, 1));
      if (walls == 3) particles.add(plane({0, 0, 1}, 0, 1));
      const double near = 0.5 * hz60;
      const double w = walls == 3 ? -1 : 0;
      particles.set_all(state<T>(near, near, walls == 3 ? near : 1, -1, -1, w));
      particles.step();
      const State3<T> end = particles.at(9);
      for (std::size_t k = 0; k < walls; ++k) {
        CHECK(std::abs(static_cast<double>(end.x[k]) - near) <= 4 * eps<T> * std::sqrt(3.0) * hz60);
        CHECK(end.v[k] == T(1));
      }
      const double speed = std::sqrt(static_cast<double>(walls));
      CHECK(std::abs(length(wide(end.v)) - speed) <= 4 * eps<T> * speed);
    }
  });
}

TEST_CASE_TEMPLATE("a wedge of 20 degrees", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double angle = 20 * std::numbers::pi / 180;
    Particles<T> particles(kernels, hz60, still);
    particles.add(plane({0, 1, 0}, 0, 1));
    particles.add(plane({std::sin(angle), -std::cos(angle), 0}, 0, 1));
    particles.add(plane({-1, 0, 0}, -2, 1));
    for (std::size_t i = 0; i < particles.count(); ++i) {
      const double turn = static_cast<double>(i) * 0.37;
      particles.set(i, state<T>(1.2, 0.2, 0, 3 * std::cos(turn), 3 * std::sin(turn), 0));
    }
    double worst_gain = 0;
    double deepest = 0;
    for (int n = 0; n < 1500; ++n) {
      std::array<double, 16> before{};
      for (std::size_t i = 0; i < 16; ++i) before[i] = length(wide(particles.at(i).v));
      particles.step();
      for (std::size_t i = 0; i < 16; ++i) {
        const State3<T> now = particles.at(i);
        const double speed = length(wide(now.v));
        worst_gain = std::max(worst_gain, speed * speed / (before[i] * before[i]) - 1);
        for (const auto& surface : particles.surfaces) {
          deepest = std::max(deepest, static_cast<double>(surface.d) - product(wide(surface.n), wide(now.x)));
        }
      }
    }
    CHECK(worst_gain <= (sizeof(T) == 4 ? 2e-6 : 1e-14));
    CHECK(deepest <= 4 * eps<T> * 2);
    for (std::size_t i = 0; i < 16; ++i) CHECK(length(wide(particles.at(i).v)) > 2.9);
  });
}

TEST_CASE_TEMPLATE("a channel with many bounces in a step", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const int bounces : {2, 17, 167}) {
      Particles<T> particles(kernels, hz60, still);
      particles.terms.impacts = 32;
      const double width = 0.0625;
      particles.add(plane({0, 1, 0}, 0, 1));
      particles.add(plane({0, -1, 0}, -width, 1));
      const double way = (bounces + 0.3) * width;
      particles.set_all(state<T>(0, 0, 0, 0.7, way * 60, 0));
      particles.step();
      const State3<T> end = particles.at(4);
      const double y = static_cast<double>(end.x[1]);
      CHECK(y >= -1e-6);
      CHECK(y <= width + 1e-6);
      CHECK(length(wide(end.v)) <= length({0.7, way * 60, 0}) * (1 + 4 * eps<T>));
      if (bounces <= 32) CHECK(std::abs(y - (bounces % 2 == 0 ? 0.3 : 0.7) * width) <= 1e-6);
    }
  });
}

TEST_CASE_TEMPLATE("nothing tunnels", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const ContactPath sweep : {ContactPath::curve, ContactPath::line}) {
      Particles<T> particles(kernels, hz60, still);
      Plane ground = floor_with(1);
      ground.sweep = sweep;
      particles.add(ground);
      particles.set_all(state<T>(0, 10, 0, 0, -1e5, 0));
      particles.step();
      CHECK(std::abs(static_cast<double>(particles.at(2).x[1]) - (1e5 / 60 - 10)) <= 4 * eps<T> * 1656.667);
    }
    for (const ContactPath sweep : {ContactPath::curve, ContactPath::line}) {  // a sphere that a single step crosses
      Particles<T> particles(kernels, hz60, still);
      Sphere ball;
      ball.restitution = 1;
      ball.sweep = sweep;
      particles.add(ball);
      particles.set_all(state<T>(0, 10, 0, 0, -1e4, 0));
      particles.step();
      CHECK(std::abs(static_cast<double>(particles.at(2).x[1]) - (1 + 1e4 / 60 - 9)) <= 8 * eps<T> * 160);
      CHECK(std::abs(static_cast<double>(particles.at(2).v[1]) - 1e4) <= 4 * eps<T> * 1e4);
    }
  });
}

TEST_CASE_TEMPLATE("infinite friction holds a particle in a corner", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const bool is_viscous : {false, true}) {
      Particles<T> particles(kernels, hz60, {-2, -9.81, 1});
      Plane ground = floor_with(0);
      Plane wall = plane({1, 0, 0}, 0, 0);
      for (Plane* surface : {&ground, &wall}) {
        surface->friction = is_viscous ? 0 : std::numeric_limits<double>::infinity();
        surface->viscosity = is_viscous ? std::numeric_limits<double>::infinity() : 0;
      }
      particles.add(ground);
      particles.add(wall);
      particles.set_all(state<T>(0, 0, 0, -1, -2, 3));
      particles.step(2);
      CHECK(particles.at(6).v == std::array<T, 3>{});
      const State3<T> held = particles.at(6);
      particles.step(1000);
      CHECK(particles.at(6).v == std::array<T, 3>{});
      CHECK(particles.at(6).x == held.x);
    }
  });
}

}  // namespace dvdx::test::contacts::plane_test
