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

// Springs and constraints, at their worst in the looks that were taken.
struct Joins {
  struct Stretch {
    double most = 0;  // length over rest length, of springs that pull; 0: there are none
    Pair ends{};
    double time = 0;  // s
  };
  struct Rods {
    double most = 0;  // off what a distance is bound to, as part of that
    Pair ends{};
    std::size_t constraint = 0;
    double time = 0;  // s
  };
  Stretch stretch{};
  Rods rods{};
  bool has_rods = false;                                          // the scene has distances
  double most_energy = -std::numeric_limits<double>::infinity();  // J
  double driven = 0;                                              // J: at most, given by forces that have no potential
};

// The first look at which particles moved with, and springs held, more than the start and the forces can have given.
struct HeldTooMuch {
  double joules = 0, given = 0;  // J
  std::uint64_t step = 0;
};

// A particle between two surfaces that overlap there, at the deepest of the looks.
struct Pinch {
  std::size_t particle = 0;
  double time = 0;     // s
  double depth = 0;    // m: inside both by at least this
  double overlap = 0;  // m
  double limit = 0;    // m: of the depth
};

// A body that is out of cloth between two of its particles, at the deepest of the looks.
struct PokeThrough {
  Pair between{};           // particles
  std::size_t contact = 0;  // of the scene's
  double time = 0;          // s
  double depth = 0;         // m: how far inside the body the middle between the two is
  double limit = 0;         // m: of the depth
  double thickness = 0;     // m: of the contact, with which it is outside
};

// How often edges of cloth go through its triangles.
struct Crossed {
  std::size_t at_end = 0;
  std::size_t most = 0;  // of all looks
  // m, or by part_of_cells as part of itself at the start, of all looks: of cells and triangles, not of diagonals
  double longest_side = 0;
  double time = 0;  // s: when it was so long
};

// Particles that meet.
struct Met {
  double pairs = 0;           // that touch at the end, of each particle on average
  std::size_t most = 0;       // that one particle has had within reach
  std::uint64_t rebuilt = 0;  // how often their lists were
  double overlap_mean = 0;    // at the end, of pairs that touch, as part of the distance that each wants
  double overlap_most = 0;
  double stretch_limit = 0;          // of springs: what is stretched by less lets nothing pass; 0: of balls, which have none
  std::size_t passing_layers = 0;    // pairs that started too near, and never meet
  std::optional<Crossed> crossed{};  // of cloth that does not tear
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
  std::optional<HeldTooMuch> held{};
  std::optional<StartInside> inside{};       // of one process
  std::optional<SpringRounding> rounding{};  // of one process
  std::optional<Pinch> pinch{};              // of one process
  std::optional<PokeThrough> poke{};         // of one process
  std::optional<Warning> dear{};             // that was said when it was found
  std::optional<Joins> joins{};              // of one process, of a scene that springs or constraints join
  std::optional<Met> met{};                  // where particles meet
  std::optional<NetworkLimit> network{};
  std::optional<Turned> turned{};
  std::optional<Halo> halo{};                 // where springs are split over ranks
  std::vector<ContactSum> contacts{};         // in the scene's order, where they were asked for
  std::optional<std::size_t> torn{};          // springs, where some can tear
  std::optional<std::uint64_t> resumed_at{};  // step, of a run that went on from a checkpoint
  std::vector<WrittenFile> written{};
};

}  // namespace dvdx::tool
