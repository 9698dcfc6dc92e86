// How fast the springs of a scene can swing, and what each scheme takes of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compile/particle_order.hpp"
#include "dvdx/plan.hpp"

//   M x'' = -K x - G x',  K = sum_e K_e over the springs, K_e = k (n n^T + (1 - l/r)(1 - n n^T)) between its ends.
// K_e <= k 1 in every direction while r >= l/2, so that whatever the positions are
//   lambda(M^-1 K) <= lambda of the same springs with k 1 in place of K_e        (one number a particle)
//                  <= max over springs of (w_a S_a + w_b S_b),  S the sum of the k at an end
// (the second from the rows of K^1/2 B^T W B K^1/2; Anderson and Morley 1985 for equal weights). Of a grid, the first is at
// most the largest value of its symbol, sum over directions of 2 k w (1 - cos), for a sheet without borders.

namespace dvdx {

struct Frequencies {
  double start = 0;    // rad/s, at the start's positions
  double bound = 0;    // rad/s, anywhere
  double damping = 0;  // 1/s, bound of lambda(M^-1 G)
  std::uint32_t particle = 0;
  bool is_isolated = true;  // no movable particle has two springs
};

// w: 1/kg of each particle, 0 where fixed.
Frequencies frequencies(std::span<const JoinedPair> springs, const Grid* grid, std::span<const double> w,
                        std::span<const Vec3> start);

// frequency * sub-step up to which the scheme is stable without damping; infinite where any is.
double scheme_limit(const Coupling& coupling);

// The same up to which the energy of linear springs stays within half and twice of what it is: leapfrog's swings by
// 1/(1 - z^2/4), without bound towards the limit.
double calm_limit(const Coupling& coupling);

// Sub-steps of a step h that keep frequency and damping within such a limit.
int substeps_for(double limit, double h, double frequency, double damping);

// The splitting of a scheme: flows over a[0] h, a[1] h, ... with a pulse b[k] h after each but the last.
struct Splitting {
  std::vector<double> a, b;
};
Splitting splitting(const Coupling& coupling);

}  // namespace dvdx
