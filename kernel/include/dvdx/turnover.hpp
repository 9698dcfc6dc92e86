// Particles that come and go: what makes them, what removes them. Plain values in SI units; nothing is checked before
// compile().
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

// Makes particles one after another, 1/rate apart: the n-th of them (from 1) at the time start + n/rate, whatever the steps
// are. From there to the end of the step it moves in a straight line; forces and contacts act from the next step on. All that
// is drawn for it is a function of (seed, n - 1) alone: Philox's four words of the counter (n - 1, group, 1), each times 2^-32;
// lifecycle/pass/emission_reference.hpp says which number is for what.
struct Emitter {
  std::variant<Vec3, Disc, Box> shape = Vec3{};          // a point, or evenly over a disc or in a box
  double rate = 0;                                       // particles/s, >= 0
  double start = 0;                                      // s, finite: scene time from which on the emitter works
  double end = std::numeric_limits<double>::infinity();  // s, >= start: it makes rate (end - start) particles, rounded down
  Vec3 velocity{};                                       // m/s
  std::variant<double, Vec3> spread = 0.0;  // m/s, >= 0: to the velocity is added what lies evenly in a ball of this radius,
                                            // or in a box of these half sides
  double least_lifetime = std::numeric_limits<double>::infinity();  // s, > 0
  double most_lifetime = std::numeric_limits<double>::infinity();   // s, >= least: evenly between the two
  std::uint64_t seed = 0;
  // The motion of Scene::motions that carries it from where it is written, place, aim and all. A birth then goes straight, as
  // seen from the motion, to the end of the step in which it is born, and has the motion's velocity there besides its own.
  // None: it rests.
  std::optional<std::size_t> motion{};
  bool operator==(const Emitter&) const = default;
};

// Where particles are removed: where normal . x < offset (m, for the normal made a unit vector).
struct Boundary {
  Vec3 normal{0, 1, 0};
  double offset = 0;
  bool operator==(const Boundary&) const = default;
};

enum class NotFinite { kept, removed };

// In which order the others stand after some were removed.
//   kept  as before: all behind the first that goes are moved up
//   any   births take the places of what goes, and the last fill the holes that are left. Which takes which is the same on
//         every instruction set, for any threads, layout and steps a call. Each run of 16384 places has its share of the
//         step's births for its first holes; of its other holes those before its new end take the survivors behind it. Births
//         left over take the ends of runs, then follow behind all; ends still free are filled from the last. Where count and
//         births exceed the capacity all births follow behind: docs/scene.md
enum class SurvivorOrder { kept, any };

// Looked at after every step; a particle whose age has reached its lifetime is removed too. A comparison with what is not
// a number does not hold: such a particle stays unless not_finite says otherwise.
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
  std::size_t capacity = 0;  // particles: most that live at once. Births beyond it are dropped and counted.
  bool operator==(const Lifecycle&) const = default;
};

using Turnover [[deprecated("dvdx::Lifecycle")]] = Lifecycle;

enum class EmitterId : std::size_t {};  // of Lifecycle::emitters
inline EmitterId add_emitter(Lifecycle& turnover, Emitter emitter) {
  turnover.emitters.push_back(std::move(emitter));
  return EmitterId{turnover.emitters.size() - 1};
}

}  // namespace dvdx
