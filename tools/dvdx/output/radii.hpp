// The size at which particles that are balls are drawn.
#pragma once

#include <vector>

#include "output/writer.hpp"

namespace dvdx::tool {

// m: of each number by which the file names particles; none where they are no balls. A number that no particle has has 0.
[[nodiscard]] std::vector<double> radii_of(const Output& output);

}  // namespace dvdx::tool
