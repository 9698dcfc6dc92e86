// The part of an owner of some rows of a sheet, made of these alone.
#include <algorithm>
#include <cstddef>
#include <numeric>

#include "dvdx/partition.hpp"
#include "topology/halo_lists.hpp"
#include "topology/particle_order.hpp"
#include "topology/whole.hpp"

namespace dvdx {
namespace {

// The owner of each row of a sheet in stripes, as stripes() assigns them.
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

// Adds the springs that reach the part's own rows, and the ends of those that are cut.
void add_springs(const Grid& sheet, const RowOwners& owner_of, std::uint32_t part, const OwnRows& own, Part& made,
                 HaloByPart& halo) {
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
      HaloRows& other = halo[above == part ? below : above];
      for (std::size_t column = from; column < to; ++column) {
        const auto a = static_cast<std::uint32_t>(row * sheet.columns + column);
        const auto b = static_cast<std::uint32_t>((row + d.down) * sheet.columns + column + static_cast<std::size_t>(d.right));
        other.sent.push_back(above == part ? a : b);
        other.received.push_back(above == part ? b : a);
      }
    }
  }
}

// Takes the own rows, and the particles that the part receives from others.
void hold_particles(const Grid& sheet, const OwnRows& own, const HaloByPart& halo, Part& made) {
  for (const auto& [other, lists] : halo) {
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
  const Grid* const sheet = SteppedGrid(scene, count).own();
  if (sheet == nullptr || sheet->aerodynamics) return std::nullopt;
  const RowOwners owner_of(scene, *sheet, parts);
  const OwnRows own = owner_of.of(part);
  Part made;
  made.pulses_per_telling = pulses_per_telling(scene, *sheet, owner_of.fewest());
  if (own.first == own.end) return made;
  HaloByPart halo;
  if (is_swept(scene) || made.pulses_per_telling > 1) {
    hold_rows(*sheet, own, owner_of, rows_held(scene, *sheet, made.pulses_per_telling), halo);
  }
  add_springs(*sheet, owner_of, part, own, made, halo);
  hold_particles(*sheet, own, halo, made);
  const auto place_of = [&](std::uint32_t number) {
    return static_cast<std::uint32_t>(std::lower_bound(made.particles.begin(), made.particles.end(), number) -
                                      made.particles.begin());
  };
  add_neighbours(halo, place_of, made);
  return made;
}

}  // namespace dvdx
