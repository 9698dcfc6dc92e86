// A whole file as text, and what may be wrong with it.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <tl/expected.hpp>

namespace dvdx::tool {

// What is wrong with what a file holds, without its name: "line 3 has 2 numbers: must have 3".
class FileFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The bytes, or what stood in the way: "cannot be read: No such file or directory".
[[nodiscard]] tl::expected<std::string, std::string> read_file(const std::filesystem::path& path);

}  // namespace dvdx::tool
