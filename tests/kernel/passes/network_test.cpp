// Springs between particles: closed forms, orders, what must be kept, and the scalar twins' bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "plan/joints.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/oracle.hpp"

namespace network_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Joined;
using test::Layout;
using test::plan_of;
using test::Run;
using test::stepped;

// Position and velocity of a particle.
double x(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + axis]; }
double v(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + 3 + axis]; }

std::vector<double> as_double(const std::vector<float>& values) { return {values.begin(), values.end()}; }

double difference_rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i += 6) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum += (a[i + axis] - b[i + axis]) * (a[i + axis] - b[i + axis]);
  }
  return std::sqrt(sum / static_cast<double>(a.size() / 6));
}

Joined with(Joined joined, const Coupling& coupling) {
  joined.scene.coupling = coupling;
  return joined;
}

constexpr std::array all_schemes = {
    Coupling{.scheme = Scheme::leapfrog},
    Coupling{.scheme = Scheme::fourth_order},
    Coupling{.scheme = Scheme::sequential, .substeps = 3},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.5},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.55},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 1, .sweeps = SweepOrder::forward},
    Coupling{.scheme = Scheme::accumulate, .method = Method::exact},
    Coupling{.scheme = Scheme::accumulate, .method = Method::pulse, .axis = PairAxis::start},
    Coupling{.scheme = Scheme::accumulate, .method = Method::combined},
};

// A damped sheet whose rows and columns are joined by springs of stiffness 0, which are none, or of one that is 0 in float32.
Joined damped_diagonals(double structural) {
  Joined sheet = test::sheet(9, 20, 50, 0.02);
  auto& grid = std::get<Grid>(sheet.scene.networks[0]);
  grid.structural = structural;
  grid.shear = 20;
  sheet.name += ", structural " + std::to_string(structural * 1e60) + "e-60";
  return sheet;
}

// Every way in which springs lie: one register, several, a border in each place, wider than a stripe, neighbours at two,
// damping, masses and springs of their own, neighbours anywhere.
std::vector<Joined> bit_scenes() {
  std::vector<Joined> scenes;
  for (const auto& [rows, columns] : {std::pair{2U, 2U}, {3U, 5U}, {17U, 33U}, {3U, 300U}}) {
    scenes.push_back(test::sheet(rows, columns, 50));
  }
  scenes.push_back(test::sheet(9, 20, 50, 0.001));
  Joined bent = test::sheet(10, 23, 50, 0.001);
  std::get<Grid>(bent.scene.networks[0]).bend = 5;
  bent.name += ", bent";
  scenes.push_back(bent);
  Joined only_rows = test::sheet(6, 18, 50);
  std::get<Grid>(only_rows.scene.networks[0]).shear = 0;
  only_rows.name += ", without shear";
  scenes.push_back(only_rows);
  for (std::size_t s = 0, grids = scenes.size(); s < grids; ++s) scenes.push_back(test::as_list(scenes[s]));
  for (const double damping : {0.0, 0.001})
    scenes.push_back(test::with_spring_across(test::as_list(test::sheet(9, 33, 50, damping))));

  Joined heavy = test::sheet(7, 19, 50);
  std::vector<double> masses;
  for (std::size_t i = 0; i < heavy.x.size(); ++i) masses.push_back(0.002 * (1.5 + test::scatter(i, 6)));
  heavy.scene.mass = Scalars(masses);
  heavy.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 2}});
  heavy.scene.add(Sinusoid{.acceleration = {0, 0, 3}, .angular_frequency = 5});
  heavy.name += ", masses each, wind and a gust";
  scenes.push_back(heavy);

  for (const double structural : {0.0, 1e-60}) scenes.push_back(damped_diagonals(structural));

  Joined anywhere = test::sheet(6, 20, 50);
  Springs springs{.pairs = {}, .stiffness = 30.0, .rest_length = std::nullopt, .damping = 0.0005};
  for (std::uint32_t s = 0; s < 300; ++s) {
    const auto i = static_cast<std::uint32_t>(59.5 * (1 + test::scatter(s, 0)));
    const auto j = static_cast<std::uint32_t>(59.5 * (1 + test::scatter(s, 1)));
    if (i != j) springs.pairs.push_back({i, j});
  }
  anywhere.scene.networks = {springs};
  anywhere.name = "neighbours anywhere";
  scenes.push_back(anywhere);

  std::vector<double> lengths;
  for (std::size_t n = 0; n < springs.pairs.size(); ++n) lengths.push_back(n % 3 == 0 ? 0 : 0.3);
  springs.rest_length = Scalars(lengths);
  springs.damping = 0;
  anywhere.scene.networks = {springs};
  anywhere.name = "neighbours anywhere, a third of them without rest length";
  scenes.push_back(anywhere);
  return scenes;
}

