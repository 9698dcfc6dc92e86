// Point masses on springs by fourth-order Runge-Kutta in plain double: the reference for the networks. It shares nothing with
// the library.
#pragma once

#include <cstddef>
#include <vector>

#include "dvdx/network.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {

struct Link {
  std::size_t a = 0, b = 0;
  double stiffness = 0;    // N/m
  double rest_length = 0;  // m
  double damping = 0;      // kg/s along the spring; the library's scene takes the first one's for all
};

struct PlainSprings {
  std::vector<Start> bodies;
  std::vector<double> mass;  // kg; 0: fixed
  std::vector<Link> links;
  Vec3 gravity{};     // m/s^2
  double drag = 0;    // 1/s
  double anchor = 0;  // 1/s^2, towards each body's start

  // J: kinetic energy, energy of the springs between bodies, and gravity's potential.
  [[nodiscard]] double energy() const;
};

// Returns the bodies after `seconds`, in `steps` steps.
[[nodiscard]] std::vector<Start> run_plain(const PlainSprings& system, double seconds, std::size_t steps);

// The same system for the library. Bodies must be alike if there is drag or an anchor.
[[nodiscard]] Scene scene_of(const PlainSprings& system, const Coupling& coupling);

}  // namespace dvdx::tool::stability
