// What the air gives a scene's cloth.
#pragma once

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::tool {

[[nodiscard]] bool meets_air(const Scene& scene) noexcept;

// W: the sum of F.wind, F the air's force on a triangle, over the triangles where it is positive, at the state's time.
template <class T>
[[nodiscard]] double air_power(const Scene& scene, const State<T>& state);

extern template double air_power(const Scene&, const State<float>&);
extern template double air_power(const Scene&, const State<double>&);

}  // namespace dvdx::tool
