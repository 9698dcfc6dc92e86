// Which of the listed pairs may meet in a sub-step, as a pass takes it: those whose ways come within reach of each other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meet/meet.hpp"

namespace dvdx {

// In a list of near pairs, beside the lower number: that the pair goes fast enough for an impact; beside the higher one: that
// it is far, and that no push will come to it unless they are longer than those of the sub-step before.
inline constexpr std::uint32_t pair_goes_fast = std::uint32_t{1} << 31;
inline constexpr std::uint32_t pair_is_far = std::uint32_t{1} << 31;

template <class T>
struct WithinTerms {
  const std::uint32_t *owners = nullptr, *partners = nullptr;  // the listed pairs, by places
  MetParticles<T> particles{};
  Wanted wanted = Wanted::sum;
  T widest = 0;   // m: no pair wants more
  T margin = 0;   // m: beyond the distance that a pair wants
  T most = 0;     // m: of the strays that are looked at beyond it
  T far = 0;      // m: beyond the wanted distance; no result depends on it
  T slowest = 0;  // m/s
  // The pairs that are near, in the order of their places: from the first place that a call is given on, and no farther than
  // the last.
  std::uint32_t *i = nullptr, *j = nullptr;
};

}  // namespace dvdx
