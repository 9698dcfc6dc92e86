// Checks for finite values of a scene that the plan's scalar type cannot hold, or whose coefficients it cannot hold. The
// largest stable step: springs/frequencies.hpp.
#pragma once

#include <optional>
#include <span>

#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// The scene and the options must have been checked. start: the particles' positions if anchors stand there or something joins
// particles; count: none if all particles are alike.
template <class T>
std::optional<Error> check_range(const Scene& scene, const Options& options, std::optional<std::size_t> count,
                                 std::span<const Vec3> start);
// The same for the forces alone; for one contact; for the wind; and whether a grid is in range with an inverse mass w, 1/kg.
template <class T>
std::optional<Error> check_range_of_forces(const Scene& scene, const Options& options, std::optional<std::size_t> count,
                                           std::span<const Vec3> start);
template <class T>
std::optional<Error> check_range(const Contact& contact, std::size_t index, const Origin& origin);
template <class T>
std::optional<Error> check_range(const Wind& wind);
template <class T>
bool is_in_range(const Grid& grid, double h, double w);
// Whether a spring between two particles is in range. w: the sum of their inverse masses, 1/kg.
template <class T>
bool is_in_range(const JoinedPair& spring, double h, double w);
// Whether all springs would be in range if each were as stiff and as long as any, between the lightest particles.
template <class T>
bool are_well_in_range(const Springs& springs, const Scene& scene, double h, std::span<const Vec3> start);

}  // namespace dvdx
