// How networks are stepped.
#pragma once

#include "dvdx/scene.hpp"
#include "scene_io/fields.hpp"

namespace dvdx::tool {

// Reads the keys `substeps`, a whole number or "auto", and `most_substeps`, if they are there.
void read_substeps(const Fields& fields, Coupling& coupling);

// method: used if the network names none.
[[nodiscard]] Coupling read_coupling(const Fields& fields, Method method);

// Refuses a coupling that differs from the first network's: all networks of a scene are stepped together.
void check_alike(const Node& node, const Coupling& first, const Coupling& own);

}  // namespace dvdx::tool
