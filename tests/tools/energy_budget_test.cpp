// The energy that forces can have given a scene's particles, compared with known motions, and a run's messages about it.
#include "watch/energy_budget.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/ranks.hpp"
#include "state/start.hpp"
#include "support/close.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"
#include "watch/energy.hpp"
#include "watch/heat_watch.hpp"
#include "watch/observer.hpp"

namespace energy_budget_test {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::is_close;

// Two particles of 2 kg on a spring of 50 N/m and 1 m, moving at 1 m/s across it.
SceneFile pair_of(std::vector<Force> forces, double distance = 1) {
  SceneFile file{.path = {}, .name = {}, .about = {}, .particles = {}, .scene = {}};
  file.step = 1e-3;
  file.particles = {.count = 2,
                    .position = std::vector<Vec3>{{0, 3, 0}, {distance, 3, 0}},
                    .velocity = std::vector<Vec3>{{0, 0, 1}, {0, 0, 1}}};
  file.scene.mass = 2.0;
  file.scene.forces = std::move(forces);
  file.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 50.0, .rest_length = Scalars(1.0)}));
  return file;
}

struct Run {
  double kinetic = 0, given = 0, share = 0;
  double energy_gained = 0;  // by the state itself, as `energy` computes it
};

Run run_of(const SceneFile& file, std::uint64_t steps, std::uint64_t every) {
  Soa<double> memory(2);
  auto state = memory.view();
  place_at_start(file, state);
  const auto plan = compile<double>(file.scene, {.step = file.step}, state);
  REQUIRE(plan);
  EnergyBudget budget(file, state);
  const double start = energy(file, state);
  for (std::uint64_t n = 0; n < steps; n += every) {
    REQUIRE(plan->step(state, every) == StepResult::done);
    budget.look(state);
  }
  return {.kinetic = budget.kinetic(),
          .given = budget.given(),
          .share = budget.share(),
          .energy_gained = energy(file, state) - start};
}

TEST_CASE("energy: a torn spring of a grid or of a list stores none") {
  SceneFile file = pair_of({}, 1.5);
  Soa<double> memory(2);
  State<double> state = memory.view();
  place_at_start(file, state);
  CHECK(is_close(energy(file, state), 2.0 + 0.5 * 50 * 0.25, 1e-12));
  std::get<Springs>(file.scene.networks[0]).broken = {{1, 0}};
  CHECK(is_close(energy(file, state), 2.0, 1e-12));

  Grid grid{.rows = 2, .columns = 2, .edge_u = {1, 0, 0}, .edge_v = {0, 1, 0}, .structural = 8, .shear = 2};
  SceneFile sheet{.path = {}, .name = {}, .about = {}, .particles = {}, .scene = {}};
  sheet.particles = {.count = 4, .position = std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}}};
  sheet.scene.add(Network(grid));
  Soa<double> of_sheet(4);
  State<double> stretched = of_sheet.view();
  place_at_start(sheet, stretched);
  const double diagonals = (std::sqrt(5.0) - std::sqrt(2.0)) * (std::sqrt(5.0) - std::sqrt(2.0));  // both, at 2 N/m, halved
  CHECK(is_close(energy(sheet, stretched), 0.5 * 8 * 2 + 2 * diagonals, 1e-12));
  std::get<Grid>(sheet.scene.networks[0]).broken = {{0, 1}, {2, 1}};
  CHECK(is_close(energy(sheet, stretched), 0.5 * 8 + diagonals, 1e-12));
}

TEST_CASE("energy budget: gravity's work accounts for the fall of a pair, however far apart the looks are") {
  for (const std::uint64_t every : {1U, 40U, 200U}) {
    const auto run = run_of(pair_of({Constant{.acceleration = {0, -10, 0}}}), 200, every);
    CHECK(is_close(run.kinetic, 2.0 + 4 * 0.5 * 4, 1e-9));  // 2 m/s down besides 1 m/s across
    CHECK(is_close(run.share, 1, 1e-9));
  }
}

