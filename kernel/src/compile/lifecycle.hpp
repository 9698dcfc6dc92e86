// Particles that come and go, compiled: a plan that steps them, the tables of the passes, and memory to work in.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"
#include "isa/passes.hpp"
#include "math/two_double.hpp"
#include "passes/removal/fill.hpp"

namespace dvdx {

// Steps that are taken while a chunk is in cache: what dies during them is stepped to their end,
// which adds one step in 14 where particles live for 50.
inline constexpr std::size_t batch_steps = 8;
// Particles that are stepped, marked and moved while the second-level cache holds them. Every pass over them begins at memory's
// pace anew: a million with 2 % turnover took 4.3 ms a step in chunks of 1024, 2.9 in those of 8192 (one thread, AMD EPYC).
inline constexpr std::size_t live_chunk = 8192;
inline constexpr std::size_t aside_chunk = 1024;   // where they are stepped in the plan's own memory
inline constexpr std::size_t live_segments = 8;    // pieces that the particles are cut into for threads
inline constexpr std::size_t scratch_columns = 8;  // of a state, age and lifetime
static_assert(live_chunk % aside_chunk == 0 && fill_run % aside_chunk == 0);
inline constexpr std::size_t most_groups = batch_steps + live_segments;

inline bool fills_holes(const Removal& removal) noexcept { return removal.order == SurvivorOrder::any; }

// Births of one emitter until some time, as many as are whole, and as a number.
struct BirthsBy {
  std::uint64_t whole = 0;
  TwoDouble number{};
};
BirthsBy births_by(const Emitter& emitter, const Clock& clock) noexcept;

// Births side by side, counted from some first one.
struct Stretch {
  std::uint64_t first = 0, count = 0;
};

// Particles side by side that are stepped alike.
struct ParticleGroup {
  std::size_t first = 0, count = 0;
  std::size_t steps = 0;
  Clock clock{};
  bool is_new = false;       // born in this batch: looked at before the first step too
  std::size_t aside_of = 0;  // of particles that are stepped aside: where the first of them stands
};

template <class T>
struct CompiledLifecycle {
  CompiledLifecycle(Plan<T> plan_, Turnover turnover_, const SharedBirths& shared_);

  Plan<T> plan;
  Turnover turnover;
  SharedBirths shared;
  const Passes& passes;
  RemovalTerms<T> removal;
  std::vector<EmissionTerms> emitters;
};

// The working memory of one call: only one state is stepped in it at a time.
template <class T>
struct LifecycleWorkspace {
  // parts: that share the particles, each about as many.
  LifecycleWorkspace(const Turnover& turnover, std::size_t parts, const Memory& memory);

  std::array<std::vector<BirthsBy>, batch_steps + 1>
      births;                                 // of each emitter, by the start of each step and by the last's end
  std::array<Clock, batch_steps + 1> clocks;  // of the same times
  AlignedArray<T> scratch;                    // a chunk for each thread
  std::size_t overflow_bytes;
  AlignedArray<T> overflow;       // survivors that must wait until another thread has read where they belong
  std::vector<std::size_t> kept;  // of each run, in any order
  std::vector<Stretch> waiting;   // births that found no hole in their run
  std::vector<Fill> fills;        // of each thread
  std::atomic_flag is_stepping = ATOMIC_FLAG_INIT;
};

template <class T>
struct LivePlan<T>::Parts {
  Parts(Plan<T> plan, const Turnover& turnover, const Options& options)
      : compiled(std::move(plan), turnover, options.elsewhere.births),
        workspace(turnover, options.elsewhere.births.parts, options.memory),
        memory(options.memory) {}
  explicit Parts(const Parts& other)
      : compiled(other.compiled.plan.clone(), other.compiled.turnover, other.compiled.shared),
        workspace(compiled.turnover, compiled.shared.parts, other.memory),
        memory(other.memory) {}

  CompiledLifecycle<T> compiled;
  LifecycleWorkspace<T> workspace;
  Memory memory;
};

}  // namespace dvdx
