// The search for near particles, a register of candidates at once: near_reference.hpp in lanes. Particles of neighbouring cells
// share candidates, which are brought together once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "meet/near.hpp"
#include "simd/lanes.hpp"

namespace dvdx {
namespace {

inline constexpr std::size_t most_together = 256;
inline constexpr std::uint32_t cells_together = 3;
inline constexpr std::uint32_t enough_together = 6;  // particles that share candidates

template <class T>
struct NearCandidates {
  alignas(64) std::array<T, most_together + near_padding> x, y, z, a;
  alignas(64) std::array<std::uint32_t, most_together + near_padding> number;
};

template <class T>
[[gnu::always_inline]] inline void copy_some(T* to, const T* from) noexcept {
  std::memcpy(to, from, near_padding * sizeof(T));
}

// Returns true if one of the first `count` numbers is higher. count: at most near_padding.
template <class V>
[[gnu::always_inline]] inline bool has_higher(const std::uint32_t* numbers, std::size_t count, std::uint32_t than) noexcept {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < near_padding; k += V::size) bits |= bits_of_higher<V>(numbers + k, than) << k;
  return (bits & ((std::uint64_t{1} << count) - 1)) != 0;
}

// Copies the candidates that may be partners of particles with this number or higher ones: half of them if numbers go along
// with places. Returns their number. Beyond them x is NaN, which is near nobody.
template <class V>
[[gnu::always_inline]] inline std::size_t bring_together(const NearTerms<Scalar<V>>& terms, const PlacesAbout& about,
                                                         std::uint32_t lowest, NearCandidates<Scalar<V>>& to) noexcept {
  std::size_t at = 0;
  for (std::size_t part = 0; part < about.count; ++part) {
    const std::size_t end = about.parts[part].to;
    for (std::size_t place = about.parts[part].from; place < end; place += near_padding) {
      const std::size_t count = std::min(near_padding, end - place);
      if (!has_higher<V>(terms.number + place, count, lowest)) continue;
      copy_some(to.x.data() + at, terms.x + place);
      copy_some(to.y.data() + at, terms.y + place);
      copy_some(to.z.data() + at, terms.z + place);
      copy_some(to.a.data() + at, terms.a + place);
      copy_some(to.number.data() + at, terms.number + place);
      at += count;
    }
  }
  std::fill_n(to.x.begin() + static_cast<std::ptrdiff_t>(at), near_padding, std::numeric_limits<Scalar<V>>::quiet_NaN());
  return at;
}

template <class V>
struct Looker {
  V x, y, z, a, reach;
  std::uint32_t number;

  [[gnu::always_inline]] Looker(const NearTerms<Scalar<V>>& terms, std::size_t s) noexcept
      : x(terms.x[s]), y(terms.y[s]), z(terms.z[s]), a(terms.a[s]), reach(terms.reach), number(terms.number[s]) {}

  // Writes the numbers of the near candidates of a register, or of its first `count`.
  template <class T>
  [[gnu::always_inline]] std::size_t look(const T* at_x, const T* at_y, const T* at_z, const T* at_a,
                                          const std::uint32_t* numbers, std::size_t count,
                                          std::uint32_t* found) const noexcept {
    const V dx = x - load_lanes<V>(at_x), dy = y - load_lanes<V>(at_y), dz = z - load_lanes<V>(at_z);
    const V most = a + load_lanes<V>(at_a) + reach;
    std::uint64_t bits = bits_of<V>((dx * dx + dy * dy) + dz * dz < most * most) & bits_of_higher<V>(numbers, number);
    if (count < V::size) bits &= (std::uint64_t{1} << count) - 1;
    return store_chosen<V>(found, numbers, bits);
  }
};

// Finds the number of cells along x, from that of a place on, whose particles share candidates.
template <class T>
[[gnu::always_inline]] inline std::uint32_t find_block(const NearTerms<T>& terms, std::size_t from, std::uint32_t cell,
                                                       PlacesAbout& about) noexcept {
  const CellGrid::Cell at = terms.grid.place_of(cell);
  std::uint32_t cells = 1;
  while (at[0] > 0 && at[0] + cells < terms.grid.mask[0] && cells < cells_together &&
         terms.starts[cell + cells] < from + enough_together) {
    ++cells;
  }
  about.find(terms.grid, terms.starts, at, cells);
  if (about.all > most_together && cells > 1) about.find(terms.grid, terms.starts, at, cells = 1);
  return cells;
}

// A lower bound of the numbers of some cells' particles from a place on. Numbers ascend in each cell.
template <class T>
[[gnu::always_inline]] inline std::uint32_t lowest_number(const NearTerms<T>& terms, std::size_t from, std::uint32_t cell,
                                                          std::uint32_t cells) noexcept {
  std::uint32_t lowest = terms.number[from];
  for (std::uint32_t k = 1; k < cells_together; ++k) {
    const std::uint32_t first = terms.number[terms.starts[cell + (k < cells ? k : 0)]];
    lowest = std::min(lowest, first);
  }
  return lowest;
}

template <class V>
Looked find_near(const NearTerms<Scalar<V>>& terms, std::size_t from, std::size_t to, std::size_t used) noexcept {
  PlacesAbout about;
  NearCandidates<Scalar<V>> candidates;
  while (from < to) {
    const std::uint32_t cell = terms.cell[terms.number[from]];
    const std::uint32_t cells = find_block(terms, from, cell, about);
    const bool are_together = about.all <= most_together;
    const std::size_t together =
        are_together ? bring_together<V>(terms, about, lowest_number(terms, from, cell, cells), candidates) : 0;
    const std::size_t end = std::min<std::size_t>(terms.starts[cell + cells], to);
    for (; from < end; ++from) {
      if (used + about.all + near_padding > terms.room) return {from, used};
      const Looker<V> looker(terms, from);
      const std::size_t first = used;
      if (are_together) {
        for (std::size_t k = 0; k < together; k += V::size) {
          used += looker.look(candidates.x.data() + k, candidates.y.data() + k, candidates.z.data() + k,
                              candidates.a.data() + k, candidates.number.data() + k, V::size, terms.found + used);
        }
      } else {
        for (std::size_t part = 0; part < about.count; ++part) {
          const std::size_t last = about.parts[part].to;
          for (std::size_t t = about.parts[part].from; t < last; t += V::size) {
            used +=
                looker.look(terms.x + t, terms.y + t, terms.z + t, terms.a + t, terms.number + t, last - t, terms.found + used);
          }
        }
      }
      terms.first[looker.number] = static_cast<std::uint32_t>(first);
      terms.count[looker.number] = static_cast<std::uint32_t>(used - first);
    }
  }
  return {from, used};
}

// Sorts a list longer than sorted_at_once by insertion.
[[gnu::noinline]] inline void order_long(std::uint32_t* list, const std::uint32_t* found, std::size_t count) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t j = found[k];
    std::size_t place = k;
    for (; place > 0 && list[place - 1] > j; --place) list[place] = list[place - 1];
    list[place] = j;
  }
}

template <class V>
void order_lists(const ListTerms& terms, std::size_t from, std::size_t to) noexcept {
  const std::size_t end = terms.first[to];
  for (std::size_t i = from; i < to; ++i) {
    const std::uint32_t* const found = terms.found + terms.found_at[i];
    const std::size_t count = terms.count[i];
    const std::size_t first = terms.first[i];
    if (count <= sorted_at_once<V> && first + sorted_at_once<V> <= end) {
      store_sorted<V>(terms.lists + first, found, count);
    } else {
      order_long(terms.lists + first, found, count);
    }
  }
}

}  // namespace
}  // namespace dvdx