bool is_possible(const Joined& joined, const Coupling& coupling) {
  return coupling.scheme != Scheme::accumulate || joined.scene.contacts.empty();
}

template <class T>
void check_bits(const Joined& joined, Arithmetic arithmetic) {
  const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 2);
  std::size_t turn = 0;
  for (const Isa isa : available_isas(arithmetic)) {
    const Run run{.isa = isa, .arithmetic = arithmetic, .layout = test::layouts[turn++ % test::layouts.size()]};
    const std::string difference = test::difference(wanted, stepped<T>(joined, run, 2));
    CHECK_MESSAGE(difference.empty(), joined.name << ", scheme " << static_cast<int>(joined.scene.coupling.scheme) << ", "
                                                  << 8 * sizeof(T) << " bits, " << std::string(name(isa)) << ": "
                                                  << difference);
  }
}

// Each scene in every scheme, and both in each kind of number.
TEST_CASE("network: every ISA and layout gives the scalar reference's bits, in every scheme") {
  std::size_t first = 0;
  for (const Joined& joined : bit_scenes()) {
    std::size_t turn = first++;
    for (const Coupling& coupling : all_schemes) {
      const std::size_t kind = turn++ % 3;
      if (!is_possible(joined, coupling)) continue;
      const Joined scene = with(joined, coupling);
      if (kind == 0) check_bits<float>(scene, Arithmetic::separate);
      if (kind == 1) check_bits<double>(scene, Arithmetic::separate);
      if (kind == 2) check_bits<float>(scene, Arithmetic::contracted);
    }
  }
}

// Where a row fills its registers no padding lies beyond it: what a spring that leads out of the grid reads is the next row.
TEST_CASE("network: no spring leads beyond the last column of a grid whose rows fill their registers") {
  for (const std::size_t columns : {16U, 32U}) {
    Joined bent = with(test::sheet(4, columns, 50, 0.001), {.scheme = Scheme::leapfrog});
    std::get<Grid>(bent.scene.networks[0]).bend = 5;
    check_bits<float>(bent, Arithmetic::separate);
    check_bits<double>(bent, Arithmetic::separate);
    check_bits<double>(bent, Arithmetic::contracted);
  }
}

// A row has one direction that springs act along, and as many motions that stretch none of them as there are particles.
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

TEST_CASE(
    "network: a spring without rest length pulls its turning ends as two harmonic oscillators, beside others along lines") {
  Joined joined;
  joined.x = {{-0.5, 0, 0}, {0.5, 0, 0}, {10, 0, 0}, {12, 0, 0}};
  joined.v = {{0, -7, 0}, {0, 7, 0}, {-0.1, 0, 0}, {0.1, 0, 0}};
  joined.step = 1.0 / 60;
  constexpr double k = 5000;  // N/m, Omega = 100 rad/s of masses of 1 kg
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

TEST_CASE("network: contacts in every flow give the scalar reference's bits") {
  Joined joined = test::sheet(9, 17, 50);
  joined.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.005, .restitution = 0.2, .friction = 0.3});
  joined.scene.add(Sphere{.center = {0.5, -0.2, 0.5}, .radius = 0.205});
  joined.name += " on a plane and a sphere";
  for (const Coupling& coupling : all_schemes) {
    if (coupling.scheme == Scheme::accumulate) continue;
    check_bits<float>(with(joined, coupling), Arithmetic::separate);
    check_bits<double>(with(joined, coupling), Arithmetic::separate);
  }
}

TEST_CASE("network: any number of threads gives the same bits, many particles" * doctest::test_suite("threads")) {
  Joined joined = test::sheet(110, 150, 5, 0.0001);
  REQUIRE(joined.x.size() >= parallel_from);
  joined.step = 1.0 / 2000;
  std::size_t turn = 0;  // each scheme meets one count of threads in the grid, the other in the list
  for (const Joined& scene : {joined, test::as_list(joined)}) {
    for (const Coupling& coupling : all_schemes) {
      const Joined coupled = with(scene, coupling);
      const auto plan = plan_of<float>(coupled, {.isa = best_isa()});
      const auto end_by = [&](std::size_t threads) { return stepped(coupled, plan, {.threads = threads}, 1); };
      const std::size_t threads = turn++ % 2 == 0 ? 2 : 5;
      const std::string difference = test::difference(end_by(1), end_by(threads));
      CHECK_MESSAGE(difference.empty(), coupled.name << ", scheme " << static_cast<int>(coupling.scheme) << ", threads "
                                                     << threads << ": " << difference);
    }
  }
}

