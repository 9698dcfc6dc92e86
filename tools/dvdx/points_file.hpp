// Points and numbers from the files that a scene refers to.
#pragma once

#include <filesystem>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx::tool {

// .csv: three columns, or the columns x, y, z of a header; .ply: the vertices, ascii or binary_little_endian;
// .npy: float32 or float64 of shape (n, 3).
[[nodiscard]] std::vector<Vec3> read_points(const std::filesystem::path& path);

// .csv: one column; .npy: shape (n,) or (n, 1).
[[nodiscard]] std::vector<double> read_numbers(const std::filesystem::path& path);

}  // namespace dvdx::tool
