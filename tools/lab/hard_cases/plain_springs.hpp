// Point masses on springs by Runge and Kutta's fourth order in plain double: what the networks are judged by. It shares
// nothing with the library.
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
  double damping = 0;      // kg/s along it; of the library's scene the first one's for all
};

struct PlainSprings {
  std::vector<Start> bodies;
  std::vector<double> mass;  // kg; 0: fixed
  std::vector<Link> links;
  Vec3 gravity{};     // m/s^2
  double drag = 0;    // 1/s
  double anchor = 0;  // 1/s^2, to where each body starts

  // J: kinetic, of the springs between bodies, and of gravity.
  [[nodiscard]] double energy() const;
};

// Where the bodies are after `seconds`, in `steps` steps.
[[nodiscard]] std::vector<Start> run_plain(const PlainSprings& system, double seconds, std::size_t steps);

// The same for the library, of bodies that are alike where there are drag or anchors.
[[nodiscard]] Scene scene_of(const PlainSprings& system, const Coupling& coupling);

}  // namespace dvdx::tool::stability
