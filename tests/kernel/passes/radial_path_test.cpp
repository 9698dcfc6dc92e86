// The path of radial springs in space, compared with fourth-order Runge-Kutta in long double at tiny steps, extrapolated; and
// the order at which each method approaches it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernel/passes/every_run.hpp"
#include "support/margin.hpp"

namespace dvdx::test::radial_path {

using Real = long double;
using Point = std::array<Real, 3>;

struct Body {
  Point x{}, v{};
};

// A radial spring and the other forces on a particle of 1 kg.
struct Orbit {
  std::string name;
  double stiffness = 0, damping = 0, rest_length = 0;
  Vec3 anchor{};
  Vec3 gravity{};
  double drag = 0;
  Vec3 x{}, v{};
  double time = 2;  // s

  [[nodiscard]] Scene scene(Method method) const {
    Scene scene;
    scene.add(RadialSpring{
        .stiffness = stiffness, .damping = damping, .anchor = anchor, .rest_length = rest_length, .method = method});
    if (gravity != Vec3{}) scene.add(Constant{.acceleration = gravity});
    if (drag > 0) scene.add(Drag{.coefficient = drag});
    return scene;
  }
};

Body rate(const Orbit& orbit, const Body& at) {
  Point n{};
  Real r = 0, along = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    n[k] = at.x[k] - static_cast<Real>(orbit.anchor[k]);
    r += n[k] * n[k];
    along += n[k] * at.v[k];
  }
  r = std::sqrt(r);
  const Real pull = (orbit.stiffness * (r - static_cast<Real>(orbit.rest_length)) + orbit.damping * along / r) / r;
  Body out{at.v, {}};
  for (std::size_t k = 0; k < 3; ++k) out.v[k] = static_cast<Real>(orbit.gravity[k]) - orbit.drag * at.v[k] - pull * n[k];
  return out;
}

Body moved(const Body& at, const Body& rate, Real h) {
  Body out = at;
  for (std::size_t k = 0; k < 3; ++k) {
    out.x[k] += h * rate.x[k];
    out.v[k] += h * rate.v[k];
  }
  return out;
}

Body run_plain(const Orbit& orbit, int steps) {
  const Real h = static_cast<Real>(orbit.time) / steps;
  Body at;
  for (std::size_t k = 0; k < 3; ++k) {
    at.x[k] = orbit.x[k];
    at.v[k] = orbit.v[k];
  }
  for (int n = 0; n < steps; ++n) {
    const Body k1 = rate(orbit, at);
    const Body k2 = rate(orbit, moved(at, k1, h / 2));
    const Body k3 = rate(orbit, moved(at, k2, h / 2));
    const Body k4 = rate(orbit, moved(at, k3, h));
    for (const auto& [k, part] : {std::pair{&k1, 6}, {&k2, 3}, {&k3, 3}, {&k4, 6}}) at = moved(at, *k, h / part);
  }
  return at;
}

struct Reference {
  Body end;
  double own_error = 0;  // m
};

double distance(const Point& a, const Point& b) {
  return static_cast<double>(
      std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2])));
}

// Richardson extrapolation: half the step reduces the leading error of fourth order to a sixteenth.
Reference reference_of(const Orbit& orbit) {
  const auto extrapolated = [&](int steps) {
    const Body coarse = run_plain(orbit, steps);
    Body fine = run_plain(orbit, 2 * steps);
    for (std::size_t k = 0; k < 3; ++k) {
      fine.x[k] += (fine.x[k] - coarse.x[k]) / 15;
      fine.v[k] += (fine.v[k] - coarse.v[k]) / 15;
    }
    return fine;
  };
  const Body end = extrapolated(20000);
  return {end, distance(end.x, extrapolated(10000).x)};
}

