#include "dvdx/partition.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "scene/particle_values.hpp"
#include "topology/list_sheet.hpp"
#include "topology/particle_order.hpp"
#include "topology/piece_colours.hpp"

namespace dvdx {
namespace {

bool is_sheet(const Scene& scene, std::size_t count) {
  return scene.coupling.scheme != Scheme::accumulate && only_grid(scene, count) != nullptr;
}

bool is_swept(const Scene& scene) { return scene.coupling.scheme == Scheme::sequential; }

std::vector<JoinedPair> joined_pairs(const Scene& scene, std::size_t count) {
  const std::vector<Vec3> nowhere(count);  // lengths do not matter
  return dvdx::joined_pairs(scene, nowhere);
}

// Particles of each of several sheets that are swept side by side; else 0.
std::size_t particles_of_stacked(const Scene& scene, std::size_t count) {
  return is_swept(scene) && stacked_grids(scene, count) ? count / scene.networks.size() : 0;
}

bool is_swept_list(const Scene& scene, std::size_t count) {
  return is_swept(scene) && !scene.networks.empty() && !is_sheet(scene, count) && particles_of_stacked(scene, count) == 0;
}

std::vector<std::uint32_t> as_numbered(std::size_t count) {
  std::vector<std::uint32_t> place(count);
  std::iota(place.begin(), place.end(), 0U);
  return place;
}

std::optional<ListSheet> swept_sheet(const Scene& scene, std::size_t count) {
  return is_swept_list(scene, count) ? list_sheet(scene, joined_pairs(scene, count), count) : std::nullopt;
}

// The rows of such a list, and whether springs lead across two.
Grid rows_of(const ListSheet& sheet) {
  return Grid{.rows = sheet.rows, .columns = sheet.columns, .bend = sheet.reach == 2 ? 1.0 : 0.0};
}

std::uint64_t reach_of(const Grid& grid) { return grid.bend != 0 ? 2 : 1; }  // rows

// The rows that parts have whole: of the scene's sheet, or of a list that sweeps walk as one.
class WholeRows {
 public:
  explicit WholeRows(const Grid& grid) : grid_(grid) {}
  explicit WholeRows(ListSheet sheet) : grid_(rows_of(sheet)), place_(std::move(sheet.place)), at_(place_.size()) {
    for (std::size_t i = 0; i < place_.size(); ++i) at_[place_[i]] = static_cast<std::uint32_t>(i);
  }
  static std::optional<WholeRows> of(const Scene& scene, std::size_t count) {
    if (is_sheet(scene, count)) return WholeRows(*only_grid(scene, count));
    auto list = swept_sheet(scene, count);
    return list ? std::optional(WholeRows(std::move(*list))) : std::nullopt;
  }

  [[nodiscard]] const Grid& grid() const noexcept { return grid_; }
  // The place of a particle, row by row; and the other way.
  [[nodiscard]] std::size_t place(std::size_t particle) const noexcept { return place_.empty() ? particle : place_[particle]; }
  [[nodiscard]] std::uint32_t at(std::size_t place) const noexcept {
    return place_.empty() ? static_cast<std::uint32_t>(place) : at_[place];
  }

 private:
  Grid grid_;
  std::vector<std::uint32_t> place_, at_;  // empty where particles stand as they are numbered
};

// Where each particle of what is no sheet stands among those whose springs are summed: as plan/joints.cpp orders the whole
// scene.
std::vector<std::uint32_t> places(const Scene& scene, std::size_t count) {
  if (scene.networks.empty() || particles_of_stacked(scene, count) != 0) return as_numbered(count);
  return graph_order(joined_pairs(scene, count), count).of;
}

// A list that is swept, as plan/joints.cpp orders the whole scene.
struct WholeSweeps {
  WholeSweeps(const Scene& scene, std::size_t count)
      : pairs(joined_pairs(scene, count)), order(pieces_order(pairs, count)), w(count, 1) {
    for (const std::size_t i : scene.fixed) w[i] = 0;
    for (const Kinematic& followers : scene.kinematic) {
      for (const std::size_t i : followers.particles) w[i] = 0;
    }
    colour_of = colours_between_pieces(pairs, order, w);
    for (const std::uint32_t colour : colour_of) colours = std::max(colours, colour);
  }
  [[nodiscard]] std::size_t piece_of(std::uint32_t particle) const { return order.piece_of(particle); }

