// The slots of a graph: which neighbours each particle sums, for each slice of 16 particles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "springs/form.hpp"

namespace dvdx {

struct SlotNeighbour {
  std::int32_t offset;
  std::uint32_t nth;     // of the springs that join the same two
  std::uint32_t spring;  // index of the list
  std::uint32_t owner;   // particle
};

// One slot of a slice: the neighbours of some of its lanes, by their indices in Slots::neighbours.
inline constexpr std::uint32_t no_neighbour = 0xffffffff;
using SlotLanes = std::array<std::uint32_t, slice>;

struct Slots {
  std::vector<SlotNeighbour> neighbours;   // of each element in turn, by their offsets
  std::vector<std::uint32_t> first;        // of each element, and one more
  std::vector<SlotLanes> lanes;            // of each slice in turn
  std::vector<std::uint32_t> first_slot;   // of each slice, and one more
  std::vector<std::uint8_t> is_at_offset;  // of each slice
};
Slots slots_of(const NetworkInput& in);

// The slots as a pass reads them.
struct SlotLists {
  std::vector<std::uint32_t> first_slot;
  std::vector<Slot> slots;
  std::vector<std::int32_t> indices;

  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_of(first_slot) + bytes_of(slots) + bytes_of(indices); }
};

// Fills the slots: put(spring, w of the owner, lane) writes what one lane of a slot's columns holds.
template <class T, class Put>
void fill_slots(const NetworkInput& in, const Slots& slots, SlotLists& lists, GraphTerms<T>& terms, const Put& put) {
  const auto add = [&](std::size_t first, std::size_t s, bool is_at_offset) {
    Slot slot;
    if (!is_at_offset) slot.indices = static_cast<std::int32_t>(lists.indices.size());
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const std::uint32_t place = slots.lanes[s][lane];
      const SlotNeighbour* const n = place != no_neighbour ? &slots.neighbours[place] : nullptr;
      if (!is_at_offset) {
        lists.indices.push_back(static_cast<std::int32_t>(first + lane) + (n != nullptr ? n->offset : 0));
      } else if (n != nullptr) {
        slot.offset = n->offset;
      }
      if (n != nullptr) put(in.springs[n->spring], in.w[n->owner], s * slice + lane);
    }
    lists.slots.push_back(slot);
  };
  for (std::size_t n = 0; n + 1 < slots.first_slot.size(); ++n) {
    for (std::size_t s = slots.first_slot[n]; s < slots.first_slot[n + 1]; ++s) add(n * slice, s, slots.is_at_offset[n] != 0);
  }
  lists.first_slot = slots.first_slot;
  terms.first_slot = lists.first_slot.data();
  terms.slots = lists.slots.data();
  terms.indices = lists.indices.data();
  terms.damping = in.is_damped ? Damping::along : Damping::none;
  terms.drift = static_cast<T>(in.coupling.axis == PairAxis::midpoint ? in.substep.taken / 2 : 0);
}

// A column of 16 elements a slot, which the pass only reads.
template <class T>
T* slot_column(const Slots& slots, Columns<T>& columns, const T*& view) {
  T* const column = columns.add(slots.lanes.size() * slice, T(0), column_margin);
  view = column;
  return column;
}

// A stiffness that rounds to zero in T counts as no spring in every loop: 0 times a length that overflows T would be NaN.
template <class T>
T unless_empty(bool is_empty, double value) noexcept {
  return is_empty ? T(0) : static_cast<T>(value);
}

}  // namespace dvdx
