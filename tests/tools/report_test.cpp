// The report on scenes with known results.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "report/beyond.hpp"
#include "report/build.hpp"
#include "report/claims.hpp"
#include "report/compare.hpp"
#include "report/growth.hpp"
#include "report/json.hpp"
#include "report/long_run.hpp"
#include "report/machine.hpp"
#include "report/orders.hpp"
#include "report/sample.hpp"
#include "report/summary.hpp"
#include "report/table.hpp"
#include "scene_io/scene_reader.hpp"
#include "support/close.hpp"
#include "support/paths.hpp"
#include "tools/scratch_folder.hpp"

namespace report_test {

using namespace dvdx::tool;
using namespace dvdx::tool::report;
using dvdx::test::is_close;

SceneFile shipped(const std::string& name) { return read_scene(dvdx::test::scenes() + "/" + name + ".json"); }

Setup setup() { return {.engine = {.isa = dvdx::best_isa()}, .parallel = {}}; }

SceneReport measured(const SceneFile& file, Effort effort = Effort::quick) {
  const MeasureOptions options{.precisions = {Precision::float64}, .effort = effort};
  return measure_scene(file, options, setup(), [](double, const std::string&) {});
}

const Order& order_named(const SceneReport& report, const std::string& method) {
  const auto* order = order_of(report, method, Precision::float64);
  REQUIRE(order != nullptr);
  return *order;
}

TEST_CASE("two equal springs at rest: fitted orders are those of the analysis") {
  const auto report = measured(shipped("two-springs"));
  CHECK(report.reference.kind == "closed_form");
  CHECK(report.reference.self_error < 1e-17);
  CHECK(is_close(report.amplitude, std::sqrt(0.5), 0.02));
  struct Known {
    const char* method;
    double order;
  };
  for (const Known known : {Known{"symplectic_euler", 1}, Known{"pulse", 1}, Known{"exact", 2},
                            Known{"average_acceleration", 3}, Known{"baseline_leapfrog", 2}, Known{"baseline_rk4", 4}}) {
    CAPTURE(known.method);
    const auto& order = order_named(report, known.method);
    REQUIRE(order.fitted);
    CHECK(*order.theory == known.order);
    CHECK(std::abs(*order.fitted - known.order) < 0.1);
  }
  CHECK(order_named(report, "combined").note == "exact");
  CHECK(!order_named(report, "combined").fitted);
}

TEST_CASE("every run of a report has the contract's keys, and one run has the scene's own step") {
  const auto file = shipped("two-springs");
  Report whole{.machine = {}, .scenes = {measured(file)}};
  const auto json = to_json(whole);
  bool has_own_step = false;
  for (const auto& run : json["scenes"][0]["runs"]) {
    for (const char* key :
         {"method", "scheme", "precision", "step", "substeps", "isa", "threads", "layout", "arithmetic", "ns_per_particle_step",
          "seconds_per_simulated_second", "error", "energy_drift", "order", "diverged"}) {
      CAPTURE(key);
      CHECK(run.contains(key));
    }
    CHECK(run["ns_per_particle_step"] > 0);
    CHECK(run["repeats"] >= 5);
    const double steps = file.duration / run["step"].get<double>();
    CHECK(std::abs(steps - std::round(steps)) < 1e-6);
    has_own_step = has_own_step || run["step"] == file.step;
    const double relative = run["error"]["position_rms"].get<double>() / json["scenes"][0]["amplitude"].get<double>();
    CHECK(is_close(run["error"]["relative"].get<double>(), relative, 1e-12));
  }
  CHECK(has_own_step);
  CHECK(to_text(whole).find("two springs") != std::string::npos);
}

TEST_CASE("energy over a long run grows, decays or stays as the determinants predict") {
  for (const char* name : {"one-spring", "two-springs"}) {
    CAPTURE(name);
    const auto runs = measure_long_runs(shipped(name), setup());
    REQUIRE(runs.size() == 5);
    for (const auto& run : runs) {
      CAPTURE(run.method);
      CHECK(run.agrees);
    }
  }
  const auto runs = measure_long_runs(shipped("two-springs"), setup());
  CHECK(runs[1].verdict == "grows");
  CHECK(runs[2].verdict == "damps");
  CHECK(runs[3].verdict == "damps");
  CHECK(runs[4].verdict == "conserves");
  CHECK(is_close(runs[1].measured, 1.52, 0.01));
  CHECK(is_close(runs[2].measured, 0.81, 0.01));
  CHECK(measure_long_runs(shipped("bouncing"), setup()).empty());
}

TEST_CASE("the text's claims are measured as expected, and each verdict says whether the claim holds") {
  const auto file = shipped("two-springs");
  const auto claims = measure_claims(file, measure_long_runs(file, setup()), setup());
  REQUIRE(claims.size() == 14);
  for (const auto& claim : claims) {
    CAPTURE(claim.where);
    CHECK(is_close(claim.measured, std::stod(claim.expected), 0.03));
  }
  CHECK(claims[0].verdict == "holds");
  CHECK(claims[3].verdict == "does not hold");
  CHECK(measure_claims(shipped("one-spring"), {}, setup()).empty());
}

TEST_CASE("theory: constraints leave at most second order, and limits have no theory") {
  using dvdx::Method;
  SceneFile file;
  file.particles.count = 2;
  file.scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  file.scene.add(dvdx::Distance{.pairs = {{0, 1}}, .length = 1.0});
  file.scene.add(dvdx::OnPoint{.particle = 0});
  CHECK(theory_of(file, Method::combined).order == 2.0);
  CHECK(theory_of(file, Method::exact).order == 2.0);
  CHECK(theory_of(file, Method::symplectic_euler).order == 1.0);
  file.scene.add(dvdx::Distance{.pairs = {{0, 1}}, .length = 1.0, .bound = dvdx::Bound::at_most});
  CHECK_FALSE(theory_of(file, Method::combined).order.has_value());
  CHECK(theory_of(file, Method::combined).note == "no theory: limits");
}

TEST_CASE("theory: two equal springs at rest are of third order, and of second where a constraint holds them") {
  SceneFile file;
  file.particles.count = 2;
  for (int k = 0; k < 2; ++k) file.scene.add(dvdx::Spring{.stiffness = 10.0});
  CHECK(theory_of(file, dvdx::Method::average_acceleration).order == 3.0);
  file.scene.add(dvdx::Distance{.pairs = {{0, 1}}, .length = 1.0});
  CHECK(theory_of(file, dvdx::Method::average_acceleration).order == 2.0);
}

TEST_CASE("theory: any drag among other forces leaves first order") {
  using dvdx::Method;
  SceneFile file;
  file.particles.count = 1;
  file.scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  CHECK(theory_of(file, Method::exact).note == "exact");
  CHECK(theory_of(file, Method::symplectic_euler).order == 1.0);
  file.scene.add(dvdx::Spring{.stiffness = 10.0});
  CHECK(theory_of(file, Method::exact).order == 2.0);
  CHECK(theory_of(file, Method::average_acceleration).order == 2.0);
  file.scene.add(dvdx::Drag{.coefficient = 0.1});
  CHECK(theory_of(file, Method::exact).order == 1.0);
  CHECK(theory_of(file, Method::average_acceleration).order == 1.0);
  CHECK(theory_of(file, Method::combined).note == "exact");
  std::get<dvdx::Drag>(file.scene.forces.back()).expansion = dvdx::Expansion::first_order;
  CHECK(theory_of(file, Method::combined).order == 1.0);
}

TEST_CASE("a ball that bounces is exact by method combined, and by no plain loop") {
  auto file = shipped("bouncing");
  file.duration = 10;
  const auto report = measured(file);
  CHECK(report.reference.kind == "closed_form");
  for (const auto& run : report.runs) {
    if (run.is_baseline) CHECK(run.errors.relative > 1e-4);
    if (run.method == "combined") CHECK(run.errors.relative < 1e-11);
  }
}

TEST_CASE("a reference without a closed form is stepped far finer than the runs shown") {
  auto file = shipped("one-spring");
  file.scene.forces = {dvdx::RadialSpring{.stiffness = 40.0, .rest_length = 0.5}};
  file.particles.velocity = dvdx::Vec3{0, 2, 0};
  const auto report = measured(file);
  CHECK(report.reference.kind == "extrapolated");
  CHECK(report.reference.settled);
  for (const auto& run : report.runs) {
    CHECK(run.step > 2 * report.reference.step);
    CHECK(run.errors.position_rms >= 100 * report.reference.self_error);
  }
}

TEST_CASE("a run that diverges stays in the list and is named") {
  auto file = shipped("two-springs");
  file.step = 0.5;
  file.duration = 512;  // Omega h = pi/2: above the stability limit of separate exact contributions
  Report whole{.machine = {}, .scenes = {measured(file)}};
  bool diverged = false;
  for (const auto& run : whole.scenes[0].runs) diverged = diverged || (run.method == "exact" && run.errors.diverged);
  CHECK(diverged);
  CHECK(to_text(whole).find("DIVERGED: exact in float64") != std::string::npos);
  CHECK(to_json(whole).dump().find(":nan") == std::string::npos);
}

TEST_CASE("a pair on one spring: every scheme at its own order, against the closed form") {
  Report whole{.machine = {}, .scenes = {measured(shipped("seed-pair"))}};
  const auto& report = whole.scenes[0];
  CHECK(report.reference.kind == "closed_form");
  CHECK(report.keeps_energy);
  const auto& fourth = order_named(report, "fourth_order");
  REQUIRE(fourth.fitted);
  CHECK(std::abs(*fourth.fitted - 4) < 0.1);
  const auto& leapfrog = order_named(report, "leapfrog");
  REQUIRE(leapfrog.fitted);
  CHECK(std::abs(*leapfrog.fitted - 2) < 0.1);
  for (const auto& run : report.runs) {
    CAPTURE(run.method);
    CHECK_FALSE(run.errors.diverged);
    if (run.method == "accumulate exact") CHECK(run.errors.relative < 1e-12);
    if (run.method == "sequential 0.5") CHECK(run.errors.energy_drift < 1e-12);
  }
  const auto runs = to_json(whole)["scenes"][0]["runs"];
  CHECK(runs[0]["scheme"] == "leapfrog");
  CHECK(runs[0]["method"] == "combined");
  CHECK(runs[0]["substeps"] == 1);
  const auto last = std::find_if(runs.rbegin(), runs.rend(), [](const auto& run) { return run["arithmetic"] == "separate"; });
  CHECK((*last)["scheme"] == "accumulate");
  CHECK((*last)["method"] == "exact");
  CHECK((*last)["axis"] == "start");
}

TEST_CASE("a network's own scheme is raced in every arithmetic, at its usual sub-steps") {
  const auto report = measured(shipped("seed-pair"));
  for (const std::string word : {"contracted", "fast"}) {
    CAPTURE(word);
    const auto race = std::find_if(report.runs.begin(), report.runs.end(), [&](const auto& r) { return r.arithmetic == word; });
    REQUIRE(race != report.runs.end());
    CHECK(race->method == "leapfrog, " + word);
    CHECK(race->timing.ns_per_particle_step > 0);
    const auto own = std::find_if(report.runs.begin(), report.runs.end(), [&](const auto& other) {
      return other.method == "leapfrog" && other.substeps == race->substeps;
    });
    REQUIRE(own != report.runs.end());
    CHECK(own->arithmetic == "separate");
    CHECK(is_close(race->errors.relative, own->errors.relative, 0.01));
  }
}

TEST_CASE("a network without a closed form is held against finer sub-steps, and schemes that cannot run are named") {
  auto file = shipped("net-stiff");
  file.duration = 0.5;
  file.scene.add(dvdx::Plane{.offset = -9});  // far below
  Report whole{.machine = {}, .scenes = {measured(file)}};
  const auto& report = whole.scenes[0];
  CHECK(report.reference.kind == "extrapolated");
  for (const auto& run : report.runs) CHECK(run.substeps < report.reference.substeps);
  // The sum of the pairs' contributions does not support contacts.
  CHECK(report.left_out.size() == 5);
  CHECK(to_text(whole).find("accumulate exact, start in float64: network.scheme is accumulate") != std::string::npos);
  CHECK(to_json(whole)["scenes"][0]["left_out"].size() == 5);
}

enum class Held { top, bottom };

// A sheet of 1 m x 1 m in a light wind. It hangs from its top edge, or stands on its bottom edge until it buckles.
SceneFile sheet(Held edge) {
  constexpr std::size_t side = 8;
  const double way = edge == Held::top ? -1 : 1;
  SceneFile file{.path = "sheet.json", .name = "sheet", .about = {}, .particles = {}, .scene = {}};
  file.step = 1.0 / 60;
  file.duration = 2;
  std::vector<dvdx::Vec3> places;
  for (std::size_t i = 0; i < side * side; ++i) {
    const auto at = [](std::size_t n) { return static_cast<double>(n) / (side - 1); };
    places.push_back({at(i % side), way * at(i / side), 0});
  }
  file.particles = {.count = side * side, .position = std::move(places)};
  file.scene.mass = 0.01;
  for (std::size_t i = 0; i < side; ++i) file.scene.fixed.push_back(i);
  file.scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  file.scene.add(dvdx::Drag{.coefficient = 0.001, .wind = {0.1, 0, 0.5}});
  file.scene.add(dvdx::Network(dvdx::Grid{
      .rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, way, 0}, .structural = 200, .shear = 100, .bend = 1}));
  return file;
}

