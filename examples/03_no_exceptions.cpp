// Compiled without exceptions and without run-time types, as many engines are: every fault is a value.
#include <cstdio>
#include <dvdx/build_info.hpp>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>

#if defined(__cpp_exceptions) || defined(__cpp_rtti)
#error "to be compiled with -fno-exceptions -fno-rtti"
#endif

int main() {
  if (!dvdx::is_compatible()) return std::puts("another dvdx than these headers"), 1;
  std::puts(dvdx::build_info().text().c_str());

  dvdx::Scene scene;
  scene.add(dvdx::Spring{.stiffness = -40.0});  // a mistake
  const auto wrong = dvdx::compile<float>(scene, {.step = 1.0 / 60});
  if (wrong) return 1;
  std::printf("refused: %s\n", wrong.error().message().c_str());  // forces[0].stiffness is -40: must be a finite number >= 0
  if (wrong.error().field != "forces[0].stiffness") return 1;

  scene.forces[0] = dvdx::Spring{.stiffness = 40.0, .damping = 0.3};
  const auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60});
  if (!plan) return 1;
  float x = 1, y = 0, z = 0, vx = 0, vy = 0, vz = 0;
  auto state = dvdx::soa(&x, &y, &z, &vx, &vy, &vz, 1);
  if (plan->step(state, 600) != dvdx::StepResult::done) return 1;
  std::printf("after 10 s: x = %.4f m\n", static_cast<double>(x));
  state.count = 2;  // of columns with a capacity of one
  return plan->step(state) == dvdx::StepResult::capacity_too_small ? 0 : 1;
}
