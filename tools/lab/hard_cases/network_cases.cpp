// Springs between particles.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "closed_form/closed_form.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/plain_springs.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

const Coupling leapfrog{};
const Coupling by_sum{.scheme = Scheme::accumulate, .substeps = 1, .method = Method::exact};
const Coupling by_filter{.scheme = Scheme::accumulate, .substeps = 1, .method = Method::combined};
const Coupling swept{.scheme = Scheme::sequential, .substeps = 1, .theta = 0.5};

struct NamedCoupling {
  const char* name;
  Coupling coupling;
};

const std::array<NamedCoupling, 6> couplings{
    {{"leapfrog", leapfrog},
     {"fourth_order", {.scheme = Scheme::fourth_order}},
     {"sequential 0.5", swept},
     {"sequential 1 forward", {.scheme = Scheme::sequential, .theta = 1, .sweeps = SweepOrder::forward}},
     {"accumulate exact", by_sum},
     {"accumulate combined", by_filter}}};
constexpr std::array<std::string_view, std::tuple_size_v<decltype(couplings)>> momentum_constant{
    "leapfrog: momentum constant",         "fourth_order: momentum constant",
    "sequential 0.5: momentum constant",   "sequential 1 forward: momentum constant",
    "accumulate exact: momentum constant", "accumulate combined: momentum constant"};

template <class T>
std::vector<Start> bodies_of(const Trial<T>& trial) {
  std::vector<Start> bodies;
  for (std::size_t i = 0; i < trial.count(); ++i) {
    bodies.push_back({{trial.x(0, i), trial.x(1, i), trial.x(2, i)}, {trial.v(0, i), trial.v(1, i), trial.v(2, i)}});
  }
  return bodies;
}

template <class T>
double energy_now(const Trial<T>& trial, PlainSprings& system) {
  for (std::size_t i = 0; i < trial.count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      system.bodies[i].x[axis] = trial.x(axis, i);
      system.bodies[i].v[axis] = trial.v(axis, i);
    }
  }
  return system.energy();
}

double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

// NaN if any coordinate or velocity is not finite.
template <class T>
double farthest(const Trial<T>& trial) {
  Worst worst;
  for (const Start& body : bodies_of(trial)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      worst.see(std::isfinite(body.v[axis]) ? std::abs(body.x[axis]) : not_a_number);
    }
  }
  return worst.value;
}

// --- 4: the limit of leapfrog -------------------------------------------------------------------------------------------

// Adds `count` bodies of 1 kg in a row, 1 m apart, slightly disturbed. omega is the highest frequency of that row.
void add_row(PlainSprings& system, std::size_t count, double omega) {
  const auto n = static_cast<double>(count);
  const double k = omega * omega / (2 - 2 * std::cos(std::acos(-1.0) * (n - 1) / n));
  const std::size_t first = system.bodies.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<double>(i);
    system.bodies.push_back({{at + 0.05 * std::sin(3 * at + 1), 0, 0}, {0, 0.1 * std::cos(2 * at), 0}});
    system.mass.push_back(1);
    if (i > 0) system.links.push_back({first + i - 1, first + i, k, 1});
  }
}

// The energies of several rows that one trial steps together.
template <class T>
class RowEnergies {
 public:
  RowEnergies(const Trial<T>& trial, const std::vector<PlainSprings>& rows) : trial_(trial), rows_(rows) {
    for (std::size_t r = 0; r < rows_.size(); ++r) start_.push_back(now(r));
  }
  [[nodiscard]] double change(std::size_t row) { return std::abs(now(row) / start_[row] - 1); }

 private:
  double now(std::size_t row) {
    std::size_t first = 0;
    for (std::size_t r = 0; r < row; ++r) first += rows_[r].bodies.size();
    PlainSprings& system = rows_[row];
    for (std::size_t i = 0; i < system.bodies.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        system.bodies[i].x[axis] = trial_.x(axis, first + i);
        system.bodies[i].v[axis] = trial_.v(axis, first + i);
      }
    }
    return system.energy();
  }

  const Trial<T>& trial_;
  std::vector<PlainSprings> rows_;
  std::vector<double> start_;
};

