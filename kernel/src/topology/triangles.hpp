// The triangles of a network's cloth.
#pragma once

#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx {

// The cells of a grid, each cut in two (triangles_of), or the springs' own triangles, without those that have a torn side.
[[nodiscard]] std::vector<Triangle> whole_triangles(const Network& network);

}  // namespace dvdx
