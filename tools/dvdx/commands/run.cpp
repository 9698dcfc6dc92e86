// dvdx run: a scene from its start to its end.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>

#include "checkpoint/checkpoints.hpp"
#include "checkpoint/states_out.hpp"
#include "commands/commands.hpp"
#include "commands/progress.hpp"
#include "commands/run_reference.hpp"
#include "commands/scene_options.hpp"
#include "dvdx/build_info.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "output/console.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "ranks/join.hpp"
#include "ranks/over_ranks.hpp"
#include "ranks/refusal.hpp"
#include "ranks/split.hpp"
#include "run/contact_watch.hpp"
#include "run/energy.hpp"
#include "run/energy_budget.hpp"
#include "run/engine.hpp"
#include "run/health.hpp"
#include "run/live_simulation.hpp"
#include "run/origin.hpp"
#include "run/outcome.hpp"
#include "run/start.hpp"
#include "run/threads.hpp"
#include "scene_io/fingerprint.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

struct RunOptions {
  SceneOptions scene;
  EngineOptions engine;
  std::string out;
  std::string events;
  std::optional<std::uint64_t> every{};  // 0: the last state alone; where not given, as the file's kind has it
  bool error = false;                    // a page is coloured by it
  bool json = false;
  CheckpointOptions checkpoint;
};

// Steps that one call takes: many, so that a block stays in cache for them, but not so many that progress stands still. A
// function of the scene alone, so that a run does not depend on the machine's speed.
std::uint64_t batch_for(std::size_t particles) {
  constexpr std::uint64_t particle_steps = std::uint64_t{1} << 24U;
  return std::clamp<std::uint64_t>(particle_steps / particles, 8, 4096);
}

std::uint64_t states_written(std::uint64_t steps, std::uint64_t every) {
  return every == 0 ? 1 : steps / every + (steps % every == 0 ? 1 : 2);
}

// Writes, weighs and hashes states as the world sees them: in float64 where their own columns are counted from an origin of
// their own or carry residuals, else as they are. Of several ranks each has its part of the particles, and all are told the
// same.
template <class T>
class Observer {
 public:
  Observer(const LoadedScene& loaded, const Engine& engine, const std::optional<Output>& output, std::uint64_t every,
           Checkpoints& checkpoints, Ranks& ranks)
      : file_(loaded.file),
        is_absent_(is_split_by_springs(file_, ranks) && ranks.rank() > 0),
        ranks_(is_split_by_springs(file_, ranks) ? alone_ : ranks) {
    if (is_absent_) return;
    if (is_seen_from_elsewhere(file_.scene, rounding_of(engine.precision))) world_.emplace(file_.particles.count);
    if (!output) return;
    if (world_) {
      world_out_ = std::make_unique<StatesOut<double>>(*output, every, checkpoints);
    } else {
      out_ = std::make_unique<StatesOut<T>>(*output, every, checkpoints);
    }
  }

  // Where springs join particles the first rank is told all of them, and the others have nothing to say.
  [[nodiscard]] bool is_absent() const noexcept { return is_absent_; }

  void write(const Moment& moment, const State<T>& state) {
    if (out_ != nullptr) out_->write(moment, state);
    if (world_out_ != nullptr) world_out_->write(moment, seen(state));
  }
  void finish() {
    if (out_ != nullptr) out_->finish();
    if (world_out_ != nullptr) world_out_->finish();
  }

  [[nodiscard]] double energy(const State<T>& state) {
    if (is_absent_) return 0;
    return world_ ? tool::energy(ranks_, file_, seen(state)) : tool::energy(ranks_, file_, state);
  }
  [[nodiscard]] std::uint64_t hash(const State<T>& state) {
    if (is_absent_) return 0;
    return world_ ? tool::state_hash(ranks_, seen(state)) : tool::state_hash(ranks_, state);
  }
  [[nodiscard]] Health health(const State<T>& state) {
    if (is_absent_) return {};
    return combined(ranks_, world_ ? health_of(seen(state)) : health_of(state));
  }
  [[nodiscard]] EnergyBudget budget(const State<T>& state) {
    return world_ ? EnergyBudget(file_, seen(state)) : EnergyBudget(file_, state);
  }
  void look(EnergyBudget& budget, const State<T>& state) {
    if (world_) {
      budget.look(seen(state));
    } else {
      budget.look(state);
    }
  }