TEST_CASE("network: a grid and the list of its springs give the same bits where particles sum their springs") {
  // A list whose own order is far from its neighbours' is stepped in another one: there the sums' order differs (3 x 300).
  for (const Joined& joined : {test::sheet(17, 33, 50), test::sheet(9, 20, 50, 0.001), test::sheet(60, 140, 5),
                               damped_diagonals(0), damped_diagonals(1e-60)}) {
    for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
      const Joined grid = with(joined, {.scheme = scheme, .substeps = 40});
      const Run run{.isa = best_isa()};
      CHECK(test::difference(stepped<float>(grid, run, 3), stepped<float>(test::as_list(grid), run, 3)) == "");
      CHECK(test::difference(stepped<double>(grid, run, 3), stepped<double>(test::as_list(grid), run, 3)) == "");
    }
  }
}

TEST_CASE("network: each of two sheets that differ moves as it does alone") {
  const Joined one = with(test::sheet(9, 33, 50), {.scheme = Scheme::leapfrog, .substeps = 40});
  for (int difference = 0; difference < 3; ++difference) {
    CAPTURE(difference);
    Joined other = one;
    Grid& grid = std::get<Grid>(other.scene.networks[0]);
    if (difference == 0) grid.structural = 20;
    if (difference == 1) grid.edge_v = {0, 0, 1.1};
    if (difference == 2) grid.bend = 3;
    Joined both = one;
    const std::size_t each = one.x.size();
    both.scene.networks.push_back(other.scene.networks[0]);
    std::get<Grid>(both.scene.networks[1]).first = each;
    for (const std::size_t i : other.scene.fixed) both.scene.fixed.push_back(each + i);
    both.x.insert(both.x.end(), other.x.begin(), other.x.end());
    both.v.insert(both.v.end(), other.v.begin(), other.v.end());
    auto wanted = stepped<double>(one, {.isa = best_isa()}, 3);
    const auto second = stepped<double>(other, {.isa = best_isa()}, 3);
    wanted.insert(wanted.end(), second.begin(), second.end());
    CHECK(test::difference(wanted, stepped<double>(both, {.isa = best_isa()}, 3)) == "");
  }
}

constexpr std::size_t sheets_in_a_row = 60, torn_sheet = 31;
constexpr std::size_t rows_of_each = 9, columns_of_each = 33, particles_of_each = rows_of_each * columns_of_each;

// Some of the sheets, from one of them on. The particle at a seam is bad: torn springs must not lead from it to the sheet behind.
Joined sheets_from(std::size_t first, std::size_t count, Scheme scheme, double damping) {
  constexpr std::size_t each = particles_of_each;
  Grid grid{.rows = rows_of_each,
            .columns = columns_of_each,
            .edge_u = {1.6, 0, 0},
            .edge_v = {0, 0, 0.4},
            .structural = 12,
            .shear = 5,
            .bend = 0.7};
  grid.damping = damping;
  const auto place_of = [&](std::size_t n, std::size_t i) {
    const std::size_t k = each * n + i;
    const Vec3 x{0.05 * static_cast<double>(i % columns_of_each), 0.3 + 0.02 * test::scatter(k, 0),
                 0.05 * static_cast<double>(i / columns_of_each)};
    return n == torn_sheet - 1 && i == each - 7 ? Vec3{std::nan(""), x[1], x[2]} : x;
  };
  Joined joined;
  joined.name = "sheets";
  joined.scene.mass = 0.001;
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.2, .friction = 0.3});
  joined.scene.coupling.scheme = scheme;
  joined.scene.coupling.substeps = 3;
  for (std::size_t n = first; n < first + count; ++n) {
    grid.first = (n - first) * each;
    const auto at = static_cast<std::uint32_t>(grid.first);
    grid.broken.clear();
    if (n == torn_sheet) grid.broken = {{at + 40, at + 41}, {at + 1, at + 34}};
    joined.scene.networks.emplace_back(grid);
    joined.scene.fixed.push_back(grid.first + columns_of_each - 1);
    for (std::size_t i = 0; i < each; ++i) {
      joined.x.push_back(place_of(n, i));
      joined.v.push_back({0, test::scatter(each * n + i, 1), 0});
    }
  }
  return joined;
}

