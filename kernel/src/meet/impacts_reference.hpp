// Impacts of pairs, scalar: one after the other. The wide twin: impacts.inl.hpp.
#pragma once

#include "meet/impacts.hpp"
#include "meet/meet.inl.hpp"

namespace dvdx::reference {

// Writes the impacts of the given pairs from number `at` on. Returns the end of those written.
template <class T>
std::size_t find_impacts(const ImpactTerms<T>& terms, const std::uint32_t* pairs, std::size_t count, std::size_t at) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    const MetPair pair = pair_at(terms.pairs, pairs[k]);
    const Impact<T> impact = find_impact(pair.i, pair.j, terms.particles, terms.wanted[pairs[k]], terms.h, terms.slowest);
    if (impact.f > 1) continue;
    put_impact(terms.found, at, impact);
    terms.pair_of[at++] = pairs[k];
  }
  return at;
}

// Writes those of the pairs from `from` to `to` with a particle that was hit in this round, and with none hit in a later one.
// Returns their number. Up to most_chosen more may be written.
template <class T>
std::size_t find_hit(const ImpactTerms<T>& terms, std::size_t from, std::size_t to, T round, std::uint32_t* pairs) noexcept {
  std::size_t count = 0;
  for (std::size_t p = from; p < to; ++p) {
    const MetPair pair = pair_at(terms.pairs, p);
    const T of_i = terms.particles.shift[pair.i].round, of_j = terms.particles.shift[pair.j].round;
    pairs[count] = static_cast<std::uint32_t>(p);
    count += (of_i > of_j ? of_i : of_j) == round ? 1U : 0U;
  }
  return count;
}

}  // namespace dvdx::reference
