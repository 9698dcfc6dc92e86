// Damping along springs in leapfrog and fourth_order: orders, limits of sub-steps, and conserved quantities.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "springs/frequencies.hpp"
#include "support/close.hpp"

namespace damping_test {

using namespace dvdx;
using test::is_close;
using test::Joined;
using test::Run;
using test::stepped;

constexpr Coupling leapfrog{.scheme = Scheme::leapfrog};
constexpr Coupling fourth_order{.scheme = Scheme::fourth_order};
constexpr Coupling accumulate{.scheme = Scheme::accumulate};

Joined with(Joined joined, Coupling coupling, int substeps) {
  joined.scene.coupling = coupling;
  joined.scene.coupling.substeps = substeps;
  return joined;
}

// ---- orders ------------------------------------------------------------------------------------------------------------

enum class Besides { nothing, drag_and_anchors };

// 12 x 12 particles, 0.8 m and 0.2 kg, flat and at rest, held by two corners.
Joined cloth(double damping, Besides besides) {
  constexpr std::size_t side = 12;
  Joined joined;
  for (std::size_t i = 0; i < side * side; ++i) {
    joined.x.push_back({0.8 * static_cast<double>(i % side) / (side - 1), 0, 0.8 * static_cast<double>(i / side) / (side - 1)});
    joined.v.push_back({});
  }
  joined.step = 0.02;
  joined.scene.mass = 0.2 / (side * side);
  joined.scene.fixed = {0, side - 1};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Network(Grid{.rows = side,
                                .columns = side,
                                .edge_u = {0.8, 0, 0},
                                .edge_v = {0, 0, 0.8},
                                .structural = 2000,
                                .shear = 1000,
                                .bend = 200,
                                .damping = damping}));
  if (besides == Besides::nothing) return joined;
  const double mass = joined.scene.mass[0];
  joined.scene.add(Drag{.coefficient = 0.5 * mass});
  joined.scene.add(Spring{.stiffness = 400 * mass, .anchor = at_start});
  return joined;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (i % 6 < 3) sum += (a[i] - b[i]) * (a[i] - b[i]);  // positions
  }
  return std::sqrt(sum);
}

// The order that follows from the differences made by two halvings of the sub-step.
double measured_order(const Joined& joined, const Coupling& coupling, int substeps) {
  const auto end = [&](int n) { return stepped<double>(with(joined, coupling, n), {.isa = best_isa()}, 8); };
  const std::vector<double> middle = end(2 * substeps);
  return std::log2(difference(end(substeps), middle) / difference(middle, end(4 * substeps)));
}

TEST_CASE("damping: leapfrog is of second order and fourth_order of fourth, however strong the damping" *
          doctest::test_suite("long")) {
  struct Tried {
    double damping;  // kg/s
    int leapfrog, fourth_order;
  };
  for (const Tried& tried : {Tried{0.02, 160, 40}, {0.2, 160, 40}, {1, 640, 160}}) {
    const auto [damping, of_leapfrog, of_fourth] = tried;
    for (const Besides besides : {Besides::nothing, Besides::drag_and_anchors}) {
      CAPTURE(tried.damping);
      CAPTURE(static_cast<int>(besides));
      const Joined joined = cloth(damping, besides);
      CHECK(std::abs(measured_order(joined, leapfrog, of_leapfrog) - 2) <= 0.1);
      CHECK(std::abs(measured_order(joined, fourth_order, of_fourth) - 4) <= 0.2);
    }
  }
}

// ---- limits ------------------------------------------------------------------------------------------------------------

// Two modes with symmetric K and C and given eigenvalues; the axes of C are rotated against those of K by an angle.
struct TwoModes {
  std::array<double, 2> z{}, q{};  // frequency and rate of damping times the sub-step
  double angle = 0;
};

using Matrix = std::array<std::array<double, 4>, 4>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t j = 0; j < 4; ++j) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

