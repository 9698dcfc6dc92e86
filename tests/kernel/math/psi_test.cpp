#include "math/psi.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "support/oracle.hpp"
#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

namespace {

// The size around which psi_k swings: its own value, or where it oscillates through zero, its amplitude exp(-q/2)/z^k. A
// response that has died away to nothing is measured by a trace of its largest value, which is below 1/q.
double envelope(int k, double exact, double w, double q) {
  if (k == 0) return 1;
  const double swing = 4 * w > q * q ? std::exp(-q / 2) * std::pow(w, -0.5 * k) : 0.0;
  return std::max({std::abs(exact), swing, 1e-20 / std::max(1.0, q)});
}

}  // namespace

TEST_CASE("psi agrees with the closed form on the whole grid") {
  const Oracle oracle("psi.csv");
  Worst lanes, host;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double w = row["w"], q = row["q"];
    const Psi at = psi(w, q);
    const std::array<double, 4> value{at.psi0, at.psi1, at.psi2, at.psi3};
    const double bar = std::max(16.0, std::sqrt(w));
    for (int k = 0; k <= 5; ++k) {
      const double exact = row["psi" + std::to_string(k)];
      const double scale = envelope(k, exact, w, q);
      CAPTURE(w);
      CAPTURE(q);
      CAPTURE(k);
      const double host_error = epsilons(psi_k(k, w, q), exact, scale);
      host.see(host_error);
      CHECK(host_error <= 1);
      if (k > 3) continue;
      const double lane_error = epsilons(value[static_cast<std::size_t>(k)], exact, scale) / bar;
      lanes.see(lane_error);
      CHECK(lane_error <= 1);
    }
  }
  MESSAGE("psi in lanes, worst error / max(16,z) eps: " << lanes.worst() << "; psi_k, worst error in eps: " << host.worst());
}

TEST_CASE("psi is finite for every w >= 0 and q >= 0") {
  for (const double w : {0.0, 1e-308, 1e-300, 1e-20, 1.0, 1e20, 1e31, 1e100, 1e200, 1e300}) {
    for (const double q : {0.0, 1e-308, 1e-300, 1e-20, 1.0, 1e20, 1e31, 1e100, 1e200, 1e300}) {
      CAPTURE(w);
      CAPTURE(q);
      const Psi at = psi(w, q);
      CHECK(std::isfinite(at.psi0));
      CHECK(std::isfinite(at.psi1));
      CHECK(std::isfinite(at.psi2));
      CHECK(std::isfinite(at.psi3));
      for (int k = 0; k <= psi_max; ++k) CHECK(std::isfinite(psi_k(k, w, q)));
    }
  }
}

TEST_CASE("the recurrence holds for every k, forwards and backwards in time") {
  for (const double w : {0.0, 1e-9, 0.3, 2.5, 40.0, 1e4}) {
    for (const double q : {-30.0, -2.5, -1e-6, 0.0, 1e-6, 0.7, 3.0, 50.0, 1e5}) {
      double factorial = 1;
      for (int k = 1; k < psi_max; factorial *= k++) {
        CAPTURE(w);
        CAPTURE(q);
        CAPTURE(k);
        const double a = psi_k(k - 1, w, q), b = q * psi_k(k, w, q), c = w * psi_k(k + 1, w, q);
        CHECK(std::abs(a + b + c - 1 / factorial) <= 4e-16 * (std::abs(a) + std::abs(b) + std::abs(c) + 1 / factorial));
      }
    }
  }
}

TEST_CASE("psi in lanes runs backwards too") {
  Worst error;
  for (double w = 1e-8; w < 1e5; w *= 3.7) {
    for (double q = 1e-8; q < 60; q *= 2.3) {
      const Psi at = psi(w, -q);
      const double bar = std::max({16.0, std::sqrt(w), q});
      error.see(epsilons(at.psi1, psi_k(1, w, -q), envelope(1, psi_k(1, w, -q), w, -q)) / bar);
      error.see(epsilons(at.psi2, psi_k(2, w, -q), envelope(2, psi_k(2, w, -q), w, -q)) / bar);
      error.see(epsilons(at.psi3, psi_k(3, w, -q), envelope(3, psi_k(3, w, -q), w, -q)) / bar);
    }
  }
  MESSAGE("worst error / max(16,z,q) eps: " << error.worst());
  CHECK(error.worst() <= 2);
}
