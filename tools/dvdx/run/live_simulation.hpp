// dvdx run of a scene whose particles come and go.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "checkpoint/checkpoints.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "run/progress.hpp"
#include "run/shared_life.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/engine.hpp"
#include "state/health.hpp"
#include "state/live_memory.hpp"
#include "state/loaded_scene.hpp"
#include "state/refusal.hpp"
#include "state/threads.hpp"
#include "watch/contact_watch.hpp"
#include "watch/long_run_watch.hpp"
#include "watch/meet_watch.hpp"
#include "watch/outcome.hpp"
#include "watch/over_ranks.hpp"
#include "watch/warnings.hpp"

namespace dvdx::tool {

template <class T>
class LiveSimulation {
 public:
  LiveSimulation(const LoadedScene& loaded, const Engine& engine, Ranks& ranks)
      : loaded_(loaded),
        ranks_(ranks),
        memory_(share_of(ranks).of(loaded.file.turnover.capacity).count, engine.layout),
        plan_(together(ranks, [&] { return live_plan<T>(loaded.file, options_of(engine)); })),
        threads_(engine.threads) {
    together(ranks, [&] { memory_.start(loaded.file); });
    if (loaded.file.scene.meet) outcome_.network = plan_.plan().network_limit();
    if (!is_split_by_births(loaded.file, ranks)) return;
    shared_.emplace(loaded.file, engine.layout, ranks);
    shared_->deal(memory_);
  }

  // Carries particle ids from now on. Returns the function that gives the ids of the shown particles. All ranks must call it.
  [[nodiscard]] ParticleIds ids() {
    memory_.carry_ids();
    if (shared_) shared_->carry_ids();
    return [this](std::size_t count) {
      memory_.give_ids(ranks_);
      if (shared_) shared_->take_ids(memory_);
      return std::span<const std::uint32_t>(memory_.ids().first(count));
    };
  }

  // observer: writes states, and computes energy, health and hash.
  template <class Observer>
  Outcome run(Observer& observer, const Frames& frames, ContactWatch& contacts, Checkpoints& checkpoints) {
    const auto start = observer.health(shown_.state, threads_.parallel_for());
    MeetWatch meetings(loaded_);
    outcome_.energy_start = observer.energy({}, shown_.state);
    if (checkpoints.resumed() != nullptr) {
      go_on(*checkpoints.resumed(), contacts, meetings);
    } else if (!frames.is_last_alone() && loaded_.steps > 0) {
      observer.write(moment(), shown());
    }
    {
      std::optional<Progress> progress;
      if (ranks_.rank() == 0) progress.emplace(loaded_.steps, done_);
      while (done_ < loaded_.steps) {
        advance(frames.next(done_, loaded_.steps), contacts, meetings, progress, checkpoints);
        if (done_ < loaded_.steps) observer.write(moment(), shown());
      }
    }
    checkpoints.finish(done_, [&] { return prepare(contacts, meetings); });
    observer.write(moment(), shown());
    observer.finish();
    contacts.finish();
    contacts.join();
    outcome_.contacts = contacts.sums();
    meetings.look(plan_.meetings(), shown_.state);
    outcome_.met = meetings.seen();
    outcome_.energy_end = observer.energy({}, shown_.state);
    outcome_.hash = observer.hash(shown_.state);
    const auto end = observer.health(shown_.state, threads_.parallel_for());
    outcome_.bad_particles = end.bad_particles;
    outcome_.diverged = has_diverged(start, end);
    ranks_.broadcast(0, writable_bytes_in(outcome_.diverged));
    outcome_.wall_seconds = longest(ranks_, outcome_.wall_seconds);
    outcome_.turned = {.live = memory_.all(),
                       .born = shown_.born,
                       .removed = shown_.removed,
                       .dropped = shown_.dropped,
                       .particle_steps = all_particle_steps()};
    return outcome_;
  }

 private:
  [[nodiscard]] Options options_of(const Engine& engine) const {
    Options options{.step = loaded_.file.step,
                    .isa = engine.isa,
                    .arithmetic = engine.arithmetic,
                    .rounding = rounding_of(engine.precision)};
    if (is_split_by_births(loaded_.file, ranks_)) options.elsewhere.births = SharedLife<T>::births(ranks_);
    return options;
  }

