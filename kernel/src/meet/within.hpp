// The listed pairs that may meet in a sub-step, as a pass takes them: those whose ways come within reach of each other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meet/meet.hpp"

namespace dvdx {

// Flags in a list of near pairs. On the lower number: the pair goes fast enough for an impact. On the higher number: the pair
// is far, and no push reaches it unless pushes are longer than those of the sub-step before.
inline constexpr std::uint32_t pair_goes_fast = std::uint32_t{1} << 31;
inline constexpr std::uint32_t pair_is_far = std::uint32_t{1} << 31;

template <class T>
struct WithinTerms {
  const std::uint32_t *owners = nullptr, *partners = nullptr;  // the listed pairs, by places
  MetParticles<T> particles{};
  Wanted wanted = Wanted::sum;
  T widest = 0;   // m: no pair wants more
  T margin = 0;   // m: beyond the distance that a pair wants
  T most = 0;     // m: strays widen the reach by at most this
  T far = 0;      // m: pairs farther than this beyond the wanted distance are far; no result depends on it
  T slowest = 0;  // m/s
  // The near pairs in the order of their places, from the first place of a call on, and no farther than its last.
  std::uint32_t *i = nullptr, *j = nullptr;
};

}  // namespace dvdx
