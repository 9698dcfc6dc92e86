// A curtain between two hands, and a ball that is pushed through it: both move where the program has them each frame. Nothing
// is compiled again, and neither jumps: in every sub-step they are on the way, with the velocity of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>
#include <vector>

namespace {

constexpr std::size_t side = 24;
constexpr double frame = 1.0 / 60;  // s
constexpr double radius = 0.2;      // m, of the ball

// The upper corners sway sideways, half a metre to each side in two seconds.
std::array<dvdx::Vec3, 2> hands(double time) {
  const double sway = 0.5 * std::sin(3.14159265358979 * time);
  return {dvdx::Vec3{sway, 1, 0}, dvdx::Vec3{1 + sway, 1, 0}};
}

// From a metre before the curtain to half a metre behind it, at 0.5 m/s.
dvdx::Vec3 ball(double time) { return {0.5, 0.4, std::min(0.5 * time - 1, 0.5)}; }

}  // namespace

int main() {
  dvdx::Scene scene;
  scene.mass = 0.2 / (side * side);
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Drag{.coefficient = 2e-4});
  scene.add(dvdx::Network(dvdx::Grid{
      .rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, -1, 0}, .structural = 60, .damping = 0.005}));
  scene.add(dvdx::Motion{.center = ball(0), .keys = {{.time = 0}}});  // of the ball, at rest until it is told where to go
  scene.add(dvdx::Motion{.keys = {{.time = 0}}});                     // of the hands
  scene.add(dvdx::Kinematic{.particles = {0, side - 1}, .motion = 1});
  scene.add(dvdx::Sphere{.center = ball(0), .radius = radius, .friction = 0.3, .motion = 0});

  dvdx::Soa<float> particles(side * side);
  auto state = particles.view();
  for (std::size_t i = 0; i < state.count; ++i) {
    state.x[0][i] = static_cast<float>(i % side) / (side - 1);
    state.x[1][i] = 1 - static_cast<float>(i / side) / (side - 1);
  }
  auto plan = dvdx::compile<float>(scene, {.step = frame}, state);
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  double nearest = 1e9;  // of any particle to the ball's center, m
  double fastest = 0;    // m/s
  for (int n = 1; n <= 240; ++n) {
    const dvdx::Vec3 center = ball(n * frame);
    const auto pins = hands(n * frame);
    if (!plan->set_pose(0, {.translation = {0, 0, center[2] - ball(0)[2]}}) || !plan->set_places(0, pins)) return 1;
    if (plan->step(state) != dvdx::StepResult::done) return 1;
    for (std::size_t i = 0; i < state.count; ++i) {
      const auto away = [&](std::size_t axis) { return double{state.x[axis][i]} - center[axis]; };
      nearest = std::min(nearest, std::sqrt(away(0) * away(0) + away(1) * away(1) + away(2) * away(2)));
      const auto speed = [&](std::size_t axis) { return double{state.v[axis][i]}; };
      fastest = std::max(fastest, std::sqrt(speed(0) * speed(0) + speed(1) * speed(1) + speed(2) * speed(2)));
    }
  }
  const auto pins = hands(240 * frame);
  const double missed = std::abs(double{state.x[0][0]} - pins[0][0]);
  std::printf("no particle nearer to the ball than %.4f m (its radius is %.1f), none faster than %.1f m/s; pins %.1e m off\n",
              nearest, radius, fastest, missed);
  return nearest > radius - 1e-4 && nearest < radius + 0.01 && fastest < 15 && missed < 1e-6 ? 0 : 1;
}
