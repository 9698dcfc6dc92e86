#include "report/trace.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dvdx/layouts/soa.hpp"
#include "run/energy.hpp"

namespace dvdx::tool::report {
namespace {

template <class T>
double kinetic_energy(const Scene& scene, const State<T>& state) {
  double sum = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const auto& column : state.v) {
      sum += 0.5 * scene.mass[i] * static_cast<double>(column[i]) * static_cast<double>(column[i]);
    }
  }
  return sum;
}

template <class T>
void record(const SceneFile& file, const Picks& picks, const State<T>& state, Trace& trace) {
  for (const auto i : picks) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      trace.x.push_back(static_cast<double>(state.x[axis][i]));
      trace.v.push_back(static_cast<double>(state.v[axis][i]));
    }
  }
  trace.energy.push_back(energy(file, state));
  trace.kinetic.push_back(kinetic_energy(file.scene, state));
}

}  // namespace

Picks picks_of(std::size_t count, std::size_t most) {
  constexpr double golden = 0.6180339887498949;
  Picks picks;
  if (count <= most) {
    for (std::size_t i = 0; i < count; ++i) picks.push_back(i);
    return picks;
  }
  for (std::size_t k = 1; k <= most; ++k) {
    const double part = static_cast<double>(k) * golden;
    picks.push_back(static_cast<std::size_t>((part - std::floor(part)) * static_cast<double>(count)));
  }
  std::sort(picks.begin(), picks.end());
  picks.erase(std::unique(picks.begin(), picks.end()), picks.end());
  return picks;
}

template <class T>
Trace traced(const SceneFile& file, const Plan<T>& plan, std::uint64_t parts, const Grid& grid, const Picks& picks,
             const Setup& setup) {
  Soa<T> memory(file.particles.count);
  auto state = memory.view();
  place_at_start(file, state);
  Trace trace;
  record(file, picks, state, trace);
  for (std::size_t k = 1; k < grid.counts.size(); ++k) {
    const auto before = std::chrono::steady_clock::now();
    advance(plan, state, (grid.counts[k] - grid.counts[k - 1]) * parts, setup.parallel);
    trace.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    record(file, picks, state, trace);
  }
  return trace;
}

Path path_of(const Trace& trace, std::size_t particles, std::size_t times) {
  Path path(particles, times);
  std::copy(trace.x.begin(), trace.x.end(), path.x.begin());
  std::copy(trace.v.begin(), trace.v.end(), path.v.begin());
  return path;
}

template Trace traced(const SceneFile&, const Plan<float>&, std::uint64_t, const Grid&, const Picks&, const Setup&);
template Trace traced(const SceneFile&, const Plan<double>&, std::uint64_t, const Grid&, const Picks&, const Setup&);

}  // namespace dvdx::tool::report
