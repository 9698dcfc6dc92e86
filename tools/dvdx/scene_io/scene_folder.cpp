#include "scene_io/scene_folder.hpp"

namespace dvdx::tool {

std::filesystem::path SceneFolder::find(const Node& node) {
  const std::filesystem::path path = node.text();
  if (path.is_absolute()) node.refuse("a path relative to the scene file");
  return named_.emplace_back(folder_ / path);
}

}  // namespace dvdx::tool
