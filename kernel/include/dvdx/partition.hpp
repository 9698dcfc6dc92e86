// A scene whose springs join particles, cut into parts that are stepped apart: who owns which particle, which ones of others
// its springs reach, and what is told to whom. Nothing here talks to other processes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/export.h"
#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

// The halo by which a part tells another and is told: places in its own list of particles, both in the order of their numbers.
struct Neighbour {
  std::uint32_t part = 0;
  std::vector<std::uint32_t> sent, received;
};

struct Part {
  // Numbers in the whole scene: those that the part owns, and those of others that springs join to them (the halo). They stand
  // in the order in which a particle sums its springs; of a list with swept_rows(), row by row.
  std::vector<std::uint32_t> particles;
  std::vector<std::uint8_t> is_own;   // of each of them: 1, or 0
  std::vector<std::uint8_t> is_told;  // likewise: whether a neighbour is told of it
  std::vector<Neighbour> neighbours;  // parts that share springs with this one, ascending
  std::size_t own = 0;                // particles
  std::size_t springs = 0, cut = 0;   // that reach an own particle; and of these, those that another part shares
  // Exchange::pulses_per_telling. Where it is more than 1 the halo is as deep as springs reach in so many pulses.
  std::uint32_t pulses_per_telling = 1;
  // For PartContext::sweeps, of networks by `sequential` that are no sheets: the part's own particles stand in whole pieces,
  // which are few thousand particles each; or in whole rows, of lists that are swept by rows.
  std::optional<SweptPart> sweeps{};
};

// How often parts tell a halo in a sub-step of networks by `sequential`: once of a sheet and of a list with swept_rows(), of
// others twice for each colour of the springs that lead from piece to piece.
[[nodiscard]] DVDX_EXPORT std::uint32_t tellings_of_sweeps(const Scene& scene, std::size_t count);

// The pulses between tellings of a sheet in parts of whole rows, the least of which has `fewest_rows`: more than 1 for
// `leapfrog` without damping, air and motions, where a part is large beside the rows that so many pulses reach, and does not
// fit in a core's cache.
[[nodiscard]] DVDX_EXPORT std::uint32_t pulses_per_telling(const Scene& scene, const Grid& sheet, std::uint64_t fewest_rows);

// The rows of a list that `sequential` walks as a sheet, as it walks a grid: three rows or more of at least 16 particles (32
// where springs lead two rows or columns); springs that lead where a grid's lead, or across a side of two triangles from corner
// to corner, no pair joined twice. Particles stand in rows as they are numbered, and more than half of these places are filled;
// or they are numbered in any order, and springs of each kind that there is are everywhere. The grid has rows, columns, and a
// bend that is not 0 where springs lead two rows or columns; nothing else in it means anything. None of other scenes. Which
// particles stand in a row stripes() alone knows.
[[nodiscard]] DVDX_EXPORT std::optional<Grid> swept_rows(const Scene& scene, std::size_t count);

// Rows of a sheet that one part must have together: of `sequential` two bands, which its sweeps take one after the other; of
// other schemes 1.
[[nodiscard]] DVDX_EXPORT std::size_t rows_kept_together(const Scene& scene, const Grid& sheet);

// The rows that a part holds of the part above it (of lesser rows) and of the one below it, so that its own are right after so
// many pulses or, by `sequential`, a sub-step.
struct RowsHeld {
  std::uint64_t above = 0, below = 0;
};
[[nodiscard]] DVDX_EXPORT RowsHeld rows_held(const Scene& scene, const Grid& sheet, std::uint32_t pulses);

// The owner of each of `count` particles: particles side by side as they stand in memory, a sheet by whole rows
// (rows_kept_together of them), as many for each part as can be, a list with swept_rows() likewise. By `sequential` several
// sheets that are alike stay whole, and so do a list's pieces.
[[nodiscard]] DVDX_EXPORT std::vector<std::uint32_t> stripes(const Scene& scene, std::size_t count, std::uint32_t parts);

// The springs as pairs of particles, the lesser number first, each pair as often as springs join it: what a graph is cut by.
[[nodiscard]] DVDX_EXPORT std::vector<Pair> joined(const Scene& scene, std::size_t count);

// owner: of each particle. By `sequential` one that stripes() would not give may be refused: sweeps go through
// rows_kept_together() rows of a sheet, a part's one after the other; through whole sheets where several are alike; and through
// whole pieces of other networks.
[[nodiscard]] DVDX_EXPORT Expected<Part> part_of(const Scene& scene, std::span<const std::uint32_t> owner, std::uint32_t part);

// The part that stripes() gives to a sheet's rows, made of these rows alone: nothing is as long as the scene. None where the
// scene is not one sheet, where pairs are summed one by one (`accumulate`), and in air.
[[nodiscard]] DVDX_EXPORT std::optional<Part> part_of_sheet(const Scene& scene, std::size_t count, std::uint32_t parts,
                                                            std::uint32_t part);

// The rates of some rows of a sheet: how fast its springs can swing. The rates of all rows are the highest, number by number.
struct SheetRates {
  double of_k = 0, of_c = 0;  // 1/s^2, 1/s: the highest w_a S_a + w_b S_b of the springs that begin in them, S of k or c
  double w = 0;               // 1/kg, the highest
};
// The rates of rows first, ..., end - 1 of a scene that is one sheet with nothing torn. Any other scene gives 0 for all.
[[nodiscard]] DVDX_EXPORT SheetRates rates_of_rows(const Scene& scene, std::uint64_t first, std::uint64_t end);

// The limit of the whole's sub-steps, as its plan tells it, with two differences: `frequency` is the bound, and `particle` is
// not looked for. None where the plan's eigenvalues decide whether so few sub-steps are refused, and for a scene that is no
// sheet.
[[nodiscard]] DVDX_EXPORT std::optional<NetworkLimit> limit_of_sheet(const Scene& scene, double step, const SheetRates& all);

// The scene of a part: its own numbers, fixed and kinematic particles, springs, in the whole's order; origin, contacts, motions
// and what is alike for all particles as they were. Skins stay, each with the particles that the part has. Scenes with
// constraints or tethers have no parts.
[[nodiscard]] DVDX_EXPORT Scene scene_of(const Scene& whole, const Part& part);

}  // namespace dvdx
