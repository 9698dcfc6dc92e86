// Networks, compared with closed forms and with the reference path of a cloth.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "support/close.hpp"
#include "support/oracle.hpp"

namespace networks::closed_form_test {

using test::is_close;
using test::stepped;

TEST_CASE(
    "network: a spring without rest length pulls its turning ends as two harmonic oscillators, beside others along lines") {
  Joined joined;
  joined.x = {{-0.5, 0, 0}, {0.5, 0, 0}, {10, 0, 0}, {12, 0, 0}};
  joined.v = {{0, -7, 0}, {0, 7, 0}, {-0.1, 0, 0}, {0.1, 0, 0}};
  joined.step = 1.0 / 60;
  constexpr double k = 5000;  // N/m, Omega = 100 rad/s for masses of 1 kg
  joined.scene.add(
      Network(Springs{.pairs = {{0, 1}, {2, 3}}, .stiffness = k, .rest_length = Scalars(std::vector<double>{0, 2})}));
  joined.scene.coupling = {.scheme = Scheme::accumulate, .substeps = 1, .method = Method::exact};
  const double Omega = std::sqrt(2 * k);
  const double angle = Omega * joined.step;
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    const auto after = stepped<double>(joined, {.isa = isa}, 1);
    CHECK(is_close(x(after, 1, 0), 0.5 * std::cos(angle), 1e-13));
    CHECK(is_close(x(after, 1, 1), 7 / Omega * std::sin(angle), 1e-13));
    CHECK(is_close(v(after, 1, 0), -0.5 * Omega * std::sin(angle), 1e-13));
    CHECK(is_close(v(after, 1, 1), 7 * std::cos(angle), 1e-13));
    CHECK(is_close(x(after, 3, 0), 12 + 0.1 / Omega * std::sin(angle), 1e-13));
    CHECK(is_close(v(after, 3, 0), 0.1 * std::cos(angle), 1e-11));
    CHECK(is_close(v(after, 2, 0), -0.1 * std::cos(angle), 1e-11));
  }
}

std::size_t steps_in(double time, double step) { return static_cast<std::size_t>(std::lround(time / step)); }

// e is the stretch of the pair, u = de/dt, W and g those of both masses: a = -W (e + h u + h^2 a) - g (u + h a), h = theta s.
TEST_CASE("network: sequential is the theta step of a damped pair, as a list and as the rows of a grid") {
  constexpr double k = 400, c = 3, mass = 0.5, l = 1.25;
  constexpr double W = 2 * k / mass, g = 2 * c / mass;
  constexpr int substeps = 3, steps = 20;
  Springs springs{.pairs = {{0, 1}, {2, 3}}, .stiffness = k, .rest_length = l};
  springs.damping = c;
  Grid grid{.rows = 2, .columns = 2, .edge_u = {l, 0, 0}, .edge_v = {0, 0, 2}, .structural = k};
  grid.damping = c;
  for (const Network& network : {Network(springs), Network(grid)}) {
    for (const double theta : {0.5, 0.55, 0.75, 1.0}) {
      CAPTURE(theta);
      Joined pairs;
      pairs.x = {{0, 0, 0}, {l + 0.1, 0, 0}, {0, 0, 2}, {l + 0.1, 0, 2}};
      pairs.v = {{-0.2, 0, 0}, {0.5, 0, 0}, {-0.2, 0, 0}, {0.5, 0, 0}};
      pairs.scene.mass = mass;
      pairs.scene.add(network);
      pairs.scene.coupling = {.scheme = Scheme::sequential, .substeps = substeps, .theta = theta};
      const double s = pairs.step / substeps, h = theta * s;
      double e = 0.1, u = 0.7;
      for (int n = 0; n < substeps * steps; ++n) {
        const double a = -(W * (e + h * u) + g * u) / (1 + W * h * h + g * h);
        e += s * u + theta * s * s * a;
        u += s * a;
      }
      for (const Isa isa : {Isa::reference, best_isa()}) {
        const auto got = stepped<double>(pairs, {.isa = isa}, steps);
        for (const std::size_t first : {0U, 2U}) {
          CHECK(std::abs(x(got, first + 1, 0) - x(got, first, 0) - l - e) <= 1e-13);
          CHECK(std::abs(v(got, first + 1, 0) - v(got, first, 0) - u) <= 1e-11);
        }
      }
    }
  }
}

// Springs without stiffness only remove speed, a pair as if it were alone: u' = -g u along it.
TEST_CASE("network: the filtered pulse damps a pair as its closed form does, whatever the step") {
  for (const double damping : {0.1, 3.0, 40.0}) {
    Joined pair = on_a_line({0, 1.25}, {-0.25, 0.75}, 0);
    Springs springs{.pairs = {{0, 1}}, .stiffness = 1e-9, .rest_length = Scalars(1.25)};
    springs.damping = damping;
    pair.scene.add(Network(springs));
    pair.scene.coupling = {.scheme = Scheme::accumulate, .substeps = 1, .method = Method::combined};
    const auto got = stepped<double>(pair, {.isa = best_isa()}, 1);
    CHECK(is_close(v(got, 1, 0) - v(got, 0, 0), std::exp(-2 * damping * pair.step), 1e-8));
  }
}

