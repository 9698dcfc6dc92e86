// The tuner's choices: among candidates whose errors and costs are formulas, and on scenes with known results.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "dvdx/isa.hpp"
#include "report/machine.hpp"
#include "scene_io/scene_reader.hpp"
#include "scene_io/seeds.hpp"
#include "support/close.hpp"
#include "support/paths.hpp"
#include "tools/scratch_folder.hpp"
#include "tune/bench.hpp"
#include "tune/json.hpp"
#include "tune/search.hpp"
#include "tune/table.hpp"
#include "tune/tune_scene.hpp"

namespace tune_test {

using namespace dvdx::tool;
using namespace dvdx::tool::tune;
using dvdx::Method;
using dvdx::test::is_close;

// A ladder with the error `constant` / steps^order, but at least `floor`, and infinite below `stable` steps.
struct Law {
  Method method = Method::combined;  // distinguishes the ladders
  double constant = 1;
  double order = 2;
  double floor = 0;
  double seconds = 1;  // for a unit of work
  std::uint64_t stable = 1;
};

class FakeProbe final : public Probe {
 public:
  explicit FakeProbe(std::vector<Law> laws, int patience = 1000000) : laws_(std::move(laws)), patience_(patience) {}

  Outcome errors(const Candidate& candidate) override {
    ++measured;
    const auto& law = of(candidate);
    if (candidate.parts < law.stable) return {.errors = {.diverged = true}};
    const double relative = law.constant * std::pow(candidate.work(), -law.order) + law.floor;
    return {.errors = {.relative = relative}};
  }
  Cost rough_cost(const Candidate& candidate) override {
    ++timed;
    const double seconds = of(candidate).seconds * candidate.work();
    return {.ns_per_particle_step = of(candidate).seconds, .seconds_per_simulated_second = seconds};
  }
  std::vector<Cost> race(const std::vector<Candidate>& candidates) override {
    std::vector<Cost> costs;
    for (const auto& candidate : candidates) costs.push_back(rough_cost(candidate));
    return costs;
  }
  bool is_over() override { return measured >= patience_; }

  int measured = 0;
  int timed = 0;

