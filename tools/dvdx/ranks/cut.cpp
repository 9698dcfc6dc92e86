#include "ranks/cut.hpp"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>
#include <variant>

#ifdef DVDX_METIS
#include <metis.h>
#endif

namespace dvdx::tool {
namespace {

// Returns the index at which piece k begins, if `all` indices are cut as evenly as possible: index i is in piece i parts / all.
std::uint64_t begin_of(std::uint64_t all, std::uint64_t parts, std::uint64_t k) { return (k * all + parts - 1) / parts; }

struct Direction {
  std::uint64_t down = 0;
  std::int64_t right = 0;
};

std::vector<Direction> directions_of(const Grid& grid) {
  std::vector<Direction> all;
  const auto add = [&](double k, std::initializer_list<Direction> some) {
    if (k != 0 || grid.damping != 0) all.insert(all.end(), some);
  };
  add(grid.structural, {{0, 1}, {1, 0}});
  add(grid.shear, {{1, 1}, {1, -1}});
  add(grid.bend, {{0, 2}, {2, 0}});
  return all;
}

// One axis of a rank's rectangle of a sheet.
struct Piece {
  std::uint64_t first = 0, length = 0;
  std::uint64_t all = 0, parts = 1;  // of the sheet

  // Whether the sheet has index `at`, and which piece owns it. Indices count from the beginning of the piece, which is taken as
  // `taken` long (`length`, or less): those from `taken` on lie behind it.
  [[nodiscard]] bool is_there(std::int64_t at, std::int64_t taken) const noexcept {
    return at < 0 ? first >= static_cast<std::uint64_t>(-at)
                  : at < taken || first + length + static_cast<std::uint64_t>(at - taken) < all;
  }
  [[nodiscard]] std::uint64_t owner(std::int64_t at, std::int64_t taken) const noexcept {
    const auto place =
        at < 0 ? first - static_cast<std::uint64_t>(-at)
               : first + (at < taken ? static_cast<std::uint64_t>(0) : length + static_cast<std::uint64_t>(at - taken));
    return place * parts / all;
  }
};
struct Block {
  Piece rows, columns;
};

// Returns from how many of the `length` indices from `first` on a step of `by` stays in a sheet that is `all` long.
std::uint64_t ends_within(std::uint64_t first, std::uint64_t length, std::uint64_t all, std::int64_t by) {
  const auto low = std::max<std::int64_t>(static_cast<std::int64_t>(first), by < 0 ? -by : 0);
  const auto high = std::min<std::int64_t>(static_cast<std::int64_t>(first + length),
                                           static_cast<std::int64_t>(all) - std::max<std::int64_t>(by, 0));
  return high > low ? static_cast<std::uint64_t>(high - low) : 0;
}

// Returns from how many of a piece's `length` indices a step of `by` stays in the piece.
std::uint64_t ends_inside(std::uint64_t length, std::int64_t by) {
  const auto far = static_cast<std::uint64_t>(by < 0 ? -by : by);
  return length > far ? length - far : 0;
}

struct BlockCount {
  std::uint64_t springs = 0, inner = 0, halo = 0, neighbours = 0;
};

using Steps = std::set<std::pair<std::int64_t, std::int64_t>>;  // rows, columns
using Owners = std::set<std::pair<std::uint64_t, std::uint64_t>>;

// Counts the particles of others that springs reach from a block of `rows` x `columns`, and collects their owners.
std::uint64_t halo_of(const Block& block, std::int64_t rows, std::int64_t columns, const Steps& steps, Owners& owners) {
  const auto is_inside = [&](std::int64_t r, std::int64_t c) { return r >= 0 && r < rows && c >= 0 && c < columns; };
  const auto is_reached = [&](std::int64_t r, std::int64_t c) {
    return std::any_of(steps.begin(), steps.end(),
                       [&](const auto& step) { return is_inside(r - step.first, c - step.second); });
  };
  constexpr std::int64_t reach = 2;
  std::uint64_t halo = 0;
  for (std::int64_t r = -reach; r < rows + reach; ++r) {
    for (std::int64_t c = -reach; c < columns + reach; ++c) {
      if (is_inside(r, c) || !block.rows.is_there(r, rows) || !block.columns.is_there(c, columns) || !is_reached(r, c))
        continue;
      ++halo;
      owners.emplace(block.rows.owner(r, rows), block.columns.owner(c, columns));
    }
  }
  return halo;
}

BlockCount count_of(const Block& block, const std::vector<Direction>& directions) {
  BlockCount count;
  const auto& [rows, columns] = block;
  Steps steps;
  for (const auto& [down, right] : directions) {
    for (const std::int64_t sign : {1, -1}) {
      const auto by_rows = sign * static_cast<std::int64_t>(down);
      const auto by_columns = sign * right;
      const auto inside = ends_inside(rows.length, by_rows) * ends_inside(columns.length, by_columns);
      count.springs += ends_within(rows.first, rows.length, rows.all, by_rows) *
                           ends_within(columns.first, columns.length, columns.all, by_columns) -
                       (sign < 0 ? inside : 0);
      if (sign > 0) count.inner += inside;
      steps.emplace(by_rows, by_columns);
    }
  }
  // Beyond a few rows and columns, each further row or column adds the same number to the halo.
  const auto taken = [](const Piece& piece) { return static_cast<std::int64_t>(std::min<std::uint64_t>(piece.length, 6)); };
  Owners owners;
  count.halo = halo_of(block, taken(rows), taken(columns), steps, owners);
  const std::uint64_t more_rows = rows.length - static_cast<std::uint64_t>(taken(rows));
  const std::uint64_t more_columns = columns.length - static_cast<std::uint64_t>(taken(columns));
  const std::uint64_t base = count.halo;
  if (more_rows > 0) count.halo += more_rows * (halo_of(block, taken(rows) + 1, taken(columns), steps, owners) - base);
  if (more_columns > 0) count.halo += more_columns * (halo_of(block, taken(rows), taken(columns) + 1, steps, owners) - base);
  count.neighbours = owners.size();
  return count;
}

void take(Cut& cut, std::uint64_t particles, std::uint64_t springs, std::uint64_t halo, std::uint64_t neighbours,
          std::uint64_t times) {
  cut.fewest = cut.all_particles == 0 ? particles : std::min(cut.fewest, particles);
  cut.particles = std::max(cut.particles, particles);
  cut.springs = std::max(cut.springs, springs);
  cut.halo = std::max(cut.halo, halo);
  cut.neighbours = std::max(cut.neighbours, neighbours);
  cut.all_particles += times * particles;
  cut.all_halo += times * halo;
  cut.all_neighbours += times * neighbours;
}

// Returns one piece of each kind along one axis. Pieces that are two away from both ends count alike if they have the same
// length, because no spring reaches beyond a piece's neighbours. Pieces shorter than 2 are each a kind of their own.
std::vector<std::pair<std::uint64_t, std::uint64_t>> kinds_of(std::uint64_t all, std::uint64_t parts) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> kinds;  // a piece, and the number of pieces of its kind
  const std::uint64_t least = all / parts;
  std::array<std::optional<std::size_t>, 2> between;
  for (std::uint64_t k = 0; k < parts; ++k) {
    if (least < 2 || k < 2 || k + 2 >= parts) {
      kinds.emplace_back(k, 1);
      continue;
    }
    auto& kind = between.at(begin_of(all, parts, k + 1) - begin_of(all, parts, k) - least);
    if (!kind) {
      kind = kinds.size();
      kinds.emplace_back(k, 0);
    }
    ++kinds[*kind].second;
  }
  return kinds;
}

Piece piece_of(std::uint64_t all, std::uint64_t parts, std::uint64_t k) {
  const auto first = begin_of(all, parts, k);
  return {.first = first, .length = begin_of(all, parts, k + 1) - first, .all = all, .parts = parts};
}

}  // namespace

