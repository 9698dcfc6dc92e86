// The closed-form results of tests/oracles through scene, plan and step, as a user runs them: on every instruction set, in
// float32 and float64, in separate and in contracted arithmetic, with one step and many.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "kernel/passes/dealt_rows.hpp"
#include "kernel/passes/every_run.hpp"
#include "support/margin.hpp"
#include "support/oracle.hpp"

namespace dvdx::test::oracle_answers {

// The allowed error relative to the motion's scales, for a run of one step and of many. Contracted arithmetic rounds less often
// and keeps the same bounds.
struct Bound {
  double one, many;
};
template <class T>
constexpr Bound bound = sizeof(T) == 8 ? Bound{2e-15, 2e-13} : Bound{4e-7, 4e-6};

// The largest position, velocity and acceleration of a motion, the scales of its rounding.
struct Scale {
  double x = 1e-3, v = 1e-3, a = 0;

  void see(double position, double velocity) {
    x = std::max(x, std::abs(position));
    v = std::max(v, std::abs(velocity));
  }
};

struct State3 {
  Vec3 x{}, v{};
};

// One row: a scene of one particle, the time, and the state at that time.
struct Answer {
  std::string name;
  Joined start;  // all particles start alike
  double time = 0;
  State3 end;
  std::array<Scale, 3> scale;
  double phase = 0;  // rad: the phase error that rounded sums of springs may cause
};

// x'' = a - W (x - c) - g v + driving: the scales of an axis whose motion starts at x0, v0 and is pulled by at most `pull`.
Scale scale_of(double W, double g, double c, double pull, double x0, double v0, double t) {
  const double infinite = std::numeric_limits<double>::infinity();
  const double swing = W > 0 ? 1 / std::sqrt(W) : infinite;
  const double brake = g > 0 ? 1 / g : infinite;
  const double reach = std::min({std::abs(t), swing, brake});  // s: how long a velocity acts
  Scale scale;
  scale.see(c, 0);
  scale.see(std::abs(x0) + std::abs(v0) * reach, v0);
  scale.v = std::max({scale.v, pull * reach, scale.x * std::min(std::sqrt(W), W * std::abs(t))});
  scale.a = pull + W * scale.x + g * scale.v;
  return scale;
}

// Five particles: a whole vector on some instruction sets, and a remainder.
constexpr std::size_t copies = 5;

Joined alone(const Vec3& x, const Vec3& v) {
  Joined start;
  start.x.assign(copies, x);
  start.v.assign(copies, v);
  return start;
}

template <class T>
void see_answer(Margin& margin, Answer answer, const Run& run, std::size_t steps) {
  answer.start.step = answer.time / static_cast<double>(steps);
  answer.start.name = answer.name;
  const auto got = test::stepped<T>(answer.start, run, steps);
  const double late = std::abs(std::fma(static_cast<double>(steps), answer.start.step, -answer.time));  // s, of rounding
  const double part = (steps == 1 ? bound<T>.one : bound<T>.many) + answer.phase;
  for (std::size_t i = 0; i < copies; i += copies - 1) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Scale& scale = answer.scale[axis];
      const auto where = [&](const char* what) {
        return [&answer, what, steps] {
          return answer.name + ", t = " + std::to_string(answer.time) + " s in " + std::to_string(steps) + " steps, " + what;
        };
      };
      margin.see(std::abs(static_cast<double>(got[6 * i + axis]) - answer.end.x[axis]), part * scale.x + late * scale.v,
                 where("x"));
      margin.see(std::abs(static_cast<double>(got[6 * i + 3 + axis]) - answer.end.v[axis]), part * scale.v + late * scale.a,
                 where("v"));
    }
  }
}

// Checks all results in one step and in 60. The rows are distributed over all the runs that this machine supports.
template <class T>
void check_answers(const std::vector<Answer>& answers) {
  for_each_run([&](const Run& run, const std::string& words) {
    Margin one, many;
    const DealtRows<T> dealt(run);
    std::size_t row = 0;
    for (const Answer& answer : answers) {
      if (!dealt.has(row++)) continue;
      see_answer<T>(one, answer, run, 1);
      see_answer<T>(many, answer, run, 60);
    }
    CHECK_MESSAGE(one.is_kept(), words << ", " << 8 * sizeof(T) << " bits, one step: " << one.words());
    CHECK_MESSAGE(many.is_kept(), words << ", " << 8 * sizeof(T) << " bits, 60 steps: " << many.words());
  });
}

