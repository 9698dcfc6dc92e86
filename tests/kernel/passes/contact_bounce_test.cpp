// The contact pass: the result of an impact, and bounces compared with closed forms, by every table of every ISA.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/contacts.hpp"
#include "kernel/passes/particles.hpp"
#include "support/oracle.hpp"

namespace dvdx::test::contacts::bounce_test {

TEST_CASE_TEMPLATE("an impact changes a velocity by its restitution, viscosity and friction", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const auto after = [&](double restitution, double viscosity, double friction) {
      Particles<T> particles(kernels, hz60, still);
      Plane ground = floor_with(restitution);
      ground.viscosity = viscosity;
      ground.friction = friction;
      particles.add(ground);
      particles.set_all(state<T>(0, 0.01, 0, 3, -1, 4));
      particles.step();
      return wide(particles.at(11).v);
    };
    const double infinite = std::numeric_limits<double>::infinity();
    const double near = 8 * eps<T>;
    CHECK(after(0, 0, 0) == Vec3{3, 0, 4});
    CHECK(after(1, 0, 0) == Vec3{3, 1, 4});
    CHECK(after(1, infinite, 0) == Vec3{0, 1, 0});
    CHECK(after(0, infinite, 0) == Vec3{0, 0, 0});
    CHECK(after(0.5, 0, infinite) == Vec3{0, 0.5, 0});
    CHECK(std::abs(after(0.5, std::log(4.0), 0)[0] - 0.75) <= near);
    // Coulomb: |dv_t| = mu (1 + e) |v_n| = 0.3 * 1.5, along (3, 4)/5
    const Vec3 rubbed = after(0.5, 0, 0.3);
    CHECK(std::abs(rubbed[0] - (3 - 0.45 * 0.6)) <= 3 * near);
    CHECK(std::abs(rubbed[2] - (4 - 0.45 * 0.8)) <= 4 * near);
  });
}

TEST_CASE_TEMPLATE("sliding friction takes mu g a second", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, gravity);
    Plane ground = floor_with(0.5);
    ground.friction = 0.2;
    particles.add(ground);
    particles.set_all(state<T>(0, 0, 0, 2, 0, 0));
    particles.step(30);
    CHECK(std::abs(static_cast<double>(particles.at(1).v[0]) - (2 - 0.2 * 9.81 / 2)) <= 200 * eps<T>);
    particles.step(60);
    CHECK(particles.at(1).v == std::array<T, 3>{});
    CHECK(particles.at(1).x[1] == T(0));
    // stops at v^2 / (2 mu g), less half a step of the impulse's delay
    CHECK(std::abs(static_cast<double>(particles.at(1).x[0]) - 4 / (2 * 0.2 * 9.81)) <= 2 * hz60);
  });
}

TEST_CASE_TEMPLATE("an elastic bounce keeps its energy", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, gravity);
    particles.add(floor_with(1));
    particles.set_all(state<T>(0, 1, 0, 0, 0, 0));
    double worst = 0;
    for (int n = 0; n < 15000; ++n) {
      particles.step();
      const State3<T> now = particles.at(0);
      const double v = static_cast<double>(now.v[1]);
      worst = std::max(worst, std::abs((9.81 * static_cast<double>(now.x[1]) + v * v / 2) / 9.81 - 1));
    }
    CHECK(worst <= (sizeof(T) == 4 ? 1e-3 : 1e-10));
    MESSAGE(words << ": energy error " << worst);
  });
}

TEST_CASE_TEMPLATE("a bounce that decays comes to rest when it should", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, gravity);
    particles.add(floor_with(0.5));
    particles.set_all(state<T>(0, 1, 0, 0, 0, 0));
    const double rest = std::sqrt(2 / 9.81) * (1 + 2 * 0.5 / (1 - 0.5));
    int n = 0;
    while (n < 200 && (particles.at(0).v[1] != 0 || particles.at(0).x[1] != 0 || n == 0)) {
      particles.step();
      ++n;
    }
    CHECK(n * hz60 >= rest - 1e-9);
    CHECK((n - 1) * hz60 <= rest);
    particles.step(100);
    CHECK(particles.at(0).v[1] == T(0));
    CHECK(particles.at(0).x[1] == T(0));
  });
}

TEST_CASE_TEMPLATE("the seed's response ends the step on the surface", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, still);
    Plane ground = floor_with(1);
    ground.response = Response::end_on_surface;
    particles.add(ground);
    particles.set_all(state<T>(0, 0.01, 0, 3, -2, 0));
    particles.step();
    const State3<T> end = particles.at(13);
    CHECK(std::abs(static_cast<double>(end.x[1])) <= eps<T>);
    CHECK(std::abs(static_cast<double>(end.x[0]) - 3 * hz60) <= 4 * eps<T> * 0.05);
    CHECK(end.v == std::array<T, 3>{3, 2, 0});
  });
}

