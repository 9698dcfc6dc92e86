// Networks: the order of each scheme, and conserved quantities.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace networks::order_test {

using test::Batch;
using test::is_close;
using test::Layout;
using test::plan_of;
using test::stepped;

double difference_rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i += 6) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum += (a[i + axis] - b[i + axis]) * (a[i + axis] - b[i + axis]);
  }
  return std::sqrt(sum / static_cast<double>(a.size() / 6));
}

double fitted_order(const Joined& joined, Coupling coupling, int substeps) {
  const auto run = [&](int n) {
    coupling.substeps = n;
    return stepped<double>(with(joined, coupling), {.isa = best_isa()}, 6);
  };
  const auto coarse = run(substeps);
  const auto middle = run(2 * substeps);
  const auto fine = run(4 * substeps);
  return std::log2(difference_rms(coarse, middle) / difference_rms(middle, fine));
}

TEST_CASE("network: each scheme has its order") {
  Joined joined = test::sheet(8, 9, 20);
  joined.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 0}});
  const double leapfrog = fitted_order(joined, {.scheme = Scheme::leapfrog}, 32);
  const double fourth = fitted_order(joined, {.scheme = Scheme::fourth_order}, 16);
  const double half = fitted_order(joined, {.scheme = Scheme::sequential, .theta = 0.5}, 64);
  const double one = fitted_order(joined, {.scheme = Scheme::sequential, .theta = 1, .sweeps = SweepOrder::forward}, 128);
  const double filtered = fitted_order(joined, {.scheme = Scheme::accumulate, .method = Method::combined}, 32);
  MESSAGE("orders: leapfrog " << leapfrog << ", fourth_order " << fourth << ", sequential 0.5 " << half << ", theta 1 " << one
                              << ", filtered pulse " << filtered);
  CHECK(is_close(leapfrog, 2, 0.05));
  CHECK(std::abs(fourth - 4) < 0.2);
  CHECK(is_close(half, 2, 0.1));
  CHECK(is_close(one, 1, 0.2));
  CHECK(is_close(filtered, 2, 0.05));
}

TEST_CASE("network: a symmetric scheme is its own inverse") {
  Joined joined = test::sheet(8, 9, 20);
  for (const Coupling& coupling :
       {Coupling{.scheme = Scheme::leapfrog, .substeps = 20}, Coupling{.scheme = Scheme::fourth_order, .substeps = 10},
        Coupling{.scheme = Scheme::sequential, .substeps = 10, .theta = 0.5}}) {
    const Joined forward = with(joined, coupling);
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(forward, batch.view());
    const auto start = test::values_of(batch.view());
    Plan<double> plan = plan_of(forward, {.isa = best_isa()}, batch.view());
    REQUIRE(plan.step(batch.view(), 20) == StepResult::done);
    REQUIRE(plan.set_step(-joined.step).has_value());
    REQUIRE(plan.step(batch.view(), 20) == StepResult::done);
    CHECK(difference_rms(start, test::values_of(batch.view())) < 1e-11);
  }
}

// One step from rest at theta = 1/2 turns displacements into velocities. Near the rest lengths this is a matrix, which a
// forward and a backward sweep keep symmetric, however incomplete the solution is.
TEST_CASE("network: a forward and a backward sweep act on two particles alike, in strands and in colours") {
  Joined sheet = test::sheet(5, 5, 5000);
  sheet.scene.forces.clear();
  sheet.scene.fixed.clear();
  sheet.scene.coupling = {.scheme = Scheme::sequential, .substeps = 1, .theta = 0.5};
  for (std::size_t i = 0; i < 25; ++i) {
    sheet.x[i] = {0.25 * static_cast<double>(i % 5), 0, 0.25 * static_cast<double>(i / 5)};
    sheet.v[i] = {};
  }
  constexpr double moved = 1e-7;
  constexpr std::array<std::array<std::size_t, 2>, 6> looked_at = {{{0, 0}, {6, 2}, {7, 0}, {12, 2}, {13, 0}, {19, 2}}};
  for (const Joined& springs : {sheet, test::as_list(sheet)}) {
    std::array<std::array<double, 6>, 6> answer{};
    double largest = 0;
    for (std::size_t j = 0; j < looked_at.size(); ++j) {
      Joined drawn = springs;
      drawn.x[looked_at[j][0]][looked_at[j][1]] += moved;
      const auto got = stepped<double>(drawn, {.isa = best_isa()}, 1);
      for (std::size_t i = 0; i < looked_at.size(); ++i) {
        answer[i][j] = v(got, looked_at[i][0], looked_at[i][1]) / moved;
        if (i != j) largest = std::max(largest, std::abs(answer[i][j]));
      }
    }
    CHECK(largest > 1);
    for (std::size_t i = 0; i < looked_at.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        CAPTURE(springs.name);
        CHECK(std::abs(answer[i][j] - answer[j][i]) <= 1e-4 * largest);
      }
    }
  }
}

