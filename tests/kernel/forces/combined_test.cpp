#include "forces/combined.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "forces/drag.hpp"
#include "forces/polynomial.hpp"
#include "forces/sinusoid.hpp"
#include "kernel/forces/scalar_step.hpp"
#include "support/close.hpp"
#include "support/oracle.hpp"
#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

namespace combined_test {

struct Errors {
  Worst x, v;
  void see(AxisState at, AxisState exact, double length, double speed) {
    x.see(std::abs(at.x - exact.x) / length);
    v.see(std::abs(at.v - exact.v) / speed);
  }
  [[nodiscard]] double worst() const { return std::max(x.worst(), v.worst()); }
};

// x'' = a - W (x-c) - g (v-u) over t in n steps.
AxisState run(const Oracle::Row& row, const Combined& step, int n) {
  const double f = row["a_"] + row["g_"] * row["u_"];
  AxisState at{row["x0"], row["v0"]};
  for (int i = 0; i < n; ++i) at = stepped(at, step, row["c_"], step.constant.v * f, step.constant.x * f);
  return at;
}

struct Scale {
  double length, speed;
};

// The scale of the motion: the largest length and speed in it.
Scale scale(const Oracle::Row& row) {
  const double reach = std::max({std::abs(row["x0"]), std::abs(row["c_"]), std::abs(row["x_m"]), 1e-3});
  return {reach, std::max({std::abs(row["v0"]), std::abs(row["u_"]), std::abs(row["v_m"]), std::sqrt(row["W_"]) * reach})};
}

TEST_CASE("combined: one step of any length, and 1000 steps, are the closed form") {
  const Oracle oracle("linear1d.csv");
  Errors one, lanes, thousand;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double W = row["W_"], g = row["g_"], t = row["t_"];
    const AxisState exact{row["x_m"], row["v_m"]};
    const Scale s = scale(row);
    CAPTURE(row.text("case"));
    CAPTURE(row.text("kind"));
    CAPTURE(t);
    const auto check = [&](Errors& errors, AxisState at, double bar) {
      errors.see(at, exact, s.length, s.speed);
      CHECK(std::abs(at.x - exact.x) <= bar * s.length);
      CHECK(std::abs(at.v - exact.v) <= bar * s.speed);
    };
    check(one, run(row, combined(W, g, t), 1), 4e-15);
    // Coefficients from lanes have a phase accurate to z eps.
    check(lanes, run(row, combined_in_lanes(W, g, t), 1), 1e-14 + 4e-16 * std::sqrt(W) * t);
    if (i % 4 == 0) {
      // t/1000 is rounded by up to half an ulp. That phase error, 1000 times, belongs to the input.
      const double rounding = std::abs(std::fma(1000.0, t / 1000, -t)) * std::max(std::sqrt(W), 1.0);
      check(thousand, run(row, combined(W, g, t / 1000), 1000), 1e-12 + 2 * rounding);
    }
  }
  MESSAGE("one step " << one.worst() << ", in lanes " << lanes.worst() << ", 1000 steps " << thousand.worst());
}

TEST_CASE("sinusoid: free, forced, resonant and nearly so") {
  const Oracle oracle("sinusoid1d.csv");
  Errors one, many;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double W = row["W_"], g = row["g_"], t = row["t_"], Omega = row["Omega_"], amplitude = row["A_"];
    const AxisState exact{row["x_m"], row["v_m"]};
    const double length = std::max({std::abs(row["x0"]), std::abs(row["x_m"]), 1e-3});
    const double speed = std::max({std::abs(row["v0"]), std::abs(row["v_m"]), std::sqrt(W) * length});
    CAPTURE(row.text("case"));
    CAPTURE(row.text("kind"));
    CAPTURE(t);
    for (const int n : {1, 50}) {
      const double h = t / n;
      const Combined step = combined(W, g, h);
      const SinusoidGains gains = combined_sinusoid(W, g, Omega, h);
      AxisState at{row["x0"], row["v0"]};
      Clock clock;
      for (int k = 0; k < n; ++k) {
        const Phase start = phase_at(Omega, row["phase"], clock);
        const double P = amplitude * (gains.in_phase.v * start.sin + gains.quadrature.v * start.cos);
        const double Q = amplitude * (gains.in_phase.x * start.sin + gains.quadrature.x * start.cos);
        at = stepped(at, step, 0, P, Q);
        clock.advance(h, 1);
      }
      const double rounding = std::abs(std::fma(static_cast<double>(n), h, -t)) * std::max({std::sqrt(W), Omega, 1.0});
      (n == 1 ? one : many).see(at, exact, length, speed);
      const double bar = (n == 1 ? 1e-14 : 1e-13) + 2 * rounding;
      CHECK(std::abs(at.x - exact.x) <= bar * length);
      CHECK(std::abs(at.v - exact.v) <= bar * speed);
    }
  }
  MESSAGE("one step " << one.worst() << ", 50 steps " << many.worst());
}

