// A scene whose particles springs join, stepped by several ranks: each holds the particles that it owns and those that its
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

// The kinds of numbers that a plan carries.
struct CarriedShape {
  bool meets = false;      // particles do: pulses of pairs and surfaces come first
  std::size_t driven = 0;  // those at the end, of what the caller may drive
};

// The numbers that a plan carries from step to step. Where it remembers accelerations: three of each particle of this rank's
// range, and those before and behind them, alike on all ranks. Else all are alike.
struct CarriedInRanges {
  bool remembers = false;
  std::size_t all = 0;  // particles of the scene
  std::vector<double> before{};
  std::vector<double> range{};
  std::vector<double> alike{};  // those behind, or all

  // As one rank's plan carries it, also called by one alone.
  void save(Sink& sink) const;
  // mine: this rank's range.
  void load(Source& source, std::size_t particles, const Run& mine, const CarriedShape& shape);
};

// The limit of the sub-steps of a scene that is one sheet, of which each rank looks at some rows (dvdx/partition.hpp: the
// frequency is the bound). None where it takes a plan of the whole: for other networks, in air, with skins, constraints or
// particles that meet, where springs tear, and where fewer sub-steps are asked for than are stable in any position. Called by
// all ranks, which get the same.
[[nodiscard]] std::optional<NetworkLimit> limit_by_rows(const SceneFile& file, Ranks& ranks);

template <class T>
class Split {
 public:
  // Throws SharedFault where a rank cannot make its part. limit: the whole scene's.
  Split(const SceneFile& file, const Engine& engine, Ranks& ranks, const NetworkLimit& limit);

  // report: null, or what this rank's own particles do to contacts. Called by all. Throws SharedFault where particles meet and
  // one has too many neighbours.
  void step(std::uint64_t steps, ContactReport* report, const ParallelFor& parallel);
  // Fills the state that is shown, weighed and written: ranges of the particles' numbers, one a rank. Called by all.
  void to_ranges(State<T>& range);
  // A state that a run goes on from, and what its plan carried then.
  void go_on(const State<T>& range, const CarriedInRanges& carried);
  [[nodiscard]] CarriedInRanges carried();
  [[nodiscard]] const CarriedShape& carried_shape() const noexcept { return carried_shape_; }

  // The springs of a network that are longer than `stretch` times their rest length: the scene's numbers of their ends, the
  // lesser first, ascending. Called by all, who are told the same.
  [[nodiscard]] std::vector<Pair> too_long(std::size_t network, double stretch) const;
  // Springs that joined the scene's particles do no more, and the sub-steps of the whole scene may be others since. Throws
  // SharedFault.
  void break_springs(std::size_t network, std::span<const Pair> torn);
  void take(const NetworkLimit& limit);

  // Each particle's rank. Called by all.
  [[nodiscard]] std::vector<std::uint32_t> owner() const;
  // The scene's number of each that the plan steps.
  [[nodiscard]] std::span<const std::uint32_t> particles() const noexcept { return part_.particles; }
  // s: of this rank's steps, in which it had nothing to do but to wait for what others tell.
  [[nodiscard]] double waited_seconds() const noexcept {
    return halo_.waited_seconds() + (meetings_ ? meetings_->waited_seconds() : 0);
  }
  // How all particles met in the last sub-step: nothing where this rank has none.
  [[nodiscard]] Meetings meetings() const noexcept { return plan_ ? plan_->meetings() : Meetings(); }

 private:
  [[nodiscard]] Plan<T> made(const State<T>& start) const;
  [[nodiscard]] std::optional<std::uint32_t> place_of(std::uint32_t number) const;
  [[nodiscard]] std::vector<double> carried_here(const CarriedInRanges& carried) const;

  Ranks& ranks_;
  Part part_;
  std::vector<std::uint32_t> own_;  // places in part_.particles
  std::size_t all_;                 // particles of the scene
  HaloExchange halo_;
  std::optional<MeetingsExchange> meetings_;  // where particles meet
  SceneFile file_;
  Layout layout_;
  Options options_;
  StateMemory<T> memory_;
  State<T> state_;
  std::optional<Plan<T>> plan_;  // none where a rank has no particles
  CarriedShape carried_shape_;
  RangeExchange ranges_;                  // of its own particles
  std::vector<std::uint32_t> by_number_;  // places in part_.particles in the order of their numbers, where springs tear
};

extern template class Split<float>;
extern template class Split<double>;

}  // namespace dvdx::tool