// Rows of 2 and of 8, checked after every step in windows of a hundred steps. The slowest oscillation takes 40 steps.
template <class T>
Worst limit_of_leapfrog(CaseRun& way) {
  Worst worst;
  for (const double z : {1.8, 1.99, 2.01, 2.2, 7.0}) {
    PlainSprings both;
    std::vector<PlainSprings> rows(2);
    for (std::size_t r = 0; r < 2; ++r) {
      add_row(both, r == 0 ? 2 : 8, z / hz60);
      add_row(rows[r], r == 0 ? 2 : 8, z / hz60);
    }
    Trial<T> trial(way, scene_of(both, leapfrog), hz60, both.bodies);
    RowEnergies<T> energies(trial, rows);
    for (int window = 0; window < way.looks; ++window) {
      for (int look = 0; look < 100; ++look) {
        trial.step();
        for (std::size_t r = 0; r < 2; ++r) {
          worst.see(energies.change(r), fmt::format("{} bodies, omega h = {:g}", rows[r].bodies.size(), z));
        }
      }
      trial.step(9900);
    }
  }
  return worst;
}

// --- 16: unequal masses -------------------------------------------------------------------------------------------------

// Two pairs with one scheme, one of them drifting.
template <class T, std::size_t which>
Worst unequal_masses(CaseRun& way) {
  constexpr std::array drifts{0.0, 1e-3};  // m/s
  PlainSprings system;
  for (std::size_t pair = 0; pair < drifts.size(); ++pair) {
    const double drift = drifts[pair];
    system.mass.insert(system.mass.end(), {1, 1e6});
    system.bodies.push_back({{0, 0, 0}, {drift - 0.7, 0.4, 0}});
    system.bodies.push_back({{1.1, 0, 0}, {drift + 0.7e-6, -0.4e-6, 0}});
    system.links.push_back({2 * pair, 2 * pair + 1, 100, 1});
  }
  Trial<T> trial(way, scene_of(system, couplings[which].coupling), hz60, system.bodies);
  const auto momentum = [&](std::size_t pair, std::size_t axis) {
    return trial.v(axis, 2 * pair) + 1e6 * trial.v(axis, 2 * pair + 1);
  };
  const std::array<Vec3, 2> start{{{momentum(0, 0), momentum(0, 1), 0}, {momentum(1, 0), momentum(1, 1), 0}}};
  Worst worst;
  for (int look = 0; look < way.looks; ++look) {
    trial.step(10000);
    for (std::size_t pair = 0; pair < drifts.size(); ++pair) {
      const double scale = 1 + 1e6 * drifts[pair];  // kg m/s that the two bodies exchange
      for (const std::size_t axis : {0U, 1U}) {
        worst.see(std::abs(momentum(pair, axis) - start[pair][axis]) / scale,
                  fmt::format("drifting at {:g} m/s", drifts[pair]));
      }
    }
  }
  return worst;
}

// Float32 only, in the order of the couplings.
constexpr std::array<std::optional<KnownMiss>, momentum_constant.size()> momentum_misses{
    std::nullopt, KnownMiss{1.6e-4, "the heavy one's velocity is rounded at each of six pulses a sub-step"},
    std::nullopt, KnownMiss{1.3e-4, "the heavy one's velocity is what its rounded positions differ by"},
    std::nullopt, std::nullopt};

// One bar for each scheme.
std::vector<Bar> bars_of_unequal_masses() {
  std::vector<Bar> bars;
  const auto add = [&]<std::size_t which>(std::integral_constant<std::size_t, which>) {
    const auto bar = [&](std::string_view precision, Check check, double limit) {
      bars.push_back({.precision = precision,
                      .check = check,
                      .limit = limit,
                      .unit = "sum m |v|",
                      .expected = momentum_constant[which],
                      .known_miss = precision == float32 ? momentum_misses[which] : std::nullopt,
                      .runs_on = RunsOn::only_best_whole});
    };
    bar(float64, unequal_masses<double, which>, 1e-12);
    bar(float32_compensated, unequal_masses<Compensated, which>, 1e-8);
    bar(float32, unequal_masses<float, which>, 1e-4);
  };
  [&]<std::size_t... which>(std::index_sequence<which...>) { (add(std::integral_constant<std::size_t, which>()), ...); }
  (std::make_index_sequence<momentum_constant.size()>());
  return bars;
}

