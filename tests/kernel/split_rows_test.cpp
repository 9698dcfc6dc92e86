// Parts of a sheet: whole rows, several sub-steps between exchanges, and their limit.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "kernel/parts.hpp"

namespace parts::rows_test {

TEST_CASE("split: a scene that is not one sheet has no limit by rows") {
  Scene scene;
  CHECK(rates_of_rows(scene, 0, 2).of_k == 0);
  CHECK_FALSE(limit_of_sheet(scene, 1.0 / 60, {}));
  scene.networks = {shuffled({20, 20}, 0)};
  CHECK(rates_of_rows(scene, 0, 2).w == 0);
  CHECK_FALSE(limit_of_sheet(scene, 1.0 / 60, {}));
}

// Each part has too many particles for the cache, and takes four sub-steps between two exchanges.
TEST_CASE("split: a large sheet's parts exchange once in several sub-steps and have the bits of the whole") {
  const Sheet sheet{1601, 512};
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {51.1, 0, 0}, .edge_v = {0, 0, 160}};
  grid.structural = 30;
  grid.bend = 2;
  scene.networks.emplace_back(grid);
  scene.coupling.substeps = 5;
  scene.fixed = {0, sheet.width - 1, 540 * sheet.width};
  scene.contacts.emplace_back(Sphere{.center = {20, 0.5, 53.5}, .radius = 0.49, .restitution = 0.4, .friction = 0.3});
  const Options options{.step = 1.0 / 60, .isa = best_isa()};
  NetworkLimit limit;
  const auto whole = whole_hash(sheet, scene, options, &limit);
  std::size_t tellings = 0;
  CHECK(hash_in_parts(sheet, scene, options, limit, 3, &tellings) == whole);
  CHECK(tellings == 2 * (steps * 5 / 4));  // positions and velocities
}

TEST_CASE("split: only parts of whole rows, large beside their halo, take several sub-steps between exchanges") {
  Scene scene;
  scene.networks.emplace_back(Grid{.rows = 4096, .columns = 256, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 1});
  const auto pulses = [](const Scene& of, std::uint64_t rows) {
    return pulses_per_telling(of, std::get<Grid>(of.networks[0]), rows);
  };
  CHECK(pulses(scene, 1024) == 4);
  CHECK(pulses(scene, 1023) == 1);  // it fits in cache
  Scene other = scene;
  std::get<Grid>(other.networks[0]).damping = 0.1;
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  std::get<Grid>(other.networks[0]).aerodynamics = Aerodynamics{};
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  other.coupling.scheme = Scheme::fourth_order;
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  other.add(Motion{.center = {}, .keys = {{.time = 0}}});
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  std::get<Grid>(other.networks[0]).columns = 1 << 16;
  CHECK(pulses(other, 64) == 4);
  CHECK(pulses(other, 63) == 1);
  std::get<Grid>(other.networks[0]).bend = 1;
  CHECK(pulses(other, 64) == 1);
}

// Sheets whose parts have many rows, one, or none.
std::vector<Scene> sheets_in_stripes() {
  std::vector<Scene> scenes;
  for (const Grid& grid :
       {Grid{.rows = 13, .columns = 6, .structural = 30, .shear = 8, .damping = 0.002},
        Grid{.rows = 4, .columns = 7, .structural = 30, .shear = 8, .bend = 2}, Grid{.rows = 9, .columns = 2, .bend = 2},
        Grid{.rows = 200, .columns = 7, .structural = 5, .bend = 1}}) {
    Scene scene;
    scene.networks.emplace_back(grid);
    auto& made = std::get<Grid>(scene.networks[0]);
    made.edge_u = {1, 0, 0};
    made.edge_v = {0, 0, 1};
    for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
      scene.coupling.scheme = scheme;
      scene.coupling.lines = Lines::none;
      scenes.push_back(scene);
    }
  }
  return scenes;
}

