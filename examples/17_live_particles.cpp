// Particles that come and go while a body and the nozzle that makes them move, the nozzle is switched off and bursts, and frame
// times vary.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <dvdx/layouts/aos.hpp>
#include <dvdx/live.hpp>
#include <vector>

namespace {

struct Spark {
  float position[3], velocity[3], age, lifetime;
};
constexpr std::size_t capacity = 20000;

const dvdx::Sphere body{.center = {0, 0.6, 0}, .radius = 0.4, .restitution = 0.3};
dvdx::Vec3 body_at(double time) { return {0.5 * std::sin(2 * time), 0, 0}; }
dvdx::Pose nozzle_at(double time) { return {.translation = {std::sin(time), 0, 0}, .rotation = {0, time, 0}}; }

}  // namespace

int main() {
  std::vector<Spark> sparks(capacity);
  dvdx::LiveState<float> live{.state = dvdx::aos(sparks[0].position, sparks[0].velocity, sizeof(Spark), capacity),
                              .age = dvdx::field(&sparks[0].age, sizeof(Spark), capacity),
                              .lifetime = dvdx::field(&sparks[0].lifetime, sizeof(Spark), capacity)};
  live.state.count = 0;
  dvdx::Scene scene;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Plane{.restitution = 0.4, .friction = 0.3});
  const dvdx::MotionId ball = add_body(scene, body);
  const dvdx::MotionId hand = add_motion(scene);
  dvdx::Emitter nozzle{.shape = dvdx::Disc{.center = {0, 2, 0}, .normal = {0, 1, 0}, .radius = 0.05},
                       .rate = 3000,
                       .velocity = {3, -2, 0},
                       .spread = 0.5,
                       .least_lifetime = 1.0,
                       .most_lifetime = 2.0,
                       .seed = 7,
                       .motion = static_cast<std::size_t>(hand)};
  dvdx::Lifecycle turnover{.emitters = {}, .removal = {}, .capacity = capacity};
  const dvdx::EmitterId jet = add_emitter(turnover, nozzle);
  auto plan = dvdx::compile<float>(scene, turnover, {.step = 1.0 / 60});
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  double time = 0;
  float deepest = 0;
  for (int frame = 0; frame < 200; ++frame) {
    const double frame_time = frame % 2 == 0 ? 1.0 / 50 : 1.0 / 80;
    time += frame_time;
    if (!plan->set_step(frame_time) || !plan->set_pose(ball, {.translation = body_at(time)}) ||
        !plan->set_pose(hand, nozzle_at(time))) {
      return 1;
    }
    if (frame == 120) {
      nozzle.rate = 0;  // off
      if (!plan->set_emitter(jet, nozzle)) return 1;
    }
    if (frame == 150 && !plan->burst(live, jet, 1000)) return 1;
    if (plan->step(live) != dvdx::StepResult::done) return 1;
    for (std::size_t i = 0; i < live.state.count; ++i) {
      if (sparks[i].age < 0.02F) continue;  // is born where the nozzle is
      const auto& x = sparks[i].position;
      const double r = std::hypot(x[0] - body_at(time)[0], x[1] - body.center[1], x[2]);
      deepest = std::max(deepest, static_cast<float>(body.radius - r));
    }
  }
  std::printf("after %.2f s %zu of %llu sparks are there; none was more than %.1e m in the body\n", live.state.clock.seconds,
              live.state.count, static_cast<unsigned long long>(live.born), static_cast<double>(deepest));
  return live.born > 6500 && live.born < 7500 && live.state.count > 0 && live.state.count < live.born && deepest < 1e-4F ? 0
                                                                                                                         : 1;
}