TEST_CASE("network: chains of springs follow their closed form") {
  const test::Oracle oracle("chain1d.csv");
  double worst_leapfrog = 0;
  double worst_fourth = 0;
  for (std::size_t r = 0; r < oracle.size(); ++r) {
    const auto row = oracle[r];
    if (row["lengths_positive"] != 1 || row["t_s"] > 1) continue;
    const auto n = static_cast<std::size_t>(row["n"]);
    const double l = row["rest_len"];
    std::vector<double> at{0};
    std::vector<double> speed{0};
    std::vector<double> mass{1};
    for (std::size_t i = 0; i < n; ++i) {
      at.push_back(static_cast<double>(i + 1) * l + row.list("u0")[i]);
      speed.push_back(row.list("v0")[i]);
      mass.push_back(row.list("m_kg")[i]);
    }
    Joined joined = on_a_line(at, speed, row["a_m"]);
    joined.scene.mass = Scalars(mass);
    joined.scene.fixed = {0};
    Springs springs{.pairs = {}, .stiffness = Scalars(row.list("k_N")), .rest_length = l};
    for (std::uint32_t i = 0; i < n; ++i) springs.pairs.push_back({i, i + 1});
    joined.scene.add(Network(springs));
    const std::vector<double> wanted = row.list("x_m");
    const auto error = [&](const Coupling& coupling) {
      const auto got = stepped<double>(with(joined, coupling), {.isa = best_isa()}, steps_in(row["t_s"], joined.step));
      double worst = 0;
      for (std::size_t i = 0; i < n; ++i) worst = std::max(worst, std::abs(x(got, i + 1, 0) - wanted[i]));
      return worst;
    };
    worst_leapfrog = std::max(worst_leapfrog, error({.scheme = Scheme::leapfrog, .substeps = 400}));
    worst_fourth = std::max(worst_fourth, error({.scheme = Scheme::fourth_order, .substeps = 100}));
  }
  MESSAGE("chains, worst error of a body: leapfrog, 400 sub-steps " << worst_leapfrog << " m, fourth_order, 100 "
                                                                    << worst_fourth << " m");
  CHECK(worst_leapfrog < 5e-5);
  CHECK(worst_fourth < 3e-7);
}

TEST_CASE("network: two bodies on a line follow their closed form; the filtered pulse does at any stiffness" *
          doctest::test_suite("long")) {
  const test::Oracle oracle("twobody1d.csv");
  double worst_exact = 0;
  double worst_filtered = 0;
  double worst_sequential = 0;
  for (std::size_t r = 0; r < oracle.size(); ++r) {
    const auto row = oracle[r];
    if (row["r_positive"] != 1 || row["c_Ns"] != 0) continue;
    Joined joined = on_a_line({row["x1_0"], row["x2_0"]}, {row["v1_0"], row["v2_0"]}, row["a_m"]);
    joined.scene.mass = Scalars(std::vector<double>{row["m1"], row["m2"]});
    joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = row["k_N"], .rest_length = Scalars(row["l_m"])}));
    const double scale = std::abs(row["x2_0"] - row["x1_0"]) + row["l_m"];
    const double omega = std::sqrt(row["k_N"] * (1 / row["m1"] + 1 / row["m2"]));
    const auto error = [&](const Coupling& coupling) {
      const auto got = stepped<double>(with(joined, coupling), {.isa = best_isa()}, steps_in(row["t_s"], joined.step));
      return std::max(std::abs(x(got, 0, 0) - row["x1"]), std::abs(x(got, 1, 0) - row["x2"])) / scale;
    };
    // Enough sub-steps that a pair with a nearly vanishing length does not pass through itself within a step.
    const int fine = std::max(20, static_cast<int>(omega / 60 / 0.05));
    worst_exact = std::max(worst_exact, error({.scheme = Scheme::accumulate, .substeps = fine, .method = Method::exact}));
    worst_filtered =
        std::max(worst_filtered, error({.scheme = Scheme::accumulate, .substeps = fine, .method = Method::combined}));
    worst_sequential = std::max(worst_sequential, error({.scheme = Scheme::sequential, .substeps = 10 * fine, .theta = 0.5}));
  }
  MESSAGE("two bodies, worst error over rest length and start: exact contributions "
          << worst_exact << ", filtered pulse " << worst_filtered << ", sequential " << worst_sequential);
  CHECK(worst_exact < 1e-9);
  CHECK(worst_filtered < 5e-4);
  CHECK(worst_sequential < 5e-3);
}

