// .csv files, as points and as numbers.
#include "fuzz/points.hpp"

void dvdx::fuzz::csv_reader(std::string_view bytes) {
  try_points(bytes, tool::PointsFormat::csv);
  try_numbers(bytes, tool::PointsFormat::csv);
}
