// A scene's constraints, compiled and rounded: colours of constraints that can be solved side by side. Immutable.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "constraint/constraint.hpp"
#include "dvdx/scene.hpp"
#include "topology/particle_order.hpp"
#include "work/columns.hpp"

namespace dvdx {

// A scene's constrained pairs as springs without stiffness: the particles that a working order must keep near each other.
std::vector<JoinedPair> constrained_pairs(const Scene& scene);

// m/s^2: the sum of all constant forces.
Vec3 constant_acceleration(const Scene& scene);

// 1/m: the largest square of a frequency, over gravity, of rods that sweeps solve because they meet others, under all that may
// hang on them. Ropes that cross count a four hundredth of theirs. 0 if there are none: lone chains take sub-steps of their
// own. w: 1/kg of each particle, 0 where fixed.
double swept_rods_rate(const Scene& scene, std::span<const Vec3> start, std::span<const double> w);
// The number of sub-steps that they need in a step of h seconds at this frequency, rad/s; at most 1024.
int substeps_of_rods(double frequency, double h) noexcept;

// The number of elements of the columns in which the passes leave their sums.
struct ConstraintShape {
  std::size_t pairs = 0, chains = 0, limits = 0, lines = 0;
  bool has_lone_chains = false;
  bool operator==(const ConstraintShape&) const = default;
};

// Constraints of one kind that share no particle that can move, side by side.
struct ConstraintColour {
  // limit: chains of `at_most` that share no particle with another constraint; crossing: an `at_most` that does.
  enum class Kind : std::uint8_t { equal, at_most, at_least, chain, limit, crossing, line };
  Kind kind = Kind::equal;
  std::size_t from = 0, to = 0;  // in the columns of its kind's terms, multiples of 16; for chains and limits, bundles
};

// A particle that is held at a point, by its element.
template <class T>
struct HeldPoint {
  std::uint32_t element = 0;
  std::array<T, 3> at{};
};

// The passes' terms; columns of sums are null until a workspace's are put in.
template <class T>
struct ConstraintTerms {
  PairTerms<T> pairs;
  ChainTerms<T> chains;
  LimitTerms<T> limits;
  LineTerms<T> lines;
};

struct OneConstraint;    // a constraint, its ends as elements
struct ConstraintBlock;  // constraints that are solved together

template <class T>
class Constraints {
 public:
  // The scene has been checked; start: the particles' positions; w: 1/kg of each particle, 0 where fixed; h: s, a sub-step.
  Constraints(const Scene& scene, std::span<const Vec3> start, std::span<const double> w, const ParticleOrder& order, double h,
              const Memory& memory);
  Constraints(const Constraints&) = delete;
  Constraints& operator=(const Constraints&) = delete;

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::size_t chains() const noexcept { return chain_count_; }
  [[nodiscard]] const std::vector<ConstraintColour>& colours() const noexcept { return colours_; }
  // Chains that share no particle with another constraint; empty where there are none.
  [[nodiscard]] const ConstraintColour& lone_chains() const noexcept { return lone_; }
  [[nodiscard]] const std::vector<HeldPoint<T>>& points() const noexcept { return points_; }
  [[nodiscard]] const ConstraintTerms<T>& terms() const noexcept { return terms_; }
  // 1/m: the largest square of a transverse frequency, over gravity, of lone chains that hang from their first end.
  [[nodiscard]] double hanging_rate() const noexcept { return hanging_rate_; }
  [[nodiscard]] Time time() const noexcept { return time_; }
  // Sweeps in a sub-step: one if there is no more than one colour.
  [[nodiscard]] int sweeps() const noexcept { return sweeps_; }
  [[nodiscard]] SweepOrder order() const noexcept { return order_; }
  [[nodiscard]] ConstraintShape shape() const noexcept {
    return {a_.size(), chain_a_.size(), limit_a_.size(), line_a_.size(), lone_.to != 0};
  }
  [[nodiscard]] std::size_t bytes() const noexcept;

 private:
  using Blocks = std::vector<ConstraintBlock>;

  std::vector<const OneConstraint*> lanes(const std::vector<Blocks>& colours, bool is_line);
  void make_points(const Scene& scene, std::span<const double> w, const ParticleOrder& order);
  void make_pairs(const std::vector<Blocks>& colours, std::size_t beyond);
  void make_lines(const std::vector<Blocks>& colours, std::size_t beyond);
  void make_chains(const std::vector<Blocks>& colours, const Blocks& lone, std::size_t beyond);
  struct ChainColumns {
    T *l, *w, *m, *whole, *longest;
  };
  void add_chain(const ConstraintBlock& chain, std::size_t first, std::size_t number, const ChainColumns& columns);
  void make_limits(const std::vector<Blocks>& colours, std::size_t beyond);

  std::size_t count_ = 0, chain_count_ = 0;
  double hanging_rate_ = 0;
  int sweeps_ = 1;
  SweepOrder order_ = SweepOrder::symmetric;
  Time time_;
  Columns<T> columns_;
  std::vector<ConstraintColour> colours_;
  ConstraintColour lone_{.kind = ConstraintColour::Kind::chain};
  std::vector<HeldPoint<T>> points_;
  std::vector<std::int32_t> a_, b_, line_a_, chain_a_, chain_self_, limit_a_;
  std::vector<std::uint32_t> first_, links_, limit_first_, limit_links_;
  ConstraintTerms<T> terms_;
};

extern template class Constraints<float>;
extern template class Constraints<double>;

}  // namespace dvdx
