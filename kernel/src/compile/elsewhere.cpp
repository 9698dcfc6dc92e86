#include "dvdx/elsewhere.hpp"

#include <algorithm>
#include <cmath>

#include "compile/compiled_scene.hpp"
#include "compile/system.hpp"

namespace dvdx {
namespace {

bool holds_any(const Skin& skin) {
  const auto is_held = [&](std::size_t k) { return skin.backstop || !std::isinf(skin.at_most[k]); };
  for (std::size_t k = 0; k < skin.particles.size(); ++k) {
    if (is_held(k)) return true;
  }
  return false;
}

Elsewhere rates_of(const Scene& scene, std::size_t count) {
  const System system(scene, {}, 1);
  Elsewhere found{.anchors_differ = system.anchors_differ()};
  found.closes_substeps = std::any_of(scene.skins.begin(), scene.skins.end(), holds_any);
  const std::size_t axes = system.is_isotropic() ? 1 : 3;
  for (std::size_t i = 0; i < (system.is_uniform() ? std::min<std::size_t>(count, 1) : count); ++i) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const Rate rate = system.total_rate(axis, i);
      found.W = std::max(found.W, rate.W);
      found.g = std::max(found.g, rate.g);
    }
  }
  return found;
}

bool is_linear(const Force& force) {
  return std::holds_alternative<RadialSpring>(force) && std::holds_alternative<Spring>(with_linear_spring(force));
}

}  // namespace

Elsewhere elsewhere_of(const Scene& scene, std::size_t count) {
  if (std::none_of(scene.forces.begin(), scene.forces.end(), is_linear)) return rates_of(scene, count);
  Scene linear = scene;
  for (Force& force : linear.forces) force = with_linear_spring(force);
  return rates_of(linear, count);
}

}  // namespace dvdx
