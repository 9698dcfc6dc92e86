// Predicts the cost of a scene on many ranks: counts, and a time from a latency and a bandwidth.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "ranks/cut.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// The defaults are those of one 100 Gbit/s port and a core a rank.
struct Machine {
  double latency = 1.5e-6;                   // s: of a message
  double bandwidth = 12.5e9;                 // bytes/s: of a rank's link
  std::optional<double> particle_seconds{};  // s: of a particle's sub-step; none: measured here
};

// The scene that is counted, or one like it of another size.
struct Extent {
  std::uint64_t particles = 0;
  std::optional<Grid> sheet{};  // that holds all particles
  const Scene* list = nullptr;  // of springs that are no sheet
  const Scene* scene = nullptr;
  [[nodiscard]] bool is_joined() const noexcept { return sheet || list != nullptr; }
};
// size: "1e10" for a scene in which nothing joins particles; "32768x32768" for a sheet; empty: the scene's. Throws Fault
// (usage).
[[nodiscard]] Extent extent_of(const SceneFile& file, const std::string& size);

// The messages between two sub-steps.
struct HaloMessages {
  std::uint64_t times = 0;    // a sub-step
  std::uint64_t numbers = 0;  // of each particle of the halo, each time
  std::uint64_t bytes = 0;    // of a number
  // If particles meet, each rank sends every other this many numbers of each of its own particles, and computes all meetings.
  std::uint64_t numbers_to_all = 0;
};
[[nodiscard]] HaloMessages halo_of(const SceneFile& file, std::size_t scalar_bytes);

// Returns the ways to share the extent among so many ranks; none if there are too many of them.
[[nodiscard]] std::vector<Cut> cuts_of(const Extent& extent, std::uint64_t ranks);

struct Times {
  double own = 0;   // s a sub-step: particles of the fullest rank
  double told = 0;  // messages of the rank that receives most
  [[nodiscard]] double all() const noexcept { return own + told; }
};
// Assumes no overlap: messages wait for particles, and particles for messages.
[[nodiscard]] Times times_of(const Cut& cut, const HaloMessages& sent, const Machine& machine);

// Returns a table for one number of ranks. one: the cut on one rank.
[[nodiscard]] std::string table_of(const std::vector<Cut>& cuts, const HaloMessages& sent, const Machine& machine,
                                   const Cut& one);

// The efficiencies of the cheapest sharing at 1, 2, 4, ... ranks up to `most`.
struct ScalePoint {
  std::uint64_t ranks = 1;
  double strong = 1;  // efficiency: the scene on all these ranks
  double weak = 1;    // the scene on each of these ranks
};
[[nodiscard]] std::vector<ScalePoint> curve_of(const Extent& extent, const HaloMessages& sent, const Machine& machine,
                                               std::uint64_t most);
[[nodiscard]] std::string table_of(const std::vector<ScalePoint>& curve);
// Returns an SVG. Throws Fault (input_output) if gnuplot cannot draw it.
[[nodiscard]] std::string picture_of(const std::vector<ScalePoint>& curve, const std::string& title);

}  // namespace dvdx::tool
