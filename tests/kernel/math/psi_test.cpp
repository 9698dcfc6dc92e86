#include "math/psi.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "math/two_double_flow.hpp"
#include "support/oracle.hpp"
#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

namespace psi_test {

// The scale of psi_k's error: its own value or, if it oscillates through zero, the amplitude exp(-q/2)/z^k. A response that has
// decayed to nothing is measured relative to a tiny part of its largest value, which is below 1/q.
double envelope(int k, double exact, double w, double q) {
  if (k == 0) return 1;
  const double swing = 4 * w > q * q ? std::exp(-q / 2) * std::pow(w, -0.5 * k) : 0.0;
  return std::max({std::abs(exact), swing, 1e-20 / std::max(1.0, q)});
}

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

bool is_near(double a, double b) { return std::abs(a - b) <= 1e-13 * std::abs(b); }

TEST_CASE("psi of a stiffness or a damping beyond 2^100 is the motion that follows its force at once") {
  constexpr double far = 0x1p+110;
  // w y = s^(k-2)/(k-2)!, at the end of the unit of time
  const PsiTable stiff = flow(far, 0.0, 6);
  CHECK(is_near(stiff[4].value(), 1 / (2 * far)));
  CHECK(is_near(stiff[5].value(), 1 / (6 * far)));
  CHECK(is_near(stiff[6].value(), 1 / (24 * far)));
  // q y' + w y = s^(k-2)/(k-2)! with w = q: y' + y = s^(k-2)/((k-2)! q), and of a pulse y = exp(-s)/q
  const PsiTable damped = flow(far, far, 3);
  const double decay = std::exp(-1.0);
  CHECK(is_near(damped[1].value(), decay / far));
  CHECK(is_near(damped[2].value(), (1 - decay) / far));
  CHECK(is_near(damped[3].value(), decay / far));
}

TEST_CASE("a force that swings, on a damping beyond 2^50, moves as the force over the damping") {
  // y' = exp(i theta s)/q
  constexpr double q = 0x1p+60, theta = 1.2;
  const Forced forced = forced_flow(0.0, q, theta);
  CHECK(is_near(forced.velocity.re.value(), std::cos(theta) / q));
  CHECK(is_near(forced.velocity.im.value(), std::sin(theta) / q));
  CHECK(is_near(forced.position.re.value(), std::sin(theta) / (theta * q)));
  CHECK(is_near(forced.position.im.value(), (1 - std::cos(theta)) / (theta * q)));
}

}  // namespace psi_test