TEST_CASE("growth of a difference: a hanging sheet has next to none, and a standing sheet that buckles has much") {
  const auto hanging = growth_of(sheet(Held::top), 60, setup());
  CHECK(hanging.is_whole);
  CHECK(hanging.horizon == 60);
  CHECK(hanging.at.back() < 100);
  const auto standing = growth_of(sheet(Held::bottom), 120, setup());
  CHECK_FALSE(standing.is_whole);
  CHECK(standing.horizon < 60);
  CHECK(standing.at.back() > most_growth);
  for (std::size_t k = 0; k < standing.at.size(); ++k) {
    if (standing.counts[k] <= standing.horizon) CHECK(standing.at[k] <= most_growth);
  }
  CHECK(growth_of(shipped("seed-pair"), 100, setup()).at.empty());  // has a closed form
}

TEST_CASE("a run's shape is compared with the shapes of the other runs alone") {
  std::vector<Statistics> all(3);
  all[0].shape = {0, 0, 0};
  all[1].shape = {0, 1, 0};
  all[2].shape = {0, 5, 0};
  const auto apart = shapes_apart(all);
  REQUIRE(apart.size() == 3);
  CHECK(is_close(apart[0], 3, 1e-12));
  CHECK(is_close(apart[1], 1.5, 1e-12));
  CHECK(is_close(apart[2], 4.5, 1e-12));
}

