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
#include "commands/progress.hpp"
#include "commands/scene_options.hpp"
#include "dvdx/plan.hpp"
#include "ranks/agree.hpp"
#include "ranks/over_ranks.hpp"
#include "ranks/refusal.hpp"
#include "ranks/split.hpp"
#include "run/contact_watch.hpp"
#include "run/engine.hpp"
#include "run/health.hpp"
#include "run/heat_watch.hpp"
#include "run/observer.hpp"
#include "run/outcome.hpp"
#include "run/start.hpp"
#include "run/state_memory.hpp"
#include "run/tearing.hpp"
#include "run/threads.hpp"
#include "scene_io/plan_fault.hpp"

namespace dvdx::tool {

// Steps that one call takes: many, so that a block stays in cache for them, but not so many that progress stands still. A
// function of the scene alone, so that a run does not depend on the machine's speed.
inline std::uint64_t batch_for(std::size_t particles) {
  constexpr std::uint64_t particle_steps = std::uint64_t{1} << 24U;
  return std::clamp<std::uint64_t>(particle_steps / particles, 8, 4096);
}

template <class T>
class Simulation {
 public:
  Simulation(const LoadedScene& loaded, const Engine& engine, Ranks& ranks)
      : loaded_(loaded),
        ranks_(ranks),
        memory_(engine.layout, has_state() ? loaded.file.particles.count : 0, rounding_of(engine.precision)),
        state_(together(ranks, [&] { return started(loaded.file, memory_.view()); })),
        plan_(made(loaded.file, engine, state_)),
        tearing_(loaded.file),
        threads_(engine.threads) {
    outcome_.network = limit();
    if (plan_) (void)plan_->step(state_, 0);  // kinematic particles, where they are at the start
    if (!is_split_by_springs(loaded.file, ranks)) return;
    plan_.reset();
    split_.emplace(loaded.file, engine, ranks, *outcome_.network);
  }

  // Grows while the run goes on.
  [[nodiscard]] const std::vector<Tear>& tears() const noexcept { return tearing_.tears(); }

  // Each particle's rank, on the first one, where springs are split.
  [[nodiscard]] std::vector<std::uint32_t> owner() const { return split_ ? split_->owner() : std::vector<std::uint32_t>(); }

  Outcome run(Observer<T>& observer, std::uint64_t every, ContactWatch& contacts, Checkpoints& checkpoints) {
    const auto start = observer.health(state_);
    outcome_.energy_start = observer.energy(networks(), state_);
    HeatWatch<T> watch(loaded_, outcome_.network, observer, state_);
    if (split_) contacts.tell_of(split_->particles());
    if (checkpoints.resumed() != nullptr) {
      go_on(*checkpoints.resumed(), watch, contacts);
    } else if (every > 0 && loaded_.steps > 0) {
      observer.write(moment(), state_);
    }
    const PrepareSave prepare = [&] { return this->prepare(watch, contacts); };
    (void)longest(ranks_, 0);  // what the first rank has weighed alone is no time of the steps
    {
      std::optional<Progress> progress;
      if (ranks_.rank() == 0) progress.emplace(loaded_.steps, done_);
      while (done_ < loaded_.steps) {
        const auto until = every == 0 ? loaded_.steps : std::min(loaded_.steps, (done_ / every + 1) * every);
        advance(until, watch, contacts, progress, checkpoints, prepare);
        if (every > 0 && done_ < loaded_.steps) observer.write(moment(), gathered());
      }
    }
    checkpoints.finish(done_, prepare);
    observer.write(moment(), gathered());
    observer.finish();
    contacts.finish();
    contacts.join();
    tell(observer, contacts, watch, start);
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
      if (!plan) throw fault_of(file, plan.error());
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

  // As they are now: with what has torn.
  [[nodiscard]] std::span<const Network> networks() const {
    return tearing_.is_possible() ? plan_->scene().networks : loaded_.file.scene.networks;
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

  void tell(Observer<T>& observer, const ContactWatch& contacts, const HeatWatch<T>& watch, const Health& start) {
    outcome_.contacts = contacts.sums();
    outcome_.energy_end = observer.energy(networks(), state_);
    if (tearing_.is_possible()) outcome_.torn = tearing_.tears().size();
    outcome_.hash = observer.hash(state_);
    const auto end = observer.health(state_);
    outcome_.bad_particles = end.bad_particles;
    outcome_.diverged = has_diverged(start, end);
    ranks_.broadcast(0, writable_bytes_in(outcome_.diverged));
    outcome_.warmth = watch.warmth();
    outcome_.wall_seconds = longest(ranks_, outcome_.wall_seconds);
    if (!split_) return;
    std::array<std::uint64_t, 2> told{ranks_.started().messages, ranks_.started().bytes};
    ranks_.sum(told);
    outcome_.halo =
        Halo{.told = {.messages = told[0], .bytes = told[1]}, .waited_seconds = longest(ranks_, split_->waited_seconds())};
  }

  [[nodiscard]] std::vector<double> carried() { return split_ ? split_->carried() : plan_->carried(state_); }

  [[nodiscard]] SaveRun prepare(const HeatWatch<T>& watch, ContactWatch& contacts) {
    gathered();
    contacts.flush();
    return [this, &watch, carried = this->carried(), words = contacts.words(),
            seconds = longest(ranks_, outcome_.wall_seconds)](Sink& sink) {
      put_state(sink, state_, loaded_.file.particles.total());
      tearing_.save(sink);
      sink.put(std::span<const double>(carried));
      watch.save(sink);
      sink.put(std::span<const std::int64_t>(words));
      sink.put(seconds);
    };
  }
  // What each rank holds, or all of it on the first one.
  void load(Source& source, std::uint64_t step, std::vector<double>& carried, HeatWatch<T>& watch, ContactWatch& contacts) {
    get_state(source, state_, {.first = loaded_.file.particles.first, .all = loaded_.file.particles.total()});
    if (plan_) tearing_.load(source, *plan_);
    source.get(carried);
    if (plan_ && !plan_->restore(carried, state_)) source.fail();
    watch.load(source);
    std::vector<std::int64_t> words;
    source.get(words);
    contacts.load(words, step, source);
    source.get(outcome_.wall_seconds);
  }
  void go_on(const Checkpoint& checkpoint, HeatWatch<T>& watch, ContactWatch& contacts) {
    std::vector<double> carried;
    const auto step = checkpoint.header().step;
    together(ranks_, [&] {
      if (!has_state()) return contacts.go_on_at(step);
      checkpoint.load([&](Source& source) { load(source, step, carried, watch, contacts); });
    });
    if (split_) split_->go_on(state_, carried);
    done_ = step;
    outcome_.resumed_at = done_;
  }

  void advance(std::uint64_t until, HeatWatch<T>& watch, ContactWatch& contacts, std::optional<Progress>& progress,
               Checkpoints& checkpoints, const PrepareSave& prepare) {
    const auto most = batch_for(loaded_.file.particles.total());
    while (done_ < until) {
      checkpoints.look(done_, prepare);
      const auto wanted = watch.most_steps(done_, std::min(most, until - done_));
      const auto steps = contacts.most_steps(checkpoints.most_steps(done_, tearing_.is_possible() ? 1 : wanted));
      const auto before = std::chrono::steady_clock::now();
      step(steps, contacts.report());
      if (tearing_.is_possible()) tearing_.look(*plan_, state_, done_ + steps);
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
  Tearing<T> tearing_;
  Threads threads_;
  std::uint64_t done_ = 0;
  Outcome outcome_;
};

}  // namespace dvdx::tool
