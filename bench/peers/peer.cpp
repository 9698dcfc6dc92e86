#include "peers/peer.hpp"

#include <algorithm>
#include <cmath>

#include "support/race.hpp"

namespace dvdx::bench {

// One ladder for all methods that accept any number of sub-steps: each meets a goal with as few as it needs.
std::vector<int> any_ladder(const Cloth& /*cloth*/) {
  return {1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 12, 14,  16,  18,  20, 22,
          25, 28, 30, 35, 40, 45, 50, 60, 70, 80, 90, 100, 140, 200, 500};
}

std::vector<int> explicit_ladder(const Cloth& cloth, double reach) {
  const double fewest = std::max(1.0, std::ceil(cloth.limit() / reach));
  std::vector<int> ladder;
  for (const double factor : {1.0, 1.25, 1.5, 2.0, 3.0}) ladder.push_back(static_cast<int>(std::ceil(factor * fewest)));
  ladder.erase(std::unique(ladder.begin(), ladder.end()), ladder.end());
  return ladder;
}

// Slightly below the limit, because the springs stiffen as the cloth moves.
std::vector<int> leapfrog_ladder(const Cloth& cloth) { return explicit_ladder(cloth, 0.93); }

std::vector<int> tolerance_ladder(const Cloth& /*cloth*/) { return {2, 3, 4, 5, 6, 7, 8}; }

double tolerance_of(int digits) { return std::pow(10.0, -digits); }

std::size_t steps_of(double seconds, int substeps) {
  return static_cast<std::size_t>(std::lround(seconds / frame_time * substeps));
}

double time_once(const std::function<void()>& work) {
  const double start = now(Timer::thread);
  work();
  return now(Timer::thread) - start;
}

}  // namespace dvdx::bench
