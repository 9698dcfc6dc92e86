// Points and numbers from the files that a scene refers to.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string_view>
#include <variant>
#include <vector>

#include "dvdx/scene.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

enum class PointsFormat { csv, ply, npy };

// Consecutive rows.
struct Run {
  std::size_t first = 0, count = std::numeric_limits<std::size_t>::max();
};

// The values that are kept of a file, and the number of rows that it holds in all. Rows that are not kept are not parsed:
// binary files skip them, text files count them.
template <class List>
struct KeptOf {
  List values;
  std::size_t all = 0;
};
template <class Value>
using Kept = KeptOf<std::vector<Value>>;

// .csv: three columns, or the columns x, y, z of a header; .ply: the vertices, ascii or binary_little_endian; .npy: float32 or
// float64 of shape (n, 3). All kept values are finite. Throws FileFault. Points stay in float32 if a binary file holds that:
// many points then take half the memory.
using Points = std::variant<KeptOf<Chunked<Vec3>>, KeptOf<Chunked<Vec3f>>>;
[[nodiscard]] Points read_points_as_held(const std::filesystem::path& path, const Run& run = {});
[[nodiscard]] Kept<Vec3> read_points(const std::filesystem::path& path, const Run& run = {});
[[nodiscard]] std::vector<Vec3> parse_points(std::string_view text, PointsFormat format);

// .csv: one column; .npy: shape (n,) or (n, 1). All kept values are finite. Throws FileFault.
[[nodiscard]] Kept<double> read_numbers(const std::filesystem::path& path, const Run& run = {});
[[nodiscard]] std::vector<double> parse_numbers(std::string_view text, PointsFormat format);

}  // namespace dvdx::tool
