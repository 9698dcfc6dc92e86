// .npy files, as points and as numbers.
#include "fuzz/points.hpp"

void dvdx::fuzz::npy_reader(std::string_view bytes) {
  try_points(bytes, tool::PointsFormat::npy);
  try_numbers(bytes, tool::PointsFormat::npy);
}
