// The radii of particles that are drawn as balls.
#pragma once

#include <vector>

#include "output/writer.hpp"

namespace dvdx::tool {

// Returns m for each number by which the file names particles, 0 for one of no particle. Empty if particles are no balls.
[[nodiscard]] std::vector<double> radii_of(const Output& output);

}  // namespace dvdx::tool
