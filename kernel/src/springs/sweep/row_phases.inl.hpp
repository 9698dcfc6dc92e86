// Rows of a sheet into their lines and back, wide. The scalar twin: row_phases_reference.hpp.
#pragma once

#include "simd/lanes.hpp"
#include "springs/network.hpp"

namespace dvdx {
namespace {

// Deals rows to `phases` lines: a register of each line at a time, then the remaining elements one by one.
template <class V, std::size_t phases>
void deal_rows(const Scalar<V>* row, const SheetRows& sheet, Scalar<V>* lines) noexcept {
  const std::size_t pitch = sheet.pitch;
  for (std::size_t r = 0; r < sheet.rows; ++r, row += sheet.columns, lines += phases * pitch) {
    std::size_t k = 0;
    for (; (k + V::size) * phases <= sheet.columns; k += V::size) {
      const Scalar<V>* const at = row + k * phases;
      const auto [even, odd] = deinterleaved(load_lanes<V>(at), load_lanes<V>(at + V::size));
      if constexpr (phases == 2) {
        store_lanes(lines + k, even);
        store_lanes(lines + k + pitch, odd);
      } else {
        const auto [even2, odd2] = deinterleaved(load_lanes<V>(at + 2 * V::size), load_lanes<V>(at + 3 * V::size));
        const auto [first, third] = deinterleaved(even, even2);
        const auto [second, fourth] = deinterleaved(odd, odd2);
        store_lanes(lines + k, first);
        store_lanes(lines + k + pitch, second);
        store_lanes(lines + k + 2 * pitch, third);
        store_lanes(lines + k + 3 * pitch, fourth);
      }
    }
    for (std::size_t i = k * phases; i < sheet.columns; ++i) lines[i % phases * pitch + i / phases] = row[i];
  }
}

template <class V, std::size_t phases>
void collect_rows(const Scalar<V>* lines, const SheetRows& sheet, Scalar<V>* row) noexcept {
  const std::size_t pitch = sheet.pitch;
  for (std::size_t r = 0; r < sheet.rows; ++r, row += sheet.columns, lines += phases * pitch) {
    std::size_t k = 0;
    for (; (k + V::size) * phases <= sheet.columns; k += V::size) {
      Scalar<V>* const to = row + k * phases;
      if constexpr (phases == 2) {
        const auto [low, high] = interleaved(load_lanes<V>(lines + k), load_lanes<V>(lines + k + pitch));
        store_lanes(to, low);
        store_lanes(to + V::size, high);
      } else {
        const auto even = interleaved(load_lanes<V>(lines + k), load_lanes<V>(lines + k + 2 * pitch));
        const auto odd = interleaved(load_lanes<V>(lines + k + pitch), load_lanes<V>(lines + k + 3 * pitch));
        const auto low = interleaved(even.first, odd.first);
        const auto high = interleaved(even.second, odd.second);
        store_lanes(to, low.first);
        store_lanes(to + V::size, low.second);
        store_lanes(to + 2 * V::size, high.first);
        store_lanes(to + 3 * V::size, high.second);
      }
    }
    for (std::size_t i = k * phases; i < sheet.columns; ++i) row[i] = lines[i % phases * pitch + i / phases];
  }
}

template <class V>
void deal(const Scalar<V>* rows, const SheetRows& sheet, Scalar<V>* lines) noexcept {
  sheet.phases == 2 ? deal_rows<V, 2>(rows, sheet, lines) : deal_rows<V, 4>(rows, sheet, lines);
}
template <class V>
void collect(const Scalar<V>* lines, const SheetRows& sheet, Scalar<V>* rows) noexcept {
  sheet.phases == 2 ? collect_rows<V, 2>(lines, sheet, rows) : collect_rows<V, 4>(lines, sheet, rows);
}

}  // namespace
}  // namespace dvdx