std::string_view name(Sharing sharing) noexcept {
  switch (sharing) {
    case Sharing::ranges:
      return "ranges";
    case Sharing::stripes:
      return "stripes";
    case Sharing::blocks:
      return "blocks";
    case Sharing::metis:
      break;
  }
  return "METIS";
}

double Cut::imbalance() const noexcept {
  return all_particles == 0 ? 1
                            : static_cast<double>(particles) * static_cast<double>(ranks) / static_cast<double>(all_particles);
}

Cut cut_of_ranges(std::uint64_t particles, std::uint64_t ranks) {
  Cut cut{.sharing = Sharing::ranges, .ranks = ranks};
  cut.particles = (particles + ranks - 1) / ranks;
  cut.fewest = particles / ranks;
  cut.all_particles = particles;
  return cut;
}

Cut cut_of_sheet(const Grid& grid, std::uint64_t rows_of_ranks, std::uint64_t columns_of_ranks) {
  Cut cut{.sharing = columns_of_ranks == 1 ? Sharing::stripes : Sharing::blocks, .ranks = rows_of_ranks * columns_of_ranks};
  const auto directions = directions_of(grid);
  for (const auto& [down, right] : directions) {
    cut.all_springs += ends_within(0, grid.rows, grid.rows, static_cast<std::int64_t>(down)) *
                       ends_within(0, grid.columns, grid.columns, right);
  }
  std::uint64_t inner = 0;
  for (const auto& [i, as_i] : kinds_of(grid.rows, rows_of_ranks)) {
    const Piece rows = piece_of(grid.rows, rows_of_ranks, i);
    for (const auto& [j, as_j] : kinds_of(grid.columns, columns_of_ranks)) {
      const Block block{.rows = rows, .columns = piece_of(grid.columns, columns_of_ranks, j)};
      const auto count = count_of(block, directions);
      take(cut, block.rows.length * block.columns.length, count.springs, count.halo, count.neighbours, as_i * as_j);
      inner += as_i * as_j * count.inner;
    }
  }
  cut.cut_springs = cut.all_springs - inner;
  return cut;
}

