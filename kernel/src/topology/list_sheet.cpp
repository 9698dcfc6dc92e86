#include "topology/list_sheet.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <variant>

#include "topology/sheet_places.hpp"

namespace dvdx {
namespace {

// The least length of a line. A spring in strands takes as long as in colours if a register of 16 holds about 8 springs.
constexpr std::size_t least_line = 8;
// Threads share the bands of a sheet of at least shared_from particles. It needs least_bands bands: every second is a task.
constexpr std::size_t shared_from = 16384;
constexpr std::size_t least_bands = 8;

// The directions of a grid; and across the side of two triangles, to the facing corners, if all cells are cut one way.
constexpr std::array<GridDirection, 10> sheet_directions{{{.down = 0, .right = 1},
                                                          {.down = 0, .right = 2},
                                                          {.down = 1, .right = -2},
                                                          {.down = 1, .right = -1},
                                                          {.down = 1, .right = 0},
                                                          {.down = 1, .right = 1},
                                                          {.down = 1, .right = 2},
                                                          {.down = 2, .right = -1},
                                                          {.down = 2, .right = 0},
                                                          {.down = 2, .right = 1}}};

bool is_bend(const GridDirection& d) noexcept { return d.down == 2 || std::abs(d.right) == 2; }

// Returns the index of a spring's direction, or none. In rows of fewer than 5 some directions lead equally far.
std::optional<std::size_t> direction_of(const JoinedPair& s, const ListSheet& sheet) noexcept {
  const auto [a, b] = std::minmax({sheet.place_of(s.a), sheet.place_of(s.b)});
  const std::size_t columns = sheet.columns;
  const auto column = static_cast<std::ptrdiff_t>(a % columns);
  for (std::size_t n = 0; n < sheet_directions.size(); ++n) {
    const auto& [down, right, k, l, along] = sheet_directions[n];
    const bool is_as_far = b - a == down * columns + static_cast<std::size_t>(right);
    if (is_as_far && column + right >= 0 && column + right < static_cast<std::ptrdiff_t>(columns)) return n;
  }
  return std::nullopt;
}

// Returns the differences of the ends' numbers, ascending; none if there are more than a sheet has.
std::vector<std::size_t> distances(std::span<const JoinedPair> springs) {
  std::vector<std::size_t> found;
  for (const JoinedPair& s : springs) {
    const std::size_t apart = s.b - s.a;
    const auto at = std::lower_bound(found.begin(), found.end(), apart);
    if (at != found.end() && *at == apart) continue;
    found.insert(at, apart);
    if (found.size() > sheet_directions.size()) return {};
  }
  return found;
}

bool has_doubles(std::span<const JoinedPair> springs) {
  return std::adjacent_find(springs.begin(), springs.end(),
                            [](const JoinedPair& s, const JoinedPair& t) { return s.a == t.a && s.b == t.b; }) != springs.end();
}

// The number of springs that a sheet has room for.
std::size_t room_for(std::span<const GridDirection> of, const ListSheet& sheet) {
  std::size_t room = 0;
  for (const GridDirection& d : of)
    room += (sheet.rows - d.down) * (sheet.columns - static_cast<std::size_t>(std::abs(d.right)));
  return room;
}

bool is_worth(const ListSheet& sheet) {
  const std::size_t bands = sheet.rows / rows_of_band(sheet.columns);
  return sheet.columns >= least_line * sheet.phases() && (sheet.rows * sheet.columns < shared_from || bands >= least_bands);
}

// Whether triangles in air reach only adjacent rows: a part of the sheet holds the rows beside its own for its air.
bool meets_air_in_rows(const Scene& scene, const ListSheet& sheet) {
  const auto is_in_rows = [&](const Triangle& triangle) {
    const auto row = [&](std::uint32_t i) { return sheet.place_of(i) / sheet.columns; };
    const auto [least, most] = std::minmax({row(triangle[0]), row(triangle[1]), row(triangle[2])});
    return most - least <= 1;
  };
  const auto are_in_rows = [&](const Springs& springs) {
    return !springs.aerodynamics || std::all_of(springs.triangles.begin(), springs.triangles.end(), is_in_rows);
  };
  return std::all_of(scene.networks.begin(), scene.networks.end(), [&](const Network& network) {
    const auto* const grid = std::get_if<Grid>(&network);
    if (grid == nullptr) return are_in_rows(std::get<Springs>(network));
    return !grid->aerodynamics || are_in_rows(springs_of(*grid));
  });
}

}  // namespace

// A band is enough independent work for a core, and small enough for first-level cache. It is a multiple of 4 rows, so that
// rows of equal number mod 4 mean the same in each.
std::size_t rows_of_band(std::size_t columns) noexcept { return std::clamp<std::size_t>(512 / columns / 4 * 4, 4, 32); }

bool fits(std::span<const JoinedPair> springs, const ListSheet& sheet) {
  const auto leads_there = [&](const JoinedPair& s) {
    const auto n = direction_of(s, sheet);
    return n && (sheet.reach == 2 || !is_bend(sheet_directions[*n]));
  };
  return std::all_of(springs.begin(), springs.end(), leads_there) && !has_doubles(springs);
}

ListSheet given_sheet(const SweptPart& sweeps, std::size_t count) noexcept {
  return {.rows = count / sweeps.columns, .columns = sweeps.columns, .reach = sweeps.reach};
}

std::vector<GridDirection> directions_of(std::span<const JoinedPair> springs, const ListSheet& sheet) {
  std::array<bool, sheet_directions.size()> is_there{};
  for (const JoinedPair& s : springs) is_there[*direction_of(s, sheet)] = true;
  std::vector<GridDirection> found;
  for (std::size_t n = 0; n < sheet_directions.size(); ++n) {
    if (is_there[n]) found.push_back(sheet_directions[n]);
  }
  return found;
}

namespace {

// Returns the sheet whose rows follow the particles' numbers, if each spring leads where one of a sheet may.
std::optional<ListSheet> numbered_sheet(std::span<const JoinedPair> springs, std::size_t count) {
  for (const std::size_t apart : distances(springs)) {
    for (const std::size_t columns : {apart - 1, apart, apart + 1}) {  // a diagonal, a column, the other diagonal
      if (columns < least_line || count % columns != 0 || count / columns < 3) continue;
      ListSheet sheet{.rows = count / columns, .columns = columns, .reach = 2};
      if (fits(springs, sheet)) return sheet;
    }
  }
  return std::nullopt;
}

std::optional<ListSheet> shuffled_sheet(std::span<const JoinedPair> springs, std::size_t count) {
  if (has_doubles(springs)) return std::nullopt;
  auto places = sheet_places(springs, count);
  if (!places) return std::nullopt;
  return ListSheet{.rows = places->rows, .columns = places->columns, .reach = 2, .place = std::move(places->of)};
}

// Returns the sheet with its columns taken for rows.
ListSheet turned(const ListSheet& sheet) {
  ListSheet other{.rows = sheet.columns, .columns = sheet.rows, .reach = sheet.reach};
  other.place.resize(sheet.rows * sheet.columns);
  for (std::size_t i = 0; i < other.place.size(); ++i) {
    const std::size_t place = sheet.place_of(i);
    other.place[i] = static_cast<std::uint32_t>(place % sheet.columns * sheet.rows + place / sheet.columns);
  }
  return other;
}

// Returns the sheet with the reach that its springs need, or none if sweeps would not gain by its rows.
std::optional<ListSheet> as_swept(const Scene& scene, std::span<const JoinedPair> springs, ListSheet sheet) {
  const std::vector<GridDirection> its = directions_of(springs, sheet);
  if (std::none_of(its.begin(), its.end(), is_bend)) sheet.reach = 1;
  const bool is_dense = 2 * springs.size() > room_for(its, sheet);
  if (!is_dense || !is_worth(sheet) || !meets_air_in_rows(scene, sheet)) return std::nullopt;
  return sheet;
}

}  // namespace

// Takes rows as particles are numbered, or along the longer side. If these do not serve, it takes columns for rows.
std::optional<ListSheet> list_sheet(const Scene& scene, std::span<const JoinedPair> springs, std::size_t count) {
  auto sheet = numbered_sheet(springs, count);
  if (!sheet) {
    sheet = shuffled_sheet(springs, count);
    if (sheet && sheet->columns < sheet->rows) sheet = turned(*sheet);
  }
  if (!sheet) return std::nullopt;
  auto swept = as_swept(scene, springs, *sheet);
  return swept ? std::move(swept) : as_swept(scene, springs, turned(*sheet));
}

bool are_ropes(std::span<const JoinedPair> springs, std::size_t count) {
  std::vector<std::uint8_t> found(count, 0);
  for (const JoinedPair& s : springs) {
    for (const std::uint32_t i : {s.a, s.b}) {
      if (++found[i] > 2) return false;
    }
  }
  return true;
}

}  // namespace dvdx
