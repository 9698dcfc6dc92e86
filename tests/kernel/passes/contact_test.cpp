// The contact pass on its own: every table of every ISA, against closed forms and against the scalar twin bit by bit.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/particles.hpp"
#include "support/oracle.hpp"

namespace dvdx::test::contact_test {

constexpr Vec3 still{};
constexpr Vec3 gravity{0, -9.81, 0};

Plane plane(const Vec3& normal, double offset, double restitution) {
  Plane plane;
  plane.normal = normal;
  plane.offset = offset;
  plane.restitution = restitution;
  return plane;
}
Plane floor_with(double restitution) { return plane({0, 1, 0}, 0, restitution); }

template <class T>
State3<T> state(double x, double y, double z, double u, double v, double w) {
  return {{static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)}, {static_cast<T>(u), static_cast<T>(v), static_cast<T>(w)}};
}

double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3& a) { return std::sqrt(product(a, a)); }
Vec3 unit(const Vec3& a) { return {a[0] / length(a), a[1] / length(a), a[2] / length(a)}; }

template <class T>
bool same_bits(T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}
template <class T>
bool same_bits(const State3<T>& a, const State3<T>& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (!same_bits(a.x[k], b.x[k]) || !same_bits(a.v[k], b.v[k])) return false;
  }
  return true;
}

TEST_CASE_TEMPLATE("rest on an axis-aligned plane is exact for a million steps", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const bool is_long = words == "avx2 contracted";
    for (const double offset : {0.0, 7.3, -0.1}) {
      for (const double restitution : {0.0, 0.5, 1.0}) {
        Particles<T> particles(kernels, hz60, gravity);
        particles.add(plane({0, 1, 0}, offset, restitution));
        const auto start = state<T>(3, static_cast<double>(static_cast<T>(offset)), -2, 0, 0, 0);
        particles.set_all(start);
        particles.step(is_long && restitution == 0.5 && offset == 7.3 ? 1000000 : 500);
        CHECK(particles.at(0).x == start.x);
        CHECK(particles.at(15).v == start.v);
      }
    }
  });
}

TEST_CASE_TEMPLATE("rest on an oblique plane neither sinks nor creeps", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const bool is_long = words == "avx2 contracted";
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 12; ++trial) {
      const Vec3 n = unit({normal(random), normal(random), normal(random)});
      const double offset = trial % 3 == 0 ? 7.3 : normal(random);
      const Vec3 along{n[1], -n[0], 0};
      Particles<T> particles(kernels, hz60, {-9.81 * n[0], -9.81 * n[1], -9.81 * n[2]});
      particles.add(plane(n, offset, trial % 2 == 0 ? 0.5 : 0.0));
      const double reach = 2;
      const auto start = state<T>(offset * n[0] + reach * along[0], offset * n[1] + reach * along[1], offset * n[2], 0, 0, 0);
      particles.set_all(start);
      particles.step(100);
      const State3<T> settled = particles.at(3);
      particles.step(is_long && trial == 0 ? 300000 : 500);
      const State3<T> end = particles.at(3);
      const Vec3 x = wide(end.x);
      CHECK(std::abs(product(wide(particles.surfaces[0].n), x) - static_cast<double>(particles.surfaces[0].d)) <=
            4 * eps<T> * length(x));
      CHECK(std::abs(product(n, wide(end.v))) <= 1e-6);
      CHECK(length(wide(end.v)) <= 1e-6);
      CHECK(end.x == settled.x);
      for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(end.x[k] - start.x[k]) <= 16 * eps<T> * length(x));
    }
  });
}

TEST_CASE_TEMPLATE("grazing leaves the velocity as it is", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const double y : {0.0, 1e-7}) {
      Particles<T> particles(kernels, hz60, still);
      Plane ground = floor_with(0.5);
      ground.friction = 0.3;
      ground.viscosity = 1;
      particles.add(ground);
      const auto start = state<T>(0.1, y, 0.2, 1.1, 0, -2.3);
      particles.set_all(start);
      particles.step(1000);
      CHECK(particles.at(7).v == start.v);
    }
  });
}

