// The origin of float32 states, by which a scene far from the world's origin keeps the digits that it has near it.
#pragma once

#include "dvdx/layouts/state.hpp"
#include "dvdx/ranks.hpp"
#include "scene_io/scene_file.hpp"
#include "state/engine.hpp"

namespace dvdx::tool {

// Gives the scene an origin if `precision` is float32, the file names none and particles far out would lose digits:
//   only forces of its own on each particle: whole metres near its anchor, otherwise near its start, for each that is far;
//   contacts, networks or constraints: whole metres at the middle of all particles, if that brings all of them nearer.
void choose_origin(SceneFile& file, Precision precision);
// The same for the particles of all ranks.
void choose_origin(SceneFile& file, Precision precision, Ranks& ranks);

// Whether a state's columns differ from world coordinates: by an origin or by residuals.
[[nodiscard]] bool is_seen_from_elsewhere(const Scene& scene, Rounding rounding) noexcept;

// Writes the state with residuals added, from the world's origin. first: the scene's number of its first particle.
template <class T>
void to_world(const Scene& scene, const State<T>& state, State<double>& world, std::size_t first = 0);

extern template void to_world(const Scene&, const State<float>&, State<double>&, std::size_t);
extern template void to_world(const Scene&, const State<double>&, State<double>&, std::size_t);

}  // namespace dvdx::tool
