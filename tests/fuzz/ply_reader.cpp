// .ply files.
#include "fuzz/points.hpp"

void dvdx::fuzz::ply_reader(std::string_view bytes) { try_points(bytes, tool::PointsFormat::ply); }
