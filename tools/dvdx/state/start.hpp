// The state of a scene's particles at time 0.
#pragma once

#include "dvdx/layouts/state.hpp"
#include "dvdx/parallel.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Writes position (from the scene's origin) and velocity of every particle, rounded once to T or to T and its residual; fixed
// particles get velocity zero. Throws Fault (bad_scene) if a value is beyond T. state.count must be the scene's.
template <class T>
void place_at_start(const SceneFile& file, State<T>& state, const ParallelFor& parallel = {});
// The same, and releases the values read from files as the state fills: they are gone afterwards.
template <class T>
void move_to_start(SceneFile& file, State<T>& state, const ParallelFor& parallel);
// Whether the start is still needed once particles have been placed: by the energy of springs anchored there, and by springs
// and constraints whose length is that at the start.
[[nodiscard]] bool is_start_asked_for(const Scene& scene);

extern template void place_at_start(const SceneFile&, State<float>&, const ParallelFor&);
extern template void place_at_start(const SceneFile&, State<double>&, const ParallelFor&);
extern template void move_to_start(SceneFile&, State<float>&, const ParallelFor&);
extern template void move_to_start(SceneFile&, State<double>&, const ParallelFor&);

}  // namespace dvdx::tool