// --- 17, 18: springs without a direction --------------------------------------------------------------------------------

// A spring of zero rest length to a point equals the linear spring in every direction. So does one between two bodies, on their
// line and when they turn about each other.
enum class Ends { to_a_point, on_a_line, turning };

template <class T>
double turned(CaseRun& way, double z, Ends ends) {
  const double omega = z / hz60;
  const double k = omega * omega;
  const bool is_pair = ends != Ends::to_a_point;
  const Vec3 v0 = ends == Ends::on_a_line ? Vec3{-0.6 * omega, 0, 0.8 * omega} : Vec3{0, omega, 0};
  Scene scene;
  std::vector<Start> starts{{{0.6, 0, -0.8}, v0}};
  if (is_pair) {
    scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = k / 2, .rest_length = Scalars(0.0)}));
    scene.coupling = by_sum;
    starts = {{{-0.3, 0, 0.4}, {-v0[0] / 2, -v0[1] / 2, -v0[2] / 2}}, {{0.3, 0, -0.4}, {v0[0] / 2, v0[1] / 2, v0[2] / 2}}};
  } else {
    scene.add(RadialSpring{.stiffness = k});
  }
  Trial<T> trial(way, scene, hz60, starts);
  const auto axis_now = [&](std::size_t axis) -> AxisState {
    if (!is_pair) return {trial.x(axis), trial.v(axis)};
    return {trial.x(axis, 1) - trial.x(axis, 0), trial.v(axis, 1) - trial.v(axis, 0)};
  };
  const std::array start{axis_now(0), axis_now(1), axis_now(2)};
  trial.step();
  Worst worst;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const AxisState exact = solve({.W = k, .g = 0, .polynomial = {}, .sines = {}}, start[axis], hz60);
    worst.see(static_cast<double>(std::abs(axis_now(axis).x - exact.x)));
    worst.see(static_cast<double>(std::abs(axis_now(axis).v - exact.v)) / omega);
  }
  return worst.value;
}

template <class T, Ends ends>
Worst no_rest_length(CaseRun& way) {
  Worst worst;
  for (const double z : {0.1, 3.0, 10.0, 100.0}) {
    worst.see(turned<T>(way, z, ends) / (epsilon<T> * std::max(z, 1.0)), fmt::format("omega h = {:g}", z));
  }
  return worst;
}

// Two bodies at one place, which is also their anchor: the speed that they gain.
template <class T>
Worst coincident(CaseRun& way) {
  Worst worst;
  for (const double rest_length : {0.0, 1.0}) {
    for (const auto& [name, coupling] : couplings) {
      Scene scene;
      scene.add(RadialSpring{.stiffness = 100.0, .anchor = Vec3{0.25, 0.5, 0.75}, .rest_length = rest_length});
      scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = Scalars(rest_length)}));
      scene.coupling = coupling;
      Trial<T> trial(way, scene, hz60, std::vector<Start>(2, {{0.25, 0.5, 0.75}, {}}));
      trial.step(100);
      for (const Start& body : bodies_of(trial)) {
        for (const double v : body.v) worst.see(std::abs(v), fmt::format("{}, rest length {:g} m", name, rest_length));
      }
    }
  }
  return worst;
}

