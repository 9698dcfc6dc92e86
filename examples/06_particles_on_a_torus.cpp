// Particles that slide on a surface of your own: a torus about the y axis. Any layout will do; here an array of structs.
#include <array>
#include <cmath>
#include <cstdio>
#include <dvdx/constrain.hpp>
#include <dvdx/layouts/aos.hpp>
#include <dvdx/layouts/convert.hpp>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>
#include <vector>

namespace {

struct Particle {
  float position[3];
  float age;
  float velocity[3];
};

struct OnTorus {
  double ring, tube;  // m, radii

  template <class R>
  R operator()(const std::array<R, 3>& x, std::array<R, 3>& gradient) const {
    const R around = sqrt(x[0] * x[0] + x[2] * x[2]);
    const R out = around - ring;
    gradient = {2.0 * out * x[0] / around, 2.0 * x[1], 2.0 * out * x[2] / around};
    return out * out + x[1] * x[1] - tube * tube;
  }
};

double distance_to_core(const Particle& p) {
  const double out = std::hypot(p.position[0], p.position[2]) - 1.0;
  return std::hypot(out, static_cast<double>(p.position[1]));
}

}  // namespace

int main() {
  constexpr std::size_t count = 2000;
  std::vector<Particle> particles(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double turn = 0.37 * static_cast<double>(i);
    const double tilt = 0.11 * static_cast<double>(i);
    const double out = 1.0 + 0.3 * std::cos(tilt);
    particles[i] = {.position = {static_cast<float>(out * std::cos(turn)), static_cast<float>(0.3 * std::sin(tilt)),
                                 static_cast<float>(out * std::sin(turn))},
                    .age = 0,
                    .velocity = {0, 0, 0}};
  }
  dvdx::State<float> state = dvdx::aos(particles, &Particle::position, &Particle::velocity);
  dvdx::Soa<float> memory(count);
  dvdx::State<float> before = memory.view();

  dvdx::Scene scene;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Drag{.coefficient = 0.5, .wind = {2, 0, 0}});
  const auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 120});
  if (!plan) return std::puts(plan.error().message().c_str()), 1;
  for (int step = 0; step < 600; ++step) {
    dvdx::copy(state, before);
    (void)plan->step(state);
    dvdx::constrain(before, state, plan->step_size(), OnTorus{1.0, 0.3});
  }

  double off = 0;
  for (const Particle& p : particles) off = std::fmax(off, std::fabs(distance_to_core(p) - 0.3));
  std::printf("after 5 s: at most %.1e m off the torus\n", off);
  return off < 1e-6 ? 0 : 1;
}
