// Lines of springs that `sequential` solves at once between its sweeps: the lines, in families that share no particle, and how
// a pass finds their particles and springs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/network.hpp"
#include "springs/network.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// Memory in which lines of springs are solved, a room for each task.
template <class T>
struct WorkRooms {
  T* first = nullptr;
  std::size_t each = 0, count = 0;
};

// The rooms that lines need. Bundles are solved in a room one after the other.
struct LineRooms {
  std::size_t count = 0, each = 0;  // each: numbers
  bool operator==(const LineRooms&) const = default;
};

// Families in the order in which they are solved: forwards and backwards, the last of them once or twice.
class LineVisits {
 public:
  enum class Turn : std::uint8_t { once, twice };
  LineVisits(std::size_t families, Turn turn) noexcept : families_(families), count_(2 * families) {
    if (turn == Turn::once && families != 0) --count_;
  }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::size_t family(std::size_t visit) const noexcept { return visit < families_ ? visit : count_ - 1 - visit; }
  [[nodiscard]] Visit visit(std::size_t n) const noexcept { return n < families_ ? Visit::first : Visit::again; }

 private:
  std::size_t families_, count_;
};

// Limits of how far springs turn in a sub-step under their load (SweepEstimate::turning). Up to the first a net comes to rest
// by forces that stay. Up to the second a sheet rests by redirected ones. Beyond the third these swing faster than the former.
inline constexpr double most_turning_that_stays = 2;
inline constexpr double most_turning_redirected = 7;
inline constexpr double most_turning_to_redirect = 14;
[[nodiscard]] LineForces line_forces(double turning) noexcept;

// Lines of a stack of sheets that are alike: down the columns, along the rows and along both diagonals, as far as there are
// springs of these directions.
struct SheetLines {
  std::vector<LineFamily> families;
  std::vector<LineStrand> strands;
  std::size_t rows = 0, columns = 0, sheets = 0;  // of each sheet, and how many there are
  std::size_t phases = 1, pitch = 0;
  LineForces forces = LineForces::stay;

  [[nodiscard]] bool empty() const noexcept { return families.empty(); }
  [[nodiscard]] SheetLineTerms terms() const noexcept {
    return {families.data(), strands.data(), rows, columns, phases, pitch};
  }
  [[nodiscard]] LineVisits visits() const noexcept { return {families.size(), LineVisits::Turn::once}; }
  [[nodiscard]] LineRooms rooms() const noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept;
};

// Lines of a list.
struct ListLines {
  std::vector<LineBundle> bundles;
  std::vector<std::uint32_t> places;
  std::vector<std::size_t> families;  // first bundle of each family, and one more

  [[nodiscard]] bool empty() const noexcept { return bundles.empty(); }
  [[nodiscard]] BundleTerms terms() const noexcept { return {bundles.data(), places.data()}; }
  [[nodiscard]] LineVisits visits() const noexcept { return {families.size() - 1, LineVisits::Turn::twice}; }
  [[nodiscard]] LineRooms rooms(bool may_share_work) const noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept;
};

// rows: of all sheets. strands: all that the sheets have room for, with or without springs.
SheetLines lines_of_sheets(const ParticleOrder& order, std::size_t rows, std::size_t columns, std::size_t sheet_rows,
                           std::span<const GridDirection> directions, std::span<const Strand> strands);

// The lines of any springs. At each particle the straightest pairs at the start go on from each other. spring_at: of each lane.
ListLines lines_of_list(std::span<const JoinedPair> springs, std::span<const Vec3> start, const ParticleOrder& order,
                        std::span<const std::uint32_t> spring_at);

}  // namespace dvdx
