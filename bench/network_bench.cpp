// The network pass: a hanging sheet with shear, as a grid and as a list of springs, by pulses and by sweeps. An item is one
// spring in one sub-step, whether that consists of flows, of one pulse, or of a forward and a backward sweep. A call takes
// twenty sub-steps, or those of a game's frame.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "support/benches.hpp"
#include "support/plain.hpp"
#include "support/plan_bench.hpp"

namespace dvdx::bench {
namespace {

constexpr double step = 1e-4;  // s: a soft sheet of any size here is stable

// Shuffled: the particles are numbered at random. Irregular: one spring is missing as well, so that sweeps find no sheet.
enum class Arrangement { grid, list, shuffled, irregular };

struct Sheet {
  std::string name;
  Coupling coupling;
  Arrangement arrangement = Arrangement::grid;
  double damping = 0;
  int substeps = 20;  // in a call
};

Grid grid_of(std::size_t side, double damping) {
  return {.rows = side,
          .columns = side,
          .edge_u = {2, 0, 0},
          .edge_v = {0, 0, 2},
          .structural = 100,
          .shear = 100,
          .damping = damping};
}

// The index of each of the sheet's particles in the caller's order.
std::vector<std::uint32_t> places(const Sheet& sheet, std::size_t side) {
  std::vector<std::uint32_t> place(side * side);
  std::iota(place.begin(), place.end(), 0U);
  if (sheet.arrangement == Arrangement::shuffled || sheet.arrangement == Arrangement::irregular)
    std::shuffle(place.begin(), place.end(), std::mt19937(1));
  return place;
}

void lose_last(Springs& springs) {
  const auto all_but_last = [](const Scalars& values) {
    if (values.is_uniform()) return values;
    return Scalars(std::vector<double>(values.each().begin(), values.each().end() - 1));
  };
  springs.pairs.pop_back();
  springs.stiffness = all_but_last(springs.stiffness);
  springs.rest_length = all_but_last(*springs.rest_length);
}

Scene scene_of(const Sheet& sheet, std::size_t side) {
  Scene scene;
  scene.mass = 1.0 / static_cast<double>(side * side);
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const std::vector<std::uint32_t> place = places(sheet, side);
  scene.fixed = {std::min(place[0], place[side - 1]), std::max(place[0], place[side - 1])};
  const Grid grid = grid_of(side, sheet.damping);
  Springs springs = springs_of(grid);
  if (sheet.arrangement == Arrangement::irregular) lose_last(springs);
  for (auto& [a, b] : springs.pairs) {
    a = place[a];
    b = place[b];
  }
  scene.add(sheet.arrangement == Arrangement::grid ? Network(grid) : Network(springs));
  scene.coupling = sheet.coupling;
  scene.coupling.substeps = sheet.substeps;
  return scene;
}

template <class T>
void lay_flat(State<T>& state, const Sheet& sheet, std::size_t side) {
  const std::vector<std::uint32_t> place = places(sheet, side);
  for (std::size_t i = 0; i < state.count; ++i) {
    const std::uint32_t at = place[i];
    state.x[0][at] = static_cast<T>(2.0 * static_cast<double>(i % side) / static_cast<double>(side - 1));
    state.x[1][at] = static_cast<T>(0.001 * static_cast<double>(i % 7));
    state.x[2][at] = static_cast<T>(2.0 * static_cast<double>(i / side) / static_cast<double>(side - 1));
    for (std::size_t axis = 0; axis < 3; ++axis) state.v[axis][at] = 0;
  }
}

std::size_t springs_in(std::size_t side) { return 2 * side * (side - 1) + 2 * (side - 1) * (side - 1); }

// Estimates have different bits. They must agree within a few roundings of positions of metres.
template <class T>
bool is_near(const State<T>& a, const State<T>& b) {
  const T most = 16 * std::numeric_limits<T>::epsilon();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < a.count; ++i) {
      if (!(std::abs(a.x[axis][i] - b.x[axis][i]) <= most)) return false;
    }
  }
  return true;
}

// The scalar reference's state of a sheet after one step. It is computed at first use, once for all plans that step the sheet
// in that arithmetic.
template <class T>
class ByReference {
 public:
  const State<T>& after(const Sheet& sheet, Arithmetic arithmetic, std::size_t side) {
    if (!held_) {
      held_ = hold_padded<T>(side * side);
      lay_flat(held_->state, sheet, side);
      const Options options{.step = step, .isa = Isa::reference, .arithmetic = arithmetic};
      (void)compile<T>(scene_of(sheet, side), options, held_->state).value().step(held_->state, 1);
    }
    return held_->state;
  }

 private:
  std::optional<Held<T>> held_;
};

template <class T>
bool is_right(const Plan<T>& plan, const Sheet& sheet, const How& how, std::size_t side, ByReference<T>& by_reference) {
  Held<T> got = hold_padded<T>(side * side);
  lay_flat(got.state, sheet, side);
  (void)plan.step(got.state, 1, on_threads(how.threads));
  const State<T>& wanted = by_reference.after(sheet, how.arithmetic, side);
  if (how.arithmetic == Arithmetic::fast) return is_near(got.state, wanted);
  return is_same_bits(got.state, wanted, side * side);
}