 private:
  [[nodiscard]] const Law& of(const Candidate& candidate) const {
    for (const auto& law : laws_) {
      if (law.method == candidate.method) return law;
    }
    throw std::logic_error("no law for this method");
  }
  std::vector<Law> laws_;
  int patience_;
};

std::vector<Ladder> ladders_for(const std::vector<Law>& laws, std::uint64_t most = 1024) {
  std::vector<Ladder> ladders;
  for (const auto& law : laws) {
    Ladder ladder{.name = "ladder " + std::to_string(ladders.size()), .order = 2, .rungs = {}};
    for (std::uint64_t parts = 1; parts <= most; ++parts) {
      const bool is_rung = (parts & (parts - 1)) == 0 || (parts % 3 == 0 && ((parts / 3) & (parts / 3 - 1)) == 0);
      if (is_rung) ladder.rungs.push_back({.method = law.method, .parts = parts, .step = 1.0 / static_cast<double>(parts)});
    }
    ladders.push_back(std::move(ladder));
  }
  return ladders;
}

TEST_CASE("tune search: the search finds the exhaustive choice with less than half of the runs") {
  const std::vector<Law> laws{{.method = Method::combined, .constant = 1, .order = 2, .seconds = 1},
                              {.method = Method::exact, .constant = 40, .order = 4, .seconds = 3},
                              {.method = Method::pulse, .constant = 1, .order = 1, .seconds = 0.5},
                              {.method = Method::symplectic_euler, .constant = 5, .order = 1, .seconds = 1, .stable = 7}};
  for (const double goal : {0.5, 3e-2, 1e-3, 1e-5}) {
    CAPTURE(goal);
    const auto ladders = ladders_for(laws);
    FakeProbe all_probe(laws);
    const auto all = search(ladders, goal, Thoroughness::exhaustive, all_probe);
    FakeProbe probe(laws);
    const auto found = search(ladders, goal, Thoroughness::search, probe);
    REQUIRE(all.choice);
    REQUIRE(found.choice);
    const auto& choice = found.trials[*found.choice];
    CHECK(choice.outcome.errors.relative <= goal);
    CHECK(choice.candidate == all.trials[*all.choice].candidate);
    CHECK(probe.measured * 2 < all_probe.measured);
    CHECK(probe.timed < all_probe.timed);
  }
}

TEST_CASE("tune search: the next cheaper candidate misses the goal, and the next finer one has more parts") {
  const std::vector<Law> laws{{.method = Method::combined, .constant = 1, .order = 2, .seconds = 1}};
  FakeProbe probe(laws);
  const auto found = search(ladders_for(laws), 1e-2, Thoroughness::search, probe);
  REQUIRE(found.choice);
  CHECK(found.trials[*found.choice].candidate.parts == 12);  // 1/144; 8 gives 1/64
  REQUIRE(found.cheaper);
  CHECK(found.trials[*found.cheaper].candidate.parts == 8);
  CHECK(is_close(found.trials[*found.cheaper].outcome.errors.relative, 1.0 / 64, 1e-12));
  if (found.finer) CHECK(found.trials[*found.finer].candidate.parts > 12);
}

TEST_CASE("tune search: the most accurate of the candidates that tie in cost is chosen") {
  const std::vector<Law> laws{{.method = Method::exact, .constant = 1e-3, .seconds = 1},
                              {.method = Method::combined, .constant = 1e-9, .seconds = 1.02},
                              {.method = Method::pulse, .constant = 1e-12, .seconds = 1.2}};
  FakeProbe probe(laws);
  const auto found = search(ladders_for(laws), 1e-2, Thoroughness::search, probe);
  REQUIRE(found.choice);
  CHECK(found.trials[*found.choice].candidate.method == Method::combined);
  REQUIRE(found.finer);
  CHECK(found.trials[*found.finer].candidate.method == Method::pulse);
  CHECK(!found.cheaper);
}

TEST_CASE("tune search: no candidate is chosen if each one rounds too much for the goal or is unstable") {
  const std::vector<Law> laws{{.method = Method::combined, .constant = 1, .order = 2, .floor = 1e-4},
                              {.method = Method::exact, .stable = 100000}};
  FakeProbe probe(laws);
  const auto found = search(ladders_for(laws), 1e-5, Thoroughness::search, probe);
  CHECK(!found.choice);
  CHECK(!found.cheaper);
  const auto* best = most_accurate(found);
  REQUIRE(best != nullptr);
  CHECK(is_close(best->outcome.errors.relative, 1e-4, 0.05));
  CHECK(!found.is_cut());
}

TEST_CASE("tune search: ladders cut short by the time limit are named") {
  const std::vector<Law> laws{{.method = Method::combined}, {.method = Method::exact}, {.method = Method::pulse}};
  FakeProbe probe(laws, 3);
  const auto found = search(ladders_for(laws), 1e-4, Thoroughness::search, probe);
  std::vector<std::string> cut;
  for (const auto& [ladder, why] : found.not_run) {
    CHECK(why == NotRun::Why::time);
    cut.push_back(ladder);
  }
  CHECK(cut == std::vector<std::string>{"ladder 0", "ladder 1", "ladder 2"});  // the first one incompletely
}

TEST_CASE("tune search: a choice that fails elsewhere gives way to the next cheapest") {
  const std::vector<Law> laws{{.method = Method::combined, .constant = 1e-3, .seconds = 1},
                              {.method = Method::exact, .constant = 1e-3, .seconds = 1.3}};
  FakeProbe probe(laws);
  auto found = search(ladders_for(laws), 1e-2, Thoroughness::search, probe);
  CHECK(found.trials[*found.choice].candidate.method == Method::combined);
  choose(found, 1e-2, [](const Candidate& candidate) { return candidate.method != Method::combined; });
  REQUIRE(found.choice);
  CHECK(found.trials[*found.choice].candidate.method == Method::exact);
  choose(found, 1e-2, [](const Candidate&) { return false; });
  CHECK(!found.choice);
}

// ---- on scenes -----------------------------------------------------------------------------------------------------------

constexpr const char* breeze = R"({
  "format": "dvdx-scene/1", "name": "breeze", "step": 0.0625, "duration": 2,
  "particles": {"count": 6, "position": {"uniform": {"min": [0, 1, 0], "max": [1, 2, 1], "seed": 3}}},
  "forces": [{"type": "spring", "stiffness": 30, "anchor": [0, 0, 0]},
             {"type": "drag", "coefficient": 1e-9},
             {"type": "constant", "acceleration": [0, -9.81, 0], "method": "exact"}]
})";

constexpr const char* chain = R"({
  "format": "dvdx-scene/1", "name": "chain", "step": 0.0625, "duration": 1,
  "particles": {"count": 3, "position": {"values": [[0, 0, 0], [1.1, 0, 0], [2.1, 0.2, 0]]}},
  "network": [{"type": "springs", "pairs": [[0, 1], [1, 2]], "stiffness": 30, "rest_length": 1}]
})";

