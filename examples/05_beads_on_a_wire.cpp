// Beads that slide without friction on a wire of your own: two surfaces whose common line is the wire y = x^2 in the plane z =
// 0.
#include <array>
#include <cmath>
#include <cstdio>
#include <dvdx/constrain.hpp>
#include <dvdx/layouts/convert.hpp>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>

namespace {

struct Parabola {  // y - x^2 = 0
  template <class R>
  R operator()(const std::array<R, 3>& x, std::array<R, 3>& gradient) const {
    gradient = {-2.0 * x[0], 1.0, 0.0};
    return x[1] - x[0] * x[0];
  }
};

struct Flat {  // z = 0
  template <class R>
  R operator()(const std::array<R, 3>& x, std::array<R, 3>& gradient) const {
    gradient = {0.0, 0.0, 1.0};
    return x[2];
  }
};

}  // namespace

int main() {
  constexpr std::size_t count = 1000;
  constexpr double g = 9.81;
  dvdx::Soa<double> beads(count);
  dvdx::Soa<double> memory(count);
  dvdx::State<double> state = beads.view();
  dvdx::State<double> before = memory.view();
  for (std::size_t i = 0; i < count; ++i) {
    const double x = 0.001 * static_cast<double>(i + 1);
    const std::array<double, 3> at = {x, x * x, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = at[axis];
      state.v[axis][i] = 0;
    }
  }

  dvdx::Scene scene;
  scene.add(dvdx::Constant{.acceleration = {0, -g, 0}});
  const auto plan = dvdx::compile<double>(scene, {.step = 1.0 / 240});
  if (!plan) return std::puts(plan.error().message().c_str()), 1;
  for (int step = 0; step < 240; ++step) {
    dvdx::copy(state, before);
    (void)plan->step(state);
    dvdx::constrain(before, state, plan->step_size(), Parabola{}, Flat{});
  }

  double off = 0;
  double energy = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = state.x[0][i];
    const double speed = std::hypot(state.v[0][i], state.v[1][i], state.v[2][i]);
    const double start = 0.001 * static_cast<double>(i + 1);
    off = std::fmax(off, std::fabs(state.x[1][i] - x * x));
    energy = std::fmax(energy, std::fabs(speed * speed / 2 + g * state.x[1][i] - g * start * start));
  }
  std::printf("after 1 s: at most %.1e m off the wire, energy within %.1e J/kg\n", off, energy);
  return off < 1e-12 && energy < 1e-4 ? 0 : 1;
}