TEST_CASE("network: sheets of one plan, one after the other, have the bits of a plan each") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
    for (const double damping : {0.0, 0.01}) {
      const auto values = stepped<float>(sheets_from(0, sheets_in_a_row, scheme, damping), {.isa = best_isa()}, 1);
      for (const std::size_t n : {std::size_t{0}, torn_sheet, torn_sheet + 1, sheets_in_a_row - 1}) {
        CAPTURE(n);
        const auto alone = stepped<float>(sheets_from(n, 1, scheme, damping), {.isa = best_isa()}, 1);
        const auto at = values.begin() + static_cast<std::ptrdiff_t>(6 * particles_of_each * n);
        CHECK(test::difference(alone, {at, at + 6 * particles_of_each}) == "");
      }
    }
  }
}

TEST_CASE("network: sheets of one plan have the same bits on any number of threads" * doctest::test_suite("threads")) {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
    for (const double damping : {0.0, 0.01}) {
      const Joined all = sheets_from(0, sheets_in_a_row, scheme, damping);
      const auto plan = plan_of<float>(all, {.isa = best_isa()});
      const std::size_t threads = damping == 0 ? 2 : 3;
      CHECK(test::difference(stepped(all, plan, {}, 1), stepped(all, plan, {.threads = threads}, 1)) == "");
    }
  }
}

// Larger than a cache, where several pulses are taken at once; a double takes twice the room.
Joined large_grid(std::size_t rows, const Coupling& coupling) {
  Joined joined = test::sheet(rows, 96, 5);
  joined.step = 1.0 / 960;
  std::get<Grid>(joined.scene.networks[0]).bend = 1;
  joined.scene.add(Sinusoid{.acceleration = {3, 0, 1}, .angular_frequency = 7});
  joined.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.005, .restitution = 0.2, .friction = 0.3});
  joined.scene.fixed.push_back(rows / 2 * 96 + 5);
  return with(joined, coupling);
}
Joined large_grid_of_floats() { return large_grid(400, {.scheme = Scheme::leapfrog, .substeps = 3}); }
Joined large_grid_of_doubles() { return large_grid(210, {.scheme = Scheme::fourth_order, .substeps = 2}); }

TEST_CASE("network: a grid larger than a cache takes several pulses at once, and gives the bits of its list") {
  const Run run{.isa = best_isa()};
  const Joined floats = large_grid_of_floats();
  CHECK(test::difference(stepped<float>(test::as_list(floats), run, 1), stepped<float>(floats, run, 1)) == "");
  const Joined doubles = large_grid_of_doubles();
  CHECK(test::difference(stepped<double>(test::as_list(doubles), run, 1), stepped<double>(doubles, run, 1)) == "");
}

TEST_CASE("network: a grid larger than a cache has the same bits on any number of threads" * doctest::test_suite("threads")) {
  const Joined floats = large_grid_of_floats();
  const auto plan = plan_of<float>(floats, {.isa = best_isa()});
  CHECK(test::difference(stepped(floats, plan, {}, 1), stepped(floats, plan, {.threads = 3}, 1)) == "");
  const Joined doubles = large_grid_of_doubles();
  const auto plan_of_doubles = plan_of<double>(doubles, {.isa = best_isa()});
  CHECK(test::difference(stepped(doubles, plan_of_doubles, {}, 1), stepped(doubles, plan_of_doubles, {.threads = 3}, 1)) == "");
}

TEST_CASE("network: a grid whose edges are not at right angles has two kinds of diagonals, as the list of its springs has") {
  Joined skewed = test::sheet(7, 19, 50);
  std::get<Grid>(skewed.scene.networks[0]).edge_v = {0.4, 0, 1};
  for (std::size_t i = 0; i < skewed.x.size(); ++i) skewed.x[i][0] += 0.4 * skewed.x[i][2];
  const Joined grid = with(skewed, {.scheme = Scheme::leapfrog, .substeps = 40});
  for (const Isa isa : {Isa::reference, best_isa()}) {
    const Run run{.isa = isa};
    CHECK(test::difference(stepped<double>(grid, run, 3), stepped<double>(test::as_list(grid), run, 3)) == "");
  }
}

