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

// The fate of pairs that are nearer at the start than they want to be, by more than a millionth of that.
enum class NearAtStart : std::uint8_t {
  by_kind,  // balls meet, cloth passes
  meet,     // they are pushed apart
  pass,     // they never meet
};

// Particles that stay apart. One of radius, thickness and part_of_cells is given.
//   balls   two particles are at least the sum of their radii apart, and each is its radius (more than the surface's thickness)
//           off every surface of the scene.
//   cloth   two particles of networks are at least `thickness` apart. Surfaces keep them off by their own thickness alone.
//           By part_of_cells each has a thickness of its own, so much of the widest cell that it is a corner of (of its
//           shortest spring where it is of none), and a pair the larger one: meshes whose cells differ let nothing pass either.
// Approaches that are faster than 4 g h (g: the constant acceleration, h: the sub-step) bounce; slower ones rest. Fixed and
// kinematic particles are met, and do not yield. At the end of each sub-step, after springs and before constraints.
struct Meet {
  std::optional<Scalars> radius{};  // m, > 0: of balls; one for all, or one each
  // m, > 0: of cloth and ropes. Less than the widest cell's side, without cells than the shortest spring at rest
  std::optional<double> thickness{};
  std::optional<double> part_of_cells{};  // > 0 and < 1, of cells as they are at the start: 0.95 lets nothing pass up to 1.34
  double restitution = 0;                 // 0..1
  double friction = 0;                    // >= 0: Coulomb's coefficient; balls that have one come to rest
  int rounds = 12;                        // 1..64 a sub-step: each carries a push by one particle more
  int most_neighbours = 24;               // 1..255: a particle that has more within reach stops the step (too_many_neighbours)
  NearAtStart near_at_start = NearAtStart::by_kind;
  std::optional<MeetGroups> groups{};  // none: all meet
  bool operator==(const Meet&) const = default;
};

// How the particles of a state met in the last sub-step: Plan::meetings().
struct Meetings {
  double listed = 0;           // pairs within reach, of each particle on average
  double touching = 0;         // pairs that touch at the end (to a thousandth of their distance), of each particle on average
  std::size_t most = 0;        // pairs within reach of the particle that has most
  std::uint64_t rebuilt = 0;   // how often lists were built since the workspace was made
  std::uint64_t substeps = 0;  // since then
  double overlap_mean = 0;     // of pairs that touch, as part of the distance that each pair wants
  double overlap_most = 0;
  double stretch_limit = 0;  // cloth: cells stretched by less let nothing pass, sqrt(2) t / s; 0 for balls
  // Pairs of cloth that never meet (NearAtStart::pass) and are no neighbours, the way along springs from one to the other being
  // more than two thicknesses: layers that were too near when the plan was made. A state that is folded already needs
  // NearAtStart::meet, or the plan that folded it.
  std::size_t passing_layers = 0;
};

}  // namespace dvdx
