// The rows and columns of a sheet whose particles are numbered in any order, from its springs alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

struct SheetPlaces {
  std::size_t rows = 0, columns = 0;
  std::vector<std::uint32_t> of;  // place of each particle, row by row
};

// Finds the places of a sheet from its springs, no two of which join the same particles. It has at least three rows and
// columns. Springs lead from each particle to the next of its row and of its column. Others lead, everywhere in the sheet or
// nowhere, along either diagonal, to the second next of its row and of its column, or a row and two columns and two rows and a
// column on. A sheet that lacks a spring, or has another, gives none. Rows may be what another reader would call columns.
[[nodiscard]] std::optional<SheetPlaces> sheet_places(std::span<const JoinedPair> springs, std::size_t count);

}  // namespace dvdx