TEST_CASE("polynomial: the power of tau that stands last is expanded about a later time by its binomial coefficients") {
  Polynomial8 last{};
  last.back() = 1;  // (2 + tau)^7
  CHECK(shift(last, Clock{2, 0}) == Polynomial8{128, 448, 672, 560, 280, 84, 14, 1});
}

TEST_CASE("polynomial: in one step, and expanded anew at every step") {
  const Oracle oracle("poly1d.csv");
  Errors one, many;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double W = row["W_"], g = row["g_"], t = row["t_"];
    const AxisState exact{row["x_m"], row["v_m"]};
    const double length = std::max({std::abs(row["x0"]), std::abs(row["x_m"]), 1e-3});
    const double speed = std::max({std::abs(row["v0"]), std::abs(row["v_m"]), std::sqrt(W) * length});
    const Polynomial8 polynomial{row["a0"], row["a1"], row["a2"] / 2, row["a3"] / 6};
    CAPTURE(row.text("case"));
    CAPTURE(t);
    for (const int n : {1, 20}) {
      const double h = t / n;
      const Combined step = combined(W, g, h);
      AxisState at{row["x0"], row["v0"]};
      Clock clock;
      for (int k = 0; k < n; ++k) {
        const Polynomial8 local = shift(polynomial, clock);
        double P = 0, Q = 0;
        for (int power = 0; power < 4; ++power) {
          const Gain gain = combined_monomial(power, W, g, h);
          P += local[static_cast<std::size_t>(power)] * gain.v;
          Q += local[static_cast<std::size_t>(power)] * gain.x;
        }
        at = stepped(at, step, 0, P, Q);
        clock.advance(h, 1);
      }
      const double rounding = std::abs(std::fma(static_cast<double>(n), h, -t)) * std::max(std::sqrt(W), 1.0);
      (n == 1 ? one : many).see(at, exact, length, speed);
      const double bar = (n == 1 ? 1e-14 : 1e-13) + 2 * rounding;
      CHECK(std::abs(at.x - exact.x) <= bar * length);
      CHECK(std::abs(at.v - exact.v) <= bar * speed);
    }
  }
  MESSAGE("one step " << one.worst() << ", 20 steps " << many.worst());
}

TEST_CASE("a particle in space on several springs, in drag, wind, gravity and a shaking") {
  const Oracle oracle("multiforce3d.csv");
  Worst one, many;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double m = row["m_kg"], t = row["t_s"];
    const auto k = row.list("k_list"), anchors = row.list("anchors"), wind = row.list("wind"), gravity = row.list("gravity");
    const auto amplitude = row.list("A_m_s2"), x0 = row.list("x0"), v0 = row.list("v0");
    double stiffness = 0;
    for (const double each : k) stiffness += each;
    const double W = stiffness / m, g = row["drag_"] / m, Omega = row["Omega"];
    for (const int n : {1, 100}) {
      const double h = t / n;
      const Combined step = combined(W, g, h);
      const SinusoidGains gains = combined_sinusoid(W, g, Omega, h);
      double length = 1e-3, speed = 1e-3, error_x = 0, error_v = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double anchor = 0;
        for (std::size_t j = 0; j < k.size(); ++j) anchor += k[j] / stiffness * anchors[3 * j + axis];
        AxisState at{x0[axis], v0[axis]};
        Clock clock;
        const double f = gravity[axis] + g * wind[axis];
        for (int s = 0; s < n; ++s) {
          const Phase p = phase_at(Omega, row["phase"], clock);
          const double P = f * step.constant.v + amplitude[axis] * (gains.in_phase.v * p.sin + gains.quadrature.v * p.cos);
          const double Q = f * step.constant.x + amplitude[axis] * (gains.in_phase.x * p.sin + gains.quadrature.x * p.cos);
          at = stepped(at, step, anchor, P, Q);
          clock.advance(h, 1);
        }
        const std::string name(1, "xyz"[axis]);
        const double x = row[name], v = row["v" + name];
        length = std::max({length, std::abs(x0[axis]), std::abs(x), std::abs(anchor)});
        speed = std::max({speed, std::abs(v0[axis]), std::abs(v)});
        error_x = std::max(error_x, std::abs(at.x - x));
        error_v = std::max(error_v, std::abs(at.v - v));
      }
      // W and t/n are rounded: half an ulp is a phase of z/2.
      const double z = std::max(std::sqrt(W), Omega) * t;
      speed = std::max(speed, std::sqrt(W) * length);
      (n == 1 ? one : many).see(std::max(error_x / length, error_v / speed));
      CAPTURE(row.text("case"));
      CAPTURE(t);
      CAPTURE(n);
      CHECK(error_x <= ((n == 1 ? 1e-14 : 1e-13) + 4e-16 * z) * length);
      CHECK(error_v <= ((n == 1 ? 1e-14 : 1e-13) + 4e-16 * z) * speed);
    }
  }
  MESSAGE("one step " << one.worst() << ", 100 steps " << many.worst());
}