 private:
  [[nodiscard]] State<double> seen(const State<T>& state) {
    State<double> world = world_->view();
    to_world(file_.scene, state, world);
    return world;
  }

  const SceneFile& file_;
  OneRank alone_;
  bool is_absent_;
  Ranks& ranks_;
  std::optional<Soa<double>> world_;
  std::unique_ptr<StatesOut<T>> out_;
  std::unique_ptr<StatesOut<double>> world_out_;
};

std::size_t most_particles(const SceneFile& file) { return std::max(file.particles.total(), file.turnover.capacity); }

// A page plays what it holds, so it holds many states; but not more than play well.
std::uint64_t every_of(const RunOptions& options, const LoadedScene& loaded) {
  if (options.every) return *options.every;
  if (!is_page(options.out)) return 0;
  constexpr std::uint64_t particle_states = 15'000'000;
  const auto states = std::clamp<std::uint64_t>(particle_states / most_particles(loaded.file), 300, 3600);
  return std::max<std::uint64_t>(1, (loaded.steps + states - 1) / states);
}

// Whether a run heats, looked at from time to time. Does nothing where no bound is known.
template <class T>
class HeatWatch {
 public:
  HeatWatch(const LoadedScene& loaded, const std::optional<NetworkLimit>& limit, Observer<T>& observer, const State<T>& start)
      : observer_(observer) {
    every_ = limit ? steps_between_looks(loaded.file) : std::nullopt;
    if (!every_ || observer.is_absent()) return;
    budget_.emplace(observer.budget(start));
    most_ = most_share(*limit, loaded.file.step);
    warmth_.emplace();
  }

  // Steps until the next look, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const {
    return every_ ? std::min(wanted, *every_ - done % *every_) : wanted;
  }
  void look(const State<T>& state, std::uint64_t done) {
    if (!warmth_ || warmth_->is_heating) return;
    observer_.look(*budget_, state);
    *warmth_ = {
        .is_heating = !(budget_->share() <= most_), .kinetic = budget_->kinetic(), .given = budget_->given(), .step = done};
  }
  [[nodiscard]] bool looks() const { return every_.has_value(); }
  [[nodiscard]] const std::optional<Warmth>& warmth() const { return warmth_; }

  void save(Sink& sink) const {
    if (!warmth_) return;
    EnergyBudget::Account account = budget_->account();
    for_each_number(account, [&](double& number) { sink.put(number); });
    sink.put(warmth_->is_heating);
    sink.put(warmth_->kinetic);
    sink.put(warmth_->given);
    sink.put(warmth_->step);
  }
  void load(Source& source) {
    if (!warmth_) return;
    EnergyBudget::Account account;
    for_each_number(account, [&](double& number) { source.get(number); });
    budget_->go_on_from(account);
    source.get(warmth_->is_heating);
    source.get(warmth_->kinetic);
    source.get(warmth_->given);
    source.get(warmth_->step);
  }

 private:
  template <class Use>
  static void for_each_number(EnergyBudget::Account& account, const Use& use) {
    use(account.now.kinetic);
    for (double& number : account.now.mass) use(number);
    for (double& number : account.now.momentum) use(number);
    auto& [now, seconds, work, most_work] = account;
    for (double* const number : {&now.wind, &now.air, &seconds, &work, &most_work}) use(*number);
  }

  Observer<T>& observer_;
  std::optional<std::uint64_t> every_;
  std::optional<EnergyBudget> budget_;
  double most_ = 0;
  std::optional<Warmth> warmth_;
};

template <class T>
class Simulation {
 public:
  Simulation(const LoadedScene& loaded, const Engine& engine, Ranks& ranks)
      : loaded_(loaded),
        ranks_(ranks),
        memory_(engine.layout, has_state() ? loaded.file.particles.count : 0, rounding_of(engine.precision)),
        state_(together(ranks, [&] { return started(loaded.file, memory_.view()); })),
        plan_(made(loaded.file, engine, state_)),
        threads_(engine.threads) {
    outcome_.network = limit();
    if (!is_split_by_springs(loaded.file, ranks)) return;
    plan_.reset();
    split_.emplace(loaded.file, engine, ranks, outcome_.network->substeps);
  }

