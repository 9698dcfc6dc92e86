// Counts a scene's particles shared among ranks: the particles of each rank, the springs between ranks, and the halo that ranks
// send each other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "dvdx/partition.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::tool {

enum class Sharing {
  ranges,   // particles that nothing joins, by their numbers
  stripes,  // whole rows of a sheet, or particles of a list as they stand in memory
  blocks,   // rectangles of a sheet's rows and columns
  metis,    // of any network: METIS' k-way cut of the graph
};
[[nodiscard]] std::string_view name(Sharing sharing) noexcept;

// The load of the busiest rank, and of all together.
struct Cut {
  Sharing sharing = Sharing::ranges;
  std::uint64_t ranks = 1;
  std::uint64_t particles = 0;   // of the rank with most
  std::uint64_t fewest = 0;      // of the rank with fewest
  std::uint64_t springs = 0;     // that reach a particle of the rank with most of them
  std::uint64_t halo = 0;        // particles of others that the rank with most of them receives
  std::uint64_t neighbours = 0;  // of the rank with most
  std::uint64_t all_particles = 0;
  std::uint64_t all_springs = 0;
  std::uint64_t cut_springs = 0;     // between ranks, each once
  std::uint64_t all_halo = 0;        // over all ranks
  std::uint64_t all_neighbours = 0;  // likewise: messages an exchange

  // The number of pulses sent together, with positions, by parts whose halo is that many times as deep (dvdx/partition.hpp).
  std::uint64_t pulses = 1;

  // Particles of the fullest rank over the mean.
  [[nodiscard]] double imbalance() const noexcept;
};

[[nodiscard]] Cut cut_of_ranges(std::uint64_t particles, std::uint64_t ranks);

// Counts a sheet of any size, without a list of its springs, on rows_of_ranks x columns_of_ranks ranks: at most as many as the
// sheet has rows and columns.
[[nodiscard]] Cut cut_of_sheet(const Grid& grid, std::uint64_t rows_of_ranks, std::uint64_t columns_of_ranks);

// Counts a sheet by `sequential`. rows_together, held: rows_kept_together() and rows_held() of dvdx/partition.hpp.
[[nodiscard]] Cut cut_of_swept_sheet(const Grid& grid, std::uint64_t ranks, std::uint64_t rows_together, const RowsHeld& held);
// Returns the two factors of `ranks` that cut fewest springs, or none if no two fit the sheet.
[[nodiscard]] std::optional<std::array<std::uint64_t, 2>> best_blocks(const Grid& grid, std::uint64_t ranks);

// Counts pairs of particles by the rank that owns each particle.
[[nodiscard]] Cut cut_of_pairs(std::span<const Pair> springs, std::span<const std::uint32_t> owner, std::uint64_t ranks);

// Returns each particle's owner by METIS. None: built without METIS, METIS failed, or more ranks than particles.
[[nodiscard]] std::optional<std::vector<std::uint32_t>> owners_by_metis(std::span<const Pair> springs, std::size_t particles,
                                                                        std::uint64_t ranks);

// All springs of a scene's networks.
[[nodiscard]] std::vector<Pair> springs_of(const Scene& scene);
// Returns the sheet that holds all particles, or null. By `accumulate` a sheet counts as a list.
[[nodiscard]] const Grid* only_sheet(const Scene& scene, std::uint64_t particles);

}  // namespace dvdx::tool
