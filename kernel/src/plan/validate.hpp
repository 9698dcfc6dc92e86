// Checks of a scene and its options.
#pragma once

#include <cstddef>
#include <optional>

#include "dvdx/plan.hpp"

namespace dvdx {

inline constexpr int most_substeps = 1000000;  // a step

// The first error, or nothing. count: the state's particles, if a state is given. elsewhere: the context of a part.
std::optional<Error> check(const Scene& scene, std::optional<std::size_t> count, const PartContext& elsewhere);
std::optional<Error> check(const Options& options);
// Refuses a scene, checked before, whose sweeps a part cannot make.
std::optional<Error> check_sweeps(const Scene& scene, const PartContext& elsewhere, std::optional<std::size_t> count);
// Checks one alone: forces[index], contacts[index].
std::optional<Error> check(const Force& force, std::size_t index, std::optional<std::size_t> count);
std::optional<Error> check(const Contact& contact, std::size_t index);
std::optional<Error> check(const Wind& wind);

}  // namespace dvdx