  Outcome run(Observer<T>& observer, std::uint64_t every, ContactWatch& contacts, Checkpoints& checkpoints) {
    const auto start = observer.health(state_);
    outcome_.energy_start = observer.energy(state_);
    HeatWatch<T> watch(loaded_, outcome_.network, observer, state_);
    if (checkpoints.resumed() != nullptr) {
      go_on(*checkpoints.resumed(), watch, contacts);
    } else if (every > 0 && loaded_.steps > 0) {
      observer.write(moment(), state_);
    }
    const SaveRun save = [&](Sink& sink) { this->save(sink, watch, contacts); };
    {
      std::optional<Progress> progress;
      if (ranks_.rank() == 0) progress.emplace(loaded_.steps, done_);
      while (done_ < loaded_.steps) {
        const auto until = every == 0 ? loaded_.steps : std::min(loaded_.steps, (done_ / every + 1) * every);
        advance(until, watch, contacts, progress, checkpoints, save);
        if (every > 0 && done_ < loaded_.steps) observer.write(moment(), gathered());
      }
    }
    checkpoints.finish(done_, save);
    observer.write(moment(), gathered());
    observer.finish();
    contacts.finish();
    contacts.join(ranks_);
    outcome_.contacts = contacts.sums();
    outcome_.energy_end = observer.energy(state_);
    outcome_.hash = observer.hash(state_);
    const auto end = observer.health(state_);
    outcome_.bad_particles = end.bad_particles;
    outcome_.diverged = has_diverged(start, end);
    ranks_.broadcast(0, writable_bytes_in(outcome_.diverged));
    outcome_.warmth = watch.warmth();
    outcome_.wall_seconds = longest(ranks_, outcome_.wall_seconds);
    return outcome_;
  }

 private:
  static State<T> started(const SceneFile& file, State<T> state) {
    if (state.count == file.particles.count) place_at_start(file, state);
    return state;
  }

  // Where springs are split, the first rank has the whole state to show, and made the whole plan to learn its sub-steps.
  [[nodiscard]] bool has_state() const { return !is_split_by_springs(loaded_.file, ranks_) || ranks_.rank() == 0; }

  std::optional<Plan<T>> made(const SceneFile& file, const Engine& engine, const State<T>& state) {
    Options options{
        .step = file.step, .isa = engine.isa, .arithmetic = engine.arithmetic, .rounding = rounding_of(engine.precision)};
    if (is_split_by_ranges(file, ranks_)) options.elsewhere = elsewhere_of(ranks_, file);
    return together(ranks_, [&]() -> std::optional<Plan<T>> {
      if (!has_state()) return std::nullopt;
      auto plan = compile<T>(file.scene, options, state);
      if (!plan) throw Fault(Exit::bad_scene, file.path + ": " + plan.error().message());
      return std::move(*plan);
    });
  }

  [[nodiscard]] std::optional<NetworkLimit> limit() {
    if (!is_split_by_springs(loaded_.file, ranks_)) return plan_->network_limit();
    NetworkLimit limit;
    if (plan_) limit = plan_->network_limit().value_or(limit);
    ranks_.broadcast(0, writable_bytes_in(limit));
    return limit;
  }

  // What the observer sees.
  const State<T>& gathered() {
    if (split_) split_->gather(state_);
    return state_;
  }

  void step(std::uint64_t steps, ContactReport* report) {
    const ParallelFor parallel = threads_.parallel_for();
    if (split_) return split_->step(steps, report, parallel);
    const StepResult result =
        report != nullptr ? plan_->step(state_, *report, steps, parallel) : plan_->step(state_, steps, parallel);
    if (result != StepResult::done) throw std::logic_error("the plan is for another state");
  }

  [[nodiscard]] Moment moment() const { return {.step = done_, .time = state_.clock.seconds}; }

