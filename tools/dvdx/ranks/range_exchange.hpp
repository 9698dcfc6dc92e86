// Sends particles' values from the rank whose range holds them to the rank that asks for them, and back. No rank holds all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/layouts/column.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/ranks.hpp"
#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {

[[nodiscard]] inline RankShare share_of(const Ranks& ranks) noexcept {
  return {.rank = static_cast<std::size_t>(ranks.rank()), .ranks = static_cast<std::size_t>(ranks.count())};
}

// Which of a scene's particles a state has.
struct Held {
  Ranks* ranks = nullptr;  // null: all of them
  std::size_t first = 0;   // otherwise from this one on; other ranks have the others
};

// All ranks must call all members.
class RangeExchange {
 public:
  // numbers: which of the scene's `all` particles this rank asks for, in any order. places: the index of each in this rank's
  // columns; empty: in that order.
  RangeExchange(Ranks& ranks, std::size_t all, std::span<const std::uint32_t> numbers,
                std::span<const std::uint32_t> places = {});
  // For particles that are numbered in some order, with gaps: the particles of all ranks are cut into ranges in this order.
  // numbers: of the particles in this rank's columns, ascending; no two ranks have the same.
  [[nodiscard]] static RangeExchange in_order(Ranks& ranks, std::span<const std::int64_t> numbers);

  [[nodiscard]] std::size_t all() const noexcept { return all_; }

  template <class T>
  void from_ranges(const Column<T>& range, const Column<T>& mine);
  // Each particle must be asked for by one rank, once.
  template <class T>
  void to_ranges(const Column<T>& mine, const Column<T>& range);
  void from_ranges(std::span<const std::uint32_t> range, std::span<std::uint32_t> mine);
  void to_ranges(std::span<const std::uint32_t> mine, std::span<std::uint32_t> range);
  // Columns and clock.
  template <class T>
  void from_ranges(const State<T>& range, State<T>& mine);
  template <class T>
  void to_ranges(const State<T>& mine, State<T>& range);

 private:
  using Lists = std::vector<std::vector<std::uint32_t>>;  // one for each rank
  RangeExchange(Ranks& ranks, std::size_t all);
  template <class Number, class From, class To>
  void exchange(const From& from, const Lists& outgoing, const To& to, const Lists& incoming);

  Ranks* ranks_;
  std::size_t all_;
  Lists asked_;  // indices in this rank's columns of the particles in each rank's range
  Lists given_;  // indices in this rank's range of the particles that each rank asks for
};

}  // namespace dvdx::tool