// Two bodies that pass through each other or start at one place: the worst change of momentum in three steps.
template <class T>
Worst passage(CaseRun& way) {
  Worst worst;
  const std::vector<std::array<Start, 2>> starts{
      {{{{-1.5 * hz60, 0, 0}, {1, 0, 0}}, {{1.5 * hz60, 0, 0}, {-1, 0, 0}}}},        // meet in the middle of a step
      {{{{-hz60, 0, 0}, {1, 0, 0}}, {{hz60, 0, 0}, {-1, 0, 0}}}},                    // meet at the end of a step
      {{{{0.5, 0, 0}, {0.3, 0.1, 0}}, {{0.5, 0, 0}, {-0.2, 0, 0.4}}}},               // start at one place
      {{{{0.5, 0, 0}, {1, 2, 3}}, {{0.5, 0, 0}, {1, 2, 3}}}},                        // and stay together
      {{{{-1.5 * hz60, 1e-9, 0}, {1, 0, 0}}, {{1.5 * hz60, -1e-9, 0}, {-1, 0, 0}}}}  // almost meet
  };
  for (const auto& [name, coupling] : couplings) {
    for (std::size_t s = 0; s < starts.size(); ++s) {
      Scene scene;
      scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = Scalars(0.7)}));
      scene.coupling = coupling;
      Trial<T> trial(way, scene, hz60, starts[s]);
      for (std::size_t n = 0; n < 3; ++n) {
        const auto before = bodies_of(trial);
        trial.step();
        const auto after = bodies_of(trial);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double change = (after[0].v[axis] + after[1].v[axis]) - (before[0].v[axis] + before[1].v[axis]);
          const double scale = 1 + std::abs(after[0].v[axis]) + std::abs(after[1].v[axis]);
          worst.see(std::abs(change) / (epsilon<T> * scale), fmt::format("{}, start {}", name, s + 1));
        }
      }
    }
  }
  return worst;
}

// --- 19: a spinning pair ------------------------------------------------------------------------------------------------

// omega h = 0.19
PlainSprings spinning_pair() {
  PlainSprings system;
  system.mass = {1.54, 1.54};
  const double spin = 2;      // rad/s
  const double half = 0.525;  // m
  system.bodies = {{{-half, 0, 0}, {0, -half * spin, 0}}, {{half, 0, 0}, {0, half * spin, 0}}};
  system.links = {{0, 1, 100, 1}};
  return system;
}

const std::array<NamedCoupling, 5> symmetric_couplings{{{"leapfrog", leapfrog},
                                                        {"fourth_order", {.scheme = Scheme::fourth_order}},
                                                        {"accumulate exact", by_sum},
                                                        {"accumulate combined", by_filter},
                                                        {"sequential 0.5", swept}}};
template <class T>
Worst distance_after_spinning(CaseRun& way, std::span<const NamedCoupling> which) {
  const PlainSprings system = spinning_pair();
  static const auto exact = run_plain(system, 3, 30000);
  Worst worst;
  for (const auto& [name, coupling] : which) {
    Trial<T> trial(way, scene_of(system, coupling), hz60, system.bodies);
    trial.step(180);
    for (std::size_t i = 0; i < 2; ++i) worst.see(distance(bodies_of(trial)[i].x, exact[i].x), name);
  }
  return worst;
}

template <class T>
Worst spinning(CaseRun& way) {
  return distance_after_spinning<T>(way, std::span(symmetric_couplings).first(4));
}
template <class T>
Worst spinning_in_sweeps(CaseRun& way) {
  return distance_after_spinning<T>(way, std::span(symmetric_couplings).last(1));
}

template <class T>
Worst spinning_energy(CaseRun& way) {
  PlainSprings system = spinning_pair();
  const double start = system.energy();
  const std::vector<Start> bodies = system.bodies;
  Worst worst;
  for (const auto& [name, coupling] : symmetric_couplings) {
    Trial<T> trial(way, scene_of(spinning_pair(), coupling), hz60, bodies);
    for (int n = 0; n < 180; ++n) {
      trial.step();
      worst.see(std::abs(energy_now(trial, system) / start - 1), name);
    }
  }
  return worst;
}

// --- 36: a stiff rod and a soft spring ----------------------------------------------------------------------------------

PlainSprings rod_and_spring(double k) {
  PlainSprings system;
  system.mass = {0, 1, 1};
  system.bodies = {{}, {{1, 0, 0}, {}}, {{2, 0, 0}, {}}};
  system.links = {{0, 1, k, 1}, {1, 2, 50, 1}};
  system.gravity = {0, -9.81, 0};
  return system;
}

