// A list of springs that is a sheet. Its particles stand in rows, and each spring leads where a grid's springs lead, or across
// a side of two triangles. Sweeps walk it in strands, as they walk a grid, with coefficients of each spring's own.
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
  std::vector<std::uint32_t> place{};  // of each particle, row by row; empty if they stand as they are numbered
  [[nodiscard]] std::size_t phases() const noexcept { return 2 * reach; }
  [[nodiscard]] std::size_t place_of(std::size_t particle) const noexcept { return place.empty() ? particle : place[particle]; }
  bool operator==(const ListSheet&) const = default;
};

// Returns the sheet that a scene's springs form, as joined_pairs() lists them, or none. Returns none too if a pair is joined
// twice, or if triangles that meet air lead farther than to the next row. Returns none if colours are faster: half of all
// places in the strands or more would hold no spring, rows are shorter than 16 particles (with bends 32), or a large sheet has
// few bands, which threads share. If particles are not numbered row by row, each kind of spring must be everywhere or nowhere.
// Rows may be the caller's columns.
[[nodiscard]] std::optional<ListSheet> list_sheet(const Scene& scene, std::span<const JoinedPair> springs, std::size_t count);
// Whether each spring leads where one of the sheet may, and no two join the same particles.
[[nodiscard]] bool fits(std::span<const JoinedPair> springs, const ListSheet& sheet);

// The number of rows that a sweep takes together, all springs of one direction before the next.
[[nodiscard]] std::size_t rows_of_band(std::size_t columns) noexcept;

enum class SpringsAre : std::uint8_t { in_rows, any };  // in_rows: ropes and sheets (Lines::rows)
// Whether no particle has more than two springs. Torn springs count, so that a tear changes no line of others.
[[nodiscard]] bool are_ropes(std::span<const JoinedPair> springs, std::size_t count);

// The sheet in which a part is told that its `count` particles stand. sweeps.columns must not be 0.
[[nodiscard]] ListSheet given_sheet(const SweptPart& sweeps, std::size_t count) noexcept;

// Returns the springs' directions, in the order of the neighbour's number. k and l are not set: they are each spring's own.
[[nodiscard]] std::vector<GridDirection> directions_of(std::span<const JoinedPair> springs, const ListSheet& sheet);

}  // namespace dvdx
