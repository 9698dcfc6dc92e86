// The joints of a scene's particles, compiled: springs in the form that a pass walks, constraints, the order in which particles
// stand while they are stepped, and the sub-steps that the springs ask for. Independent of the forces.
// Several plans may share one; a plan that alone holds it changes it in place (plan/in_place.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "air/compiled_air.hpp"
#include "constraint/constraints.hpp"
#include "dvdx/plan.hpp"
#include "meet/meet_rules.hpp"
#include "skin/balls.hpp"
#include "springs/grid_rates.hpp"
#include "springs/limit.hpp"
#include "springs/network_forms.hpp"
#include "springs/sweep/colours_in_place.hpp"
#include "springs/sweep/strands_in_place.hpp"
#include "stability/sweep_error.hpp"
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
struct TellingOrder {
  std::vector<UnitRange> told, inside;
  std::vector<std::uint32_t> records;  // of a list in sweeps: where each particle's begins
};

struct FixedParticle {
  std::uint32_t particle = 0, element = 0;
  std::optional<std::uint32_t> motion{};  // that carries it
  std::uint32_t group = 0, index = 0;     // of Scene::kinematic, and in its list
  Vec3 place{};                           // m: where it is carried from, in the world
};

// Which sub-steps a coupling takes of springs whose rates lie within bounds.
struct SubstepRule {
  SubstepRule() = default;
  SubstepRule(const Coupling& coupling, bool is_isolated);
  bool is_alone = false;  // a pair's own contribution, stable at any step where its particles have no other spring
  StableRange stable, calm;
};
struct Substeps {
  int substeps = 1;    // a step
  double rho = 0;      // of generalized alpha
  double longest = 0;  // s, of the step's sign: no sub-step of sweeps is longer, however long a step
  Pace pace = Pace::even;
  bool is_safe = true;  // in any position
  bool operator==(const Substeps&) const = default;
  // Whether generalized alpha solves each spring by the same coefficients.
  [[nodiscard]] bool solves_alike(const Substeps& other) const noexcept {
    return rho == other.rho && longest == other.longest && pace == other.pace;
  }
};

// The options of a plan whose step becomes another.
[[nodiscard]] Options with_other_step(const Options& options, double step);

// Since other joints of the same particles were made.
enum class Changed {
  step,     // the step alone: rates and order stay
  springs,  // what the springs are made of, masses, and what is fixed: the order stays
};

template <class T>
class Joints {
 public:
  // The scene and the options have been checked; start: the particles' positions.
  Joints(const Scene& scene, const Options& options, std::span<const Vec3> start);
  // The same particles joined by the same springs, of which `changed` may differ.
  Joints(const Scene& scene, const Options& options, std::span<const Vec3> start, const Joints& kept, Changed changed);
  Joints(const Joints&) = delete;
  Joints& operator=(const Joints&) = delete;

