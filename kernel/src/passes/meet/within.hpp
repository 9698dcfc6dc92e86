// Which of the listed pairs may meet in a sub-step, as a pass takes it: those whose ways come within reach of each other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "passes/meet/meet.hpp"

namespace dvdx {

// In a list of near pairs: that the pair goes fast enough for an impact.
inline constexpr std::uint32_t goes_fast = std::uint32_t{1} << 31;

template <class T>
struct WithinTerms {
  const std::uint32_t *owners = nullptr, *partners = nullptr;  // the listed pairs, by places
  MetParticles<T> particles{};
  T margin = 0;   // m: beyond the distance that a pair wants
  T most = 0;     // m: of the strays that are looked at beyond it
  T slowest = 0;  // m/s
  // The pairs that are near, in the order of their places: from the first place that a call is given on, and no farther than
  // the last. The one with the lower number has goes_fast added where the pair does.
  std::uint32_t *i = nullptr, *j = nullptr;
};

}  // namespace dvdx
