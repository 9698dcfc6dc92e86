// What the figures were measured on.
#pragma once

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

[[nodiscard]] Machine this_machine(const Setup& setup);

}  // namespace dvdx::tool::report
