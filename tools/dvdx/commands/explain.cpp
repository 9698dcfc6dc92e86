// dvdx explain: what a scene needs, before it runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "commands/commands.hpp"
#include "commands/scene_options.hpp"
#include "dvdx/plan.hpp"
#include "output/console.hpp"
#include "run/live_memory.hpp"
#include "run/start.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

struct ExplainOptions {
  SceneOptions scene;
  EngineOptions engine;
};

void print_summary(const LoadedScene& loaded) {
  const auto& file = loaded.file;
  print_answer(fmt::format("scene        {}\n", printable(file.name)));
  if (!file.about.empty()) print_answer(fmt::format("             {}\n", printable(file.about)));
  if (is_live(file)) {
    print_answer(fmt::format("particles    {} at the start, at most {}\n", file.particles.count, file.turnover.capacity));
  } else {
    std::size_t kinematic = 0;
    for (const Kinematic& followers : file.scene.kinematic) kinematic += followers.particles.size();
    const std::string carried = kinematic != 0 ? fmt::format(", {} carried by motions", kinematic) : "";
    print_answer(fmt::format("particles    {}, {} of them fixed{}\n", file.particles.count, file.scene.fixed.size(), carried));
  }
  print_answer(fmt::format("duration     {} s in {} steps\n", file.duration, loaded.steps));
  print_answer(fmt::format("method       {}\n", name_in(methods, file.scene.method)));
}

template <class T>
std::string explained(const SceneFile& file, const Engine& engine) {
  if (is_live(file)) {
    const auto plan = live_plan<T>(file, {.step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic});
    return plan.plan().explain() + plan.explain();
  }
  StateMemory<T> memory(engine.layout, file.particles.count);
  auto state = memory.view();
  place_at_start(file, state);
  const auto plan = compile<T>(file.scene, {.step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic}, state);
  if (!plan) throw Fault(Exit::bad_scene, file.path + ": " + plan.error().message());
  return plan->explain();
}

void explain(const ExplainOptions& options) {
  const auto engine = engine_of(options.engine);
  const auto loaded = load_scene(options.scene, engine.precision);
  const auto text =
      engine.precision == Precision::float32 ? explained<float>(loaded.file, engine) : explained<double>(loaded.file, engine);
  print_summary(loaded);
  print_answer(text);
}

}  // namespace

void add_explain(CLI::App& app, Exit& /*exit*/) {
  auto options = std::make_shared<ExplainOptions>();
  auto* command = app.add_subcommand("explain", "Tell what a scene needs: passes, cost, stability");
  command->footer("dvdx explain two-springs.json --method average_acceleration");
  add_scene_options(*command, options->scene);
  add_engine_options(*command, options->engine);
  command->callback([options] { explain(*options); });
}

}  // namespace dvdx::tool
