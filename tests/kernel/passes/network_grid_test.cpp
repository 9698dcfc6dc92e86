// Networks that are grids: several in one plan, larger than a cache, and as the list of their springs.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "support/batch.hpp"

namespace networks::grid_test {

using test::plan_of;
using test::Run;
using test::stepped;

TEST_CASE("network: a grid and the list of its springs give the same bits where particles sum their springs") {
  // A list whose order is far from its neighbours' is stepped in another order, which changes the sums (3 x 300).
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

// `count` of the sheets, from number `first` on. The particle at a seam is bad: its torn springs must not reach the sheet
// behind.
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

// Larger than a cache, where several pulses are taken at once; a double needs twice the memory.
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

}  // namespace networks::grid_test
