// dvdx run of a scene whose particles stay.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "checkpoint/checkpoints.hpp"
#include "dvdx/plan.hpp"
#include "ranks/agree.hpp"
#include "run/progress.hpp"
#include "run/split.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/engine.hpp"
#include "state/health.hpp"
#include "state/loaded_scene.hpp"
#include "state/refusal.hpp"
#include "state/start.hpp"
#include "state/state_memory.hpp"
#include "state/threads.hpp"
#include "watch/contact_watch.hpp"
#include "watch/heat_watch.hpp"
#include "watch/join_watch.hpp"
#include "watch/long_run_watch.hpp"
#include "watch/meet_watch.hpp"
#include "watch/observer.hpp"
#include "watch/outcome.hpp"
#include "watch/over_ranks.hpp"
#include "watch/pinch_watch.hpp"
#include "watch/poke_watch.hpp"
#include "watch/tearing.hpp"
#include "watch/warnings.hpp"

namespace dvdx::tool {

// Returns the steps of one call: many, so that a block stays in cache for them, but few enough that progress is shown. It
// depends on the scene alone, so that a run does not depend on the machine's speed.
inline std::uint64_t batch_for(std::size_t particles) {
  constexpr std::uint64_t particle_steps = std::uint64_t{1} << 24U;
  return std::clamp<std::uint64_t>(particle_steps / particles, 8, 4096);
}

// Whether the start values read from a scene's files are kept after the particles have been placed.
enum class Starts { kept, given_back };

template <class T>
class Simulation {
 public:
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  Simulation(LoadedScene& loaded, const Engine& engine, Ranks& ranks, Starts starts)
      : loaded_(loaded),
        ranks_(ranks),
        memory_(engine.layout, shown_by(loaded.file, ranks).count, rounding_of(engine.precision)),
        state_(memory_.view()),
        tearing_(loaded.file),
        threads_(engine.threads) {
    is_split_by_springs(loaded.file, ranks) ? split(engine, loaded.file) : start(engine, loaded.file, starts);
  }

  // Grows while the run goes on.
  [[nodiscard]] const std::vector<Tear>& tears() const noexcept { return tearing_.tears(); }

  // Returns each particle's rank if springs are split over ranks, otherwise nothing.
  [[nodiscard]] std::vector<std::uint32_t> owner() const { return split_ ? split_->owner() : std::vector<std::uint32_t>(); }

  Outcome run(Observer<T>& observer, const Frames& frames, ContactWatch& contacts, Checkpoints& checkpoints) {
    const auto start = observer.health(state_, threads_.parallel_for());
    outcome_.energy_start = observer.energy(loaded_.file.scene.networks, state_);
    HeatWatch<T> heat(loaded_, outcome_.network, find_frequency_, observer, state_);
    JoinWatch<T> joins(loaded_, outcome_.network, heat, ranks_.count(), plan_ ? &*plan_ : nullptr);
    PinchWatch pinches(loaded_.file, ranks_.count());
    PokeWatch pokes(loaded_.file, ranks_.count());
    MeetWatch meetings(loaded_, ranks_.count());
    Watches watch{observer, heat, joins, pinches, pokes, meetings};
    if (split_) contacts.tell_of(split_->particles());
    if (checkpoints.resumed() != nullptr) {
      go_on(*checkpoints.resumed(), watch, contacts);
    } else {
      joins.look(observer, state_, done_, heat);
      if (!frames.is_last_alone() && loaded_.steps > 0) observer.write(moment(), state_);
    }
    const PrepareSave prepare = [&] { return this->prepare(watch, contacts); };
    (void)longest(ranks_, 0);  // a barrier: work that one rank does alone does not count as time of the steps
    {
      std::optional<Progress> progress;
      if (ranks_.rank() == 0) progress.emplace(loaded_.steps, done_);
      while (done_ < loaded_.steps) {
        advance(frames.next(done_, loaded_.steps), watch, contacts, progress, checkpoints, prepare);
        if (done_ < loaded_.steps) observer.write(moment(), shown());
      }
    }
    checkpoints.finish(done_, prepare);
    observer.write(moment(), shown());
    observer.finish();
    contacts.finish();
    contacts.join();
    watch.look_at_end(shown(), done_);
    look_at_meetings(watch);
    tell(observer, contacts, watch, start);
    return outcome_;
  }

