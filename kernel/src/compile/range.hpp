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
// Of the forces alone; of one contact; and whether a grid takes such an inverse mass, 1/kg.
template <class T>
std::optional<Error> check_range_of_forces(const Scene& scene, const Options& options, std::optional<std::size_t> count,
                                           std::span<const Vec3> start);
template <class T>
std::optional<Error> check_range(const Contact& contact, std::size_t index, const Origin& origin);
template <class T>
std::optional<Error> check_range(const Wind& wind);
template <class T>
bool is_in_range(const Grid& grid, double h, double w);

}  // namespace dvdx
