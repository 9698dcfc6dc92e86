// Your own array of structs, whatever else it holds: a million particles thrown into the wind over a floor.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <dvdx/layouts/aos.hpp>
#include <dvdx/plan.hpp>
#include <vector>

namespace {

struct Particle {  // with fields of its own, and unnamed bytes that the compiler puts between them
  std::uint8_t kind;
  float position[3];
  double age;
  float velocity[3];
};

}  // namespace

int main() {
  std::vector<Particle> particles(1'000'000);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const auto x = static_cast<float>(i) * 1e-3F;
    particles[i] = {.kind = 7, .position = {x, 1, 0}, .age = 0.25, .velocity = {0, 2, 1}};
  }

  dvdx::Scene scene;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Drag{.coefficient = 0.02, .wind = {3, 0, 0}});
  scene.add(dvdx::Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60});
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  auto state = dvdx::aos(particles, &Particle::position, &Particle::velocity);  // a view: nothing is copied
  if (plan->step(state, 60) != dvdx::StepResult::done) return 1;
  std::printf("after 1 s the last particle is %.3f m high; %s steps them\n", particles.back().position[1],
              std::string(name(plan->isa())).c_str());

  for (const Particle& p : particles) {
    const bool is_well = std::isfinite(p.position[0]) && p.position[1] >= -1e-5F;
    if (!is_well || p.kind != 7 || p.age != 0.25) return 1;  // what is yours alone is as it was
  }
  return 0;
}
