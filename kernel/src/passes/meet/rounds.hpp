// A round of all contacts of pairs, as a pass takes it: meet.hpp's push, from memory to memory.
#pragma once

#include <cstddef>

#include "passes/meet/meet.hpp"
#include "passes/meet/near.hpp"

namespace dvdx {

// Blocks of meeting_lanes pairs, and the pulse of each.
template <class T>
struct RoundTerms {
  const MetPairs* pairs = nullptr;
  Separations<T>* contacts = nullptr;
  Pulse<T>* pulses = nullptr;
  const MeetPush<T>* pushed = nullptr;  // by particles
  T mu{}, beta{};
};

template <class T>
struct MeetKernels {
  // Pairs from `from`, the first of a block, to `to`. More of the last block may be taken with them.
  void (*push)(const RoundTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  NearKernels<T> near{};
};

}  // namespace dvdx
