// Cuts a scene with springs between particles into parts that are stepped apart: the owner of each particle, the halo that its
// springs reach, and the particles that parts send and receive. Nothing here communicates with other processes.
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

// The particles that a part sends to another and receives from it: indices into Part::particles, in the whole's order.
struct Neighbour {
  std::uint32_t part = 0;
  std::vector<std::uint32_t> sent, received;
};

struct Part {
  // Indices in the whole scene: the particles that the part owns, and the halo, other parts' particles that springs join to
  // them. They are in the order in which a particle sums its springs; for a list with swept_rows(), row by row.
  std::vector<std::uint32_t> particles;
  std::vector<std::uint8_t> is_own;   // for each particle: 1 or 0
  std::vector<std::uint8_t> is_told;  // for each particle: 1 if it is sent to a neighbour
  std::vector<Neighbour> neighbours;  // parts that share springs with this one, ascending
  std::size_t own = 0;                // number of own particles
  std::size_t springs = 0, cut = 0;   // springs that reach an own particle; those of them that another part shares
  // Exchange::pulses_per_telling. If it is more than 1, the halo is as deep as springs reach in that many pulses.
  std::uint32_t pulses_per_telling = 1;
  // For PartContext::sweeps, for networks by `sequential` that are no sheets. The part's own particles form whole pieces of a
  // few thousand particles each, or whole rows of lists that are swept by rows.
  std::optional<SweptPart> sweeps{};
};

// Returns the number of halo exchanges in a sub-step of networks by `sequential`: 1 for a sheet and for a list with
// swept_rows(), 0 for several equal sheets, which stay whole. Other networks exchange twice by symmetric sweeps, once by
// forward sweeps, for each colour of the springs between pieces; at least once.
[[nodiscard]] DVDX_EXPORT std::uint32_t tellings_of_sweeps(const Scene& scene, std::size_t count);

// Returns the pulses between exchanges for a sheet in parts of whole rows; the smallest part has `fewest_rows`. More than 1
// only for one sheet by `leapfrog` without damping, air, motions, skins and meet, if the smallest part is large beside the rows
// that these pulses reach and does not fit in a core's cache.
[[nodiscard]] DVDX_EXPORT std::uint32_t pulses_per_telling(const Scene& scene, const Grid& sheet, std::uint64_t fewest_rows);

// Returns the rows of a list that `sequential` walks as a sheet, like a grid. The list has at least three rows of at least 16
// particles (32 if springs lead two rows or columns). Its springs lead where a grid's lead, or across a side of two triangles
// from corner to corner, and join no pair twice. Either the particles are numbered row by row and more than half of the places
// for springs are filled, or they are numbered in any order and each kind of spring that occurs is everywhere. The result has
// rows, columns, and a bend that is not 0 if springs lead two rows or columns; its other fields mean nothing. None for other
// scenes. stripes() alone knows which particles form a row.
[[nodiscard]] DVDX_EXPORT std::optional<Grid> swept_rows(const Scene& scene, std::size_t count);

// Returns the number of rows of a sheet that must stay in one part: for `sequential` two bands, which its sweeps take one after
// the other; for other schemes 1.
[[nodiscard]] DVDX_EXPORT std::size_t rows_kept_together(const Scene& scene, const Grid& sheet);

// The halo rows that a part holds of the part above it (with lesser row numbers) and of the part below it, so that its own rows
// are right after the given pulses or, by `sequential`, after a sub-step.
struct RowsHeld {
  std::uint64_t above = 0, below = 0;
};
[[nodiscard]] DVDX_EXPORT RowsHeld rows_held(const Scene& scene, const Grid& sheet, std::uint32_t pulses);

// Returns the owner of each of `count` particles, in equal shares as far as possible. A part owns neighbouring particles in
// memory order; a sheet, or a list with swept_rows(), is cut by whole rows (rows_kept_together() of them). By `sequential`
// several equal sheets stay whole each, and so do a list's pieces.
[[nodiscard]] DVDX_EXPORT std::vector<std::uint32_t> stripes(const Scene& scene, std::size_t count, std::uint32_t parts);

// Returns the springs as pairs of particles, the lesser number first, a pair once for each of its springs: the graph to be cut.
[[nodiscard]] DVDX_EXPORT std::vector<Pair> joined(const Scene& scene, std::size_t count);

// owner: one for each particle. By `sequential` an owner that stripes() would not give may be refused: sweeps go through
// rows_kept_together() rows of a sheet at once, and a part's rows must follow each other; through whole sheets if several are
// equal; and through whole pieces of other networks.
[[nodiscard]] DVDX_EXPORT Expected<Part> part_of(const Scene& scene, std::span<const std::uint32_t> owner, std::uint32_t part);

// Returns the part that stripes() gives to a sheet's rows, made of these rows alone: no list is as long as the scene. None if
// the scene is not one sheet, if pairs are summed one by one (`accumulate`), or in air.
[[nodiscard]] DVDX_EXPORT std::optional<Part> part_of_sheet(const Scene& scene, std::size_t count, std::uint32_t parts,
                                                            std::uint32_t part);

// The rates of some rows of a sheet bound the frequency of its springs. The rates of all rows are the maxima, number by number.
struct SheetRates {
  double of_k = 0, of_c = 0;  // 1/s^2, 1/s: the highest w_a S_a + w_b S_b of the springs that begin in them, S of k or c
  double w = 0;               // 1/kg, the highest
};
// Returns the rates of rows first, ..., end - 1 of a scene that is one sheet with nothing torn. Any other scene gives 0 for
// all.
[[nodiscard]] DVDX_EXPORT SheetRates rates_of_rows(const Scene& scene, std::uint64_t first, std::uint64_t end);

// Returns the limit of the whole's sub-steps as its plan has it, with two differences: `frequency` is the bound, and `particle`
// is 0. None for a scene that is no sheet, and if the sub-steps are not safe in any position or too many: the plan's
// eigenvalues then decide whether they are refused.
[[nodiscard]] DVDX_EXPORT std::optional<NetworkLimit> limit_of_sheet(const Scene& scene, double step, const SheetRates& all);

// Returns the scene of a part. It has numbers, fixed and kinematic particles and springs of its own, in the whole's order.
// Origin, contacts, motions and values that are alike for all particles stay. Skins stay, each with the particles that the part
// has. Scenes with constraints or tethers have no parts.
[[nodiscard]] DVDX_EXPORT Scene scene_of(const Scene& whole, const Part& part);

}  // namespace dvdx