TEST_CASE("energy budget: the energy of a spring stretched at the start counts as given") {
  const auto file = pair_of({Constant{.acceleration = {0, -10, 0}}}, 1.5);
  const auto run = run_of(file, 500, 20);
  CHECK(std::abs(run.energy_gained) < 1e-3);  // gravity's potential falls by as much as the rest rises
  CHECK(is_close(run.given, 2.0 + 0.5 * 50 * 0.25 + 4 * 10 * 1.25, 1e-6));  // 1.25 m in half a second
  CHECK(run.share > 0.9);
  CHECK(run.share <= 1 + 1e-9);
}

TEST_CASE("energy budget: the work of forces that vary with time is right to 1e-3 with looks 10 steps apart") {
  const double omega = 3;
  const auto file = pair_of(
      {Sinusoid{.acceleration = {0, 5, 0}, .angular_frequency = omega}, Polynomial{.acceleration = {{0, 0, 0}, {0, 1, 0}}}});
  const auto run = run_of(file, 600, 10);
  const double t = 0.6;
  const double v = 5 / omega * (1 - std::cos(omega * t)) + 0.5 * t * t;
  CHECK(is_close(run.kinetic, 2.0 + 0.5 * 4 * v * v, 1e-6));
  CHECK(is_close(run.given, run.kinetic, 1e-3));
}

TEST_CASE("energy budget: a force that grows with time works by Simpson's rule, exactly in one look") {
  const auto run = run_of(pair_of({Polynomial{.acceleration = {{0, 0, 0}, {0, 10, 0}}}}), 500, 500);
  const double v = 5 * 0.5 * 0.5;
  CHECK(is_close(run.kinetic, 2.0 + 0.5 * 4 * v * v, 1e-9));
  CHECK(is_close(run.given, run.kinetic, 1e-9));
}

TEST_CASE("energy budget: work counts as given even after the force takes it back") {
  const double omega = 3;
  const auto run = run_of(pair_of({Sinusoid{.acceleration = {0, 5, 0}, .angular_frequency = omega}}), 2090, 10);  // a period
  CHECK(is_close(run.kinetic, 2.0, 1e-3));
  const double fastest = 2 * 5 / omega;
  CHECK(is_close(run.given, 2.0 + 0.5 * 4 * fastest * fastest, 1e-3));
}

TEST_CASE("energy budget: the work of wind is at most its force times the distance") {
  const auto run = run_of(pair_of({Drag{.coefficient = 4.0, .wind = {0, 0, 6}}}), 400, 20);
  const double t = 0.4;  // at a rate of 2/s towards the wind's 6 m/s
  const double v = 6 - 5 * std::exp(-2 * t);
  const double way = 6 * t - 2.5 * (1 - std::exp(-2 * t));
  CHECK(is_close(run.kinetic, 0.5 * 4 * v * v, 1e-9));
  CHECK(is_close(run.given, 2.0 + 2 * 4 * 6 * way, 1e-9));
  CHECK(run.share < 1);
}

TEST_CASE("energy budget: motion within rounding has the share 0, and a velocity of NaN gives NaN") {
  auto file = pair_of({});
  file.particles.velocity = Vec3{};
  Soa<double> memory(2);
  auto state = memory.view();
  place_at_start(file, state);
  EnergyBudget budget(file, state);
  state.v[0][1] = 1e-4;  // a tenth of a thousand roundings of 1 m within a millisecond
  budget.look(state);
  CHECK(budget.share() == 0);
  state.v[0][1] = 10;
  budget.look(state);
  CHECK(budget.share() > 1e3);
  state.v[0][1] = std::nan("");
  budget.look(state);
  CHECK(std::isnan(budget.share()));
}

