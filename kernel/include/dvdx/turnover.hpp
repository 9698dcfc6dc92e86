// Emitters and removal of particles that come and go. Plain values in SI units; nothing is checked before compile().
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/values.hpp"

namespace dvdx {

struct Disc {
  Vec3 center{};         // m
  Vec3 normal{0, 1, 0};  // of any finite length > 0
  double radius = 1;     // m, >= 0
  bool operator==(const Disc&) const = default;
};

struct Box {
  Vec3 min{};  // m
  Vec3 max{};  // m, >= min on every axis
  bool operator==(const Box&) const = default;
};

// Makes particles one after another, 1/rate apart: the n-th (from 1) at the time start + n/rate, whatever the steps are. It
// moves in a straight line to the end of the step of its birth; forces and contacts act from the next step on. Its random
// numbers depend on (seed, n - 1) alone: Philox's four words of the counter (n - 1, group, 1), each times 2^-32.
// lifecycle/pass/emission_reference.hpp lists their uses.
struct Emitter {
  std::variant<Vec3, Disc, Box> shape = Vec3{};          // a point, or evenly over a disc or in a box
  double rate = 0;                                       // particles/s, >= 0
  double start = 0;                                      // s, finite: scene time at which the emitter begins to work
  double end = std::numeric_limits<double>::infinity();  // s, >= start: it makes rate (end - start) particles, rounded down
  Vec3 velocity{};                                       // m/s
  std::variant<double, Vec3> spread = 0.0;  // m/s, >= 0: the velocity gets a random addition, uniform in a ball of this radius
                                            // or in a box of these half sides
  double least_lifetime = std::numeric_limits<double>::infinity();  // s, > 0
  double most_lifetime = std::numeric_limits<double>::infinity();   // s, >= least: lifetimes are uniform between the two
  std::uint64_t seed = 0;
  // Index in Scene::motions of the motion that carries the emitter's place and aim. A birth then goes straight, as seen from
  // the motion, to the end of the step in which it is born, and has the motion's velocity there besides its own. None: it
  // rests.
  std::optional<std::size_t> motion{};
  bool operator==(const Emitter&) const = default;
};

// Particles are removed where normal . x < offset (m, for the unit normal).
struct Boundary {
  Vec3 normal{0, 1, 0};
  double offset = 0;
  bool operator==(const Boundary&) const = default;
};

enum class NotFinite { kept, removed };

// The order of the survivors after a removal.
//   kept  unchanged: all particles behind the first removed one move up
//   any   births take the places of removed particles, and the last particles fill the other holes. The assignment is the same
//         on every instruction set, for any threads, layout and steps a call. Each run of 16384 places gets its share of the
//         step's births for its first holes. Its holes before its new end are filled with the survivors behind that end. Births
//         left over take the free ends of runs, then follow behind all; ends still free are filled from the last particle. If
//         count and births exceed the capacity, all births follow behind (docs/scene.md).
enum class SurvivorOrder { kept, any };

// Conditions that are tested after every step; a particle whose age has reached its lifetime is removed too. A comparison with
// NaN is false: such a particle stays unless not_finite says otherwise.
struct Removal {
  std::vector<Boundary> boundaries{};  // at most 8
  std::optional<Box> outside{};        // removed where x < min or x > max on any axis
  NotFinite not_finite = NotFinite::kept;
  SurvivorOrder order = SurvivorOrder::kept;
  bool operator==(const Removal&) const = default;
};

struct Lifecycle {
  std::vector<Emitter> emitters{};
  Removal removal{};
  std::size_t capacity = 0;  // most particles that live at once; births beyond it are dropped and counted
  bool operator==(const Lifecycle&) const = default;
};

using Turnover [[deprecated("dvdx::Lifecycle")]] = Lifecycle;

enum class EmitterId : std::size_t {};  // into Lifecycle::emitters
inline EmitterId add_emitter(Lifecycle& turnover, Emitter emitter) {
  turnover.emitters.push_back(std::move(emitter));
  return EmitterId{turnover.emitters.size() - 1};
}

}  // namespace dvdx