TEST_CASE_TEMPLATE("starting inside and on the surface", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, still);
    particles.add(floor_with(0.5));
    particles.set(0, state<T>(0, -0.1, 0, 0, -5, 0));
    particles.set(1, state<T>(0, -0.1, 0, 0, 0, 0));
    particles.set(2, state<T>(0, -0.1, 0, 0, 5, 0));
    particles.set(3, state<T>(0, 0, 0, 0, 3, 0));
    particles.set(4, state<T>(0, 0, 0, 0, -3, 0));
    particles.step();
    const std::array<double, 3> left{2.5, 0, 5};
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(particles.at(i).x[1] >= 0);
      CHECK(particles.at(i).v[1] == static_cast<T>(left[i]));
    }
    CHECK(std::abs(static_cast<double>(particles.at(3).x[1]) - 0.05) <= 4 * eps<T> * 0.05);
    CHECK(std::abs(static_cast<double>(particles.at(4).x[1]) - 0.025) <= 4 * eps<T> * 0.025);
    CHECK(particles.at(3).v[1] == T(3));
    CHECK(particles.at(4).v[1] == T(1.5));
  });
}

TEST_CASE_TEMPLATE("corners of two and three planes hit at once", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const std::size_t walls : {2U, 3U}) {
      Particles<T> particles(kernels, hz60, still);
      particles.add(plane({1, 0, 0}, 0, 1));
      particles.add(plane({0, 1, 0}, 0, 1));
      if (walls == 3) particles.add(plane({0, 0, 1}, 0, 1));
      const double near = 0.5 * hz60;
      const double w = walls == 3 ? -1 : 0;
      particles.set_all(state<T>(near, near, walls == 3 ? near : 1, -1, -1, w));
      particles.step();
      const State3<T> end = particles.at(9);
      for (std::size_t k = 0; k < walls; ++k) {
        CHECK(std::abs(static_cast<double>(end.x[k]) - near) <= 4 * eps<T> * std::sqrt(3.0) * hz60);
        CHECK(end.v[k] == T(1));
      }
      const double speed = std::sqrt(static_cast<double>(walls));
      CHECK(std::abs(length(wide(end.v)) - speed) <= 4 * eps<T> * speed);
    }
  });
}

TEST_CASE_TEMPLATE("a wedge of 20 degrees", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double angle = 20 * std::numbers::pi / 180;
    Particles<T> particles(kernels, hz60, still);
    particles.add(plane({0, 1, 0}, 0, 1));
    particles.add(plane({std::sin(angle), -std::cos(angle), 0}, 0, 1));
    particles.add(plane({-1, 0, 0}, -2, 1));
    for (std::size_t i = 0; i < particles.count(); ++i) {
      const double turn = static_cast<double>(i) * 0.37;
      particles.set(i, state<T>(1.2, 0.2, 0, 3 * std::cos(turn), 3 * std::sin(turn), 0));
    }
    double worst_gain = 0;
    double deepest = 0;
    for (int n = 0; n < 1500; ++n) {
      std::array<double, 16> before{};
      for (std::size_t i = 0; i < 16; ++i) before[i] = length(wide(particles.at(i).v));
      particles.step();
      for (std::size_t i = 0; i < 16; ++i) {
        const State3<T> now = particles.at(i);
        const double speed = length(wide(now.v));
        worst_gain = std::max(worst_gain, speed * speed / (before[i] * before[i]) - 1);
        for (const auto& surface : particles.surfaces) {
          deepest = std::max(deepest, static_cast<double>(surface.d) - product(wide(surface.n), wide(now.x)));
        }
      }
    }
    CHECK(worst_gain <= (sizeof(T) == 4 ? 2e-6 : 1e-14));
    CHECK(deepest <= 4 * eps<T> * 2);
    for (std::size_t i = 0; i < 16; ++i) CHECK(length(wide(particles.at(i).v)) > 2.9);
  });
}

TEST_CASE_TEMPLATE("a channel with many bounces in a step", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const int bounces : {2, 17, 167}) {
      Particles<T> particles(kernels, hz60, still);
      particles.terms.impacts = 32;
      const double width = 0.0625;
      particles.add(plane({0, 1, 0}, 0, 1));
      particles.add(plane({0, -1, 0}, -width, 1));
      const double way = (bounces + 0.3) * width;
      particles.set_all(state<T>(0, 0, 0, 0.7, way * 60, 0));
      particles.step();
      const State3<T> end = particles.at(4);
      const double y = static_cast<double>(end.x[1]);
      CHECK(y >= -1e-6);
      CHECK(y <= width + 1e-6);
      CHECK(length(wide(end.v)) <= length({0.7, way * 60, 0}) * (1 + 4 * eps<T>));
      if (bounces <= 32) CHECK(std::abs(y - (bounces % 2 == 0 ? 0.3 : 0.7) * width) <= 1e-6);
    }
  });
}

