#include "output/radii.hpp"

#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

std::vector<double> radii_of(const Output& output) {
  if (output.scene == nullptr || !output.scene->scene.meet || !output.scene->scene.meet->radius) return {};
  const Scalars& radius = *output.scene->scene.meet->radius;
  const Numbering& numbering = *output.numbering;
  std::vector<double> radii;
  if (numbering.is_own()) {
    for (std::size_t i = 0; i < output.particles; ++i) radii.push_back(radius[i]);
    return radii;
  }
  for (const auto particle : numbering.particles) radii.push_back(particle == Numbering::nobody ? 0 : radius[particle]);
  return radii;
}

}  // namespace dvdx::tool