// The scales of an oracle's cases cover every row up to the present one's time.
class Cases {
 public:
  void see(const std::string& name, std::size_t axis, double x, double v) { seen_[name][axis].see(x, v); }
  [[nodiscard]] Scale with(const std::string& name, std::size_t axis, Scale scale, double W) const {
    const auto found = seen_.find(name);
    if (found != seen_.end()) scale.see(found->second[axis].x, found->second[axis].v);
    scale.v = std::max(scale.v, std::min(std::sqrt(W) * scale.x, 1e300));
    return scale;
  }

 private:
  std::map<std::string, std::array<Scale, 3>> seen_;
};

// A result along one axis, used for all three.
Answer along_all(const Oracle::Row& row, Scene scene, const Scale& scale) {
  const double x0 = row["x0"], v0 = row["v0"], x = row["x_m"], v = row["v_m"];
  Answer answer{.name = "case " + row.text("case"),
                .start = alone({x0, x0, x0}, {v0, v0, v0}),
                .time = row["t_"],
                .end = {},
                .scale = {}};
  answer.start.scene = std::move(scene);
  answer.end = {{x, x, x}, {v, v, v}};
  answer.scale.fill(scale);
  return answer;
}

std::vector<Answer> linear_answers() {
  const Oracle oracle("linear1d.csv");
  std::vector<Answer> answers;
  Cases cases;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double W = row["W_"], g = row["g_"], a = row["a_"], c = row["c_"], u = row["u_"];
    Scene scene;
    if (W > 0) scene.add(Spring{.stiffness = W, .anchor = Vec3{c, c, c}});
    if (g > 0) scene.add(Drag{.coefficient = g, .wind = {u, u, u}});
    if (a != 0) scene.add(Constant{.acceleration = {a, a, a}});
    Scale scale = scale_of(W, g, c, std::abs(a) + g * std::abs(u), row["x0"], row["v0"], row["t_"]);
    cases.see(row.text("case"), 0, row["x_m"], row["v_m"]);
    scale = cases.with(row.text("case"), 0, scale, W);
    answers.push_back(along_all(row, scene, scale));
  }
  return answers;
}

std::vector<Answer> sinusoid_answers() {
  const Oracle oracle("sinusoid1d.csv");
  std::vector<Answer> answers;
  Cases cases;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double W = row["W_"], g = row["g_"], A = row["A_"];
    Scene scene;
    if (W > 0) scene.add(Spring{.stiffness = W});
    if (g > 0) scene.add(Drag{.coefficient = g});
    scene.add(Sinusoid{.acceleration = {A, A, A}, .angular_frequency = row["Omega_"], .phase = row["phase"]});
    cases.see(row.text("case"), 0, row["x_m"], row["v_m"]);
    const Scale scale = cases.with(row.text("case"), 0, scale_of(W, g, 0, std::abs(A), row["x0"], row["v0"], row["t_"]), W);
    answers.push_back(along_all(row, scene, scale));
  }
  return answers;
}

std::vector<Answer> polynomial_answers() {
  const Oracle oracle("poly1d.csv");
  std::vector<Answer> answers;
  Cases cases;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double W = row["W_"], g = row["g_"], t = row["t_"];
    Scene scene;
    if (W > 0) scene.add(Spring{.stiffness = W});
    if (g > 0) scene.add(Drag{.coefficient = g});
    Polynomial polynomial;
    double pull = 0;
    double power = 1;
    for (const double term : {row["a0"], row["a1"], row["a2"] / 2, row["a3"] / 6}) {
      polynomial.acceleration.push_back({term, term, term});
      pull += std::abs(term) * power;
      power *= t;
    }
    scene.add(polynomial);
    cases.see(row.text("case"), 0, row["x_m"], row["v_m"]);
    answers.push_back(
        along_all(row, scene, cases.with(row.text("case"), 0, scale_of(W, g, 0, pull, row["x0"], row["v0"], t), W)));
  }
  return answers;
}

Vec3 point(const std::vector<double>& list, std::size_t at = 0) { return {list[at], list[at + 1], list[at + 2]}; }

