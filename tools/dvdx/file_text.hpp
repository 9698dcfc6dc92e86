// A whole file as text.
#pragma once

#include <filesystem>
#include <string>
#include <tl/expected.hpp>

namespace dvdx::tool {

// The bytes, or what stood in the way: "cannot be read: No such file or directory".
[[nodiscard]] tl::expected<std::string, std::string> read_file(const std::filesystem::path& path);

}  // namespace dvdx::tool
