// From a system of forces to the columns of coefficients that a plan keeps.
#pragma once

#include <cstddef>
#include <span>

#include "flow/terms.hpp"
#include "free/free_kernels.hpp"
#include "free/system.hpp"

namespace dvdx {

// Fills the columns of `rates` for `count` particles. column_sources[k] is the source whose gains columns k hold.
template <class T>
void make_rates(const System& system, const FreeKernels<T>& passes, Flow flow, std::size_t count,
                std::span<const std::size_t> column_sources, const Rates<T>& rates);

}  // namespace dvdx