// The fourth order moves back slightly between two pulses. A particle that just left the floor is then below it for a while.
TEST_CASE("network: a bounce between the pulses of the fourth order is one bounce, though the scheme goes back over it") {
  for (const double height : {0.42, 0.59, 0.3}) {  // a backward flow passes the impact again, in two of them
    Joined pair;
    pair.x = {{0, height, 0}, {10, 5, 0}};
    pair.v = {{0, -1, 0}, {0, 0, 0}};
    pair.step = 1;
    pair.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 1e-12, .rest_length = Scalars(11.0)}));
    pair.scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5});
    pair.scene.coupling = {.scheme = Scheme::fourth_order, .substeps = 1};
    for (const Isa isa : {Isa::reference, best_isa()}) {
      const auto got = stepped<double>(pair, {.isa = isa}, 1);
      CHECK(std::abs(v(got, 0, 1) - 0.5) <= 1e-9);
      CHECK(std::abs(x(got, 0, 1) - 0.5 * (1 - height)) <= 1e-9);
    }
  }
}

TEST_CASE("network: free sheets keep their momentum") {
  for (const Coupling& coupling : all_schemes) {
    Joined joined = with(test::sheet(9, 20, 50, 0.001), coupling);
    joined.scene.forces.clear();
    joined.scene.fixed.clear();
    double moved = 0;  // the sum of the momenta's absolute values
    const auto momentum = [&](const std::vector<double>& values) {
      Vec3 p{};
      moved = 0;
      for (std::size_t i = 0; i < values.size() / 6; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          p[axis] += v(values, i, axis);
          moved += std::abs(v(values, i, axis));
        }
      }
      return p;
    };
    const auto before = momentum(stepped<double>(joined, {.isa = best_isa()}, 0));
    // Exact contributions of pairs that share particles gain energy at every step, so these runs are short.
    const std::size_t steps = coupling.method == Method::exact ? 10 : 100;
    const auto after =
        momentum(stepped<double>(joined, {.isa = best_isa()}, coupling.scheme == Scheme::accumulate ? steps : 100));
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(std::abs(after[axis] - before[axis]) <= 1e-13 * moved);
  }
}

TEST_CASE("network: a pair of masses a million apart keeps its momentum") {
  Joined joined = on_a_line({0, 1.1}, {0.3, -0.2}, 0);
  joined.scene.mass = Scalars(std::vector<double>{1e6, 1});
  joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = 1.0}));
  for (const Coupling& coupling : all_schemes) {
    if (coupling.theta == 1) continue;
    const auto got = stepped<double>(with(joined, coupling), {.isa = best_isa()}, 10000);
    CHECK(is_close(1e6 * v(got, 0, 0) + v(got, 1, 0), 1e6 * 0.3 - 0.2, 1e-13));
  }
}

TEST_CASE("network: sequential is stable at every step, linear springs") {
  // 64 bodies on a line, stiff and soft springs in turn, a step of 1000 / omega
  std::vector<double> at;
  std::vector<double> speed(65, 0.0);
  for (std::size_t i = 0; i < 65; ++i) at.push_back(static_cast<double>(i) + 1e-6 * std::sin(0.3 * static_cast<double>(i)));
  Joined joined = on_a_line(at, speed, 0);
  joined.scene.fixed = {0, 64};
  std::vector<double> k;
  Springs springs;
  for (std::uint32_t i = 0; i < 64; ++i) {
    springs.pairs.push_back({i, i + 1});
    k.push_back(i % 2 == 0 ? 1e4 : 1.0);
  }
  springs.stiffness = Scalars(k);
  springs.rest_length = 1.0;
  joined.scene.add(Network(springs));
  for (const auto& [theta, step] : {std::pair{std::optional(0.5), 0.01},
                                    {std::optional(0.5), 0.1},
                                    {std::optional(0.5), 10.0},
                                    {std::optional<double>(), 0.01},
                                    {std::optional<double>(), 10.0}}) {
    joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 1, .theta = theta};
    joined.step = step;
    const auto got = stepped<double>(joined, {.isa = best_isa()}, 10000);
    double worst = 0;
    for (std::size_t i = 0; i < 65; ++i) worst = std::max(worst, std::abs(x(got, i, 0) - static_cast<double>(i)));
    MESSAGE("a step of " << step * 200 << " / omega, 10000 of them: displacements of 1e-6 m have become " << worst << " m");
    CHECK(worst < 1e-3);
  }
}

}  // namespace networks::order_test
