// Every separate method, compared with closed forms computed here in long double: polynomials of time, sinusoids, wind, damped
// springs to different anchors. Runs through scene, plan and step, on every instruction set, in both precisions.
//
// A force's contribution to a step of h, per unit mass, where the force acts alone:
//   exact                 dv = Int a dt   dx = Int Int a dt dt
//   average_acceleration  dv = Int a dt   dx = dv h/2
//   pulse                 dv = Int a dt   dx = dv h
//   symplectic_euler      dv = a(0) h     dx = dv h
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernel/passes/every_run.hpp"
#include "support/margin.hpp"

namespace dvdx::test::methods {

using Real = long double;

constexpr std::array separate_methods{Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler};
constexpr std::array method_names{"exact", "average_acceleration", "pulse", "symplectic_euler"};

struct Kick {
  Real v = 0, x = 0;  // the contribution of a force to a step
};

// The kick of a force with known start value and integrals over the step.
Kick kick_by(Method method, Real start, Real once, Real twice, Real h) {
  switch (method) {
    case Method::exact:
      return {once, twice};
    case Method::average_acceleration:
      return {once, once * h / 2};
    case Method::pulse:
      return {once, once * h};
    default:
      return {start * h, start * h * h};
  }
}

struct AxisState {
  Real x = 0, v = 0;
};

// a(t) = sum c_k t^k, integrated from t to t + h term by term.
Kick of_polynomial(Method method, const std::vector<Real>& c, Real t, Real h) {
  Real start = 0, once = 0, twice = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    const auto n = static_cast<Real>(k);
    start += c[k] * std::pow(t, n);
    once += c[k] * (std::pow(t + h, n + 1) - std::pow(t, n + 1)) / (n + 1);
    twice += c[k] * ((std::pow(t + h, n + 2) - std::pow(t, n + 2)) / ((n + 1) * (n + 2)) - std::pow(t, n + 1) * h / (n + 1));
  }
  return kick_by(method, start, once, twice, h);
}

// a(t) = A sin(w t + p)
Kick of_sinusoid(Method method, Real A, Real w, Real p, Real t, Real h) {
  const Real from = w * t + p, to = w * (t + h) + p;
  return kick_by(method, A * std::sin(from), A * (std::cos(from) - std::cos(to)) / w,
                 A * (h * std::cos(from) / w - (std::sin(to) - std::sin(from)) / (w * w)), h);
}

// v' = -g (v - u), which decays to the wind.
Kick of_drag(Method method, Real g, Real u, Expansion expansion, const AxisState& at, Real h) {
  const Real q = g * h;
  const Real apart = at.v - u;
  if (expansion == Expansion::first_order) return kick_by(method, -g * apart, -q * apart, -q * apart * h / 2, h);
  return kick_by(method, -g * apart, std::expm1(-q) * apart, (-std::expm1(-q) / g - h) * apart, h);
}

// x'' = -W (x - c) - d x', an oscillation that decays with d/2.
Kick of_spring(Method method, Real W, Real d, Real c, const AxisState& at, Real h) {
  const Real omega = std::sqrt(W - d * d / 4);
  const Real e = at.x - c;
  const Real fade = std::exp(-d * h / 2);
  const Real amplitude = (at.v + d / 2 * e) / omega;
  const Real end = fade * (e * std::cos(omega * h) + amplitude * std::sin(omega * h));
  const Real speed = -d / 2 * end + fade * omega * (amplitude * std::cos(omega * h) - e * std::sin(omega * h));
  return kick_by(method, -W * e - d * at.v, speed - at.v, end - e - at.v * h, h);
}

// One particle of 0.5 kg with every kind of force.
constexpr Real mass = 0.5L;
const std::vector<Vec3> ramp{{0.2, -9.81, 1}, {-0.3, 0.7, 0}, {0.05, 0, 0.4}, {0, -0.02, 0.01}};
const Sinusoid gust{.acceleration = {2, 0.3, -0.6}, .angular_frequency = 4.3, .phase = 0.4};
const Sinusoid hum{.acceleration = {-0.5, 1.1, 0.7}, .angular_frequency = 61, .phase = -1.9};
const Drag breeze{.coefficient = {0.1, 0.2, 0.3}, .wind = {1, -0.5, -2}};
const Drag storm{.coefficient = 0.7, .wind = {-3, 4, 0.5}};
const Drag taylor{.coefficient = 0.4, .wind = {0.5, 0, -1}, .expansion = Expansion::first_order};
const Spring soft{.stiffness = {6, 9, 12}, .damping = 0.2, .anchor = Vec3{0.1, 0, -0.3}};
const Spring stiff{.stiffness = 150.0, .anchor = Vec3{-0.4, 0.1, 0.2}};

