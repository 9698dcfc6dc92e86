// dvdx tune: the cheapest way to run a scene within an error.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "closed_form/balls.hpp"
#include "commands/commands.hpp"
#include "commands/options.hpp"
#include "commands/scenes_progress.hpp"
#include "commands/typed.hpp"
#include "output/console.hpp"
#include "report/machine.hpp"
#include "scene_io/network_reader.hpp"
#include "scene_io/turnover_reader.hpp"
#include "state/threads.hpp"
#include "tune/json.hpp"
#include "tune/table.hpp"
#include "tune/tune_scene.hpp"

namespace dvdx::tool {
namespace {

struct TuneOptions {
  std::vector<std::string> scenes;
  SceneOptions scene;  // values that are replaced in every scene
  EngineOptions engine;
  tune::SearchOptions wish;
  bool exhaustive = false;
  bool json = false;
};

void print(const TuneOptions& options, const report::Machine& machine, const std::vector<tune::Tuning>& tunings) {
  if (!options.json) {
    for (const auto& tuning : tunings) print_answer((&tuning == tunings.data() ? "" : "\n") + tune::to_text(tuning));
    return;
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& tuning : tunings) list.push_back(tune::to_json(machine, tuning));
  print_json((tunings.size() == 1 ? list.front() : list).dump(1) + "\n");
}

Exit run(TuneOptions options) {
  options.engine.precision = "float64";  // of the reference
  const Engine engine = engine_of(options.engine);
  const Threads threads(engine.threads);
  const report::Setup setup{.engine = engine, .parallel = threads.parallel_for()};
  if (options.exhaustive) options.wish.thoroughness = tune::Thoroughness::exhaustive;
  std::vector<SceneOptions> scenes;
  for (const auto& path : options.scenes) {
    scenes.push_back(options.scene);
    scenes.back().scene = path;
    const auto loaded = load_scene(scenes.back(), Precision::float64);  // reads all before any work is done
    refuse_turnover(loaded.file, "tune");
    refuse_tearing(loaded.file, "tune");
    refuse_meet(loaded.file, "tune");
  }
  std::vector<tune::Tuning> tunings;
  {
    ScenesProgress told(scenes.size());
    for (std::size_t n = 0; n < scenes.size(); ++n) {
      told.scene(n, scenes[n].scene);
      const auto tell = [&](double part, const std::string& what) { told.at(part, what); };
      tunings.push_back(tune::tune_scene(scenes[n], options.wish, setup, tell));
    }
  }
  print(options, report::this_machine(setup), tunings);
  const bool all_reached =
      std::all_of(tunings.begin(), tunings.end(), [](const tune::Tuning& tuning) { return tuning.choice() != nullptr; });
  return all_reached ? Exit::done : Exit::verification_failed;
}

}  // namespace

void add_tune(CLI::App& app, Exit& exit) {
  auto options = std::make_shared<TuneOptions>();
  auto* command = app.add_subcommand("tune", "Find the cheapest method, scheme, step, sub-steps and precision within an error");
  command->footer("dvdx tune meadow.json --error 1e-3");
  command->add_option("SCENE", options->scenes, "scene files (JSON)")->required();
  command->add_option("--error", options->wish.goal, "at most, of positions over the amplitude, as a report's `relative`")
      ->required()
      ->check(number_above_zero());
  command->add_option("--budget", options->wish.seconds, "s a scene: a longer search is cut, and says so")
      ->check(number_above_zero())
      ->capture_default_str();
  command->add_flag("--exhaustive", options->exhaustive, "measure every candidate too, and say how far the choice is off");
  add_scene_replacements(*command, options->scene);
  add_machine_options(*command, options->engine);
  command->add_flag("--json", options->json, "print one JSON object (a list of them for several scenes)");
  command->callback([options, &exit] { exit = run(*options); });
}

}  // namespace dvdx::tool
