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

// Particles that stay apart. One of radius and thickness is given.
//   balls   two particles are at least the sum of their radii apart, and each is its radius (more than the surface's thickness)
//           off every surface of the scene.
//   cloth   two particles of networks are at least `thickness` apart. Surfaces keep them off by their own thickness alone.
// Approaches that are faster than 4 g h (g: the constant acceleration, h: the sub-step) bounce; slower ones rest. Fixed and
// kinematic particles are met, and do not yield. At the end of each sub-step, after springs and before constraints.
struct Meet {
  std::optional<Scalars> radius{};    // m, > 0: of balls; one for all, or one each
  std::optional<double> thickness{};  // m, > 0 and less than the shortest spring at rest: of cloth and ropes
  double restitution = 0;             // 0..1
  double friction = 0;                // >= 0: Coulomb's coefficient; balls that have one come to rest
  int rounds = 12;                    // 1..64 a sub-step: each carries a push by one particle more
  int most_neighbours = 24;           // 1..255: a particle that has more within reach stops the step (too_many_neighbours)
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
  double stretch_limit = 0;  // cloth: springs stretched by less let nothing pass, sqrt(2) t / s; 0 for balls
};

}  // namespace dvdx