TEST_CASE("a chaotic sheet is ranked within its horizon, and compared by statistics beyond it") {
  const auto file = sheet(Held::bottom);
  const auto report = measured(file);
  const auto& horizon = report.reference.horizon;
  CHECK_FALSE(horizon.is_whole);
  CHECK(horizon.by_growth);
  CHECK(horizon.growth <= most_growth);
  CHECK(horizon.seconds < 1);
  CHECK(report.amplitude < report.whole_amplitude);
  const auto& order = order_named(report, "leapfrog");
  REQUIRE(order.fitted);
  CHECK(std::abs(*order.fitted - 2) < 0.2);
  REQUIRE(report.beyond.starts == 3);
  CHECK(report.beyond.apart > 1e-3);
  CHECK(report.beyond.apart < 2);
  bool is_any_unranked = false;
  for (const auto& run : report.runs) {
    CAPTURE(run.method);
    CAPTURE(run.substeps);
    if (run.errors.diverged) continue;
    CHECK(run.is_ranked == (run.errors.position_rms < report.beyond.apart / 3));
    CHECK(run.beyond.size() == report.beyond.statistics.size());
    is_any_unranked = is_any_unranked || !run.is_ranked;
    // a fine run that conserves energy is of the reference's kind
    if (run.method == "fourth_order") CHECK(run.beyond[0].agrees);
  }
  for (const auto& cheapest : cheapest_of(report)) {
    for (const auto* run : cheapest.runs) CHECK((run == nullptr || run->is_ranked));
  }
  const auto json = to_json(Report{.machine = {}, .scenes = {report}})["scenes"][0];
  CHECK(json["reference"]["horizon"]["ended_by"] == "growth");
  CHECK(json["reference"]["horizon"]["seconds"] == horizon.seconds);
  CHECK(json["beyond"]["statistics"].size() == 4);
  CHECK(json["runs"][0].contains("ranked"));
  CHECK(json["growth"]["times"].size() == json["growth"]["growth"].size());
  const auto text = to_text(Report{.machine = {}, .scenes = {report}});
  CHECK(text.find("horizon: ") != std::string::npos);
  CHECK(text.find("beyond the horizon, over time") != std::string::npos);
  CHECK((text.find("NOT RANKED") != std::string::npos) == is_any_unranked);
}