Cut cut_of_swept_sheet(const Grid& grid, std::uint64_t ranks, std::uint64_t rows_together, const RowsHeld& held) {
  Cut cut{.sharing = Sharing::stripes, .ranks = ranks};
  const auto directions = directions_of(grid);
  const std::uint64_t units = (grid.rows + rows_together - 1) / rows_together;
  const auto begin = [&](std::uint64_t k) {
    return std::min<std::uint64_t>(grid.rows, begin_of(units, ranks, k) * rows_together);
  };
  const Piece columns{.first = 0, .length = grid.columns, .all = grid.columns};
  std::uint64_t fewest = grid.rows;
  std::uint64_t within = 0;
  for (std::uint64_t k = 0; k < ranks; ++k) {
    const std::uint64_t first = begin(k);
    const std::uint64_t end = begin(k + 1);
    fewest = std::min(fewest, end - first);
    if (end == first) continue;
    const Block block{.rows = {.first = first, .length = end - first, .all = grid.rows}, .columns = columns};
    const BlockCount count = count_of(block, directions);
    const std::uint64_t above = std::min(first, held.above);
    const std::uint64_t below = std::min(grid.rows - end, held.below);
    take(cut, (end - first) * grid.columns, count.springs, (above + below) * grid.columns,
         (above != 0 ? 1U : 0U) + (below != 0 ? 1U : 0U), 1);
    within += count.inner;
  }
  cut.fewest = fewest * grid.columns;
  const Block whole{.rows = {.first = 0, .length = grid.rows, .all = grid.rows}, .columns = columns};
  cut.all_springs = count_of(whole, directions).inner;
  cut.cut_springs = cut.all_springs - within;
  return cut;
}

std::optional<std::array<std::uint64_t, 2>> best_blocks(const Grid& grid, std::uint64_t ranks) {
  std::optional<std::array<std::uint64_t, 2>> best;
  double least = 0;
  for (std::uint64_t rows = 1; rows <= ranks; ++rows) {
    if (ranks % rows != 0 || rows > grid.rows || ranks / rows > grid.columns) continue;
    // Each inner boundary cuts as many springs as it is long.
    const double cut = static_cast<double>(rows - 1) * static_cast<double>(grid.columns) +
                       static_cast<double>(ranks / rows - 1) * static_cast<double>(grid.rows);
    if (best && cut >= least) continue;
    least = cut;
    best = {rows, ranks / rows};
  }
  return best;
}

