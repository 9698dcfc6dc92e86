// Particles that are walked together.
#pragma once

#include <cstddef>

namespace dvdx {

// A whole number of registers on every instruction set, in both precisions.
inline constexpr std::size_t slice = 16;

}  // namespace dvdx