// The matrix of a sub-step on (x, v), column by column, directly from the scheme's definition.
Matrix substep_of(const TwoModes& m, const Coupling& coupling) {
  const double c = std::cos(m.angle);
  const double s = std::sin(m.angle);
  const double C[2][2] = {{c * c * m.q[0] + s * s * m.q[1], c * s * (m.q[0] - m.q[1])},
                          {c * s * (m.q[0] - m.q[1]), s * s * m.q[0] + c * c * m.q[1]}};
  const Splitting splitting = dvdx::splitting(coupling);
  Matrix step{};
  for (std::size_t column = 0; column < 4; ++column) {
    std::array<double, 4> y{};
    y[column] = 1;
    const auto flow = [&](double a) {
      for (std::size_t i = 0; i < 2; ++i) y[i] += a * y[i + 2];
    };
    const auto damped = [&](const std::array<double, 2>& u) {
      return std::array{-(C[0][0] * u[0] + C[0][1] * u[1]), -(C[1][0] * u[0] + C[1][1] * u[1])};
    };
    for (std::size_t k = 0; k < splitting.b.size(); ++k) {
      flow(splitting.a[k]);
      const double b = splitting.b[k];
      std::array<double, 2> a0 = damped({y[2], y[3]});
      for (std::size_t i = 0; i < 2; ++i) a0[i] -= m.z[i] * m.z[i] * y[i];
      const std::array<double, 2> a1 = damped(a0);
      const std::array<double, 2> a2 = damped(a1);
      const double beta = splitting.beta.empty() ? 0 : splitting.beta[k];
      for (std::size_t i = 0; i < 2; ++i) y[i + 2] += b * a0[i] + b * b / 2 * a1[i] + beta * a2[i];
    }
    flow(splitting.a.back());
    for (std::size_t row = 0; row < 4; ++row) step[row][column] = y[row];
  }
  return step;
}

// The logarithm of the spectral radius, from the growth over 2^20 sub-steps. Growth proportional to their number appears as
// 1e-5.
double growth(Matrix step) {
  constexpr int doublings = 20;
  double logarithm = 0;  // logarithm of the norm divided out
  for (int n = 0; n < doublings; ++n) {
    step = product(step, step);
    double norm = 0;
    for (const auto& row : step) {
      for (const double value : row) norm = std::max(norm, std::abs(value));
    }
    if (norm == 0) return -std::numeric_limits<double>::infinity();
    for (auto& row : step) {
      for (double& value : row) value /= norm;
    }
    logarithm = 2 * logarithm + std::log(norm);
  }
  return logarithm / std::pow(2.0, doublings);
}

constexpr double sees = 3e-5;

TEST_CASE("damping: nothing grows within the limits, whichever modes have the highest frequency and the strongest damping") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    CAPTURE(static_cast<int>(coupling.scheme));
    const StableRange range = scheme_limit(coupling);
    double worst = -1;
    for (int z = 0; z <= 12; ++z) {
      for (int q = 0; q <= 12; ++q) {
        const double most_z = range.frequency * (z < 12 ? z / 12.0 : 1 - 1e-3);
        const double most_q = range.damping * q / 12;
        for (const double angle : {0.0, 0.2, 0.4, 0.785, 1.1, 1.57}) {
          for (const double other_z : {0.0, 0.4, 1.0}) {
            for (const double other_q : {0.0, 0.3, 0.8}) {
              const TwoModes modes{{most_z, other_z * most_z}, {most_q, other_q * most_q}, angle};
              worst = std::max(worst, growth(substep_of(modes, coupling)));
            }
          }
        }
      }
    }
    CHECK(worst <= sees);
  }
}

TEST_CASE("damping: beyond each limit something grows") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    CAPTURE(static_cast<int>(coupling.scheme));
    const StableRange range = scheme_limit(coupling);
    CHECK(growth(substep_of({{1.005 * range.frequency, 0}, {0, 0}, 0}, coupling)) > sees);
  }
  CHECK(growth(substep_of({{0, 0}, {2.02, 0}, 0}, leapfrog)) > sees);
  // A single mode of fourth_order may have a damping of 8. Two modes across each other have a lower limit, which the plan uses.
  CHECK(growth(substep_of({{3.13, 0}, {7.9, 0}, 0}, fourth_order)) <= sees);
  double worst = 0;
  for (double angle = 0; angle < 1.6; angle += 0.02) {
    worst = std::max(worst, growth(substep_of({{3.13, 0.3}, {7.2, 0}, angle}, fourth_order)));
  }
  CHECK(worst > sees);
}

TEST_CASE("damping: sub-steps are the larger of what the frequency and the damping ask for") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    const StableRange range = scheme_limit(coupling);
    CHECK(range.damping == (coupling.scheme == Scheme::leapfrog ? 2 : 6));
    for (const double z : {0.5, 3.0, 17.0}) {
      for (const double q : {0.0, 2.9, 40.0}) {
        const double n = std::max({1.0, std::ceil(z / range.frequency - 1e-9), std::ceil(q / range.damping - 1e-9)});
        CHECK(substeps_for(range, 0.1, {z / 0.1, q / 0.1}) == n);
        CHECK(limited_by(range, 0.1, {z / 0.1, q / 0.1}) ==
              (q / range.damping > z / range.frequency ? LimitedBy::damping : LimitedBy::frequency));
      }
    }
  }
}

