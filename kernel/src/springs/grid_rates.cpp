#include "springs/grid_rates.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "springs/frequencies.hpp"

namespace dvdx {

// With X = cos a, Y = cos b, a and b a wave's phase angles from one column and from one row to the next, the springs' terms are
//   2 g,   g = ks (2 - X - Y) + 2 kb (2 - X^2 - Y^2) + 2 kd (1 - X Y),   X and Y from -1 to 1
// (both diagonals: (1 - cos(a + b)) + (1 - cos(a - b)) = 2 - 2 X Y; every second one: 1 - cos 2a = 2 - 2 X^2). g is concave in
// X and in Y. Its largest value lies on an edge, at a corner or where the derivative along the edge is 0. Or it lies inside, if
// both derivatives are 0: at X = Y = -ks / (4 kb + 2 kd), or if 2 kb = kd on a line through this point that ends on the edges.
double largest_symbol(double structural, double shear, double bend) noexcept {
  const auto g = [&](double X, double Y) {
    return structural * (2 - X - Y) + 2 * bend * (2 - X * X - Y * Y) + 2 * shear * (1 - X * Y);
  };
  // Along an edge. X and Y are interchangeable.
  const auto on_edge = [&](double X) {
    double most = std::max(g(X, -1), g(X, 1));
    if (bend > 0) most = std::max(most, g(X, std::clamp(-(structural + 2 * shear * X) / (4 * bend), -1.0, 1.0)));
    return most;
  };
  double most = std::max(on_edge(-1), on_edge(1));
  if (bend > 0 || shear > 0) {
    const double inside = std::max(-1.0, -structural / (4 * bend + 2 * shear));
    most = std::max(most, g(inside, inside));
  }
  return 2 * most;
}

namespace {

double largest_symbol_of(const Grid& grid) { return largest_symbol(grid.structural, grid.shear, grid.bend); }

// The largest symbol of the damping, which is the same for all springs that exist.
double largest_damping_symbol(const Grid& grid) {
  const auto damping = [&](double k) { return k != 0 ? grid.damping : 0; };
  return largest_symbol(damping(grid.structural), damping(grid.shear), damping(grid.bend));
}

}  // namespace

GridRates::GridRates(const Grid& grid, std::span<const double> w)
    : rows_(grid.rows),
      columns_(grid.columns),
      damping_(grid.damping),
      directions_(directions_of(grid)),
      symbol_k_(largest_symbol_of(grid)),
      symbol_c_(largest_damping_symbol(grid)),
      of_k_(w.size()),
      of_c_(grid.damping != 0 ? w.size() : 0),
      by_row_(grid.rows) {
  for (const Pair& ends : grid.broken) {
    reserve_broken();
    mark(*spring_between(grid, ends), SpringIs::torn);
  }
  for (std::size_t row = 0; row < rows_; ++row) sum_up_row(w, row);
  for (std::size_t row = 0; row < rows_; ++row) look_at(w, row);
}

void GridRates::reserve_broken() {
  if (broken_.empty()) broken_.resize(rows_ * columns_, 0);
}

bool GridRates::is_whole(std::size_t row, std::size_t column, std::size_t direction) const noexcept {
  return broken_.empty() || (broken_[row * columns_ + column] >> direction & 1U) == 0;
}

GridRates::Springs GridRates::springs_at(std::size_t row, std::size_t column) const noexcept {
  Springs found;
  for (std::size_t n = 0; n < directions_.size(); ++n) {
    const GridDirection& d = directions_[n];
    const auto right = static_cast<std::ptrdiff_t>(column) + d.right;
    const auto left = static_cast<std::ptrdiff_t>(column) - d.right;
    const auto is_inside = [&](std::ptrdiff_t c) { return c >= 0 && c < static_cast<std::ptrdiff_t>(columns_); };
    std::size_t ends = 0;
    if (row + d.down < rows_ && is_inside(right) && is_whole(row, column, n)) ++ends;
    if (row >= d.down && is_inside(left) && is_whole(row - d.down, static_cast<std::size_t>(left), n)) ++ends;
    found.k += static_cast<double>(ends) * d.k;
    found.count += ends;
  }
  return found;
}

void GridRates::sum_up(std::span<const double> w, std::size_t row, std::size_t column, const Springs& springs) noexcept {
  const std::size_t i = row * columns_ + column;
  of_k_[i] = w[i] * springs.k;
  if (!of_c_.empty()) of_c_[i] = w[i] * (damping_ * static_cast<double>(springs.count));
}

// If no spring is torn, all particles of a row that are at least two columns from the sheet's sides have the same springs.
void GridRates::sum_up_row(std::span<const double> w, std::size_t row) noexcept {
  const bool is_alike = broken_.empty() && columns_ > 4;
  const Springs inside = is_alike ? springs_at(row, 2) : Springs{};
  for (std::size_t column = 0; column < columns_; ++column) {
    const bool is_inside = is_alike && column >= 2 && column + 2 < columns_;
    sum_up(w, row, column, is_inside ? inside : springs_at(row, column));
  }
}

void GridRates::look_at(std::span<const double> w, std::size_t row) noexcept {
  Row found;
  const std::size_t first = row * columns_;
  for (std::size_t i = first; i < first + columns_; ++i) found.w = std::max(found.w, w[i]);
  for (std::size_t n = 0; n < directions_.size(); ++n) {
    const GridDirection& d = directions_[n];
    if (row + d.down >= rows_) continue;
    const std::size_t from = d.right < 0 ? static_cast<std::size_t>(-d.right) : 0;
    const std::size_t across = d.right > 0 ? static_cast<std::size_t>(d.right) : 0;
    const std::size_t to = columns_ > across ? columns_ - across : 0;
    const auto other = static_cast<std::ptrdiff_t>(d.down * columns_) + d.right;
    const auto most_of = [&](const std::vector<double>& of) {
      double most = 0;
      const double* const a = of.data() + first;
      const double* const b = a + other;
      for (std::size_t column = from; column < to; ++column) {
        const double both = a[column] + b[column];
        if (both > most && is_whole(row, column, n)) most = both;
      }
      return most;
    };
    found.of_k = std::max(found.of_k, most_of(of_k_));
    if (!of_c_.empty()) found.of_c = std::max(found.of_c, most_of(of_c_));
  }
  by_row_[row] = found;
}

// Springs lead at most two rows down.
void GridRates::look_around(std::span<const double> w, std::size_t row) noexcept {
  for (std::size_t r = row - std::min<std::size_t>(row, 2); r <= row; ++r) look_at(w, r);
}

void GridRates::set_mass(std::span<const double> w, std::size_t particle) noexcept {
  const std::size_t row = particle / columns_;
  sum_up(w, row, particle % columns_, springs_at(row, particle % columns_));
  look_around(w, row);
}

void GridRates::mark(const GridSpring& spring, SpringIs state) noexcept {
  for (std::size_t n = 0; n < directions_.size(); ++n) {
    if (directions_[n].down != spring.down || directions_[n].right != spring.right) continue;
    const auto bit = static_cast<std::uint8_t>(1U << n);
    std::uint8_t& bits = broken_[spring.row * columns_ + spring.column];
    bits = static_cast<std::uint8_t>(state == SpringIs::torn ? bits | bit : bits & ~bit);
  }
}

void GridRates::set(std::span<const double> w, const GridSpring& spring, SpringIs state) noexcept {
  mark(spring, state);
  const auto other = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(spring.column) + spring.right);
  sum_up(w, spring.row, spring.column, springs_at(spring.row, spring.column));
  sum_up(w, spring.row + spring.down, other, springs_at(spring.row + spring.down, other));
  const std::size_t from = spring.row - std::min<std::size_t>(spring.row, 2);
  for (std::size_t r = from; r <= spring.row + spring.down; ++r) look_at(w, r);
}