  // The state that is stepped here.
  [[nodiscard]] LiveState<T>& live() { return shared_ ? shared_->live() : shown_; }
  // The state that the observer sees.
  const State<T>& shown() {
    if (shared_) shared_->to_range(memory_);
    return shown_.state;
  }
  [[nodiscard]] std::uint64_t all_particle_steps() {
    std::uint64_t all = particle_steps_;
    ranks_.sum(std::span(&all, 1));
    return all;
  }

  [[nodiscard]] Moment moment() { return {.step = done_, .time = live().state.clock.seconds}; }

  void step(std::uint64_t steps, ContactReport* report) {
    const StepResult result = report != nullptr ? plan_.step(live(), *report, steps, threads_.parallel_for())
                                                : plan_.step(live(), steps, threads_.parallel_for());
    check_stepped(result, loaded_.file, live().state.clock.seconds, loaded_.file.step);
  }

  [[nodiscard]] SaveRun prepare(ContactWatch& contacts, const MeetWatch& meetings) {
    shown();
    contacts.flush();
    return [this, &meetings, carried = plan_.carried(live()), words = contacts.words(), particle_steps = all_particle_steps(),
            seconds = longest(ranks_, outcome_.wall_seconds)](Sink& sink) {
      memory_.save(sink);
      if (loaded_.file.scene.meet) sink.put(std::span<const double>(carried));
      meetings.save(sink);
      sink.put(std::span<const std::int64_t>(words));
      sink.put(particle_steps);
      sink.put(seconds);
    };
  }
  void go_on(const Checkpoint& checkpoint, ContactWatch& contacts, MeetWatch& meetings) {
    together(ranks_, [&] {
      checkpoint.load([&](Source& source) {
        memory_.load(source, share_of(ranks_));
        if (loaded_.file.scene.meet) {
          std::vector<double> carried;
          source.get(carried);
          if (!plan_.restore(carried, live())) source.fail();
        }
        meetings.load(source);
        std::vector<std::int64_t> words;
        source.get(words);
        contacts.load(words, checkpoint.header().step, source);
        source.get(particle_steps_);
        source.get(outcome_.wall_seconds);
      });
    });
    if (ranks_.rank() != 0) particle_steps_ = 0;  // the loaded sum is of all ranks: the first keeps it
    if (shared_) shared_->deal(memory_);
    done_ = checkpoint.header().step;
    outcome_.resumed_at = done_;
  }

  // Returns the steps of one call, at most `wanted`. An event names a particle by its index among all particles at the start of
  // the step. Several ranks know this index only at the start of a call: with events each call takes one step.
  std::uint64_t steps_of_call(std::uint64_t wanted, ContactWatch& contacts) {
    if (!shared_ || !contacts.tells_events()) return contacts.most_steps(std::min(steps_a_call, wanted));
    contacts.tell_in_order(shared_->kept_numbers());
    return 1;
  }

  void advance(std::uint64_t until, ContactWatch& contacts, MeetWatch& meetings, std::optional<Progress>& progress,
               Checkpoints& checkpoints) {
    while (done_ < until) {
      checkpoints.look(done_, [&] { return prepare(contacts, meetings); });
      const auto steps = steps_of_call(meetings.most_steps(done_, checkpoints.most_steps(done_, until - done_)), contacts);
      const auto before = std::chrono::steady_clock::now();
      step(steps, contacts.report());
      const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
      outcome_.wall_seconds += took;
      particle_steps_ += live().state.count * steps;
      done_ += steps;
      if (meetings.is_due(done_)) meetings.look(plan_.meetings(), shown_.state);
      contacts.write();
      if (!progress) continue;
      if (const auto seconds = dear_.take(took, steps, loaded_.steps - done_))
        warn_of_long_run(*seconds, loaded_.file, outcome_);
      progress->at(done_);
    }
  }

  const LoadedScene& loaded_;
  Ranks& ranks_;
  LiveMemory<T> memory_;  // with several ranks: the range that this rank shows
  LiveState<T>& shown_ = memory_.live();
  std::optional<SharedLife<T>> shared_;
  LifecyclePlan<T> plan_;
  Threads threads_;
  LongRunWatch dear_;
  std::uint64_t done_ = 0;
  Outcome outcome_{};
  std::uint64_t particle_steps_ = 0;
};

}  // namespace dvdx::tool
