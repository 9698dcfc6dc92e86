// Whether particles joined by springs or constraints start inside a surface.
#pragma once

#include <cstddef>
#include <optional>

#include "dvdx/layouts/state.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// The first step puts particles that start inside onto the surface, and springs hold this displacement as energy.
struct StartInside {
  std::size_t particles = 0;  // that start inside, neither fixed nor kinematic
  std::size_t deepest = 0;    // one of them
  Vec3 way{};                 // m: from it to the surface
  double depth = 0;           // m: of way
  double limit = 0;           // m: particles less deep are not counted, a ten-thousandth of the scene's extent
};

// state: the start, in one process. Returns none if nothing starts inside or if nothing joins particles.
template <class T>
[[nodiscard]] std::optional<StartInside> start_inside(const SceneFile& file, const State<T>& state);

extern template std::optional<StartInside> start_inside(const SceneFile&, const State<float>&);
extern template std::optional<StartInside> start_inside(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
