#include "compile/list_sheet.hpp"

#include <algorithm>
#include <array>

namespace dvdx {
namespace {

// Of a line, at the least: a spring in strands takes as long as in colours where a register of 16 holds some 8.
constexpr std::size_t least_line = 8;

struct Place {
  std::size_t down;
  std::ptrdiff_t right;
};
constexpr std::array<Place, 6> places{{{0, 1}, {0, 2}, {1, -1}, {1, 0}, {1, 1}, {2, 0}}};

std::size_t offset(const Place& place, std::size_t columns) noexcept {
  return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(place.down * columns) + place.right);
}

// Which of the places, or none; the lesser end first.
std::optional<std::size_t> place_of(const JoinedPair& s, std::size_t columns) noexcept {
  const std::size_t column = s.a % columns;
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (s.b - s.a != offset(places[n], columns)) continue;
    const std::ptrdiff_t other = static_cast<std::ptrdiff_t>(column) + places[n].right;
    return other >= 0 && other < static_cast<std::ptrdiff_t>(columns) ? std::optional(n) : std::nullopt;
  }
  return std::nullopt;
}

// How far apart ends stand, ascending; none where there are more distances than a sheet has.
std::vector<std::size_t> distances(std::span<const JoinedPair> springs) {
  std::vector<std::size_t> found;
  for (const JoinedPair& s : springs) {
    const std::size_t apart = s.b - s.a;
    const auto at = std::lower_bound(found.begin(), found.end(), apart);
    if (at != found.end() && *at == apart) continue;
    found.insert(at, apart);
    if (found.size() > places.size()) return {};
  }
  return found;
}

bool has_doubles(std::span<const JoinedPair> springs) {
  return std::adjacent_find(springs.begin(), springs.end(),
                            [](const JoinedPair& s, const JoinedPair& t) { return s.a == t.a && s.b == t.b; }) != springs.end();
}

// Springs that the directions have room for.
std::size_t room_for(std::span<const GridDirection> directions, const ListSheet& sheet) {
  std::size_t room = 0;
  for (const GridDirection& d : directions) {
    room += (sheet.rows - d.down) * (sheet.columns - static_cast<std::size_t>(d.right < 0 ? -d.right : d.right));
  }
  return room;
}

}  // namespace

bool is_sheet(std::span<const JoinedPair> springs, const ListSheet& sheet) {
  const auto leads_there = [&](const JoinedPair& s) {
    const auto n = place_of(s, sheet.columns);
    return n && std::max<std::size_t>(places[*n].down, places[*n].right == 2 ? 2 : 1) <= sheet.reach;
  };
  return std::all_of(springs.begin(), springs.end(), leads_there) && !has_doubles(springs);
}

std::vector<GridDirection> directions_of(std::span<const JoinedPair> springs, const ListSheet& sheet) {
  std::array<bool, places.size()> is_there{};
  for (const JoinedPair& s : springs) is_there[*place_of(s, sheet.columns)] = true;
  std::vector<GridDirection> directions;
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (is_there[n]) directions.push_back({.down = places[n].down, .right = places[n].right});
  }
  return directions;
}

std::optional<ListSheet> list_sheet(std::span<const JoinedPair> springs, std::size_t count) {
  for (const std::size_t apart : distances(springs)) {
    for (const std::size_t columns : {apart - 1, apart, apart + 1}) {  // a diagonal, a column, the other diagonal
      if (columns < 3 || count % columns != 0 || count / columns < 3) continue;
      ListSheet sheet{.rows = count / columns, .columns = columns, .reach = 2};
      if (!is_sheet(springs, sheet)) continue;
      const std::vector<GridDirection> directions = directions_of(springs, sheet);
      const bool has_bends =
          std::any_of(directions.begin(), directions.end(), [](const GridDirection& d) { return d.down == 2 || d.right == 2; });
      if (!has_bends) sheet.reach = 1;
      const bool is_wide = columns >= least_line * sheet.phases();
      return is_wide && 2 * springs.size() > room_for(directions, sheet) ? std::optional(sheet) : std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace dvdx
