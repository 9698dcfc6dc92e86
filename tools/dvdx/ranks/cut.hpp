// A scene's particles shared out among ranks, by counting: who has how many, which springs lead from one to another, and what
// is sent across them.
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
  blocks,   // of a sheet: rows and columns
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

  // That are sent together, positions too, by parts whose halo is so many times as deep (dvdx/partition.hpp).
  std::uint64_t pulses = 1;

  // Particles of the fullest rank over the mean.
  [[nodiscard]] double imbalance() const noexcept;
};

[[nodiscard]] Cut cut_of_ranges(std::uint64_t particles, std::uint64_t ranks);

// For a sheet, without a list of its springs: at any size. rows_of_ranks x columns_of_ranks ranks, at most as many as there are
// rows and columns.
[[nodiscard]] Cut cut_of_sheet(const Grid& grid, std::uint64_t rows_of_ranks, std::uint64_t columns_of_ranks);

// For a sheet by `sequential`: rows_kept_together() and rows_held() of dvdx/partition.hpp.
[[nodiscard]] Cut cut_of_swept_sheet(const Grid& grid, std::uint64_t ranks, std::uint64_t rows_together, const RowsHeld& held);
// The factors of so many ranks that cut fewest springs; none where no two fit the sheet.
[[nodiscard]] std::optional<std::array<std::uint64_t, 2>> best_blocks(const Grid& grid, std::uint64_t ranks);

// For pairs of particles, by the rank that owns each particle.
[[nodiscard]] Cut cut_of_pairs(std::span<const Pair> springs, std::span<const std::uint32_t> owner, std::uint64_t ranks);

// The owner of each particle, by METIS; none where dvdx was built without it, or there are more ranks than particles.
[[nodiscard]] std::optional<std::vector<std::uint32_t>> owners_by_metis(std::span<const Pair> springs, std::size_t particles,
                                                                        std::uint64_t ranks);

// All springs of a scene's networks.
[[nodiscard]] std::vector<Pair> springs_of(const Scene& scene);
// The sheet that holds all particles, or null; by `accumulate` it is a list.
[[nodiscard]] const Grid* only_sheet(const Scene& scene, std::uint64_t particles);

}  // namespace dvdx::tool
