#include "springs/sum/slots.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace dvdx {
namespace {

constexpr SlotLanes no_neighbours = [] {
  SlotLanes lanes{};
  lanes.fill(no_neighbour);
  return lanes;
}();

// Finds the neighbours of each particle that can move, or whose neighbour can.
void find_neighbours(const NetworkInput& in, Slots& found) {
  const auto for_each_end = [&](const auto& use) {
    for (std::size_t s = 0; s < in.springs.size(); ++s) {
      const JoinedPair& spring = in.springs[s];
      if (in.w[spring.a] == 0 && in.w[spring.b] == 0) continue;
      use(s, spring.a, spring.b);
      use(s, spring.b, spring.a);
    }
  };
  found.first.assign(in.order.size + 1, 0);
  for_each_end([&](std::size_t, std::uint32_t owner, std::uint32_t) { ++found.first[in.order.of[owner] + 1]; });
  std::partial_sum(found.first.begin(), found.first.end(), found.first.begin());
  found.neighbours.resize(found.first.back());
  std::vector<std::uint32_t> next(found.first.begin(), found.first.end() - 1);
  for_each_end([&](std::size_t s, std::uint32_t owner, std::uint32_t other) {
    const auto offset = static_cast<std::int32_t>(in.order.of[other]) - static_cast<std::int32_t>(in.order.of[owner]);
    found.neighbours[next[in.order.of[owner]]++] = {offset, 0, static_cast<std::uint32_t>(s), owner};
  });
  for (std::size_t i = 0; i < in.order.size; ++i) {
    const std::span<SlotNeighbour> own =
        std::span(found.neighbours).subspan(found.first[i], found.first[i + 1] - found.first[i]);
    std::sort(own.begin(), own.end(), [](const SlotNeighbour& m, const SlotNeighbour& n) {
      return std::pair(m.offset, m.spring) < std::pair(n.offset, n.spring);
    });
    for (std::size_t n = 1; n < own.size(); ++n) {
      if (own[n].offset == own[n - 1].offset) own[n].nth = own[n - 1].nth + 1;
    }
  }
}

// Adds slots at fixed offsets if that takes at most 4 slots more than the lane with most neighbours has.
void add_slots_of_slice(std::size_t first, Slots& slots) {
  struct KeyedSlot {
    std::pair<std::int32_t, std::uint32_t> key;  // offset, nth
    std::size_t lane;
    std::uint32_t place;
  };
  std::vector<KeyedSlot> all;
  std::size_t most = 0;
  for (std::size_t lane = 0; lane < slice; ++lane) {
    const std::uint32_t from = slots.first[first + lane], to = slots.first[first + lane + 1];
    most = std::max<std::size_t>(most, to - from);
    for (std::uint32_t n = from; n < to; ++n) {
      all.push_back({{slots.neighbours[n].offset, slots.neighbours[n].nth}, lane, n});
    }
  }
  std::sort(all.begin(), all.end(), [](const KeyedSlot& m, const KeyedSlot& n) { return m.key < n.key; });
  const auto is_new = [&](std::size_t k) { return k != 0 && all[k].key != all[k - 1].key; };
  std::size_t different = all.empty() ? 0 : 1;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (is_new(k)) ++different;
  }
  const bool is_at_offset = different <= most + 4;
  slots.is_at_offset.push_back(is_at_offset ? 1 : 0);
  const std::size_t begin = slots.lanes.size();
  slots.lanes.resize(begin + (is_at_offset ? different : most), no_neighbours);
  std::size_t slot = begin;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (is_new(k)) ++slot;
    const std::size_t of = is_at_offset ? slot : begin + (all[k].place - slots.first[first + all[k].lane]);
    slots.lanes[of][all[k].lane] = all[k].place;
  }
}

}  // namespace

Slots slots_of(const NetworkInput& in) {
  Slots slots;
  find_neighbours(in, slots);
  for (std::size_t first = 0; first < in.order.size; first += slice) {
    slots.first_slot.push_back(static_cast<std::uint32_t>(slots.lanes.size()));
    add_slots_of_slice(first, slots);
  }
  slots.first_slot.push_back(static_cast<std::uint32_t>(slots.lanes.size()));
  return slots;
}

}  // namespace dvdx
