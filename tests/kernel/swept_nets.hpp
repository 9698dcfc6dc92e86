// Ropes and sheets that hang on held particles, stepped by sweeps, and where they come to rest.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"

namespace swept_nets {

using namespace dvdx;

inline constexpr double g = 9.81;
inline constexpr double link = 0.01;    // kg
inline constexpr double length = 0.1;   // m
inline constexpr double drag_rate = 3;  // 1/s
inline constexpr double seconds = 4;    // until everything is at rest
inline constexpr double frame = 1.0 / 60;

struct Net {
  Scene scene;
  std::vector<Vec3> start;
  double side = 0;  // m
  Options options{.step = frame, .isa = Isa::reference};
};

inline Scalars drags(const Scalars& mass, std::size_t count) {
  std::vector<double> each;
  for (std::size_t i = 0; i < count; ++i) each.push_back(drag_rate * mass[i]);
  return each;
}

struct LoadedRope {
  std::size_t springs;
  double k, load;  // N/m; in masses of a link
};

// Particles along a direction, joined by springs, the last one `load` times as heavy as a link.
inline Net rope(std::size_t springs, double k, double load, const Vec3& along) {
  Net net;
  Springs list{.pairs = {}, .stiffness = k, .rest_length = Scalars(length)};
  std::vector<double> mass(springs + 1, link);
  mass.back() *= load;
  for (std::uint32_t i = 0; i <= springs; ++i) {
    if (i < springs) list.pairs.push_back({i, i + 1});
    net.start.push_back({along[0] * length * i, along[1] * length * i, along[2] * length * i});
  }
  net.scene.mass = mass;
  net.scene.fixed = {0};
  net.scene.add(Network(list));
  net.scene.add(Constant{.acceleration = {0, -g, 0}});
  net.scene.add(Drag{.coefficient = PerAxis(drags(net.scene.mass, springs + 1))});
  net.scene.coupling.scheme = Scheme::sequential;
  net.side = static_cast<double>(springs) * length;
  net.scene.coupling.lines = Lines::none;  // with lines, few sub-steps are enough
  return net;
}
inline Net hung_rope(std::size_t springs, double k, double load) { return rope(springs, k, load, {0, -1, 0}); }

// A sheet of 1 m and 1 kg that hangs from its corners, or from its upper edge.
enum class Held { corners, edge };
inline Net sheet(std::size_t side, double k, double shear, Held held) {
  Net net;
  const double cells = static_cast<double>(side - 1);
  net.scene.mass = 1 / static_cast<double>(side * side);
  for (std::size_t i = 0; i < side * side; ++i) {
    net.start.push_back({static_cast<double>(i % side) / cells, -static_cast<double>(i / side) / cells, 0});
  }
  for (std::size_t column = 0; column < side; ++column) {
    if (held == Held::edge || column == 0 || column + 1 == side) net.scene.fixed.push_back(column);
  }
  net.scene.add(
      Network(Grid{.rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, -1, 0}, .structural = k, .shear = shear}));
  net.scene.add(Constant{.acceleration = {0, -g, 0}});
  net.scene.add(Drag{.coefficient = PerAxis(drag_rate * net.scene.mass[0])});
  net.scene.coupling.scheme = Scheme::sequential;
  net.side = 1;
  return net;
}

inline Soa<double> placed(const Net& net) {
  Soa<double> memory(net.start.size());
  State<double> state = memory.view();
  for (std::size_t i = 0; i < net.start.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = net.start[i][axis];
  }
  return memory;
}

inline Plan<double> plan_of(const Net& net) {
  Soa<double> memory = placed(net);
  auto plan = compile<double>(net.scene, net.options, memory.view());
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

inline NetworkLimit limit_of(const Net& net) { return plan_of(net).network_limit().value(); }

// m: the height of the lowest particle at rest.
inline double lowest(const Net& net) {
  Soa<double> memory = placed(net);
  State<double> state = memory.view();
  const auto plan = compile<double>(net.scene, net.options, state);
  REQUIRE(plan.has_value());
  REQUIRE(plan->step(state, static_cast<std::uint64_t>(std::lround(seconds / net.options.step))) == StepResult::done);
  double y = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < state.count; ++i) y = std::min(y, state.x[1][i]);
  return y;
}

inline double lowest_by(Net net, Scheme scheme, std::optional<int> substeps) {
  net.scene.coupling.scheme = scheme;
  net.scene.coupling.substeps = substeps;
  return lowest(net);
}

// The equilibrium, in which each spring carries the weight below it.
inline double lowest_of_rope(std::size_t springs, double k, double load) {
  double y = -static_cast<double>(springs) * length;
  for (std::size_t s = 0; s < springs; ++s) y -= g * link * (static_cast<double>(springs - 1 - s) + load) / k;
  return y;
}

}  // namespace swept_nets
