// The outcome of a run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/ranks.hpp"
#include "output/writer.hpp"
#include "watch/spring_rounding.hpp"
#include "watch/start_inside.hpp"

namespace dvdx::tool {

// The counts of a scene whose particles come and go.
struct TurnoverCounts {
  std::size_t live = 0;
  std::uint64_t born = 0;
  std::uint64_t removed = 0;
  std::uint64_t dropped = 0;         // births that found no room
  std::uint64_t particle_steps = 0;  // of those that lived after each call
};

// The first look at which there was more kinetic energy than the start and the forces can have given, otherwise the last look.
struct HeatCheck {
  bool is_heating = false;
  double kinetic = 0, given = 0;  // J, then
  std::uint64_t step = 0;
};

// The worst of springs and constraints in all looks.
struct Joins {
  struct Stretch {
    double most = 0;  // length over rest length, of springs that pull; 0: there are none
    Pair ends{};
    double time = 0;  // s
  };
  struct Rods {
    double most = 0;  // deviation from a distance's bound, as part of the bound
    Pair ends{};
    std::size_t constraint = 0;
    double time = 0;  // s
  };
  Stretch stretch{};
  Rods rods{};
  bool has_rods = false;                                          // the scene has distances
  double most_energy = -std::numeric_limits<double>::infinity();  // J
  double driven = 0;                                              // J: the most given by forces that have no potential
};

// The first look at which kinetic and spring energy together exceeded what the start and the forces can have given.
struct OverStretch {
  double joules = 0, given = 0;  // J
  std::uint64_t step = 0;
};

// A particle between two surfaces that overlap there, at its deepest in all looks.
struct Pinch {
  std::size_t particle = 0;
  double time = 0;     // s
  double depth = 0;    // m: inside both by at least this
  double overlap = 0;  // m
  double limit = 0;    // m: of the depth
};

// A body that pokes through cloth between two particles of the cloth, at its deepest in all looks.
struct PokeThrough {
  Pair between{};           // particles
  std::size_t contact = 0;  // index in the scene
  double time = 0;          // s
  double depth = 0;         // m: how far inside the body the middle between the two is
  double limit = 0;         // m: of the depth
  double thickness = 0;     // m: of the contact, with which the body stays under the cloth
};

// How often edges of cloth go through its triangles.
struct Crossed {
  std::size_t at_end = 0;
  std::size_t most = 0;  // of all looks
  // m, or with part_of_cells relative to the start: of all looks, the longest side of cells and triangles, without diagonals
  double longest_side = 0;
  double time = 0;  // s: when a side was so long
};

// Particles that meet.
struct Met {
  double pairs = 0;           // that touch at the end, of each particle on average
  std::size_t most = 0;       // the most that one particle has had within reach
  std::uint64_t rebuilt = 0;  // how often lists were rebuilt
  double overlap_mean = 0;    // at the end, of touching pairs, as part of the distance that each wants
  double overlap_most = 0;
  double stretch_limit = 0;          // of springs: cells stretched by less let nothing pass; 0: balls, which have no limit
  std::size_t passing_layers = 0;    // pairs that started too near, and never meet
  std::optional<Crossed> crossed{};  // of cloth that does not tear
};

struct Halo {
  Traffic told{};             // over all ranks
  double waited_seconds = 0;  // s, of the rank that waited longest for others; part of its wall time
};

struct Outcome {
  double wall_seconds = 0;  // of the steps, without making the plan and writing
  std::uint64_t hash = 0;
  double energy_start = 0;
  double energy_end = 0;
  bool diverged = false;
  std::size_t bad_particles = 0;
  std::optional<HeatCheck> warmth{};  // none if no bound is known
  std::optional<OverStretch> held{};
  std::optional<StartInside> inside{};       // of one process
  std::optional<SpringRounding> rounding{};  // of one process
  std::optional<Pinch> pinch{};              // of one process
  std::optional<PokeThrough> poke{};         // of one process
  std::optional<Warning> dear{};             // printed when it was found
  std::optional<Joins> joins{};              // of one process, if springs or constraints join particles
  std::optional<Met> met{};                  // if particles meet
  std::optional<NetworkLimit> network{};
  std::optional<TurnoverCounts> turned{};
  std::optional<Halo> halo{};                 // if springs are split over ranks
  std::vector<ContactSum> contacts{};         // in the scene's order, if they were asked for
  std::optional<std::size_t> torn{};          // springs, if some can tear
  std::optional<std::uint64_t> resumed_at{};  // step at which the run resumed from a checkpoint
  std::vector<WrittenFile> written{};
};

}  // namespace dvdx::tool
