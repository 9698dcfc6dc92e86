// Networks: their highest frequency, and the sub-steps that it requires.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace networks::limit_test {

using test::Batch;
using test::is_close;
using test::Layout;
using test::plan_of;
using test::stepped;

// The springs of a row act along one direction, and as many motions as there are particles stretch none of them.
TEST_CASE("network: the highest frequency of rows is found, whatever the stiffness; sub-steps keep their energy within twice") {
  for (const std::size_t count : {2U, 3U, 8U, 20U}) {
    for (int n = 0; n < 40; ++n) {
      const double k = 1000 * std::pow(1.37, n);
      Joined joined;
      joined.step = 1.0 / 60;
      Springs springs{.pairs = {}, .stiffness = k, .rest_length = Scalars(1.0)};
      for (std::size_t i = 0; i < count; ++i) {
        const auto at = static_cast<double>(i);
        joined.x.push_back({at + 0.05 * std::sin(3 * at + 1), 0, 0});
        joined.v.push_back({});
        if (i > 0) springs.pairs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
      }
      joined.scene.add(Network(springs));
      Batch<double> batch(Layout::soa, count);
      test::place(joined, batch.view());
      const auto limit = *plan_of(joined, {}, batch.view()).network_limit();
      const double last = std::acos(-1.0) * static_cast<double>(count - 1) / static_cast<double>(count);
      const double omega = std::sqrt(k * (2 - 2 * std::cos(last)));
      CHECK(is_close(limit.frequency, omega, 1e-3));
      CHECK(limit.bound >= omega * (1 - 1e-9));
      CHECK(limit.bound <= omega * 1.02);
      CHECK(limit.substeps == std::ceil(limit.bound * joined.step / 1.414));
      CHECK(limit.safe <= limit.substeps);
    }
  }
}

TEST_CASE("network: the plan knows the highest frequency and refuses fewer sub-steps than the start allows") {
  // A chain of equal masses and springs, both ends fixed: omega_max = 2 sqrt(k/m) sin(n pi / (2 (n+1)))
  constexpr std::size_t n = 20;
  std::vector<double> at;
  for (std::size_t i = 0; i < n + 2; ++i) at.push_back(static_cast<double>(i));
  Joined joined = on_a_line(at, std::vector<double>(n + 2, 0.0), 0);
  joined.scene.fixed = {0, n + 1};
  Springs springs{.pairs = {}, .stiffness = 1e4, .rest_length = 1.0};
  for (std::uint32_t i = 0; i <= n; ++i) springs.pairs.push_back({i, i + 1});
  joined.scene.add(Network(springs));
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto limit = plan_of(joined, {}, batch.view()).network_limit();
  REQUIRE(limit.has_value());
  const double omega = 2 * 100 * std::sin(n * 3.14159265358979 / (2.0 * (n + 1)));
  CHECK(is_close(limit->frequency, omega, 1e-3));
  CHECK(limit->bound >= omega);
  CHECK(limit->bound < 1.02 * omega);
  CHECK(is_close(limit->limit, 2, 1e-3));
  CHECK(limit->fewest == 2);  // 199.4 / 60 / 1.86 = 1.79
  joined.scene.coupling.substeps = 1;
  const auto refused = compile<double>(joined.scene, {.step = joined.step}, batch.view());
  REQUIRE(!refused.has_value());
  CHECK(refused.error().field == "coupling.substeps");
  CHECK(compile<double>(joined.scene, {.step = joined.step, .unstable = Unstable::allowed}, batch.view()).has_value());
  joined.scene.coupling.scheme = Scheme::sequential;
  CHECK(compile<double>(joined.scene, {.step = joined.step}, batch.view()).has_value());
}

NetworkLimit limit_of(const Joined& joined) {
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  return *plan_of(joined, {}, batch.view()).network_limit();
}