TEST_CASE("damping: with automatic sub-steps the strongest damped mode loses at least a quarter of its speed in each") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    const double most = bounded_energy_limit(coupling).damping;
    for (const double q : {0.6 * most, 0.9 * most, most}) {
      const Matrix step = substep_of({{0, 0}, {q, 0}, 0}, coupling);
      CHECK(std::abs(step[2][2]) <= 0.75 * (1 + 1e-12));
    }
  }
}

TEST_CASE("damping: the limit of accumulate is where a pulse reverses the most damped speed") {
  const StableRange range = scheme_limit(accumulate);
  for (const double q : {2.9, 40.0}) CHECK(substeps_for(range, 0.1, {0, q / 0.1}) == std::ceil(q / 2));
}

// A pair of 1 kg each on the x axis, at rest length, that flies apart.
Joined pair_of(double k, double damping) {
  Joined pair;
  pair.x = {{0, 0, 0}, {2, 0, 0}};
  pair.v = {{0, 0, 0}, {3, 0, 0}};
  pair.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = k, .rest_length = 2.0, .damping = damping}));
  return pair;
}

NetworkLimit limit_of(const Joined& joined) {
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  return *test::plan_of(joined, {}, batch.view()).network_limit();
}

std::string refusal_of(const Joined& joined) {
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = compile<double>(joined.scene, {.step = joined.step}, batch.view());
  return plan ? "" : plan.error().message();
}

TEST_CASE("damping: the plan's rate is that of a pair, of a row, and of a sheet in any position") {
  CHECK(is_close(limit_of(pair_of(10, 500)).damping, 1000, 1e-12));  // c (1/m + 1/m)
  CHECK(limit_of(pair_of(10, 0)).damping == 0);
  CHECK(limit_of(pair_of(10, 500)).damping_limit == 2);
  // A row of n masses: the largest eigenvalue of its springs' matrix is 2 - 2 cos(pi (n-1)/n).
  Joined row;
  Springs springs{.pairs = {}, .stiffness = 100.0, .damping = 7};
  constexpr std::uint32_t n = 12;
  for (std::uint32_t i = 0; i < n; ++i) {
    row.x.push_back({static_cast<double>(i), 0, 0});
    row.v.push_back({});
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  row.scene.add(Network(springs));
  const double largest = 7 * (2 - 2 * std::cos(std::acos(-1.0) * (n - 1) / n));
  CHECK(limit_of(row).damping >= largest * (1 - 1e-9));
  CHECK(limit_of(row).damping <= largest * 1.021);
  // The grid and the list of its springs, whose rates are bounded in different ways.
  const Joined sheet = test::sheet(9, 14, 50, 0.01);
  CHECK(is_close(limit_of(sheet).damping, limit_of(test::as_list(sheet)).damping, 0.1));
}

TEST_CASE("damping: too few sub-steps are refused, and the message says whether frequency or damping asks for more") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    const double takes = coupling.scheme == Scheme::leapfrog ? 2 : 6;
    const auto fewest = static_cast<int>(std::ceil(1000.0 / 60 / takes));
    CHECK(refusal_of(with(pair_of(10, 500), coupling, fewest)).empty());
    const std::string refused = refusal_of(with(pair_of(10, 500), coupling, fewest - 1));
    CHECK(refused.starts_with("coupling.substeps is " + std::to_string(fewest - 1) + ": must be at least " +
                              std::to_string(fewest)));
    CHECK(refused.find("unstable by their damping") != std::string::npos);
    CHECK(refusal_of(with(pair_of(1e6, 500), coupling, 1)).find("unstable by their frequency") != std::string::npos);
  }
}

TEST_CASE("damping: with the fewest sub-steps a strongly damped pair does not grow, with those of auto it comes to rest") {
  for (const Coupling& coupling : {leapfrog, fourth_order, accumulate}) {
    Joined pair = pair_of(1e-6, 1000);
    pair.scene.coupling = coupling;
    const NetworkLimit limit = limit_of(pair);
    const auto apart = [&](const Joined& joined) {
      const auto after = stepped<double>(joined, {}, 60);
      CHECK(std::abs(after[3] + after[9] - 3) < 1e-12);  // momentum
      return std::abs(after[9] - after[3]);
    };
    CHECK(apart(with(pair, coupling, limit.fewest)) <= 3);
    CHECK(apart(pair) < 1e-9);
  }
}

// ---- conserved quantities ----------------------------------------------------------------------------------------------

