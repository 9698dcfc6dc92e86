// Impacts of pairs as a pass takes them: find_impact() of meet.hpp over lists of pairs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meet/meet.hpp"

namespace dvdx {

template <class T>
struct ImpactTerms {
  const MetPairs* pairs = nullptr;
  const T* wanted = nullptr;  // m: the distance that each pair wants, by pair number
  MetParticles<T> particles{};
  T h = 0;        // s
  T slowest = 0;  // m/s
  // The impacts found, in lanes: n in `n`, f in `gap`, the speed in `normal`. pair_of: the pair number of each.
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
