// Particles that meet each other: grains and balls, cloth on itself and on other cloth.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "dvdx/values.hpp"

namespace dvdx {

// Which particles meet.
struct MeetGroups {
  std::vector<std::uint16_t> of;                   // each particle's group, below 1024
  std::vector<std::array<std::uint16_t, 2>> meet;  // groups that meet each other (or themselves); others pass through
  bool operator==(const MeetGroups&) const = default;
};

// Treatment of pairs that are nearer at the start than their wanted distance, by more than a millionth of it.
enum class NearAtStart : std::uint8_t {
  by_kind,  // balls meet, cloth passes
  meet,     // they are pushed apart
  pass,     // they never meet
};

// Particles that stay apart. Exactly one of radius, thickness and part_of_cells is given.
//   balls   two particles are at least the sum of their radii apart. Each keeps its radius from every surface of the scene, or
//           the surface's thickness if that is more.
//   cloth   two particles of networks are at least `thickness` apart. Surfaces keep them off by their own thickness alone.
//           By part_of_cells each particle has a thickness of its own: that part of the widest cell that it is a corner of, or
//           of its shortest spring if it has no cell. A pair takes the larger one, so meshes of unequal cells let nothing pass.
// Approaches faster than 4 g h (g: the constant acceleration, h: the sub-step) bounce; slower ones rest. Fixed and kinematic
// particles are met and do not yield. Particles meet at the end of each sub-step, after springs and before constraints.
struct Meet {
  std::optional<Scalars> radius{};  // m, > 0, for balls; one for all, or one each
  // m, > 0, for cloth and ropes: less than the side of the widest cell, or without cells than the shortest spring at rest
  std::optional<double> thickness{};
  std::optional<double> part_of_cells{};  // > 0 and < 1, of the cells at the start; 0.95: closed up to a stretch of 1.34
  double restitution = 0;                 // 0..1
  double friction = 0;                    // >= 0: Coulomb's coefficient; balls with friction come to rest
  int rounds = 12;                        // 1..64 a sub-step: each carries a push one particle further
  int most_neighbours = 24;               // 1..255: a particle with more within reach stops the step (too_many_neighbours)
  NearAtStart near_at_start = NearAtStart::by_kind;
  std::optional<MeetGroups> groups{};  // none: all meet
  bool operator==(const Meet&) const = default;
};

// How the particles of a state met in the last sub-step: Plan::meetings().
struct Meetings {
  double listed = 0;           // pairs within reach, per particle on average
  double touching = 0;         // pairs that touch at the end (to a thousandth of their distance), per particle on average
  std::size_t most = 0;        // the largest number of pairs within reach of one particle
  std::uint64_t rebuilt = 0;   // times that lists were built since the workspace was made
  std::uint64_t substeps = 0;  // sub-steps since then
  double overlap_mean = 0;     // mean overlap of pairs that touch, as part of each pair's wanted distance
  double overlap_most = 0;
  double stretch_limit = 0;  // cloth: cells stretched by less let nothing pass, sqrt(2) t / s; 0 for balls
  // Pairs of cloth that never meet (NearAtStart::pass) although they are no neighbours: no path along springs joins them, or
  // only one longer than two thicknesses. Such layers were too near when the plan was made. A state that is already folded
  // needs NearAtStart::meet, or the plan that folded it.
  std::size_t passing_layers = 0;
};

}  // namespace dvdx
