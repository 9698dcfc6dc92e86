// A scene's network, compiled: springs in the form that a pass walks, constraints, the order of the particles in the working
// columns, and the sub-steps that the springs ask for. Only the steady part of the forces and of the wind matters to it.
// Several plans may share one; its only owner changes it in place (plan/in_place.hpp).
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

// Particles of one task. The number is fixed, so that no result depends on the number of threads.
inline constexpr std::size_t particles_per_task = 4096;
// Below this many particles, waking a thread for every pulse and flow costs more than it saves.
inline constexpr std::size_t parallel_from = 16384;
// Meeting balls take several times as much work per particle.
inline constexpr std::size_t parallel_from_of_balls = 4096;

// Units of a part of a larger scene: rows of a grid or slices of a list. Those with a particle that is sent to other parts
// come first.
struct UnitRange {
  std::size_t from = 0, to = 0;
};
struct HaloSchedule {
  std::vector<UnitRange> outer, inside;
  std::vector<std::uint32_t> records;  // of a list in sweeps: the offset of each particle's record
};

struct FixedParticle {
  std::uint32_t particle = 0, element = 0;
  std::optional<std::uint32_t> motion{};  // the motion that carries it
  std::uint32_t group = 0, index = 0;     // of Scene::kinematic, and in its list
  Vec3 place{};                           // m: its start in the world, from which the motion carries it
};

template <class T>
class CompiledNetwork : public SubstepChoice {
 public:
  // The scene and the options have been checked; start: the particles' positions.
  CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start);
  // The same particles and springs as in `kept`, except for what `changed` names.
  CompiledNetwork(const Scene& scene, const Options& options, std::span<const Vec3> start, const CompiledNetwork& kept,
                  Changed changed);
  CompiledNetwork(const CompiledNetwork&) = delete;
  CompiledNetwork& operator=(const CompiledNetwork&) = delete;

  // The limit of the springs as they are now, by eigenvalues. Takes as long as a hundred steps.
  [[nodiscard]] NetworkLimit limit(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] std::size_t bytes() const noexcept;
  [[nodiscard]] bool is_damped() const noexcept { return is_damped_; }
  // The number of times that a pulse applies the damping's matrix. Each takes one more pass over the springs that damp.
  [[nodiscard]] std::size_t damping_passes() const noexcept { return is_damped_ ? dvdx::damping_passes(coupling) : 0; }

  std::size_t springs = 0;
  Splitting splitting;
  const ParticleOrder& order;           // of the topology
  std::uint64_t order_fingerprint = 0;  // of generalized alpha, which keeps accelerations in that order from step to step
  std::vector<FixedParticle> fixed;     // and kinematic particles, by element
  const T* w = nullptr;                 // the working column of inverse masses
  NetworkForm<T> form;
  std::optional<Constraints<T>> constraints;
  std::unique_ptr<Air<T>> air;         // or null
  std::unique_ptr<Balls<T>> balls;     // or null
  std::unique_ptr<MeetRules<T>> meet;  // or null
  HaloSchedule halo;                   // empty if nothing is sent

  [[nodiscard]] bool are_worth_threads(std::size_t count) const noexcept {
    return count >= (meet != nullptr && meet->are_balls() ? parallel_from_of_balls : parallel_from);
  }
  // Whether something acts at the end of each sub-step, after its last flow.
  [[nodiscard]] bool closes_substeps() const noexcept {
    return constraints.has_value() || balls != nullptr || meet != nullptr || closes_in_whole_;
  }
  // Changes in place, by the only owner (plan/plan_parts.hpp). They need grids that are stepped as one, or a list by any
  // scheme but accumulate, and no constraints. scene: the one that the network was made of, except for the change.
  [[nodiscard]] bool can_change_in_place() const noexcept;
  // Whether the step may change in place: sums must determine its sub-steps, and a swept grid must keep its springs'
  // coefficients. options: with the new step.
  [[nodiscard]] bool can_change_step(const Options& options) const noexcept;
  // Allocates for take_step(). After change_step() the springs keep the coefficients of the previous step until take_step().
  void reserve_step(const Scene& scene, std::span<const Vec3> start);
  void change_step(const Options& options) noexcept;
  // before: `chosen` before change_step().
  void take_step(const Substeps& before) noexcept;
  // Makes the rates at the first change in place. Their updates look only at the neighbourhood of one particle.
  void reserve_rates(const Scene& scene, std::span<const Vec3> start);
  // The rates of a list after reserve_rates(), otherwise null.
  [[nodiscard]] const ListRates* list_rates() const noexcept { return network_rates_.list(); }
  // w: 1/kg, 0 if the particle is fixed. Returns false and changes nothing if the springs would ask for other sub-steps, or if
  // other springs would be left out between fixed particles.
  [[nodiscard]] bool set_inverse_mass(std::size_t particle, double w) noexcept;
  // Tears every spring of networks[network] between these pairs, or none. A grid allocates at the first torn spring of a row.
  [[nodiscard]] bool break_springs(const Scene& scene, std::size_t network, std::span<const Pair> pairs);
  // Sets the stiffness that the scene's grid, or networks[network], has now. before: its previous values. Returns false and
  // changes nothing if the sub-steps would change, or if springs or damping would come or go.
  [[nodiscard]] bool set_stiffness(const Scene& scene);
  [[nodiscard]] bool set_stiffness(const Scene& scene, std::size_t network, const SpringsStiffness& before) noexcept;
  // Sets its zero_length likewise. Returns false in sweeps, which have none.
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
  NetworkRates network_rates_;  // made at the first change in place
  Memory memory_;
  Columns<T> columns_;
};

extern template class CompiledNetwork<float>;
extern template class CompiledNetwork<double>;

}  // namespace dvdx