enum class Kind { of_time, wind, springs, all };
constexpr std::array kinds{Kind::of_time, Kind::wind, Kind::springs, Kind::all};
constexpr std::array kind_names{"forces of time", "drags in wind", "springs to two anchors", "all of them"};

bool has(Kind kind, Kind part) { return kind == part || kind == Kind::all; }

Scene scene_of(Kind kind, Method method) {
  Scene scene;
  scene.mass = static_cast<double>(mass);
  scene.method = method;
  if (has(kind, Kind::of_time)) scene.add(Polynomial{.acceleration = ramp}).add(gust).add(hum);
  if (has(kind, Kind::wind)) scene.add(breeze).add(storm).add(taylor);
  if (has(kind, Kind::springs)) scene.add(soft).add(stiff);
  return scene;
}

AxisState stepped(Kind kind, Method method, std::size_t axis, const AxisState& at, Real t, Real h) {
  Kick sum;
  const auto add = [&](const Kick& kick) { sum = {sum.v + kick.v, sum.x + kick.x}; };
  if (has(kind, Kind::of_time)) {
    std::vector<Real> c;
    for (const Vec3& term : ramp) c.push_back(term[axis]);
    add(of_polynomial(method, c, t, h));
    for (const Sinusoid* force : {&gust, &hum}) {
      add(of_sinusoid(method, force->acceleration[axis], force->angular_frequency, force->phase, t, h));
    }
  }
  if (has(kind, Kind::wind)) {
    constexpr std::array<Real, 3> gentle{0.1L, 0.2L, 0.3L};
    add(of_drag(method, gentle[axis] / mass, breeze.wind[axis], Expansion::exact, at, h));
    add(of_drag(method, 0.7L / mass, storm.wind[axis], Expansion::exact, at, h));
    add(of_drag(method, 0.4L / mass, taylor.wind[axis], Expansion::first_order, at, h));
  }
  if (has(kind, Kind::springs)) {
    constexpr std::array<Real, 3> stiffness{6, 9, 12};
    const auto anchor = [&](const Spring& spring) { return std::get<Vec3>(spring.anchor)[axis]; };
    add(of_spring(method, stiffness[axis] / mass, 0.2L / mass, anchor(soft), at, h));
    add(of_spring(method, 150 / mass, 0, anchor(stiff), at, h));
  }
  return {at.x + at.v * h + sum.x, at.v + sum.v};
}

constexpr Vec3 start_x{0.7, -0.25, 1.3};
constexpr Vec3 start_v{-1.1, 2.0, 0.4};

TEST_CASE_TEMPLATE("methods: each method's contributions of every kind of force follow their closed forms, step after step", T,
                   float, double) {
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    for (std::size_t m = 0; m < separate_methods.size(); ++m) {
      for (const double h : {1.0 / 240, 1.0 / 60, 0.05}) {
        constexpr std::size_t steps = 40;
        std::array<AxisState, 3> exact;
        std::array<Real, 3> farthest{}, fastest{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          exact[axis] = {static_cast<T>(start_x[axis]), static_cast<T>(start_v[axis])};
          for (std::size_t n = 0; n < steps; ++n) {
            farthest[axis] = std::max(farthest[axis], std::abs(exact[axis].x) + 1);
            fastest[axis] = std::max(fastest[axis], std::abs(exact[axis].v) + 1);
            exact[axis] = stepped(kinds[k], separate_methods[m], axis, exact[axis], static_cast<Real>(n) * h, h);
          }
        }
        Joined particle{.name = method_names[m], .scene = scene_of(kinds[k], separate_methods[m]), .x = {}, .v = {}, .step = h};
        particle.x.assign(5, start_x);
        particle.v.assign(5, start_v);
        for_each_run([&](const Run& run, const std::string& words) {
          const auto got = test::stepped<T>(particle, run, steps);
          Margin margin;
          const double part = sizeof(T) == 8 ? 1e-13 : 2e-5;
          for (std::size_t i = 0; i < 5; i += 4) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
              const auto where = [&] { return std::string("axis ") + "xyz"[axis]; };
              margin.see(static_cast<double>(std::abs(static_cast<Real>(got[6 * i + axis]) - exact[axis].x)),
                         part * static_cast<double>(farthest[axis]), where);
              margin.see(static_cast<double>(std::abs(static_cast<Real>(got[6 * i + 3 + axis]) - exact[axis].v)),
                         part * static_cast<double>(std::max(fastest[axis], 20 * farthest[axis])), where);
            }
          }
          CHECK_MESSAGE(margin.is_kept(), kind_names[k] << " by " << method_names[m] << ", h = " << h << ", " << words << ", "
                                                        << 8 * sizeof(T) << " bits: " << margin.words());
        });
      }
    }
  }
}

