// Grains that are poured into a box: they meet each other and its walls, heap up and come to rest.
#include <algorithm>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>

namespace {

constexpr std::size_t along = 8;  // grains, along two sides
constexpr std::size_t layers = 10;
constexpr double radius = 0.01;  // m
constexpr double half = 0.1;     // m, of the box

// A little more than a diameter apart, and every other layer aside, so that grains fall between those below.
void pour(const dvdx::State<float>& state) {
  const double apart = 2.05 * radius;
  for (std::size_t i = 0; i < state.count; ++i) {
    const std::size_t layer = i / (along * along);
    const double aside = layer % 2 == 0 ? 0.0 : radius;
    state.x[0][i] = static_cast<float>(static_cast<double>(i % along) * apart - 0.075 + aside);
    state.x[1][i] = static_cast<float>(0.05 + static_cast<double>(layer) * apart);
    state.x[2][i] = static_cast<float>(static_cast<double>(i / along % along) * apart - 0.075 - aside);
  }
}

}  // namespace

int main() {
  dvdx::Scene scene;
  scene.mass = 0.01;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.4});
  for (const double side : {-1.0, 1.0}) {
    scene.add(dvdx::Plane{.normal = {-side, 0, 0}, .offset = -half});
    scene.add(dvdx::Plane{.normal = {0, 0, -side}, .offset = -half});
  }
  scene.add(dvdx::Meet{.radius = radius, .restitution = 0.2, .friction = 0.4});

  dvdx::Soa<float> memory(along * along * layers);
  dvdx::State<float> grains = memory.view();
  pour(grains);
  const auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60}, grains);
  if (!plan) return std::puts(plan.error().message().c_str()), 1;
  for (int frame = 0; frame < 60; ++frame) {
    // A particle that finds more than Meet::most_neighbours others within reach ends the step: the state is as it was before.
    if (plan->step(grains) != dvdx::StepResult::done) return std::puts("a grain has too many neighbours"), 1;
  }

  const dvdx::Meetings met = plan->meetings();
  float lowest = grains.x[1][0];
  float highest = lowest;
  for (std::size_t i = 0; i < grains.count; ++i) {
    lowest = std::min(lowest, grains.x[1][i]);
    highest = std::max(highest, grains.x[1][i]);
  }
  std::printf(
      "%zu grains between %.3f and %.3f m, %.1f meetings each, overlap %.1f %% on average; %llu lists in %llu sub-steps\n",
      grains.count, static_cast<double>(lowest), static_cast<double>(highest), met.touching, 100 * met.overlap_mean,
      static_cast<unsigned long long>(met.rebuilt), static_cast<unsigned long long>(met.substeps));
  const bool lies = static_cast<double>(lowest) > 0.9 * radius && static_cast<double>(highest) < 0.25;
  return lies && met.touching > 2 && met.overlap_mean < 0.05 ? 0 : 1;
}
