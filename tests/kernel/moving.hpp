// Test setups of particles and surfaces that follow a motion.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"

namespace moving {

using namespace dvdx;
using test::Joined;

inline Motion along(const Vec3& velocity) {
  const double T = 16;
  return {.center = {}, .keys = {{.time = 0}, {.time = T, .translation = {T * velocity[0], T * velocity[1], T * velocity[2]}}}};
}

// Turns the fixed particles into followers of a motion.
inline Joined carried(Joined joined, Motion motion) {
  joined.scene.add(Kinematic{.particles = std::exchange(joined.scene.fixed, {}), .motion = joined.scene.motions.size()});
  joined.scene.add(std::move(motion));
  return joined;
}

inline std::vector<Coupling> couplings() {
  return {{.scheme = Scheme::leapfrog},
          {.scheme = Scheme::fourth_order},
          {.scheme = Scheme::sequential, .substeps = 4},
          {.scheme = Scheme::sequential, .substeps = 4, .theta = 0.5},
          {.scheme = Scheme::sequential, .substeps = 4, .theta = 1, .sweeps = SweepOrder::forward},
          {.scheme = Scheme::accumulate, .method = Method::combined}};
}

inline constexpr Vec3 boost{1.5, -0.75, 2.25};

// The sheet, its pins and the wind all move at one velocity.
inline Joined boosted(const Joined& still) {
  Joined moving = carried(still, along(boost));
  for (Vec3& v : moving.v) {
    for (std::size_t k = 0; k < 3; ++k) v[k] += boost[k];
  }
  for (Force& force : moving.scene.forces) {
    if (auto* drag = std::get_if<Drag>(&force)) drag->wind = boost;
  }
  return moving;
}

// The largest distance between the two runs, without the boost's displacement in the time t.
inline double furthest(const std::vector<double>& still, const std::vector<double>& moving, double t) {
  double most = 0;
  for (std::size_t i = 0; i < still.size(); i += 6) {
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(moving[i + k] - t * boost[k] - still[i + k]));
  }
  return most;
}

}  // namespace moving
