// The rate pass: the scalar twin's bits on every ISA, and errors within the stated bound.
#include "flow/rate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "forces/combined.hpp"
#include "isa/passes.hpp"
#include "math/elementary.hpp"
#include "math/psi.hpp"
#include "support/close.hpp"

using namespace dvdx;
using dvdx::test::is_close;

namespace rate_test {

constexpr double h = 1.0 / 60;

// Every regime: free, tiny, oscillating up to the lanes' limit, critical and nearly critical, overdamped, drag only.
struct Regimes {
  std::vector<double> W, g;
  Regimes() {
    for (double w = 1e-20; w < 2e12; w *= 6.3) {
      for (double q = 1e-14; q < 1e9; q *= 17) add(w / h / h, q / h);
      add(w / h / h, 0);
      for (const double off : {0.0, 1e-13, -1e-13, 1e-6, -1e-6}) add(w / h / h, 2 * std::sqrt(w) * (1 + off) / h);
    }
    for (double q = 1e-16; q < 1e9; q *= 3.7) add(0, q / h);
    add(0, 0);
    add(1, 1e300);
    while (W.size() % 16 != 0) add(1, 1);
  }
  void add(double stiffness, double damping) {
    W.push_back(stiffness);
    g.push_back(damping);
  }
};

struct Made {
  std::vector<double> A, B, C, S, X;
  explicit Made(std::size_t n) : A(n), B(n), C(n), S(n), X(n) {}
  bool operator==(const Made& o) const {
    const auto same = [](const std::vector<double>& a, const std::vector<double>& b) {
      return std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
    };
    return same(A, o.A) && same(B, o.B) && same(C, o.C) && same(S, o.S) && same(X, o.X);
  }
};

Made make(const Regimes& grid, Isa isa, Arithmetic arithmetic, double step) {
  const std::size_t n = grid.W.size();
  Made made(n);
  find_passes(isa, arithmetic)
      ->f64.free.rate({.count = n,
                       .h = step,
                       .W = grid.W.data(),
                       .g = grid.g.data(),
                       .A = made.A.data(),
                       .B = made.B.data(),
                       .C = made.C.data(),
                       .S = made.S.data(),
                       .X = made.X.data()});
  return made;
}

struct Driven {
  std::vector<double> in_v, in_x, quad_v, quad_x;
  explicit Driven(std::size_t n) : in_v(n), in_x(n), quad_v(n), quad_x(n) {}
  bool operator==(const Driven&) const = default;
};

Driven drive(const Regimes& grid, Isa isa, double theta) {
  const std::size_t n = grid.W.size();
  Driven made(n);
  find_passes(isa)->f64.free.rate_sinusoid({.count = n,
                                            .h = h,
                                            .theta = theta,
                                            .W = grid.W.data(),
                                            .g = grid.g.data(),
                                            .in_v = made.in_v.data(),
                                            .in_x = made.in_x.data(),
                                            .quad_v = made.quad_v.data(),
                                            .quad_x = made.quad_x.data()});
  return made;
}

TEST_CASE("rate: every instruction set and either arithmetic make the bits of the scalar twin") {
  const Regimes grid;
  for (const double step : {h, -h / 64}) {
    Regimes here = grid;
    // Backwards, damping beyond exp(600) overflows, and a plan refuses it.
    if (step < 0) std::transform(here.g.begin(), here.g.end(), here.g.begin(), [](double g) { return std::min(g, 1e4); });
    const Made wanted = make(here, Isa::reference, Arithmetic::separate, step);
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(std::string(name(isa)));
        CHECK(make(here, isa, arithmetic, step) == wanted);
      }
    }
  }
}

TEST_CASE("rate: coefficients within 6 eps of their exact value, or 2 z eps of their amplitude") {
  const Regimes grid;
  const Made made = make(grid, Isa::reference, Arithmetic::separate, h);
  constexpr double eps = 2.3e-16;
  double worst = 0;
  for (std::size_t i = 0; i < grid.W.size(); ++i) {
    const double z = std::sqrt(grid.W[i]) * h;
    if (z > sincos_fast || grid.g[i] > 1e100) continue;
    const Combined exact = combined(grid.W[i], grid.g[i], h);
    const double bound = std::max(6.0, 2 * z) * eps;
    const auto see = [&](double got, double want) {
      REQUIRE(std::isfinite(got));
      if (want != 0) worst = std::max(worst, std::abs(got - want) / (bound * std::abs(want)));
    };
    if (z > 1) {
      // The coefficients of an oscillation pass through zero, so their errors are relative to its amplitude.
      const double omega = std::sqrt(grid.W[i]);
      CHECK(std::abs(made.A[i] - exact.A) <= bound * omega);
      CHECK(std::abs(made.B[i] - exact.B) <= bound * 2);
      CHECK(std::abs(made.C[i] - exact.C) <= bound * 2);
      CHECK(std::abs(made.S[i] - exact.S) <= bound * std::max(exact.S, 1 / omega));
      CHECK(std::abs(made.X[i] - exact.constant.x) <= bound * std::max(exact.constant.x, 1 / grid.W[i]));
    } else {
      see(made.A[i], exact.A);
      see(made.B[i], exact.B);
      see(made.C[i], exact.C);
      see(made.S[i], exact.S);
      see(made.X[i], exact.constant.x);
    }
  }
  CHECK(worst <= 1);
}

