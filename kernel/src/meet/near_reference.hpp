// The search for near particles, scalar: one pair after the other. The wide twin: near.inl.hpp.
#pragma once

#include "meet/meet.inl.hpp"
#include "meet/near.hpp"

namespace dvdx::reference {

// Returns true if two places are near and the second one has the higher number.
template <class T>
bool is_near(const NearTerms<T>& terms, std::size_t s, std::size_t t) noexcept {
  const Point<T> apart{terms.x[s] - terms.x[t], terms.y[s] - terms.y[t], terms.z[s] - terms.z[t]};
  const T most = terms.a[s] + terms.a[t] + terms.reach;
  return (dvdx::inner(apart, apart) < most * most) & (terms.number[t] > terms.number[s]);
}

// use(place) for each place that may be near.
template <class Use>
void for_each_about(const PlacesAbout& about, const Use& use) noexcept {
  for (std::size_t part = 0; part < about.count; ++part) {
    for (std::uint32_t t = about.parts[part].from; t < about.parts[part].to; ++t) use(t);
  }
}

template <class T>
PlacesAbout places_about(const NearTerms<T>& terms, std::size_t s) noexcept {
  PlacesAbout about;
  about.find(terms.grid, terms.starts, terms.grid.place_of(terms.cell[terms.number[s]]), 1);
  return about;
}

template <class T>
Looked find_near(const NearTerms<T>& terms, std::size_t from, std::size_t to, std::size_t used) noexcept {
  for (; from < to; ++from) {
    const PlacesAbout about = places_about(terms, from);
    if (used + about.all + near_padding > terms.room) break;
    const std::uint32_t i = terms.number[from];
    terms.first[i] = static_cast<std::uint32_t>(used);
    for_each_about(about, [&](std::uint32_t t) {
      terms.found[used] = terms.number[t];
      used += is_near(terms, from, t) ? 1U : 0U;
    });
    terms.count[i] = static_cast<std::uint32_t>(used) - terms.first[i];
  }
  return {from, used};
}

inline void order_lists(const ListTerms& terms, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from; i < to; ++i) {
    const std::uint32_t* const found = terms.found + terms.found_at[i];
    std::uint32_t* const list = terms.lists + terms.first[i];
    for (std::uint32_t k = 0; k < terms.count[i]; ++k) {
      const std::uint32_t j = found[k];
      std::uint32_t place = k;
      for (; place > 0 && list[place - 1] > j; --place) list[place] = list[place - 1];
      list[place] = j;
    }
  }
}

}  // namespace dvdx::reference
