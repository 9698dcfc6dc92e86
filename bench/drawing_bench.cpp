// Normals and bounds for drawing, in ns a particle, and the cost of a contact report in a step.
#include <vector>

#include "dvdx/drawing.hpp"
#include "dvdx/plan.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"

namespace dvdx::bench {
namespace {

struct DrawnSheet {
  explicit DrawnSheet(std::size_t side) : grid{.rows = side, .columns = side}, memory(side * side), out(side * side) {
    const auto state = memory.view();
    for (std::size_t i = 0; i < state.count; ++i) {
      state.x[0][i] = static_cast<float>(i % side);
      state.x[1][i] = 0.01F * static_cast<float>(i * 7919 % 100);
      state.x[2][i] = static_cast<float>(i / side);
    }
    for (std::uint32_t i = 0; i + side < state.count; ++i) {
      const auto below = i + static_cast<std::uint32_t>(side);
      if ((i + 1) % side == 0) continue;
      triangles.push_back({i, i + 1, below + 1});
      triangles.push_back({i, below + 1, below});
    }
  }
  Grid grid;
  Soa<float> memory, out;
  std::vector<Triangle> triangles;
};

template <class Work>
void time_sheet(benchmark::State& timing, std::size_t side, const Work& work) {
  DrawnSheet sheet(side);
  const auto state = sheet.memory.view();
  const auto to = sheet.out.view().x;
  for (auto _ : timing) {
    work(sheet, state, to);
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) * static_cast<std::int64_t>(side * side));
}

enum class Told { nothing, contacts };

// A thousand particles that hop or rest on a floor.
void time_report(benchmark::State& timing, Told told, const Plane& surface, void (*start)(State<float>&)) {
  constexpr std::size_t count = 1024;
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}}).add(surface);
  Soa<float> memory(count);
  auto state = memory.view();
  start(state);
  const auto plan = compile<float>(scene, {.step = frame});
  ContactReport report(1);
  for (auto _ : timing) {
    if (told == Told::contacts) {
      (void)plan->step(state, report);
    } else {
      (void)plan->step(state);
    }
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) * static_cast<std::int64_t>(count));
}

}  // namespace

void register_drawing(Pace pace) {
  for (const std::size_t side : {std::size_t{64}, std::size_t{1024}}) {
    const std::string size = std::string("/").append(std::to_string(side)).append("x").append(std::to_string(side));
    add(pace, std::string("drawing/normals_of_grid").append(size), [side](benchmark::State& timing) {
      time_sheet(timing, side,
                 [](const DrawnSheet& sheet, const auto& state, const auto& to) { normals(sheet.grid, state, to); });
    });
    add(pace, std::string("drawing/normals_of_triangles").append(size), [side](benchmark::State& timing) {
      time_sheet(timing, side, [](const DrawnSheet& sheet, const auto& state, const auto& to) {
        normals(std::span<const Triangle>(sheet.triangles), state, to);
      });
    });
    add(pace, std::string("drawing/bounds").append(size), [side](benchmark::State& timing) {
      time_sheet(timing, side,
                 [](const DrawnSheet&, const auto& state, const auto&) { benchmark::DoNotOptimize(bounds(state)); });
    });
  }
  for (const auto& [words, told] : {std::pair{"without", Told::nothing}, std::pair{"with", Told::contacts}}) {
    add(pace, std::string("report/hopping/") + words,
        [told = told](benchmark::State& timing) { time_report(timing, told, floor(), start_hopping<float>); });
    add(pace, std::string("report/resting/") + words,
        [told = told](benchmark::State& timing) { time_report(timing, told, ground(), start_resting<float>); });
  }
}

}  // namespace dvdx::bench
