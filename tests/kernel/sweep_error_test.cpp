// A plan's estimate of the part that sweeps leave unsolved, compared with closed forms and with what is measured.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "kernel/swept_nets.hpp"
#include "support/close.hpp"

namespace swept_nets::error_test {

using test::is_close;

TEST_CASE("sequential by itself: the estimate is near what is measured, at sub-steps that are asked for too") {
  for (const auto& [springs, k, load] : {LoadedRope{10, 1e4, 100}, {20, 1e4, 10}}) {
    Net net = hung_rope(springs, k, load);
    for (const int substeps : {12, 24}) {
      net.scene.coupling.substeps = substeps;
      const double measured = lowest_of_rope(springs, k, load) - lowest(net);
      const SweepEstimate estimate = limit_of(net).estimate;
      CAPTURE(substeps);
      CAPTURE(measured);
      CHECK(limit_of(net).substeps == substeps);
      CHECK(estimate.rest <= 1.8 * measured);
      CHECK(estimate.rest >= 0.8 * measured);
      CHECK(is_close(estimate.sag, lowest_of_rope(springs, 1e300, load) - lowest_of_rope(springs, k, load), 0.6));
    }
  }
}

// At its rest length a rope of weight W and compliance C between two ends L apart sags by s, s^3 = 3 C W L^2/64.
struct Cable {
  Net net;
  double sag, turning;  // m; rad/s, of its links under the tension W L/(8 s)
};

Cable taut_cable(std::size_t springs, double k) {
  Cable cable{.net = rope(springs, k, 1, {1, 0, 0}), .sag = 0, .turning = 0};
  cable.net.scene.fixed = {0, springs};
  const double L = cable.net.side, W = static_cast<double>(springs - 1) * link * g, C = static_cast<double>(springs) / k;
  cable.sag = std::cbrt(3 * C * W * L * L / 64);
  cable.turning = 2 * std::sqrt(W * L / (8 * cable.sag) / link / length);
  return cable;
}

TEST_CASE("sequential by itself: the estimate of a taut rope between two ends is near what is measured") {
  for (const std::size_t springs : {20U, 30U}) {
    for (const double k : {1e4, 1e5}) {
      Cable cable = taut_cable(springs, k);
      for (const int substeps : {2, 4}) {
        cable.net.scene.coupling.substeps = substeps;
        const double measured = -cable.sag - lowest(cable.net);
        const SweepEstimate estimate = limit_of(cable.net).estimate;
        CAPTURE(springs);
        CAPTURE(substeps);
        CAPTURE(measured);
        CHECK(estimate.rest <= 1.5 * measured);
        CHECK(estimate.rest >= 0.8 * measured);
      }
    }
  }
}

// Up to 2 a sub-step it hangs too low only by its fall between two pulses.
TEST_CASE("sequential by itself: a rope that lines solve has the error of sweeps once its links turn too far in a sub-step") {
  for (const double k : {1e4, 1e5, 1e6}) {
    Cable cable = taut_cable(30, k);
    cable.net.scene.coupling.lines = Lines::whole;
    cable.net.scene.coupling.substeps = 1;
    const auto part_of_fall = [&](double turning) {
      const double step = cable.net.options.step = turning / cable.turning;
      return limit_of(cable.net).estimate.rest / (g * step * step / 8);
    };
    CAPTURE(k);
    CHECK(is_close(part_of_fall(1.75), 1, 1e-9));
    CHECK(part_of_fall(2.25) > 100);
  }
}

// m: of the last particle from the first, in the mean over a swing to the other side from where the rope lies level.
double mean_reach(Net net, Scheme scheme, std::optional<int> substeps) {
  net.scene.coupling.scheme = scheme;
  net.scene.coupling.substeps = substeps;
  const double swing = 2 * 1.8540746773 * std::sqrt(net.side / g);  // s; the elliptic integral of a pendulum let go level
  Soa<double> memory = placed(net);
  State<double> state = memory.view();
  const Plan<double> plan = plan_of(net);
  const int steps = static_cast<int>(std::lround(swing / net.options.step));
  double sum = 0;
  for (int n = 0; n < steps; ++n) {
    REQUIRE(plan.step(state, 1) == StepResult::done);
    sum += std::hypot(state.x[0][state.count - 1], state.x[1][state.count - 1]);
  }
  return sum / steps;
}

TEST_CASE("sequential by itself: the estimate of a swing's error is near what is measured") {
  for (const LoadedRope& swung : {LoadedRope{3, 1e5, 100}, {10, 1e4, 100}, {10, 1e5, 100}}) {
    Net net = rope(swung.springs, swung.k, swung.load, {1, 0, 0});
    net.scene.forces.pop_back();  // the drag
    const double right = mean_reach(net, Scheme::leapfrog, std::nullopt);
    for (const int substeps : {6, 12}) {
      net.scene.coupling.substeps = substeps;
      const double measured = mean_reach(net, Scheme::sequential, substeps) - right;
      const double estimated = limit_of(net).estimate.motion;
      CAPTURE(swung.springs);
      CAPTURE(substeps);
      CAPTURE(measured);
      CHECK(estimated <= 2 * measured);
      CHECK(estimated >= 0.8 * measured);
    }
  }
}

// Such a sheet draws in by half of its stretch. Each of the diagonals beside a column's spring then takes a sixth of the load.
TEST_CASE("sequential by itself: a sheet sags as columns that bear two thirds of the load, beside diagonals as stiff as they") {
  for (const std::size_t side : {8U, 16U, 24U}) {
    const double weight = g / static_cast<double>(side);  // N, of a column
    const double stretch = 2.0 / 3 * weight * static_cast<double>(side - 1) / 2 / 1e4;
    CHECK(is_close(limit_of(sheet(side, 1e4, 1e4, Held::edge)).estimate.sag, stretch, 0.25));
  }
}

}  // namespace swept_nets::error_test
