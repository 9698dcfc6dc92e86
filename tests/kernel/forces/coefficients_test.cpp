#include <doctest/doctest.h>

#include <cmath>

#include "forces/combined.hpp"
#include "forces/drag.hpp"
#include "forces/spring.hpp"
#include "kernel/forces/scalar_step.hpp"
#include "support/close.hpp"
#include "support/oracle.hpp"
#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

// z and q are given for h = 1. W = z^2 is rounded by half an ulp, a phase of z/2 half ulps. That error belongs to the input and
// not to the coefficients, so the oracle is moved along its derivative to the exact z of the rounded W.
TEST_CASE("spring and drag coefficients are within 4 eps in double and 2 ulp in float") {
  const Oracle oracle("coefficients.csv");
  Worst spring_error, drag_error, float_error;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double z = row["z"];
    CAPTURE(row.text("kind"));
    CAPTURE(z);
    if (row.text("kind") == "spring") {
      const double W = z * z;
      const double dz = -std::fma(z, z, -W) / (2 * z);  // sqrt(W) - z
      const double sine = row["c1"] / z, cosine = 1 - row["c2"];
      const Contribution f = spring(W, 0, 1, Method::exact);
      const double A = row["c1"] + dz * (sine + z * cosine);
      const double B = row["c2"] + dz * sine;
      const double D = row["c3"] + dz * (sine / z - cosine) / z;
      const double near_zero = std::max(1.0, 1e-3 / std::abs(sine)) * 1.0;
      spring_error.see(epsilons(f.A, A, z > 1 ? z : A) / near_zero);
      spring_error.see(epsilons(f.B, B, B > 1e-3 ? 1.0 : B));
      spring_error.see(epsilons(f.D, D, D));
      if (std::abs(sine) > 1e-3 || z < 1e-3) float_error.see(ulps(static_cast<float>(f.A), A));
      float_error.see(ulps(static_cast<float>(f.B), B));
      float_error.see(ulps(static_cast<float>(f.D), D));
    } else {
      const Contribution f = drag(z, 1, Method::exact, Expansion::exact);
      drag_error.see(epsilons(f.B, row["c2"], row["c2"]));
      drag_error.see(epsilons(f.D, row["c3"], row["c3"]));
      drag_error.see(epsilons(1 - f.B, row["c1"], 1));
      float_error.see(ulps(static_cast<float>(f.B), row["c2"]));
      float_error.see(ulps(static_cast<float>(f.D), row["c3"]));
    }
  }
  MESSAGE("spring " << spring_error.worst() << " eps, drag " << drag_error.worst() << " eps, float " << float_error.worst()
                    << " ulp");
  CHECK(spring_error.worst() <= 4);
  CHECK(drag_error.worst() <= 4);
  CHECK(float_error.worst() <= 2);
}

TEST_CASE("a step of no time is the identity") {
  for (const Method method :
       {Method::combined, Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
    const Contribution f = spring(1e5, 3, 0, method);
    CHECK(f.A == 0);
    CHECK(f.B == 0);
    CHECK(f.C == 0);
    CHECK(f.D == 0);
  }
  const Combined f = combined(1e5, 3, 0);
  CHECK(f.S == 0);
  CHECK(f.constant.v == 0);
  CHECK(f.constant.x == 0);
}

// det of one step minus 1, summed over springs of z_i like Brown's separate modes.
TEST_CASE("the separate modes have the determinants that theory gives them") {
  const double h = 0.01;
  for (const double ratio : {1.0, 4.0, 10.0}) {
    const double W1 = 9, W2 = ratio * W1;
    const auto sum = [&](Method method) {
      const Contribution a = spring(W1, 0, h, method), b = spring(W2, 0, h, method);
      return Matrix{1 - a.C - b.C, h - a.D - b.D, -a.A - b.A, 1 - a.B - b.B}.det() - 1;
    };
    const double z2 = (W1 + W2) * h * h;
    const double z4 = (W1 * W1 + W2 * W2) * h * h * h * h;
    CHECK(is_close(sum(Method::exact), (z2 * z2 - z4) / 12, 0.01));
    CHECK(is_close(sum(Method::average_acceleration), -z4 / 24, 0.01));
    CHECK(is_close(sum(Method::pulse), -z2 / 2, 0.01));
    CHECK(std::abs(sum(Method::symplectic_euler)) < 1e-15);
  }
  const Contribution one = spring(9, 0, h, Method::exact);
  CHECK(std::abs(matrix(one, h).det() - 1) < 1e-15);
  CHECK(is_close(matrix(spring(9, 0, 1, Method::pulse), 1).det(), std::cos(3.0), 1e-12));
}

TEST_CASE("drag: wind acts through v - u, and the first-order form is g h and g h^2/2") {
  const double g = 3, h = 0.1, u = 7;
  for (const Method method : {Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
    for (const Expansion expansion : {Expansion::exact, Expansion::first_order}) {
      const Contribution f = drag(g, h, method, expansion);
      const AxisState at = stepped({0, u}, f, h, 0, f.B * u, f.D * u);
      CHECK(is_close(at.v, u, 1e-12));
      CHECK(is_close(at.x, u * h, 1e-12));
    }
  }
  const Contribution first = drag(g, h, Method::exact, Expansion::first_order);
  CHECK(first.B == g * h);
  CHECK(is_close(first.D, g * h * h / 2, 1e-12));
  const Contribution heavy = drag(1e12, 1, Method::exact, Expansion::exact);
  CHECK(is_close(heavy.B, 1, 1e-12));
  CHECK(is_close(heavy.D, 1, 1e-12));
}
