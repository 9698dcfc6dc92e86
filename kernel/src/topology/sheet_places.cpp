#include "topology/sheet_places.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <utility>

#include "topology/neighbours.hpp"

// The number of columns of a sheet follows from its shape, particles and springs. A corner, and the particles to the right of
// it and below, then decide all others. The candidates for the next place are the neighbours of the particle before (in the
// first row) or above. A candidate fits if those of its neighbours that have a place stand just where springs that lead to the
// next place begin. If several fit, the one of fewest neighbours takes the place, nearest to the sheet's edge. Nothing is taken
// back. So anything found is a sheet, but a sheet may not be found.

namespace dvdx {
namespace {

struct StencilOffset {
  std::ptrdiff_t down, right;
  bool operator==(const StencilOffset&) const = default;
};

// The offsets at which springs lead from each particle of a sheet.
class SheetShape {
 public:
  explicit SheetShape(std::vector<StencilOffset> offsets) : offsets_(std::move(offsets)) {}

  [[nodiscard]] bool has(const StencilOffset& offset) const noexcept {
    return std::find(offsets_.begin(), offsets_.end(), offset) != offsets_.end();
  }
  [[nodiscard]] std::size_t springs(std::size_t rows, std::size_t columns) const noexcept {
    std::size_t count = 0;
    for (const StencilOffset& offset : offsets_) {
      const auto across = static_cast<std::size_t>(std::abs(offset.right));
      const auto down = static_cast<std::size_t>(offset.down);
      if (rows > down && columns > across) count += (rows - down) * (columns - across);
    }
    return count;
  }
  // The number of neighbours of the particle in the top left corner.
  [[nodiscard]] std::size_t at_corner() const noexcept {
    return static_cast<std::size_t>(
        std::count_if(offsets_.begin(), offsets_.end(), [](const StencilOffset& offset) { return offset.right >= 0; }));
  }
  // The number of springs that lead to a place of a sheet with so many columns.
  [[nodiscard]] std::size_t leading_to(std::size_t row, std::size_t column, std::size_t columns) const noexcept {
    const auto r = static_cast<std::ptrdiff_t>(row), c = static_cast<std::ptrdiff_t>(column);
    return static_cast<std::size_t>(std::count_if(offsets_.begin(), offsets_.end(), [&](const StencilOffset& offset) {
      return r >= offset.down && c >= offset.right && c - offset.right < static_cast<std::ptrdiff_t>(columns);
    }));
  }

 private:
  std::vector<StencilOffset> offsets_;
};

// Returns all shapes: springs along rows and columns; with any of the diagonals; and with bends along rows, columns or both, or
// across the sides of triangles.
std::vector<SheetShape> shapes() {
  const std::array<std::vector<StencilOffset>, 4> diagonals{{{}, {{1, 1}}, {{1, -1}}, {{1, 1}, {1, -1}}}};
  const std::array<std::vector<StencilOffset>, 6> bends{
      {{}, {{0, 2}}, {{2, 0}}, {{0, 2}, {2, 0}}, {{1, 2}, {2, 1}}, {{1, -2}, {2, -1}}}};
  std::vector<SheetShape> all;
  for (const std::vector<StencilOffset>& diagonal : diagonals) {
    for (const std::vector<StencilOffset>& bend : bends) {
      std::vector<StencilOffset> offsets{{0, 1}, {1, 0}};
      offsets.insert(offsets.end(), diagonal.begin(), diagonal.end());
      offsets.insert(offsets.end(), bend.begin(), bend.end());
      all.emplace_back(std::move(offsets));
    }
  }
  return all;
}

class SheetWalk {
 public:
  static constexpr std::uint32_t nowhere = 0xffffffff;

  SheetWalk(const Neighbours& neighbours, std::size_t count) : neighbours_(neighbours), place_(count, nowhere) {}

  // Returns none if there is no sheet of such a shape.
  [[nodiscard]] std::optional<SheetPlaces> operator()(const SheetShape& shape, std::size_t columns, std::uint32_t corner,
                                                      std::uint32_t right, std::uint32_t below) {
    for (const std::uint32_t i : at_) place_[i] = nowhere;
    at_.clear();
    columns_ = columns;
    take(corner);
    take(right);
    while (at_.size() < columns_) {
      if (!take_next(shape, at_.back(), below)) return std::nullopt;
    }
    if (!fits(shape, below, 1, 0)) return std::nullopt;
    take(below);
    while (at_.size() < place_.size()) {
      if (!take_next(shape, at_[at_.size() - columns_], nowhere)) return std::nullopt;
    }
    return SheetPlaces{place_.size() / columns_, columns_, place_};
  }

 private:
  void take(std::uint32_t i) {
    place_[i] = static_cast<std::uint32_t>(at_.size());
    at_.push_back(i);
  }

  // Gives the next place to one of a particle's neighbours, other than `other`. Returns false if none fits.
  [[nodiscard]] bool take_next(const SheetShape& shape, std::uint32_t particle, std::uint32_t other) {
    const std::size_t row = at_.size() / columns_;
    const std::size_t column = at_.size() % columns_;
    std::optional<std::uint32_t> best;
    for (const std::uint32_t i : neighbours_.of(particle)) {
      if (place_[i] != nowhere || i == other || !fits(shape, i, row, column)) continue;
      if (!best || neighbours_.count(i) < neighbours_.count(*best)) best = i;
    }
    if (best) take(*best);
    return best.has_value();
  }

  [[nodiscard]] bool fits(const SheetShape& shape, std::uint32_t i, std::size_t row, std::size_t column) const {
    std::size_t found = 0;
    for (const std::uint32_t j : neighbours_.of(i)) {
      if (place_[j] == nowhere) continue;
      const auto down = static_cast<std::ptrdiff_t>(row - place_[j] / columns_);
      const auto right = static_cast<std::ptrdiff_t>(column) - static_cast<std::ptrdiff_t>(place_[j] % columns_);
      if (!shape.has({down, right})) return false;
      ++found;
    }
    return found == shape.leading_to(row, column, columns_);
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

std::optional<SheetPlaces> sheet_places(std::span<const JoinedPair> springs, std::size_t count) {
  constexpr std::size_t least = 3;  // rows and columns
  if (count < least * least) return std::nullopt;
  const Neighbours neighbours(springs, count);
  const std::uint32_t corner = fewest_neighbours(neighbours, count);
  SheetWalk walk(neighbours, count);
  for (const SheetShape& shape : shapes()) {
    if (shape.at_corner() != neighbours.count(corner)) continue;
    for (std::size_t columns = least; columns <= count / least; ++columns) {
      if (count % columns != 0 || shape.springs(count / columns, columns) != springs.size()) continue;
      for (const std::uint32_t right : neighbours.of(corner)) {
        for (const std::uint32_t below : neighbours.of(corner)) {
          if (below == right) continue;
          if (auto sheet = walk(shape, columns, corner, right, below)) return sheet;
        }
      }
    }
  }
  return std::nullopt;
}

}  // namespace dvdx
