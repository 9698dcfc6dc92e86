// Whether particles that springs or constraints join start inside a surface.
#pragma once

#include <cstddef>
#include <optional>

#include "dvdx/layouts/state.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// The first step puts what starts inside onto the surface, and springs hold how far that is as energy.
struct StartInside {
  std::size_t particles = 0;  // that start inside, neither fixed nor kinematic
  std::size_t deepest = 0;    // one of them
  Vec3 way{};                 // m: from it to the surface
  double depth = 0;           // m: of way
  double limit = 0;           // m: what is less deep is not counted, a ten-thousandth of the scene's extent
};

// state: the start, by one process. None where nothing starts inside, and where nothing joins particles.
template <class T>
[[nodiscard]] std::optional<StartInside> start_inside(const SceneFile& file, const State<T>& state);

extern template std::optional<StartInside> start_inside(const SceneFile&, const State<float>&);
extern template std::optional<StartInside> start_inside(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