  void save(Sink& sink, const HeatWatch<T>& watch, const ContactWatch& contacts) const {
    put_state(sink, state_);
    sink.put(std::span<const double>(plan_->carried(state_)));
    watch.save(sink);
    contacts.save(sink);
    sink.put(outcome_.wall_seconds);
  }
  void go_on(const Checkpoint& checkpoint, HeatWatch<T>& watch, ContactWatch& contacts) {
    checkpoint.load([&](Source& source) {
      const auto count = state_.count;
      get_state(source, state_, count);
      std::vector<double> carried;
      source.get(carried);
      if (state_.count != count || !plan_->restore(carried, state_)) source.fail();
      watch.load(source);
      contacts.load(source);
      source.get(outcome_.wall_seconds);
    });
    done_ = checkpoint.header().step;
    outcome_.resumed_at = done_;
  }

  void advance(std::uint64_t until, HeatWatch<T>& watch, ContactWatch& contacts, std::optional<Progress>& progress,
               Checkpoints& checkpoints, const SaveRun& save) {
    const auto most = batch_for(loaded_.file.particles.total());
    while (done_ < until) {
      checkpoints.look(done_, save);
      const auto wanted = watch.most_steps(done_, std::min(most, until - done_));
      const auto steps = contacts.most_steps(checkpoints.most_steps(done_, wanted));
      const auto before = std::chrono::steady_clock::now();
      step(steps, contacts.report());
      outcome_.wall_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
      done_ += steps;
      if (watch.looks()) watch.look(gathered(), done_);
      contacts.write();
      if (progress) progress->at(done_);
    }
  }

  const LoadedScene& loaded_;
  Ranks& ranks_;
  StateMemory<T> memory_;
  State<T> state_;
  std::optional<Plan<T>> plan_;
  std::optional<Split<T>> split_;
  Threads threads_;
  std::uint64_t done_ = 0;
  Outcome outcome_;
};

// The bits of a run hang on all of this, but neither on threads nor on the layout, and on the instruction set only where
// arithmetic is fast.
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
Outcome run_all(const RunOptions& options, const LoadedScene& loaded, const Engine& engine, Ranks& ranks) {
  Simulated simulation(loaded, engine, ranks);
  const auto every = every_of(options, loaded);
  std::optional<Output> output;
  if (!options.out.empty()) {
    output = {.target = options.out,
              .particles = most_particles(loaded.file),
              .states = states_written(loaded.steps, every),
              .topology = &loaded.file.topology,
              .counts = is_live(loaded.file) ? Counts::changing : Counts::fixed,
              .scene = &loaded.file,
              .ranks = is_split_by_ranges(loaded.file, ranks) ? &ranks : nullptr,
              .first = loaded.file.particles.first};
  }
  Checkpoints checkpoints(options.checkpoint, identity_of(options, loaded, engine), loaded.file.name,
                          engine.precision == Precision::float32_compensated ? CallsEnd::where_they_do : CallsEnd::anywhere,
                          loaded.file.sources);
  if constexpr (std::is_same_v<Simulated, LiveSimulation<T>>) {
    if (output && (is_page(options.out) || checkpoints.is_writing())) output->ids = simulation.ids();
  }
  if (options.error && ranks.rank() == 0) {
    const auto reference = reference_of(loaded, engine);
    output->reference = reference.positions;
    output->reference_text = reference.text;
  }
  Observer<T> observer(loaded, engine, output, every, checkpoints, ranks);
  const bool counts = options.json || checkpoints.is_writing();
  ContactWatch contacts(loaded.file, counts ? Sums::counted : Sums::left_out, options.events);
  return simulation.run(observer, every, contacts, checkpoints);
}

template <class T>
Outcome simulate(const RunOptions& options, const LoadedScene& loaded, const Engine& engine, Ranks& ranks) {
  return is_live(loaded.file) ? run_all<T, LiveSimulation<T>>(options, loaded, engine, ranks)
                              : run_all<T, Simulation<T>>(options, loaded, engine, ranks);
}

double particle_steps_per_second(const LoadedScene& loaded, const Outcome& outcome) {
  const auto all = outcome.turned ? static_cast<double>(outcome.turned->particle_steps)
                                  : static_cast<double>(loaded.file.particles.total()) * static_cast<double>(loaded.steps);
  return outcome.wall_seconds > 0 ? all / outcome.wall_seconds : 0;
}

// At the end.
std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome) {
  return outcome.turned ? outcome.turned->live : loaded.file.particles.total();
}