template <class T>
Worst stiff_rod(CaseRun& way) {
  Worst worst;
  for (const double k : {1e4, 1e6, 1e8}) {
    const PlainSprings system = rod_and_spring(k);
    const auto exact = run_plain(system, 2, k > 1e7 ? 1000000 : 100000);
    for (const auto& [name, coupling] : {NamedCoupling{"sequential 0.5", swept}}) {
      Trial<T> trial(way, scene_of(system, coupling), hz60, system.bodies);
      trial.step(120);
      for (std::size_t i = 1; i < 3; ++i) {
        worst.see(distance(bodies_of(trial)[i].x, exact[i].x), fmt::format("{}, {:g} N/m", name, k));
      }
    }
  }
  return worst;
}

// --- 37: cloth ----------------------------------------------------------------------------------------------------------

constexpr std::size_t side = 16;                                       // bodies
constexpr double cloth_mass = 0.3;                                     // kg
constexpr std::array cloth_stiffnesses{50.0, 500.0, 5000.0, 50000.0};  // N/m

// 16 x 16 bodies, 1 m by 1 m and 0.3 kg, hung by the two corners of the first row.
PlainSprings cloth(double k) {
  PlainSprings system;
  system.gravity = {0, 0, -9.81};
  const auto at = [](std::size_t i) { return static_cast<double>(i) / (side - 1); };
  const auto join = [&](std::size_t a, std::size_t b, double stiffness) {
    system.links.push_back({a, b, stiffness, distance(system.bodies[a].x, system.bodies[b].x)});
  };
  for (std::size_t i = 0; i < side * side; ++i) {
    system.bodies.push_back({{at(i / side), at(i % side), 0}, {}});
    system.mass.push_back(i == 0 || i == side - 1 ? 0 : cloth_mass / (side * side));
  }
  for (std::size_t row = 0; row < side; ++row) {
    for (std::size_t column = 0; column < side; ++column) {
      const std::size_t i = row * side + column;
      if (column + 1 < side) join(i, i + 1, k);
      if (row + 1 < side) join(i, i + side, k);
      if (column + 1 < side && row + 1 < side) join(i, i + side + 1, k / 2);
      if (column > 0 && row + 1 < side) join(i, i + side - 1, k / 2);
      if (column + 2 < side) join(i, i + 2, k / 10);
      if (row + 2 < side) join(i, i + 2 * side, k / 10);
    }
  }
  return system;
}

// Root mean square error over the bodies at 0.5 s, relative to the side of 1 m.
template <class T>
double cloth_error(CaseRun& way, const PlainSprings& system, const std::vector<Start>& exact, const Coupling& coupling) {
  Trial<T> trial(way, scene_of(system, coupling), hz60, system.bodies);
  trial.step(30);
  double squares = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) squares += std::pow(distance(bodies_of(trial)[i].x, exact[i].x), 2);
  return std::sqrt(squares / static_cast<double>(exact.size()));
}

// The cloths' states after 0.5 s, computed once: every instruction set is compared with the same states.
const std::vector<Start>& cloth_end(std::size_t which) {
  static const auto ends = [] {
    std::array<std::vector<Start>, cloth_stiffnesses.size()> list;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const double k = cloth_stiffnesses[i];
      list[i] = run_plain(cloth(k), 0.5, static_cast<std::size_t>(120 * std::sqrt(k)) + 200);
    }
    return list;
  }();
  return ends[which];
}

template <class T>
Worst hanging_cloth(CaseRun& way) {
  Worst worst;
  for (std::size_t i = 0; i < cloth_stiffnesses.size(); ++i) {
    const double k = cloth_stiffnesses[i];
    worst.see(cloth_error<T>(way, cloth(k), cloth_end(i), leapfrog), fmt::format("{:g} N/m", k));
  }
  return worst;
}

template <class T>
Worst swept_cloth(CaseRun& way) {
  Coupling coupling = swept;
  coupling.substeps = 32;  // 64 sweeps over the springs in a step
  Worst worst;
  worst.see(cloth_error<T>(way, cloth(500), cloth_end(1), coupling));
  return worst;
}

