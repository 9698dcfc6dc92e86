// Impacts of pairs, as a pass takes them: meet.hpp's find_impact, from lists to lists.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meet/meet.hpp"

namespace dvdx {

template <class T>
struct ImpactTerms {
  const MetPairs* pairs = nullptr;
  const T* wanted = nullptr;  // m: by pairs, the distance that each wants
  MetParticles<T> particles{};
  T h = 0;        // s
  T slowest = 0;  // m/s
  // The impacts that there are, in lanes: n, f where the gap stands, the speed where the normal pulse does; and their pairs.
  Separations<T>* found = nullptr;
  std::uint32_t* pair_of = nullptr;
};

template <class T>
Impact<T> impact_at(const Separations<T>* found, std::size_t k) noexcept {
  const Separations<T>& of = found[k / meeting_lanes];
  const std::size_t lane = k % meeting_lanes;
  return {Separations<T>::at(of.n, lane), of.gap.data()[lane], of.normal.data()[lane]};
}
template <class T>
void put_impact(Separations<T>* found, std::size_t k, const Impact<T>& impact) noexcept {
  Separations<T>& of = found[k / meeting_lanes];
  const std::size_t lane = k % meeting_lanes;
  Separations<T>::put(of.n, lane, impact.n);
  of.gap.data()[lane] = impact.f;
  of.normal.data()[lane] = impact.speed;
}

}  // namespace dvdx
