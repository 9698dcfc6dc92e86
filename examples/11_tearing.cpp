// A sheet that tears while it runs: held by its corners, it is fine until one of its particles grows heavy. Springs that are
// stretched too far are torn, a millionth of a second each; the plan is never compiled again.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>
#include <vector>

namespace {

constexpr std::size_t side = 24;
constexpr std::size_t middle = side / 2 * side + side / 2;
constexpr double spacing = 1.0 / (side - 1);  // m
constexpr double tears_at = 1.6;              // times its length

// A spring of the sheet that the program looks at: between neighbours of a row or a column.
struct Thread {
  std::array<std::uint32_t, 2> ends;
  bool is_whole = true;
};

std::vector<Thread> threads() {
  std::vector<Thread> all;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    if (i % side + 1 < side) all.push_back({.ends = {i, i + 1}});
    if (i / side + 1 < side) all.push_back({.ends = {i, i + static_cast<std::uint32_t>(side)}});
  }
  return all;
}

double stretch(const dvdx::State<float>& state, const Thread& thread) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = double{state.x[axis][thread.ends[1]]} - double{state.x[axis][thread.ends[0]]};
    square += d * d;
  }
  return std::sqrt(square) / spacing;
}

// Tears what is stretched too far. How many springs that were, or -1.
int tear(dvdx::Plan<float>& plan, const dvdx::State<float>& state, std::vector<Thread>& all) {
  int torn = 0;
  for (Thread& thread : all) {
    if (!thread.is_whole || stretch(state, thread) < tears_at) continue;
    if (const auto done = plan.break_spring(0, thread.ends); !done) return std::puts(done.error().message().c_str()), -1;
    thread.is_whole = false;
    ++torn;
  }
  return torn;
}

}  // namespace

int main() {
  dvdx::Scene scene;
  scene.mass = 0.2 / (side * side);
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Drag{.coefficient = 5e-5});
  scene.add(dvdx::Network(
      dvdx::Grid{.rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 60, .damping = 0.002}));
  scene.fixed = {0, side - 1, side * (side - 1), side * side - 1};

  dvdx::Soa<float> particles(side * side);
  auto state = particles.view();
  for (std::size_t i = 0; i < state.count; ++i) {
    state.x[0][i] = static_cast<float>(spacing * static_cast<double>(i % side));
    state.x[2][i] = static_cast<float>(spacing * static_cast<double>(i / side));
  }
  auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60}, state);
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  std::vector<Thread> all = threads();
  int torn_before = 0;
  int torn = 0;
  for (int frame = 0; frame < 180; ++frame) {
    if (frame == 60) {
      torn_before = torn;
      if (const auto heavy = plan->set_mass(middle, 1.0); !heavy) return std::puts(heavy.error().message().c_str()), 1;
    }
    if (plan->step(state) != dvdx::StepResult::done) return 1;
    const int now = tear(*plan, state, all);
    if (now < 0) return 1;
    torn += now;
  }
  const float depth = state.x[1][middle];
  std::printf("%d springs torn before, %d after; the heavy particle is %.1f m below\n", torn_before, torn - torn_before,
              -depth);
  return torn_before == 0 && torn >= 4 && depth < -5 && std::isfinite(state.x[1][1]) ? 0 : 1;
}
