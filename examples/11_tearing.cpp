// A sheet that tears while it runs: held by its corners, it is fine until one of its particles grows heavy. After each frame
// the springs that are stretched too far are torn; the plan is never compiled again.
#include <cmath>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>

namespace {

constexpr std::size_t side = 24;
constexpr std::size_t middle = side / 2 * side + side / 2;
constexpr double spacing = 1.0 / (side - 1);  // m
constexpr double tears_at = 1.6;              // times its rest length

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

  std::size_t torn_before = 0;
  std::size_t torn = 0;
  for (int frame = 0; frame < 180; ++frame) {
    if (frame == 60) {
      torn_before = torn;
      if (const auto heavy = plan->set_mass(middle, 1.0); !heavy) return std::puts(heavy.error().message().c_str()), 1;
    }
    if (plan->step(state) != dvdx::StepResult::done) return 1;
    const auto now = plan->tear(0, tears_at, state);
    if (!now) return std::puts(now.error().message().c_str()), 1;
    torn += *now;
  }
  const float depth = state.x[1][middle];
  std::printf("%zu springs torn before, %zu after; the heavy particle is %.1f m below\n", torn_before, torn - torn_before,
              -depth);
  return torn_before == 0 && torn >= 4 && depth < -5 && std::isfinite(state.x[1][1]) ? 0 : 1;
}
