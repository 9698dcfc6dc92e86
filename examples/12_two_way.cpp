// A rigid ball of the program's own falls onto a cloth and comes to rest on it. The cloth pushes the ball by the impulse and
// the torque of the plan's report, the program moves it, and set_pose hands it back to the plan as a contact.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>

namespace {

constexpr std::size_t side = 32;
constexpr double frame = 1.0 / 240;  // s
constexpr double g = 9.81;           // m/s^2
constexpr double radius = 0.15;      // m
constexpr double mass = 0.3;         // kg
constexpr double inertia = 0.4 * mass * radius * radius;
constexpr double air = 1.5;  // 1/s, brakes the ball

// The state of the ball, which the program moves itself.
struct Ball {
  dvdx::Vec3 x{0.5, 0.4, 0.5}, v{};  // m, m/s
  dvdx::Vec3 omega{0, 0, 3};         // rad/s
  dvdx::Vec3 turn{};                 // a rotation vector: exact while the axis stays the same

  // Adds the changes of velocity by gravity, the air and the cloth in the last frame, then moves the ball at the new velocity.
  void move(const dvdx::Vec3& impulse, const dvdx::Vec3& torque) {
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] += impulse[k] / mass - frame * (air * v[k] + (k == 1 ? g : 0));
      omega[k] += torque[k] / inertia - frame * air * omega[k];
      x[k] += frame * v[k];
      turn[k] += frame * omega[k];
    }
  }
};

}  // namespace

int main() {
  Ball ball;
  const dvdx::Vec3 start = ball.x;

  dvdx::Scene scene;
  scene.mass = 0.4 / (side * side);
  scene.add(dvdx::Constant{.acceleration = {0, -g, 0}});
  scene.add(dvdx::Drag{.coefficient = 4e-3});
  scene.add(dvdx::Network(
      dvdx::Grid{.rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 400, .damping = 0.05}));
  for (std::size_t i = 0; i < side * side; ++i) {  // pinned all around
    if (i % side == 0 || i % side == side - 1 || i / side == 0 || i / side == side - 1) scene.fixed.push_back(i);
  }
  scene.add(dvdx::Motion{.center = start, .keys = {{.time = 0}}});
  scene.add(dvdx::Sphere{.center = start, .radius = radius, .friction = 0.5, .motion = 0});

  dvdx::Soa<double> particles(side * side);
  auto state = particles.view();
  for (std::size_t i = 0; i < state.count; ++i) {
    state.x[0][i] = static_cast<double>(i % side) / (side - 1);
    state.x[2][i] = static_cast<double>(i / side) / (side - 1);
  }
  auto plan = dvdx::compile<double>(scene, {.step = frame}, state);
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  dvdx::ContactReport report(1);
  double lowest = ball.x[1];
  double fastest = 0;  // in the last second, m/s
  double lifted = 0;   // N s, in the last second
  constexpr int frames = 10 * 240;
  for (int n = 0; n < frames; ++n) {
    const dvdx::ContactSum met = report.of(0);
    report.clear();
    ball.move(met.impulse, met.torque_impulse);
    const dvdx::Pose pose{.translation = {ball.x[0] - start[0], ball.x[1] - start[1], ball.x[2] - start[2]},
                          .rotation = ball.turn};
    if (!plan->set_pose(0, pose)) return 1;
    if (plan->step(state, report) != dvdx::StepResult::done) return 1;
    lowest = std::min(lowest, ball.x[1]);
    if (n < frames - 240) continue;
    fastest = std::max(fastest, std::sqrt(ball.v[0] * ball.v[0] + ball.v[1] * ball.v[1] + ball.v[2] * ball.v[2]));
    lifted += report.of(0).impulse[1];
  }
  const double height = ball.x[1] - radius;
  std::printf(
      "the ball's lowest point rests at %.3f m (it was down to %.3f m) and moves by %.1e m/s; the cloth carries %.4f of it\n",
      height, lowest - radius, fastest, lifted / (mass * g));
  const bool rests = fastest < 0.02 && std::abs(lifted / (mass * g) - 1) < 0.01;
  return rests && height < -0.02 && height > -0.5 && std::isfinite(height) ? 0 : 1;
}