// Mass, springs to several anchors, drag in wind, gravity and shaking.
std::vector<Answer> space_answers() {
  const Oracle oracle("multiforce3d.csv");
  std::vector<Answer> answers;
  Cases cases;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    const double m = row["m_kg"], drag = row["drag_"], Omega = row["Omega"];
    const auto k = row.list("k_list"), anchors = row.list("anchors");
    const Vec3 wind = point(row.list("wind")), gravity = point(row.list("gravity")), amplitude = point(row.list("A_m_s2"));
    Scene scene;
    scene.mass = m;
    double stiffness = 0;
    Vec3 farthest{};
    for (std::size_t s = 0; s < k.size(); ++s) {
      scene.add(Spring{.stiffness = k[s], .anchor = point(anchors, 3 * s)});
      stiffness += k[s];
      for (std::size_t axis = 0; axis < 3; ++axis) farthest[axis] = std::max(farthest[axis], std::abs(anchors[3 * s + axis]));
    }
    if (drag > 0) scene.add(Drag{.coefficient = drag, .wind = wind});
    scene.add(Constant{.acceleration = gravity});
    scene.add(Sinusoid{.acceleration = amplitude, .angular_frequency = Omega, .phase = row["phase"]});
    const Vec3 x0 = point(row.list("x0")), v0 = point(row.list("v0"));
    Answer answer{.name = "case " + row.text("case"), .start = alone(x0, v0), .time = row["t_s"], .end = {}, .scale = {}};
    answer.start.scene = std::move(scene);
    answer.end = {{row["x"], row["y"], row["z"]}, {row["vx"], row["vy"], row["vz"]}};
    answer.phase = 4e-16 * std::sqrt(stiffness / m) * answer.time;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double pull = std::abs(gravity[axis]) + std::abs(amplitude[axis]) + drag / m * std::abs(wind[axis]);
      cases.see(answer.name, axis, answer.end.x[axis], answer.end.v[axis]);
      answer.scale[axis] =
          cases.with(answer.name, axis,
                     scale_of(stiffness / m, drag / m, farthest[axis], pull, x0[axis], v0[axis], answer.time), stiffness / m);
    }
    answers.push_back(std::move(answer));
  }
  return answers;
}

TEST_CASE_TEMPLATE("oracles: springs, drag, wind and gravity along an axis", T, float, double) {
  check_answers<T>(linear_answers());
}

TEST_CASE_TEMPLATE("oracles: forced by a sinusoid, free, resonant and nearly so", T, float, double) {
  check_answers<T>(sinusoid_answers());
}

TEST_CASE_TEMPLATE("oracles: driven by a polynomial of time", T, float, double) { check_answers<T>(polynomial_answers()); }

TEST_CASE_TEMPLATE("oracles: several springs, drag, wind, gravity and a shaking in space", T, float, double) {
  check_answers<T>(space_answers());
}

// ---- particles that differ ----------------------------------------------------------------------------------------------

// Cases with the same time as one batch, with individual stiffness, drag and anchor.
TEST_CASE_TEMPLATE("oracles: all springs and drags of one time as particles of one plan", T, float, double) {
  const Oracle oracle("linear1d.csv");
  std::map<double, std::vector<std::size_t>> times;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    if (oracle[i]["a_"] == 0 && oracle[i]["u_"] == 0) times[oracle[i]["t_"]].push_back(i);
  }
  REQUIRE(times.size() > 3);
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    for (const auto& [time, rows] : times) {
      Joined batch;
      std::vector<double> W, g;
      std::vector<Vec3> anchors;
      for (const std::size_t i : rows) {
        const auto row = oracle[i];
        batch.x.push_back({row["x0"], row["x0"], row["x0"]});
        batch.v.push_back({row["v0"], row["v0"], row["v0"]});
        W.push_back(row["W_"]);
        g.push_back(row["g_"]);
        anchors.push_back({row["c_"], row["c_"], row["c_"]});
      }
      batch.scene.add(Spring{.stiffness = W, .anchor = anchors});
      batch.scene.add(Drag{.coefficient = g});
      batch.step = time;
      const auto got = test::stepped<T>(batch, run, 1);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto row = oracle[rows[k]];
        Scale scale = scale_of(W[k], g[k], row["c_"], 0, row["x0"], row["v0"], time);
        scale.see(row["x_m"], row["v_m"]);
        // Coefficients made in lanes have a phase accurate to z eps.
        const double part = bound<T>.one + 4e-16 * std::sqrt(W[k]) * time;
        const auto where = [&row, t = time] { return "case " + row.text("case") + " at " + std::to_string(t) + " s"; };
        scale.v = std::max(scale.v, std::sqrt(W[k]) * scale.x);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          margin.see(std::abs(static_cast<double>(got[6 * k + axis]) - row["x_m"]), part * scale.x, where);
          margin.see(std::abs(static_cast<double>(got[6 * k + 3 + axis]) - row["v_m"]), part * scale.v, where);
        }
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