void check_part_of_sheet(const Scene& scene, std::uint32_t parts, std::uint32_t p) {
  const auto& grid = std::get<Grid>(scene.networks[0]);
  const std::size_t count = grid.rows * grid.columns;
  const auto owners = stripes(scene, count, parts);
  CAPTURE(grid.rows);
  CAPTURE(parts);
  CAPTURE(p);
  const Part whole = part_of(scene, owners, p).value();
  const auto part = part_of_sheet(scene, count, parts, p);
  REQUIRE(part);
  CHECK(part->particles == whole.particles);
  CHECK(part->is_own == whole.is_own);
  CHECK(part->is_told == whole.is_told);
  CHECK(part->own == whole.own);
  CHECK(part->springs == whole.springs);
  CHECK(part->cut == whole.cut);
  if (whole.own != 0) CHECK(part->pulses_per_telling == whole.pulses_per_telling);
  REQUIRE(part->neighbours.size() == whole.neighbours.size());
  for (std::size_t n = 0; n < whole.neighbours.size(); ++n) {
    CHECK(part->neighbours[n].part == whole.neighbours[n].part);
    CHECK(part->neighbours[n].sent == whole.neighbours[n].sent);
    CHECK(part->neighbours[n].received == whole.neighbours[n].received);
  }
}

TEST_CASE("split: a part made of its own rows is the part made of the whole sheet") {
  for (const Scene& scene : sheets_in_stripes()) {
    for (const std::uint32_t parts : {1U, 2U, 3U, 6U}) {
      for (std::uint32_t p = 0; p < parts; ++p) check_part_of_sheet(scene, parts, p);
    }
  }
  Scene large;  // three parts, each with several sub-steps between exchanges
  large.networks.emplace_back(
      Grid{.rows = 1601, .columns = 512, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 30, .bend = 2});
  REQUIRE(pulses_per_telling(large, std::get<Grid>(large.networks[0]), 1601 / 3) > 1);
  check_part_of_sheet(large, 3, 1);                                          // the middle part, which receives from both others
  CHECK_FALSE(part_of_sheet(scene_with({}), small.count(), 2, 0));           // in air
  CHECK_FALSE(part_of_sheet(scene_with(Pair{0, 20}), small.count(), 2, 0));  // not a sheet alone
}

// The largest bounds lie on both sides of a cut, and rows reach across it.
TEST_CASE("split: the limit of a sheet's sub-steps found by rows is that of the whole sheet's plan") {
  const Sheet sheet{20, 6};
  Scene scene;
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {0.5, 0, 0}, .edge_v = {0, 0, 1.9}};
  grid.structural = 30;
  grid.shear = 8;
  grid.bend = 2;
  grid.damping = 0.002;
  scene.networks.emplace_back(grid);
  scene.fixed = {0, sheet.width - 1, 100};
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
    scene.coupling.scheme = scheme;
    scene.coupling.lines = Lines::none;
    for (std::size_t row = 0; row < 12; ++row) {  // across two cuts
      std::vector<double> mass(sheet.count(), 0.01);
      std::fill_n(mass.begin() + static_cast<std::ptrdiff_t>(row * sheet.width), 2 * sheet.width, 0.002);
      scene.mass = mass;
      Soa<float> memory(sheet.count());
      place(sheet, memory.view(), {});
      const auto plan = compile(scene, {.step = 1.0 / 60}, memory.view());
      REQUIRE(plan);
      const NetworkLimit limit = *plan->network_limit();
      SheetRates all;
      for (std::uint64_t first = 0; first < sheet.height; first += 5) {
        const SheetRates rates = rates_of_rows(scene, first, first + 5);
        all = {std::max(all.of_k, rates.of_k), std::max(all.of_c, rates.of_c), std::max(all.w, rates.w)};
      }
      const auto found = limit_of_sheet(scene, 1.0 / 60, all);
      REQUIRE(found);
      CHECK(found->substeps == limit.substeps);
      CHECK(found->bound == limit.bound);
      CHECK(found->damping == limit.damping);
      CHECK(found->rho == limit.rho);
      CHECK(found->safe == limit.safe);
    }
  }
  const SheetRates whole = rates_of_rows(scene, 0, sheet.height), beyond = rates_of_rows(scene, 0, sheet.height + 15);
  CHECK(std::array{beyond.of_k, beyond.of_c, beyond.w} == std::array{whole.of_k, whole.of_c, whole.w});
  CHECK(rates_of_rows(scene, sheet.height, sheet.height + 3).w == 0);
  scene.coupling = {.substeps = 1};
  CHECK_FALSE(limit_of_sheet(scene, 1, rates_of_rows(scene, 0, sheet.height)));  // eigenvalues tell whether it is refused
}

}  // namespace parts::rows_test
