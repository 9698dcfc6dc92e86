// Balls that meet and have an exact motion.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "closed_form/closed_form.hpp"

namespace dvdx::tool {

// Whether particles meet in a way that has a closed form, and nothing else acts on them but constant forces:
// - two balls that start apart: they meet once at most. The normal speed is turned round and multiplied by the restitution, and
//   friction takes from the tangential one what Coulomb's law allows;
// - balls of one mass in a row, which move along it and lose nothing: each impact exchanges two velocities, so that apart from
//   their sizes they pass through one another, and stay in order.
[[nodiscard]] bool is_of_balls(const SceneFile& file);

[[nodiscard]] std::vector<AxisState> balls_state(const SceneFile& file, std::size_t particle, long double t);

// Throws Fault (bad_scene) for other scenes in which particles meet. command: "report"
void refuse_meet(const SceneFile& file, std::string_view command);

}  // namespace dvdx::tool