TEST_CASE("network: one call of five steps is five calls of one") {
  for (const Coupling& coupling : all_schemes) {
    Joined joined = with(test::sheet(9, 20, 50, 0.001), coupling);
    joined.scene.add(Sinusoid{.acceleration = {0, 0, 3}, .angular_frequency = 5});
    Batch<float> batch(Layout::aos, joined.x.size());
    test::place(joined, batch.view());
    const Plan<float> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
    for (int step = 0; step < 5; ++step) REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
    CHECK(test::difference(stepped<float>(joined, {.isa = best_isa()}, 5), test::values_of(batch.view())) == "");
  }
}

// ---- closed forms ------------------------------------------------------------------------------------------------------

// Bodies on the x axis.
Joined on_a_line(const std::vector<double>& at, const std::vector<double>& speed, double acceleration) {
  Joined joined;
  for (std::size_t i = 0; i < at.size(); ++i) {
    joined.x.push_back({at[i], 0, 0});
    joined.v.push_back({speed[i], 0, 0});
  }
  joined.scene.add(Constant{.acceleration = {acceleration, 0, 0}});
  return joined;
}

std::size_t steps_in(double time, double step) { return static_cast<std::size_t>(std::lround(time / step)); }

// e is how far the pair is drawn, u = de/dt, with W and g of both masses: a = -W (e + h u + h^2 a) - g (u + h a), h = theta s.
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

// Springs without stiffness only take speed away, a pair as if it were alone: u' = -g u along it.
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
    // Enough that a pair whose length nearly vanishes is not carried through itself within a step.
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

// ---- orders, and what must be kept -------------------------------------------------------------------------------------

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

// One step from rest at theta = 1/2 makes velocities of the displacements; near the rest lengths that is a matrix, which a
// forward and a backward sweep leave symmetric, however far the springs are from being solved.
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