TEST_CASE_TEMPLATE("nothing tunnels", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const ContactPath sweep : {ContactPath::curve, ContactPath::line}) {
      Particles<T> particles(kernels, hz60, still);
      Plane ground = floor_with(1);
      ground.sweep = sweep;
      particles.add(ground);
      particles.set_all(state<T>(0, 10, 0, 0, -1e5, 0));
      particles.step();
      CHECK(std::abs(static_cast<double>(particles.at(2).x[1]) - (1e5 / 60 - 10)) <= 4 * eps<T> * 1656.667);
    }
    for (const ContactPath sweep : {ContactPath::curve, ContactPath::line}) {  // a sphere that a step passes right through
      Particles<T> particles(kernels, hz60, still);
      Sphere ball;
      ball.restitution = 1;
      ball.sweep = sweep;
      particles.add(ball);
      particles.set_all(state<T>(0, 10, 0, 0, -1e4, 0));
      particles.step();
      CHECK(std::abs(static_cast<double>(particles.at(2).x[1]) - (1 + 1e4 / 60 - 9)) <= 8 * eps<T> * 160);
      CHECK(std::abs(static_cast<double>(particles.at(2).v[1]) - 1e4) <= 4 * eps<T> * 1e4);
    }
  });
}

TEST_CASE_TEMPLATE("infinite friction holds a particle in a corner", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const bool is_viscous : {false, true}) {
      Particles<T> particles(kernels, hz60, {-2, -9.81, 1});
      Plane ground = floor_with(0);
      Plane wall = plane({1, 0, 0}, 0, 0);
      for (Plane* surface : {&ground, &wall}) {
        surface->friction = is_viscous ? 0 : std::numeric_limits<double>::infinity();
        surface->viscosity = is_viscous ? std::numeric_limits<double>::infinity() : 0;
      }
      particles.add(ground);
      particles.add(wall);
      particles.set_all(state<T>(0, 0, 0, -1, -2, 3));
      particles.step(2);
      CHECK(particles.at(6).v == std::array<T, 3>{});
      const State3<T> held = particles.at(6);
      particles.step(1000);
      CHECK(particles.at(6).v == std::array<T, 3>{});
      CHECK(particles.at(6).x == held.x);
    }
  });
}

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
    // at v^2 / (2 mu g), less half a step of the impulse's delay
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
  std::size_t turn = 0;  // each row is that of every third table
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
  std::size_t turn = 0;  // each row is that of every third table
  for_each_kernels<double>([&](const Kernels<double>& kernels, const std::string& words) {
    CAPTURE(words);
    double worst = 0;
    for (std::size_t i = turn++ % 3; i < oracle.size(); i += 3) {
      // Step to a quarter of the way between this bounce and the next, and look back for the time of the impact.
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
      // x moves with a constant 1 m/s until the impact takes it all: it tells the time.
      Particles<double> particles(kernels, h, still);
      Plane surface = floor_with(1);
      surface.viscosity = std::numeric_limits<double>::infinity();
      particles.add(surface);
      Terms<double>& terms = particles.terms;
      // x1, v1 as the exact motion has them: a drift whose offsets are the difference.
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
    // A lift of 2 * 60 m/s^2: down by v, up again, the end as high as the start.
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

// Above the floor all the way; a parabola through its ends and its first velocity would dip into it.
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

TEST_CASE("a step back of what moves the other way mirrors a step forwards, in a corner and with one impact a step") {
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

TEST_CASE("a throw onto a sphere hits it where the parabola does") {
  const Vec3 x{0.3, 1.5, 0}, v{0.2, -1, 0.1};
  const auto at = [&](double t) {
    Vec3 p{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = x[k] + t * v[k] + 0.5 * t * t * gravity[k];
    return p;
  };
  double low = 0, high = 0.4;
  for (int n = 0; n < 100; ++n) (length(at(0.5 * (low + high))) > 1 ? low : high) = 0.5 * (low + high);
  Scene scene;
  scene.add(Constant{.acceleration = gravity});
  scene.add(Sphere{.center = {}, .radius = 1, .response = Response::end_on_surface});  // shows where the impact was
  Soa<double> memory(1);
  State<double> state = memory.view();
  for (std::size_t k = 0; k < 3; ++k) {
    state.x[k][0] = x[k];
    state.v[k][0] = v[k];
  }
  (void)compile<double>(scene, {.step = 0.5})->step(state);
  // The way along the surface is kept: only what leads into it, along the normal at the impact, is taken back.
  const Vec3 hit = at(low), end = at(0.5);
  double into = 0;
  for (std::size_t k = 0; k < 3; ++k) into += hit[k] * (end[k] - hit[k]);
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(state.x[k][0] - (end[k] - into * hit[k])) <= 1e-13);
}

// From beside a sphere along its tangent, then drawn into it and out again: x = (1.05 - 2 f^2, sqrt(2.5) f) in a step of 1 s.
// |x| = 1 where 4 f^4 - 1.7 f^2 + 0.1025 = 0; the path's end is outside, and so is that of the straight line.
TEST_CASE("a path that bends into a sphere and out of it within a step hits it at its quartic's root") {
  const double u = std::sqrt(2.5);
  const double f = std::sqrt((1.7 - std::sqrt(1.7 * 1.7 - 16 * 0.1025)) / 8);
  const Vec3 n{1.05 - 2 * f * f, u * f, 0};
  CHECK(std::abs(length(n) - 1) < 1e-14);
  const double into = product(n, {-4 * f, u, 0});
  const Vec3 after{-4 * f - 2 * into * n[0], u - 2 * into * n[1], 0};
  const double rest = 1 - f;
  Scene scene;
  scene.add(Constant{.acceleration = {-4, 0, 0}});
  scene.add(Sphere{.center = {}, .radius = 1, .restitution = 1});
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      Soa<double> memory(1);
      State<double> state = memory.view();
      for (std::size_t k = 0; k < 3; ++k) state.x[k][0] = state.v[k][0] = 0;
      state.x[0][0] = 1.05;
      state.v[1][0] = u;
      (void)compile<double>(scene, {.step = 1, .isa = isa, .arithmetic = arithmetic})->step(state);
      CAPTURE(name(isa));
      CHECK(std::abs(state.x[0][0] - (n[0] + rest * after[0] - 2 * rest * rest)) <= 1e-12);
      CHECK(std::abs(state.x[1][0] - (n[1] + rest * after[1])) <= 1e-12);
      CHECK(std::abs(state.v[0][0] - (after[0] - 4 * rest)) <= 1e-12);
      CHECK(std::abs(state.v[1][0] - after[1]) <= 1e-12);
    }
  }
}

TEST_CASE_TEMPLATE("inside and outside of spheres", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    {  // billiards inside: the speed and the angular momentum stay
      Particles<T> particles(kernels, hz60, still, 64);
      Sphere shell;
      shell.side = Side::inside;
      shell.restitution = 1;
      shell.radius = 0.5;
      particles.add(shell);
      for (std::size_t i = 0; i < 64; ++i) {
        particles.set(i, state<T>(0.2 * std::tanh(normal(random)), 0.2 * std::tanh(normal(random)), 0.1, 20 * normal(random),
                                  20 * normal(random), 20 * normal(random)));
      }
      std::vector<double> speeds;
      for (std::size_t i = 0; i < 64; ++i) speeds.push_back(length(wide(particles.at(i).v)));
      particles.step(300);
      for (std::size_t i = 0; i < 64; ++i) {
        CHECK(length(wide(particles.at(i).x)) <= 0.5 * (1 + 4 * eps<T>));
        CHECK(std::abs(length(wide(particles.at(i).v)) / speeds[i] - 1) <= (sizeof(T) == 4 ? 1e-3 : 1e-12));
      }
    }
    {  // rain on a ball: nothing enters, energy stays
      Particles<T> particles(kernels, hz60, gravity, 64);
      Sphere ball;
      ball.restitution = 1;
      particles.add(ball);
      std::vector<double> energies;
      for (std::size_t i = 0; i < 64; ++i) {
        const auto start = state<T>(0.6 * std::tanh(normal(random)), 2, 0.6 * std::tanh(normal(random)), 0, normal(random), 0);
        particles.set(i, start);
        energies.push_back(9.81 * 2 + std::pow(length(wide(start.v)), 2) / 2);
      }
      for (int n = 0; n < 60; ++n) {
        particles.step();
        for (std::size_t i = 0; i < 64; ++i) REQUIRE(length(wide(particles.at(i).x)) >= 1 - 4 * eps<T>);
      }
      for (std::size_t i = 0; i < 64; ++i) {
        const State3<T> end = particles.at(i);
        const double energy = 9.81 * static_cast<double>(end.x[1]) + std::pow(length(wide(end.v)), 2) / 2;
        CHECK(std::abs(energy / energies[i] - 1) <= (sizeof(T) == 4 ? 1e-4 : 1e-10));
      }
    }
    {  // the very centre: pushed out, no NaN
      Particles<T> particles(kernels, hz60, still);
      Sphere ball;
      ball.restitution = 0.5;
      particles.add(ball);
      particles.set(1, state<T>(0, 0, 0, 0, -1, 0));
      particles.set(2, state<T>(0, 0, 0, 1, 0, 0));
      particles.step();
      for (std::size_t i = 0; i < 16; ++i) {
        CHECK(std::abs(length(wide(particles.at(i).x)) - 1) <= 4 * eps<T>);
        CHECK(std::isfinite(particles.at(i).v[0] + particles.at(i).v[1] + particles.at(i).v[2]));
      }
    }
    {  // at rest at the bottom of a bowl and on top of a ball
      Particles<T> particles(kernels, hz60, gravity);
      Sphere bowl;
      bowl.side = Side::inside;
      bowl.center = {0, 1, 0};
      particles.add(bowl);
      particles.set_all(state<T>(0, 0, 0, 0, 0, 0));
      particles.step(1000);
      CHECK(particles.at(5).x == std::array<T, 3>{});
      CHECK(particles.at(5).v == std::array<T, 3>{});
    }
  });
}

