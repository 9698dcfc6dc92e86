// A scene's network, compiled: springs in the form that a pass walks, constraints, the order in which particles
// stand while they are stepped, and the sub-steps that the springs ask for. Independent of the forces.
// Several plans may share one; a plan that alone holds it changes it in place (plan/in_place.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "air/compiled_air.hpp"
#include "constraint/constraints.hpp"
#include "dvdx/plan.hpp"
#include "meet/meet_rules.hpp"
#include "plan/substeps.hpp"
#include "skin/balls.hpp"
#include "springs/frequencies.hpp"
#include "springs/network_forms.hpp"
#include "springs/network_rates.hpp"
#include "topology/topology.hpp"
#include "work/columns.hpp"

namespace dvdx {

// Particles that one call of the caller's parallel_for takes: a fixed number, so that nothing depends on threads.
inline constexpr std::size_t particles_per_task = 4096;
// Below this many particles, waking a thread for every pulse and flow costs more than it saves.
inline constexpr std::size_t parallel_from = 16384;
// Balls that meet have several times as much to do in each.
inline constexpr std::size_t parallel_from_of_balls = 4096;

// Units of a part of a larger scene: rows of a grid or slices of a list. Those that hold a particle which other parts are told
// of come first.
struct UnitRange {
  std::size_t from = 0, to = 0;
};
struct HaloSchedule {
  std::vector<UnitRange> outer, inside;
  std::vector<std::uint32_t> records;  // of a list in sweeps: where each particle's begins
};

struct FixedParticle {
  std::uint32_t particle = 0, element = 0;
  std::optional<std::uint32_t> motion{};  // that carries it
  std::uint32_t group = 0, index = 0;     // of Scene::kinematic, and in its list
  Vec3 place{};                           // m: where it is carried from, in the world
};

template <class T>
class CompiledNetwork : public SubstepChoice {
 public:
  // The scene and the options have been checked; start: the particles' positions.
  CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start);
  // The same particles joined by the same springs, of which `changed` may differ.
  CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start, const CompiledNetwork& kept,
                  Changed changed);
  CompiledNetwork(const CompiledNetwork&) = delete;
  CompiledNetwork& operator=(const CompiledNetwork&) = delete;

  // The limit by the springs as they are now, by eigenvalues: a hundred steps' time.
  [[nodiscard]] NetworkLimit limit(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] std::size_t bytes() const noexcept;
  [[nodiscard]] bool is_damped() const noexcept { return is_damped_; }
  // How often a pulse applies the damping to what came before: it takes as many passes more over the springs that damp.
  [[nodiscard]] std::size_t damping_passes() const noexcept { return is_damped_ ? dvdx::damping_passes(coupling) : 0; }

  std::size_t springs = 0;
  Splitting splitting;
  const ParticleOrder& order;           // of the topology
  std::uint64_t order_fingerprint = 0;  // of generalized alpha, whose accelerations stand in that order from step to step
  std::vector<FixedParticle> fixed;     // and kinematic ones, by element
  const T* w = nullptr;                 // the working column of inverse masses
  NetworkForm<T> form;
  std::optional<Constraints<T>> constraints;
  std::unique_ptr<Air<T>> air;         // or null
  std::unique_ptr<Balls<T>> balls;     // or null
  std::unique_ptr<MeetRules<T>> meet;  // or null
  HaloSchedule halo;                   // empty where nothing is sent

  // So many of them.
  [[nodiscard]] bool are_worth_threads(std::size_t count) const noexcept {
    return count >= (meet != nullptr && meet->are_balls() ? parallel_from_of_balls : parallel_from);
  }
  // Whether something acts at the end of each sub-step, after its last flow.
  [[nodiscard]] bool closes_substeps() const noexcept {
    return constraints.has_value() || balls != nullptr || meet != nullptr || closes_in_whole_;
  }
  // Changes in place, of the only owner (plan/plan_parts.hpp): of grids that are stepped as one, or of a list by any scheme
  // but accumulate, without constraints. the scene is the one that the network was made of, but for the change.
  [[nodiscard]] bool can_change_in_place() const noexcept;
  // Whether the springs' coefficients are those of another step too, and sums tell its sub-steps. options: with that step.
  [[nodiscard]] bool can_change_step(const Options& options) const noexcept;
  // Takes memory for take_step() first. After it the springs' coefficients are those of the step before until take_step().
  void reserve_step(const Scene& scene, std::span<const Vec3> start);
  void change_step(const Options& options) noexcept;
  // before: `chosen` as it was.
  void take_step(const Substeps& before) noexcept;
  // Makes the rates, which look at the neighbourhood of one particle alone, at the first of these changes.
  void reserve_rates(const Scene& scene, std::span<const Vec3> start);
  // The rates of a list, after reserve_rates(); else null.
  [[nodiscard]] const ListRates* list_rates() const noexcept { return network_rates_.list(); }
  // 1/kg of a particle, 0 where it is fixed: false, and nothing is changed, where it asks for other sub-steps, or where other
  // springs would be left out between fixed particles.
  [[nodiscard]] bool set_inverse_mass(std::size_t particle, double w) noexcept;
  // All that networks[network] joins such pairs by, or none. A grid takes memory for the first that begins in a row.
  [[nodiscard]] bool break_springs(const Scene& scene, std::size_t network, std::span<const Pair> pairs);
  // To what the scene's grid, or networks[network], has now; before: what it had. The same sub-steps, and springs where
  // there were some: else false, and nothing is changed.
  [[nodiscard]] bool set_stiffness(const Scene& scene);
  [[nodiscard]] bool set_stiffness(const Scene& scene, std::size_t network, const SpringsStiffness& before) noexcept;
  // Likewise its zero_length: false in sweeps, which have none.
  [[nodiscard]] bool set_zero_length(const Scene& scene, std::size_t network, const Scalars& before) noexcept;

 private:
  CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start, const CompiledNetwork* kept,
                  Changed changed, const JoinedScene& joined);

  void choose_line_forces(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net);
  void make_fixed(const Scene& scene, std::span<const Vec3> start);
  void make_inverse_masses();
  void make_halo_schedule(const Exchange& exchange);

  template <class Put, class TakeBack>
  [[nodiscard]] bool set_rates(const Put& put, const TakeBack& take_back) noexcept;
  template <class Put, class TakeBack>
  [[nodiscard]] bool set_springs(const Put& put, const TakeBack& take_back) noexcept;
  void take_rates(const RateBounds& bounds) noexcept;
  [[nodiscard]] bool break_grid(const Scene& scene, std::size_t network, std::span<const Pair> pairs);
  [[nodiscard]] bool break_list(const Scene& scene, std::size_t network, std::span<const Pair> pairs);
  [[nodiscard]] NetworkInput input(std::span<const JoinedPair> pairs) const;

  [[nodiscard]] bool sweeps_list() const noexcept;

  bool is_damped_ = false;
  bool has_tethers_ = false;
  const SweptPart* sweeps_ = nullptr;
  bool closes_in_whole_ = false;
  NetworkRates network_rates_;  // once something is changed in place
  Memory memory_;
  Columns<T> columns_;
};

extern template class CompiledNetwork<float>;
extern template class CompiledNetwork<double>;

}  // namespace dvdx