 private:
  struct Watches {
    Observer<T>& observer;
    HeatWatch<T>& heat;
    JoinWatch<T>& joins;
    PinchWatch& pinches;
    PokeWatch& pokes;
    MeetWatch& meetings;

    [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const {
      return meetings.most_steps(done, joins.most_steps(done, heat.most_steps(done, wanted)));
    }
    void look(const State<T>& state, std::uint64_t done) {
      heat.look_when_due(state, done);
      joins.look_when_due(observer, state, done, heat);
      if (!joins.is_due(done)) return;
      pinches.look(state);
      pokes.look(state);
    }
    [[nodiscard]] bool looks() const { return heat.looks() || joins.looks(); }
    void look_at_end(const State<T>& state, std::uint64_t done) {
      heat.look(state, done);
      joins.look(observer, state, done, heat);
      pinches.look(state);
      pokes.look(state);
    }
    void save(Sink& sink) const {
      heat.save(sink);
      joins.save(sink);
      meetings.save(sink);
    }
    void load(Source& source) {
      heat.load(source);
      joins.load(source);
      meetings.load(source);
    }
  };

  [[nodiscard]] Options options_of(const Engine& engine) const {
    return {.step = loaded_.file.step,
            .isa = engine.isa,
            .arithmetic = engine.arithmetic,
            .rounding = rounding_of(engine.precision)};
  }
  [[nodiscard]] Plan<T> made(const Options& options, const State<T>& state) const {
    auto plan = compile<T>(loaded_.file.scene, options, state);
    if (!plan) throw fault_of(loaded_.file, plan.error());
    return std::move(*plan);
  }

  void start(const Engine& engine, SceneFile& file, Starts starts) {
    const bool gives_back = starts == Starts::given_back && !is_start_asked_for(file.scene);
    together(ranks_, [&] {
      if (gives_back) {
        move_to_start(file, state_, threads_.parallel_for());
      } else {
        place_at_start(file, state_, threads_.parallel_for());
      }
    });
    Options options = options_of(engine);
    if (is_split_by_ranges(loaded_.file, ranks_)) options.elsewhere = elsewhere_of(ranks_, loaded_.file);
    together(ranks_, [&] { plan_.emplace(made(options, state_)); });
    outcome_.network = limit_by_rows(file, ranks_);
    if (outcome_.network) {
      find_frequency_ = [this] { return plan_->network_limit()->frequency; };
    } else {
      outcome_.network = plan_->network_limit();
    }
    if (outcome_.network) file.scene.coupling.scheme = outcome_.network->scheme;
    (void)plan_->step(state_, 0);  // places kinematic particles where they are at the start
    if (ranks_.count() != 1) return;
    outcome_.inside = start_inside(file, state_);
    if (!state_.has_rests()) outcome_.rounding = spring_rounding(file, state_);
  }
  void split(const Engine& engine, SceneFile& file) {
    outcome_.network = limit_by_rows(file, ranks_);
    if (outcome_.network) {
      find_frequency_ = [this, engine] { return limit_of_whole(engine).frequency; };
    } else {
      outcome_.network = limit_of_whole(engine);
    }
    file.scene.coupling.scheme = outcome_.network->scheme;
    try {
      split_.emplace(loaded_.file, engine, ranks_, *outcome_.network);
    } catch (const SharedFault& fault) {
      // A part has its own particle numbers, so the plan of the whole scene reports the fault.
      if (find_frequency_ && fault.exit() == Exit::bad_scene) (void)limit_of_whole(engine);
      throw;
    }
    split_->to_ranges(state_);
  }
  // The first rank compiles the whole scene and sends all ranks the limit. It keeps this plan if tears may change the limit.
  [[nodiscard]] NetworkLimit limit_of_whole(const Engine& engine) {
    together(ranks_, [&] {
      if (ranks_.rank() != 0) return;
      StateMemory<T> memory(engine.layout, loaded_.file.particles.count, rounding_of(engine.precision));
      State<T> whole = memory.view();
      place_at_start(loaded_.file, whole, threads_.parallel_for());
      plan_.emplace(made(options_of(engine), whole));
    });
    const NetworkLimit limit = limit_now();
    if (!may_tears_change_limit()) plan_.reset();
    return limit;
  }
  // Given sub-steps never change. By `sequential` the springs also choose rho, the part of a stiff motion that is left.
  [[nodiscard]] bool may_tears_change_limit() const {
    const Coupling& coupling = loaded_.file.scene.coupling;
    return tearing_.is_possible() && (!coupling.substeps || coupling.scheme == Scheme::sequential);
  }
  [[nodiscard]] NetworkLimit limit_now() {
    NetworkLimit limit;
    if (plan_) limit = plan_->network_limit().value_or(limit);
    ranks_.broadcast(0, writable_bytes_in(limit));
    return limit;
  }

