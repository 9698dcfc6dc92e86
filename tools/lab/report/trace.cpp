#include "report/trace.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dvdx/counter_random.hpp"
#include "dvdx/layouts/soa.hpp"
#include "watch/energy.hpp"

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

struct Length {
  Pair ends{};
  double rest = 0;  // m, > 0
};

// The lengths of all springs that have a rest length.
std::vector<Length> lengths_of(const SceneFile& file) {
  std::vector<Length> lengths;
  const auto take = [&](const Springs& springs) {
    for (std::size_t n = 0; n < springs.pairs.size(); ++n) {
      const auto [i, j] = springs.pairs[n];
      double rest = 0;
      if (springs.rest_length) {
        rest = (*springs.rest_length)[n];
      } else {
        const auto a = value_of(file.particles.position, i);
        const auto b = value_of(file.particles.position, j);
        rest = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      }
      if (rest > 0) lengths.push_back({.ends = springs.pairs[n], .rest = rest});
    }
  };
  for (const auto& network : file.scene.networks) {
    if (const auto* grid = std::get_if<dvdx::Grid>(&network)) {
      take(springs_of(*grid));
    } else {
      take(std::get<Springs>(network));
    }
  }
  return lengths;
}

template <class T>
double largest_stretch(const std::vector<Length>& lengths, const State<T>& state) {
  double largest = -1;
  for (const auto& [ends, rest] : lengths) {
    double squares = 0;
    for (const auto& column : state.x) {
      const double d = static_cast<double>(column[ends[1]]) - static_cast<double>(column[ends[0]]);
      squares += d * d;
    }
    largest = std::max(largest, std::sqrt(squares) / rest - 1);
  }
  return largest;
}

template <class T>
void record(const SceneFile& file, const Picks& picks, const std::vector<Length>& lengths, const State<T>& state,
            Trace& trace) {
  for (const auto i : picks) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      trace.x.push_back(static_cast<double>(state.x[axis][i]));
      trace.v.push_back(static_cast<double>(state.v[axis][i]));
    }
  }
  trace.energy.push_back(energy(file, state));
  trace.kinetic.push_back(kinetic_energy(file.scene, state));
  trace.stretch.push_back(largest_stretch(lengths, state));
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
void move_start(const SceneFile& file, const Nudge& nudge, State<T>& state) {
  if (nudge.most == 0) return;
  std::vector<bool> is_fixed(state.count, false);
  for (const auto id : file.scene.fixed) is_fixed[id] = true;
  for (const Kinematic& followers : file.scene.kinematic) {
    for (const auto id : followers.particles) is_fixed[id] = true;
  }
  for (std::size_t i = 0; i < state.count; ++i) {
    if (is_fixed[i]) continue;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const double by = nudge.most * (2 * unit_value(nudge.seed, i, axis) - 1);
      state.x[axis][i] = static_cast<T>(static_cast<double>(state.x[axis][i]) + by);
    }
  }
}

template <class T>
Trace traced(const SceneFile& file, const Plan<T>& plan, std::uint64_t parts, const Grid& grid, const Picks& picks,
             const Setup& setup, const Nudge& nudge) {
  Soa<T> memory(file.particles.count);
  auto state = memory.view();
  place_at_start(file, state);
  move_start(file, nudge, state);
  const auto lengths = lengths_of(file);
  Trace trace;
  record(file, picks, lengths, state, trace);
  for (std::size_t k = 1; k < grid.counts.size() && (k == 1 || WallClock::now() < setup.end); ++k) {
    const auto before = WallClock::now();
    advance(plan, state, (grid.counts[k] - grid.counts[k - 1]) * parts, setup.parallel);
    trace.seconds += std::chrono::duration<double>(WallClock::now() - before).count();
    record(file, picks, lengths, state, trace);
  }
  return trace;
}

Path path_of(const Trace& trace, std::size_t particles, std::size_t times) {
  Path path(particles, times);
  std::copy(trace.x.begin(), trace.x.end(), path.x.begin());
  std::copy(trace.v.begin(), trace.v.end(), path.v.begin());
  return path;
}

template void move_start(const SceneFile&, const Nudge&, State<float>&);
template void move_start(const SceneFile&, const Nudge&, State<double>&);
template Trace traced(const SceneFile&, const Plan<float>&, std::uint64_t, const Grid&, const Picks&, const Setup&,
                      const Nudge&);
template Trace traced(const SceneFile&, const Plan<double>&, std::uint64_t, const Grid&, const Picks&, const Setup&,
                      const Nudge&);

}  // namespace dvdx::tool::report
