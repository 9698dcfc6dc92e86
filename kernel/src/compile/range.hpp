// Values of a scene that are finite but that the plan's scalar type cannot hold, or not what is made of them.
#pragma once

#include <optional>
#include <span>

#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

// The scene and the options have been checked. start: the particles' positions where anchors stand there or something joins
// particles; count: none where all particles are alike.
template <class T>
std::optional<Error> check_range(const Scene& scene, const Options& options, std::optional<std::size_t> count,
                                 std::span<const Vec3> start);

}  // namespace dvdx