TEST_CASE("energy budget: a scene without a known bound gets no looks") {
  auto file = pair_of({Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 30}});
  CHECK(steps_between_looks(file) == 10);  // 0.3 rad
  file.step = 1.0 / 60;
  CHECK(steps_between_looks(file) == 1);  // 0.5 rad a step
  file.step = 0.1;
  CHECK_FALSE(steps_between_looks(file));
  file.scene.forces.clear();
  CHECK(steps_between_looks(file) == 32);
  file.step = -0.1;
  CHECK_FALSE(steps_between_looks(file));
  file.step = 0.1;
  file.turnover.capacity = 5;
  CHECK_FALSE(steps_between_looks(file));
  file.turnover.capacity = 0;
  file.scene.networks.clear();
  CHECK_FALSE(steps_between_looks(file));
  file.scene.add(Distance{.pairs = {{0, 1}}, .length = 1.0});
  CHECK(steps_between_looks(file) == 32);
}

TEST_CASE("energy budget: the allowed share rises as a scheme nears its limit") {
  NetworkLimit limit{.substeps = 2, .frequency = 100, .limit = 2};
  CHECK(is_close(most_share(limit, 0.02), 1.3 / 0.75, 1e-12));  // half of the limit
  CHECK(is_close(most_share(limit, 0.2), 13, 1e-12));
  limit.limit = std::numeric_limits<double>::infinity();
  CHECK(is_close(most_share(limit, 0.2), 1.3, 1e-12));
}

// Whether a pair heats that has twice the kinetic energy it was given: at the bound of its frequency it may have 13 times that,
// at a low frequency only 1.3 times.
bool heats_at(double frequency) {
  const LoadedScene loaded{.file = pair_of({})};
  Soa<double> memory(2);
  auto state = memory.view();
  place_at_start(loaded.file, state);
  OneRank alone;
  Checkpoints checkpoints({}, {}, {}, CallsEnd::anywhere, {}, alone);
  Observer<double> observer(loaded, {.precision = Precision::float64}, {}, {}, checkpoints, alone);
  const NetworkLimit at_bound{.frequency = 2 / loaded.file.step, .limit = 2};
  const FindFrequency find = [frequency] { return frequency; };
  HeatWatch<double> heat(loaded, at_bound, find, observer, state);
  for (std::size_t i = 0; i < 2; ++i) state.v[2][i] = std::sqrt(2.0);
  heat.look(state, 1);
  return heat.warmth()->is_heating;
}

TEST_CASE("energy budget: the frequency at the start decides whether a run heats, where its bound leaves that open") {
  CHECK(heats_at(1));
  CHECK_FALSE(heats_at(1900));
}

// A sheet at rest that the wind carries along: all its motion comes from the air.
TEST_CASE("energy budget: the work of wind on cloth is counted, however dense the air") {
  for (const double density : {0.1, 1.2, 1000.0}) {
    SceneFile file;
    file.step = 1.0 / 60;
    file.particles.count = 9;
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < 9; ++i) places.push_back({static_cast<double>(i % 3), 0, static_cast<double>(i / 3)});
    file.particles.position = places;
    file.scene.mass = 0.1;
    file.scene.add(Network(Grid{.rows = 3, .columns = 3, .edge_u = {2, 0, 0}, .edge_v = {0, 0, 2}, .structural = 10}));
    std::get<Grid>(file.scene.networks[0]).aerodynamics = Aerodynamics{.density = density};
    file.scene.wind.mean = {0, 6, 1};
    Soa<double> memory(9);
    auto state = memory.view();
    place_at_start(file, state);
    const auto plan = compile<double>(file.scene, {.step = file.step}, state);
    REQUIRE(plan.has_value());
    EnergyBudget budget(file, state);
    const auto steps = steps_between_looks(file);
    REQUIRE(steps.has_value());
    double most = 0;
    for (int look = 0; look < 60; ++look) {
      REQUIRE(plan->step(state, *steps) == StepResult::done);
      budget.look(state);
      most = std::max(most, budget.share());
    }
    CHECK(most > 5e-4);  // share of a bound that is far too high where the air is dense
    CHECK(most <= 1.05);
  }
}