// The same cloth as a grid, the fastest form.
Scene grid_of_cloth(double k, const Coupling& coupling) {
  Scene scene;
  scene.mass = cloth_mass / (side * side);
  scene.fixed = {0, side - 1};
  scene.add(Constant{.acceleration = {0, 0, -9.81}});
  Grid grid{.rows = side, .columns = side, .edge_u = {0, 1, 0}, .edge_v = {1, 0, 0}, .structural = k, .shear = k / 2};
  grid.bend = k / 10;
  scene.add(Network(grid));
  scene.coupling = coupling;
  return scene;
}

// The energy that gravity has given a cloth that started at z = 0, and its kinetic part.
template <class T>
struct ClothEnergy {
  double given = 0, kinetic = 0;  // J

  explicit ClothEnergy(const Trial<T>& trial) {
    constexpr double mass = cloth_mass / (side * side);
    for (std::size_t i = 0; i < trial.count(); ++i) {
      given -= mass * 9.81 * trial.x(2, i);
      for (std::size_t axis = 0; axis < 3; ++axis) kinetic += mass / 2 * trial.v(axis, i) * trial.v(axis, i);
    }
  }
};

// Runs 1e5 steps or a tenth; 1e4 in contracted arithmetic, and with leapfrog if it takes 71 or 224 sub-steps a step. Every
// hundred steps it checks the largest coordinate, relative to ten times the sheet's length, and the kinetic energy, relative to
// 1.3 times the most that gravity has given so far. Returns the worse of both; NaN if any coordinate or velocity is NaN.
template <class T>
Worst lasting_cloth(CaseRun& way, std::span<const double> stiffnesses, const Coupling& coupling) {
  Worst worst;
  for (const double k : stiffnesses) {
    Trial<T> trial(way, grid_of_cloth(k, coupling), hz60, cloth(k).bodies);
    double given = 0;
    const bool is_dear = way.arithmetic != Arithmetic::separate || (coupling.scheme == Scheme::leapfrog && k > 500);
    const int looks = (is_dear ? 100 : 1000) / (way.duration == Duration::tenth ? 10 : 1);
    for (int look = 0; look < looks; ++look) {
      trial.step(100);
      worst.see(farthest(trial) / 10, fmt::format("{:g} N/m, length", k));
      const ClothEnergy<T> energy(trial);
      given = std::max(given, energy.given);
      worst.see(energy.kinetic / (1.3 * given), fmt::format("{:g} N/m, kinetic energy", k));
    }
  }
  return worst;
}

template <class T>
Worst lasting_leapfrog(CaseRun& way) {
  return lasting_cloth<T>(way, cloth_stiffnesses, leapfrog);
}

// One sweep to and fro in a step of 60 Hz: up to 500 N/m, omega h = 30, and beyond.
template <class T>
Worst lasting_sweeps(CaseRun& way) {
  return lasting_cloth<T>(way, std::span(cloth_stiffnesses).first(2), {.scheme = Scheme::sequential});
}
template <class T>
Worst lasting_stiff_sweeps(CaseRun& way) {
  return lasting_cloth<T>(way, std::span(cloth_stiffnesses).subspan(2), {.scheme = Scheme::sequential});
}

Bar lasts(std::string_view precision, Check check, std::string_view expected, std::optional<KnownMiss> known_miss = {}) {
  return {.precision = precision,
          .check = check,
          .limit = 1,
          .unit = "bars",
          .expected = expected,
          .known_miss = known_miss,
          .runs_on = RunsOn::best_isa};
}

constexpr KnownMiss swinging{1.6, "leapfrog's energy swings by 0.96, and the rounding of float32 adds up beside it"};
constexpr KnownMiss twice_leapfrog{1.5e-3, "implicit midpoint along the axis: its phase is off by twice leapfrog's"};

}  // namespace

