// Balls that meet and have an exact motion.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "closed_form/closed_form.hpp"

namespace dvdx::tool {

// Returns true if particles meet in a way that has a closed form, and only constant forces act besides:
// - two balls that start apart. They meet at most once. The impact reverses the normal speed and multiplies it by the
//   restitution; friction reduces the tangential speed by Coulomb's law;
// - balls of one mass in a row that move along it and lose nothing. Each impact exchanges two velocities. Apart from their
//   sizes, the balls therefore pass through one another, and stay in order.
[[nodiscard]] bool is_of_balls(const SceneFile& file);

[[nodiscard]] std::vector<AxisState> balls_state(const SceneFile& file, std::size_t particle, long double t);

// Throws Fault (bad_scene) for other scenes in which particles meet. command: "report"
void refuse_meet(const SceneFile& file, std::string_view command);

}  // namespace dvdx::tool