// The scale of psi_k's error: its own value or, if it oscillates through zero, the amplitude exp(-q/2)/z^k. A response that has
// decayed to nothing is measured relative to a tiny part of its largest value, which is below 1/q.
double envelope(int k, double exact, double w, double q) {
  if (k == 0) return 1;
  const double swing = 4 * w > q * q ? std::exp(-q / 2) * std::pow(w, -0.5 * k) : 0.0;
  return std::max({std::abs(exact), swing, 1e-20 / std::max(1.0, q)});
}

constexpr std::array factorials = {1.0, 1.0, 2.0, 6.0};

// After a step of 1 s from rest under a(t) = t^k/k!: x = psi_{k+2}, v = psi_{k+1}; from v = 1: x = psi_1, v = psi_0.
Joined responding(const Oracle& oracle, std::size_t from, std::size_t count, int power) {
  Joined batch;
  std::vector<double> W, g;
  for (std::size_t i = from; i < from + count; ++i) {
    W.push_back(oracle[i]["w"]);
    g.push_back(oracle[i]["q"]);
  }
  const double kick = power < 0 ? 1 : 0;
  batch.x.assign(count, {});
  batch.v.assign(count, {kick, kick, kick});
  batch.step = 1;
  // A list of numbers is made in lanes, one for each particle; a single number is made by the plan.
  if (count == 1) {
    batch.scene.add(Spring{.stiffness = W[0]});
    batch.scene.add(Drag{.coefficient = g[0]});
  } else {
    batch.scene.add(Spring{.stiffness = W});
    batch.scene.add(Drag{.coefficient = g});
  }
  if (power >= 0) {
    std::vector<Vec3> terms(static_cast<std::size_t>(power) + 1);
    const double term = 1 / factorials[static_cast<std::size_t>(power)];
    terms.back() = {term, term, term};
    batch.scene.add(Polynomial{.acceleration = terms});
  }
  return batch;
}

template <class T>
void see_responses(Margin& margin, const Oracle& oracle, const Run& run, std::size_t from, std::size_t count) {
  const DealtRows<T> dealt(run);
  for (int power = -1; power <= 3; ++power) {
    const auto got = test::stepped<T>(responding(oracle, from, count, power), run, 1);
    for (std::size_t i = 0; i < count; ++i) {
      if (!dealt.has(from + i)) continue;
      const auto row = oracle[from + i];
      const double w = row["w"], q = row["q"];
      for (const int k : {power + 1, power + 2}) {
        const double exact = row["psi" + std::to_string(k)];
        // below the smallest normal number a float32 is 0
        if (std::abs(exact) < 100 * static_cast<double>(std::numeric_limits<T>::min())) continue;
        const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
        const double unit = eps * (sizeof(T) == 8 ? std::max(16.0, std::sqrt(w)) : 4 + 1e-8 * std::sqrt(w));
        const double value = static_cast<double>(got[6 * i + (k == power + 1 ? 3 : 0)]);
        margin.see(std::abs(value - exact), unit * envelope(k, exact, w, q),
                   [&] { return "psi_" + std::to_string(k) + " at w = " + row.text("w") + ", q = " + row.text("q"); });
      }
    }
  }
}

TEST_CASE_TEMPLATE("oracles: psi_0 to psi_5 are the responses of a step to a kick, a push, a ramp and on", T, float, double) {
  const Oracle oracle("psi.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin each, together;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (dealt.has(i)) see_responses<T>(each, oracle, run, i, 1);
    }
    see_responses<T>(together, oracle, run, 0, oracle.size());
    CHECK_MESSAGE(each.is_kept(), words << ", " << 8 * sizeof(T) << " bits, a plan each: " << each.words());
    CHECK_MESSAGE(together.is_kept(), words << ", " << 8 * sizeof(T) << " bits, one plan: " << together.words());
  });
}