TEST_CASE("damping: a free sheet keeps its momentum, and the damped part of its springs takes energy") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    for (const bool is_list : {false, true}) {
      Joined sheet = test::sheet(8, 11, 50, 0.002);
      if (is_list) sheet = test::as_list(sheet);
      sheet.scene.forces.clear();
      sheet.scene.fixed.clear();
      const auto momentum = [](const std::vector<double>& values, std::size_t axis) {
        double sum = 0;
        for (std::size_t i = 3 + axis; i < values.size(); i += 6) sum += values[i];
        return sum;
      };
      const Joined joined = with(sheet, coupling, 30);
      const auto before = stepped<double>(joined, {.isa = best_isa()}, 0);
      const auto after = stepped<double>(joined, {.isa = best_isa()}, 60);
      for (std::size_t axis = 0; axis < 3; ++axis) CHECK(std::abs(momentum(after, axis) - momentum(before, axis)) < 1e-12);
    }
  }
}

// A grid of springs as a list, and three springs between its corners.
Joined two_networks(double damping_of_grid, double damping_of_rope) {
  Joined joined = test::sheet(6, 9, 50, damping_of_grid);
  joined.scene.add(Network(
      Springs{.pairs = {{0, 8}, {8, 45}, {45, 53}}, .stiffness = 20.0, .rest_length = 0.9, .damping = damping_of_rope}));
  return joined;
}

TEST_CASE("damping: either of two networks may be damped alone, and the order stays the scheme's") {
  for (const auto& both : {std::pair{0.0, 0.02}, {0.002, 0.0}, {0.002, 0.02}}) {
    const auto [grid, rope] = both;
    CAPTURE(both.first);
    CHECK(std::abs(measured_order(two_networks(grid, rope), leapfrog, 80) - 2) <= 0.1);
    CHECK(std::abs(measured_order(two_networks(grid, rope), fourth_order, 40) - 4) <= 0.2);
  }
}

TEST_CASE("damping: an undamped network beside a damped one has the bits of one with negligible damping") {
  // A damping of 1e-300 kg/s leaves nothing in any sum, but all springs take part in the damping passes.
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    const Joined alone = with(two_networks(0, 0.02), coupling, 30);
    const Joined both = with(two_networks(1e-300, 0.02), coupling, 30);
    CHECK(test::difference(stepped<double>(alone, {.isa = best_isa()}, 3), stepped<double>(both, {.isa = best_isa()}, 3)) ==
          "");
  }
}

TEST_CASE("damping: an undamped network asks for no memory that damping needs") {
  const auto bytes = [](const Coupling& coupling, double damping) {
    const Joined joined = with(test::sheet(20, 20, 50, damping), coupling, 30);
    test::Batch<double> batch(test::Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    return test::plan_of(joined, {}, batch.view()).workspace().bytes();
  };
  const std::size_t plain = bytes(leapfrog, 0);
  CHECK(bytes(fourth_order, 0) == plain);
  const std::size_t columns = bytes(leapfrog, 0.001) - plain;
  CHECK(columns >= 3 * 20 * 32 * sizeof(double));  // a row takes 32 elements
  CHECK(bytes(fourth_order, 0.001) - plain == 2 * columns);
}

TEST_CASE_TEMPLATE("damping: neighbours of a particle with a bad velocity go on as if its springs were cut, bit by bit", T,
                   float, double) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  constexpr std::uint32_t bad = 17;
  Joined joined = test::as_list(test::sheet(6, 9, 50, 0.002));
  Joined cut = joined;
  const auto& springs = std::get<Springs>(joined.scene.networks[0]);
  Springs left{.pairs = {}, .stiffness = 0.0, .rest_length = std::nullopt, .damping = springs.damping};
  std::vector<double> k;
  std::vector<double> l;
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    if (springs.pairs[s][0] == bad || springs.pairs[s][1] == bad) continue;
    left.pairs.push_back(springs.pairs[s]);
    k.push_back(springs.stiffness[s]);
    l.push_back((*springs.rest_length)[s]);
  }
  left.stiffness = Scalars(k);
  left.rest_length = Scalars(l);
  cut.scene.networks = {left};
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    for (const Isa isa : available_isas()) {
      const std::vector<T> wanted = stepped<T>(with(cut, coupling, 12), {.isa = isa}, 4);
      for (const double value : {std::numeric_limits<double>::quiet_NaN(), infinite, -infinite}) {
        Joined ill = joined;
        ill.v[bad][1] = value;
        std::vector<T> got = stepped<T>(with(ill, coupling, 12), {.isa = isa}, 4);
        std::copy_n(wanted.begin() + 6 * bad, 6, got.begin() + 6 * bad);
        const std::string difference = test::difference(wanted, got);
        CHECK_MESSAGE(difference.empty(),
                      "scheme " << static_cast<int>(coupling.scheme) << ", " << name(isa) << ": " << difference);
      }
    }
  }
}

}  // namespace damping_test
