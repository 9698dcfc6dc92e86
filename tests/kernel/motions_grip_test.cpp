// A grip: two boxes close on an object and lift it by 0.5 m in a second.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/moving.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"

namespace moving::grip_test {

using test::Run;
using test::stepped;

// The faces, 1 cm from the middle, close within 0.2 s to the given overlap. They are at rest from 1.2 s on.
Joined in_grip(Joined joined, double overlap, double friction) {
  joined.name = "grip";
  for (const double side : {-1.0, 1.0}) {
    Motion motion{.center = {}, .keys = {{.time = 0}}};
    const double way = -side * (0.01 + overlap / 2);
    motion.keys.push_back({.time = 0.2, .translation = {0, 0, way}});
    motion.keys.push_back({.time = 1.2, .translation = {0, 0.5, way}});
    joined.scene.add(OrientedBox{.center = {0, 0, 0.02 * side},
                                 .half_extents = {0.6, 0.6, 0.01},
                                 .friction = friction,
                                 .motion = joined.scene.motions.size()});
    joined.scene.add(std::move(motion));
  }
  return joined;
}

Joined grain() {
  Joined joined;
  joined.x = {{0.1, 0.05, 0}};
  joined.v = {{}};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

// A square of 0.6 m.
Joined hung(std::size_t rows, const Coupling& coupling) {
  Joined joined;
  for (std::size_t i = 0; i < rows * rows; ++i) {
    const auto part = [&](std::size_t k) { return 0.6 * (static_cast<double>(k) / static_cast<double>(rows - 1) - 0.5); };
    joined.x.push_back({part(i % rows), part(i / rows), 0});
  }
  joined.v.assign(joined.x.size(), {});
  joined.scene.mass = 0.1 / static_cast<double>(rows * rows);
  joined.scene.add(
      Network(Grid{.rows = rows, .columns = rows, .edge_u = {0.6, 0, 0}, .edge_v = {0, 0.6, 0}, .structural = 50}));
  joined.scene.coupling = coupling;
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

template <class T>
double lowest_rise(const Joined& joined, const Run& run, double seconds) {
  const std::vector<T> end = stepped<T>(joined, run, static_cast<std::size_t>(std::lround(seconds / joined.step)));
  double rise = 1e9;
  for (std::size_t i = 0; i < joined.x.size(); ++i) rise = std::min(rise, static_cast<double>(end[6 * i + 1]) - joined.x[i][1]);
  return rise;
}

// A past defect: the grain fell out as soon as the boxes stopped closing, with any friction.
TEST_CASE_TEMPLATE("motions: a grain that two boxes squeeze is lifted by friction, and slides out without", T, float, double) {
  for (const double step : {1.0 / 20, 1.0 / 60, 1.0 / 200}) {
    for (const double overlap : {0.004, 0.001}) {
      CAPTURE(step);
      CAPTURE(overlap);
      Joined joined = in_grip(grain(), overlap, overlap == 0.004 ? 0.6 : 0.1);
      joined.step = step;
      for (const double seconds : {1.2, 4.0}) CHECK(lowest_rise<T>(joined, {.isa = best_isa()}, seconds) > 0.2);
      CHECK(std::abs(lowest_rise<T>(joined, {.isa = best_isa()}, 4) - lowest_rise<T>(joined, {.isa = best_isa()}, 2)) < 1e-6);
    }
    Joined joined = in_grip(grain(), 0.004, 0);
    joined.step = step;
    CHECK(lowest_rise<T>(joined, {.isa = best_isa()}, 1.2) < -1);
  }
}

TEST_CASE("motions: a grain that two boxes squeeze has the twin's bits on every instruction set") {
  for (const double friction : {0.0, 0.05, 0.6}) {
    Joined joined = in_grip(grain(), 0.004, friction);
    joined.scene.contacts.push_back(Plane{.offset = -0.2, .restitution = 0.5});
    for (std::size_t i = 1; i < 21; ++i) {
      joined.x.push_back({0.3 * test::scatter(i, 0), 0.2 * test::scatter(i, 1), 0.012 * test::scatter(i, 2)});
      joined.v.push_back({test::scatter(i, 3), 0, 0});
    }
    const std::vector<double> wanted = stepped<double>(joined, {}, 30);
    for (const Isa isa : available_isas(Arithmetic::separate)) {
      CAPTURE(name(isa));
      CHECK(wanted == stepped<double>(joined, {.isa = isa}, 30));
    }
  }
}

TEST_CASE("motions: cloth that two boxes squeeze is lifted by friction") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential, Scheme::fourth_order}) {
    CAPTURE(static_cast<int>(scheme));
    const Joined joined = in_grip(hung(4, {.scheme = scheme}), 0.004, 0.6);
    CHECK(lowest_rise<double>(joined, {.isa = best_isa()}, 0.9) > 0.2);
    CHECK(lowest_rise<double>(in_grip(hung(4, {.scheme = scheme}), 0.004, 0), {.isa = best_isa()}, 0.65) < -1);
  }
}

}  // namespace moving::grip_test
