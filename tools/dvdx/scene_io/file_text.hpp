// A whole file as text, and what may be wrong with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dvdx::tool {

// A fault in a file's contents, without the file's name: "line 3 has 2 numbers: must have 3".
class FileFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The most that is read of one kind of file.
struct FileLimit {
  std::uint64_t bytes;
  std::string_view text;
};
inline constexpr FileLimit scene_limit{.bytes = std::uint64_t{1} << 28U, .text = "256 MiB"};
inline constexpr FileLimit data_limit{.bytes = std::uint64_t{1} << 32U, .text = "4 GiB"};  // of points, numbers or a mesh

// Returns the bytes, or why there are none: "cannot be read: No such file or directory". Only regular files are read, because a
// pipe or a device may have no end, or never begin.
[[nodiscard]] tl::expected<std::string, std::string> read_file(const std::filesystem::path& path,
                                                               const FileLimit& limit = data_limit);

}  // namespace dvdx::tool
