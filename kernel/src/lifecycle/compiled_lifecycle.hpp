// Particles that come and go, compiled: a plan that steps them, the passes, and memory to work in. Their step: live_step.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "contact/surfaces/surface.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"
#include "flow/terms.hpp"
#include "isa/passes.hpp"
#include "lifecycle/pass/fill.hpp"
#include "math/two_double.hpp"
#include "motion/driven.hpp"
#include "motion/pose_track.hpp"
#include "scene/particle_values.hpp"

namespace dvdx {

// Steps that are taken while a chunk is in cache. Particles that die during them are stepped to their end, which adds one step
// in 14 if particles live for 50.
inline constexpr std::size_t batch_steps = 8;
// Particles that are stepped, marked and moved while they are in second-level cache. Every pass over them starts at the speed
// of memory: a million with 2 % turnover took 4.3 ms a step in chunks of 1024, 2.9 in those of 8192 (one thread, AMD EPYC).
inline constexpr std::size_t live_chunk = 8192;
inline constexpr std::size_t aside_chunk = 1024;   // likewise, stepped in the plan's own memory
inline constexpr std::size_t live_segments = 8;    // pieces that the particles are cut into for threads
inline constexpr std::size_t scratch_columns = 8;  // of a state, age and lifetime
static_assert(live_chunk % aside_chunk == 0 && fill_run % aside_chunk == 0);
inline constexpr std::size_t most_groups = batch_steps + live_segments;

inline bool fills_holes(SurvivorOrder order) noexcept { return order == SurvivorOrder::any; }
inline bool fills_holes(const Removal& removal) noexcept { return fills_holes(removal.order); }

// Births of one emitter until some time: the whole births, and the number with its fraction.
struct BirthCount {
  std::uint64_t whole = 0;
  TwoDouble number{};
};
BirthCount births_until(const Emitter& emitter, const Clock& clock) noexcept;

// Consecutive births, counted from some first one.
struct BirthRange {
  std::uint64_t first = 0, count = 0;
};

// Consecutive particles that are stepped alike.
struct ParticleGroup {
  std::size_t first = 0, count = 0;
  std::size_t steps = 0;
  Clock clock{};
  bool is_new = false;       // born in this batch: tested for removal before the first step too
  bool is_stepped = false;   // already moved: the steps only age and test them
  std::size_t aside_of = 0;  // of particles stepped in the plan's own memory: the place of the first
};

template <class T>
struct CompiledLifecycle {
  CompiledLifecycle(Plan<T> plan_, Lifecycle turnover_, const SharedBirths& shared_);

  Plan<T> plan;
  Lifecycle turnover;
  SharedBirths shared;
  const Passes& passes;
  RemovalTerms<T> removal;
  std::vector<EmissionTerms> emitters;
  std::vector<PoseTrack> tracks;  // of the scene's motions
};

// The numbers that a workspace is made for.
struct LifecycleShape {
  std::size_t capacity = 0, parts = 1, emitters = 0, contacts = 0, motions = 0;
  SurvivorOrder order = SurvivorOrder::kept;
  bool meets = false;
  bool operator==(const LifecycleShape&) const = default;
};
// Whether the particles meet. The plan then steps all of them, and what follows a motion, in working columns by sub-steps.
template <class T>
bool meets(const CompiledLifecycle<T>& compiled) noexcept {
  return compiled.plan.scene().meet.has_value();
}
template <class T>
LifecycleShape shape_of(const CompiledLifecycle<T>& compiled) noexcept {
  const Lifecycle& turnover = compiled.turnover;
  return {.capacity = turnover.capacity,
          .parts = compiled.shared.parts,
          .emitters = turnover.emitters.size(),
          .contacts = compiled.plan.scene().contacts.size(),
          .motions = compiled.tracks.size(),
          .order = turnover.removal.order,
          .meets = meets(compiled)};
}

// Everything that follows a motion, as it is at the end of one step.
template <class T>
struct LiveFollowers {
  explicit LiveFollowers(const LifecycleShape& shape);

  std::vector<DrivenMotion> motions;  // with the caller's targets
  std::vector<MovedPose> poses;       // of each
  std::vector<Surface<T>> surfaces;   // of the scene's contacts
  Terms<T> terms{};                   // of the step, with these surfaces
  const Terms<T>* moved = nullptr;    // these, if a surface is carried
};

// The working memory of one call: only one state is stepped in it at a time.
template <class T>
struct LifecycleWorkspace {
  LifecycleWorkspace(const LifecycleShape& shape, const Memory& memory);

  [[nodiscard]] std::size_t bytes() const noexcept;

  LifecycleShape shape;
  std::array<std::vector<BirthCount>, batch_steps + 1>
      births;                                 // of each emitter, by the start of each step and by the last's end
  std::array<Clock, batch_steps + 1> clocks;  // of the same times
  AlignedArray<T> scratch;                    // a chunk for each thread
  std::size_t overflow_bytes;
  AlignedArray<T> overflow;         // survivors that wait until the places where they belong have been read
  std::vector<std::size_t> kept;    // places taken in each run, for SurvivorOrder::any
  std::vector<BirthRange> waiting;  // births that found no hole in their run
  std::vector<Fill> fills;          // of each thread
  LiveFollowers<T> followers;
  std::optional<Workspace<T>> meeting;  // of particles that meet; none: the plan's own
  std::vector<std::uint32_t> after;     // likewise: each particle's number after a removal
  std::atomic_flag is_stepping = ATOMIC_FLAG_INIT;
  // The number of the plan's calls of set_pose() that this workspace includes; all_known if it was driven itself.
  std::uint64_t known = 0;
  static constexpr std::uint64_t all_known = std::numeric_limits<std::uint64_t>::max();
};

// Whether a contact, and whether anything, follows a motion that the lifecycle moves.
template <class T>
bool moves_contacts(const CompiledLifecycle<T>& compiled) noexcept {
  return !compiled.tracks.empty() && !meets(compiled) && is_any_carried(compiled.plan.scene().contacts);
}
template <class T>
bool moves_anything(const CompiledLifecycle<T>& compiled) noexcept {
  const auto& emitters = compiled.turnover.emitters;
  const auto is_carried = [](const Emitter& emitter) { return emitter.motion.has_value(); };
  return moves_contacts(compiled) || std::any_of(emitters.begin(), emitters.end(), is_carried);
}

// The pose of what carries an emitter, if anything does.
template <class T>
const MovedPose* carrier_of(const CompiledLifecycle<T>& compiled, const LiveFollowers<T>& followers,
                            std::size_t emitter) noexcept {
  const auto& motion = compiled.turnover.emitters[emitter].motion;
  return motion ? &followers.poses[*motion] : nullptr;
}

template <class T>
struct LifecyclePlan<T>::Parts {
  Parts(Plan<T> plan, const Lifecycle& turnover, const Options& options)
      : compiled(std::move(plan), turnover, options.elsewhere.births),
        workspace(shape_of(compiled), options.memory),
        memory(options.memory) {}
  explicit Parts(const Parts& other)
      : compiled(other.compiled.plan.clone(), other.compiled.turnover, other.compiled.shared),
        workspace(shape_of(compiled), other.memory),
        memory(other.memory) {}

  CompiledLifecycle<T> compiled;
  LifecycleWorkspace<T> workspace;
  Memory memory;
  std::uint64_t drives = 0;  // number of calls of set_pose()
};

template <class T>
struct LiveWorkspace<T>::Parts {
  Parts(const LifecycleShape& shape, const Memory& memory) : workspace(shape, memory) {}

  LifecycleWorkspace<T> workspace;
};

}  // namespace dvdx
