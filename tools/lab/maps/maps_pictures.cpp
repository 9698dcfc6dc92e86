// One picture for each family of maps, drawn by gnuplot: for each method a heat map of the measured growth with two contours of
// growth one. The measured contour follows the cells' edges, the analysed one goes through its bisected points.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "maps/maps_show.hpp"
#include "output/gnuplot.hpp"

namespace dvdx::tool::stability {
namespace {

// Growth less one on a logarithmic scale to both sides of `one_within`: 9 means twice the amplitude a step, 6 a thousandth
// more.
double shade_of(double growth) {
  const double from_one = growth - 1;
  const double decades = std::log10(std::max(std::abs(from_one) / one_within, 1.0));
  return std::copysign(std::min(decades, 9.0), from_one);
}

constexpr std::string_view palette =
    "set palette defined (-9 '#053061', -6 '#2166ac', -3 '#92c5de', 0 '#ffffff', 3 '#fdb863', 6 '#e08214', 9 '#7f3b08')\n"
    "set cbrange [-9:9]\n";

// The position of a value on the scale of cells, counted from 0.
double cell_of(const Axis& axis, double value) {
  const auto& values = axis.values;
  const auto next = std::upper_bound(values.begin() + 1, values.end() - 1, value);
  const double low = *(next - 1);
  const double part =
      axis.spacing == Spacing::linear ? (value - low) / (*next - low) : std::log(value / low) / std::log(*next / low);
  return static_cast<double>(next - 1 - values.begin()) + part;
}

std::string tic(const Axis& axis, double value) { return fmt::format("'{:g}' {:.3f}", value, cell_of(axis, value)); }

// Ticks at powers of ten and the axis' ends, or at a handful of its values.
std::string tics_of(const Axis& axis) {
  const auto& values = axis.values;
  std::string tics;
  const auto add = [&](double value) { tics += (tics.empty() ? "" : ", ") + tic(axis, value); };
  if (axis.spacing == Spacing::linear) {
    const std::size_t every = (values.size() + 5) / 6;
    for (std::size_t k = values.size() % every == 1 ? 0 : every - 1; k < values.size(); k += every) add(values[k]);
    return tics;
  }
  const double decades = std::log10(values.back() / values.front());
  const auto add_inside = [&](double value) {
    if (value >= values.front() * 0.9999 && value <= values.back() * 1.0001) add(value);
  };
  const int first = static_cast<int>(std::floor(std::log10(values.front()) + 1e-9));
  for (int power = first; std::pow(10, power) <= values.back(); ++power) {
    if (decades < 4 || power % 2 == 0) add_inside(std::pow(10, power));
    if (decades < 3) add_inside(2 * std::pow(10, power));
    if (decades < 2) add_inside(5 * std::pow(10, power));
  }
  return tics;
}

std::string shades(const GrowthMap& map) {
  std::string data;
  for (std::size_t k = 0; k < map.y.values.size(); ++k) {
    for (const double growth : map.row(map.measured, k)) {
      data += std::isnan(growth) ? std::string("NaN ") : fmt::format("{:.2f} ", shade_of(growth));
    }
    data += "\n";
  }
  return data;
}

// The edges between stable and unstable cells.
std::string edges(const GrowthMap& map) {
  const std::size_t columns = map.x.values.size();
  const std::size_t rows = map.y.values.size();
  const auto grows = [&](std::size_t row, std::size_t column) {
    return !(map.measured[row * columns + column] <= 1 + one_within);
  };
  std::string data;
  const auto edge = [&](double x0, double y0, double x1, double y1) {
    data += fmt::format("{} {}\n{} {}\n\n", x0, y0, x1, y1);
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double x = static_cast<double>(column) + 0.5;
      const double y = static_cast<double>(row) + 0.5;
      if (column + 1 < columns && grows(row, column) != grows(row, column + 1)) edge(x, y - 1, x, y);
      if (row + 1 < rows && grows(row, column) != grows(row + 1, column)) edge(x - 1, y, x, y);
    }
  }
  return data;
}

std::string limit_points(const GrowthMap& map) {
  std::string data;
  for (std::size_t k = 0; k < map.limits.size(); ++k) {
    if (map.limits[k] > 0) data += fmt::format("{:.3f} {}\n", cell_of(map.x, map.limits[k]), k);
  }
  return data;
}

std::string panel(const GrowthMap& map, std::size_t number) {
  const std::string marks = limit_points(map);
  const std::string rim = edges(map);
  std::string text = fmt::format("$shades{0} << EOD\n{1}EOD\n", number, shades(map));
  std::string plot = fmt::format("plot $shades{} matrix with image notitle", number);
  if (!rim.empty()) {
    text += fmt::format("$edges{0} << EOD\n{1}EOD\n", number, rim);
    plot += fmt::format(", $edges{} with lines lc rgb 'black' lw 1.6 notitle", number);
  }
  if (!marks.empty()) {
    text += fmt::format("$limits{0} << EOD\n{1}EOD\n", number, marks);
    plot += fmt::format(
        ", $limits{0} with points pt 7 ps 0.42 lc rgb 'white' notitle, $limits{0} with points pt 6 ps 0.42 lw 0.8 "
        "lc rgb 'black' notitle",
        number);
  }
  return text + fmt::format(
                    "set title {} noenhanced\nset xrange [-0.5:{}]\nset yrange [-0.5:{}]\nset xtics ({})\nset ytics ({})\n{}\n",
                    gnuplot_literal(map.method), static_cast<double>(map.x.values.size()) - 0.5,
                    static_cast<double>(map.y.values.size()) - 0.5, tics_of(map.x), tics_of(map.y), plot);
}

// The colour scale, in the place of a panel.
std::string legend_at(double x, double y, double width) {
  std::string row;
  for (int quarters = -36; quarters <= 36; ++quarters) row += fmt::format("{} ", quarters / 4.0);
  return fmt::format(
      "$scale << EOD\n{0}\n{0}\nEOD\nset title 'growth less one' noenhanced\nset xrange [-9:9]\nset yrange [-0.5:1.5]\nunset "
      "ytics\n"
      "unset ylabel\nunset xlabel\n"
      "set xtics ('−1' -9, '−10^{{-3}}' -6, '−10^{{-6}}' -3, '0' 0, '10^{{-6}}' 3, '10^{{-3}}' 6, '1' 9)\n"
      "set size {1},0.2\nset origin {2},{3}\nplot $scale matrix using ($1 / 4 - 9):2:3 with image notitle\n",
      row, width, x, y);
}

std::string script_of(std::span<const GrowthMap> family) {
  const std::size_t places = family.size() + 1;
  const std::size_t columns = places > 6 ? 4 : (places > 4 ? 3 : 2);
  const std::size_t rows = (places + columns - 1) / columns;
  const GrowthMap& first = family.front();
  std::string text = fmt::format(
      "set terminal svg size {},{} standalone font 'sans-serif,11' background '#ffffff'\nset encoding utf8\nset datafile "
      "missing "
      "'NaN'\n{}unset colorbox\nunset key\nset tics nomirror out scale 0.5\nset multiplot title {} noenhanced\nset xlabel {} "
      "noenhanced offset 0,0.4\nset ylabel {} noenhanced offset 0.6,0\n",
      280 * columns, 40 + 210 * rows, palette, gnuplot_literal(first.title), gnuplot_literal(first.x.name),
      gnuplot_literal(first.y.name));
  const double width = 1.0 / static_cast<double>(columns);
  const double height = 0.94 / static_cast<double>(rows);
  for (std::size_t k = 0; k < family.size(); ++k) {
    const double x = width * static_cast<double>(k % columns);
    const double y = 0.94 - height * static_cast<double>(k / columns + 1);
    text += fmt::format("set size {},{}\nset origin {},{}\n", width, height, x, y) + panel(family[k], k);
  }
  const std::size_t last = rows * columns - 1;
  return text + legend_at(width * static_cast<double>(last % columns), 0.3 * height, width) + "unset multiplot\n";
}

// Keeps cells sharp when a viewer enlarges the picture.
std::string with_sharp_images(std::string svg) {
  const std::string image = "<image ";
  for (std::size_t at = svg.find(image); at != std::string::npos; at = svg.find(image, at + image.size())) {
    svg.insert(at + image.size(), "style='image-rendering:pixelated' ");
  }
  return svg;
}

}  // namespace

MapPictures draw_maps(const std::vector<GrowthMap>& maps) {
  MapPictures pictures;
  std::vector<std::string> scripts;
  for (auto first = maps.begin(); first != maps.end();) {
    const auto last = std::find_if(first, maps.end(), [&](const GrowthMap& map) { return map.name != first->name; });
    scripts.push_back(script_of({first, last}));
    pictures.all.push_back({.file = first->name + ".svg", .svg = {}});
    first = last;
  }
  const auto drawn = run_gnuplot(scripts);
  if (!drawn) return {.all = {}, .warning = drawn.error()};
  for (std::size_t k = 0; k < drawn->size(); ++k) pictures.all[k].svg = with_sharp_images((*drawn)[k]);
  return pictures;
}

}  // namespace dvdx::tool::stability