TEST_CASE("n steps of h are one step of n h") {
  const double h = 0x1p-6;  // n h is exact
  Worst error;
  for (double W = 1e-6; W < 1e8; W *= 17) {
    for (double g = 1e-6; g < 1e8; g *= 17) {
      const Combined small = combined(W, g, h), large = combined(W, g, 64 * h);
      AxisState at{1, -2};
      for (int n = 0; n < 64; ++n) at = stepped(at, small, 0.25, 3 * small.constant.v, 3 * small.constant.x);
      const AxisState exact = stepped({1, -2}, large, 0.25, 3 * large.constant.v, 3 * large.constant.x);
      error.see(std::abs(at.x - exact.x));
      error.see(std::abs(at.v - exact.v) / std::max(1.0, std::sqrt(W)));
    }
  }
  MESSAGE("worst " << error.worst());
  CHECK(error.worst() < 1e-13);
}

TEST_CASE("time runs backwards") {
  for (const double g : {0.0, 0.01, 1.0, 5.0}) {
    for (const double W : {0.0, 1e-4, 40.0, 400.0, 1e5}) {
      const double h = 1.0 / 60;
      const Combined forth = combined(W, g, h), back = combined(W, g, -h);
      AxisState at{1, -2};
      for (int n = 0; n < 100; ++n) at = stepped(at, forth, 0.25, -9.81 * forth.constant.v, -9.81 * forth.constant.x);
      for (int n = 0; n < 100; ++n) at = stepped(at, back, 0.25, -9.81 * back.constant.v, -9.81 * back.constant.x);
      CAPTURE(W);
      CAPTURE(g);
      // The loss on the way forth grows by at most exp(g t), or by exp(g t/2) if the motion oscillates.
      const double growth = std::exp(g * 100 * h * (4 * W > g * g ? 0.5 : 1.0));
      CHECK(std::abs(at.x - 1) < 1e-11 * growth);
      CHECK(std::abs(at.v + 2) < 1e-11 * growth * std::max(1.0, std::sqrt(W)));
    }
  }
  // One strongly damped step forth and back.
  for (const double q : {1.0, 10.0, 50.0}) {
    const Combined forth = combined(7, q, 1), back = combined(7, q, -1);
    const Matrix a = matrix(forth), b = matrix(back);
    if (q <= 10) CHECK(is_close(b.det(), std::exp(q), 1e-10));
    CHECK(std::abs(a.a * b.a + a.b * b.c - 1) < 4e-16 * std::exp(q));
  }
}

TEST_CASE("gravity and drag together keep the terminal velocity") {
  for (double q = 1e-12; q < 2e6; q *= 10) {
    const double h = 1.0 / 60, g = q / h;
    const Combined step = combined(0, g, h);
    const double terminal = 9.81 / g;
    AxisState at{0, terminal};
    for (int n = 0; n < 1000; ++n) at = stepped(at, step, 0, 9.81 * step.constant.v, 9.81 * step.constant.x);
    CAPTURE(q);
    CHECK(is_close(at.v, terminal, 1e-13));
    CHECK(is_close(at.x, terminal * 1000 * h, 1e-12));
  }
}

TEST_CASE("gravity and drag together reach the terminal velocity, and separate ones exceed it by at least q/2") {
  const double h = 1.0 / 60;
  for (const double q : {1e-3, 0.1, 1.0, 10.0, 1e4}) {
    const double g = q / h;
    const double terminal = 9.81 / g;
    const Combined together = combined(0, g, h);
    const Contribution braking = drag(g, h, Method::exact, Expansion::exact);
    const Gain falling = monomial(0, h, Method::exact);
    AxisState at{0, 0}, apart{0, 0};
    for (int n = 0; n < 50 / std::min(q, 1.0); ++n) {
      at = stepped(at, together, 0, 9.81 * together.constant.v, 9.81 * together.constant.x);
      apart = stepped(apart, braking, h, 0, 9.81 * falling.v, 9.81 * falling.x);
    }
    CAPTURE(q);
    CHECK(is_close(at.v, terminal, 1e-12));
    CHECK(is_close(apart.v, terminal * q / -std::expm1(-q), 1e-12));
    CHECK(apart.v / terminal - 1 >= q / 2);
  }
}