  std::vector<JoinedPair> pairs;
  ParticleOrder order;
  std::vector<double> w;  // 0 where fixed; else only that it is not
  std::vector<std::uint32_t> colour_of;
  std::uint32_t colours = 0;
};

// From numbers of the whole to numbers of the part.
class Renumbered {
 public:
  explicit Renumbered(const Part& part) : part_(part), in_order_(part.particles.size()) {
    std::iota(in_order_.begin(), in_order_.end(), 0U);
    std::sort(in_order_.begin(), in_order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return part.particles[a] < part.particles[b]; });
  }
  [[nodiscard]] std::optional<std::uint32_t> operator()(std::size_t number) const {
    const auto found = std::lower_bound(in_order_.begin(), in_order_.end(), number,
                                        [&](std::uint32_t a, std::size_t n) { return part_.particles[a] < n; });
    if (found == in_order_.end() || part_.particles[*found] != number) return std::nullopt;
    return *found;
  }
  [[nodiscard]] bool is_own(std::uint32_t particle) const { return part_.is_own[particle] != 0; }

 private:
  const Part& part_;
  std::vector<std::uint32_t> in_order_;
};

Scalars taken(const Scalars& values, std::span<const std::uint32_t> particles) {
  if (values.is_uniform()) return values;
  std::vector<double> each;
  each.reserve(particles.size());
  for (const std::uint32_t i : particles) each.push_back(values[i]);
  return each;
}
PerAxis taken(const PerAxis& values, std::span<const std::uint32_t> particles) {
  return values.is_uniform() ? values : PerAxis(taken(values.scalars(), particles));
}
Anchor taken(const Anchor& anchor, std::span<const std::uint32_t> particles) {
  const auto* all = std::get_if<std::vector<Vec3>>(&anchor);
  if (all == nullptr) return anchor;
  std::vector<Vec3> each;
  each.reserve(particles.size());
  for (const std::uint32_t i : particles) each.push_back((*all)[i]);
  return each;
}

// Those between its particles. In air these are those that reach an own particle, and those that share the particles of
// these with them.
std::vector<Triangle> taken(const std::vector<Triangle>& whole, const Renumbered& renumbered) {
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c] : whole) {
    const auto i = renumbered(a);
    const auto j = renumbered(b);
    const auto k = renumbered(c);
    if (i && j && k) triangles.push_back({*i, *j, *k});
  }
  return triangles;
}

// Which springs a part has: those that reach a particle of its own; or, of a list whose rows are swept, all between its rows.
enum class Taken : std::uint8_t { own, all };

Springs taken(const Springs& whole, const Renumbered& renumbered, Taken which) {
  Springs springs{.pairs = {}, .damping = whole.damping};
  springs.triangles = taken(whole.triangles, renumbered);
  if (!springs.triangles.empty()) springs.aerodynamics = whole.aerodynamics;
  std::vector<std::uint32_t> kept;
  const auto both = [&](const Pair& pair) -> std::optional<Pair> {
    const auto a = renumbered(pair[0]);
    const auto b = renumbered(pair[1]);
    if (!a || !b) return std::nullopt;
    if (which == Taken::own && !renumbered.is_own(*a) && !renumbered.is_own(*b)) return std::nullopt;
    return Pair{*a, *b};
  };
  for (std::size_t s = 0; s < whole.pairs.size(); ++s) {
    const auto pair = both(whole.pairs[s]);
    if (!pair) continue;
    springs.pairs.push_back(*pair);
    kept.push_back(static_cast<std::uint32_t>(s));
  }
  springs.stiffness = taken(whole.stiffness, kept);
  if (whole.rest_length) springs.rest_length = taken(*whole.rest_length, kept);
  springs.zero_length = taken(whole.zero_length, kept);
  for (const Pair& torn : whole.broken) {
    if (const auto pair = both(torn)) springs.broken.push_back(*pair);
  }
  return springs;
}