std::vector<Case> network_cases() {
  return {
      {4,
       "the limit of leapfrog",
       "omega h = 1.8 to 7 in a row of 2 and of 8 bodies, 1e6 steps, sub-steps by themselves",
       {{float64, limit_of_leapfrog<double>, 1, "E0", "no blow-up: |E/E0 - 1| <= 1", {}, RunsOn::only_best_whole},
        {float32, limit_of_leapfrog<float>, 1, "E0", "no blow-up: |E/E0 - 1| <= 1", swinging, RunsOn::only_best_whole}}},
      {16, "mass ratio of a million", "a pair of 1 kg and 1e6 kg, 1e6 steps: what the heavy one gains is below its rounding",
       bars_of_unequal_masses()},
      {17,
       "no rest length",
       "linear in every direction; both ends at one place have none",
       {{float64, no_rest_length<double, Ends::to_a_point>, 4, "eps max(z, 1) A", "to a point: exact rotation"},
        {float32, no_rest_length<float, Ends::to_a_point>, 2, "eps max(z, 1) A", "to a point: exact rotation"},
        {float64, no_rest_length<double, Ends::on_a_line>, 4, "eps max(z, 1) A", "a pair on its line: exact"},
        {float32, no_rest_length<float, Ends::on_a_line>, 2, "eps max(z, 1) A", "a pair on its line: exact"},
        {float64, no_rest_length<double, Ends::turning>, 4, "eps max(z, 1) A", "a pair that turns: exact"},
        {float32, no_rest_length<float, Ends::turning>, 2, "eps max(z, 1) A", "a pair that turns: exact"},
        {float64, coincident<double>, 0, "m/s", "ends at one place stay there"},
        {float32, coincident<float>, 0, "m/s", "ends at one place stay there"}}},
      {18, "through a spring's end", "r = 0 in a step, at its end, from its start, with a rest length; every scheme",
       both<passage<double>, passage<float>>(4, 4, "eps sum |v|", "finite, momentum kept")},
      {19,
       "spinning pair",
       "2 rad/s at 60 Hz, k = 100 N/m, 3 s: the axis turns within a step",
       {{float64, spinning<double>, 1e-3, "m", "the path"},
        {float32, spinning<float>, 1e-3, "m", "the path"},
        {float64, spinning_in_sweeps<double>, 1e-3, "m", "the path, sequential 0.5", twice_leapfrog},
        {float32, spinning_in_sweeps<float>, 1e-3, "m", "the path, sequential 0.5", twice_leapfrog},
        {float64, spinning_energy<double>, 1e-3, "E0", "energy constant"},
        {float32, spinning_energy<float>, 1e-3, "E0", "energy constant"}}},
      {36, "stiff rod, soft spring", "1e4 to 1e8 N/m beside 50 N/m at 60 Hz: omega h to 170, one sweep to and fro a step",
       both<stiff_rod<double>, stiff_rod<float>>(3e-2, 3e-2, "m", "the path for 2 s")},
      {37,
       "hanging cloth",
       "16 x 16 bodies, k = 50 to 5e4 N/m at 60 Hz",
       {{float64, hanging_cloth<double>, 2e-4, "of 1 m", "leapfrog: the path for 0.5 s"},
        {float32, hanging_cloth<float>, 2e-4, "of 1 m", "leapfrog: the path for 0.5 s"},
        {float64, swept_cloth<double>, 1e-3, "of 1 m", "sequential, 64 sweeps: the path for 0.5 s"},
        {float32, swept_cloth<float>, 1e-3, "of 1 m", "sequential, 64 sweeps: the path for 0.5 s"},
        lasts(float64, lasting_leapfrog<double>,
              "leapfrog, 1e5 steps (--coarse: a tenth), stiff 1e4: a sheet, no faster than 1.3 times what gravity gives"),
        lasts(float32, lasting_leapfrog<float>,
              "leapfrog, 1e5 steps (--coarse: a tenth), stiff 1e4: a sheet, no faster than 1.3 times what gravity gives"),
        lasts(float64, lasting_sweeps<double>, "one sweep, 1e5 steps (--coarse: a tenth), to 500 N/m: likewise"),
        lasts(float32, lasting_sweeps<float>, "one sweep, 1e5 steps (--coarse: a tenth), to 500 N/m: likewise"),
        lasts(float64, lasting_stiff_sweeps<double>, "one sweep, 1e5 steps (--coarse: a tenth), 5e3 and 5e4 N/m: likewise"),
        lasts(float32, lasting_stiff_sweeps<float>, "one sweep, 1e5 steps (--coarse: a tenth), 5e3 and 5e4 N/m: likewise")}},
  };
}

}  // namespace dvdx::tool::stability