// The fourth order goes back a little between two pulses. A particle that has just left the floor is then below it for a while.
TEST_CASE("network: a bounce between the pulses of the fourth order is one bounce, though the scheme goes back over it") {
  for (const double height : {0.42, 0.59, 0.3}) {  // met where a flow backwards follows, twice, and where none does
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
    double moved = 0;  // the sum of all momenta, each as large as it is
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
    // Exact contributions of pairs that share particles gain energy at every step: they are not asked for long.
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

// ---- faults ------------------------------------------------------------------------------------------------------------

TEST_CASE("network: a bad particle stays alone, its neighbours go on without its springs") {
  for (const bool is_list : {false, true}) {
    for (const Coupling& coupling : all_schemes) {
      Joined joined = with(test::sheet(32, 32, 50, 0.001), coupling);
      if (is_list) joined = test::as_list(joined);
      joined.x[500][1] = std::numeric_limits<double>::quiet_NaN();
      joined.v[77][2] = std::numeric_limits<double>::infinity();
      const auto got = as_double(stepped<float>(joined, {.isa = best_isa()}, 10));
      std::size_t bad = 0;
      for (std::size_t i = 0; i < 1024; ++i) {
        bool is_bad = false;
        for (std::size_t k = 0; k < 6; ++k) is_bad = is_bad || !std::isfinite(got[6 * i + k]);
        bad += is_bad ? 1 : 0;
      }
      CHECK_MESSAGE(bad == 2, "scheme " << static_cast<int>(coupling.scheme) << (is_list ? ", list" : ", grid"));
    }
  }
}

constexpr std::size_t half = 63;  // particles of each of two sheets that nothing joins

Joined two_sheets() {
  Joined joined = test::sheet(7, 9, 50, 0.001);
  Grid second = std::get<Grid>(joined.scene.networks[0]);
  second.first = half;
  joined.scene.add(Network(second));
  for (std::size_t i = 0; i < half; ++i) {
    joined.x.push_back({joined.x[i][0], joined.x[i][1] + 1, joined.x[i][2]});
    joined.v.push_back(joined.v[i]);
  }
  return joined;
}

Joined two_lists() {
  Joined joined = two_sheets();
  for (Network& network : joined.scene.networks) network = springs_of(std::get<Grid>(network));
  joined.name += ", as lists";
  return joined;
}

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

// In one of four ways, by the turn, a particle of either sheet is bad.
template <class T>
void check_other_sheet(const Joined& joined, const test::Run& run, const std::vector<T>& wanted, std::size_t turn) {
  constexpr std::array<std::array<double, 2>, 4> ways{
      {{not_a_number, 0.0}, {0.0, not_a_number}, {infinite, 1.0}, {1.0, -infinite}}};
  const auto& [bad_x, bad_v] = ways[turn % 4];
  const std::size_t bad = turn / 4 % 2 == 0 ? std::size_t{31} : half + 31;
  Joined ill = joined;
  ill.x[bad][1] = bad_x;
  ill.v[bad][0] = bad_v;
  std::vector<T> got = stepped<T>(ill, run, 4);
  const auto own = static_cast<std::ptrdiff_t>(bad < half ? 0 : 6 * half);
  std::copy_n(wanted.begin() + own, 6 * half, got.begin() + own);
  const std::string difference = test::difference(wanted, got);
  CHECK_MESSAGE(difference.empty(), joined.name << ", scheme " << static_cast<int>(joined.scene.coupling.scheme) << ", "
                                                << name(run.isa) << ", " << name(run.arithmetic) << ": " << difference);
}

// Springs to one particle are taken away.
Joined without_springs_of(Joined joined, std::uint32_t particle) {
  for (Network& network : joined.scene.networks) {
    auto& springs = std::get<Springs>(network);
    Springs left{.pairs = {}, .stiffness = 0.0, .rest_length = std::nullopt, .damping = springs.damping};
    std::vector<double> k;
    std::vector<double> l;
    for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
      if (springs.pairs[s][0] == particle || springs.pairs[s][1] == particle) continue;
      left.pairs.push_back(springs.pairs[s]);
      k.push_back(springs.stiffness[s]);
      l.push_back((*springs.rest_length)[s]);
    }
    left.stiffness = Scalars(k);
    left.rest_length = Scalars(l);
    springs = left;
  }
  return joined;
}

TEST_CASE_TEMPLATE("network: a bad particle changes no bit of what is not joined with it, in any scheme", T, float, double) {
  std::size_t first = 0;  // every ISA meets every way in either sheet in one scheme or another
  for (const Joined& two : {two_sheets(), two_lists()}) {
    for (const Coupling& coupling : all_schemes) {
      const Joined joined = with(two, coupling);
      std::size_t turn = first++;
      for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
        std::vector<T> wanted;
        for (const Isa isa : available_isas(arithmetic)) {
          const Run run{.isa = isa, .arithmetic = arithmetic};
          // fast arithmetic alone has other bits on another ISA
          if (wanted.empty() || arithmetic == Arithmetic::fast) wanted = stepped<T>(joined, run, 4);
          check_other_sheet<T>(joined, run, wanted, turn++);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("network: neighbours of a bad particle go on as if its springs were cut, bit by bit", T, float, double) {
  constexpr std::size_t bad = 31;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::accumulate}) {
    Joined joined = with(two_lists(), {.scheme = scheme, .substeps = 12});
    for (const Isa isa : available_isas()) {
      const std::vector<T> wanted = stepped<T>(without_springs_of(joined, bad), {.isa = isa}, 4);
      Joined ill = joined;
      ill.x[bad][1] = not_a_number;
      std::vector<T> got = stepped<T>(ill, {.isa = isa}, 4);
      std::copy_n(wanted.begin() + 6 * bad, 6, got.begin() + 6 * bad);
      const std::string difference = test::difference(wanted, got);
      CHECK_MESSAGE(difference.empty(), "scheme " << static_cast<int>(scheme) << ", " << name(isa) << ": " << difference);
    }
  }
}

TEST_CASE("network: coincident ends contribute nothing, and what passes through them stays finite") {
  for (const Coupling& coupling : all_schemes) {
    Joined still = with(on_a_line({0.5, 0.5}, {0.25, 0.25}, 0), coupling);
    still.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = 1.0}));
    const auto got = stepped<double>(still, {.isa = best_isa()}, 60);
    CHECK(is_close(x(got, 0, 0), 0.75, 1e-12));
    CHECK(x(got, 1, 0) == x(got, 0, 0));

    Joined through = with(on_a_line({0, 1}, {1, -1}, 0), coupling);
    through.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = 0.0}));
    const auto passed = stepped<double>(through, {.isa = best_isa()}, 120);
    for (const double value : passed) CHECK(std::isfinite(value));
    CHECK(std::abs(v(passed, 0, 0) + v(passed, 1, 0)) < 1e-12);
  }
}

TEST_CASE("network: fixed particles do not move by a bit, and springs between them do nothing") {
  for (const Coupling& coupling : all_schemes) {
    Joined joined = with(test::sheet(6, 9, 50), coupling);
    joined.scene.fixed = {0, 1, 2, 10, 53};
    joined.v[1] = {3, -0.0, 5};
    const auto start = stepped<float>(joined, {.isa = best_isa()}, 0);
    const auto got = stepped<float>(joined, {.isa = best_isa()}, 20);
    for (const std::size_t i : joined.scene.fixed) {
      for (std::size_t k = 0; k < 6; ++k)
        CHECK(std::bit_cast<std::uint32_t>(start[6 * i + k]) == std::bit_cast<std::uint32_t>(got[6 * i + k]));
    }
  }
}