TEST_CASE("errors count up to the horizon, and divergence is looked for beyond it too") {
  SceneFile file{.path = {}, .name = {}, .about = {}, .particles = {.count = 1}, .scene = {}};
  Reference reference;
  reference.picks = {0};
  reference.path = Path(1, 4);
  reference.horizon = 2;
  reference.energy = {0, 0, 0, 0};
  reference.amplitude = 1;
  reference.whole_amplitude = 1;
  reference.energy_scale = 1;
  dvdx::Soa<double> memory(1);
  auto state = memory.view();
  const auto errors_with = [&](double last) {
    Comparison comparison(reference, file);
    for (const double x : {0.0, 0.25, 7.0, last}) {
      state.x[0][0] = x;
      comparison.take(state, comparison.energy().size());
    }
    return comparison.errors();
  };
  CHECK(errors_with(9).position_rms == 0.25);
  CHECK(errors_with(9).position_max == 0.25);
  CHECK_FALSE(errors_with(9).diverged);
  CHECK(errors_with(1000).diverged);
  CHECK(errors_with(std::nan("")).diverged);
}

TEST_CASE("a sampled particle has the position, mass and stiffness that it has among all") {
  const auto file = shipped("meadow");
  const auto sample = sample_of(file, 100);
  CHECK(sample.particles.count == 100);
  for (const std::size_t k : {0U, 7U, 99U}) {
    const auto i = k * file.particles.count / 100;
    CHECK(value_of(sample.particles.position, k) == value_of(file.particles.position, i));
    CHECK(sample.scene.mass[k] == file.scene.mass[i]);
    CHECK(std::get<dvdx::Spring>(sample.scene.forces[0]).stiffness.at(0, k) ==
          std::get<dvdx::Spring>(file.scene.forces[0]).stiffness.at(0, i));
  }
}

