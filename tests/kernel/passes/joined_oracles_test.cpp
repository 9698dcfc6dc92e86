// The closed-form results of tests/oracles for joined particles, on every instruction set, in float32 and float64, in separate
// and in contracted arithmetic. network_closed_form_test.cpp compares the schemes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernel/passes/dealt_rows.hpp"
#include "kernel/passes/every_run.hpp"
#include "support/margin.hpp"
#include "support/oracle.hpp"

namespace dvdx::test::joined_oracles {

constexpr double hz60 = 1.0 / 60;

std::size_t steps_in(double time, double step) { return static_cast<std::size_t>(std::lround(time / step)); }

template <class T>
double x_of(const std::vector<T>& values, std::size_t particle, std::size_t axis) {
  return static_cast<double>(values[6 * particle + axis]);
}
template <class T>
double v_of(const std::vector<T>& values, std::size_t particle, std::size_t axis) {
  return static_cast<double>(values[6 * particle + 3 + axis]);
}

// Along a line, a damped spring's contribution to its two ends is exact for any step. With the axis of the step's start, one
// step of any stiffness is enough.
TEST_CASE_TEMPLATE("oracles: two bodies on a line, damped ones too, in one step and in 60", T, float, double) {
  const Oracle oracle("twobody1d.csv");
  std::size_t damped = 0;
  std::size_t rows = 0;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    damped += oracle[i]["c_Ns"] != 0 ? 1U : 0U;
    rows += oracle[i]["r_positive"] == 1 ? 1U : 0U;
  }
  CHECK(damped == 126);
  CHECK(rows == 198);
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      if (row["r_positive"] != 1) continue;  // the oracle's length has a sign, the spring's has none: see the next test
      const double m1 = row["m1"], m2 = row["m2"], k = row["k_N"], c = row["c_Ns"], a = row["a_m"], time = row["t_s"];
      Joined pair;
      pair.x = {{row["x1_0"], 0, 0}, {row["x2_0"], 0, 0}};
      pair.v = {{row["v1_0"], 0, 0}, {row["v2_0"], 0, 0}};
      pair.scene.mass = Scalars(std::vector<double>{m1, m2});
      pair.scene.add(Constant{.acceleration = {a, 0, 0}});
      Springs springs{.pairs = {{0, 1}}, .stiffness = k, .rest_length = Scalars(row["l_m"])};
      springs.damping = c;
      pair.scene.add(Network(springs));
      pair.scene.coupling = {.scheme = Scheme::accumulate, .substeps = 1, .method = Method::exact, .axis = PairAxis::start};
      const double omega = std::sqrt(k * (1 / m1 + 1 / m2));
      // The reach of the oscillation in space and time, and the common displacement.
      const double apart = std::abs(row["x2_0"] - row["x1_0"]) + row["l_m"] + std::abs(row["v2_0"] - row["v1_0"]) / omega;
      const double fast = std::abs(row["v1_0"]) + std::abs(row["v2_0"]) + std::abs(a) * time;
      const double length = apart + std::abs(row["x1_0"]) + std::abs(row["x2_0"]) + fast * time;
      const double speed = fast + omega * apart;
      for (const std::size_t steps : {1U, 60U}) {
        pair.step = time / static_cast<double>(steps);
        pair.name = "case " + row.text("case");
        const auto got = test::stepped<T>(pair, run, steps);
        // The frequency is rounded in the lanes, and once in the scene's sums: 2 eps of phase for each rad in float64.
        const double phase = 4e-16 * omega * time;
        const double part = (sizeof(T) == 8 ? 1e-13 : steps == 1 ? 1e-6 : 2e-5) + phase;
        const auto where = [&] {
          return "case " + row.text("case") + " at " + row.text("t_s") + " s in " + std::to_string(steps) + " steps, damping " +
                 row.text("c_Ns");
        };
        margin.see(std::abs(x_of(got, 0, 0) - row["x1"]), part * length, where);
        margin.see(std::abs(x_of(got, 1, 0) - row["x2"]), part * length, where);
        margin.see(std::abs(v_of(got, 0, 0) - row["v1"]), part * speed, where);
        margin.see(std::abs(v_of(got, 1, 0) - row["v2"]), part * speed, where);
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

// When the oracle's length passes through zero it keeps its sign, unlike a spring between particles. Its two modes are those of
// two particles: the length on a damped spring to the rest length, and the centre of mass in free fall.
TEST_CASE_TEMPLATE("oracles: two bodies on a line as their length and their centre of mass, every row", T, float, double) {
  const Oracle oracle("twobody1d.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      const double m1 = row["m1"], m2 = row["m2"], time = row["t_s"];
      const double part1 = m1 / (m1 + m2), part2 = m2 / (m1 + m2);
      const double reduced = m1 * part2;
      Joined modes;
      modes.x = {{row["x2_0"] - row["x1_0"], 0, 0}, {part1 * row["x1_0"] + part2 * row["x2_0"], 0, 0}};
      modes.v = {{row["v2_0"] - row["v1_0"], 0, 0}, {part1 * row["v1_0"] + part2 * row["v2_0"], 0, 0}};
      Joined length{.name = "length", .scene = {}, .x = {modes.x[0]}, .v = {modes.v[0]}, .step = time};
      length.scene.mass = reduced;
      length.scene.add(Spring{.stiffness = row["k_N"], .damping = row["c_Ns"], .anchor = Vec3{row["l_m"], 0, 0}});
      Joined centre{.name = "centre of mass", .scene = {}, .x = {modes.x[1]}, .v = {modes.v[1]}, .step = time};
      centre.scene.add(Constant{.acceleration = {row["a_m"], 0, 0}});
      const double omega = std::sqrt(row["k_N"] / reduced);
      const double apart = std::abs(modes.x[0][0]) + row["l_m"] + std::abs(modes.v[0][0]) / omega;
      const double fast = std::abs(row["v1_0"]) + std::abs(row["v2_0"]) + std::abs(row["a_m"]) * time;
      const double reach = apart + std::abs(row["x1_0"]) + std::abs(row["x2_0"]) + fast * time;
      for (const std::size_t steps : {1U, 60U}) {
        length.step = centre.step = time / static_cast<double>(steps);
        const auto r = test::stepped<T>(length, run, steps);
        const auto c = test::stepped<T>(centre, run, steps);
        const double part = (sizeof(T) == 8 ? 1e-13 : steps == 1 ? 1e-6 : 1e-5) + 6e-16 * omega * time;
        const auto where = [&] {
          return "case " + row.text("case") + " at " + row.text("t_s") + " s in " + std::to_string(steps) + " steps";
        };
        margin.see(std::abs(x_of(c, 0, 0) - part2 * x_of(r, 0, 0) - row["x1"]), part * reach, where);
        margin.see(std::abs(x_of(c, 0, 0) + part1 * x_of(r, 0, 0) - row["x2"]), part * reach, where);
        margin.see(std::abs(v_of(c, 0, 0) - part2 * v_of(r, 0, 0) - row["v1"]), part * (fast + omega * apart), where);
        margin.see(std::abs(v_of(c, 0, 0) + part1 * v_of(r, 0, 0) - row["v2"]), part * (fast + omega * apart), where);
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

TEST_CASE_TEMPLATE("oracles: chains of springs by the fourth order", T, float, double) {
  const Oracle oracle("chain1d.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    std::size_t looked_at = 0;
    for (std::size_t r = 0; r < oracle.size(); ++r) {
      const auto row = oracle[r];
      if (row["lengths_positive"] != 1 || row["t_s"] > 1.5 || !dealt.has(looked_at++)) continue;
      const auto n = static_cast<std::size_t>(row["n"]);
      Joined chain;
      chain.x = {{}};
      chain.v = {{}};
      std::vector<double> mass{1};
      Springs springs{.pairs = {}, .stiffness = Scalars(row.list("k_N")), .rest_length = row["rest_len"]};
      for (std::size_t i = 0; i < n; ++i) {
        chain.x.push_back({static_cast<double>(i + 1) * row["rest_len"] + row.list("u0")[i], 0, 0});
        chain.v.push_back({row.list("v0")[i], 0, 0});
        mass.push_back(row.list("m_kg")[i]);
        springs.pairs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i + 1)});
      }
      chain.scene.mass = Scalars(mass);
      chain.scene.fixed = {0};
      chain.scene.add(Constant{.acceleration = {row["a_m"], 0, 0}});
      chain.scene.add(Network(springs));
      chain.scene.coupling = {.scheme = Scheme::fourth_order, .substeps = 100};
      const auto got = test::stepped<T>(chain, run, steps_in(row["t_s"], hz60));
      const auto x = row.list("x_m"), v = row.list("v_m_s");
      for (std::size_t i = 0; i < n; ++i) {
        const auto where = [&] { return "case " + row.text("case") + " at " + row.text("t_s") + " s"; };
        margin.see(std::abs(x_of(got, i + 1, 0) - x[i]), sizeof(T) == 8 ? 1e-8 : 5e-4, where);
        margin.see(std::abs(v_of(got, i + 1, 0) - v[i]), sizeof(T) == 8 ? 1e-6 : 5e-2, where);
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

// The bounds in metres after up to 1 s at 60 Hz, and in 16 times as many steps: each of these schemes has second order.
TEST_CASE_TEMPLATE("oracles: a spinning pair", T, float, double) {
  struct Scheme1 {
    const char* name;
    Coupling coupling;
    double bound;
  };
  const std::array schemes{
      Scheme1{"leapfrog", {.scheme = Scheme::leapfrog, .substeps = 1}, 1e-2},
      Scheme1{"accumulate, exact", {.scheme = Scheme::accumulate, .substeps = 1, .method = Method::exact}, 2e-3},
      Scheme1{"accumulate, combined", {.scheme = Scheme::accumulate, .substeps = 1, .method = Method::combined}, 1e-3},
      Scheme1{"sequential, theta 0.5", {.scheme = Scheme::sequential, .substeps = 1, .theta = 0.5}, 1e-2},
      Scheme1{"fourth_order", {.scheme = Scheme::fourth_order, .substeps = 1}, 2e-5}};
  const Oracle oracle("twobody2d_spin.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t r = 0; r < oracle.size(); ++r) {
      if (!dealt.has(r)) continue;
      const auto row = oracle[r];
      Joined pair;
      pair.x = {{row["x1"], row["y1"], 0}, {row["x2"], row["y2"], 0}};
      pair.v = {{row["vx1"], row["vy1"], 0}, {row["vx2"], row["vy2"], 0}};
      pair.scene.mass = Scalars(std::vector<double>{row["m1"], row["m2"]});
      pair.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = row["k"], .rest_length = Scalars(row["l"])}));
      for (const auto& [name, coupling, bound] : schemes) {
        for (const int finer : {1, 16}) {
          pair.scene.coupling = coupling;
          pair.step = hz60 / finer;
          const auto got = test::stepped<T>(pair, run, steps_in(row["t"], pair.step));
          const double allowed = bound / (finer * finer) + (sizeof(T) == 8 ? 0 : 2e-5);
          const auto where = [&, name = name, finer = finer] {
            return std::string(name) + ", case " + row.text("case") + " at " + row.text("t") + " s, steps of 1/" +
                   std::to_string(60 * finer) + " s";
          };
          margin.see(std::hypot(x_of(got, 0, 0) - row["X1"], x_of(got, 0, 1) - row["Y1"]), allowed, where);
          margin.see(std::hypot(x_of(got, 1, 0) - row["X2"], x_of(got, 1, 1) - row["Y2"]), allowed, where);
        }
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

// Root mean square over the nodes, relative to the side of 1 m, at each of the oracle's times.
TEST_CASE_TEMPLATE("oracles: a hanging cloth by leapfrog with the sub-steps that the plan chooses", T, float, double) {
  const Oracle nodes("cloth_init.csv");
  const Oracle list("cloth_springs.csv");
  const Oracle path("cloth_nodes.csv");
  Joined cloth;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    cloth.x.push_back({nodes[i]["x"], nodes[i]["y"], nodes[i]["z"]});
    cloth.v.push_back({});
    if (nodes[i]["inv_mass"] == 0) cloth.scene.fixed.push_back(i);
  }
  cloth.scene.mass = 0.3 / 256;
  cloth.scene.add(Constant{.acceleration = {0, 0, -9.81}});
  Springs springs;
  std::vector<double> stiffness, length;
  for (std::size_t s = 0; s < list.size(); ++s) {
    springs.pairs.push_back({static_cast<std::uint32_t>(list[s]["i"]), static_cast<std::uint32_t>(list[s]["j"])});
    stiffness.push_back(list[s]["k_N"]);
    length.push_back(list[s]["rest_len"]);
  }
  springs.stiffness = Scalars(stiffness);
  springs.rest_length = Scalars(length);
  cloth.scene.add(Network(springs));
  std::vector<std::array<double, 8>> rows;
  for (std::size_t r = 0; r < path.size(); ++r) {
    const auto row = path[r];
    rows.push_back({row["t_s"], row["node"], row["x"], row["y"], row["z"], row["vx"], row["vy"], row["vz"]});
  }
  for_each_run([&](const Run& run, const std::string& words) {
    const DealtRows<T> dealt(run);
    std::size_t turn = 0;
    for (const double time : {0.1, 0.5, 1.0}) {
      if (!dealt.has(turn++)) continue;
      const auto got = test::stepped<T>(cloth, run, steps_in(time, hz60));
      double squares = 0;
      std::size_t count = 0;
      for (const auto& row : rows) {
        if (std::abs(row[0] - time) > 1e-9) continue;
        const auto node = static_cast<std::size_t>(row[1]);
        for (std::size_t axis = 0; axis < 3; ++axis) squares += std::pow(x_of(got, node, axis) - row[2 + axis], 2);
        ++count;
      }
      if (count == 0) continue;
      REQUIRE(count == 256);
      CHECK_MESSAGE(std::sqrt(squares / 256) <= 2e-4,
                    words << ", " << 8 * sizeof(T) << " bits, " << time << " s: " << std::sqrt(squares / 256) << " of 1 m");
    }
  });
}

// A bob on a rod, released at rest: errors in metres over 2 s, and a sixteenth of that at four times the rate.
TEST_CASE_TEMPLATE("oracles: pendulums on a constraint", T, float, double) {
  const Oracle oracle("pendulum.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t r = 0; r < oracle.size(); ++r) {
      if (!dealt.has(r)) continue;
      const auto row = oracle[r];
      if (row["t_s"] > 2) continue;
      const double length = row["L_m"], angle = row["theta0"];
      for (const int hertz : {60, 240}) {
        Joined pendulum;
        pendulum.x = {{0, 0, 0}, {length * std::sin(angle), -length * std::cos(angle), 0}};
        pendulum.v.resize(2);
        pendulum.scene.fixed = {0};
        pendulum.scene.add(Constant{.acceleration = {0, -row["g_m"], 0}});
        pendulum.scene.add(Distance{.pairs = {{0, 1}}, .length = length});
        pendulum.step = 1.0 / hertz;
        const auto got = test::stepped<T>(pendulum, run, steps_in(row["t_s"], pendulum.step));
        const double x = x_of(got, 1, 0), y = x_of(got, 1, 1);
        const auto where = [&, hertz = hertz] {
          return "case " + row.text("case") + " at " + row.text("t_s") + " s, " + std::to_string(hertz) + " Hz";
        };
        margin.see(std::hypot(x - row["x_m"], y - row["y_m"]), (hertz == 60 ? 6e-3 : 6e-3 / 14) + (sizeof(T) == 8 ? 0 : 1e-4),
                   where);
        margin.see(std::abs(std::hypot(x, y) / length - 1), sizeof(T) == 8 ? 1e-15 : 1e-6, where);
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

}  // namespace dvdx::test::joined_oracles