template <class T>
void time_sheet(benchmark::State& timing, const Sheet& sheet, const How& how, std::size_t side, ByReference<T>& by_reference) {
  Held<T> held = hold_padded<T>(side * side);
  lay_flat(held.state, sheet, side);
  const auto plan = compile<T>(scene_of(sheet, side), {.step = step, .isa = how.isa, .arithmetic = how.arithmetic}, held.state);
  if (!plan) return timing.SkipWithError(plan.error().message().c_str());
  for (auto _ : timing) (void)plan->step(held.state, 1, on_threads(how.threads));
  timing.SetItemsProcessed(timing.iterations() * static_cast<std::int64_t>(springs_in(side)) * sheet.substeps);
  if (!is_right(*plan, sheet, how, side, by_reference)) timing.SkipWithError("differs from the reference");
}

template <class T>
void add_sheet(Pace pace, const Sheet& sheet, const How& how, std::size_t side,
               std::shared_ptr<ByReference<T>> by_reference = std::make_shared<ByReference<T>>()) {
  const std::string name = "network/" + sheet.name + "/" + scalar_name<T>() + "/" + std::string(dvdx::name(how.isa)) + "/" +
                           std::string(dvdx::name(how.arithmetic)) + "/" + std::to_string(side) + "x" + std::to_string(side) +
                           "/threads:" + std::to_string(how.threads);
  add(
      pace, name, [=](benchmark::State& timing) { time_sheet<T>(timing, sheet, how, side, *by_reference); }, how.threads);
}

const std::vector<Sheet>& sheets() {
  static const std::vector<Sheet> all = {
      {"grid", {.scheme = Scheme::leapfrog}},
      {"grid_damped", {.scheme = Scheme::leapfrog}, Arrangement::grid, 0.001},
      {"graph", {.scheme = Scheme::leapfrog}, Arrangement::list},
      {"graph_damped", {.scheme = Scheme::leapfrog}, Arrangement::list, 0.001},
      {"grid_fourth_order", {.scheme = Scheme::fourth_order}},
      {"grid_fourth_order_damped", {.scheme = Scheme::fourth_order}, Arrangement::grid, 0.001},
      {"grid_sequential", {.scheme = Scheme::sequential}},
      {"grid_sequential_without_lines", {.scheme = Scheme::sequential, .lines = Lines::none}},
      {"grid_sequential_middle", {.scheme = Scheme::sequential, .theta = 0.5}},
      {"grid_sequential_frame", {.scheme = Scheme::sequential, .theta = 0.5}, Arrangement::grid, 0, 2},
      {"grid_forward_frame",
       {.scheme = Scheme::sequential, .theta = 1, .sweeps = SweepOrder::forward},
       Arrangement::grid,
       0,
       3},
      {"graph_sequential", {.scheme = Scheme::sequential}, Arrangement::list},
      {"shuffled_sequential", {.scheme = Scheme::sequential}, Arrangement::shuffled},
      {"shuffled_sequential_without_lines", {.scheme = Scheme::sequential, .lines = Lines::none}, Arrangement::shuffled},
      {"irregular_sequential", {.scheme = Scheme::sequential}, Arrangement::irregular},
      {"irregular_sequential_in_lines", {.scheme = Scheme::sequential, .lines = Lines::whole}, Arrangement::irregular},
      {"graph_sequential_middle", {.scheme = Scheme::sequential, .theta = 0.5}, Arrangement::list},
      {"pairs", {.scheme = Scheme::accumulate, .method = Method::average_acceleration}, Arrangement::list},
  };
  return all;
}

// Compiling a million particles takes seconds. One sheet is timed for each way through memory.
bool is_large_too(const Sheet& sheet) {
  constexpr std::array names = {"grid", "graph", "grid_sequential", "shuffled_sequential", "irregular_sequential"};
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return sheet.name == name; });
}

std::size_t usual_side(Pace pace) { return pace == Pace::timed ? 64 : 40; }
std::size_t large_side(Pace pace) { return pace == Pace::timed ? 1024 : 128; }

template <class T>
void add_sheets(Pace pace) {
  for (const Sheet& sheet : sheets()) {
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
      const auto by_reference = std::make_shared<ByReference<T>>();
      for (const Isa isa : available_isas(arithmetic)) {
        add_sheet<T>(pace, sheet, {isa, arithmetic}, usual_side(pace), by_reference);
      }
    }
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::fast}) {
      add_sheet<T>(pace, sheet, {best_isa(), arithmetic}, 32);
    }
    if (sizeof(T) != sizeof(float) || !is_large_too(sheet)) continue;
    const auto by_reference = std::make_shared<ByReference<T>>();
    for (int threads = 1; threads <= most_threads(); ++threads) {
      add_sheet<T>(pace, sheet, {best_isa(), Arithmetic::separate, threads}, large_side(pace), by_reference);
    }
  }
}

// A list of springs over an array of structs, as in a textbook.
void time_plain_springs(benchmark::State& timing, std::size_t side) {
  PlainSprings<float> plain = plain_sheet<float>(side);
  for (auto _ : timing) {
    plain_spring_step(plain, 5e-6F);
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(timing.iterations() * static_cast<std::int64_t>(springs_in(side)));
}

}  // namespace

void register_network(Pace pace) {
  add_sheets<float>(pace);
  add_sheets<double>(pace);
  for (const std::size_t side : {std::size_t{32}, usual_side(pace), large_side(pace)}) {
    add(pace, "network/plain/float32/array_of_structs/" + std::to_string(side) + "x" + std::to_string(side) + "/threads:1",
        [side](benchmark::State& timing) { time_plain_springs(timing, side); });
  }
}

}  // namespace dvdx::bench
