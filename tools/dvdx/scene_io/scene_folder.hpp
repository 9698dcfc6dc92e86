// The files that a scene names, which stand where its own stands.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "scene_io/fields.hpp"

namespace dvdx::tool {

class SceneFolder {
 public:
  explicit SceneFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Where the file is that the node names. Throws Fault where it is named by an absolute path: a scene that is moved or given
  // away goes with its files.
  [[nodiscard]] std::filesystem::path find(const Node& node);
  [[nodiscard]] const std::vector<std::filesystem::path>& named() const noexcept { return named_; }  // so far

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> named_;
};

}  // namespace dvdx::tool