Cut cut_of_pairs(std::span<const Pair> springs, std::span<const std::uint32_t> owner, std::uint64_t ranks) {
  Cut cut{.ranks = ranks};
  std::vector<std::uint64_t> particles(ranks), reaching(ranks), halo(ranks), neighbours(ranks);
  for (const auto of : owner) ++particles[of];
  std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> received;  // receiving rank, owner, particle
  for (const auto& [a, b] : springs) {
    ++reaching[owner[a]];
    if (owner[a] == owner[b]) continue;
    ++reaching[owner[b]];
    ++cut.cut_springs;
    received.emplace_back(owner[a], owner[b], static_cast<std::uint32_t>(b));
    received.emplace_back(owner[b], owner[a], static_cast<std::uint32_t>(a));
  }
  std::sort(received.begin(), received.end());
  received.erase(std::unique(received.begin(), received.end()), received.end());
  for (std::size_t n = 0; n < received.size(); ++n) {
    const auto& [rank, by, particle] = received[n];
    ++halo[rank];
    const bool is_new = n == 0 || std::get<0>(received[n - 1]) != rank || std::get<1>(received[n - 1]) != by;
    if (is_new) ++neighbours[rank];
  }
  for (std::size_t r = 0; r < ranks; ++r) take(cut, particles[r], reaching[r], halo[r], neighbours[r], 1);
  cut.fewest = *std::min_element(particles.begin(), particles.end());
  cut.all_springs = springs.size();
  return cut;
}

std::optional<std::vector<std::uint32_t>> owners_by_metis([[maybe_unused]] std::span<const Pair> springs,
                                                          [[maybe_unused]] std::size_t particles,
                                                          [[maybe_unused]] std::uint64_t ranks) {
#ifdef DVDX_METIS
  if (ranks > particles) return std::nullopt;
  if (ranks == 1) return std::vector<std::uint32_t>(particles, 0);
  std::vector<Pair> both;
  for (const auto& [a, b] : springs) {
    both.push_back({a, b});
    both.push_back({b, a});
  }
  std::sort(both.begin(), both.end());
  both.erase(std::unique(both.begin(), both.end()), both.end());
  std::vector<idx_t> first(particles + 1, 0), other;
  for (const auto& [a, b] : both) {
    ++first[a + 1];
    other.push_back(static_cast<idx_t>(b));
  }
  for (std::size_t i = 0; i < particles; ++i) first[i + 1] += first[i];
  auto vertices = static_cast<idx_t>(particles);
  auto parts = static_cast<idx_t>(ranks);
  idx_t constraints = 1, cut = 0;
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_SEED] = 1;  // the same cut each time
  std::vector<idx_t> part(particles);
  const int result = METIS_PartGraphKway(&vertices, &constraints, first.data(), other.data(), nullptr, nullptr, nullptr, &parts,
                                         nullptr, nullptr, options.data(), &cut, part.data());
  if (result != METIS_OK) return std::nullopt;
  return std::vector<std::uint32_t>(part.begin(), part.end());
#else
  return std::nullopt;
#endif
}

std::vector<Pair> springs_of(const Scene& scene) {
  std::vector<Pair> all;
  for (const Network& network : scene.networks) {
    const auto* grid = std::get_if<Grid>(&network);
    const auto& pairs = grid != nullptr ? dvdx::springs_of(*grid).pairs : std::get<Springs>(network).pairs;
    all.insert(all.end(), pairs.begin(), pairs.end());
  }
  return all;
}

const Grid* only_sheet(const Scene& scene, std::uint64_t particles) {
  if (scene.networks.size() != 1 || scene.coupling.scheme == Scheme::accumulate) return nullptr;
  const auto* grid = std::get_if<Grid>(&scene.networks[0]);
  return grid != nullptr && grid->rows * grid->columns == particles ? grid : nullptr;
}

}  // namespace dvdx::tool
