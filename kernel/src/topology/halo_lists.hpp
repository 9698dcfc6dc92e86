// Particles that a part and others hold of each other: the halo.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "dvdx/partition.hpp"
#include "topology/whole.hpp"

namespace dvdx {

// Particles by their numbers in the whole.
struct HaloRows {
  std::vector<std::uint32_t> sent, received;
};
using HaloByPart = std::map<std::uint32_t, HaloRows>;

// Consecutive rows of a sheet that a part owns. owner_of(row): the part that owns it.
struct OwnRows {
  std::uint64_t first = 0, end = 0;
};
template <class OwnerOf>
void hold_rows(const Grid& grid, const OwnRows& own, const OwnerOf& owner_of, const RowsHeld& depth, HaloByPart& halo) {
  const auto add = [&](std::vector<std::uint32_t>& list, std::uint64_t from_row, std::uint64_t to_row) {
    for (std::uint64_t i = from_row * grid.columns; i < to_row * grid.columns; ++i) {
      list.push_back(static_cast<std::uint32_t>(i));
    }
  };
  if (own.first != 0) {
    HaloRows& above = halo[owner_of(own.first - 1)];
    add(above.sent, own.first, std::min(own.end, own.first + depth.below));
    add(above.received, own.first - depth.above, own.first);
  }
  if (own.end != grid.rows) {
    HaloRows& below = halo[owner_of(own.end)];
    add(below.sent, own.end - depth.above, own.end);
    add(below.received, own.end, std::min<std::uint64_t>(grid.rows, own.end + depth.below));
  }
}

// place_of(number): the particle's number in the part, from its number in the whole.
template <class PlaceOf>
void add_neighbours(HaloByPart& halo, const PlaceOf& place_of, Part& part) {
  const auto in_part = [&](std::vector<std::uint32_t>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    for (std::uint32_t& number : numbers) number = place_of(number);
    return std::move(numbers);
  };
  part.is_told.resize(part.particles.size());
  for (auto& [other, lists] : halo) {
    part.neighbours.push_back({other, in_part(lists.sent), in_part(lists.received)});
    for (const std::uint32_t i : part.neighbours.back().sent) part.is_told[i] = 1;
  }
}

// Returns the particles that a part sends to each other part and receives from it. Counts its springs too.
[[nodiscard]] HaloByPart halo_by_part(const Owned& whole, std::uint32_t part, Part& made);

}  // namespace dvdx