// The part's rows, where it holds whole ones side by side.
std::optional<Grid> rows_of(const Grid& whole, const Part& part) {
  const auto& numbers = part.particles;
  if (numbers.empty() || numbers.front() % whole.columns != 0 || numbers.size() % whole.columns != 0) return std::nullopt;
  if (numbers.back() >= whole.rows * whole.columns) return std::nullopt;  // behind its last row
  if (numbers.back() - numbers.front() + 1 != numbers.size() || numbers.size() < 2 * whole.columns) return std::nullopt;
  Grid grid = whole;
  grid.rows = numbers.size() / whole.columns;
  grid.rows_of_whole = whole.rows_of_whole != 0 ? whole.rows_of_whole : whole.rows;
  grid.broken.clear();
  for (const auto& [a, b] : whole.broken) {
    if (std::min(a, b) < numbers.front() || std::max(a, b) > numbers.back()) continue;
    grid.broken.push_back({a - numbers.front(), b - numbers.front()});
  }
  return grid;
}

// The sheets that the part has, of those side by side.
std::vector<Network> sheets_of(const Scene& whole, const Renumbered& renumbered) {
  std::vector<Network> sheets;
  for (const Network& network : whole.networks) {
    Grid grid = std::get<Grid>(network);
    const auto first = renumbered(grid.first);
    if (!first) continue;
    for (Pair& torn : grid.broken) torn = {*renumbered(torn[0]), *renumbered(torn[1])};
    grid.first = *first;
    sheets.emplace_back(std::move(grid));
  }
  return sheets;
}

// The particles that a triangle in air shares with each, ascending: air on one depends on those that two such steps reach, as a
// triangle's corners share what they weigh with their other triangles.
class SharedTriangles {
 public:
  SharedTriangles(const Scene& scene, std::size_t count) {
    for (const Network& network : scene.networks) {
      const auto* const grid = std::get_if<Grid>(&network);
      const Springs springs = grid != nullptr ? springs_of(*grid) : std::get<Springs>(network);
      if (!springs.aerodynamics) continue;
      near_.resize(count);
      for (const Triangle& triangle : springs.triangles) {
        for (const std::uint32_t i : triangle) near_[i].insert(near_[i].end(), triangle.begin(), triangle.end());
      }
    }
    for (auto& list : near_) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  // Calls use(j) for each particle that two steps or fewer lead to, some of them several times.
  template <class Use>
  void for_each_within_two(std::size_t i, const Use& use) const {
    if (near_.empty()) return;
    for (const std::uint32_t middle : near_[i]) {
      for (const std::uint32_t j : near_[middle]) use(j);
    }
  }

 private:
  std::vector<std::vector<std::uint32_t>> near_;  // empty where nothing meets air
};

}  // namespace

std::optional<Grid> swept_rows(const Scene& scene, std::size_t count) {
  const auto sheet = swept_sheet(scene, count);
  return sheet ? std::optional(rows_of(*sheet)) : std::nullopt;
}

std::size_t rows_kept_together(const Scene& scene, const Grid& sheet) {
  return scene.coupling.scheme == Scheme::sequential ? 2 * rows_of_band(sheet.columns) : 1;
}

std::vector<std::uint32_t> stripes(const Scene& scene, std::size_t count, std::uint32_t parts) {
  const auto sheet = WholeRows::of(scene, count);
  std::vector<std::uint32_t> owner(count);
  if (!sheet && is_swept_list(scene, count)) {
    const WholeSweeps whole(scene, count);
    const auto owner_of_piece = [&](std::size_t piece) {
      return static_cast<std::uint32_t>(whole.order.pieces[piece] * parts / whole.order.size);
    };
    for (std::uint32_t i = 0; i < count; ++i) owner[i] = owner_of_piece(whole.piece_of(i));
    return owner;
  }
  std::size_t together = std::max<std::size_t>(1, particles_of_stacked(scene, count));
  if (sheet) together = sheet->grid().columns * rows_kept_together(scene, sheet->grid());
  const std::size_t units = (count + together - 1) / together;
  const std::vector<std::uint32_t> summed = sheet ? std::vector<std::uint32_t>{} : places(scene, count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t place = sheet ? sheet->place(i) : summed[i];
    owner[i] = static_cast<std::uint32_t>((place / together) * parts / units);
  }
  return owner;
}

std::vector<Pair> joined(const Scene& scene, std::size_t count) {
  std::vector<Pair> pairs;
  for (const JoinedPair& pair : joined_pairs(scene, count)) pairs.push_back({pair.a, pair.b});
  return pairs;
}