TEST_CASE("network: a plan that another thread steps says so" * doctest::test_suite("threads")) {
  const Joined joined = test::sheet(6, 9, 50);
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const Plan<float> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
  struct Within {
    const Plan<float>* plan;
    std::size_t count;
    StepResult result = StepResult::done;
    static void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
      auto& self = *static_cast<Within*>(context);
      Batch<float> other(Layout::soa, self.count);
      self.result = self.plan->step(other.view(), 1);
      for (std::size_t i = 0; i < count; ++i) body(task, i);
    }
  };
  // Small sheets ask for no threads, so step a large one.
  const Joined large = test::sheet(140, 150, 5);
  Batch<float> of_large(Layout::soa, large.x.size());
  test::place(large, of_large.view());
  const Plan<float> large_plan = plan_of(large, {.isa = best_isa()}, of_large.view());
  Within within{.plan = &large_plan, .count = large.x.size()};
  Within other{.plan = &plan, .count = joined.x.size()};
  REQUIRE(large_plan.step(of_large.view(), 1, {.run = Within::run, .context = &other}) == StepResult::done);
  CHECK(other.result == StepResult::done);
  REQUIRE(large_plan.step(of_large.view(), 1, {.run = Within::run, .context = &within}) == StepResult::done);
  CHECK(within.result == StepResult::in_use);
}

TEST_CASE("network: a plan whose wind is replaced steps as one that was compiled with it") {
  for (const Coupling& coupling : all_schemes) {
    Joined before = with(test::sheet(9, 20, 50, 0.001), coupling);
    before.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 0}});
    for (const Force& replaced :
         {Force(Drag{.coefficient = 0.002, .wind = {-3, 0, 1}}), Force(Spring{.stiffness = 0.5, .anchor = Vec3{0, 1, 0}})}) {
      Joined after = before;
      after.scene.forces[1] = replaced;
      Batch<float> batch(Layout::soa, before.x.size());
      test::place(before, batch.view());
      Plan<float> plan = plan_of(before, {.isa = best_isa()}, batch.view());
      REQUIRE(plan.set_force(1, replaced).has_value());
      REQUIRE(plan.step(batch.view(), 3) == StepResult::done);
      CHECK(test::difference(stepped<float>(after, {.isa = best_isa()}, 3), test::values_of(batch.view())) == "");
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

TEST_CASE("network: the bound holds what any position may reach: of a star, and of a grid as of the list of its springs") {
  // Three masses on springs of stiffness k to a fourth one in their middle: omega_max = sqrt(4 k/m).
  Joined star;
  star.x = {{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}, {0, 0, 0}};
  star.v.assign(4, {});
  star.scene.add(Network(Springs{.pairs = {{0, 3}, {1, 3}, {2, 3}}, .stiffness = 900.0, .rest_length = 0.0}));
  CHECK(limit_of(star).bound >= 60 * (1 - 1e-9));
  const Joined sheet = test::sheet(9, 14, 50);
  CHECK(limit_of(sheet).bound >= limit_of(test::as_list(sheet)).bound / 1.02);
}

TEST_CASE("network: a stretched spring is stiff across itself, too") {
  // Two springs of stiffness k at right angles, twice as long as at rest: omega^2 = (k + k/2)/m along either.
  Joined corner;
  corner.x = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  corner.v.assign(3, {});
  corner.scene.fixed = {1, 2};
  corner.scene.add(Network(Springs{.pairs = {{0, 1}, {0, 2}}, .stiffness = 600.0, .rest_length = 1.0}));
  CHECK(std::abs(limit_of(corner).frequency - 30) <= 0.03);
}

TEST_CASE("network: rest lengths are those of the grid's own edges, or those of the start") {
  const Springs springs = springs_of(Grid{.rows = 3, .columns = 5, .edge_u = {8, 0, 0}, .edge_v = {0, 0, 3}, .structural = 1});
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    CHECK((*springs.rest_length)[s] == (springs.pairs[s][1] == springs.pairs[s][0] + 1 ? 2 : 1.5));
  }
  Joined still;
  still.x = {{0, 0, 0}, {0, 3, 4}};
  still.v.assign(2, {});
  still.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0}));
  const auto after = stepped<double>(still, {}, 10);
  CHECK(std::abs(x(after, 1, 1) - 3) <= 1e-12);
}

