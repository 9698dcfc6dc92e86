// Damping along springs.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "hard_cases/cases.hpp"
#include "hard_cases/plain_springs.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {
namespace {

// --- 45: orders ---------------------------------------------------------------------------------------------------------

constexpr std::size_t side = 12;  // bodies
constexpr double frame = 0.02;    // s
constexpr std::size_t frames = 20;

double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

// 12 x 12 bodies, 0.8 m by 0.8 m and 0.2 kg, flat, at rest and held by two corners.
PlainSprings cloth(double damping, double drag, double anchor) {
  PlainSprings system;
  system.gravity = {0, 0, -9.81};
  system.drag = drag;
  system.anchor = anchor;
  const auto at = [](std::size_t i) { return 0.8 * static_cast<double>(i) / (side - 1); };
  const auto join = [&](std::size_t a, std::size_t b, double stiffness) {
    system.links.push_back({a, b, stiffness, distance(system.bodies[a].x, system.bodies[b].x), damping});
  };
  for (std::size_t i = 0; i < side * side; ++i) {
    system.bodies.push_back({{at(i / side), at(i % side), 0}, {}});
    system.mass.push_back(i == 0 || i == side - 1 ? 0 : 0.2 / (side * side));
  }
  for (std::size_t row = 0; row < side; ++row) {
    for (std::size_t column = 0; column < side; ++column) {
      const std::size_t i = row * side + column;
      if (column + 1 < side) join(i, i + 1, 2000);
      if (row + 1 < side) join(i, i + side, 2000);
      if (column + 1 < side && row + 1 < side) join(i, i + side + 1, 1000);
      if (column > 0 && row + 1 < side) join(i, i + side - 1, 1000);
      if (column + 2 < side) join(i, i + 2, 200);
      if (row + 2 < side) join(i, i + 2 * side, 200);
    }
  }
  return system;
}

struct Damped {
  double damping, drag, anchor;      // kg/s, 1/s, 1/s^2
  std::size_t reference;             // steps a frame of the plain Runge-Kutta loops
  int coarse_second, coarse_fourth;  // sub-steps of the coarser run of two
};
constexpr std::array<Damped, 6> scenes{{{0.02, 0, 0, 1280, 160, 40},
                                        {0.2, 0, 0, 1280, 160, 40},
                                        {1, 0, 0, 2560, 640, 160},
                                        {0.02, 0.5, 400, 1280, 160, 40},
                                        {0.2, 0.5, 400, 1280, 160, 40},
                                        {1, 0.5, 400, 2560, 640, 160}}};

// Root mean square error over the bodies at the end, relative to plain Runge-Kutta loops.
double error(CaseRun& way, const PlainSprings& system, const std::vector<Start>& exact, Coupling coupling, int substeps) {
  coupling.substeps = substeps;
  Trial<double> trial(way, scene_of(system, coupling), frame, system.bodies);
  trial.step(frames);
  double squares = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    squares += std::pow(distance({trial.x(0, i), trial.x(1, i), trial.x(2, i)}, exact[i].x), 2);
  }
  return std::sqrt(squares / static_cast<double>(exact.size()));
}

PlainSprings cloth_of(const Damped& one) { return cloth(one.damping, one.drag, one.anchor); }

// The final states of the cloths, computed once for all schemes.
const std::vector<Start>& end_of(std::size_t which) {
  static const auto ends = [] {
    std::array<std::vector<Start>, scenes.size()> list;
    for (std::size_t i = 0; i < list.size(); ++i) {
      list[i] = run_plain(cloth_of(scenes[i]), frame * frames, scenes[i].reference * frames);
    }
    return list;
  }();
  return ends[which];
}

// The order, from halving the sub-step once. Returns its distance from the order that the scheme claims.
template <Scheme scheme>
Worst order(CaseRun& way) {
  constexpr bool is_fourth = scheme == Scheme::fourth_order;
  Worst worst;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Damped& one = scenes[i];
    const PlainSprings system = cloth_of(one);
    const std::vector<Start>& exact = end_of(i);
    const Coupling coupling{.scheme = scheme};
    const int coarse = is_fourth ? one.coarse_fourth : one.coarse_second;
    const double halved = error(way, system, exact, coupling, coarse) / error(way, system, exact, coupling, 2 * coarse);
    worst.see(std::abs(std::log2(halved) - (is_fourth ? 4 : 2)),
              fmt::format("{:g} kg/s{}", one.damping, one.drag != 0 ? ", drag and anchors" : ""));
  }
  return worst;
}

Bar order_of(Check check, double limit, std::string_view expected) {
  return {.precision = float64, .check = check, .limit = limit, .unit = "", .expected = expected, .runs_on = RunsOn::best_isa};
}

}  // namespace

std::vector<Case> damping_cases() {
  return {{45,
           "damping along springs",
           "0.02, 0.2 and 1 kg/s on a cloth, drag and anchors besides: a pulse that depends on the velocity",
           {order_of(order<Scheme::leapfrog>, 0.1, "leapfrog: order 2"),
            order_of(order<Scheme::fourth_order>, 0.2, "fourth_order: order 4")}}};
}

}  // namespace dvdx::tool::stability
