#include "maps/growth_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dvdx::tool::stability {
namespace {

bool grows(double growth) { return !(growth <= 1 + one_within); }

}  // namespace

Axis spread(const std::string& name, double first, double last, std::size_t count, Spacing spacing) {
  Axis axis{.name = name, .values = {}, .spacing = spacing};
  for (std::size_t k = 0; k < count; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(count - 1);
    axis.values.push_back(spacing == Spacing::linear ? first + (last - first) * part : first * std::pow(last / first, part));
  }
  return axis;
}

std::size_t first_unstable(std::span<const double> row) {
  std::size_t k = 0;
  while (k < row.size() && !grows(row[k])) ++k;
  return k;
}

Agreement agreement_of(const GrowthMap& map) {
  Agreement found;
  for (std::size_t k = 0; k < map.y.values.size(); ++k) {
    const std::size_t a = first_unstable(map.row(map.analysed, k));
    const std::size_t m = first_unstable(map.row(map.measured, k));
    const std::size_t apart = a < m ? m - a : a - m;
    if (apart > found.boundary_cells) {
      found.boundary_cells = apart;
      found.boundary_y = map.y.values[k];
    }
  }
  for (std::size_t cell = 0; cell < map.analysed.size(); ++cell) {
    const double difference = std::abs(map.measured[cell] - map.analysed[cell]) / std::max(1.0, map.analysed[cell]);
    if (difference <= found.growth_difference) continue;  // NaN passes, and counts as the largest
    found.growth_difference = std::isnan(difference) ? std::numeric_limits<double>::infinity() : difference;
    found.growth_x = map.x.values[cell % map.x.values.size()];
    found.growth_y = map.y.values[cell / map.x.values.size()];
  }
  return found;
}

double bisected(double low, double high, const std::function<double(double)>& growth) {
  for (int step = 0; step < 50; ++step) {
    const double middle = (low + high) / 2;
    (grows(growth(middle)) ? high : low) = middle;
  }
  return low;
}

}  // namespace dvdx::tool::stability