// Forces that depend on time alone are integrated completely, for any number of them and any step.
TEST_CASE_TEMPLATE("methods: forces of time alone reach their integrals by the exact method, in one step as in many", T, float,
                   double) {
  const Real t = 2;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<Real> c;
    for (const Vec3& term : ramp) c.push_back(term[axis]);
    Kick sum = of_polynomial(Method::exact, c, 0, t);
    for (const Sinusoid* force : {&gust, &hum}) {
      const Kick kick = of_sinusoid(Method::exact, force->acceleration[axis], force->angular_frequency, force->phase, 0, t);
      sum = {sum.v + kick.v, sum.x + kick.x};
    }
    const Real v0 = static_cast<T>(start_v[axis]);
    const Real x = static_cast<T>(start_x[axis]) + v0 * t + sum.x;
    for (const std::size_t steps : {1U, 7U, 120U}) {
      Joined particle{
          .name = "forces of time", .scene = scene_of(Kind::of_time, Method::exact), .x = {start_x}, .v = {start_v}};
      particle.step = static_cast<double>(t) / static_cast<double>(steps);
      for_each_run([&](const Run& run, const std::string& words) {
        const auto got = test::stepped<T>(particle, run, steps);
        CAPTURE(words);
        CAPTURE(steps);
        CHECK(std::abs(static_cast<double>(static_cast<Real>(got[axis]) - x)) <= (sizeof(T) == 8 ? 2e-14 : 2e-5) * 20);
        CHECK(std::abs(static_cast<double>(static_cast<Real>(got[3 + axis]) - v0 - sum.v)) <=
              (sizeof(T) == 8 ? 2e-14 : 1e-5) * 20);
      });
    }
  }
}

// Particles with individual anchors and one spring by each method: the forces of a particle may have different methods.
TEST_CASE_TEMPLATE("methods: each force may name its own method, and each particle has its own anchor", T, float, double) {
  const double h = 1.0 / 60;
  const std::vector<Vec3> anchors{{0.5, -1, 2}, {-0.25, 0.75, 0}, {3, 0.1, -0.6}, {0, 0, 0}, {1, 1, 1}};
  Scene scene;
  for (const Method method : separate_methods) scene.add(Spring{.stiffness = 20.0, .anchor = anchors, .method = method});
  Joined particles{.name = "an anchor each", .scene = scene, .x = {}, .v = {}, .step = h};
  particles.x.assign(anchors.size(), start_x);
  particles.v.assign(anchors.size(), start_v);
  for_each_run([&](const Run& run, const std::string& words) {
    CAPTURE(words);
    const auto got = test::stepped<T>(particles, run, 30);
    for (std::size_t i = 0; i < anchors.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        AxisState at{static_cast<T>(start_x[axis]), static_cast<T>(start_v[axis])};
        for (int n = 0; n < 30; ++n) {
          Kick sum;
          for (const Method method : separate_methods) {
            const Kick kick = of_spring(method, 20, 0, anchors[i][axis], at, h);
            sum = {sum.v + kick.v, sum.x + kick.x};
          }
          at = {at.x + at.v * h + sum.x, at.v + sum.v};
        }
        CHECK(std::abs(static_cast<double>(static_cast<Real>(got[6 * i + axis]) - at.x)) <=
              (sizeof(T) == 8 ? 1e-13 : 1e-5) * 5);
        CHECK(std::abs(static_cast<double>(static_cast<Real>(got[6 * i + 3 + axis]) - at.v)) <=
              (sizeof(T) == 8 ? 1e-13 : 1e-5) * 50);
      }
    }
  });
}

}  // namespace dvdx::test::methods