TEST_CASE("the phase of a forcing is right after a million seconds of small steps") {
  const double Omega = 7, h = 1.0 / 60;
  Clock clock;
  for (int n = 0; n < 60000; ++n) clock.advance(h, 1000);
  const long double time = static_cast<long double>(h) * 60e6L;
  const Phase at = phase_at(Omega, 0.3, clock);
  CHECK(std::abs(at.sin - static_cast<double>(std::sin(Omega * time + static_cast<long double>(0.3)))) < 1e-11);
}

TEST_CASE("free sinusoid and polynomial by every method") {
  const double h = 0.5, Omega = 3;
  const SinusoidGains exact = sinusoid(Omega, h, Method::exact);
  CHECK(is_close(exact.in_phase.v, std::sin(1.5) / 3, 1e-12));
  CHECK(is_close(exact.quadrature.v, (1 - std::cos(1.5)) / 3, 1e-12));
  CHECK(is_close(exact.in_phase.x, (1 - std::cos(1.5)) / 9, 1e-12));
  CHECK(is_close(exact.quadrature.x, (1.5 - std::sin(1.5)) / 9, 1e-12));
  CHECK(sinusoid(Omega, h, Method::average_acceleration).quadrature.x == exact.quadrature.v * h / 2);
  CHECK(sinusoid(Omega, h, Method::pulse).in_phase.x == exact.in_phase.v * h);
  CHECK(sinusoid(Omega, h, Method::symplectic_euler).in_phase.v == h);
  CHECK(sinusoid(Omega, h, Method::symplectic_euler).quadrature.x == 0);
  const SinusoidGains slow = sinusoid(1e-9, 1, Method::exact);
  CHECK(is_close(slow.quadrature.v, 0.5e-9, 1e-15));
  CHECK(is_close(slow.quadrature.x, 1e-9 / 6, 1e-15));
  for (int k = 0; k < polynomial_terms; ++k) {
    const Gain gain = monomial(k, h, Method::exact);
    const Gain flown = combined_monomial(k, 0, 0, h);
    CHECK(is_close(gain.v, flown.v, 1e-15));
    CHECK(is_close(gain.x, flown.x, 1e-15));
  }
  CHECK(monomial(2, h, Method::symplectic_euler).v == 0);
  const Polynomial8 local = shift({1, 2, 3, 0, 0, 0, 0, 4}, Clock{2, 0});
  CHECK(local[0] == 1 + 4 + 12 + 4 * 128);
  CHECK(local[1] == 2 + 12 + 4 * 7 * 64);
  CHECK(local[7] == 4);
}

TEST_CASE("forcing stays finite at every frequency") {
  for (const double Omega : {1e-300, 1e-8, 1.0, 1e8, 1e16, 1e30, 1e100}) {
    for (const double W : {0.0, 1e-30, 1.0, 1e16, 1e32, 1e60}) {
      const SinusoidGains gains = combined_sinusoid(W, 0, Omega, 1);
      CHECK(std::isfinite(gains.in_phase.x));
      CHECK(std::isfinite(gains.quadrature.v));
    }
  }
}

TEST_CASE("bits of coefficients that must be the same on every platform") {
  const Combined host = combined(40, 0.3, 0x1p-6), lanes = combined_in_lanes(3000, 20, 0x1p-4);
  CHECK(host.A == 0x1.3ebb57e35e60cp-1);
  CHECK(host.B == 0x1.389c946352f07p-7);
  CHECK(host.C == 0x1.3f3da1340dd5fp-8);
  CHECK(host.D == 0x1.03b9b0814c3p-14);
  CHECK(lanes.A == -0x1.a82a93cad0b3ep+2);
  CHECK(lanes.B == 0x1.7ff1a1a16aceap+0);
  CHECK(lanes.D == 0x1.090c837e8628bp-4);
  const SinusoidGains forced = combined_sinusoid(40, 0.3, 7, 0.25);
  CHECK(forced.in_phase.v == 0x1.e05af6c0569p-5);
  CHECK(forced.quadrature.x == 0x1.b696baebbe7e9p-7);
}

}  // namespace combined_test