TEST_CASE("network: the bound covers any position of a star, and of a grid as of the list of its springs") {
  // Three masses on springs of stiffness k to a fourth one in the middle: omega_max = sqrt(4 k/m).
  Joined star;
  star.x = {{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}, {0, 0, 0}};
  star.v.assign(4, {});
  star.scene.add(Network(Springs{.pairs = {{0, 3}, {1, 3}, {2, 3}}, .stiffness = 900.0, .rest_length = 0.0}));
  CHECK(limit_of(star).bound >= 60 * (1 - 1e-9));
  const Joined sheet = test::sheet(9, 14, 50);
  CHECK(limit_of(sheet).bound >= limit_of(test::as_list(sheet)).bound / 1.02);
}

TEST_CASE("network: a stretched spring is stiff across itself, too") {
  // Two perpendicular springs of stiffness k, at twice their rest length: omega^2 = (k + k/2)/m along either.
  Joined corner;
  corner.x = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  corner.v.assign(3, {});
  corner.scene.fixed = {1, 2};
  corner.scene.add(Network(Springs{.pairs = {{0, 1}, {0, 2}}, .stiffness = 600.0, .rest_length = 1.0}));
  CHECK(std::abs(limit_of(corner).frequency - 30) <= 0.03);
}

TEST_CASE("network: a sheet that hangs free is held to what its start asks for and a margin") {
  Joined sheet = test::sheet(9, 14, 50);
  std::get<Grid>(sheet.scene.networks[0]).shear = 0;  // flat, its rows and columns do not interact; folded, they do
  sheet.step = 1e-4;
  const NetworkLimit slow = limit_of(sheet);
  sheet.step = 8.9 * slow.limit / slow.frequency;
  CHECK(limit_of(sheet).fewest == 10);  // 8.9 / 0.93 = 9.57
  CHECK(limit_of(sheet).safe > 10);
}

TEST_CASE("network: a damped pair is stable with as many sub-steps as the plan says") {
  // w_a + w_b = 2/kg, c = 1000 kg/s: the damping rate is 2000/s, which times the sub-step must be below 2.
  Joined pair;
  pair.x = {{0, 0, 0}, {2, 0, 0}};
  pair.v = {{0, 0, 0}, {3, 0, 0}};
  pair.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 1e-6, .rest_length = 2.0, .damping = 1000}));
  CHECK(limit_of(pair).safe == 17);  // 2000 / 60 / 2 = 16.7
  const auto after = stepped<double>(pair, {}, 60);
  CHECK(std::abs(v(after, 1, 0) - v(after, 0, 0)) < 1e-3);
  CHECK(std::abs(v(after, 1, 0) + v(after, 0, 0) - 3) < 1e-12);
}

// From omega h = 3.106 to 3.133 a sub-step of the fourth order is stable, but its energy more than doubles at times.
TEST_CASE("network: the fourth order's own sub-steps keep a pair's energy within twice, near its limit too") {
  for (int n = 0; n < 30; ++n) {
    const double angle = 30.9 + 0.015 * n;  // for a step
    Joined pair = on_a_line({0, 1.01}, {0, 0}, 0);
    const double omega = angle / pair.step;
    const double k = omega * omega / 2;
    pair.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = k, .rest_length = Scalars(1.0)}));
    pair.scene.coupling = {.scheme = Scheme::fourth_order};
    Batch<double> batch(Layout::soa, 2);
    test::place(pair, batch.view());
    const Plan<double> plan = plan_of(pair, {.isa = best_isa()}, batch.view());
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (int step = 0; step < 300; ++step) {
      const auto& state = batch.view();
      const double e = state.x[0][1] - state.x[0][0] - 1, u = (state.v[0][1] - state.v[0][0]) / omega;
      least = std::min(least, e * e + u * u);
      most = std::max(most, e * e + u * u);
      REQUIRE(plan.step(batch.view()) == StepResult::done);
    }
    CAPTURE(angle);
    CHECK(most <= 2 * least);
  }
}

}  // namespace networks::limit_test
