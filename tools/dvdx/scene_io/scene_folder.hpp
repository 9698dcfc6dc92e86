// The files that a scene names, relative to the folder of its own file.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "scene_io/fields.hpp"

namespace dvdx::tool {

class SceneFolder {
 public:
  explicit SceneFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Returns the path of the file that the node names. Throws Fault for an absolute path, because a scene that is moved or given
  // away goes with its files.
  [[nodiscard]] std::filesystem::path find(const Node& node);
  [[nodiscard]] const std::vector<std::filesystem::path>& named() const noexcept { return named_; }  // so far

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> named_;
};

}  // namespace dvdx::tool