TEST_CASE("rate: sinusoid gains, the same bits everywhere and right to 1e-14 within the series' range") {
  Regimes grid;
  for (std::size_t i = 0; i < grid.W.size(); ++i) {
    if (grid.W[i] * h * h > psi_taylor_limit) grid.W[i] = 2 / h / h;
    if (grid.g[i] * h > psi_taylor_limit) grid.g[i] = 2 / h;
  }
  for (const double theta : {0.0, 1e-9, 0.05, 1.0, 1.99, -1.3}) {
    const Driven wanted = drive(grid, Isa::reference, theta);
    for (const Isa isa : available_isas()) {
      CAPTURE(std::string(name(isa)));
      CHECK(drive(grid, isa, theta) == wanted);
    }
    for (std::size_t i = 0; i < grid.W.size(); ++i) {
      const SinusoidGains exact = combined_sinusoid(grid.W[i], grid.g[i], theta / h, h);
      CHECK(std::abs(wanted.in_v[i] - exact.in_phase.v) <= 1e-14 * h);
      CHECK(std::abs(wanted.quad_v[i] - exact.quadrature.v) <= 1e-14 * h);
      CHECK(std::abs(wanted.in_x[i] - exact.in_phase.x) <= 1e-14 * h * h);
      CHECK(std::abs(wanted.quad_x[i] - exact.quadrature.x) <= 1e-14 * h * h);
    }
  }
}

TEST_CASE("rate: particles that turn farther in a step than lanes take angles stay where they are in equilibrium") {
  const std::vector<double> stiffness = {1e14, 2e14, 4e14};  // 1e7 rad and more in a step of 1 s
  Scene scene;
  scene.add(Spring{.stiffness = stiffness});
  scene.add(Constant{.acceleration = {1e14, 0, 0}});
  Soa<double> memory(3);
  auto state = memory.view();
  for (std::size_t i = 0; i < 3; ++i) state.x[0][i] = 1e14 / stiffness[i];
  const auto plan = compile(scene, {.step = 1}, state);
  REQUIRE(plan);
  (void)plan->step(state, 10);
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(state.x[0][i] * stiffness[i] / 1e14 - 1) <= 1e-6);
}

TEST_CASE("rate: particles that differ move as plans of their own would move them, whatever the method") {
  constexpr std::size_t n = 37;
  std::vector<double> mass(n), stiffness(n), drag(n);
  for (std::size_t i = 0; i < n; ++i) {
    mass[i] = 0.3 + 0.1 * static_cast<double>(i);
    stiffness[i] = std::pow(10.0, -2 + 0.2 * static_cast<double>(i));  // up to an angle of 40 rad a step
    drag[i] = i % 5 == 0 ? 0 : 0.02 * static_cast<double>(i * i);
  }
  const auto scene_of = [&](Method method, Scalars m, PerAxis k, PerAxis c) {
    Scene scene;
    scene.method = method;
    scene.mass = std::move(m);
    scene.add(Constant{.acceleration = {0, -9.81, 1}});
    scene.add(Spring{.stiffness = std::move(k), .damping = 0.1, .anchor = Vec3{1, 2, 3}});
    scene.add(Spring{.stiffness = 3.0, .anchor = Vec3{-1, 0, 1}});
    scene.add(Drag{.coefficient = std::move(c), .wind = {2, 0, -1}});
    scene.add(Sinusoid{.acceleration = {1, 2, 3}, .angular_frequency = 5, .phase = 0.3});
    scene.add(Polynomial{.acceleration = {{1, 0, 0}, {0, 0.5, 0.1}}});
    return scene;
  };
  for (const Method method : {Method::combined, Method::exact, Method::average_acceleration, Method::pulse}) {
    Soa<double> buffer(n);
    auto state = buffer.view();
    for (std::size_t i = 0; i < n; ++i) state.v[0][i] = 0.1 * static_cast<double>(i);
    const auto together = compile(scene_of(method, mass, stiffness, drag), {.step = h}, state);
    REQUIRE(together);
    (void)together->step(state, 3);
    for (std::size_t i = 0; i < n; ++i) {
      Soa<double> one(1);
      auto alone = one.view();
      alone.v[0][0] = 0.1 * static_cast<double>(i);
      const auto plan = compile<double>(scene_of(method, mass[i], stiffness[i], drag[i]), {.step = h});
      REQUIRE(plan);
      (void)plan->step(alone, 3);
      CAPTURE(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(is_close(state.x[axis][i], alone.x[axis][0], 1e-11));
        CHECK(is_close(state.v[axis][i], alone.v[axis][0], 1e-11));
      }
    }
  }
}

}  // namespace rate_test
