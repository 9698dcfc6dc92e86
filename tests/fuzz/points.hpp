// The points and numbers of any accepted file must be finite.
#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "fuzz/targets.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/points_file.hpp"

namespace dvdx::fuzz {

inline void try_points(std::string_view bytes, tool::PointsFormat format) {
  try {
    for (const Vec3& point : tool::parse_points(bytes, format)) {
      for (const double value : point) expect(std::isfinite(value), "points are finite");
    }
  } catch (const tool::FileFault&) {
  }
}

inline void try_numbers(std::string_view bytes, tool::PointsFormat format) {
  try {
    const std::vector<double> numbers = tool::parse_numbers(bytes, format);
    expect(std::all_of(numbers.begin(), numbers.end(), [](double value) { return std::isfinite(value); }),
           "numbers are finite");
  } catch (const tool::FileFault&) {
  }
}

}  // namespace dvdx::fuzz
