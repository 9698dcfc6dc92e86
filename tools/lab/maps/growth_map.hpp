// Growth per step over two quantities, by analysis and by measurement, and the agreement of the two.
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
  std::string name;  // with its unit, if it has one
  std::vector<double> values;
  Spacing spacing = Spacing::linear;
};

// count >= 2 values from first to last, both included.
[[nodiscard]] Axis spread(const std::string& name, double first, double last, std::size_t count, Spacing spacing);

// A growth of one within this tolerance is stable: above the rounding of a radius of one, below any growth shown.
inline constexpr double one_within = 1e-9;
// The tolerance of a measured growth, relative to the analysed one if that is above one.
inline constexpr double growth_within = 1e-6;

struct GrowthMap {
  std::string name;    // the family's: "springs"
  std::string title;   // "equal springs on one particle"
  std::string method;  // "average_acceleration"
  Axis x, y;
  // The growth of the amplitude per step (for a bounce: of the energy), in y.values.size() rows of x.values.size() cells.
  std::vector<double> analysed, measured;
  std::vector<double> limits;  // for each row: the x beyond which it grows, by analysis and bisection; NaN if none does

  [[nodiscard]] std::span<const double> row(const std::vector<double>& growth, std::size_t y_index) const {
    return std::span(growth).subspan(y_index * x.values.size(), x.values.size());
  }
};

// Index of the first unstable cell of a row; the row's size if there is none. NaN is unstable.
[[nodiscard]] std::size_t first_unstable(std::span<const double> row);

struct Agreement {
  std::size_t boundary_cells = 0;  // the largest distance between the analysed and the measured boundary
  double boundary_y = 0;           // the row of that distance
  double growth_difference = 0;    // the largest |measured - analysed| / max(1, analysed)
  double growth_x = 0, growth_y = 0;
  [[nodiscard]] bool is_good() const { return boundary_cells <= 1 && growth_difference <= growth_within; }
};
[[nodiscard]] Agreement agreement_of(const GrowthMap& map);

// The largest x in low..high up to which growth(x) stays at one, by bisection. low is stable, high is not.
[[nodiscard]] double bisected(double low, double high, const std::function<double(double)>& growth);

// Fills the map of `cell_at(x, y)`: `analyse(cell)` computes a cell's growth, `measure(all cells)` measures all.
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
