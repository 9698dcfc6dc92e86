// Refusals of invalid parts of a scene.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "kernel/parts.hpp"

namespace parts::refusal_test {

TEST_CASE("split: rows that are not a part's are refused") {
  const Sheet sheet{60, 40};
  Scene scene;
  scene.mass = 0.01;
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {3.9, 0, 0}, .edge_v = {0, 0, 5.9}};
  grid.structural = 300;
  scene.networks.emplace_back(springs_of(grid));
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  const Part part = part_of(scene, stripes(scene, sheet.count(), 2), 1).value();
  const Scene own = scene_of(scene, part);
  Soa<float> memory(part.particles.size());
  place(sheet, memory.view(), part.particles);
  const auto refused = [&](std::uint32_t columns, std::uint32_t reach) {
    SweptPart sweeps = *part.sweeps;
    sweeps.columns = columns;
    sweeps.reach = reach;
    Options options{.step = 1.0 / 60};
    options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
    options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
    options.elsewhere.sweeps = &sweeps;
    const auto plan = compile(own, options, memory.view());
    return plan ? std::string("taken") : plan.error().message();
  };
  CHECK(refused(40, 1) == "taken");
  CHECK(refused(40, 3) == "elsewhere.sweeps.reach is 3: must be 1 or 2");
  CHECK(refused(41, 1).find("elsewhere.sweeps.columns is 41: must be such that the particles stand in rows of so many") == 0);
  CHECK(refused(20, 1).find("elsewhere.sweeps.columns is 20: ") == 0);
  SweptPart both = *part.sweeps;
  both.piece_ends.push_back(40);
  Options options{.step = 1.0 / 60};
  options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
  options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
  options.elsewhere.sweeps = &both;
  const auto plan = compile(own, options, memory.view());
  REQUIRE_FALSE(plan.has_value());
  CHECK(plan.error().message() == "elsewhere.sweeps.columns is 40: must be 0 where there are pieces");
}

TEST_CASE("split: owners of fewer rows than sweeps keep together are refused, and leapfrog takes them") {
  const Sheet sheet{64, 64};
  Scene scene;
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {6.3, 0, 0}, .edge_v = {0, 0, 6.3}};
  grid.structural = 300;
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  scene.networks = {grid};
  const std::size_t rows = rows_kept_together(scene, grid);
  REQUIRE(rows > 1);
  // The message for a given owner of each row.
  const auto message = [&](const auto& owner_of_row) {
    std::vector<std::uint32_t> owner(sheet.count());
    for (std::size_t i = 0; i < owner.size(); ++i) owner[i] = owner_of_row(i / sheet.width);
    const auto part = part_of(scene, owner, 1);
    return part ? std::string("taken") : part.error().message();
  };
  const auto ten = [](std::size_t row) { return row < 10 ? 0U : 1U; };
  const auto whole = [&](std::size_t row) { return row < rows ? 0U : 1U; };
  const auto turns = [&](std::size_t row) { return row / rows == 1 ? 1U : 0U; };
  const std::string by_rows =
      "owner[640] is 1: must be 0, as that of particle 639: by sequential rows in " + std::to_string(rows) + "s go together";
  const std::string by_turns =
      "owner[" + std::to_string(2 * rows * sheet.width) +
      "] is 0: must be a part that has no rows before: by sequential a part's rows stand one after the other";
  for (const bool is_list : {false, true}) {
    CAPTURE(is_list);
    if (is_list) scene.networks = {springs_of(grid)};
    CHECK(message(whole) == "taken");
    CHECK(message(ten) == by_rows);
    CHECK(message(turns) == by_turns);
  }
  scene.networks.assign(2, grid);
  std::get<Grid>(scene.networks[0]).rows = std::get<Grid>(scene.networks[1]).rows = 32;
  std::get<Grid>(scene.networks[1]).first = sheet.count() / 2;
  CHECK(message([](std::size_t row) { return row < 32 ? 0U : 1U; }) == "taken");
  CHECK(message(ten) == "owner[640] is 1: must be 0, as that of particle 639: by sequential a sheet's particles go together");
  scene.networks = {shuffled(sheet, 0)};
  CHECK(message(ten).find("by sequential a piece stays whole") != std::string::npos);
  scene.networks = {grid};
  scene.coupling.scheme = Scheme::leapfrog;
  CHECK(message(ten) == "taken");
  CHECK(message(turns) == "taken");
}

TEST_CASE("split: an order of visits that is not a part's is refused") {
  const Sheet sheet{90, 60};
  Scene scene;
  scene.mass = 0.01;
  scene.networks.emplace_back(shuffled(sheet, 0));
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  const Part part = part_of(scene, stripes(scene, sheet.count(), 2), 1).value();
  const Scene own = scene_of(scene, part);
  Soa<float> memory(part.particles.size());
  place(sheet, memory.view(), part.particles);
  const auto refused = [&](const SweptPart* sweeps) {
    Options options{.step = 1.0 / 60};
    options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
    options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
    options.elsewhere.sweeps = sweeps;
    const auto plan = compile(own, options, memory.view());
    return plan ? std::string("taken") : plan.error().message();
  };
  CHECK(refused(&*part.sweeps) == "taken");
  CHECK(refused(nullptr) == "elsewhere.sweeps is null: must be Part::sweeps of a part by sequential that is no sheet");
  SweptPart wrong = *part.sweeps;
  wrong.piece_ends.push_back(wrong.piece_ends.back());
  CHECK(refused(&wrong).find("elsewhere.sweeps.piece_ends is ") == 0);
  wrong = *part.sweeps;
  wrong.colour_of.pop_back();
  CHECK(refused(&wrong).find("elsewhere.sweeps.colour_of is ") == 0);
  std::vector<std::size_t> between;
  for (std::size_t s = 0; s < part.sweeps->colour_of.size(); ++s) {
    if (part.sweeps->colour_of[s] == 1) between.push_back(s);
  }
  REQUIRE(!between.empty());
  const auto with_colour = [&](std::size_t s, std::uint32_t colour) {
    SweptPart other = *part.sweeps;
    other.colour_of[s] = colour;
    return refused(&other);
  };
  const std::string at = "elsewhere.sweeps.colour_of[" + std::to_string(between[0]) + "] is ";
  CHECK(with_colour(between[0], 0).find(at + "0") == 0);
  CHECK(with_colour(between[0], part.sweeps->colours + 1).find(at) == 0);
  SweptPart alike = *part.sweeps;
  for (std::uint32_t& colour : alike.colour_of) colour = std::min(colour, 1U);
  CHECK(refused(&alike).find("of no other spring of its particles") != std::string::npos);
}

}  // namespace parts::refusal_test
