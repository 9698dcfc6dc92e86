// The triangles of a network's cloth.
#pragma once

#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx {

// Of a grid its cells, each cut in two (triangles_of), of springs their own; but those that have a torn side.
[[nodiscard]] std::vector<Triangle> whole_triangles(const Network& network);

}  // namespace dvdx
