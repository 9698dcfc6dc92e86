// Points and numbers from the files that a scene refers to.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx::tool {

enum class PointsFormat { csv, ply, npy };

// .csv: three columns, or the columns x, y, z of a header; .ply: the vertices, ascii or binary_little_endian;
// .npy: float32 or float64 of shape (n, 3). All that is read is finite. Throws FileFault.
[[nodiscard]] std::vector<Vec3> read_points(const std::filesystem::path& path);
[[nodiscard]] std::vector<Vec3> parse_points(std::string_view text, PointsFormat format);

// .csv: one column; .npy: shape (n,) or (n, 1). All that is read is finite. Throws FileFault.
[[nodiscard]] std::vector<double> read_numbers(const std::filesystem::path& path);
[[nodiscard]] std::vector<double> parse_numbers(std::string_view text, PointsFormat format);

}  // namespace dvdx::tool
