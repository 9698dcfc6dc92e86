// A scene whose particles springs join, stepped by several ranks: each holds the particles that it owns and those that its
// springs reach (dvdx/partition.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/ranks.hpp"
#include "run/engine.hpp"
#include "run/state_memory.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Tells the particles of a halo, between the pulses of a step.
class HaloExchange {
 public:
  HaloExchange(Ranks& ranks, const Part& part);
  HaloExchange(const HaloExchange&) = delete;
  HaloExchange& operator=(const HaloExchange&) = delete;

  // Valid as long as this.
  [[nodiscard]] Exchange exchange() noexcept {
    return {.context = this,
            .start = start,
            .finish = finish,
            .is_told = part_.is_told.data(),
            .is_own = part_.is_own.data(),
            .pulses_per_telling = part_.pulses_per_telling};
  }
  // s: that others were waited for.
  [[nodiscard]] double waited_seconds() const noexcept { return waited_seconds_; }

 private:
  static void start(void* context, const HaloColumns& columns) noexcept;
  static void finish(void* context, const HaloColumns& columns) noexcept;
  template <class A>
  void send(const HaloColumns& columns) noexcept;
  template <class A>
  void receive(const HaloColumns& columns) noexcept;

  struct Buffers {
    std::vector<double> sent, received;  // room for three numbers a particle in either precision
  };
  Ranks& ranks_;
  const Part& part_;
  std::vector<Buffers> buffers_;
  double waited_seconds_ = 0;
};

template <class T>
class Split {
 public:
  // Throws SharedFault where a rank cannot make its part. limit: the whole scene's.
  Split(const SceneFile& file, const Engine& engine, Ranks& ranks, const NetworkLimit& limit);

  // report: null, or what this rank's own particles do to contacts.
  void step(std::uint64_t steps, ContactReport* report, const ParallelFor& parallel);
  // To the first rank, which alone has a whole state.
  void gather(State<T>& whole);
  // From the first rank: a state that a run goes on from, and what its plan carried then.
  void go_on(const State<T>& whole, std::vector<double>& carried);
  // What the whole scene's plan would carry, on the first rank.
  [[nodiscard]] std::vector<double> carried();

  // Each particle's rank, on the first one.
  [[nodiscard]] std::vector<std::uint32_t> owner() const;
  // The scene's number of each that the plan steps.
  [[nodiscard]] std::span<const std::uint32_t> particles() const noexcept { return part_.particles; }
  // s: of this rank's steps, in which it had nothing to do but to wait for what others tell.
  [[nodiscard]] double waited_seconds() const noexcept { return halo_.waited_seconds(); }

 private:
  [[nodiscard]] std::vector<const std::array<Column<T>, 3>*> columns(const State<T>& state) const;
  [[nodiscard]] std::vector<double> carried_here(std::span<const double> whole) const;

  Ranks& ranks_;
  Part part_;
  std::vector<std::uint32_t> own_;  // places in part_.particles
  std::size_t all_;                 // particles of the scene
  HaloExchange halo_;
  SceneFile file_;
  StateMemory<T> memory_;
  State<T> state_;
  std::optional<Plan<T>> plan_;                    // none where a rank has no particles
  std::vector<std::vector<std::uint32_t>> owned_;  // of the first rank: numbers of each rank's own particles, in their order
  std::vector<T> buffer_;
};

extern template class Split<float>;
extern template class Split<double>;

}  // namespace dvdx::tool
