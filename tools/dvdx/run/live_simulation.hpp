// dvdx run of a scene whose particles come and go.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "checkpoint/checkpoints.hpp"
#include "commands/progress.hpp"
#include "commands/scene_options.hpp"
#include "output/writer.hpp"
#include "run/contact_watch.hpp"
#include "run/engine.hpp"
#include "run/health.hpp"
#include "run/live_memory.hpp"
#include "run/outcome.hpp"
#include "run/threads.hpp"

namespace dvdx::tool {

template <class T>
class LiveSimulation {
 public:
  LiveSimulation(const LoadedScene& loaded, const Engine& engine, Ranks& /*one*/)
      : loaded_(loaded),
        memory_(loaded.file, engine.layout),
        live_(memory_.live()),
        plan_(live_plan<T>(loaded.file, {.step = loaded.file.step,
                                         .isa = engine.isa,
                                         .arithmetic = engine.arithmetic,
                                         .rounding = rounding_of(engine.precision)})),
        threads_(engine.threads) {}

  // The particles' ids, from now on.
  [[nodiscard]] ParticleIds ids() {
    memory_.carry_ids();
    return [this](std::size_t count) { return memory_.ids(count); };
  }

  // The observer writes, weighs and hashes.
  template <class Observer>
  Outcome run(Observer& observer, std::uint64_t every, ContactWatch& contacts, Checkpoints& checkpoints) {
    const auto start = observer.health(live_.state);
    outcome_.energy_start = observer.energy({}, live_.state);
    if (checkpoints.resumed() != nullptr) {
      go_on(*checkpoints.resumed(), contacts);
    } else if (every > 0 && loaded_.steps > 0) {
      observer.write(moment(), live_.state);
    }
    {
      Progress progress(loaded_.steps, done_);
      while (done_ < loaded_.steps) {
        const auto until = every == 0 ? loaded_.steps : std::min(loaded_.steps, (done_ / every + 1) * every);
        advance(until, contacts, progress, checkpoints);
        if (every > 0 && done_ < loaded_.steps) observer.write(moment(), live_.state);
      }
    }
    checkpoints.finish(done_, [&] { return prepare(contacts); });
    observer.write(moment(), live_.state);
    observer.finish();
    contacts.finish();
    outcome_.contacts = contacts.sums();
    outcome_.energy_end = observer.energy({}, live_.state);
    outcome_.hash = observer.hash(live_.state);
    const auto end = observer.health(live_.state);
    outcome_.bad_particles = end.bad_particles;
    outcome_.diverged = has_diverged(start, end);
    turned_.live = live_.state.count;
    turned_.born = live_.born;
    turned_.removed = live_.removed;
    turned_.dropped = live_.dropped;
    outcome_.turned = turned_;
    return outcome_;
  }

 private:
  // Steps that one call takes, so that progress does not stand still.
  static constexpr std::uint64_t together = 8;

  [[nodiscard]] Moment moment() const { return {.step = done_, .time = live_.state.clock.seconds}; }

  StepResult step(std::uint64_t steps, ContactReport* report) {
    return report != nullptr ? plan_.step(live_, *report, steps, threads_.parallel_for())
                             : plan_.step(live_, steps, threads_.parallel_for());
  }

  [[nodiscard]] SaveRun prepare(ContactWatch& contacts) const {
    contacts.flush();
    return [this, words = contacts.words()](Sink& sink) {
      memory_.save(sink);
      sink.put(std::span<const std::int64_t>(words));
      sink.put(turned_.particle_steps);
      sink.put(outcome_.wall_seconds);
    };
  }
  void go_on(const Checkpoint& checkpoint, ContactWatch& contacts) {
    checkpoint.load([&](Source& source) {
      memory_.load(source);
      std::vector<std::int64_t> words;
      source.get(words);
      contacts.load(words, checkpoint.header().step, source);
      source.get(turned_.particle_steps);
      source.get(outcome_.wall_seconds);
    });
    done_ = checkpoint.header().step;
    outcome_.resumed_at = done_;
  }

  void advance(std::uint64_t until, ContactWatch& contacts, Progress& progress, Checkpoints& checkpoints) {
    while (done_ < until) {
      checkpoints.look(done_, [&] { return prepare(contacts); });
      const auto steps = contacts.most_steps(checkpoints.most_steps(done_, std::min(together, until - done_)));
      const auto before = std::chrono::steady_clock::now();
      if (step(steps, contacts.report()) != StepResult::done) throw std::logic_error("the plan is for another state");
      outcome_.wall_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
      turned_.particle_steps += live_.state.count * steps;
      done_ += steps;
      contacts.write();
      progress.at(done_);
    }
  }

  const LoadedScene& loaded_;
  LiveMemory<T> memory_;
  LiveState<T>& live_;
  LivePlan<T> plan_;
  Threads threads_;
  std::uint64_t done_ = 0;
  Outcome outcome_{};
  Turned turned_{};
};

}  // namespace dvdx::tool