  // Finds and breaks the springs that tear: OfPlan in the plan of one rank, OfRanks in the parts of several.
  struct OfPlan {
    Plan<T>& plan;
    const State<T>& state;
    [[nodiscard]] std::vector<Pair> too_long(std::size_t network, double stretch) const {
      auto found = plan.too_long(network, stretch, state);
      if (!found) throw std::logic_error(found.error().message());
      return std::move(*found);
    }
    void break_springs(std::size_t network, std::span<const Pair> torn) const {
      if (const auto done = plan.break_springs(network, torn); !done) throw std::runtime_error(done.error().message());
    }
  };
  struct OfRanks {
    Ranks& ranks;
    Split<T>& split;
    Plan<T>* whole;  // the first rank's, or null
    [[nodiscard]] std::vector<Pair> too_long(std::size_t network, double stretch) const {
      return split.too_long(network, stretch);
    }
    void break_springs(std::size_t network, std::span<const Pair> torn) const {
      together(ranks, [&] {
        const auto done = whole != nullptr ? whole->break_springs(network, torn) : Expected<void>();
        if (!done) throw std::runtime_error(done.error().message());
      });
      split.break_springs(network, torn);
    }
  };
  [[nodiscard]] OfRanks of_ranks() { return {ranks_, *split_, plan_ ? &*plan_ : nullptr}; }

  void tear(std::uint64_t step) {
    if (!split_) {
      OfPlan of{*plan_, state_};
      (void)tearing_.look(of, step);
    } else if (OfRanks of = of_ranks(); tearing_.look(of, step) && may_tears_change_limit()) {
      split_->take(limit_now());
    }
  }

  // The state that the observer sees.
  const State<T>& shown() {
    if (split_) split_->to_ranges(state_);
    return state_;
  }

  void step(std::uint64_t steps, ContactReport* report) {
    const ParallelFor parallel = threads_.parallel_for();
    if (split_) return split_->step(steps, report, parallel);
    const StepResult result =
        report != nullptr ? plan_->step(state_, *report, steps, parallel) : plan_->step(state_, steps, parallel);
    check_stepped(result, loaded_.file, state_.clock.seconds, static_cast<double>(steps) * loaded_.file.step);
  }

  void look_at_meetings(const Watches& watch) const {
    if (split_) return watch.meetings.look(split_->meetings(), state_);
    watch.meetings.look(plan_->meetings(), state_);
  }

  [[nodiscard]] Moment moment() const { return {.step = done_, .time = state_.clock.seconds}; }

  void tell(Observer<T>& observer, const ContactWatch& contacts, const Watches& watch, const Health& start) {
    outcome_.contacts = contacts.sums();
    if (tearing_.is_possible()) {
      outcome_.energy_end = observer.energy(tearing_.torn(loaded_.file.scene.networks), state_);
      outcome_.torn = tearing_.tears().size();
    } else {
      outcome_.energy_end = observer.energy(loaded_.file.scene.networks, state_);
    }
    outcome_.hash = observer.hash(state_);
    const auto end = observer.health(state_, threads_.parallel_for());
    outcome_.bad_particles = end.bad_particles;
    outcome_.diverged = has_diverged(start, end);
    ranks_.broadcast(0, writable_bytes_in(outcome_.diverged));
    outcome_.warmth = watch.heat.warmth();
    outcome_.held = watch.heat.held();
    outcome_.joins = watch.joins.seen();
    outcome_.pinch = watch.pinches.found();
    outcome_.poke = watch.pokes.found();
    outcome_.met = watch.meetings.seen();
    outcome_.wall_seconds = longest(ranks_, outcome_.wall_seconds);
    if (!split_) return;
    std::array<std::uint64_t, 2> told{ranks_.started().messages, ranks_.started().bytes};
    ranks_.sum(told);
    outcome_.halo =
        Halo{.told = {.messages = told[0], .bytes = told[1]}, .waited_seconds = longest(ranks_, split_->waited_seconds())};
  }