class Folder : public dvdx::test::ScratchFolder {
 public:
  explicit Folder(const std::string& name) : ScratchFolder("tune-" + name) {
    write("breeze.json", breeze);
    write("chain.json", chain);
  }
  [[nodiscard]] SceneOptions scene(std::string_view name) const {
    SceneOptions options;
    options.scene = *this / name;
    return options;
  }
};

dvdx::tool::report::Setup one_thread() { return {.engine = {.isa = dvdx::best_isa()}, .parallel = {}}; }

Tuning tuned(const SceneOptions& options, double goal) {
  return tune_scene(options, {.goal = goal, .seconds = 60}, one_thread(), [](double, const std::string&) {});
}

TEST_CASE("tune advice: a force that does next to nothing may be left out, and the spring must stay") {
  const Folder folder("advice");
  const auto file = read_scene(folder / "breeze.json");
  const auto setup = one_thread();
  const Judge judge(file, 1e-4, setup);
  const auto& grid = judge.grid();
  const Candidate choice{.precision = Precision::float64, .parts = 1, .step = grid.coarsest};
  REQUIRE(judge.errors(choice).errors.relative < 1e-12);
  const auto advice = advise(
      file.scene, choice, 1e-4, [&](const Judge::Change& change) { return judge.errors(choice, change); },
      [](const Judge::Change&) { return 1.0; });
  REQUIRE(advice.forces.size() == 3);
  CHECK(advice.forces[0].type == "spring");
  CHECK(advice.forces[0].advice == "combined");
  CHECK(advice.forces[1].advice == "leave_out");
  CHECK(advice.forces[1].changes[0].outcome.errors.relative < 1e-6);
  CHECK(advice.forces[1].changes[0].outcome.errors.relative > 1e-12);
  CHECK(advice.forces[2].advice == "combined");
  CHECK(advice.forces[2].changes[0].outcome.errors.relative > 0.1);
}

TEST_CASE("tune: the choice keeps the goal with other seeds too, and is float64 where float32 rounds too much") {
  const Folder folder("coarsest");
  const auto coarse = tuned(folder.scene("breeze.json"), 1e-3);
  REQUIRE(coarse.choice() != nullptr);
  CHECK(coarse.choice()->outcome.keeps(1e-3));
  CHECK(coarse.seeds == 1);
  REQUIRE(coarse.other_seed);
  CHECK(coarse.other_seed->outcome.keeps(1e-3));
  const auto fine = tuned(folder.scene("breeze.json"), 1e-10);
  REQUIRE(fine.choice() != nullptr);
  CHECK(fine.choice()->candidate.method == Method::combined);
  CHECK(fine.choice()->candidate.precision == Precision::float64);
  CHECK(tuned(folder.scene("breeze.json"), 1e-19).choice() == nullptr);
}

TEST_CASE("tune: the printed options load the chosen scene") {
  const Folder folder("words");
  for (const char* name : {"breeze.json", "chain.json"}) {
    CAPTURE(name);
    const auto options = folder.scene(name);
    const auto tuning = tuned(options, 2e-2);
    REQUIRE(tuning.choice() != nullptr);
    const auto& words = tuning.run_options;
    REQUIRE(words.size() % 2 == 1);
    CHECK(words[0] == options.scene);
    SceneOptions again;
    again.scene = words[0];
    for (std::size_t n = 1; n < words.size(); n += 2) {
      if (words[n] == "--step") again.step = std::stod(words[n + 1]);
      if (words[n] == "--method") again.method = words[n + 1];
      if (words[n] == "--scheme") again.scheme = words[n + 1];
      if (words[n] == "--substeps") again.substeps = words[n + 1];
      if (words[n] == "--set") again.overrides.push_back(words[n + 1]);
    }
    auto loaded = load_scene(again, Precision::float64).file;
    const auto& candidate = tuning.choice()->candidate;
    CHECK(loaded.step == candidate.step);
    const auto chosen = scene_of(load_scene(options, Precision::float64).file.scene, candidate);
    const bool pairs_have_methods = chosen.coupling.scheme == dvdx::Scheme::accumulate;
    if (!pairs_have_methods) loaded.scene.coupling.method = chosen.coupling.method;  // --method replaces an unread setting
    CHECK(loaded.scene.coupling == chosen.coupling);
    CHECK((loaded.scene == chosen || pairs_have_methods));  // there --set gives forces their own method, the same one
    CHECK(tuning.scene_lines.size() >= 2);
  }
}

