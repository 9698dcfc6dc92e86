#include "meet/passing_layers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "math/vec3.hpp"

namespace dvdx {
namespace {

using Cell = std::array<std::int64_t, 3>;
struct Placed {
  Cell cell;
  std::uint32_t particle;
  bool operator<(const Placed& other) const noexcept { return cell < other.cell; }
};

// Sorts particles by cells of this side. Positions that are not finite, or too far, are left out.
std::vector<Placed> sorted_by_cells(std::span<const Vec3> start, double side) {
  constexpr double farthest = 0x1p62;
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < start.size(); ++i) {
    Cell cell{};
    bool has_place = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = std::floor(start[i][axis] / side);
      has_place = has_place && std::abs(at) < farthest;
      cell[axis] = has_place ? static_cast<std::int64_t>(at) : 0;
    }
    if (has_place) placed.push_back({cell, static_cast<std::uint32_t>(i)});
  }
  std::sort(placed.begin(), placed.end());
  return placed;
}

// use(j) for the particles of this one's cell and of the cells that touch it, as long as it returns true.
template <class Use>
void over_near(std::span<const Placed> placed, const Placed& at, const Use& use) {
  for (int row = 0; row < 9; ++row) {
    const Cell first{at.cell[0] + row / 3 - 1, at.cell[1] + row % 3 - 1, at.cell[2] - 1};
    const Cell last{first[0], first[1], at.cell[2] + 1};
    for (auto of = std::lower_bound(placed.begin(), placed.end(), Placed{first, 0}); of != placed.end() && of->cell <= last;
         ++of) {
      if (!use(of->particle)) return;
    }
  }
}

// The shortest paths from one particle along springs and rods.
class WaysAlong {
 public:
  WaysAlong(std::span<const JoinedPair> joined, std::span<const Vec3> start)
      : from_(start.size() + 1), way_(start.size(), std::numeric_limits<double>::infinity()) {
    for (const JoinedPair& s : joined) {
      ++from_[s.a];
      ++from_[s.b];
    }
    for (std::size_t i = 1; i < from_.size(); ++i) from_[i] += from_[i - 1];
    joined_.resize(2 * joined.size());
    for (const JoinedPair& s : joined) {
      const double l = s.l > 0 ? s.l : distance(start[s.a], start[s.b]);
      joined_[--from_[s.a]] = {l, s.b};
      joined_[--from_[s.b]] = {l, s.a};
    }
  }
  // Finds the paths from a particle, m. Those longer than `most` are infinite.
  void find(std::uint32_t particle, double most) {
    for (const std::uint32_t i : found_) way_[i] = std::numeric_limits<double>::infinity();
    found_.clear();
    come(0, particle, most);
    while (!next_.empty()) {
      const auto [way, i] = next_.top();
      next_.pop();
      if (way > way_[i]) continue;
      for (std::size_t k = from_[i]; k < from_[i + 1]; ++k) come(way + joined_[k].first, joined_[k].second, most);
    }
  }
  [[nodiscard]] double to(std::uint32_t i) const noexcept { return way_[i]; }

 private:
  using Reached = std::pair<double, std::uint32_t>;
  void come(double way, std::uint32_t i, double most) {
    if (!(way <= most) || !(way < way_[i])) return;
    way_[i] = way;
    found_.push_back(i);
    next_.push({way, i});
  }

  std::vector<std::size_t> from_;  // by particle: where its entries of joined_ begin; then their end
  std::vector<Reached> joined_;
  std::vector<double> way_;
  std::vector<std::uint32_t> found_;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next_;
};

}  // namespace

std::size_t count_passing_layers(std::span<const JoinedPair> joined, std::span<const Vec3> start, double most,
                                 const std::function<double(std::uint32_t, std::uint32_t)>& wanted) {
  const std::vector<Placed> placed = sorted_by_cells(start, most);
  std::optional<WaysAlong> ways;
  std::size_t count = 0;
  std::size_t looks = 1024 * start.size();
  for (const Placed& at : placed) {
    bool is_found = false;
    over_near(placed, at, [&](std::uint32_t j) {
      const std::uint32_t i = at.particle;
      const double d = i < j ? wanted(i, j) : 0;
      if (d > 0) {
        if (!ways) ways.emplace(joined, start);
        if (!is_found) ways->find(i, 2 * most);
        is_found = true;
        count += ways->to(j) > 2 * d ? 1U : 0U;
      }
      return --looks > 0 && count < start.size();
    });
    if (looks == 0 || count >= start.size()) break;
  }
  return count;
}

}  // namespace dvdx
