// Removal without order: which survivors move where. Nothing is computed, so that every instruction set has the same bits.
//
// The rule for `count` places, some of which are holes: births go into the first holes, until births or holes run out. `kept`
// places are then to be taken. The survivors behind that new end move into the holes before it, both in ascending order.
// Everything else stays where it is. The numbers match: if h of the first `kept` places are holes, kept - h survivors stand
// there, and h stand behind.
//
// It is applied twice. First to each run of fill_run places by itself, with its share of the births, while the run is in
// cache. Then to all places, with the births that are left; by then only the ends of the runs are free. So few moves leave the
// cache, and runs can be filled at once.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace dvdx {

inline constexpr std::size_t fill_run = 16384;  // places

// Moves within one run: from some n on, hole to[n + k] takes the element at from[k].
struct Fill {
  std::array<std::uint16_t, fill_run> to;        // left uninitialised
  std::array<std::uint16_t, fill_run / 2> from;  // likewise
  std::size_t count = 0;
};

// Lists the places from `at` to `end` whose bit is set in `words`, each word flipped by `flip`. They ascend. Returns how many.
inline std::size_t list_places(const std::uint64_t* words, std::uint64_t flip, std::size_t at, std::size_t end,
                               std::uint16_t* places) noexcept {
  std::size_t n = 0;
  std::uint64_t hidden = (std::uint64_t{1} << (at % 64)) - 1;  // before `at`
  for (std::size_t w = at / 64; w * 64 < end; ++w) {
    std::uint64_t bits = (words[w] ^ flip) & ~hidden;
    if (end - w * 64 < 64) bits &= (std::uint64_t{1} << (end % 64)) - 1;
    for (; bits != 0; bits &= bits - 1)
      places[n++] = static_cast<std::uint16_t>(64 * w + static_cast<std::size_t>(std::countr_zero(bits)));
    hidden = 0;
  }
  return n;
}

// Finds the holes among the first `count` places of a run. Returns how many. removed: a bit for each place, the lowest first.
inline std::size_t find_holes(const std::uint64_t* removed, std::size_t count, Fill& fill) noexcept {
  return list_places(removed, 0, 0, count, fill.to.data());
}

// Finds the survivors behind the first `kept` places. No birth stands there: the holes without a birth are behind all births,
// and are as many as the places behind `kept`.
inline void find_fill(const std::uint64_t* removed, std::size_t count, std::size_t kept, Fill& fill) noexcept {
  fill.count = list_places(removed, ~std::uint64_t{0}, kept, count, fill.from.data());
}

// Applies the rule to all `count` places once the runs are filled: the first kept[run] places of each run are taken. Calls
// move(from, to, n) to move n consecutive elements. Returns how many places are taken.
template <class Move>
std::size_t for_each_run_fill(std::span<const std::size_t> kept, std::size_t count, Move&& move) noexcept {
  std::size_t end = 0;
  for (const std::size_t n : kept) end += n;
  if (end == count) return end;
  struct Places {
    std::size_t at, end;
  };
  const auto free_of = [=](std::size_t run) { return Places{run * fill_run + kept[run], std::min((run + 1) * fill_run, end)}; };
  const auto behind_of = [=](std::size_t run) { return Places{std::max(run * fill_run, end), run * fill_run + kept[run]}; };
  const std::size_t last = end / fill_run;  // the run in which the new end is
  std::size_t into = 0, out_of = last;
  Places to = free_of(into), from = behind_of(out_of);
  for (;;) {
    while (to.at >= to.end) {
      if (into == last) return end;
      to = free_of(++into);
    }
    while (from.at >= from.end) from = behind_of(++out_of);
    const std::size_t n = std::min(to.end - to.at, from.end - from.at);
    move(from.at, to.at, n);
    from.at += n;
    to.at += n;
  }
}

}  // namespace dvdx