std::uint32_t tellings_of_sweeps(const Scene& scene, std::size_t count) {
  if (WholeRows::of(scene, count)) return 1;
  if (!is_swept_list(scene, count)) return 0;
  const std::uint32_t colours = WholeSweeps(scene, count).colours;
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

// A part of a sheet that is swept goes through all bands that its own rows depend on. Bands of even number are swept first, and
// again last; each reaches into the band below it. A part begins with a band of even number (rows_kept_together), and ends with
// one of odd number, which waits for the first sweep of the band below it; its own first band waits for the band above it,
// which waits for the first sweep of the one above that.
RowsHeld rows_held(const Scene& scene, const Grid& sheet, std::uint32_t pulses) {
  if (scene.coupling.scheme != Scheme::sequential) return {pulses * reach_of(sheet), pulses * reach_of(sheet)};
  const std::uint64_t band = rows_of_band(sheet.columns);
  return {.above = 2 * band, .below = band + reach_of(sheet)};
}

namespace {

// The rows that a part and those on either side of it hold of each other; in numbers of the whole.
struct Told {
  std::vector<std::uint32_t> sent, received;
};
using ToldByPart = std::map<std::uint32_t, Told>;

// A sheet's rows that a part owns, side by side; owner_of: of a row.
struct OwnRows {
  std::uint64_t first = 0, end = 0;
};
template <class OwnerOf>
void hold_rows(const Grid& grid, const OwnRows& own, const OwnerOf& owner_of, const RowsHeld& depth, ToldByPart& told) {
  const auto add = [&](std::vector<std::uint32_t>& list, std::uint64_t from_row, std::uint64_t to_row) {
    for (std::uint64_t i = from_row * grid.columns; i < to_row * grid.columns; ++i) {
      list.push_back(static_cast<std::uint32_t>(i));
    }
  };
  if (own.first != 0) {
    Told& above = told[owner_of(own.first - 1)];
    add(above.sent, own.first, std::min(own.end, own.first + depth.below));
    add(above.received, own.first - depth.above, own.first);
  }
  if (own.end != grid.rows) {
    Told& below = told[owner_of(own.end)];
    add(below.sent, own.end - depth.above, own.end);
    add(below.received, own.end, std::min<std::uint64_t>(grid.rows, own.end + depth.below));
  }
}

// place_of: in the part, of a number of the whole.
template <class PlaceOf>
void add_neighbours(ToldByPart& told, const PlaceOf& place_of, Part& part) {
  const auto in_part = [&](std::vector<std::uint32_t>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    for (std::uint32_t& number : numbers) number = place_of(number);
    return std::move(numbers);
  };
  part.is_told.resize(part.particles.size());
  for (auto& [other, lists] : told) {
    part.neighbours.push_back({other, in_part(lists.sent), in_part(lists.received)});
    for (const std::uint32_t i : part.neighbours.back().sent) part.is_told[i] = 1;
  }
}

SweptPart swept_part(const WholeSweeps& whole, const Part& part, const Renumbered& renumbered) {
  SweptPart sweeps{.piece_ends = {}, .colour_of = {}, .colours = whole.colours};
  for (std::uint32_t k = 0; k < part.own; ++k) {
    const bool is_last = k + 1 == part.own || whole.piece_of(part.particles[k]) != whole.piece_of(part.particles[k + 1]);
    if (is_last) sweeps.piece_ends.push_back(k + 1);
  }
  struct Coloured {
    std::uint32_t a, b, colour;
  };
  std::vector<Coloured> springs;
  for (std::size_t s = 0; s < whole.pairs.size(); ++s) {
    const auto a = renumbered(whole.pairs[s].a);
    const auto b = renumbered(whole.pairs[s].b);
    if (!a || !b || (!renumbered.is_own(*a) && !renumbered.is_own(*b))) continue;
    springs.push_back({std::min(*a, *b), std::max(*a, *b), whole.colour_of[s]});
  }
  std::stable_sort(springs.begin(), springs.end(),
                   [](const Coloured& s, const Coloured& t) { return std::pair(s.a, s.b) < std::pair(t.a, t.b); });
  for (const Coloured& spring : springs) sweeps.colour_of.push_back(spring.colour);
  return sweeps;
}

}  // namespace

namespace {

Error refused_owner(std::span<const std::uint32_t> owner, std::size_t particle, std::string valid) {
  return {"owner[" + std::to_string(particle) + "]", std::to_string(owner[particle]), std::move(valid)};
}

std::optional<Error> refused_in_pieces(std::span<const std::uint32_t> owner, const WholeSweeps& whole) {
  std::map<std::size_t, std::uint32_t> owner_of;
  for (std::uint32_t i = 0; i < owner.size(); ++i) {
    const std::uint32_t first = owner_of.try_emplace(whole.piece_of(i), owner[i]).first->second;
    if (first == owner[i]) continue;
    return refused_owner(owner, i, std::to_string(first) + ", as of others in its piece: by sequential a piece stays whole");
  }
  return std::nullopt;
}

// A scene and the owner of each of its particles.
struct Owned {
  Owned(const Scene& of, std::span<const std::uint32_t> owner_of)
      : scene(of), owner(owner_of), sheet(WholeRows::of(scene, owner.size())) {
    if (!sheet && is_swept_list(scene, owner.size())) pieces.emplace(scene, owner.size());
  }
  // The particle at a place of a sheet's rows; else all stand as they are numbered.
  [[nodiscard]] std::uint32_t at(std::size_t place) const {
    return sheet ? sheet->at(place) : static_cast<std::uint32_t>(place);
  }
  [[nodiscard]] std::uint32_t owner_at(std::size_t place) const { return owner[at(place)]; }
  [[nodiscard]] std::uint32_t owner_of_row(std::size_t row) const { return owner_at(row * sheet->grid().columns); }

  const Scene& scene;
  std::span<const std::uint32_t> owner;
  std::optional<WholeRows> sheet;
  std::optional<WholeSweeps> pieces;  // of a list that is swept by pieces
};

// Refuses several owners in a run of `together` places; the last run may be shorter.
std::optional<Error> refused_in_runs(const Owned& whole, std::size_t together, const std::string& what) {
  for (std::size_t place = 1; place < whole.owner.size(); ++place) {
    if (place % together == 0 || whole.owner_at(place) == whole.owner_at(place - 1)) continue;
    return refused_owner(whole.owner, whole.at(place),
                         std::to_string(whole.owner_at(place - 1)) + ", as that of particle " +
                             std::to_string(whole.at(place - 1)) + ": by sequential " + what + " go together");
  }
  return std::nullopt;
}

std::optional<Error> refused_in_rows(const Owned& whole, std::size_t rows) {
  const Grid& sheet = whole.sheet->grid();
  auto refused = refused_in_runs(whole, rows * sheet.columns, "rows in " + std::to_string(rows) + "s");
  std::set<std::uint32_t> seen;
  for (std::size_t row = 0; row < sheet.rows && !refused; row += rows) {
    const bool is_same = row != 0 && whole.owner_of_row(row) == whole.owner_of_row(row - 1);
    if (is_same || seen.insert(whole.owner_of_row(row)).second) continue;
    refused = refused_owner(whole.owner, whole.at(row * sheet.columns),
                            "a part that has no rows before: by sequential a part's rows stand one after the other");
  }
  return refused;
}

// Sweeps take a part's particles in the whole's order only where it has all that they go through at once.
std::optional<Error> refused_owners(const Owned& whole) {
  const auto& [scene, owner, sheet, pieces] = whole;
  if (!is_swept(scene)) return std::nullopt;
  if (pieces) return refused_in_pieces(owner, *pieces);
  if (sheet) return refused_in_rows(whole, rows_kept_together(scene, sheet->grid()));
  const std::size_t stacked = particles_of_stacked(scene, owner.size());
  return stacked != 0 ? refused_in_runs(whole, stacked, "a sheet's particles") : std::nullopt;
}

// The least of the parts, where each has whole rows, one part's after another's; else 0.
std::uint64_t fewest_rows(const Owned& whole) {
  const Grid& grid = whole.sheet->grid();
  std::uint64_t fewest = grid.rows;
  std::uint64_t rows = 0;
  for (std::size_t row = 0; row < grid.rows; ++row) {
    const std::uint32_t owner = whole.owner_of_row(row);
    for (std::size_t column = 1; column < grid.columns; ++column) {
      if (whole.owner_at(row * grid.columns + column) != owner) return 0;
    }
    const bool is_last = row + 1 == grid.rows;
    if (!is_last && whole.owner_of_row(row + 1) < owner) return 0;
    ++rows;
    if (is_last || whole.owner_of_row(row + 1) != owner) fewest = std::min(fewest, std::exchange(rows, 0));
  }
  return fewest;
}

OwnRows own_rows(const Owned& whole, std::uint32_t part) {
  const std::size_t rows = whole.sheet->grid().rows;
  std::size_t first = 0;
  while (first < rows && whole.owner_of_row(first) != part) ++first;
  std::size_t end = first;
  while (end < rows && whole.owner_of_row(end) == part) ++end;
  return {first, end};
}

// Whole rows, where a part holds more of others than its springs reach.
void tell_rows(const Owned& whole, std::uint32_t part, std::uint32_t pulses, ToldByPart& told) {
  if (!whole.sheet || (!is_swept(whole.scene) && pulses == 1)) return;
  const Grid& sheet = whole.sheet->grid();
  const OwnRows own = own_rows(whole, part);
  if (own.first == own.end) return;
  const auto owner_of_row = [&](std::uint64_t row) { return whole.owner_of_row(row); };
  hold_rows(sheet, own, owner_of_row, rows_held(whole.scene, sheet, pulses), told);
  for (auto& [other, lists] : told) {
    for (std::uint32_t& place : lists.sent) place = whole.at(place);
    for (std::uint32_t& place : lists.received) place = whole.at(place);
  }
}

void tell_ends_of_springs(const Owned& whole, std::uint32_t part, Part& made, ToldByPart& told) {
  for (const auto& [a, b] : joined(whole.scene, whole.owner.size())) {
    const std::uint32_t of_a = whole.owner[a], of_b = whole.owner[b];
    if (of_a != part && of_b != part) continue;
    ++made.springs;
    if (of_a == of_b) continue;
    ++made.cut;
    Told& other = told[of_a == part ? of_b : of_a];
    other.sent.push_back(of_a == part ? a : b);
    other.received.push_back(of_a == part ? b : a);
  }
}

void tell_what_meets_air(const Owned& whole, std::uint32_t part, ToldByPart& told) {
  const SharedTriangles in_air(whole.scene, whole.owner.size());
  for (std::uint32_t i = 0; i < whole.owner.size(); ++i) {
    if (whole.owner[i] != part) continue;
    in_air.for_each_within_two(i, [&](std::uint32_t j) {
      if (whole.owner[j] == part) return;
      told[whole.owner[j]].sent.push_back(i);
      told[whole.owner[j]].received.push_back(j);
    });
  }
}

// A part's own particles and those that it is told of, in the order in which a particle sums its springs; of a list in pieces its
// own come first.
std::vector<std::uint32_t> particles_of(const Owned& whole, std::uint32_t part, const ToldByPart& told) {
  const std::size_t count = whole.owner.size();
  std::vector<std::uint8_t> is_held(count, 0);
  for (std::size_t i = 0; i < count; ++i) is_held[i] = whole.owner[i] == part ? 1 : 0;
  for (const auto& [other, lists] : told) {
    for (const std::uint32_t i : lists.received) is_held[i] = 1;
  }
  std::vector<std::uint32_t> particles;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (is_held[i] != 0) particles.push_back(i);
  }
  if (whole.sheet) {
    const auto place = [&](std::uint32_t i) { return whole.sheet->place(i); };
    std::sort(particles.begin(), particles.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
    return particles;
  }
  const std::vector<std::uint32_t> place = whole.pieces ? whole.pieces->order.of : places(whole.scene, count);
  const auto comes_at = [&](std::uint32_t i) { return std::pair(whole.pieces && whole.owner[i] != part, place[i]); };
  std::sort(particles.begin(), particles.end(), [&](std::uint32_t a, std::uint32_t b) { return comes_at(a) < comes_at(b); });
  return particles;
}

std::optional<SweptPart> sweeps_of(const Owned& whole, const Part& part, const Renumbered& renumbered) {
  if (whole.pieces) return swept_part(*whole.pieces, part, renumbered);
  if (!whole.sheet || !is_swept_list(whole.scene, whole.owner.size())) return std::nullopt;
  return SweptPart{.piece_ends = {},
                   .colour_of = {},
                   .columns = static_cast<std::uint32_t>(whole.sheet->grid().columns),
                   .reach = static_cast<std::uint32_t>(reach_of(whole.sheet->grid()))};
}

}  // namespace

Expected<Part> part_of(const Scene& scene, std::span<const std::uint32_t> owner, std::uint32_t part) {
  const Owned whole(scene, owner);
  if (auto refused = refused_owners(whole)) return tl::unexpected(std::move(*refused));
  Part made;
  made.own = static_cast<std::size_t>(std::count(owner.begin(), owner.end(), part));
  if (whole.sheet) made.pulses_per_telling = pulses_per_telling(scene, whole.sheet->grid(), fewest_rows(whole));
  ToldByPart told;
  tell_rows(whole, part, made.pulses_per_telling, told);
  tell_ends_of_springs(whole, part, made, told);
  tell_what_meets_air(whole, part, told);
  made.particles = particles_of(whole, part, told);
  for (const std::uint32_t i : made.particles) made.is_own.push_back(owner[i] == part ? 1 : 0);
  const Renumbered renumbered(made);
  made.sweeps = sweeps_of(whole, made, renumbered);
  add_neighbours(
      told, [&](std::uint32_t number) { return *renumbered(number); }, made);
  return made;
}

namespace {

// A sheet in stripes: who owns each row, as stripes() has it.
class RowOwners {
 public:
  RowOwners(const Scene& scene, const Grid& sheet, std::uint32_t parts)
      : rows_(sheet.rows),
        together_(rows_kept_together(scene, sheet)),
        units_((sheet.rows + together_ - 1) / together_),
        parts_(parts) {}

  [[nodiscard]] std::uint32_t operator()(std::uint64_t row) const {
    return static_cast<std::uint32_t>(row / together_ * parts_ / units_);
  }
  [[nodiscard]] OwnRows of(std::uint32_t part) const {
    const auto first_of = [&](std::uint64_t p) { return std::min(rows_, (p * units_ + parts_ - 1) / parts_ * together_); };
    return {first_of(part), first_of(std::uint64_t{part} + 1)};
  }
  // The fewest rows among the parts that have any.
  [[nodiscard]] std::uint64_t fewest() const {
    std::uint64_t fewest = rows_;
    for (std::uint32_t part = 0; part < parts_; ++part) {
      const OwnRows own = of(part);
      if (own.first != own.end) fewest = std::min(fewest, own.end - own.first);
    }
    return fewest;
  }

 private:
  std::uint64_t rows_, together_, units_, parts_;
};

// The springs that reach the part's own rows.
void add_springs(const Grid& sheet, const RowOwners& owner_of, std::uint32_t part, const OwnRows& own, Part& made,
                 ToldByPart& told) {
  for (const GridDirection& d : directions_of(sheet)) {
    const std::size_t from = d.right < 0 ? static_cast<std::size_t>(-d.right) : 0;
    const std::size_t across = d.right > 0 ? static_cast<std::size_t>(d.right) : 0;
    const std::size_t to = sheet.columns > across ? sheet.columns - across : 0;
    if (from >= to) continue;
    for (std::uint64_t row = own.first - std::min<std::uint64_t>(own.first, d.down); row < own.end; ++row) {
      if (row + d.down >= sheet.rows) break;
      const std::uint32_t above = owner_of(row), below = owner_of(row + d.down);
      if (above != part && below != part) continue;
      made.springs += to - from;
      if (above == below) continue;
      made.cut += to - from;
      Told& other = told[above == part ? below : above];
      for (std::size_t column = from; column < to; ++column) {
        const auto a = static_cast<std::uint32_t>(row * sheet.columns + column);
        const auto b = static_cast<std::uint32_t>((row + d.down) * sheet.columns + column + static_cast<std::size_t>(d.right));
        other.sent.push_back(above == part ? a : b);
        other.received.push_back(above == part ? b : a);
      }
    }
  }
}

// Own rows, and what of others a part is told of.
void hold_particles(const Grid& sheet, const OwnRows& own, const ToldByPart& told, Part& made) {
  for (const auto& [other, lists] : told) {
    made.particles.insert(made.particles.end(), lists.received.begin(), lists.received.end());
  }
  std::sort(made.particles.begin(), made.particles.end());
  made.particles.erase(std::unique(made.particles.begin(), made.particles.end()), made.particles.end());
  const auto first = static_cast<std::uint32_t>(own.first * sheet.columns);
  const auto at = std::lower_bound(made.particles.begin(), made.particles.end(), first) - made.particles.begin();
  made.own = (own.end - own.first) * sheet.columns;
  made.particles.insert(made.particles.begin() + at, made.own, 0U);
  std::iota(made.particles.begin() + at, made.particles.begin() + at + static_cast<std::ptrdiff_t>(made.own), first);
  made.is_own.assign(made.particles.size(), 0);
  std::fill_n(made.is_own.begin() + at, made.own, 1);
}

}  // namespace

std::optional<Part> part_of_sheet(const Scene& scene, std::size_t count, std::uint32_t parts, std::uint32_t part) {
  const Grid* const sheet = is_sheet(scene, count) ? only_grid(scene, count) : nullptr;
  if (sheet == nullptr || sheet->aerodynamics) return std::nullopt;
  const RowOwners owner_of(scene, *sheet, parts);
  const OwnRows own = owner_of.of(part);
  Part made;
  made.pulses_per_telling = pulses_per_telling(scene, *sheet, owner_of.fewest());
  if (own.first == own.end) return made;
  ToldByPart told;
  if (is_swept(scene) || made.pulses_per_telling > 1) {
    hold_rows(*sheet, own, owner_of, rows_held(scene, *sheet, made.pulses_per_telling), told);
  }
  add_springs(*sheet, owner_of, part, own, made, told);
  hold_particles(*sheet, own, told, made);
  const auto place_of = [&](std::uint32_t number) {
    return static_cast<std::uint32_t>(std::lower_bound(made.particles.begin(), made.particles.end(), number) -
                                      made.particles.begin());
  };
  add_neighbours(told, place_of, made);
  return made;
}

namespace {

// The particles of a skin that the part holds, and what belongs to each.
Skin taken(const Skin& whole, const Renumbered& renumbered) {
  Skin skin{.particles = {}, .backstop = whole.backstop, .motion = whole.motion};
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < whole.particles.size(); ++k) {
    const auto number = renumbered(whole.particles[k]);
    if (!number) continue;
    skin.particles.push_back(*number);
    kept.push_back(static_cast<std::uint32_t>(k));
  }
  if (kept.empty()) {
    if (skin.backstop) skin.backstop = Backstop{.normals = {whole.backstop->normals.at(0)}};
    return skin;
  }
  const auto some = [&](const std::vector<Vec3>& all) {
    std::vector<Vec3> each;
    each.reserve(kept.size());
    for (const std::uint32_t k : kept) each.push_back(all[k]);
    return each;
  };
  if (!whole.points.empty()) skin.points = some(whole.points);
  skin.at_most = taken(whole.at_most, kept);
  if (skin.backstop) {
    if (whole.backstop->normals.size() > 1) skin.backstop->normals = some(whole.backstop->normals);
    skin.backstop->offset = taken(whole.backstop->offset, kept);
    skin.backstop->radius = taken(whole.backstop->radius, kept);
  }
  return skin;
}

}  // namespace

