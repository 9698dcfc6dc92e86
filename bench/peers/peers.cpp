// Hanging cloth by dvdx, by other libraries and by plain loops: time per simulated second against error, with the same scene,
// stiffness and start for all.
//   dvdx_peers [--size 32] [--scenes H,C] [--stiffness 1e2,1e4,1e6] [--only TEXT] [--json FILE] [--all] [--quick]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>

#include "peers/peer.hpp"
#include "peers/results.hpp"
#include "support/machine.hpp"

namespace dvdx::bench {
namespace {

constexpr double duration = 0.5;  // simulated s: scene H becomes chaotic soon after

struct Options {
  std::size_t size = 32;
  std::vector<std::string> scenes = {"H", "C"};
  std::vector<double> stiffness = {1e2, 1e4, 1e6};
  std::string only, json;
  bool is_full = false, is_quick = false;

  [[nodiscard]] int repeats() const { return is_quick ? 1 : 3; }
  // A ladder also ends at this goal: the one that shows that a method is right, or the last one that is timed.
  [[nodiscard]] const Goal& enough() const { return is_quick ? goals.front() : goals.back(); }
  [[nodiscard]] double longest() const { return is_quick ? 0.5 : 5; }  // s: a longer run ends the ladder
};

Peers all_peers() {
  Peers all;
  for (const auto peers : {
           dvdx_peers,
           plain_leapfrog_arrays_peers,
           plain_leapfrog_peers,
           plain_xpbd_peers,
#ifdef DVDX_PEERS_BULLET
           bullet_peers,
#endif
#ifdef DVDX_PEERS_ODEINT
           odeint_peers,
#endif
#ifdef DVDX_PEERS_SUNDIALS
           sundials_peers,
#endif
       }) {
    for (Peer& peer : peers()) all.push_back(std::move(peer));
  }
  return all;
}

// The shortest of several runs, or the only one if it takes long.
tl::expected<Outcome, std::string> timed(const Peer& peer, const Cloth& cloth, int knob, int repeats) {
  auto outcome = peer.run(cloth, knob, duration);
  for (int i = 1; outcome && i < repeats && outcome->seconds < 1; ++i) {
    if (const auto again = peer.run(cloth, knob, duration)) outcome->seconds = std::min(outcome->seconds, again->seconds);
  }
  return outcome;
}

Method race(const Peer& peer, const Cloth& cloth, const Reference& reference, const Options& options) {
  Method method{peer.name, peer.knob, {}, {}};
  for (const int knob : peer.ladder(cloth)) {
    const auto outcome = timed(peer, cloth, knob, options.repeats());
    if (!outcome) {
      method.refusal = outcome.error();
      continue;
    }
    const Run run{outcome->knob.empty() ? std::to_string(knob) : outcome->knob, 1e3 * outcome->seconds / duration,
                  deviation_of(cloth, outcome->motion, reference)};
    method.runs.push_back(run);
    const bool is_met = run.deviation.position <= options.enough().position;
    if (outcome->seconds > options.longest() || (is_met && !options.is_full && knob != 0)) break;
  }
  if (!method.runs.empty()) method.refusal.clear();
  return method;
}

SceneResult race_all(const Cloth& cloth, const Options& options) {
  SceneResult result{cloth.scene, cloth.stiffness, cloth.size, cloth.edges.size(), cloth.limit(), {}, {}};
  result.reference = reference_of(cloth, duration, options.is_quick ? 1e-5 : 1e-6);
  for (const Peer& peer : all_peers()) {
    if (peer.name.find(options.only) == std::string::npos) continue;
    fmt::print(stderr, "{}, k = {:.0e}: {}\n", cloth.scene, cloth.stiffness, peer.name);
    result.methods.push_back(race(peer, cloth, result.reference, options));
  }
  return result;
}

// Returns true if each dvdx method came within the loosest goal of the reference.
bool is_right(const SceneResult& result) {
  bool all = true;
  for (const Method& method : result.methods) {
    if (method.name.rfind("dvdx", 0) != 0 || cheapest(method, goals.front()) != nullptr) continue;
    fmt::print(stderr, "{}, k = {:.0e}: {} is nowhere near the reference\n", result.scene, result.stiffness, method.name);
    all = false;
  }
  return all;
}

int run(Options options) {
  const double load = this_machine().load;
  if (options.is_quick) options.size = std::min<std::size_t>(options.size, 12);
  std::vector<SceneResult> results;
  for (const std::string& scene : options.scenes) {
    for (const double stiffness : options.stiffness) {
      results.push_back(race_all(make_cloth(scene.front(), options.size, stiffness), options));
      print_table(results.back());
      std::fflush(stdout);
      if (!options.json.empty()) write_json(options.json, results, load);  // keeps the results so far if the rest is cut short
    }
  }
  if (options.is_full) {
    for (const SceneResult& result : results) print_runs(result);
  }
  print_machine(load);
  return std::all_of(results.begin(), results.end(), is_right) ? 0 : 1;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Hanging cloth side by side: time per simulated second against error.", "dvdx_peers");
  app.add_option("--size", options.size, "nodes along a side")->check(CLI::Range(3, 1024));
  app.add_option("--scenes", options.scenes, "H, C")->delimiter(',')->check(CLI::IsMember({"H", "C"}));
  app.add_option("--stiffness", options.stiffness, "N/m of every spring")->delimiter(',')->check(CLI::PositiveNumber);
  app.add_option("--only", options.only, "methods whose name holds this text");
  app.add_option("--json", options.json, "write every run to this file");
  app.add_flag("--all", options.is_full, "run whole ladders and print every run");
  app.add_flag("--quick", options.is_quick,
               "at most 12 nodes a side, each run once, to the first goal, and none that takes long");
  CLI11_PARSE(app, argc, argv);
  return run(std::move(options));
}

}  // namespace
}  // namespace dvdx::bench

int main(int argc, char** argv) {
  try {
    return dvdx::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dvdx_peers: %s\n", error.what());
    return 1;
  }
}
