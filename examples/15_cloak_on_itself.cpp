// A cloak that falls in folds: its layers stay a thickness apart, up to a stretch that the plan says, and that is watched here.
#include <algorithm>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>

int main() {
  constexpr std::size_t rows = 28, columns = 16;
  constexpr double side = 0.02;  // m, between neighbours
  dvdx::Scene scene;
  scene.mass = 0.2 / (rows * columns);
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Drag{.coefficient = 1e-5});
  scene.add(dvdx::Network(dvdx::Grid{.rows = rows,
                                     .columns = columns,
                                     .edge_u = {side * (columns - 1), 0, 0},
                                     .edge_v = {0, -side * (rows - 1), 0},
                                     .structural = 300,
                                     .shear = 80,
                                     .bend = 2,
                                     .damping = 0.005}));
  scene.coupling.scheme = dvdx::Scheme::sequential;
  scene.coupling.substeps = 10;
  scene.add(dvdx::Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.5, .thickness = 0.01});
  scene.add(dvdx::Meet{.thickness = 0.95 * side, .friction = 0.3});

  // Upright over the floor and a little out of it, so that it knows which way to fold.
  dvdx::Soa<float> memory(rows * columns);
  dvdx::State<float> cloak = memory.view();
  for (std::size_t i = 0; i < cloak.count; ++i) {
    const double down = static_cast<double>(i / columns) * side;
    cloak.x[0][i] = static_cast<float>(static_cast<double>(i % columns) * side);
    cloak.x[1][i] = static_cast<float>(0.58 - down);
    cloak.x[2][i] = static_cast<float>(0.05 * down);
  }
  const auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60}, cloak);
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  double stretch = 0;
  std::size_t frames_with_folds = 0;
  for (int frame = 0; frame < 45; ++frame) {
    if (plan->step(cloak) != dvdx::StepResult::done) return std::puts("a particle has too many neighbours"), 1;
    stretch = std::max(stretch, plan->check(cloak).stretch);
    if (plan->meetings().touching > 0) ++frames_with_folds;
  }
  const double limit = plan->meetings().stretch_limit;
  std::printf("layers touch in %zu of 45 frames; springs stretch to %.3f of their length, and up to %.3f nothing passes\n",
              frames_with_folds, stretch, limit);
  return frames_with_folds > 10 && limit > 1.3 ? 0 : 1;
}
