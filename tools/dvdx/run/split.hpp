// A scene of particles joined by springs, stepped by several ranks: each holds the particles that it owns and those that its
// springs reach (dvdx/partition.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/meet.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/ranks.hpp"
#include "files/byte_stream.hpp"
#include "ranks/halo_exchange.hpp"
#include "ranks/meetings_exchange.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/scene_file.hpp"
#include "state/engine.hpp"
#include "state/state_memory.hpp"

namespace dvdx::tool {

// Which numbers a plan carries.
struct CarriedShape {
  bool meets = false;      // particles meet: pulses of pairs and surfaces come first
  std::size_t driven = 0;  // numbers at the end, of everything that the caller may drive
};

// The numbers that a plan carries from step to step. If it remembers accelerations, `range` has three of each particle of this
// rank's range, and `before` and `alike` are the same on all ranks. Otherwise all numbers are in `alike`.
struct CarriedInRanges {
  bool remembers = false;
  std::size_t all = 0;  // particles of the scene
  std::vector<double> before{};
  std::vector<double> range{};
  std::vector<double> alike{};  // the numbers behind the range, or all

  // Writes the numbers as the plan of one rank carries them. One rank alone calls it too.
  void save(Sink& sink) const;
  // mine: this rank's range.
  void load(Source& source, std::size_t particles, const Run& mine, const CarriedShape& shape);
};

// Returns the sub-step limit of a scene that is one sheet; each rank computes the rates of some rows (dvdx/partition.hpp: the
// frequency is the bound). Returns none if the limit needs a plan of the whole scene: other networks, air, skins, constraints,
// particles that meet, springs that are broken or tear, or fewer sub-steps asked for than are stable in any position. All ranks
// must call it, and get the same.
[[nodiscard]] std::optional<NetworkLimit> limit_by_rows(const SceneFile& file, Ranks& ranks);

template <class T>
class Split {
 public:
  // Throws SharedFault if a rank cannot make its part. limit: of the whole scene.
  Split(const SceneFile& file, const Engine& engine, Ranks& ranks, const NetworkLimit& limit);

  // report: null, or gets the effect of this rank's own particles on contacts. All ranks must call it. Throws SharedFault if
  // particles meet and one has too many neighbours.
  void step(std::uint64_t steps, ContactReport* report, const ParallelFor& parallel);
  // Fills the state that the observer sees: this rank's range of particles. All ranks must call it.
  void to_ranges(State<T>& range);
  // Resumes from a state and from the numbers that its plan carried then.
  void go_on(const State<T>& range, const CarriedInRanges& carried);
  [[nodiscard]] CarriedInRanges carried();
  [[nodiscard]] const CarriedShape& carried_shape() const noexcept { return carried_shape_; }

  // Returns the springs of a network that are longer than `stretch` times their rest length, ascending, as pairs of the scene's
  // numbers, lesser first. All ranks must call it, and get the same.
  [[nodiscard]] std::vector<Pair> too_long(std::size_t network, double stretch) const;
  // Removes springs between the scene's particles. The sub-steps of the whole scene may then change: take() applies them. Both
  // throw SharedFault.
  void break_springs(std::size_t network, std::span<const Pair> torn);
  void take(const NetworkLimit& limit);

  // Returns each particle's rank. All ranks must call it.
  [[nodiscard]] std::vector<std::uint32_t> owner() const;
  // Returns the scene's number of each particle that the plan steps.
  [[nodiscard]] std::span<const std::uint32_t> particles() const noexcept { return part_.particles; }
  // Returns the time in s during which this rank only waited for messages of others.
  [[nodiscard]] double waited_seconds() const noexcept {
    return halo_.waited_seconds() + (meetings_ ? meetings_->waited_seconds() : 0);
  }
  // Returns how all particles met in the last sub-step, or zeros if this rank has no particles.
  [[nodiscard]] Meetings meetings() const noexcept { return plan_ ? plan_->meetings() : Meetings(); }

 private:
  [[nodiscard]] Plan<T> made(const State<T>& start) const;
  [[nodiscard]] std::optional<std::uint32_t> place_of(std::uint32_t number) const;
  [[nodiscard]] std::vector<double> carried_here(const CarriedInRanges& carried) const;

  Ranks& ranks_;
  Part part_;
  std::vector<std::uint32_t> own_;  // indices in part_.particles
  std::size_t all_;                 // particles of the scene
  HaloExchange halo_;
  std::optional<MeetingsExchange> meetings_;  // if particles meet
  SceneFile file_;
  Layout layout_;
  Options options_;
  StateMemory<T> memory_;
  State<T> state_;
  std::optional<Plan<T>> plan_;  // none if a rank has no particles
  CarriedShape carried_shape_;
  RangeExchange ranges_;                  // of its own particles
  std::vector<std::uint32_t> by_number_;  // indices in part_.particles in the order of their numbers, if springs tear
};

extern template class Split<float>;
extern template class Split<double>;

}  // namespace dvdx::tool
