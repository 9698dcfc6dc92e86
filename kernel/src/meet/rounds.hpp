// Contacts of pairs as passes take them: their beginning, a round of all, and the sum of each particle.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meet/impacts.hpp"
#include "meet/meet.hpp"
#include "meet/near.hpp"
#include "meet/ways.hpp"
#include "meet/within.hpp"

namespace dvdx {

// Blocks of meeting_lanes pairs, and the pulse of each as the particle with the lower number takes it. against: the pulse as
// the other one takes it; null if there is no other.
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

// Pairs as the impacts leave them. On entry each pulse is that of the sub-step before.
template <class T>
struct BeginTerms {
  const MetPairs* pairs = nullptr;
  const T* wanted = nullptr;  // m: by pairs, the distance that each is to have at the end
  MetParticles<T> particles{};
  bool has_impacts = false;  // false: impacts have moved nothing
  T h = 0;                   // s
  Separations<T>* contacts = nullptr;
  Pulse<T>* pulses = nullptr;
  Pulse<T>* against = nullptr;
};

// meeting_lanes particles with `count` pulses each, or fewer; pulses that are missing are zeros.
struct SumSlice {
  std::uint32_t first = 0;  // the place of the first lane's first pulse; the next lane's stands beside it
  std::uint32_t count = 0;  // pulses of each
};

template <class T>
struct SumTerms {
  const SumSlice* slices = nullptr;
  const std::uint32_t* particles = nullptr;  // 4 times the number of each lane's particle
  const T* w = nullptr;                      // 1/kg: of each lane's particle
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
  // Finds the near ones of the listed pairs at places from `from` to `to`. Returns their number.
  std::size_t (*find_within)(const WithinTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  // Writes the impacts of the given pairs from number `at` on. Returns the end of those written.
  std::size_t (*find_impacts)(const ImpactTerms<T>& terms, const std::uint32_t* pairs, std::size_t count,
                              std::size_t at) noexcept = nullptr;
  // Finds those of the pairs from `from`, the first of a block, to `to` with a particle that was hit in `round`, and with none
  // hit in a later one. Returns their number; meeting_lanes more may be written.
  std::size_t (*find_hit)(const ImpactTerms<T>& terms, std::size_t from, std::size_t to, T round,
                          std::uint32_t* pairs) noexcept = nullptr;
  // Begins the pairs from `from`, the first of a block, to `to`; others of the last block may be begun with them. Returns the
  // least gap, m, or T's lowest number if a pair acts already.
  T (*begin)(const BeginTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  void (*push)(const RoundTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
  // Sums the slices from `from` to `to`. Returns the square of the longest push, m^2.
  T (*sum)(const SumTerms<T>& terms, std::size_t from, std::size_t to) noexcept = nullptr;
};

}  // namespace dvdx
