// Growth per step over two quantities, by analysis and by measurement, and whether the two agree.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace dvdx::tool::stability {

enum class Spacing { linear, logarithmic };

struct Axis {
  std::string name;  // with its unit, where it has one
  std::vector<double> values;
  Spacing spacing = Spacing::linear;
};

// count >= 2 values from first to last, both included.
[[nodiscard]] Axis spread(const std::string& name, double first, double last, std::size_t count, Spacing spacing);

// A growth of one within this is stable: what rounding leaves of a radius of one, and less than any method's own growth shown.
inline constexpr double one_within = 1e-9;
// How far a measured growth may lie from the analysed one, relative to it where it is above one.
inline constexpr double growth_within = 1e-6;

struct GrowthMap {
  std::string name;    // of the family: "springs"
  std::string title;   // "equal springs on one particle"
  std::string method;  // "average_acceleration"
  Axis x, y;
  // The growth of the amplitude per step (of a bounce: of the energy); row by row, y.values.size() rows of x.values.size().
  std::vector<double> analysed, measured;
  std::vector<double> limits;  // a row: the x beyond which it grows, by analysis and bisection; not a number where none does

  [[nodiscard]] std::span<const double> row(const std::vector<double>& growth, std::size_t y_index) const {
    return std::span(growth).subspan(y_index * x.values.size(), x.values.size());
  }
};

// The first of a row that grows; the row's size where none does. A value that is not a number grows.
[[nodiscard]] std::size_t first_unstable(std::span<const double> row);

struct Agreement {
  std::size_t boundary_cells = 0;  // the largest distance between the analysed and the measured boundary
  double boundary_y = 0;           // of the row where that is
  double growth_difference = 0;    // the largest |measured - analysed| / max(1, analysed)
  double growth_x = 0, growth_y = 0;
  [[nodiscard]] bool is_good() const { return boundary_cells <= 1 && growth_difference <= growth_within; }
};
[[nodiscard]] Agreement agreement_of(const GrowthMap& map);

// The largest x of low..high up to which growth(x) stays at one, by bisection: low is stable, high grows.
[[nodiscard]] double bisected(double low, double high, const std::function<double(double)>& growth);

// The map of `cell_at(x, y)`, whose growth `analyse(cell)` works out and `measure(all cells)` measures.
template <class CellAt, class Analyse, class Measure>
void fill(GrowthMap& map, const CellAt& cell_at, const Analyse& analyse, const Measure& measure) {
  std::vector<decltype(cell_at(0.0, 0.0))> cells;
  for (const double y : map.y.values) {
    for (const double x : map.x.values) cells.push_back(cell_at(x, y));
  }
  for (const auto& cell : cells) map.analysed.push_back(analyse(cell));
  map.measured = measure(cells);
  for (std::size_t k = 0; k < map.y.values.size(); ++k) {
    const std::size_t first = first_unstable(map.row(map.analysed, k));
    const double y = map.y.values[k];
    const auto growth = [&](double x) { return analyse(cell_at(x, y)); };
    const auto& x = map.x.values;
    if (first == 0) {
      map.limits.push_back(0);
    } else {
      map.limits.push_back(first == x.size() ? std::numeric_limits<double>::quiet_NaN()
                                             : bisected(x[first - 1], x[first], growth));
    }
  }
}

}  // namespace dvdx::tool::stability