  // Where the scene asks for fewer sub-steps than the start's springs allow. The eigenvalues that this takes are kept.
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::span<const Vec3> start, Unstable unstable);
  // The limit by the springs as they are now, by eigenvalues: a hundred steps' time.
  [[nodiscard]] NetworkLimit limit(const Scene& scene, std::span<const Vec3> start) const;
  // The net that the scene is now, for sequential.
  [[nodiscard]] SweptNet swept_net(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] double substep() const noexcept { return step / chosen.substeps; }  // s
  // s: the step of these options, or the longest of its sign that takes no more than Coupling::most_substeps.
  [[nodiscard]] double step_within_limit(const Options& options) const noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept;
  [[nodiscard]] bool is_damped() const noexcept { return is_damped_; }
  // How often a pulse applies the damping to what came before: it takes as many passes more over the springs that damp.
  [[nodiscard]] std::size_t damping_passes() const noexcept { return is_damped_ ? dvdx::damping_passes(coupling) : 0; }

  Coupling coupling;
  double step;                         // s
  std::optional<double> longest_step;  // s, where steps vary
  std::size_t springs = 0;
  std::vector<double> w_of;  // 1/kg of each particle, 0 where fixed or kinematic
  Splitting splitting;
  SubstepRule rule;
  RateBounds rates;
  Substeps chosen;
  std::shared_ptr<const Topology> topology;
  const ParticleOrder& order;
  std::uint64_t order_fingerprint = 0;  // of generalized alpha, whose accelerations stand in that order from step to step
  std::vector<FixedParticle> fixed;     // and kinematic ones, by element
  const T* w = nullptr;                 // the working column of inverse masses
  NetworkForm<T> form;
  std::optional<Constraints<T>> constraints;
  std::unique_ptr<Air<T>> air;         // or null
  std::unique_ptr<Balls<T>> balls;     // or null
  std::unique_ptr<MeetRules<T>> meet;  // or null
  TellingOrder telling;                // empty where nothing is told

  [[nodiscard]] std::size_t particles() const noexcept { return w_of.size(); }
  // So many of them.
  [[nodiscard]] bool are_worth_threads(std::size_t count) const noexcept {
    return count >= (meet != nullptr && meet->are_balls() ? parallel_from_of_balls : parallel_from);
  }
  // Whether something acts at the end of each sub-step, after its last flow.
  [[nodiscard]] bool closes_substeps() const noexcept {
    return constraints.has_value() || balls != nullptr || meet != nullptr || closes_in_whole_;
  }
  // Whether the constant accelerations tell how many sub-steps there are.
  [[nodiscard]] bool depends_on_weight() const noexcept {
    return (rods_rate_ != 0 || meeting_rate_ != 0) && !coupling.substeps;
  }
  // rad/s, of rods that meet under the weight of all that may hang on them, and a twentieth of that of ropes that cross; 0
  // where there are none.
  [[nodiscard]] double rods_frequency() const noexcept { return rods_frequency_; }
  // Changes in place, of the only owner (plan/plan_parts.hpp): of grids that are stepped as one, or of a list by any scheme
  // but accumulate, without constraints. The scene is the one that the joints were made of, but for the change.
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
  [[nodiscard]] const ListRates* list_rates() const noexcept { return by_spring_ ? &by_spring_->rates : nullptr; }
  // 1/kg of a particle, 0 where it is fixed: false, and nothing is changed, where it asks for other sub-steps, or where other
  // springs would be left out between fixed particles.
  [[nodiscard]] bool set_inverse_mass(const Scene& scene, std::size_t particle, double w) noexcept;
  // All that networks[network] joins such pairs by, or none. A grid takes memory for the first that begins in a row.
  [[nodiscard]] bool break_springs(const Scene& scene, std::size_t network, std::span<const Pair> pairs);
  // To what a grid, or networks[network] of the scene, has now; before: what it had. The same sub-steps, and springs where
  // there were some: else false, and nothing is changed.
  [[nodiscard]] bool set_stiffness(const Grid& grid);
  [[nodiscard]] bool set_stiffness(const Scene& scene, std::size_t network, const SpringsStiffness& before) noexcept;
  // Likewise its zero_length: false in sweeps, which have none.
  [[nodiscard]] bool set_zero_length(const Scene& scene, std::size_t network, const Scalars& before) noexcept;

 private:
  Joints(const Scene& scene, const Options& options, std::span<const Vec3> start, const Joints* kept, Changed changed,
         const JoinedScene& joined);

  // net: left as it is, or the scene's where the sub-steps take it.
  void choose(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const Vec3> start, const Joints* kept,
              Changed changed, std::optional<SweptNet>& net);
  void choose_line_forces(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net);
  [[nodiscard]] double turning(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net) const;
  void make_fixed(const Scene& scene, std::span<const Vec3> start);
  void make_inverse_masses();
  void make_form(std::span<const JoinedPair> pairs, std::span<const Vec3> start, const SteppedGrid& stepped);
  void make_telling_order(const Exchange& exchange);

  [[nodiscard]] bool set_rates(std::size_t particle, double w) noexcept;
  struct Sheet {
    std::size_t number = 0, first = 0, particles = 0;
  };
  [[nodiscard]] Sheet sheet_of(std::size_t particle) const noexcept;
  [[nodiscard]] std::span<const double> w_of_sheet(std::size_t number) const noexcept;
  void set_swept(std::uint32_t spring) noexcept;
  [[nodiscard]] bool changes_left_out(std::size_t particle, double w) const noexcept;
  void set(std::size_t network, std::span<const GridSpring> which, SpringIs state) noexcept;
  [[nodiscard]] bool break_grid(const Scene& scene, std::size_t network, std::span<const GridSpring> torn);
  [[nodiscard]] bool break_list(const Scene& scene, std::size_t network, std::span<const Pair> pairs);
  [[nodiscard]] RateBounds rates_now() const noexcept;
  [[nodiscard]] bool are_right(const RateBounds& bounds) const noexcept;
  void take(const RateBounds& bounds) noexcept;
  void take_scheme() noexcept;
  [[nodiscard]] Frequencies find(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] Substeps substeps_by(const HighestRates& highest, double h, std::optional<double> longest) const noexcept;
  [[nodiscard]] Substeps substeps_by(const HighestRates& highest) const noexcept {
    return substeps_by(highest, step, longest_step);
  }
  [[nodiscard]] NetworkInput input(std::span<const JoinedPair> pairs) const;

  // The strands of a list that is swept in such, or null.
  [[nodiscard]] StrandsForm<T>* strands_of_list() noexcept;
  [[nodiscard]] bool sweeps_list() const noexcept;

  bool is_damped_ = false;
  bool has_tethers_ = false;
  bool is_stack_ = false;  // of several sheets, stepped as one
  std::optional<double> rho_of_whole_;
  const SweptPart* sweeps_ = nullptr;
  const std::optional<ListSheet>& list_sheet_;  // of a list in sweeps that is one
  bool closes_in_whole_ = false;
  double fastest_turn_ = 0;  // rad/s, of the surfaces that follow a motion
  double rods_rate_ = 0;     // 1/m: swept_rods_rate
  double rods_frequency_ = 0;
  double meeting_rate_ = 0;        // 1/s: sub-steps that particles that meet ask for
  std::vector<GridRates> by_row_;  // of each sheet
  struct ListInPlace {
    ListRates rates;
    std::optional<GraphLanes<T>> lanes;
    std::optional<ColoursInPlace<T>> colours;
    std::optional<StrandsInPlace<T>> strands;
  };
  std::unique_ptr<ListInPlace> by_spring_;
  Memory memory_;
  std::optional<Frequencies> found_;  // of the springs as they are now, where they were asked for
  Columns<T> columns_;
};

extern template class Joints<float>;
extern template class Joints<double>;

}  // namespace dvdx
