// Contacts of pairs, as passes take them: how they begin, a round of all, and what each particle gets by it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meet/impacts.hpp"
#include "meet/meet.hpp"
#include "meet/near.hpp"
#include "meet/ways.hpp"
#include "meet/within.hpp"

namespace dvdx {

// Blocks of meeting_lanes pairs, and the pulse of each: as the particle with the lower number takes it, and as the other does,
// if there is one.
template <class T>
struct RoundTerms {
  const MetPairs* pairs = nullptr;
  Separations<T>* contacts = nullptr;
  Pulse<T>* pulses = nullptr;
  Pulse<T>* against = nullptr;
  const MeetPush<T>* pushed = nullptr;  // by particles
  const T* mus = nullptr;               // of each pair; or
  T mu{};                               // of all
  T beta{};
};

// Pairs as the impacts leave them. Each pulse is at first that of the sub-step before.
template <class T>
struct BeginTerms {
  const MetPairs* pairs = nullptr;
  const T* wanted = nullptr;  // m: by pairs, the distance that each is to have at the end
  MetParticles<T> particles{};
  bool has_impacts = false;  // else nothing has been moved by any
  T h = 0;                   // s
  Separations<T>* contacts = nullptr;
  Pulse<T>* pulses = nullptr;
  Pulse<T>* against = nullptr;
};

// meeting_lanes particles that have as many pulses each, or fewer: the others are of nothing.
struct SumSlice {
  std::uint32_t first = 0;  // the first lane's first pulse; the next lane's stands beside it
  std::uint32_t count = 0;  // pulses of each
};

template <class T>
struct SumTerms {
  const SumSlice* slices = nullptr;
  const std::uint32_t* particles = nullptr;  // 4 times the number of each lane's
  const T* w = nullptr;                      // 1/kg: of each lane's
  const std::uint32_t* places = nullptr;     // 4 times the place of each pulse
  const Pulse<T>* pulses = nullptr;
  MeetPush<T>* pushed = nullptr;
};

template <class T>
struct MeetKernels {
  // Particles from `from` to `to`.
  WaySums (*take_ways)(const WayTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  ListAge (*find_strays)(const StrayTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  NearKernels<T> near{};
  // The listed pairs of places from `from` to `to` that are near; how many.
  std::size_t (*find_within)(const WithinTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  // The impacts of some pairs, from the number `at` on; where they end.
  std::size_t (*find_impacts)(const ImpactTerms<T>& terms, const std::uint32_t* pairs, std::size_t count,
                              std::size_t at) noexcept = nullptr;
  // The pairs from `from`, the first of a block, to `to` of which one was hit in a round, and in none since. How many;
  // meeting_lanes more may be written.
  std::size_t (*find_hit)(const ImpactTerms<T>& terms, std::size_t from, std::size_t to, T round,
                          std::uint32_t* pairs) noexcept = nullptr;
  // Pairs from `from`, the first of a block, to `to`. More of the last block may be taken with them. The least gap, m; one that
  // acts already has none that is less.
  T (*begin)(const BeginTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  void (*push)(const RoundTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  // Slices from `from` to `to`. The square of the longest push, m^2.
  T (*sum)(const SumTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
};

}  // namespace dvdx
