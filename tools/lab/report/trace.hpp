// The path of a run on the library, at its sample times.
#pragma once

#include <cstddef>
#include <vector>

#include "closed_form/closed_form.hpp"
#include "report/grid.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

using Picks = std::vector<std::size_t>;  // particles whose paths are kept, rising

// At most `most` of `count`. The golden ratio spreads them over a grid, where a whole stride could follow a column.
[[nodiscard]] Picks picks_of(std::size_t count, std::size_t most);

struct Trace {
  std::vector<double> x, v;     // of the picked particles: [time][particle][axis]
  std::vector<double> energy;   // J, of all particles
  std::vector<double> kinetic;  // J
  double seconds = 0;           // of the steps
};

// The scene from its start by a plan whose step is the grid's coarsest divided by `parts`.
template <class T>
[[nodiscard]] Trace traced(const SceneFile& file, const Plan<T>& plan, std::uint64_t parts, const Grid& grid,
                           const Picks& picks, const Setup& setup);

[[nodiscard]] Path path_of(const Trace& trace, std::size_t particles, std::size_t times);

extern template Trace traced(const SceneFile&, const Plan<float>&, std::uint64_t, const Grid&, const Picks&, const Setup&);
extern template Trace traced(const SceneFile&, const Plan<double>&, std::uint64_t, const Grid&, const Picks&, const Setup&);

}  // namespace dvdx::tool::report
