// Mechanical energy of a state.
#pragma once

#include "dvdx/layouts/state.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// J: kinetic, plus the potential of constant forces (zero at the origin), springs, radial springs and networks, whose rest
// lengths "start" are those of the scene's start. Drag and forces of time alone have none. Summed in float64 in particle order
// with a running compensation, so the same for every layout and thread count.
template <class T>
[[nodiscard]] double energy(const SceneFile& file, const State<T>& state);

extern template double energy(const SceneFile&, const State<float>&);
extern template double energy(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
