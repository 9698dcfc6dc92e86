// The contact pass: the time of impact, and paths that bend within a step, by every table of every ISA.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/contacts.hpp"
#include "kernel/passes/particles.hpp"
#include "support/oracle.hpp"

namespace dvdx::test::contacts::time_test {

TEST_CASE("time of impact on a parabola, with drag and on an oscillator") {
  const Oracle oracle("toi.csv");
  for_each_kernels<double>([&](const Kernels<double>& kernels, const std::string& words) {
    CAPTURE(words);
    double worst_parabola = 0;
    double worst_other = 0;
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      const auto row = oracle[i];
      const double h = row["h_s"];
      const double v0 = row["v0_m_s"];
      // x moves at a constant 1 m/s until the impact stops it, so x gives the time.
      Particles<double> particles(kernels, h, still);
      Plane surface = floor_with(1);
      surface.viscosity = std::numeric_limits<double>::infinity();
      particles.add(surface);
      Terms<double>& terms = particles.terms;
      // x1, v1 of the exact motion: a drift with the difference as offsets.
      terms.fused[1].S = 0;
      terms.fused[1].B = 1;
      particles.set_offsets(1, row["v_end_free"], row["s_end_free"] - row["s0_m"]);
      particles.set_all(state<double>(0, row["s0_m"], 0, 1, v0, 0));
      particles.step();
      const double f = particles.at(8).x[0] / h;
      const double error = std::abs(f - row["f_exact"]);
      const std::string kind = row.text("kind");
      if (kind == "parabola") {
        worst_parabola = std::max(worst_parabola, error);
      } else if (row["g_1_s"] * h <= 0.1 && std::sqrt(row["W_1_s2"]) * h <= 0.3) {
        worst_other = std::max(worst_other, error);
      }
    }
    MESSAGE(words << ": parabola " << worst_parabola << ", others " << worst_other);
    CHECK(worst_parabola <= 1e-12);
    CHECK(worst_other <= 3e-3);
  });
}

TEST_CASE_TEMPLATE("dips within a step", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    // A lift of 2 * 60 m/s^2: down at speed v, up again, ending as high as it started.
    const double h = 0.1;
    const double lift = 40;
    for (const bool finds : {true, false}) {
      Particles<T> particles(kernels, h, {0, lift, 0});
      particles.add(floor_with(1), finds);
      particles.set_all(state<T>(0, 0.01, 0, 0, -lift * h / 2, 0));
      particles.step();
      const State3<T> end = particles.at(0);
      const double energy = -lift * static_cast<double>(end.x[1]) + static_cast<double>(end.v[1] * end.v[1]) / 2;
      const double before = -lift * 0.01 + lift * h / 2 * lift * h / 2 / 2;
      CHECK(std::abs(energy - before) <= 100 * eps<T>);
      CHECK((std::abs(static_cast<double>(end.x[1]) - 0.01) < 1e-6) == !finds);
    }
  });
}

// The path stays above the floor. A parabola through its ends with its first velocity would dip into it.
TEST_CASE("a path that bends too much for a parabola is not taken for one that dips into a surface") {
  const auto height_after = [](const Force& force, Method method, double y, double v) {
    Scene scene;
    scene.method = method;
    scene.add(force);
    scene.add(floor_with(1));
    Soa<double> memory(1);
    State<double> state = memory.view();
    state.x[1][0] = y;
    state.v[1][0] = v;
    (void)compile<double>(scene, {.step = 1})->step(state);
    return state.x[1][0];
  };
  // Drag of 5/s: y = 1 - 4 (1 - exp(-5))/5
  for (const Method method : {Method::combined, Method::exact}) {
    CHECK(std::abs(height_after(Drag{.coefficient = 5.0}, method, 1, -4) - (1 + 0.8 * std::expm1(-5.0))) <= 1e-14);
  }
  // A spring of 4 rad/s, whose lowest point is 0.01 m above the floor: y = 1 + 0.99 cos(4 t + 2)
  const Spring spring{.stiffness = 16.0, .anchor = Vec3{0, 1, 0}};
  const double y = 1 + 0.99 * std::cos(2.0), v = -4 * 0.99 * std::sin(2.0);
  CHECK(std::abs(height_after(spring, Method::combined, y, v) - (1 + 0.99 * std::cos(6.0))) <= 1e-13);
}

}  // namespace dvdx::test::contacts::time_test
