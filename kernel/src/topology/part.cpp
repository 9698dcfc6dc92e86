// The part of an owner of any particles.
#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "dvdx/partition.hpp"
#include "topology/halo_lists.hpp"
#include "topology/renumbered.hpp"
#include "topology/whole.hpp"

namespace dvdx {
namespace {

Error refused_owner(std::span<const std::uint32_t> owner, std::size_t particle, std::string valid) {
  return {"owner[" + std::to_string(particle) + "]", std::to_string(owner[particle]), std::move(valid)};
}

std::optional<Error> refused_in_pieces(const Owned& whole) {
  const auto& owner = whole.owner;
  std::map<std::size_t, std::uint32_t> owner_of;
  for (std::uint32_t i = 0; i < owner.size(); ++i) {
    const std::uint32_t first = owner_of.try_emplace(whole.piece_of(i), owner[i]).first->second;
    if (first == owner[i]) continue;
    return refused_owner(owner, i, std::to_string(first) + ", as of others in its piece: by sequential a piece stays whole");
  }
  return std::nullopt;
}

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
  const Grid& sheet = *whole.rows;
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

// Refuses owners that split a unit of the sweeps: only with whole pieces, rows or sheets a part sweeps in the whole's order.
std::optional<Error> refused_owners(const Owned& whole) {
  if (!is_swept(whole.scene)) return std::nullopt;
  if (whole.has_pieces) return refused_in_pieces(whole);
  if (whole.rows) return refused_in_rows(whole, rows_kept_together(whole.scene, *whole.rows));
  return whole.stacked != 0 ? refused_in_runs(whole, whole.stacked, "a sheet's particles") : std::nullopt;
}

// Returns the fewest rows of a part, if each has whole rows, one part's after another's; otherwise 0.
std::uint64_t fewest_rows(const Owned& whole) {
  const Grid& grid = *whole.rows;
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

SweptPart swept_part(const Whole& whole, const Part& part, const Renumbered& renumbered) {
  SweptPart sweeps{.piece_ends = {}, .colour_of = {}, .colours = whole.colours};
  for (std::uint32_t k = 0; k < part.own; ++k) {
    const bool is_last = k + 1 == part.own || whole.piece_of(part.particles[k]) != whole.piece_of(part.particles[k + 1]);
    if (is_last) sweeps.piece_ends.push_back(k + 1);
  }
  struct Coloured {
    std::uint32_t a, b, colour;
  };
  std::vector<Coloured> springs;
  for (std::size_t s = 0; s < whole.joined.pairs.size(); ++s) {
    const auto a = renumbered(whole.joined.pairs[s].a);
    const auto b = renumbered(whole.joined.pairs[s].b);
    if (!a || !b || (!renumbered.is_own(*a) && !renumbered.is_own(*b))) continue;
    springs.push_back({std::min(*a, *b), std::max(*a, *b), whole.colour_of[s]});
  }
  std::stable_sort(springs.begin(), springs.end(),
                   [](const Coloured& s, const Coloured& t) { return std::pair(s.a, s.b) < std::pair(t.a, t.b); });
  for (const Coloured& spring : springs) sweeps.colour_of.push_back(spring.colour);
  return sweeps;
}

// Returns a part's own particles and those of its halo, in the order in which a particle sums its springs. For a list in pieces
// its own come first.
std::vector<std::uint32_t> particles_of(const Owned& whole, std::uint32_t part, const HaloByPart& halo) {
  const std::size_t count = whole.owner.size();
  std::vector<std::uint8_t> is_held(count, 0);
  for (std::size_t i = 0; i < count; ++i) is_held[i] = whole.owner[i] == part ? 1 : 0;
  for (const auto& [other, lists] : halo) {
    for (const std::uint32_t i : lists.received) is_held[i] = 1;
  }
  std::vector<std::uint32_t> particles;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (is_held[i] != 0) particles.push_back(i);
  }
  const auto comes_at = [&](std::uint32_t i) {
    return std::pair(whole.has_pieces && whole.owner[i] != part, whole.topology().place_of(i));
  };
  std::sort(particles.begin(), particles.end(), [&](std::uint32_t a, std::uint32_t b) { return comes_at(a) < comes_at(b); });
  return particles;
}

std::optional<SweptPart> sweeps_of(const Owned& whole, const Part& part, const Renumbered& renumbered) {
  if (whole.has_pieces) return swept_part(whole, part, renumbered);
  if (whole.topology().walk() != Walk::sheet) return std::nullopt;
  return SweptPart{.piece_ends = {},
                   .colour_of = {},
                   .columns = static_cast<std::uint32_t>(whole.rows->columns),
                   .reach = static_cast<std::uint32_t>(reach_of(*whole.rows))};
}

}  // namespace

Expected<Part> part_of(const Scene& scene, std::span<const std::uint32_t> owner, std::uint32_t part) {
  const Owned whole(scene, owner);
  if (auto refused = refused_owners(whole)) return tl::unexpected(std::move(*refused));
  Part made;
  made.own = static_cast<std::size_t>(std::count(owner.begin(), owner.end(), part));
  if (whole.rows) made.pulses_per_telling = pulses_per_telling(scene, *whole.rows, fewest_rows(whole));
  HaloByPart halo = halo_by_part(whole, part, made);
  made.particles = particles_of(whole, part, halo);
  for (const std::uint32_t i : made.particles) made.is_own.push_back(owner[i] == part ? 1 : 0);
  const Renumbered renumbered(made);
  made.sweeps = sweeps_of(whole, made, renumbered);
  add_neighbours(
      halo, [&](std::uint32_t number) { return *renumbered(number); }, made);
  return made;
}

}  // namespace dvdx
