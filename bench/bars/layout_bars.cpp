// Layouts compared with each other, and with plain loops over the same structs.
#include <array>
#include <string>
#include <utility>

#include "bars/bars.hpp"
#include "dvdx/layouts/convert.hpp"
#include "dvdx/plan.hpp"
#include "support/held.hpp"
#include "support/race.hpp"
#include "support/report.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"
#include "support/structs.hpp"

namespace dvdx::bench {
namespace {

// A plain loop over the same structs, and a scaling of all their bytes.
struct PlainStructs {
  PlainStructStep step;
  Held<float> held;
  PlainFlow flow;
  void operator()() { step(held.state.x[0].base, held.state.v[0].base, held.state.count, flow); }
};
struct ScaledStructs {
  Held<float> held;
  std::size_t numbers;
  void operator()() { scale_numbers(held.state.x[0].base, numbers, 1.0F); }
};

}  // namespace

void layouts(Report& report, const Run& run) {
  struct Kind {
    std::string name;
    Hold<float> hold;
  };
  for (const Kind& kind : {Kind{"padded", hold_padded<float>}, Kind{"full arrays", hold_full<float>},
                           Kind{"arrays pages apart", hold_pages<float>}, Kind{"structs", hold_aos<float>},
                           Kind{"tiles of 8", hold_tiles<float, 8>}, Kind{"tiles of 16", hold_tiles<float, 16>}}) {
    const auto figure = [&](const std::string& size, const Effort& effort, std::size_t count, std::size_t steps) {
      const double seconds = shortest(effort, stepper(meadow(), scattered<float>(count, kind.hold), steps));
      report.figure(kind.name + size, seconds * 1e9 / static_cast<double>(count * steps), "ns", "a particle and step");
    };
    figure(", L1, 1 step a call", run.effort, in_cache, 1);
    figure(", L1, 16 steps a call", run.effort, in_cache, 16);
    figure(", 8 million, 1 step a call", run.memory_effort, in_memory, 1);
  }
}

// One step a call.
void structs(Report& report, const Run& run) {
  struct Flown {
    std::string name;
    Scene scene;
    Flies flies;
    PlainFlow flow;
    double bound, bound_in_pieces, bound_in_memory;  // relative to a plain loop's time; the first two in cache
  };
  const PlainFlow falling{0, 3e-4F, 0, 0.0166F, {0, -0.16F, 0}, {0, -1.4e-3F, 0}, -1e9F};
  const std::array flown{
      Flown{"gravity and drag", fall(), Flies::free, falling, 0.9, 0.45, 1.0},
      Flown{"a floor to look for", with(fall(), far_floor({0, 1, 0})), Flies::above_a_floor, falling, 1.3, 1.3, 1.3},
      Flown{"a damped spring", meadow(), Flies::on_springs, {0.65F, 0.016F, 5.5e-3F, 0.0164F, {}, {}}, 0.9, 0.45, 1.0}};
  for (const Flown& flow : flown) {
    for (std::size_t k = 0; k < struct_shapes.size(); ++k) {
      const StructShape& shape = struct_shapes[k];
      const bool is_in_pieces = shape.size >= 8;
      const std::string name = shape.name + ", " + flow.name;
      const auto beside = [&](const Effort& effort, std::size_t count, const std::string& size, double bound) {
        const Held<float> held = hold_structs(shape, count);
        const auto ours = stepper(flow.scene, held, 1);
        Race race = bench::race(effort, ours, PlainStructs{plain_struct_step_native(k, flow.flies), held, flow.flow});
        report.bar(name + size + ": step's time / plain loop's", {false, bound}, race, against(race, count, count));
        race = bench::race(effort, ours, PlainStructs{plain_struct_step_any(k, flow.flies), held, flow.flow});
        report.figure(name + size + ", the loop without -march=native", race.median, "times", against(race, count, count));
        return held;
      };
      beside(run.effort, in_cache, ", L1", is_in_pieces ? flow.bound_in_pieces : flow.bound);
      const Held<float> held = beside(run.memory_effort, in_memory, ", 8 million", flow.bound_in_memory);
      if (flow.flies == Flies::above_a_floor) continue;
      const std::size_t numbers = in_memory * shape.size * (shape.are_apart() ? 2 : 1);
      const Race race = bench::race(run.memory_effort, stepper(flow.scene, held, 1), ScaledStructs{held, numbers});
      report.bar(name + ", 8 million: step's time / scaling's", {false, 1.15}, race, against(race, in_memory, in_memory));
    }
  }
}

// Other layouts compared with columns.
void layouts_beside_columns(Report& report, const Run& run) {
  struct Tiled {
    std::string name;
    Hold<float> hold;
  };
  for (const auto& [name, scene] : {std::pair{"gravity and drag", fall()}, std::pair{"a damped spring", meadow()}}) {
    for (const Tiled& tiles : {Tiled{"tiles of 8", hold_tiles<float, 8>}, Tiled{"tiles of 16", hold_tiles<float, 16>}}) {
      for (const std::size_t steps : {std::size_t{1}, std::size_t{16}}) {
        const Race race = bench::race(run.effort, stepper(scene, scattered<float>(in_cache, tiles.hold), steps),
                                      stepper(scene, scattered<float>(in_cache), steps));
        report.bar(tiles.name + " / columns, L1, " + name + ", " + std::to_string(steps) + " a call", {false, 1.15}, race,
                   against(race, in_cache * steps, in_cache * steps));
      }
    }
  }
  const Held<float> sheet = hung();
  const Held<float> in_structs = hold_aos<float>(sheet.state.count);
  State<float> state = in_structs.state;
  copy(sheet.state, state);
  const Scene hung_by_corners = hung_sheet(Scheme::leapfrog);
  Race race = bench::race(run.effort, joined_stepper(hung_by_corners, in_structs), joined_stepper(hung_by_corners, sheet));
  report.bar("a sheet of 64 x 64, leapfrog, structs / columns", {false, 1.05}, race, "");
  const Scene floored = with(fall(), far_floor({0, 1, 0}));
  race = bench::race(run.effort, stepper(floored, scattered<float>(in_cache, hold_aos<float>), 1),
                     stepper(floored, scattered<float>(in_cache), 1));
  report.figure("a floor to look for, L1, structs / columns", race.median, "times", against(race, in_cache, in_cache));
}

}  // namespace dvdx::bench
