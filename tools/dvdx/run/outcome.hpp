// What a run came to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/ranks.hpp"

namespace dvdx::tool {

// Of a scene whose particles come and go.
struct Turned {
  std::size_t live = 0;
  std::uint64_t born = 0;
  std::uint64_t removed = 0;
  std::uint64_t dropped = 0;         // births that found no room
  std::uint64_t particle_steps = 0;  // of those that lived after each call
};

// The first look at which more moved than the start and the forces can have given, or else the last one.
struct Warmth {
  bool is_heating = false;
  double kinetic = 0, given = 0;  // J, then
  std::uint64_t step = 0;
};

struct Halo {
  Traffic told{};             // over all ranks
  double waited_seconds = 0;  // of the wall's, of the rank that waited longest for what others tell
};

struct Outcome {
  double wall_seconds = 0;  // of the steps: neither of making the plan nor of writing
  std::uint64_t hash = 0;
  double energy_start = 0;
  double energy_end = 0;
  bool diverged = false;
  std::size_t bad_particles = 0;
  std::optional<Warmth> warmth{};  // none where no bound is known
  std::optional<NetworkLimit> network{};
  std::optional<Turned> turned{};
  std::optional<Halo> halo{};                 // where springs are split over ranks
  std::vector<ContactSum> contacts{};         // in the scene's order, where they were asked for
  std::optional<std::size_t> torn{};          // springs, where some can tear
  std::optional<std::uint64_t> resumed_at{};  // step, of a run that went on from a checkpoint
};

}  // namespace dvdx::tool
