#include "compile/sheet_places.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include "compile/neighbours.hpp"

// A corner, and the particles to the right of it and below, decide all others: the first row goes on along the sheet's edge, where
// particles have fewest neighbours, to the next corner; and each place behind it is taken by the only particle whose neighbours
// among those that have a place already stand where springs that end at this place begin. What is found is a sheet: the last row
// is full, and the springs are as many as such a sheet has.

namespace dvdx {
namespace {

// Where springs lead from (row, column), besides to the right and below.
struct Shape {
  bool right_below, left_below, right2, below2;

  [[nodiscard]] bool has(std::ptrdiff_t down, std::ptrdiff_t right) const noexcept {
    if (down == 0) return right == 1 || (right2 && right == 2);
    if (down == 1) return right == 0 || (right_below && right == 1) || (left_below && right == -1);
    return below2 && down == 2 && right == 0;
  }
  [[nodiscard]] std::size_t springs(std::size_t rows, std::size_t columns) const noexcept {
    const std::size_t diagonals = std::size_t{right_below} + std::size_t{left_below};
    return rows * (columns - 1) + (rows - 1) * columns + diagonals * (rows - 1) * (columns - 1) +
           std::size_t{right2} * rows * (columns - 2) + std::size_t{below2} * (rows - 2) * columns;
  }
  // Neighbours of the particle in the corner above on the left.
  [[nodiscard]] std::size_t at_corner() const noexcept {
    return 2 + std::size_t{right_below} + std::size_t{right2} + std::size_t{below2};
  }
  // Of a place, in a row of so many columns: springs that end there.
  [[nodiscard]] std::size_t before(std::size_t row, std::size_t column, std::size_t columns) const noexcept {
    return std::size_t{column >= 1} + std::size_t{right2 && column >= 2} + std::size_t{row >= 1} +
           std::size_t{right_below && row >= 1 && column >= 1} + std::size_t{left_below && row >= 1 && column + 1 < columns} +
           std::size_t{below2 && row >= 2};
  }
};

class Walk {
 public:
  static constexpr std::uint32_t nowhere = 0xffffffff;

  Walk(const Neighbours& neighbours, std::size_t count) : neighbours_(neighbours), place_(count, nowhere) {}

  // None where this is no sheet of such a shape.
  [[nodiscard]] std::optional<SheetPlaces> operator()(const Shape& shape, std::uint32_t corner, std::uint32_t right,
                                                      std::uint32_t below, std::size_t springs) {
    for (const std::uint32_t i : at_) place_[i] = nowhere;
    at_.clear();
    take(corner);
    take(right);
    columns_ = place_.size();  // as many at the most
    if (!walk_first_row(shape, below)) return std::nullopt;
    columns_ = at_.size();
    const std::size_t rows = place_.size() / columns_;
    if (place_.size() % columns_ != 0 || rows < 3 || shape.springs(rows, columns_) != springs) return std::nullopt;
    if (!fits(shape, below, 1, 0)) return std::nullopt;
    take(below);
    while (at_.size() < place_.size()) {
      if (!take_next(shape, at_[at_.size() - columns_])) return std::nullopt;
    }
    return SheetPlaces{rows, columns_, place_};
  }

 private:
  void take(std::uint32_t i) {
    place_[i] = static_cast<std::uint32_t>(at_.size());
    at_.push_back(i);
  }

  // It ends at a corner: the number of neighbours has fallen, and would rise again. Behind the first two it has no neighbour of
  // the particle below the first.
  [[nodiscard]] bool walk_first_row(const Shape& shape, std::uint32_t below) {
    const auto is_beside = [&](std::uint32_t i) {
      const auto of = neighbours_.of(below);
      return i == below || std::find(of.begin(), of.end(), i) != of.end();
    };
    while (true) {
      const std::size_t last = neighbours_.count(at_.back());
      const bool has_fallen = last < neighbours_.count(at_[at_.size() - 2]);
      const auto next = next_from(shape, at_.back(), [&](std::uint32_t i) { return !is_beside(i); });
      if (has_fallen && (!next || neighbours_.count(*next) > last)) return at_.size() >= 3;
      if (!next) return false;
      take(*next);
    }
  }

  [[nodiscard]] bool take_next(const Shape& shape, std::uint32_t above) {
    const auto next = next_from(shape, above, [](std::uint32_t) { return true; });
    if (next) take(*next);
    return next.has_value();
  }

  // Of a particle's neighbours the one that fits the next place; of several the one of fewest neighbours, nearest to the edge.
  template <class MayBe>
  [[nodiscard]] std::optional<std::uint32_t> next_from(const Shape& shape, std::uint32_t particle, const MayBe& may_be) const {
    const std::size_t row = at_.size() / columns_;
    const std::size_t column = at_.size() % columns_;
    std::optional<std::uint32_t> best;
    for (const std::uint32_t i : neighbours_.of(particle)) {
      if (place_[i] != nowhere || !fits(shape, i, row, column) || !may_be(i)) continue;
      if (!best || neighbours_.count(i) < neighbours_.count(*best)) best = i;
    }
    return best;
  }

  [[nodiscard]] bool fits(const Shape& shape, std::uint32_t i, std::size_t row, std::size_t column) const {
    std::size_t found = 0;
    for (const std::uint32_t j : neighbours_.of(i)) {
      if (place_[j] == nowhere) continue;
      const auto down = static_cast<std::ptrdiff_t>(row - place_[j] / columns_);
      const auto right = static_cast<std::ptrdiff_t>(column) - static_cast<std::ptrdiff_t>(place_[j] % columns_);
      if (!shape.has(down, right)) return false;
      ++found;
    }
    return found == shape.before(row, column, columns_);
  }

  const Neighbours& neighbours_;
  std::vector<std::uint32_t> place_;  // of each particle, or nowhere
  std::vector<std::uint32_t> at_;     // particle of each place
  std::size_t columns_ = 0;
};

std::uint32_t fewest_neighbours(const Neighbours& neighbours, std::size_t count) {
  std::uint32_t least = 0;
  for (std::uint32_t i = 1; i < count; ++i) {
    if (neighbours.count(i) < neighbours.count(least)) least = i;
  }
  return least;
}

}  // namespace

std::vector<SheetPlaces> sheet_places(std::span<const JoinedPair> springs, std::size_t count) {
  constexpr std::size_t most_at_corner = 5;
  std::vector<SheetPlaces> found;
  if (count < 9) return found;
  const Neighbours neighbours(springs, count);
  const std::uint32_t corner = fewest_neighbours(neighbours, count);
  if (neighbours.count(corner) > most_at_corner) return found;
  Walk walk(neighbours, count);
  for (unsigned kinds = 0; kinds < 16; ++kinds) {
    const Shape shape{(kinds & 1) != 0, (kinds & 2) != 0, (kinds & 4) != 0, (kinds & 8) != 0};
    if (shape.at_corner() != neighbours.count(corner)) continue;
    for (const std::uint32_t right : neighbours.of(corner)) {
      for (const std::uint32_t below : neighbours.of(corner)) {
        if (below == right) continue;
        if (auto sheet = walk(shape, corner, right, below, springs.size())) found.push_back(std::move(*sheet));
      }
    }
  }
  return found;
}

}  // namespace dvdx