Scene scene_of(const Scene& whole, const Part& part) {
  Scene scene = whole;
  const Renumbered renumbered(part);
  for_each_particle_value_of(scene, [&](const std::string&, auto& value) { value = taken(value, part.particles); });
  const auto renumber = [&](std::vector<std::size_t>& list) {
    std::vector<std::size_t> kept;
    for (const std::size_t i : list) {
      if (const auto number = renumbered(i)) kept.push_back(*number);
    }
    list = std::move(kept);
  };
  renumber(scene.fixed);
  std::sort(scene.fixed.begin(), scene.fixed.end());
  for (Kinematic& followers : scene.kinematic) renumber(followers.particles);
  for (Skin& skin : scene.skins) skin = taken(skin, renumbered);
  if (is_swept(whole) && !part.sweeps && whole.networks.size() > 1) {
    scene.networks = sheets_of(whole, renumbered);
    return scene;
  }
  const Taken which = part.sweeps && part.sweeps->columns != 0 ? Taken::all : Taken::own;
  for (Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      const bool is_alone = whole.networks.size() == 1 && whole.coupling.scheme != Scheme::accumulate && grid->first == 0;
      if (const auto rows = is_alone ? rows_of(*grid, part) : std::nullopt) {
        network = *rows;
      } else {
        network = taken(springs_of(*grid), renumbered, which);
      }
    } else {
      network = taken(std::get<Springs>(network), renumbered, which);
    }
  }
  return scene;
}

}  // namespace dvdx