GridRates::Row GridRates::highest(std::size_t first_row, std::size_t end_row) const noexcept {
  Row most;
  for (std::size_t n = first_row; n < end_row; ++n) {
    const Row& row = by_row_[n];
    most = {std::max(most.of_k, row.of_k), std::max(most.of_c, row.of_c), std::max(most.w, row.w)};
  }
  return most;
}

double GridRates::of_stiffness() const noexcept {
  const Row most = highest(0, rows_);
  return std::min(most.of_k, symbol_k_ * most.w);
}

double GridRates::of_damping() const noexcept {
  const Row most = highest(0, rows_);
  return std::min(most.of_c, symbol_c_ * most.w);
}

SheetRates rates_of_rows(const Scene& scene, std::uint64_t first, std::uint64_t end) {
  const Grid* const only = sheet_of(scene);
  if (only == nullptr) return {};
  const Grid& sheet = *only;
  end = std::min<std::uint64_t>(end, sheet.rows);
  if (first >= end) return {};
  // Springs lead at most two rows down, and a particle there has springs that lead two rows further.
  const std::uint64_t from = first - std::min<std::uint64_t>(first, 2);
  Grid rows = sheet;
  rows.rows = std::min<std::uint64_t>(sheet.rows, end + 4) - from;
  rows.rows_of_whole = sheet.rows;
  const std::size_t first_particle = from * sheet.columns;
  std::vector<double> w(rows.rows * sheet.columns);
  for (std::size_t i = 0; i < w.size(); ++i) w[i] = 1 / scene.mass[first_particle + i];
  const auto hold = [&](const std::vector<std::size_t>& particles) {
    for (const std::size_t i : particles) {
      if (i >= first_particle && i - first_particle < w.size()) w[i - first_particle] = 0;
    }
  };
  hold(scene.fixed);
  for (const Kinematic& followers : scene.kinematic) hold(followers.particles);
  const GridRates::Row found = GridRates(rows, w).highest(first - from, end - from);
  return {.of_k = found.of_k, .of_c = found.of_c, .w = found.w};
}

HighestRates rates_of(const Grid& sheet, const SheetRates& all) noexcept {
  return {std::sqrt(std::min(all.of_k, largest_symbol_of(sheet) * all.w)),
          std::min(all.of_c, largest_damping_symbol(sheet) * all.w)};
}

}  // namespace dvdx
