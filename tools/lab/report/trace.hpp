// The path of a run on the library, at its sample times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "closed_form/closed_form.hpp"
#include "report/grid.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

using Picks = std::vector<std::size_t>;  // ascending indices of the particles whose paths are kept

// At most `most` of `count` indices. The golden ratio spreads them over a grid, where a constant stride could follow a column.
[[nodiscard]] Picks picks_of(std::size_t count, std::size_t most);

// Displaces the start of every particle that is not fixed by up to `most` along each axis. The springs keep their lengths.
struct Nudge {
  double most = 0;  // m
  std::uint64_t seed = 0;
};

template <class T>
void move_start(const SceneFile& file, const Nudge& nudge, State<T>& state);

struct Trace {
  std::vector<double> x, v;     // the picked particles: [time][particle][axis]
  std::vector<double> energy;   // J, all particles
  std::vector<double> kinetic;  // J
  std::vector<double> stretch;  // the largest length of a network's spring over its rest length, less one
  double seconds = 0;           // for the steps alone
};

// Runs the scene from its start by a plan whose step is the grid's coarsest divided by `parts`. If setup.end comes first, the
// trace ends before it, but not before two sample times.
template <class T>
[[nodiscard]] Trace traced(const SceneFile& file, const Plan<T>& plan, std::uint64_t parts, const Grid& grid,
                           const Picks& picks, const Setup& setup, const Nudge& nudge = {});

[[nodiscard]] Path path_of(const Trace& trace, std::size_t particles, std::size_t times);

extern template void move_start(const SceneFile&, const Nudge&, State<float>&);
extern template void move_start(const SceneFile&, const Nudge&, State<double>&);
extern template Trace traced(const SceneFile&, const Plan<float>&, std::uint64_t, const Grid&, const Picks&, const Setup&,
                             const Nudge&);
extern template Trace traced(const SceneFile&, const Plan<double>&, std::uint64_t, const Grid&, const Picks&, const Setup&,
                             const Nudge&);

}  // namespace dvdx::tool::report
