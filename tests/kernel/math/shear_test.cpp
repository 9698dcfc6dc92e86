#include "forces/shear.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "forces/paired.hpp"
#include "forces/radial_spring.hpp"
#include "kernel/forces/scalar_step.hpp"
#include "support/close.hpp"
#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

namespace shear_test {

template <class T>
struct Phase2 {
  T e, v;
};

// The three shears about an anchor at 0, with the operations of the pass.
template <class T, class Coefficients>
Phase2<T> sheared(Phase2<T> at, const Coefficients& k) {
  const auto sign = static_cast<T>(k.sign), t1 = static_cast<T>(k.t1), s = static_cast<T>(k.s), t2 = static_cast<T>(k.t2);
  const T p = t1 * at.v;
  const T u = at.v - (s * (at.e + p) + static_cast<T>(k.kappa) * at.v);
  const T d = p + t2 * u;
  return {at.e + ((sign - 1) * at.e + sign * d), sign * u};
}

Shear undamped(double z) { return shear(combined(z * z, 0, 1), 0, 1); }

TEST_CASE("three shears are the exact step of an oscillator at every angle and damping, forwards and backwards") {
  const double h = 1.0 / 64;
  for (const double damping : {0.0, 1e-9, 1e-3, 0.3, 0.9}) {
    Worst error, reach;
    for (double z = 1e-6; z < 1e5; z *= 1.37) {
      const double omega = z / h, g = 2 * damping * omega;
      if (g * h > 30) continue;
      for (const double signed_h : {h, -h}) {
        const Combined exact = combined(omega * omega, g, signed_h);
        const Shear k = shear(exact, g, signed_h);
        const Phase2<double> at = sheared(Phase2<double>{0.7, 0.4 * omega}, k);
        const AxisState wanted = stepped({0.7, 0.4 * omega}, exact, 0, 0, 0);
        const double growth = std::exp(-std::min(0.0, g * signed_h));
        error.see(std::abs(at.e - wanted.x) / growth);
        error.see(std::abs(at.v - wanted.v) / omega / growth);
        if (damping == 0) reach.see(std::abs(k.t2) * omega);
        CHECK(is_close(k.s * (k.t1 + k.t2), k.kick, 1e-9));
      }
    }
    CAPTURE(damping);
    // With damping, C/A loses digits near z = n pi. Only floats are made from it.
    CHECK(error.worst() < (damping == 0 ? 1e-14 : 1e-9));
    CHECK(reach.worst() <= 1 + 1e-12);
  }
  const Shear free = shear(combined(0, 0, h), 0, h);
  CHECK(free.sign == 1);
  CHECK(free.t1 == h / 2);
  CHECK(free.t2 == h / 2);
  CHECK(free.s == 0);
  CHECK(shear(combined(1e4, 0, 0), 0, 0).t1 == 0);
}

TEST_CASE("omega h = pi/2, pi, 2 pi keep their energy") {
  for (const double z : {1.5707963267948966, 3.141592653589793, 6.283185307179586}) {
    const Shear k = undamped(z);
    Phase2<double> d{0.7, 0.3 * z};
    Phase2<float> f{0.7F, static_cast<float>(0.3 * z)};
    const ShearF paired_k = paired(k);
    for (int n = 0; n < 100000; ++n) {
      d = sheared(d, k);
      f = sheared(f, paired_k);
    }
    const double energy = z * z * (0.49 + 0.09);
    CHECK(is_close(d.v * d.v + z * z * d.e * d.e, energy, 1e-9));
    CHECK(is_close(double{f.v} * double{f.v} + z * z * double{f.e} * double{f.e}, energy, 1e-4));
  }
}

TEST_CASE("float shears keep their energy over ten million steps" * doctest::test_suite("long")) {
  Worst drift;
  for (const double z : {1e-3, 0.01, 0.1, 1.0, 1.6, 2.9}) {
    const ShearF k = paired(undamped(z));
    Phase2<float> at{0.7F, static_cast<float>(0.3 * z)};
    const auto energy = [&] { return double{at.v} * double{at.v} + z * z * double{at.e} * double{at.e}; };
    const double start = energy();
    for (int n = 0; n < 10000000; ++n) at = sheared(at, k);
    drift.see(std::abs(energy() / start - 1));
  }
  MESSAGE("energy after 1e7 steps: worst " << drift.worst() << ", rms " << drift.rms());
  CHECK(drift.worst() <= 1e-3);
  CHECK(drift.rms() <= 3e-4);
}

TEST_CASE("the radial kick turns by the exact angle along its axis, and is its own inverse") {
  const double h = 0.1;
  for (const double W : {1e-6, 1.0, 100.0, 1e4, 1e6}) {
    const RadialKick kick = radial_kick(W, 0, h);
    CHECK(kick.E == 1);
    CHECK(is_close(2 - h * kick.kappa, 2 * std::cos(std::sqrt(W) * h), 1e-13));
    CHECK(radial_kick(W, 0, -h).kappa == -kick.kappa);
  }
  const RadialKick damped = radial_kick(0, 3, h);
  CHECK(damped.kappa == 0);
  CHECK(is_close(damped.E * damped.E, std::exp(-0.3), 1e-15));
  CHECK(is_close(radial_kick(0, 3, -h).E * damped.E, 1, 1e-15));
}

}  // namespace shear_test
