// The sub-steps of a step, as springs, turning surfaces, rods and meeting particles ask for them.
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

// The ranges of a coupling that determine the sub-steps for springs of given rates.
struct SubstepRule {
  SubstepRule() = default;
  SubstepRule(const Coupling& coupling, bool is_isolated);
  bool is_alone = false;  // accumulate, and no movable particle has two springs: stable at any step
  StableRange stable, energy_bounded;
};
struct Substeps {
  int substeps = 1;    // per step
  double rho = 0;      // of generalized alpha
  double longest = 0;  // s, of the step's sign: no sub-step of sweeps is longer, whatever the step
  Pace pace = Pace::even;
  bool is_safe = true;  // stable in any position
  bool operator==(const Substeps&) const = default;
  // Whether generalized alpha solves each spring by the same coefficients with both.
  [[nodiscard]] bool solves_alike(const Substeps& other) const noexcept {
    return rho == other.rho && longest == other.longest && pace == other.pace;
  }
};

// The options of a plan after its step has become `step`.
[[nodiscard]] Options with_other_step(const Options& options, double step);

// The changes since another network of the same particles was made.
enum class Changed {
  step,     // the step alone: rates and order stay
  springs,  // coefficients of springs, masses, fixed particles: the order stays
};

class SubstepChoice {
 public:
  // An error if the sub-steps exceed a limit, or are fewer than the start's springs allow. Keeps the eigenvalues it finds.
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::span<const Vec3> start, Unstable unstable);
  // The scene's net as it is now, for sequential.
  [[nodiscard]] SweptNet swept_net(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] double substep() const noexcept { return step / chosen.substeps; }  // s
  // s: the step of these options, or the longest of its sign that takes at most Coupling::most_substeps sub-steps.
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
  // Whether the number of sub-steps depends on the constant accelerations.
  [[nodiscard]] bool depends_on_weight() const noexcept {
    return (rods_rate_ != 0 || meeting_rate_ != 0) && !coupling.substeps;
  }
  // rad/s: of rods that meet, under all that may hang on them; of ropes that cross a twentieth of that; 0 if there are none.
  [[nodiscard]] double rods_frequency() const noexcept { return rods_frequency_; }

 protected:
  SubstepChoice(const Scene& scene, const Options& options, std::span<const Vec3> start,
                std::shared_ptr<const Topology> topology_);
  // kept: the choice for the same particles and springs, except for what `changed` names, or null. net: set to the scene's net
  // if the sub-steps need it, otherwise left as it is.
  void choose(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const Vec3> start, const SubstepChoice* kept,
              Changed changed, std::optional<SweptNet>& net);
  // SweepEstimate::turning. net: the scene's if it has been made.
  [[nodiscard]] double turning(const Scene& scene, std::span<const Vec3> start, const std::optional<SweptNet>& net) const;
  // The limit of the springs as they are now, by eigenvalues. Takes as long as a hundred steps.
  [[nodiscard]] NetworkLimit limit_of_springs(const Scene& scene, std::span<const Vec3> start) const;
  [[nodiscard]] Substeps substeps_by(const HighestRates& highest, double h, std::optional<double> longest) const noexcept;
  [[nodiscard]] Substeps substeps_by(const HighestRates& highest) const noexcept {
    return substeps_by(highest, step, longest_step);
  }
  // Whether springs of these rates take the chosen sub-steps.
  [[nodiscard]] bool keeps_substeps(const RateBounds& bounds) const noexcept;
  // Takes the rates. Returns the previous sub-steps if they have changed.
  std::optional<Substeps> take(const RateBounds& bounds) noexcept;
  // The rates as the scheme uses them.
  [[nodiscard]] RateBounds seen(RateBounds bounds) const noexcept;

  [[nodiscard]] bool is_stack() const noexcept { return topology->walk() == Walk::stack; }  // of several sheets, stepped as one

  bool may_take_rho_ = false;  // a change in place may take another rho than the chosen one

 private:
  [[nodiscard]] bool are_grids(const Scene& scene) const;
  [[nodiscard]] bool hangs_free(const Scene& scene) const;
  [[nodiscard]] Frequencies find(const Scene& scene, std::span<const Vec3> start) const;

  std::optional<double> rho_of_whole_;
  double fastest_turn_ = 0;  // rad/s, of the surfaces that follow a motion
  double rods_rate_ = 0;     // 1/m: swept_rods_rate
  double rods_frequency_ = 0;
  double meeting_rate_ = 0;           // 1/s: sub-steps that meeting particles ask for
  std::optional<Frequencies> found_;  // of the springs as they are now, once asked for
};

}  // namespace dvdx
