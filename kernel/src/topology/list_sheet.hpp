// A list of springs that is a sheet: its particles stand in rows, and each spring leads to one of the places where a grid's
// springs lead, or those across a side of two triangles. Sweeps walk it in strands, as they walk a grid, with numbers of each
// spring's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

struct ListSheet {
  std::size_t rows = 0, columns = 0;
  std::size_t reach = 1;               // rows and columns that a spring leads across: 1, or with bends 2
  std::vector<std::uint32_t> place{};  // of each particle, row by row; empty where they stand as they are numbered
  [[nodiscard]] std::size_t phases() const noexcept { return 2 * reach; }
  [[nodiscard]] std::size_t place_of(std::size_t particle) const noexcept { return place.empty() ? particle : place[particle]; }
  bool operator==(const ListSheet&) const = default;
};

// The sheet that a scene's springs are, as joined_pairs() lists them, or none: also where a pair is joined twice; where half of
// all places in the strands or more would hold no spring, or rows are shorter than 16 particles (with bends 32), as colours are
// then faster; where so large a sheet has few bands, which threads share; and where triangles that meet air lead farther than
// to the next row. Where particles are not numbered row by row, springs of each kind that there is must be everywhere. Rows may
// be the caller's columns.
[[nodiscard]] std::optional<ListSheet> list_sheet(const Scene& scene, std::span<const JoinedPair> springs, std::size_t count);
// Whether each spring leads where one of the sheet may, and no two lead alike.
[[nodiscard]] bool fits(std::span<const JoinedPair> springs, const ListSheet& sheet);

// Rows of a sheet that a sweep takes together, all springs of one direction before the next.
[[nodiscard]] std::size_t rows_of_band(std::size_t columns) noexcept;

enum class SpringsAre : std::uint8_t { in_rows, any };  // in_rows: ropes and sheets (Lines::rows)
// Whether no particle has more than two. Springs that are torn count: what tears changes no line of others.
[[nodiscard]] bool are_ropes(std::span<const JoinedPair> springs, std::size_t count);

// The sheet that a part is told its `count` particles stand in; sweeps.columns is not 0.
[[nodiscard]] ListSheet given_sheet(const SweptPart& sweeps, std::size_t count) noexcept;

// Directions of the springs, in the order of the neighbour's number; what they are made of is each spring's own.
[[nodiscard]] std::vector<GridDirection> directions_of(std::span<const JoinedPair> springs, const ListSheet& sheet);

}  // namespace dvdx
