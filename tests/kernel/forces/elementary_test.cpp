#include "math/elementary.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

// The math library is the oracle: in long double on x86, where its error is far below a double's.
TEST_CASE("exp and expm1 of negative arguments are within 1.1 ulp") {
  Worst exp_error, expm1_error;
  for (double x = 1e-14; x < 700; x *= 1.0371) {
    for (const double signed_x : {x, -x}) {
      const ExpNegative pair = exp_pair_negative(signed_x);
      exp_error.see(ulps(pair.exp, static_cast<double>(std::exp(-static_cast<long double>(signed_x)))));
      expm1_error.see(ulps(pair.expm1, static_cast<double>(std::expm1(-static_cast<long double>(signed_x)))));
    }
  }
  CHECK(exp_error.worst() <= 2);
  CHECK(expm1_error.worst() <= 2);
  CHECK(exp_negative(0) == 1);
  CHECK(expm1_negative(0) == 0);
  CHECK(exp_negative(1e308) == 0);
  CHECK(expm1_negative(1e308) == -1);
  CHECK(exp_negative(699.9) >= std::numeric_limits<double>::min());
}

TEST_CASE("sin and cos are within 2 eps, near and far") {
  Worst near_error, far_error;
  for (double x = 1e-12; x < 1e15; x *= 1.00719) {
    const SinCos at = sincos(-x);
    Worst& worst = x < sincos_fast ? near_error : far_error;
    worst.see(epsilons(at.sin, static_cast<double>(std::sin(-static_cast<long double>(x))), 1));
    worst.see(epsilons(at.cos, static_cast<double>(std::cos(-static_cast<long double>(x))), 1));
  }
  CHECK(near_error.worst() <= 1.5);
  CHECK(far_error.worst() <= 1.5);
  CHECK(sincos(0.0).sin == 0);
  CHECK(sincos(0.0).cos == 1);
  for (const double x : {1e16, 1e30, 1e300}) {
    const SinCos at = sincos(x);
    CHECK(std::abs(at.sin * at.sin + at.cos * at.cos - 1) < 1e-15);
  }
}

TEST_CASE("bits that must be the same on every platform") {
  CHECK(exp_negative(1.0) == 0x1.78b56362cef38p-2);
  CHECK(sincos(1.0).sin == 0x1.aed548f090ceep-1);
  CHECK(sincos(1.0).cos == 0x1.14a280fb5068cp-1);
}
