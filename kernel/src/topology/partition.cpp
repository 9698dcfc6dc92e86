// How a scene's particles may be shared among parts, and what parts tell each other.
#include "dvdx/partition.hpp"

#include <algorithm>

#include "topology/list_sheet.hpp"
#include "topology/particle_order.hpp"
#include "topology/topology.hpp"
#include "topology/whole.hpp"

namespace dvdx {

std::optional<Grid> swept_rows(const Scene& scene, std::size_t count) {
  const JoinedScene joined = joined_anywhere(scene, count);
  const auto& list = joined.topology->list_sheet();
  return list ? std::optional(rows_of(*list)) : std::nullopt;
}

std::size_t rows_kept_together(const Scene& scene, const Grid& sheet) {
  return scene.coupling.scheme == Scheme::sequential ? 2 * rows_of_band(sheet.columns) : 1;
}

std::vector<std::uint32_t> stripes(const Scene& scene, std::size_t count, std::uint32_t parts) {
  const Whole whole(scene, count);
  const Topology& topology = whole.topology();
  std::vector<std::uint32_t> owner(count);
  if (whole.has_pieces) {
    const ParticleOrder& order = topology.order();
    const auto owner_of_piece = [&](std::size_t piece) {
      return static_cast<std::uint32_t>(order.pieces[piece] * parts / order.size);
    };
    for (std::uint32_t i = 0; i < count; ++i) owner[i] = owner_of_piece(whole.piece_of(i));
    return owner;
  }
  std::size_t together = std::max<std::size_t>(1, whole.stacked);
  if (whole.rows) together = whole.rows->columns * rows_kept_together(scene, *whole.rows);
  const std::size_t units = (count + together - 1) / together;
  for (std::size_t i = 0; i < count; ++i) {
    owner[i] = static_cast<std::uint32_t>((topology.place_of(i) / together) * parts / units);
  }
  return owner;
}

std::vector<Pair> joined(const Scene& scene, std::size_t count) {
  const std::vector<Vec3> nowhere(count);  // lengths do not matter
  std::vector<Pair> pairs;
  for (const JoinedPair& pair : joined_pairs(scene, nowhere)) pairs.push_back({pair.a, pair.b});
  return pairs;
}

std::uint32_t tellings_of_sweeps(const Scene& scene, std::size_t count) {
  if (SteppedGrid(scene, count).own() != nullptr) return 1;
  const Whole whole(scene, count);
  if (whole.rows) return 1;
  if (!whole.has_pieces) return 0;
  const std::uint32_t colours = whole.colours;
  const bool is_symmetric = scene.coupling.sweeps == SweepOrder::symmetric;
  return (colours == 0 ? 0 : colours - 1) + 1 + (is_symmetric ? colours : 0);
}

std::uint32_t pulses_per_telling(const Scene& scene, const Grid& sheet, std::uint64_t fewest_rows) {
  constexpr std::uint32_t pulses = 4;
  constexpr std::uint64_t large = std::uint64_t{1} << 18U;  // particles: 7 MB in float32
  const bool goes_by_rows = scene.networks.size() == 1 && scene.coupling.scheme == Scheme::leapfrog && sheet.damping == 0 &&
                            !sheet.aerodynamics && scene.motions.empty() && scene.skins.empty() && !scene.meet;
  const bool is_large = fewest_rows * sheet.columns >= large && fewest_rows >= 16 * pulses * reach_of(sheet);
  return goes_by_rows && is_large ? pulses : 1;
}

// A part of a swept sheet goes through all bands that its own rows depend on. Bands of even number are swept first, and again
// last. Each reaches into the band below it. A part begins with a band of even number (rows_kept_together), and ends with one
// of odd number. This last band waits for the first sweep of the band below it. The part's first band waits for the band above
// it, which waits for the first sweep of the one above that.
RowsHeld rows_held(const Scene& scene, const Grid& sheet, std::uint32_t pulses) {
  if (scene.coupling.scheme != Scheme::sequential) return {pulses * reach_of(sheet), pulses * reach_of(sheet)};
  const std::uint64_t band = rows_of_band(sheet.columns);
  return {.above = 2 * band, .below = band + reach_of(sheet)};
}

}  // namespace dvdx
