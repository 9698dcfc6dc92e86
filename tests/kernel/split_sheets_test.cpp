// Parts of alike sheets side by side have the bits of the whole.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "kernel/parts.hpp"

namespace parts::sheets_test {

// One sheet after the other, one of them torn.
Scene sheets_side_by_side(std::size_t sheets, Grid grid) {
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  for (std::size_t n = 0; n < sheets; ++n) {
    grid.first = n * grid.rows * grid.columns;
    const auto torn = static_cast<std::uint32_t>(grid.first + 5);
    grid.broken.clear();
    if (n + 2 == sheets) grid.broken = {{torn, torn + 1}};
    scene.networks.emplace_back(grid);
  }
  return scene;
}

TEST_CASE("split: parts of wide sheets side by side have the bits of the whole in every scheme without sweeps") {
  const Sheet all{12, 200};
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::accumulate}) {
    for (const double damping : {0.0, 0.002}) {
      Scene scene = sheets_side_by_side(3, {.rows = 4,
                                            .columns = 200,
                                            .edge_u = {19, 0, 0},
                                            .edge_v = {0, 0, 0.31},
                                            .structural = 300,
                                            .shear = 80,
                                            .damping = damping});
      scene.coupling.scheme = scheme;
      scene.coupling.substeps = 20;
      scene.fixed = {0, 799, 801, 1605};
      CAPTURE(static_cast<int>(scheme));
      CAPTURE(damping);
      const Options options{.step = 1.0 / 60, .isa = best_isa()};
      NetworkLimit limit;
      limit.substeps = 20;
      const auto whole = whole_hash(all, scene, options);
      for (const std::uint32_t parts : {2U, 3U, 5U}) CHECK(hash_in_parts(all, scene, options, limit, parts) == whole);
    }
  }
}

TEST_CASE("split: parts of swept sheets side by side get whole sheets, exchange nothing and have the bits of the whole") {
  const Sheet all{100, 30};
  Scene scene =
      sheets_side_by_side(5, {.rows = 20, .columns = 30, .edge_u = {2.9, 0, 0}, .edge_v = {0, 0, 1.9}, .structural = 300});
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  scene.coupling.substeps = 2;
  scene.fixed = {0, 600, 1200, 1800, 2429};
  const Options options{.step = 1.0 / 60, .isa = best_isa()};
  NetworkLimit limit;
  const auto whole = whole_hash(all, scene, options, &limit);
  CHECK(tellings_of_sweeps(scene, all.count()) == 0);
  for (const std::uint32_t parts : {1U, 2U, 3U, 5U}) CHECK(hash_in_parts(all, scene, options, limit, parts) == whole);
}

}  // namespace parts::sheets_test