void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks) {
  nlohmann::ordered_json report;
  report["scene"] = loaded.file.name;
  report["particles"] = particles_of(loaded, outcome);
  if (outcome.turned) {
    report["born"] = outcome.turned->born;
    report["removed"] = outcome.turned->removed;
    report["dropped"] = outcome.turned->dropped;
  }
  report["steps"] = loaded.steps;
  if (outcome.resumed_at) report["resumed_at_step"] = *outcome.resumed_at;
  report["method"] = name_in(methods, loaded.file.scene.method);
  report["scheme"] = nullptr;
  if (outcome.network) report["scheme"] = name_in(schemes, loaded.file.scene.coupling.scheme);
  report["substeps"] = outcome.network ? outcome.network->substeps : 1;
  report["precision"] = name_in(precisions, engine.precision);
  report["isa"] = name(engine.isa);
  report["threads"] = engine.threads;
  if (ranks) report["ranks"] = *ranks;
  report["layout"] = name_in(layouts, engine.layout);
  report["arithmetic"] = name(engine.arithmetic);
  report["wall_seconds"] = outcome.wall_seconds;
  report["particle_steps_per_second"] = particle_steps_per_second(loaded, outcome);
  report["state_hash"] = hash_text(outcome.hash);
  report["energy"] = {{"start", outcome.energy_start}, {"end", outcome.energy_end}};
  report["diverged"] = outcome.diverged;
  report["bad_particles"] = outcome.bad_particles;
  report["contacts"] = nlohmann::ordered_json::array();
  for (const ContactSum& sum : outcome.contacts) {
    report["contacts"].push_back({{"hits", sum.hits}, {"impulse", sum.impulse}, {"torque_impulse", sum.torque_impulse}});
  }
  if (outcome.network) report["heating"] = outcome.warmth ? nlohmann::ordered_json(outcome.warmth->is_heating) : nullptr;
  print_json(report.dump(2) + "\n");
}

void print_table(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks) {
  const auto row = [](std::string_view name, const std::string& value) {
    print_answer(fmt::format("{:<12} {}\n", name, value));
  };
  const auto& file = loaded.file;
  const std::size_t particles = particles_of(loaded, outcome);
  row("scene", fmt::format("{}, {} particle{}", printable(file.name), particles, particles == 1 ? "" : "s"));
  if (outcome.turned) {
    row("turnover", fmt::format("{} born, {} removed, {} found no room", outcome.turned->born, outcome.turned->removed,
                                outcome.turned->dropped));
  }
  row("steps", fmt::format("{} of {} s, method {}", loaded.steps, file.step, name_in(methods, file.scene.method)));
  if (outcome.network) {
    row("networks", fmt::format("{}, {} sub-step{} a step", name_in(schemes, file.scene.coupling.scheme),
                                outcome.network->substeps, outcome.network->substeps == 1 ? "" : "s"));
  }
  if (outcome.resumed_at) row("resumed", fmt::format("at step {}", *outcome.resumed_at));
  row("engine",
      fmt::format("{}, {}, {} arithmetic, {}, {} thread{}", name_in(precisions, engine.precision), name(engine.isa),
                  name(engine.arithmetic), name_in(layouts, engine.layout), engine.threads, engine.threads == 1 ? "" : "s"));
  if (ranks) row("ranks", fmt::format("{}, each with {} thread{}", *ranks, engine.threads, engine.threads == 1 ? "" : "s"));
  row("time",
      fmt::format("{:.3g} s, {:.3g} particle-steps/s", outcome.wall_seconds, particle_steps_per_second(loaded, outcome)));
  row("energy", fmt::format("{:.9g} J at the start, {:.9g} J at the end", outcome.energy_start, outcome.energy_end));
  row("state hash", hash_text(outcome.hash));
  row("diverged", outcome.diverged ? fmt::format("YES, {} particles are not finite", outcome.bad_particles) : "no");
  if (outcome.warmth) row("heating", outcome.warmth->is_heating ? "YES" : "no");
}

