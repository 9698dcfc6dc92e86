// The highest rates of a scene's springs, and the range of them in which each scheme is stable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "springs/grid_rates.hpp"
#include "springs/list_rates.hpp"
#include "topology/particle_order.hpp"

//   M x'' = -K x - C x',  K = sum_e K_e over the springs, K_e = k (n n^T + (1 - l/r)(1 - n n^T)) between its ends.
// K_e <= k 1 in every direction while r >= l/2. Whatever the positions are, it follows that
//   lambda(M^-1 K) <= lambda of the same springs with k 1 in place of K_e        (one number a particle)
//                  <= max over springs of (w_a S_a + w_b S_b),  S the sum of the k at an end
// (the second from the rows of K^1/2 B^T W B K^1/2; Anderson and Morley 1985 for equal weights). A grid's first bound is at
// most the largest value of its symbol, sum over directions of 2 k w (1 - cos), for a sheet without borders.

namespace dvdx {

// The damping's matrix is bounded in the same way: C_e = c n n^T <= c 1, everywhere.

// The springs' rates by eigenvalues. They take the time of a hundred steps, so they are made only on request or to save
// sub-steps.
struct Frequencies {
  double start = 0;          // rad/s, at the start's positions
  double bound = 0;          // rad/s, anywhere
  double damping_start = 0;  // 1/s, lambda(M^-1 C) at the start's positions
  double damping = 0;        // 1/s, anywhere
  std::uint32_t particle = 0;
};

struct HighestRates {
  double frequency = 0, damping = 0;  // rad/s, 1/s
};

// Lower and upper limits of the bounds in `Frequencies`, from sums alone. For a grid both are the bounds themselves.
struct RateBounds {
  HighestRates least, most;
};
RateBounds rate_bounds(const GridRates& grid);
// The bounds of a sheet, from the largest values of its rows.
HighestRates rates_of(const Grid& sheet, const SheetRates& all) noexcept;
RateBounds rate_bounds(const ListRates& list);
RateBounds rate_bounds(std::span<const JoinedPair> springs, std::span<const double> w);
// The bounds themselves.
HighestRates highest_rates(std::span<const JoinedPair> springs, std::span<const double> w);
// Whether no movable particle has two springs.
bool are_isolated(std::span<const JoinedPair> springs, std::span<const double> w);

// w: 1/kg of each particle, 0 where fixed. of_grids: the bounds, if they are known.
Frequencies frequencies(std::span<const JoinedPair> springs, const std::optional<HighestRates>& of_grids,
                        std::span<const double> w, std::span<const Vec3> start);

// The largest stable z = frequency * sub-step and q = damping's rate * sub-step, which may belong to any two modes. Infinite if
// every value is stable.
struct StableRange {
  double frequency = std::numeric_limits<double>::infinity(), damping = std::numeric_limits<double>::infinity();
  enum class Rule {
    apart,    // z <= frequency and q <= damping
    together  // (z / frequency)^2 + q / damping <= 1
  } rule = Rule::apart;
};
StableRange scheme_limit(const Coupling& coupling);

// The range in which the energy of linear springs stays between half and twice its value, and the most damped mode loses at
// least a quarter of its speed in a sub-step. (leapfrog's energy swings by 1/(1 - z^2/4), without bound towards the limit.)
StableRange bounded_energy_limit(const Coupling& coupling);

// The number of sub-steps of a step h that keeps both within the range, and which of the two asks for more of them.
int substeps_for(const StableRange& range, double h, const HighestRates& rates);
enum class LimitedBy { frequency, damping };
LimitedBy limited_by(const StableRange& range, double h, const HighestRates& rates);

// The splitting of a scheme: flows over a[0] h, a[1] h, ... with a pulse b[k] h after each but the last. If springs damp, a
// pulse takes the damping into account to second order, or with beta[k] h^3 to third.
struct Splitting {
  std::vector<double> a, b, beta;
};
Splitting splitting(const Coupling& coupling);

// Passes over the springs that damp, besides the one over all springs, that a pulse of a damped network takes.
std::size_t damping_passes(const Coupling& coupling) noexcept;

}  // namespace dvdx