TEST_CASE("an enlarged scene repeats each of its own particles") {
  const auto file = sample_of(shipped("meadow"), 100);
  const auto larger = resized(file, 250);
  REQUIRE(larger.particles.count == 250);
  for (const std::size_t k : {0U, 2U, 3U, 249U}) {
    const auto i = k * 100 / 250;
    CHECK(value_of(larger.particles.position, k) == value_of(file.particles.position, i));
    CHECK(larger.scene.mass[k] == file.scene.mass[i]);
  }
}

TEST_CASE("throughput is measured over sizes, with one step and with 16 steps a call, and stands in the report") {
  const auto report = measured(shipped("two-springs"));
  REQUIRE(report.throughput.size() >= 4);
  CHECK(report.throughput.size() % 2 == 0);
  std::size_t particles = 16;
  for (std::size_t k = 0; k < report.throughput.size(); ++k) {
    const auto& one = report.throughput[k];
    if (k % 2 == 0) particles *= 16;
    CHECK(one.particles == particles);
    CHECK(one.state_bytes == 6 * sizeof(double) * particles);
    CHECK(one.steps_per_call == (k % 2 == 0 ? 1 : 16));
    CHECK(one.ns_per_particle_step > 0);
    CHECK(one.repeats >= 5);
  }
  const auto json = to_json(Report{.machine = {}, .scenes = {report}});
  CHECK(json["scenes"][0]["throughput"][1]["ns_per_particle_step"] == report.throughput[1].ns_per_particle_step);
  CHECK(measured(shipped("seed-pair")).throughput.empty());  // joined particles have one size only
}

TEST_CASE("data caches are read from the system's files, without instruction caches") {
  const dvdx::test::ScratchFolder folder("caches");
  const auto tell = [&](const std::string& index, const char* level, const char* type, const char* size,
                        const char* processors) {
    std::filesystem::create_directory(folder.path() / index);
    folder.write(index + "/level", level);
    folder.write(index + "/type", type);
    folder.write(index + "/size", size);
    folder.write(index + "/shared_cpu_list", processors);
  };
  tell("index0", "1", "Data\n", "48K\n", "0\n");
  tell("index1", "1", "Instruction\n", "32K\n", "0\n");
  tell("index2", "2", "Unified\n", "2M\n", "0,4\n");
  tell("index3", "3", "Unified\n", "36864K\n", "0-7,16-19\n");
  const auto caches = caches_in(folder.path());
  REQUIRE(caches.size() == 3);
  CHECK(caches[0].bytes == 49152);
  CHECK(caches[0].processors == 1);
  CHECK(caches[1].bytes == 2097152);
  CHECK(caches[1].processors == 2);
  CHECK(caches[2].level == 3);
  CHECK(caches[2].processors == 12);
  CHECK(caches_in(folder.path() / "none").empty());
}

}  // namespace report_test