void warn_of_heat(const RunOptions& options, const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.warmth || !outcome.warmth->is_heating) return;
  const auto& warmth = *outcome.warmth;
  print_message(
      fmt::format("{}: warning: heating: at step {} ({:.4g} s) the particles move with {:.3g} J, and the start and the forces "
                  "can have given "
                  "them {:.3g} J: the stepping makes the rest. More sub-steps{}; see docs/stability.md",
                  options.scene.scene, warmth.step, static_cast<double>(warmth.step) * loaded.file.step, warmth.kinetic,
                  warmth.given, loaded.file.scene.coupling.scheme == Scheme::sequential ? " or a larger theta" : ""));
}

void check_checkpoints(const RunOptions& options, const Ranks& ranks) {
  const auto& [file, every, resume] = options.checkpoint;
  if (file.empty() && resume.empty()) return;
  const char* const option = file.empty() ? "--resume" : "--checkpoint";
  if (ranks.count() > 1) throw Fault(Exit::usage, std::string(option) + ": one rank does it, not several");
  if (!options.events.empty()) {
    throw Fault(Exit::usage, "--events: cannot be kept over a stop: leave out " + std::string(option));
  }
}

Exit run_on(const RunOptions& options, Ranks& ranks, bool by_launcher) {
  const auto engine = together(ranks, [&] {
    if (!options.out.empty()) check_extension(options.out);
    if (!options.events.empty() && options.events == options.out) {
      throw Fault(Exit::usage, "--events " + options.events + ": is also where --out goes");
    }
    if (!options.events.empty() && ranks.count() > 1) {
      throw Fault(Exit::usage, "--events: cannot be written by several ranks: one rank writes it");
    }
    check_checkpoints(options, ranks);
    if (options.error && !is_page(options.out)) throw Fault(Exit::usage, "--error: goes with --out of an .html");
    return engine_of(options.engine, by_launcher ? ranks_here() : 1);
  });
  const auto loaded = load_scene(options.scene, engine.precision, ranks);
  together(ranks, [&] {
    if (options.error && is_live(loaded.file)) {
      throw Fault(Exit::usage, "--error: there is no reference for particles that come and go");
    }
    if (ranks.count() > 1) check_can_be_split(loaded.file, options.out);
  });
  const auto outcome = is_kept_in_float64(engine.precision) ? simulate<double>(options, loaded, engine, ranks)
                                                            : simulate<float>(options, loaded, engine, ranks);
  const Exit exit = outcome.diverged ? Exit::diverged : Exit::done;
  if (ranks.rank() > 0) return exit;
  const auto shown = by_launcher ? std::optional(ranks.count()) : std::nullopt;
  (options.json ? print_outcome_json : print_table)(loaded, engine, outcome, shown);
  warn_of_heat(options, loaded, outcome);
  if (!outcome.diverged) return exit;
  print_message(fmt::format("{}: the simulation diverged: {} of {} particles are not finite", options.scene.scene,
                            outcome.bad_particles, particles_of(loaded, outcome)));
  return exit;
}

// A fault that one rank alone has met ends the others too: they would wait for it.
Exit run(const RunOptions& options) {
  const auto [ranks, by_launcher] = join_ranks();
  if (ranks->count() == 1) return run_on(options, *ranks, by_launcher);
  try {
    return run_on(options, *ranks, by_launcher);
  } catch (const SharedFault&) {
    throw;
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
  command->add_option("--out", options->out, "write states to a .csv, .npz, .ply, .vtp, .pc2 or .html file");
  command
      ->add_option("--every", options->every,
                   "write step 0, every N-th step and the last; 0: the last alone. Where not given: 0, and for an .html as "
                   "many as play well")
      ->check(CLI::NonNegativeNumber);
  command->add_flag(
      "--error", options->error,
      "with --out of an .html: hold each state against the closed form, or against steps of an eighth in float64");
  command->add_option("--events", options->events, "write each impact on a contact to a .csv file");
  auto* const checkpoint = command->add_option("--checkpoint", options->checkpoint.file,
                                               "a file from which --resume goes on, should the run be stopped");
  auto* const often = command->add_option("--checkpoint-every", options->checkpoint.every, "write it every N steps")
                          ->check(CLI::PositiveNumber);
  checkpoint->needs(often);
  often->needs(checkpoint);
  command->add_option("--resume", options->checkpoint.resume,
                      "go on from a checkpoint: with the same scene and options the same bits and files come out");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &exit] { exit = run(*options); });
}

}  // namespace dvdx::tool
