// The sub-steps that a step is cut into: what springs, surfaces that turn, rods and particles that meet ask for.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"
#include "springs/frequencies.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "stability/sweep_error.hpp"
#include "topology/topology.hpp"

namespace dvdx {

// Which sub-steps a coupling takes of springs whose rates lie within bounds.
struct SubstepRule {
  SubstepRule() = default;
  SubstepRule(const Coupling& coupling, bool is_isolated);
  bool is_alone = false;  // a pair's own contribution, stable at any step where its particles have no other spring
  StableRange stable, energy_bounded;
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

// Since another network of the same particles was made.
enum class Changed {
  step,     // the step alone: rates and order stay
  springs,  // what the springs are made of, masses, and what is fixed: the order stays
};

class SubstepChoice {
 public:
  // Where the scene asks for fewer sub-steps than the start's springs allow. The eigenvalues that this takes are kept.
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::span<const Vec3> start, Unstable unstable);
  // The net that the scene is now, for sequential.
  [[nodiscard]] SweptNet swept_net(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] double substep() const noexcept { return step / chosen.substeps; }  // s
  // s: the step of these options, or the longest of its sign that takes no more than Coupling::most_substeps.
  [[nodiscard]] double step_within_limit(const Options& options) const noexcept;

  Coupling coupling;
  double step;                         // s
  std::optional<double> longest_step;  // s, where steps vary
  std::vector<double> w_of;            // 1/kg of each particle, 0 where fixed or kinematic
  std::shared_ptr<const Topology> topology;
  SubstepRule rule;
  RateBounds rates;
  Substeps chosen;

  [[nodiscard]] std::size_t particles() const noexcept { return w_of.size(); }
  // Whether the constant accelerations tell how many sub-steps there are.
  [[nodiscard]] bool depends_on_weight() const noexcept {
    return (rods_rate_ != 0 || meeting_rate_ != 0) && !coupling.substeps;
  }
  // rad/s, of rods that meet under the weight of all that may hang on them, and a twentieth of that of ropes that cross; 0
  // where there are none.
  [[nodiscard]] double rods_frequency() const noexcept { return rods_frequency_; }

 protected:
  SubstepChoice(const Scene& scene, const Options& options, std::span<const Vec3> start,
                std::shared_ptr<const Topology> topology_);
  // kept: of the same particles and springs, of which `changed` may differ, or null. net: left as it is, or the scene's where
  // the sub-steps take it.
  void choose(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const Vec3> start, const SubstepChoice* kept,
              Changed changed, std::optional<SweptNet>& net);
  // SweepEstimate::turning. net: that of the scene, if it has been made.
  [[nodiscard]] double turning(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net) const;
  // By the springs as they are now, by eigenvalues: a hundred steps' time.
  [[nodiscard]] NetworkLimit limit_of_springs(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] Substeps substeps_by(const HighestRates& highest, double h, std::optional<double> longest) const noexcept;
  [[nodiscard]] Substeps substeps_by(const HighestRates& highest) const noexcept {
    return substeps_by(highest, step, longest_step);
  }
  // Whether springs of such rates take the sub-steps that were chosen.
  [[nodiscard]] bool are_right(const RateBounds& bounds) const noexcept;
  // Takes the rates; the sub-steps as they were, where these are others now.
  std::optional<Substeps> take(const RateBounds& bounds) noexcept;
  // The rates as the scheme looks at them.
  [[nodiscard]] RateBounds seen(RateBounds bounds) const noexcept;

  [[nodiscard]] bool is_stack() const noexcept { return topology->walk() == Walk::stack; }  // of several sheets, stepped as one

  bool may_take_rho_ = false;  // another than was chosen, in place

 private:
  [[nodiscard]] bool are_grids(const Scene& scene) const;
  [[nodiscard]] bool hangs_free(const Scene& scene) const;
  [[nodiscard]] Frequencies find(const Scene& scene, std::span<const Vec3> start) const;

  std::optional<double> rho_of_whole_;
  double fastest_turn_ = 0;  // rad/s, of the surfaces that follow a motion
  double rods_rate_ = 0;     // 1/m: swept_rods_rate
  double rods_frequency_ = 0;
  double meeting_rate_ = 0;           // 1/s: sub-steps that particles that meet ask for
  std::optional<Frequencies> found_;  // of the springs as they are now, where they were asked for
};

}  // namespace dvdx