// 32 x 32 particles held by two corners, in steps far too coarse for their springs.
constexpr const char* sheet = R"({
  "format": "dvdx-scene/1", "name": "sheet", "step": 0.016666666666666666, "duration": 4,
  "network": {"type": "grid", "rows": 32, "columns": 32, "origin": [0, 0, 0], "edge_u": [2, 0, 0], "edge_v": [0, 0, 2],
              "mass": 1, "structural": 1e4, "shear": 1e4, "fixed": "corners_top", "scheme": "sequential", "substeps": 2,
              "theta": 0.55},
  "particles": {"velocity": {"uniform": {"min": [-1e-6, -1e-6, -1e-6], "max": [1e-6, 1e-6, 1e-6], "seed": 1}}},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]
})";

TEST_CASE("run warns of heating if sweeps heat a sheet, and not otherwise") {
  const test::ScratchFolder folder("heating");
  folder.write("sheet.json", sheet);
  const auto hot = test::run(folder, "run sheet.json --json --threads 1");
  CHECK(hot.exit == 0);
  CHECK(nlohmann::json::parse(hot.out)["heating"] == true);
  CHECK(hot.err.find("Try without theta and with --substeps auto, or 8 if that is not enough") != std::string::npos);
  std::string cured = sheet;
  cured.erase(cured.find(",\n              \"theta\": 0.55"), std::string(",\n              \"theta\": 0.55").size());
  folder.write("cured.json", cured);
  CHECK(test::run(folder, "run cured.json --threads 1 --substeps auto").err.empty());
  const auto calm = test::run(folder, "run sheet.json --json --threads 1 --set network.theta=1 --set network.sweep=forward");
  CHECK(nlohmann::json::parse(calm.out)["heating"] == false);
  CHECK(calm.err.find("heating") == std::string::npos);
  CHECK(calm.err.find("warning: stretch") != std::string::npos);  // to five times their length
  const auto back = test::run(folder, "run sheet.json --json --threads 1 --step -0.016666666666666666 --duration 0.1");
  CAPTURE(back.err);
  CHECK(nlohmann::json::parse(back.out)["heating"].is_null());
}

// A ring of 40 links that hangs by a rod.
std::string ring(const char* substeps) {
  nlohmann::json places = nlohmann::json::array();
  nlohmann::json pairs = {{0, 40}};
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.05 * std::acos(-1) * i;
    places.push_back({0.2 * std::cos(angle), 0.19 * std::sin(angle), 0.06 * std::sin(angle)});
    pairs.push_back({i, (i + 1) % 40});
  }
  places.push_back({0.4, 0, 0});
  const nlohmann::json scene = {{"format", "dvdx-scene/1"},
                                {"name", "ring"},
                                {"step", 1.0 / 60},
                                {"duration", 5},
                                {"particles", {{"count", 41}, {"mass", 0.01}, {"position", {{"values", places}}}}},
                                {"constraints", {{{"type", "distance"}, {"pairs", pairs}, {"length", "start"}}}},
                                {"forces", {{{"type", "constant"}, {"acceleration", {0, -9.81, 0}}}}},
                                {"fixed", {40}},
                                {"substeps", nlohmann::json::parse(substeps)}};
  return scene.dump();
}

TEST_CASE("run warns of heating if rods gain energy, and not otherwise") {
  const test::ScratchFolder folder("rods");
  folder.write("hot.json", ring("1"));
  folder.write("calm.json", ring("\"auto\""));
  const auto hot = test::run(folder, "run hot.json --json --threads 1");
  CHECK(hot.exit == 0);
  CHECK(nlohmann::json::parse(hot.out)["heating"] == true);
  CHECK(hot.err.find("Try --substeps auto, or 4 if that is not enough") != std::string::npos);
  const auto calm = test::run(folder, "run calm.json --json --threads 1 --duration 1");
  CHECK(nlohmann::json::parse(calm.out)["heating"] == false);
  CHECK(nlohmann::json::parse(calm.out)["substeps"] == 39);
  CHECK(calm.err.empty());
}

}  // namespace energy_budget_test
