// Parts of a swept scene have the bits of the whole.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "kernel/parts.hpp"

namespace parts::sweeps_test {

std::vector<Isa> isas_of(bool all) { return all ? available_isas(Arithmetic::separate) : std::vector{best_isa()}; }

// Only the first part has the light particles that determine rho of the sub-steps.
std::vector<double> lighter_first(const Sheet& sheet) {
  std::vector<double> mass(sheet.count(), 0.01);
  std::fill_n(mass.begin(), 300, 0.003);
  return mass;
}

// Bands of 12 rows, two of them in a part; the last of four parts has five rows.
constexpr Sheet banded{77, 40};
const std::vector<Pair> torn_in_bands{{1000, 1001}, {1900, 1940}};

Grid banded_grid(double bend, double damping) {
  Grid grid{.rows = banded.height, .columns = banded.width, .edge_u = {3.9, 0, 0}, .edge_v = {0, 0, 7.6}};
  grid.structural = 300;
  grid.shear = 80;
  grid.bend = bend;
  grid.damping = damping;
  return grid;
}

// A sheet over a ball, in three sub-steps; with bends it uses theta.
Scene banded_scene(Network network, double bend) {
  Scene scene;
  scene.mass = Scalars(lighter_first(banded));
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.networks.push_back(std::move(network));
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  if (bend != 0) scene.coupling.theta = 0.6;
  scene.coupling.substeps = 3;
  scene.wind.mean = {2, 1, 3};
  scene.fixed = {0, banded.width - 1, 60 * banded.width};
  scene.contacts.emplace_back(Sphere{.center = {2, 0.5, 4.7}, .radius = 0.499, .restitution = 0.4, .friction = 0.3});
  return scene;
}

enum class Tellings { a_substep, any };

// The best ISA runs two parts and `most`, the others only `most`.
std::vector<std::uint32_t> parts_for(Isa isa, std::uint32_t most) {
  return isa == best_isa() ? std::vector{2U, most} : std::vector{most};
}

void check_banded(const Scene& scene, bool on_all_isas, Tellings expected, const Sheet& sheet = banded,
                  std::uint32_t most_parts = 4) {
  NetworkLimit limit;
  const auto whole = whole_hash(sheet, scene, {.step = 1.0 / 60, .isa = best_isa()}, &limit);
  for (const Isa isa : isas_of(on_all_isas)) {
    const Options options{.step = 1.0 / 60, .isa = isa};
    for (const std::uint32_t parts : parts_for(isa, most_parts)) {
      CAPTURE(name(isa));
      CAPTURE(parts);
      std::size_t tellings = 0;
      CHECK(hash_in_parts(sheet, scene, options, limit, parts, &tellings) == whole);
      if (expected == Tellings::a_substep) CHECK(tellings == 3 * steps);
    }
  }
}

// Air has its own exchanges.
TEST_CASE("split: parts of a swept sheet have the bits of the whole, and exchange once a sub-step") {
  for (const double bend : {0.0, 4.0}) {
    for (const double damping : {0.0, 0.002}) {
      Grid grid = banded_grid(bend, damping);
      if (damping != 0) grid.aerodynamics = Aerodynamics{};
      grid.broken = torn_in_bands;
      CAPTURE(bend);
      CAPTURE(damping);
      check_banded(banded_scene(grid, bend), bend == 0 && damping == 0, damping == 0 ? Tellings::a_substep : Tellings::any);
    }
  }
}

TEST_CASE("split: parts of swept lists have the bits of the whole, and exchange after each colour") {
  const Sheet sheet{88, 100};  // three pieces
  for (const bool is_shuffled : {false, true}) {
    for (const double damping : {0.0, 0.002}) {
      Scene scene;
      scene.mass = Scalars(lighter_first(sheet));
      scene.add(Constant{.acceleration = {0, -9.81, 0}});
      Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {9.9, 0, 0}, .edge_v = {0, 0, 8.7}};
      grid.structural = 300;
      grid.bend = 20;
      grid.damping = damping;
      if (is_shuffled) {
        scene.networks.emplace_back(shuffled(sheet, damping));
      } else {
        scene.networks.emplace_back(grid);
        scene.networks.emplace_back(Springs{.pairs = {{0, 8000}, {50, 53}}, .stiffness = 3.0});
      }
      scene.coupling.scheme = Scheme::sequential;
      scene.coupling.lines = Lines::none;
      scene.coupling.substeps = 2;
      if (damping != 0) scene.coupling.sweeps = SweepOrder::forward;
      if (damping != 0) scene.coupling.theta = 0.7;
      scene.fixed = {0, 1, 5000, 5001};
      scene.contacts.emplace_back(Sphere{.center = {2, 0.5, 7}, .radius = 0.499, .restitution = 0.4, .friction = 0.3});
      CAPTURE(is_shuffled);
      CAPTURE(damping);
      NetworkLimit limit;
      const auto whole = whole_hash(sheet, scene, {.step = 1.0 / 60, .isa = best_isa()}, &limit);
      const auto each = tellings_of_sweeps(scene, sheet.count());
      CHECK(each > 2);
      for (const Isa isa : isas_of(!is_shuffled && damping == 0)) {
        const Options options{.step = 1.0 / 60, .isa = isa};
        const std::uint32_t parts = damping != 0 ? 2 : 3;
        CAPTURE(name(isa));
        CAPTURE(parts);
        std::size_t tellings = 0;
        CHECK(hash_in_parts(sheet, scene, options, limit, parts, &tellings) == whole);
        CHECK(tellings == 2 * steps * each);
      }
    }
  }
}