TEST_CASE("tune --json has the contract's keys, and the text names the choice") {
  const Folder folder("json");
  const auto tuning = tuned(folder.scene("chain.json"), 1e-2);
  const auto json = to_json(dvdx::tool::report::this_machine(one_thread()), tuning);
  for (const char* key :
       {"machine", "scene", "error_goal", "choice", "cheaper", "finer", "forces", "candidates", "budget_cut"}) {
    CAPTURE(key);
    CHECK(json.contains(key));
  }
  for (const char* key : {"method", "scheme", "step", "substeps", "theta", "precision", "expansion", "error",
                          "ns_per_particle_step", "seconds_per_simulated_second"}) {
    CAPTURE(key);
    REQUIRE(json["choice"].contains(key));
  }
  CHECK(json["choice"]["error"]["relative"] <= 1e-2);
  CHECK(json["choice"]["scheme"].is_string());
  CHECK(json["networks"].size() == 1);
  CHECK(json["networks"][0]["advice"] == "keep");
  CHECK(json["other_seed"].is_null());
  CHECK(json["fast"]["cost_ratio"].get<double>() > 0);
  CHECK(json["fast"]["error"]["relative"].get<double>() <= 1e-2);  // of rounding or the step: bits are not compared
  CHECK(to_text(tuning).find("--arithmetic fast: error ") != std::string::npos);
  CHECK(json["budget_cut"] == false);
  CHECK(to_text(tuning).find("nothing in this scene is drawn from a seed") != std::string::npos);
}

TEST_CASE("tune's text counts the candidates that ran, were refused or were given up") {
  dvdx::tool::tune::Tuning tuning;
  tuning.amplitude = 1;
  tuning.goal = 1e-2;
  tuning.reference_seconds = 45;
  tuning.seconds = 50;
  tuning.budget = 30;
  CHECK(to_text(tuning).find("no candidate was run: the reference took 45 s of the 30 s of --budget\n") != std::string::npos);
  tuning.findings.trials.resize(3);
  tuning.findings.trials[0].outcome.refused = "more sub-steps";
  for (auto& trial : tuning.findings.trials) trial.outcome.errors.diverged = true;
  CHECK(to_text(tuning).find("2 candidates were run, and none stayed finite; 1 were refused, 0 given up for want of time\n") !=
        std::string::npos);
}

TEST_CASE("--seed draws other values, and equal seeds stay equal") {
  using nlohmann::json;
  const auto scene = json::parse(R"({"a": {"uniform": {"min": 0, "max": 1, "seed": 5}},
                                     "b": [{"uniform": {"min": 0, "max": 1, "seed": 5}}],
                                     "c": {"uniform": {"min": 0, "max": 1, "seed": 6}}, "seed": 7})");
  CHECK(count_seeds(scene) == 3);
  auto one = scene;
  reseed(one, 1);
  auto two = scene;
  reseed(two, 2);
  const auto seed = [](const json& uniform) { return uniform["uniform"]["seed"].get<std::uint64_t>(); };
  CHECK(seed(one["a"]) == seed(one["b"][0]));
  CHECK(seed(one["a"]) != seed(one["c"]));
  CHECK(seed(one["a"]) != seed(two["a"]));
  CHECK(seed(one["a"]) != 5);
  CHECK(one["seed"] == 7);
  const Folder folder("seed");
  const auto own = read_scene(folder / "breeze.json");
  const auto other = read_scene(folder / "breeze.json", {.overrides = {}, .seed = 1});
  CHECK(value_of(own.particles.position, 0) != value_of(other.particles.position, 0));
}

struct Result {
  int exit;
  std::string out;
};

Result command(const Folder& folder, const std::string& arguments) {
  const std::string line =
      "cd '" + folder.path().string() + "' && '" + dvdx::test::command() + "' " + arguments + " >out.txt 2>err.txt </dev/null";
  const int status = std::system(line.c_str());
  return {.exit = WEXITSTATUS(status), .out = folder.read("out.txt")};
}

TEST_CASE("tune as a command: exit codes") {
  const Folder folder("command");
  const auto done = command(folder, "tune breeze.json --error 1e-3 --json");
  CHECK(done.exit == 0);
  CHECK(nlohmann::json::parse(done.out)["scene"] == "breeze");
  CHECK(command(folder, "tune breeze.json --error 1e-19").exit == 1);
  CHECK(command(folder, "tune breeze.json").exit == 2);
  CHECK(command(folder, "tune breeze.json --error 0").exit == 2);
  CHECK(command(folder, "tune breeze.json --error 1e-3 --set step=no").exit == 3);
  CHECK(command(folder, "tune nowhere.json --error 1e-3").exit == 4);
  CHECK(command(folder, "tune --help").out.rfind("Example:", 0) == 0);
}

}  // namespace tune_test
