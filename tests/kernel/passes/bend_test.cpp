// Impacts under springs, drag and forces of time: the responses in a step, the energy of a bounce, dips.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "flow/bend_reference.hpp"
#include "flow/bend_terms.hpp"
#include "kernel/passes/particles.hpp"
#include "math/psi.hpp"

namespace dvdx::test::bend_test {

template <class T>
Bend<T> bend_of(double z, double q, double theta) {
  Bend<T> bend;
  bend.w.fill(static_cast<T>(z * z));
  bend.q.fill(static_cast<T>(q));
  set_bend(bend, z, std::abs(q), theta);
  return bend;
}

double power(double phi, int k) { return std::pow(phi, k); }

// One step of one particle above a floor at 0.
struct Fall {
  double y, v;
};
template <class T>
Fall after_step(const Scene& scene, const Fall& start, double h = hz60) {
  Soa<T> memory(1);
  State<T> state = memory.view();
  state.x[1][0] = static_cast<T>(start.y);
  state.v[1][0] = static_cast<T>(start.v);
  const auto plan = compile<T>(scene, {.step = h}, state);
  REQUIRE(plan.has_value());
  (void)plan->step(state);
  return {static_cast<double>(state.x[1][0]), static_cast<double>(state.v[1][0])};
}

TEST_CASE_TEMPLATE("the responses in a step are the psi functions", T, float, double) {
  double worst = 0;
  for (const double theta : {0.0, 1.0}) {
    for (const double z : {0.0, 1e-3, 0.04, 0.3, 1.0, 2.0, 6.0}) {
      for (const double q : {0.0, 1e-3, 0.04, -0.5, 1.0, 3.0, 40.0}) {
        if (z == 0 && q == 0 && theta == 0) continue;
        const Bend<T> bend = bend_of<T>(z, q, theta);
        REQUIRE(bend.degree < most_bend_terms);
        const reference::Bending<Arithmetic::separate, T> bending(bend, 0);
        for (const double part : {1e-3, 0.2, 0.5, 0.9, 1.0}) {
          const double phi = static_cast<double>(static_cast<T>(part));
          const auto P = bending(static_cast<T>(part));
          const auto far_off = [&](int k, T got) {
            const double w = static_cast<double>(bend.w[0]) * phi * phi;
            const double exact = power(phi, k) * psi_k(k, w, static_cast<double>(bend.q[0]) * phi);
            const double size = k == 0 ? 1.0 + std::abs(exact) : power(phi, k);
            worst = std::max(worst, std::abs(static_cast<double>(got) - exact) / (size * (1 + z)));
          };
          far_off(0, P.P0[1]);
          far_off(1, P.P1[1]);
          far_off(2, P.P2[1]);
          if (theta > 0) {
            far_off(3, P.P3[1]);
            far_off(4, P.P4[1]);
            far_off(5, P.P5[1]);
          }
        }
      }
    }
  }
  MESSAGE("error in eps " << worst / static_cast<double>(std::numeric_limits<T>::epsilon()));
  CHECK(worst <= 64 * static_cast<double>(std::numeric_limits<T>::epsilon()));
}

TEST_CASE("an elastic bounce under a spring and in air is the exact one") {
  for (const double part : {0.1, 0.4, 0.8}) {
    for (const double strength : {0.03, 0.1, 0.3, 1.0, 2.0}) {
      const double speed = 2;
      const double rest = (1 - part) * hz60;
      const double back = part * hz60;
      {  // y = speed/omega sin(omega t) about the floor's height
        const double omega = strength / hz60;
        Scene scene;
        scene.add(Spring{.stiffness = omega * omega});
        scene.add(Plane{.restitution = 1});
        const Fall end = after_step<double>(scene, {speed / omega * std::sin(omega * back), -speed * std::cos(omega * back)});
        CHECK(std::abs(end.y - speed / omega * std::sin(omega * rest)) <= 1e-12 * speed * hz60);
        CHECK(std::abs(end.v - speed * std::cos(omega * rest)) <= 1e-12 * speed);
      }
      {  // y = speed (1 - exp(-g t))/g
        const double g = strength / hz60;
        Scene scene;
        scene.add(Drag{.coefficient = g});
        scene.add(Plane{.restitution = 1});
        const Fall end = after_step<double>(scene, {speed * std::expm1(g * back) / g, -speed * std::exp(g * back)});
        CHECK(std::abs(end.y + speed * std::expm1(-g * rest) / g) <= 1e-12 * speed * hz60);
        CHECK(std::abs(end.v - speed * std::exp(-g * rest)) <= 1e-12 * speed);
      }
    }
  }
}

TEST_CASE("a thousand bounces under a spring keep their energy") {
  for (const double z : {0.03, 0.1, 0.3}) {
    const double W = (z / hz60) * (z / hz60);
    Scene scene;
    scene.add(Spring{.stiffness = W});
    scene.add(Constant{.acceleration = {0, -9.81, 0}});
    scene.add(Plane{.restitution = 1});
    Soa<double> memory(1);
    State<double> state = memory.view();
    state.x[1][0] = 0.5;
    const auto plan = compile<double>(scene, {.step = hz60});
    const auto energy = [&] {
      return state.v[1][0] * state.v[1][0] / 2 + 9.81 * state.x[1][0] + W * state.x[1][0] * state.x[1][0] / 2;
    };
    const double start = energy();
    double worst = 0;
    int bounces = 0;
    double before = 0;
    for (int n = 0; n < 100000 && bounces < 1000; ++n) {
      (void)plan->step(state);
      bounces += before < 0 && state.v[1][0] > 0 ? 1 : 0;
      before = state.v[1][0];
      worst = std::max(worst, std::abs(energy() / start - 1));
    }
    CHECK(bounces == 1000);
    CHECK(worst <= 1e-9);
  }
}

TEST_CASE("a path that dips into a plane or a sphere between two ends outside is found under a spring") {
  for (const double z : {0.3, 0.8, 1.5}) {
    for (const double depth : {1e-5, 1e-3}) {
      const double omega = z / hz60;
      const double reach = 0.01 + depth;  // about a point 0.01 m above the surface
      const Fall start{0.01 - reach * std::cos(z / 2), -reach * omega * std::sin(z / 2)};
      if (start.y <= 0) continue;
      const auto energy = [&](const Fall& at) { return at.v * at.v + omega * omega * (at.y - 0.01) * (at.y - 0.01); };
      const Contact surfaces[] = {Plane{.restitution = 1}, Sphere{.center = {0, -3, 0}, .radius = 3, .restitution = 1}};
      for (const Contact& surface : surfaces) {
        CAPTURE(z);
        CAPTURE(depth);
        Scene scene;
        scene.add(Spring{.stiffness = omega * omega, .anchor = Vec3{0, 0.01, 0}});
        scene.add(surface);
        const Fall end = after_step<double>(scene, start);
        CHECK(std::abs(energy(end) / energy(start) - 1) <= 1e-10);
        CHECK(std::abs(end.y - start.y) > 1e-9);  // the end of the path without the floor
        CHECK(end.y >= 0);
      }
    }
  }
}

// x = x0 + v t + the drive of 4 m/s^2 sin(Omega t), without spring and drag: the path is not a parabola.
TEST_CASE("a force of time bends the path on which an impact is looked for") {
  for (const double theta : {0.1, 0.5, 1.0}) {
    const double Omega = theta / hz60;
    const double speed = 1;
    const double part = 0.6;
    const double at = part * hz60;
    const auto way = [&](double t) { return 4 / Omega * (t - std::sin(Omega * t) / Omega); };
    const auto rate = [&](double t) { return 4 / Omega * (1 - std::cos(Omega * t)); };
    Scene scene;
    scene.add(Sinusoid{.acceleration = {0, 4, 0}, .angular_frequency = Omega});
    scene.add(Plane{.restitution = 1});
    const double v0 = -speed - rate(at);
    const Fall end = after_step<double>(scene, {-v0 * at - way(at), v0});
    CHECK(std::abs(end.v - (speed + rate(hz60) - rate(at))) <= 1e-5 * theta * theta * theta * theta);
  }
}

}  // namespace dvdx::test::bend_test
