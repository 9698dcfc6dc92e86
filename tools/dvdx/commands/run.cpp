// dvdx run: a scene from its start to its end.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "checkpoint/checkpoints.hpp"
#include "commands/commands.hpp"
#include "commands/options.hpp"
#include "commands/run_outcome.hpp"
#include "commands/run_reference.hpp"
#include "commands/typed.hpp"
#include "dvdx/build_info.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "files/part_file.hpp"
#include "output/console.hpp"
#include "output/frames.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "ranks/join.hpp"
#include "run/live_simulation.hpp"
#include "run/simulation.hpp"
#include "scene_io/fingerprint.hpp"
#include "scene_io/names.hpp"
#include "state/engine.hpp"
#include "state/refusal.hpp"
#include "watch/contact_watch.hpp"
#include "watch/outcome.hpp"
#include "watch/warnings.hpp"

namespace dvdx::tool {
namespace {

struct RunOptions {
  SceneOptions scene;
  EngineOptions engine;
  std::string out;
  std::string events;
  std::optional<std::uint64_t> every{};  // 0: the last state alone; if neither is given, the kind of file decides
  std::optional<double> fps{};           // 1/s
  bool error = false;                    // colours a page by the error
  bool json = false;
  bool strict = false;
  CheckpointOptions checkpoint;
};

std::size_t most_particles(const SceneFile& file) { return std::max(file.particles.total(), file.turnover.capacity); }

// Animations have 30 states a second, but a page no more states than it plays well.
Frames frames_of(const RunOptions& options, const LoadedScene& loaded) {
  if (options.every) return {.apart = static_cast<double>(*options.every)};
  if (options.fps) return frames_a_second(*options.fps, loaded.file.step);
  if (!is_animation(options.out)) return {};
  const Frames frames = frames_a_second(30, loaded.file.step);
  if (!is_page(options.out)) return frames;
  constexpr std::uint64_t particle_states = 15'000'000;
  const auto most = std::clamp<std::uint64_t>(particle_states / most_particles(loaded.file), 300, 3600);
  return {.apart = std::max(frames.apart, std::ceil(static_cast<double>(loaded.steps) / static_cast<double>(most)))};
}

// A run's bits depend on all of these. They do not depend on threads or layout, and on the instruction set only if arithmetic
// is fast.
RunIdentity identity_of(const RunOptions& options, const LoadedScene& loaded, const Engine& engine) {
  if (options.checkpoint.file.empty() && options.checkpoint.resume.empty()) return {};
  const auto& scene = options.scene;
  RunIdentity run{.version = std::string(build_info().version),
                  .precision = std::string(name_in(precisions, engine.precision)),
                  .arithmetic = std::string(name(engine.arithmetic)),
                  .scene = hash_text(fingerprint_of(loaded.file, {.overrides = scene.overrides, .seed = scene.seed}))};
  if (engine.arithmetic == Arithmetic::fast) run.arithmetic += " on " + std::string(name(engine.isa));
  for (const auto& [option, value] :
       {std::pair("method", scene.method), std::pair("scheme", scene.scheme), std::pair("substeps", scene.substeps)}) {
    if (!value.empty()) run.scene += fmt::format(" {} {}", option, value);
  }
  return run;
}

template <class T, class Simulated>
Outcome run_all(const RunOptions& options, LoadedScene& loaded, const Engine& engine, Ranks& ranks) {
  auto simulation = [&] {
    if constexpr (std::is_same_v<Simulated, LiveSimulation<T>>) {
      return Simulated(loaded, engine, ranks);
    } else {
      return Simulated(loaded, engine, ranks, options.error ? Starts::kept : Starts::given_back);
    }
  }();
  const Frames frames = frames_of(options, loaded);
  std::optional<Output> output;
  if (!options.out.empty()) {
    output = {.target = options.out,
              .particles = most_particles(loaded.file),
              .states = frames.states(loaded.steps),
              .topology = &loaded.file.topology,
              .counts = is_live(loaded.file) ? Counts::changing : Counts::fixed,
              .numbering = &loaded.file.numbering,
              .scene = &loaded.file,
              .ranks = ranks.count() > 1 ? &ranks : nullptr,
              .first = shown_by(loaded.file, ranks).first};
  }
  Checkpoints checkpoints(options.checkpoint, together(ranks, [&] { return identity_of(options, loaded, engine); }),
                          loaded.file.name,
                          engine.precision == Precision::float32_compensated ? CallsEnd::where_they_do : CallsEnd::anywhere,
                          loaded.file.sources, ranks);
  if constexpr (std::is_same_v<Simulated, LiveSimulation<T>>) {
    if (output && (is_page(options.out) || checkpoints.is_writing())) output->ids = simulation.ids();
  }
  if constexpr (std::is_same_v<Simulated, Simulation<T>>) {
    if (output && !loaded.file.tears_at.empty()) output->tears = &simulation.tears();
    if (output && is_in_pieces(options.out)) output->owner = simulation.owner();
  }
  if (options.error && ranks.rank() == 0) {
    const auto reference = reference_of(loaded, engine);
    output->reference = reference.positions;
    output->reference_text = reference.text;
  }
  Observer<T> observer(loaded, engine, output, frames, checkpoints, ranks);
  const bool counts = options.json || checkpoints.is_writing();
  ContactWatch contacts(loaded.file, counts ? Sums::counted : Sums::left_out, options.events, checkpoints, ranks);
  auto outcome = simulation.run(observer, frames, contacts, checkpoints);
  if (output) outcome.written = files_of(*output);
  if (!options.events.empty()) outcome.written.push_back({.file = options.events});
  return outcome;
}

template <class T>
Outcome simulate(const RunOptions& options, LoadedScene& loaded, const Engine& engine, Ranks& ranks) {
  return is_live(loaded.file) ? run_all<T, LiveSimulation<T>>(options, loaded, engine, ranks)
                              : run_all<T, Simulation<T>>(options, loaded, engine, ranks);
}

// Files that are written must differ from each other and from those resumed from. Only a checkpoint may replace the one before.
void check_files_differ(const RunOptions& options) {
  const auto refuse_same = [](const char* option, const std::string& file, const char* other, const std::string& of_other) {
    if (file.empty() || of_other.empty() || !is_same_file(file, of_other)) return;
    throw Fault(Exit::usage, fmt::format("{} {}: must be another file than that of {}", option, file, other));
  };
  const auto& [checkpoint, every, resume] = options.checkpoint;
  refuse_same("--events", options.events, "--out", options.out);
  for (const auto& [option, file] : {std::pair("--out", options.out), std::pair("--events", options.events)}) {
    refuse_same(option, file, "--checkpoint", checkpoint);
    refuse_same(option, file, "--resume", resume);
  }
}

Exit run_on(const RunOptions& options, Ranks& ranks, bool by_launcher) {
  const auto engine = together(ranks, [&] {
    if (!options.out.empty()) check_extension(options.out);
    check_files_differ(options);
    if (options.error && !is_page(options.out)) throw Fault(Exit::usage, "--error: goes with --out of an .html");
    return engine_of(options.engine, by_launcher ? ranks_here() : 1);
  });
  const ReadTopology topology = options.out.empty() ? ReadTopology::no : ReadTopology::yes;
  auto loaded = load_scene(options.scene, engine.precision, ranks, topology);
  together(ranks, [&] {
    if (options.error && is_live(loaded.file)) {
      throw Fault(Exit::usage, "--error: there is no reference for particles that come and go");
    }
    if (options.error && !loaded.file.tears_at.empty()) {
      throw Fault(Exit::usage, "--error: there is no reference for springs that tear");
    }
    if (ranks.count() > 1) check_can_be_split(loaded.file, options.out);
  });
  auto outcome = is_kept_in_float64(engine.precision) ? simulate<double>(options, loaded, engine, ranks)
                                                      : simulate<float>(options, loaded, engine, ranks);
  name_particles(loaded.file.numbering, outcome);
  const auto warnings = warnings_of(loaded, outcome);
  const Exit calm = options.strict && !warnings.empty() ? Exit::warned : Exit::done;
  const Exit exit = outcome.diverged ? Exit::diverged : calm;
  if (ranks.rank() > 0) return exit;
  const auto shown = by_launcher ? std::optional(ranks.count()) : std::nullopt;
  if (options.json) {
    print_outcome_json(loaded, engine, outcome, warnings, shown);
  } else {
    print_table(loaded, engine, outcome, shown);
  }
  print_warnings(options.scene.scene, warnings);
  if (!outcome.diverged) return exit;
  const auto particles = particles_of(loaded, outcome);
  print_message(fmt::format("{}: the simulation diverged: {}", options.scene.scene, why_diverged(outcome, particles)));
  return exit;
}

// A fault of one rank alone ends the others too, which would otherwise wait for it.
Exit run(const RunOptions& options) {
  const auto [ranks, by_launcher] = join_ranks();
  if (ranks->count() == 1) return run_on(options, *ranks, by_launcher);
  try {
    return run_on(options, *ranks, by_launcher);
  } catch (const SharedFault& fault) {
    if (ranks->rank() == 0) print_message(fault.what());
    wait_for_all(*ranks);
    throw SharedFault(fault.exit(), std::string());
  } catch (...) {
    const auto trouble = trouble_of([] { throw; });
    print_message(trouble->message);
    ranks->end_all(static_cast<int>(trouble->exit));
    return trouble->exit;  // g++ 12 does not see that a virtual function may not return
  }
}

}  // namespace

void add_run(CLI::App& app, Exit& exit) {
  auto options = std::make_shared<RunOptions>();
  auto* command = app.add_subcommand("run", "Run a scene");
  command->footer("dvdx run hail.json --duration 5 --out hail.vtp --every 6");
  add_scene_options(*command, options->scene);
  add_engine_options(*command, options->engine);
  command->add_option("--out", options->out, fmt::format("write states to a file: {}", written_extensions()));
  auto* const every = command->add_option("--every", options->every,
                                          "write step 0, every N-th step and the last; 0: the last alone, as .csv, .ply, .obj "
                                          "and .png have it where neither is given");
  auto* const fps = command->add_option("--fps", options->fps,
                                        "write so many states a second of simulated time, at the nearest steps: 30 where "
                                        "neither is given and the file is an animation");
  every->check(whole_number(0))->excludes(fps);
  fps->check(number_above_zero());
  command->add_flag(
      "--error", options->error,
      "with --out of an .html: hold each state against the closed form, or against steps of an eighth in float64");
  command->add_option("--events", options->events, "write each impact on a contact to a .csv file");
  auto* const checkpoint = command->add_option("--checkpoint", options->checkpoint.file,
                                               "a file from which --resume goes on, should the run be stopped");
  auto* const often =
      command->add_option("--checkpoint-every", options->checkpoint.every, "write it every N steps")->check(whole_number(1));
  checkpoint->needs(often);
  often->needs(checkpoint);
  command->add_option("--resume", options->checkpoint.resume,
                      "go on from a checkpoint: with the same scene and options the same bits and files come out");
  command->add_flag("--json", options->json, "print one JSON object");
  command->add_flag("--strict", options->strict, "end with exit code 6 where there is any warning");
  command->callback([options, &exit] { exit = run(*options); });
}

}  // namespace dvdx::tool