TEST_CASE("bounces in closed form") {
  const Oracle times("bounce1d_states.csv");
  std::size_t turn = 0;  // each row runs on every third table
  for_each_kernels<double>([&](const Kernels<double>& kernels, const std::string& words) {
    CAPTURE(words);
    double worst_y = 0;
    double worst_v = 0;
    double worst_energy = 0;
    for (std::size_t i = turn++ % 3; i < times.size(); i += 3) {
      const auto row = times[i];
      const double g = row["g_m_s2"];
      const int steps = static_cast<int>(std::ceil(row["t_s"] * 60));
      Particles<double> particles(kernels, row["t_s"] / steps, {0, -g, 0});
      particles.add(floor_with(row["restitution"]));
      particles.set_all(state<double>(0, row["y0_m"], 0, 0, row["v0_m_s"], 0));
      particles.step(static_cast<std::size_t>(steps));
      const auto end = particles.at(0);
      const double scale = row["y0_m"] + row["v0_m_s"] * row["v0_m_s"] / (2 * g);
      const double speed = std::sqrt(2 * g * scale);
      worst_y = std::max(worst_y, std::abs(end.x[1] - row["y_m"]) / scale);
      const bool is_at_impact = std::abs(row["y_m"]) < 1e-9 * scale;
      if (!is_at_impact) worst_v = std::max(worst_v, std::abs(end.v[1] - row["v_m_s"]) / speed);
      const double exact = g * row["y_m"] + row["v_m_s"] * row["v_m_s"] / 2;
      worst_energy = std::max(worst_energy, std::abs(g * end.x[1] + end.v[1] * end.v[1] / 2 - exact) / (g * scale));
    }
    MESSAGE(words << ": y " << worst_y << " v " << worst_v << " energy " << worst_energy);
    CHECK(worst_y <= 1e-10);
    CHECK(worst_v <= 1e-9);
    CHECK(worst_energy <= 1e-10);
  });
}

TEST_CASE("impact times in closed form") {
  const Oracle oracle("bounce1d_times.csv");
  std::size_t turn = 0;  // each row runs on every third table
  for_each_kernels<double>([&](const Kernels<double>& kernels, const std::string& words) {
    CAPTURE(words);
    double worst = 0;
    for (std::size_t i = turn++ % 3; i < oracle.size(); i += 3) {
      // Steps to a quarter of the flight after this bounce, and computes the time of the impact backwards.
      const auto row = oracle[i];
      const double e = row["restitution"];
      const double g = row["g_m_s2"];
      const double flight = 2 * e * row["impact_speed"] / g;
      if (flight < 1e-3) continue;
      const double t = row["t_bounce"] + flight / 4;
      const int steps = static_cast<int>(std::ceil(t * 60));
      Particles<double> particles(kernels, t / steps, {0, -g, 0});
      particles.add(floor_with(e));
      particles.set_all(state<double>(0, row["y0_m"], 0, 0, row["v0_m_s"], 0));
      particles.step(static_cast<std::size_t>(steps));
      const auto end = particles.at(0);
      const double launch = std::sqrt(end.v[1] * end.v[1] + 2 * g * end.x[1]);
      worst = std::max(worst, std::abs(t - (launch - end.v[1]) / g - row["t_bounce"]) / row["t_bounce"]);
    }
    MESSAGE(words << ": " << worst);
    CHECK(worst <= 1e-12);
  });
}

TEST_CASE("bounces on oblique planes in closed form") {
  const Oracle oracle("bounce3d.csv");
  for_each_kernels<double>([&](const Kernels<double>& kernels, const std::string& words) {
    CAPTURE(words);
    double worst = 0;
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      const auto row = oracle[i];
      const Vec3 n{row["nx"], row["ny"], row["nz"]};
      const double g = row["g_along_minus_n"];
      const int steps = static_cast<int>(std::ceil(row["t_s"] * 60));
      Particles<double> particles(kernels, row["t_s"] / steps, {-g * n[0], -g * n[1], -g * n[2]});
      Plane surface = plane(n, row["d_m"], row["restitution"]);
      surface.viscosity = -std::log(row["tangential_keep"]);
      particles.add(surface);
      particles.set_all(state<double>(row["x0"], row["y0"], row["z0"], row["vx0"], row["vy0"], row["vz0"]));
      particles.step(static_cast<std::size_t>(steps));
      const auto end = particles.at(5);
      const Vec3 exact_x{row.text("x").empty() ? 0 : row["x"], row["y"], row["z"]};
      const double error = length({end.x[0] - exact_x[0], end.x[1] - exact_x[1], end.x[2] - exact_x[2]});
      worst = std::max(worst, error);
    }
    MESSAGE(words << ": " << worst);
    CHECK(worst <= 1e-10);
  });
}

TEST_CASE("a step back with reversed velocities mirrors a step forwards, in a corner and with one impact a step") {
  for (int i = 0; i < 50; ++i) {
    std::array<double, 6> after[2];
    for (const double sign : {1.0, -1.0}) {
      Scene scene;
      scene.add(Constant{.acceleration = gravity});
      scene.add(Plane{.normal = {1, 1, 0}, .restitution = 0.3, .friction = 0.4});
      scene.add(Plane{.normal = {-1, 1, 0}, .restitution = 0.6});
      Soa<double> memory(1);
      State<double> state = memory.view();
      state.x[0][0] = 0.1 * std::sin(i);
      state.x[1][0] = 0.2 + 0.05 * std::cos(3 * i);
      state.v[0][0] = sign * 4 * std::cos(2 * i);
      state.v[1][0] = sign * -3;
      (void)compile<double>(scene, {.step = sign * 0.1, .impacts = 1})->step(state, 3);
      after[sign < 0 ? 1 : 0] = {state.x[0][0],        state.x[1][0],        state.x[2][0],
                                 sign * state.v[0][0], sign * state.v[1][0], sign * state.v[2][0]};
    }
    CHECK(after[0] == after[1]);
  }
}

}  // namespace dvdx::test::contacts::bounce_test
