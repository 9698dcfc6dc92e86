// Motions by name, and the particles that follow them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "scene_io/network_reader.hpp"

namespace dvdx::tool {

// The names of a scene's motions, in the order of Scene::motions.
class MotionNames {
 public:
  void add(std::string name) { names_.push_back(std::move(name)); }
  // The motion that the node names.
  [[nodiscard]] std::size_t index_of(const Node& node) const;
  [[nodiscard]] const std::vector<std::string>& all() const noexcept { return names_; }

 private:
  std::vector<std::string> names_;
};

// Adds the motions of `fields` to the scene.
[[nodiscard]] MotionNames read_motions(const Fields& fields, Scene& scene);

// Adds the kinematic particles of `fields`; networks: of the scene, if it has any. Fixed particles must have been read before.
void read_kinematic(const Fields& fields, SceneFile& file, const Population& population, const MotionNames& motions,
                    const std::optional<NetworkReader>& networks);

}  // namespace dvdx::tool
