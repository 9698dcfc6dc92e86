// What a plan must know of the particles that it does not step, where a batch is stepped in parts.
#pragma once

#include <cstddef>

#include "dvdx/export.h"
#include "dvdx/scene.hpp"

namespace dvdx {

// Some formulas are chosen by the fastest particle of all: with these numbers of the whole batch in Options::elsewhere, a
// part's bits are those that it has in the whole.
struct Elsewhere {
  double W = 0;                 // 1/s^2: the highest stiffness over mass, of any particle and axis
  double g = 0;                 // 1/s: the highest damping over mass
  bool anchors_differ = false;  // springs whose methods keep them apart have anchors of their own
};

// Of the scene's first `count` particles.
[[nodiscard]] DVDX_EXPORT Elsewhere elsewhere_of(const Scene& scene, std::size_t count);

}  // namespace dvdx