// A step of 1 s by Method::exact: the response to a distance of 1 m, and to a velocity or a wind of 1 m/s.
TEST_CASE_TEMPLATE("oracles: the coefficients of a spring and of a drag alone", T, float, double) {
  const Oracle oracle("coefficients.csv");
  const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      const double z = row["z"], c1 = row["c1"], c2 = row["c2"], c3 = row["c3"];
      const auto where = [&] { return row.text("kind") + " " + row.text("z"); };
      const auto end_of = [&](const Force& force, double speed) {
        Joined start = alone({}, {speed, speed, speed});
        start.scene.method = Method::exact;
        start.scene.add(force);
        start.step = 1;
        const auto got = test::stepped<T>(start, run, 1);
        return std::array{static_cast<double>(got[0]), static_cast<double>(got[3])};
      };
      if (row.text("kind") == "spring") {
        // W = z^2 is rounded: the oracle is moved along its derivative to the root of the rounded W.
        const double W = z * z;
        const double dz = -std::fma(z, z, -W) / (2 * z);
        const double sine = c1 / z, cosine = 1 - c2;
        const auto [x, v] = end_of(Spring{.stiffness = W, .anchor = Vec3{1, 1, 1}}, 0);
        margin.see(std::abs(v - (c1 + dz * (sine + z * cosine))), 4 * eps * std::max(std::abs(c1), z > 1 ? z : 0.0), where);
        margin.see(std::abs(x - (c2 + dz * sine)), 4 * eps * (c2 > 1e-3 ? 1 : c2), where);
        const auto [way, left] = end_of(Spring{.stiffness = W}, 1);
        margin.see(std::abs(way - (1 - c3 + dz * (cosine - sine / z) / z)), 4 * eps, where);
        margin.see(std::abs(left - (cosine - dz * sine)), 4 * eps, where);
      } else {
        const auto [x, v] = end_of(Drag{.coefficient = z, .wind = {1, 1, 1}}, 0);
        margin.see(std::abs(v - c2), 4 * eps * c2, where);
        margin.see(std::abs(x - c3), 4 * eps * c3, where);
        const auto [way, left] = end_of(Drag{.coefficient = z}, 1);
        margin.see(std::abs(left - c1), 4 * eps, where);
        margin.see(std::abs(way - (1 - c3)), 4 * eps, where);
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

// ---- impacts ------------------------------------------------------------------------------------------------------------

std::size_t steps_at(double hertz, double time) { return static_cast<std::size_t>(std::ceil(time * hertz)); }

// The allowed error relative to the height and the speed at the start of a bounce.
template <class T>
constexpr double bounce_bound = sizeof(T) == 8 ? 1e-12 : 5e-4;

Joined bouncing(const Oracle::Row& row, double time) {
  Joined start = alone({0, row["y0_m"], 0}, {0, row["v0_m_s"], 0});
  start.scene.add(Constant{.acceleration = {0, -row["g_m_s2"], 0}});
  start.scene.add(Plane{.restitution = row["restitution"]});
  start.step = time / static_cast<double>(steps_at(60, time));
  return start;
}

TEST_CASE_TEMPLATE("oracles: bounces on the ground, to the rest and beyond", T, float, double) {
  const Oracle oracle("bounce1d_states.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      const double time = row["t_s"], g = row["g_m_s2"];
      const auto got = test::stepped<T>(bouncing(row, time), run, steps_at(60, time));
      const double top = row["y0_m"] + row["v0_m_s"] * row["v0_m_s"] / (2 * g);
      const double fastest = std::sqrt(2 * g * top);
      const auto where = [&] { return "case " + row.text("case") + " at " + row.text("t_s") + " s"; };
      const double y = static_cast<double>(got[1]), v = static_cast<double>(got[4]);
      margin.see(std::abs(y - row["y_m"]), bounce_bound<T> * top, where);
      // At the ground the velocity may be that before or after the impact.
      if (row["y_m"] > 1e-3 * top) margin.see(std::abs(v - row["v_m_s"]), 10 * bounce_bound<T> * fastest, where);
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

TEST_CASE_TEMPLATE("oracles: times of impacts, looked back at from a quarter of the flight that follows", T, float, double) {
  const Oracle oracle("bounce1d_times.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      const double g = row["g_m_s2"];
      const double flight = 2 * row["restitution"] * row["impact_speed"] / g;
      if (flight < (sizeof(T) == 8 ? 1e-3 : 2e-2)) continue;
      const double time = row["t_bounce"] + flight / 4;
      const auto got = test::stepped<T>(bouncing(row, time), run, steps_at(60, time));
      const double y = static_cast<double>(got[1]), v = static_cast<double>(got[4]);
      const double seconds_ago = (std::sqrt(v * v + 2 * g * y) - v) / g;
      margin.see(std::abs(time - seconds_ago - row["t_bounce"]), (sizeof(T) == 8 ? 1e-12 : 1e-4) * row["t_bounce"],
                 [&] { return "case " + row.text("case") + ", bounce " + row.text("bounce"); });
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

TEST_CASE_TEMPLATE("oracles: bounces on oblique planes that keep a part of the tangential velocity", T, float, double) {
  const Oracle oracle("bounce3d.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin margin;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      const Vec3 n{row["nx"], row["ny"], row["nz"]};
      const double g = row["g_along"], time = row["t_s"];
      Joined start = alone({row["x0"], row["y0"], row["z0"]}, {row["vx0"], row["vy0"], row["vz0"]});
      start.scene.add(Constant{.acceleration = {-g * n[0], -g * n[1], -g * n[2]}});
      start.scene.add(Plane{.normal = n,
                            .offset = row["d_m"],
                            .restitution = row["restitution"],
                            .viscosity = -std::log(row["tangential_keep"])});
      start.step = time / static_cast<double>(steps_at(60, time));
      const auto got = test::stepped<T>(start, run, steps_at(60, time));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        margin.see(std::abs(static_cast<double>(got[axis]) - row[std::string(1, "xyz"[axis])]), sizeof(T) == 8 ? 1e-12 : 2e-5,
                   [&] { return "case " + row.text("case") + " at " + row.text("t_s") + " s, m"; });
      }
    }
    CHECK_MESSAGE(margin.is_kept(), words << ", " << 8 * sizeof(T) << " bits: " << margin.words());
  });
}

// A particle moves at 1 m/s and sticks where it touches. Its place gives the time of the impact.
TEST_CASE_TEMPLATE("oracles: the time of impact within a step, in free fall, in drag and on a spring", T, float, double) {
  const Oracle oracle("toi.csv");
  for_each_run([&](const Run& run, const std::string& words) {
    Margin parabola, curved;
    const DealtRows<T> dealt(run);
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      if (!dealt.has(i)) continue;
      const auto row = oracle[i];
      const double W = row["W_1_s2"], g = row["g_1_s"], h = row["h_s"];
      if (g * h > 0.1 || std::sqrt(W) * h > 0.3) continue;  // two Newton steps are enough
      Joined start = alone({0, row["s0_m"], 0}, {1, row["v0_m_s"], 0});
      if (W > 0) start.scene.add(Spring{.stiffness = {0, W, 0}, .anchor = Vec3{0, row["c_m"], 0}});
      if (g > 0) start.scene.add(Drag{.coefficient = {0, g, 0}});
      if (row["a_m_s2"] != 0) start.scene.add(Constant{.acceleration = {0, row["a_m_s2"], 0}});
      start.scene.add(Plane{.restitution = 1, .friction = std::numeric_limits<double>::infinity()});
      start.step = h;
      const auto got = test::stepped<T>(start, run, 1);
      const double error = std::abs(static_cast<double>(got[0]) / h - row["f_exact"]);
      const bool is_parabola = row.text("kind") == "parabola";
      // In float32 the height is rounded before any computation, which shifts the time by this part of the step.
      const double height = std::abs(row["s0_m"]) + std::abs(row["c_m"]);
      const double rounding = sizeof(T) == 8 ? 0 : 4e-7 * (1 + height / (std::abs(row["v_impact"]) * h));
      (is_parabola ? parabola : curved).see(error, (is_parabola ? 1e-12 : 1e-10) + rounding, [&] {
        return "row " + std::to_string(i) + ", " + row.text("kind");
      });
    }
    CHECK_MESSAGE(parabola.is_kept(), words << ", " << 8 * sizeof(T) << " bits, parabola: " << parabola.words());
    CHECK_MESSAGE(curved.is_kept(), words << ", " << 8 * sizeof(T) << " bits, drag and springs: " << curved.words());
  });
}

}  // namespace dvdx::test::oracle_answers
