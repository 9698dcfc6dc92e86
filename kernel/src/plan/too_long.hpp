// The springs of a network that a state has stretched too far.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dvdx/plan.hpp"

namespace dvdx {

// The ends of each whole spring of networks[network] that is longer than `stretch` times its rest length; start: the positions
// where the plan was compiled.
template <class T>
Expected<std::vector<Pair>> too_long(const Scene& scene, std::span<const Vec3> start, std::size_t network, double stretch,
                                     const State<T>& state);

}  // namespace dvdx