TEST_CASE_TEMPLATE("every table has the scalar twin's bits", T, float, double) {
  std::mt19937 random(77);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return unit({normal(random), normal(random), normal(random)}); };
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<Contact> contacts;
    for (int k = 0; k <= trial % 5; ++k) {
      const bool is_axis = k % 2 == 1;
      if (trial % 3 != 0 || k % 2 == 0) {
        Plane p =
            plane(is_axis ? Vec3{0, 1, 0} : direction(), -0.5 + 0.2 * normal(random), 0.5 + 0.5 * std::tanh(normal(random)));
        p.friction = trial % 4 == 0 ? 0.3 : 0;
        p.viscosity = trial % 7 == 0 ? 0.2 : 0;
        p.sweep = trial % 6 == 5 ? ContactPath::line : ContactPath::curve;
        p.response = trial % 10 == 9 ? Response::end_on_surface : Response::resume;
        contacts.emplace_back(p);
      } else {
        Sphere s;
        s.center = {normal(random), normal(random), normal(random)};
        s.side = k == 1 ? Side::outside : Side::inside;
        s.radius = k == 1 ? 0.7 : 3;
        s.restitution = 0.9;
        s.friction = trial % 4 == 0 ? 0.3 : 0;
        s.sweep = trial % 6 == 5 ? ContactPath::line : ContactPath::curve;
        contacts.emplace_back(s);
      }
    }
    const Vec3 acceleration{4 * normal(random), 20 * normal(random), 4 * normal(random)};
    constexpr std::size_t count = 112;
    std::vector<State3<T>> start(count);
    for (auto& s : start) {
      const double speed = std::exp(2 * normal(random));
      s = state<T>(normal(random), normal(random), normal(random), speed * normal(random), speed * normal(random),
                   speed * normal(random));
    }
    const T nan = std::numeric_limits<T>::quiet_NaN();
    const T inf = std::numeric_limits<T>::infinity();
    start[5].x[1] = nan;
    start[37].v[2] = nan;
    start[70].x[0] = -inf;
    start[101].v[1] = -inf;
    start[102].v[1] = std::numeric_limits<T>::max();
    start[103].x = {};
    start[104].v = {};

    const double h = trial % 8 == 7 ? -hz60 : hz60;
    const auto run = [&](const Kernels<T>& kernels, bool has_bad) {
      Particles<T> particles(kernels, h, acceleration, count);
      for (const Contact& contact : contacts) particles.add(contact, trial % 5 != 4);
      if (trial % 2 == 1) particles.bend(trial % 4 == 1 ? 0.3 : 1.5, trial % 3 == 0 ? 0 : 0.2, trial % 6 == 1 ? 0.4 : 0);
      for (std::size_t i = 0; i < count; ++i) {
        const bool is_bad = i == 5 || i == 37 || i == 70 || i == 101 || i == 102;
        particles.set(i, is_bad && !has_bad ? State3<T>{} : start[i]);
      }
      particles.step(10);
      std::vector<State3<T>> end(count);
      for (std::size_t i = 0; i < count; ++i) end[i] = particles.at(i);
      return end;
    };
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      const auto expected = run(find_passes(Isa::reference, arithmetic)->of<T>(), true);
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(name(isa));
        CAPTURE(trial);
        const auto got = run(find_passes(isa, arithmetic)->of<T>(), true);
        std::size_t differing = 0;
        for (std::size_t i = 0; i < count; ++i)
          if (!same_bits(got[i], expected[i])) ++differing;
        CHECK(differing == 0);
        const auto without = run(find_passes(isa, arithmetic)->of<T>(), false);
        differing = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const bool is_bad = i == 5 || i == 37 || i == 70 || i == 101 || i == 102;
          if (!is_bad && !same_bits(got[i], without[i])) ++differing;
        }
        CHECK(differing == 0);
      }
    }
  }
}

}  // namespace dvdx::test::contact_test