  [[nodiscard]] CarriedInRanges carried() {
    return split_ ? split_->carried() : CarriedInRanges{.alike = plan_->carried(state_)};
  }

  [[nodiscard]] SaveRun prepare(const Watches& watch, ContactWatch& contacts) {
    shown();
    contacts.flush();
    return [this, &watch, carried = this->carried(), words = contacts.words(),
            seconds = longest(ranks_, outcome_.wall_seconds)](Sink& sink) {
      put_state(sink, state_, loaded_.file.particles.total());
      tearing_.save(sink);
      carried.save(sink);
      watch.save(sink);
      sink.put(std::span<const std::int64_t>(words));
      sink.put(seconds);
    };
  }
  // Loads the states that each rank shows.
  void load(Source& source, std::uint64_t step, CarriedInRanges& carried, Watches& watch, ContactWatch& contacts) {
    const std::size_t all = loaded_.file.particles.total();
    const Run mine = shown_by(loaded_.file, ranks_);
    get_state(source, state_, {.first = mine.first, .all = all});
    tearing_.load(source);
    if (split_) {
      carried.load(source, all, mine, split_->carried_shape());
    } else {
      OfPlan of{*plan_, state_};
      (void)tearing_.break_again(of);
      source.get(carried.alike);
      if (!plan_->restore(carried.alike, state_)) source.fail();
    }
    watch.load(source);
    std::vector<std::int64_t> words;
    source.get(words);
    contacts.load(words, step, source);
    source.get(outcome_.wall_seconds);
  }
  void go_on(const Checkpoint& checkpoint, Watches& watch, ContactWatch& contacts) {
    CarriedInRanges carried;
    const auto step = checkpoint.header().step;
    together(ranks_, [&] { checkpoint.load([&](Source& source) { load(source, step, carried, watch, contacts); }); });
    if (split_) {
      if (OfRanks of = of_ranks(); tearing_.break_again(of) && may_tears_change_limit()) split_->take(limit_now());
      split_->go_on(state_, carried);
    }
    done_ = step;
    outcome_.resumed_at = done_;
  }

  void advance(std::uint64_t until, Watches& watch, ContactWatch& contacts, std::optional<Progress>& progress,
               Checkpoints& checkpoints, const PrepareSave& prepare) {
    const auto most = batch_for(loaded_.file.particles.total());
    while (done_ < until) {
      checkpoints.look(done_, prepare);
      const auto wanted = watch.most_steps(done_, std::min(most, until - done_));
      const auto steps = contacts.most_steps(checkpoints.most_steps(done_, tearing_.is_possible() ? 1 : wanted));
      const auto before = std::chrono::steady_clock::now();
      step(steps, contacts.report());
      if (tearing_.is_possible()) tear(done_ + steps);
      const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
      outcome_.wall_seconds += took;
      done_ += steps;
      if (watch.looks()) watch.look(shown(), done_);
      if (watch.meetings.is_due(done_)) look_at_meetings(watch);
      contacts.write();
      if (!progress) continue;
      if (const auto seconds = dear_.take(took, steps, loaded_.steps - done_))
        warn_of_long_run(*seconds, loaded_.file, outcome_);
      progress->at(done_);
    }
  }

  const LoadedScene& loaded_;
  Ranks& ranks_;
  StateMemory<T> memory_;
  State<T> state_;
  std::optional<Plan<T>> plan_;
  std::optional<Split<T>> split_;
  Tearing tearing_;
  Threads threads_;
  LongRunWatch dear_;
  std::uint64_t done_ = 0;
  Outcome outcome_;
  FindFrequency find_frequency_;  // set if only a bound of the frequency at the start is known
};

}  // namespace dvdx::tool