TEST_CASE("network: a spinning pair follows its path") {
  const test::Oracle oracle("twobody2d_spin.csv");
  double worst_midpoint = 0;
  double worst_start = 0;
  double worst_filtered = 0;
  double worst_leapfrog = 0;
  for (std::size_t r = 0; r < oracle.size(); ++r) {
    const auto row = oracle[r];
    Joined joined;
    joined.x = {{row["x1"], row["y1"], 0}, {row["x2"], row["y2"], 0}};
    joined.v = {{row["vx1"], row["vy1"], 0}, {row["vx2"], row["vy2"], 0}};
    joined.scene.mass = Scalars(std::vector<double>{row["m1"], row["m2"]});
    joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = row["k"], .rest_length = Scalars(row["l"])}));
    const auto error = [&](const Coupling& coupling) {
      const auto got = stepped<double>(with(joined, coupling), {.isa = best_isa()}, steps_in(row["t"], joined.step));
      return std::hypot(x(got, 0, 0) - row["X1"], x(got, 0, 1) - row["Y1"]);
    };
    Coupling sum{.scheme = Scheme::accumulate, .substeps = 1, .method = Method::exact};
    worst_midpoint = std::max(worst_midpoint, error(sum));
    sum.axis = PairAxis::start;
    worst_start = std::max(worst_start, error(sum));
    worst_filtered = std::max(worst_filtered, error({.scheme = Scheme::accumulate, .substeps = 1, .method = Method::combined}));
    worst_leapfrog = std::max(worst_leapfrog, error({.scheme = Scheme::leapfrog, .substeps = 1}));
  }
  MESSAGE("spinning pair at 60 Hz, one sub-step: axis at the midpoint "
          << worst_midpoint << " m, at the start " << worst_start << " m, filtered pulse " << worst_filtered << " m, leapfrog "
          << worst_leapfrog << " m");
  CHECK(worst_filtered < 1e-3);
  CHECK(worst_midpoint < 2e-3);
  CHECK(worst_start > 10 * worst_midpoint);
  CHECK(worst_leapfrog < 1e-2);
}

Joined oracle_cloth() {
  const test::Oracle nodes("cloth_init.csv");
  const test::Oracle springs("cloth_springs.csv");
  Joined joined;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    joined.x.push_back({nodes[i]["x"], nodes[i]["y"], nodes[i]["z"]});
    joined.v.push_back({});
    if (nodes[i]["inv_mass"] == 0) joined.scene.fixed.push_back(i);
  }
  joined.scene.mass = 0.3 / 256;
  joined.scene.add(Constant{.acceleration = {0, 0, -9.81}});
  Springs list;
  std::vector<double> k;
  std::vector<double> l;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    list.pairs.push_back({static_cast<std::uint32_t>(springs[s]["i"]), static_cast<std::uint32_t>(springs[s]["j"])});
    k.push_back(springs[s]["k_N"]);
    l.push_back(springs[s]["rest_len"]);
  }
  list.stiffness = Scalars(k);
  list.rest_length = Scalars(l);
  joined.scene.add(Network(list));
  joined.step = 1.0 / 60;
  return joined;
}

// Root mean square over the nodes, relative to the side of 1 m, at a time of the table.
double cloth_error(const std::vector<double>& got, double time) {
  const test::Oracle oracle("cloth_nodes.csv");
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t r = 0; r < oracle.size(); ++r) {
    const auto row = oracle[r];
    if (std::abs(row["t_s"] - time) > 1e-9) continue;
    const auto i = static_cast<std::size_t>(row["node"]);
    sum += std::pow(x(got, i, 0) - row["x"], 2) + std::pow(x(got, i, 1) - row["y"], 2) + std::pow(x(got, i, 2) - row["z"], 2);
    ++count;
  }
  REQUIRE(count == 256);
  return std::sqrt(sum / 256);
}

TEST_CASE("network: a hanging cloth follows the reference path") {
  const Joined cloth = oracle_cloth();
  const auto error = [&](const Coupling& coupling) {
    return cloth_error(stepped<double>(with(cloth, coupling), {.isa = best_isa()}, 30), 0.5);
  };
  const double leapfrog = error({.scheme = Scheme::leapfrog});
  const double fourth = error({.scheme = Scheme::fourth_order, .substeps = 22});
  const double sequential = error({.scheme = Scheme::sequential, .substeps = 32, .theta = 0.5});
  const double float32 =
      cloth_error(as_double(stepped<float>(with(cloth, {.scheme = Scheme::leapfrog}), {.isa = best_isa()}, 30)), 0.5);
  MESSAGE("cloth at 0.5 s: leapfrog, auto " << leapfrog << ", float32 " << float32 << ", fourth_order, 22 " << fourth
                                            << ", sequential, 32 symmetric " << sequential);
  CHECK(leapfrog < 2e-4);
  CHECK(float32 < 2e-4);
  CHECK(fourth < 1e-6);
  CHECK(sequential < 1e-3);
}

}  // namespace networks::closed_form_test