// Orbits in an oblique plane, about an anchor off the origin.
std::vector<Orbit> orbits() {
  const Vec3 anchor{0.2, -0.1, 0.3};
  const Vec3 x{1.4, -0.1, 0.3};
  const Vec3 v{0.3, 1.5, 1.1};
  return {{.name = "in a plane", .stiffness = 40, .rest_length = 1, .anchor = anchor, .x = x, .v = v},
          {.name = "damped", .stiffness = 40, .damping = 0.8, .rest_length = 1, .anchor = anchor, .x = x, .v = v},
          {.name = "under gravity and drag",
           .stiffness = 40,
           .rest_length = 0.7,
           .anchor = anchor,
           .gravity = {0, -9.81, 0},
           .drag = 0.3,
           .x = x,
           .v = v}};
}

template <class T>
double error_of(const Orbit& orbit, const Reference& reference, Method method, const Run& run, std::size_t steps) {
  Joined particle{
      .name = orbit.name, .scene = orbit.scene(method), .x = {}, .v = {}, .step = orbit.time / static_cast<double>(steps)};
  particle.x.assign(5, orbit.x);
  particle.v.assign(5, orbit.v);
  const auto got = test::stepped<T>(particle, run, steps);
  const Point end{got[24], got[25], got[26]};
  CHECK(got[0] == got[24]);
  return distance(end, reference.end.x);
}

struct Order {
  Method method;
  std::string name;
  double order;
  double at_60;  // m after 2 s at 60 Hz

  // With drag, separate contributions of any two forces approach the path at first order.
  [[nodiscard]] Order beside(const Orbit& orbit) const {
    return orbit.drag > 0 && method != Method::combined ? Order{method, name, 1, std::max(at_60, 1e-2)} : *this;
  }
};

const std::array orders{Order{Method::combined, "combined", 2, 3e-3}, Order{Method::exact, "exact", 2, 3e-3},
                        Order{Method::average_acceleration, "average_acceleration", 2, 3e-3},
                        Order{Method::pulse, "pulse", 1, 3e-1}, Order{Method::symplectic_euler, "symplectic_euler", 1, 3e-1}};

TEST_CASE("radial path: every method comes to the reference path at its order") {
  for (const Orbit& orbit : orbits()) {
    const Reference reference = reference_of(orbit);
    CHECK(reference.own_error < 1e-13);
    for_each_run([&](const Run& run, const std::string& words) {
      for (const Order& any : orders) {
        const Order at = any.beside(orbit);
        const double coarse = error_of<double>(orbit, reference, at.method, run, 120);
        const double middle = error_of<double>(orbit, reference, at.method, run, 3840);
        const double fine = error_of<double>(orbit, reference, at.method, run, 7680);
        const double order = std::log2(middle / fine);
        CHECK_MESSAGE(coarse <= at.at_60, orbit.name << ", " << at.name << ", " << words << ": " << coarse << " m at 60 Hz");
        CHECK_MESSAGE(std::abs(order - at.order) < 0.05,
                      orbit.name << ", " << at.name << ", " << words << ": order " << order << ", " << fine << " m");
      }
    });
  }
}

TEST_CASE("radial path: float32 comes as near as its rounding allows") {
  for (const Orbit& orbit : orbits()) {
    const Reference reference = reference_of(orbit);
    for_each_run([&](const Run& run, const std::string& words) {
      for (const Order& any : orders) {
        const Order at = any.beside(orbit);
        if (at.order < 2) continue;
        const double got = error_of<float>(orbit, reference, at.method, run, 120);
        const double fine = error_of<float>(orbit, reference, at.method, run, 1920);
        CHECK_MESSAGE(got <= at.at_60 + 1e-5, orbit.name << ", " << at.name << ", " << words << ": " << got << " m at 60 Hz");
        CHECK_MESSAGE(fine <= at.at_60 / 256 + 5e-5, orbit.name << ", " << at.name << ", " << words << ": " << fine << " m");
      }
    });
  }
}

}  // namespace dvdx::test::radial_path