// All springs of a sheet except some diagonals, in shuffled order.
Springs most_of(const Grid& grid) {
  const Springs all = springs_of(grid);
  Springs some{.pairs = {}, .stiffness = 0.0, .rest_length = std::nullopt, .damping = all.damping};
  std::vector<double> k, l;
  for (std::size_t n = 0; n < all.pairs.size(); ++n) {
    const std::size_t s = (n * 7919) % all.pairs.size();
    const auto [a, b] = all.pairs[s];
    if (b - a == grid.columns + 1 && a % 5 == 0) continue;
    some.pairs.push_back({b, a});
    k.push_back(all.stiffness[s]);
    l.push_back((*all.rest_length)[s]);
  }
  some.stiffness = Scalars(std::move(k));
  some.rest_length = Scalars(std::move(l));
  return some;
}

TEST_CASE("split: parts of a list swept as a sheet have the bits of the whole, and exchange once a sub-step") {
  for (const double bend : {0.0, 4.0}) {
    for (const double damping : {0.0, 0.002}) {
      Springs list = most_of(banded_grid(bend, damping));
      list.broken = torn_in_bands;
      const Scene scene = banded_scene(std::move(list), bend);
      CAPTURE(bend);
      CAPTURE(damping);
      REQUIRE(swept_rows(scene, banded.count()));
      CHECK(tellings_of_sweeps(scene, banded.count()) == 1);
      check_banded(scene, bend == 0 && damping == 0, Tellings::a_substep);
    }
  }
}

// Renumbers the particles by the sheet's stride.
Springs numbered(Springs springs, const Sheet& sheet) {
  std::vector<std::uint32_t> number(sheet.count());
  for (std::uint32_t i = 0; i < number.size(); ++i) number[i * sheet.stride % number.size()] = i;
  for (Pair& pair : springs.pairs) pair = {number[pair[0]], number[pair[1]]};
  for (Pair& pair : springs.broken) pair = {number[pair[0]], number[pair[1]]};
  for (Triangle& t : springs.triangles) t = {number[t[0]], number[t[1]], number[t[2]]};
  return springs;
}

TEST_CASE("split: parts of a sheet numbered in any order have the bits of the whole, and exchange once a sub-step") {
  const Sheet sheet{banded.height, banded.width, 1003};  // its walk goes along its longer side
  for (const double bend : {0.0, 4.0}) {
    for (const double damping : {0.0, 0.002}) {
      Grid grid = banded_grid(bend, damping);
      if (damping != 0) grid.aerodynamics = Aerodynamics{};
      grid.broken = torn_in_bands;
      const Scene scene = banded_scene(numbered(springs_of(grid), sheet), bend);
      CAPTURE(bend);
      CAPTURE(damping);
      const auto rows = swept_rows(scene, sheet.count());
      REQUIRE(rows);
      CHECK(rows->columns == banded.height);
      check_banded(scene, bend == 0 && damping == 0, damping == 0 ? Tellings::a_substep : Tellings::any, sheet, 3);
    }
  }
}

// The free particles are placed where further rows of the grid would be.
TEST_CASE("split: parts of a grid followed by free particles have the bits of the whole") {
  const Sheet sheet{68, 40};
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Grid grid{.rows = 53, .columns = sheet.width, .edge_u = {3.9, 0, 0}, .edge_v = {0, 0, 5.2}};
  grid.structural = 300;
  grid.shear = 80;
  scene.networks.emplace_back(grid);
  scene.coupling.substeps = 3;
  scene.fixed = {0, sheet.width - 1};
  for (const Scheme scheme : {Scheme::sequential, Scheme::leapfrog}) {
    scene.coupling.scheme = scheme;
    scene.coupling.lines = Lines::none;
    if (scheme == Scheme::leapfrog) scene.coupling.substeps = 20;
    CAPTURE(static_cast<int>(scheme));
    const Options options{.step = 1.0 / 60};
    NetworkLimit limit;
    const auto whole = whole_hash(sheet, scene, options, &limit);
    for (const std::uint32_t parts : {2U, 3U}) {
      CAPTURE(parts);
      CHECK(hash_in_parts(sheet, scene, options, limit, parts, nullptr) == whole);
    }
  }
}

}  // namespace parts::sweeps_test
