// dvdx explain: what a scene needs, before it runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "commands/commands.hpp"
#include "commands/options.hpp"
#include "commands/run_outcome.hpp"
#include "commands/typed.hpp"
#include "dvdx/plan.hpp"
#include "files/part_file.hpp"
#include "files/part_name.hpp"
#include "output/console.hpp"
#include "scale/births.hpp"
#include "scale/prediction.hpp"
#include "scene_io/names.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/live_memory.hpp"
#include "state/refusal.hpp"
#include "state/start.hpp"
#include "watch/warnings.hpp"

namespace dvdx::tool {
namespace {

struct ExplainOptions {
  SceneOptions scene;
  EngineOptions engine;
  std::optional<std::uint64_t> ranks{};
  std::string size{};     // for which ranks are counted, in place of the scene's
  std::string picture{};  // of the efficiency over ranks
  Machine machine{};
};

constexpr std::uint64_t most_ranks = 131072;

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
  for (const MeshNetwork& mesh : file.meshes) print_answer(fmt::format("mesh         {}\n", text_of(mesh)));
  print_answer(fmt::format("duration     {} s in {} steps\n", file.duration, loaded.steps));
  print_answer(fmt::format("method       {}\n", word(file.scene.method)));
  for (std::size_t n = 0; n < file.tears_at.size(); ++n) {
    if (!std::isfinite(file.tears_at[n])) continue;
    print_answer(
        fmt::format("tearing      springs of networks[{}] that are longer than {:g} times their rest length at a step's end\n",
                    n, file.tears_at[n]));
  }
}

template <class T>
std::string explained(SceneFile& file, const Engine& engine) {
  if (is_live(file)) {
    const auto plan = live_plan<T>(file, {.step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic});
    return plan.plan().explain() + plan.explain();
  }
  StateMemory<T> memory(engine.layout, file.particles.count);
  auto state = memory.view();
  place_at_start(file, state);
  const auto plan = compile<T>(file.scene, {.step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic}, state);
  if (!plan) throw fault_of(file, plan.error());
  file.scene.coupling.scheme = plan->scene().coupling.scheme;  // the scheme that `auto` chose
  return plan->explain();
}

// Measures the time in s of a particle's sub-step on one thread: the least of at least 3 calls, for a quarter of a second.
template <class T>
double measured(const SceneFile& file, const Engine& engine) {
  StateMemory<T> memory(engine.layout, file.particles.count, rounding_of(engine.precision));
  auto state = memory.view();
  place_at_start(file, state);
  const auto plan = compile<T>(
      file.scene,
      {.step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic, .rounding = rounding_of(engine.precision)},
      state);
  if (!plan) throw fault_of(file, plan.error());
  const auto limit = plan->network_limit();
  const double substeps = static_cast<double>(state.count) * (limit ? limit->substeps : 1);
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point time) { return std::chrono::duration<double>(Clock::now() - time).count(); };
  const auto start = Clock::now();
  double least = std::numeric_limits<double>::infinity();
  for (int calls = 0; calls < 3 || seconds_since(start) < 0.25; ++calls) {
    const auto before = Clock::now();
    if (plan->step(state, 1) != StepResult::done) throw std::logic_error("the plan is for another state");
    least = std::min(least, seconds_since(before) / substeps);
  }
  return least;
}

void explain_births(const ExplainOptions& options, const SceneFile& file) {
  for (const auto& [option, value] : {std::pair("--size", options.size), std::pair("--picture", options.picture)}) {
    if (!value.empty()) throw Fault(Exit::usage, fmt::format("{} {}: not where particles come and go", option, value));
  }
  check_can_be_split(file, {});
  print_answer(table_of_births(file, *options.ranks, options.machine));
}

void explain_ranks(const ExplainOptions& options, const SceneFile& file, const Engine& engine) {
  if (is_live(file)) return explain_births(options, file);
  if (!file.scene.constraints.empty())
    throw Fault(Exit::bad_scene, file.path + ": particles that constraints join cannot be split over ranks");
  const Extent extent = extent_of(file, options.size);
  const auto sent = halo_of(file, bytes_of(engine.precision));
  const auto cuts = cuts_of(extent, *options.ranks);
  if (cuts.empty())
    throw Fault(Exit::usage,
                fmt::format("--ranks {}: no way to share {} particles among so many", *options.ranks, extent.particles));
  Machine machine = options.machine;
  const bool is_measured = !machine.particle_seconds;
  if (is_measured) {
    machine.particle_seconds =
        is_kept_in_float64(engine.precision) ? measured<double>(file, engine) : measured<float>(file, engine);
  }
  print_answer(table_of(cuts, sent, machine, cuts_of(extent, 1).front()));
  const auto curve = curve_of(extent, sent, machine, most_ranks);
  print_answer(table_of(curve));
  print_answer(fmt::format("\nby a latency of {:.3g} s, a bandwidth of {:.3g} bytes/s and {:.3g} s a particle's sub-step{}\n",
                           machine.latency, machine.bandwidth, *machine.particle_seconds,
                           is_measured ? ", measured here on one thread" : ""));
  if (options.picture.empty()) return;
  remove_stale_parts(std::filesystem::path(options.picture).parent_path());
  PartFile picture(options.picture);
  picture.write(picture_of(curve, fmt::format("{}, {:.3g} particles", file.name, static_cast<double>(extent.particles))));
  picture.commit();
}

void explain(const ExplainOptions& options) {
  const auto engine = engine_of(options.engine);
  auto loaded = load_scene(options.scene, engine.precision);
  const auto text =
      engine.precision == Precision::float32 ? explained<float>(loaded.file, engine) : explained<double>(loaded.file, engine);
  print_summary(loaded);
  print_answer(text);
  print_warnings(options.scene.scene, loaded.file.warnings);
  if (options.ranks) explain_ranks(options, loaded.file, engine);
}

}  // namespace

void add_explain(CLI::App& app, Exit& /*exit*/) {
  auto options = std::make_shared<ExplainOptions>();
  auto* command = app.add_subcommand("explain", "Tell what a scene needs: passes, cost, stability");
  command->footer("dvdx explain two-springs.json --method average_acceleration");
  add_scene_options(*command, options->scene);
  add_engine_options(*command, options->engine);
  auto* const ranks =
      command
          ->add_option("--ranks", options->ranks,
                       "also what so many ranks would have and tell each other, and the time that it would take")
          ->check(whole_number(1, most_ranks));
  command->add_option("--latency", options->machine.latency, "s: of a message between ranks, 1.5e-6 where not given")
      ->check(number_from_zero())
      ->needs(ranks);
  command->add_option("--bandwidth", options->machine.bandwidth, "bytes/s: of a rank's link, 12.5e9 where not given")
      ->check(number_above_zero())
      ->needs(ranks);
  command
      ->add_option("--particle-time", options->machine.particle_seconds,
                   "s: of a particle's sub-step on a rank; measured here where not given")
      ->check(number_above_zero())
      ->needs(ranks);
  command
      ->add_option("--size", options->size,
                   "count ranks for so many particles (1e10), or a sheet of so many rows and columns (32768x32768), in the "
                   "scene's place")
      ->needs(ranks);
  command->add_option("--picture", options->picture, "draw the predicted efficiency over ranks to an .svg")->needs(ranks);
  command->callback([options] { explain(*options); });
}

}  // namespace dvdx::tool