TEST_CASE("network: a sheet that hangs free is held to what its start asks for and a margin") {
  Joined sheet = test::sheet(9, 14, 50);
  std::get<Grid>(sheet.scene.networks[0]).shear = 0;  // flat, its rows and columns do not feel each other; folded they do
  sheet.step = 1e-4;
  const NetworkLimit slow = limit_of(sheet);
  sheet.step = 8.9 * slow.limit / slow.frequency;
  CHECK(limit_of(sheet).fewest == 10);  // 8.9 / 0.93 = 9.57
  CHECK(limit_of(sheet).safe > 10);
}

TEST_CASE("network: a damped pair is stable with as many sub-steps as the plan says") {
  // w_a + w_b = 2/kg, c = 1000 kg/s: a sub-step takes away 2000/s of the speed, which must be below 2.
  Joined pair;
  pair.x = {{0, 0, 0}, {2, 0, 0}};
  pair.v = {{0, 0, 0}, {3, 0, 0}};
  pair.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 1e-6, .rest_length = 2.0, .damping = 1000}));
  CHECK(limit_of(pair).safe == 17);  // 2000 / 60 / 2 = 16.7
  const auto after = stepped<double>(pair, {}, 60);
  CHECK(std::abs(v(after, 1, 0) - v(after, 0, 0)) < 1e-3);
  CHECK(std::abs(v(after, 1, 0) + v(after, 0, 0) - 3) < 1e-12);
}

// From 3.106 to 3.133 of a sub-step's omega h the fourth order is stable, but swings by more than twice.
TEST_CASE("network: the fourth order's own sub-steps keep a pair's energy within twice, near its limit too") {
  for (int n = 0; n < 30; ++n) {
    const double angle = 30.9 + 0.015 * n;  // of a step
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

TEST_CASE("network: an error names the field that is wrong") {
  const auto error_of = [](auto change) {
    Joined joined = test::sheet(4, 5, 50);
    change(joined.scene);
    Batch<float> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    const auto plan = compile<float>(joined.scene, {.step = joined.step}, batch.view());
    return plan ? std::string("no error") : plan.error().message();
  };
  const auto grid = [](Scene& scene) -> Grid& { return std::get<Grid>(scene.networks[0]); };
  CHECK(error_of([&](Scene& s) { grid(s).rows = 1; }).starts_with("networks[0].rows is 1: must be"));
  CHECK(error_of([&](Scene& s) { grid(s).rows = 5; }).starts_with("networks[0].rows is 5 of 5 columns"));
  CHECK(error_of([&](Scene& s) { grid(s).first = 1; }).starts_with("networks[0].rows is 4 of 5 columns from particle 1:"));
  CHECK(error_of([&](Scene& s) {
          grid(s).first = std::numeric_limits<std::size_t>::max() - 19;  // its last particle's number wraps around to 0
        }).starts_with("networks[0].rows is 4 of 5 columns from particle 18446744073709551596"));
  CHECK(error_of([&](Scene& s) { grid(s).edge_u = {}; }).starts_with("networks[0].edge_u is [0, 0, 0]"));
  CHECK(error_of([&](Scene& s) { grid(s).shear = -1; }) == "networks[0].shear is -1: must be a finite number >= 0");
  CHECK(error_of([&](Scene& s) { s.coupling.theta = 0.4; }) == "coupling.theta is 0.4: must be a number from 0.5 to 1");
  CHECK(error_of([&](Scene& s) { s.coupling.substeps = 0; }).starts_with("coupling.substeps is 0"));
  CHECK(error_of([&](Scene& s) {
          s.networks = {Springs{.pairs = {{3, 3}}, .stiffness = 1.0}};
        }).starts_with("networks[0].pairs[0] is"));
  CHECK(error_of([&](Scene& s) {
          s.networks = {Springs{.pairs = {{3, 20}}, .stiffness = 1.0}};
        }).starts_with("networks[0].pairs[0] is"));
  CHECK(error_of([&](Scene& s) {
          s.coupling = {.scheme = Scheme::accumulate};
          s.add(Plane{});
        }).starts_with("coupling.scheme is accumulate"));
  CHECK(!compile<float>(test::sheet(4, 5, 50).scene, {.step = 0.01}).has_value());
}

}  // namespace network_test
