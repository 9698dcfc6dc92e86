// Networks and constraints: their keys are checked, although this version runs neither.
#pragma once

#include <cstddef>
#include <optional>

#include "particle_values.hpp"

namespace dvdx::tool {

// What the networks of a scene add to its particles.
struct NetworkParticles {
  std::optional<std::size_t> count = 0;  // not known where one is a mesh
  bool made = false;                     // by a grid or a mesh, so that the scene need not list any
};
[[nodiscard]] NetworkParticles particles_of_networks(const Node& network);

void check_networks(const Node& network, const Population& population);
void check_constraints(const Node& constraints, const Population& population);

}  // namespace dvdx::tool
