// A plan's knowledge of the particles that it does not step, where a state is stepped in parts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/export.h"
#include "dvdx/scene.hpp"

namespace dvdx {

// Three columns of a number for each particle, of which those of others in a part's halo are to be told by their owners.
struct HaloColumns {
  std::array<void*, 3> columns{};          // x, y, z
  std::size_t scalar_bytes = 0;            // float's or double's
  const std::uint32_t* element = nullptr;  // of each particle, where it stands in them
};

// The exchange of a part's step between its springs' pulses, in which a halo's particles lack springs. A plan with one keeps
// its particles in the order in which they are numbered.
struct Exchange {
  void* context = nullptr;
  // Begins to tell what others hold of this part, while the step works out the rest of the same columns; and puts in place what
  // others tell. One after the other, once a pulse, and once more for each of its passes over springs that damp; by
  // `sequential` once a sub-step, after the sweeps of a sheet or of a list that is swept as one, and of others after each
  // colour of a sweep (SweptPart); by `accumulate` twice a sub-step, what the pairs add to x and to v. They allocate nothing.
  // Null, both: no part.
  void (*start)(void* context, const HaloColumns& columns) noexcept = nullptr;
  void (*finish)(void* context, const HaloColumns& columns) noexcept = nullptr;
  // For each particle, 0 where no other part holds it. Null: any may be held, and all is worked out before it is told.
  const std::uint8_t* is_told = nullptr;
  // For each particle, 0 where it is another part's, whose reports of contacts tell of it. Null: all are this part's.
  const std::uint8_t* is_own = nullptr;
  // A large sheet's part (dvdx/partition.hpp) goes through so many pulses while rows are in cache. Positions, and then
  // velocities, are told after them. 1: velocities after each.
  std::uint32_t pulses_per_telling = 1;
};

// The order in which the sweeps of a part take springs, as in the whole (Part::sweeps): for a part of a list that `sequential`
// sweeps. To be kept as long as the plan.
struct SweptPart {
  // Its own pieces come first, and then the halo: of each piece, the number of the particle behind its last.
  std::vector<std::uint32_t> piece_ends;
  // For each spring, in the order of its ends' numbers, the lesser first: 0 within a piece. Springs that lead out of one are
  // taken by their colours, from 1 to `colours`, and all parts tell their halo after each.
  std::vector<std::uint32_t> colour_of;
  std::uint32_t colours = 0;
  // Or, where the whole's sweeps walk the list as a sheet: the whole's columns, and how many rows or columns its springs lead
  // across at the most, 1 or 2. The part's particles are then whole rows one after the other, and what stands above is empty. 0
  // columns: pieces.
  std::uint32_t columns = 0, reach = 1;
};

// Where particles come and go, parts share the births of each step: what is drawn for a birth is a function of its number, so
// each part makes its own by itself. All parts step by the same calls, each with the particles that it made or was given.
struct SharedBirths {
  std::uint32_t part = 0, parts = 1;
  void* context = nullptr;
  // Particles of all parts, of which this one has `here`: which births find room depends on it. Called by all parts together,
  // once a call of LifecyclePlan::step with births, and up to twice a step where they might find no room. Allocates nothing.
  std::uint64_t (*count_all)(void* context, std::uint64_t here) noexcept = nullptr;
};

// Where particles meet (Scene::meet), a part works out the meetings of all of them in each sub-step, from what the others
// tell of theirs, and takes what they do to its own. The part's scene has the whole's `meet` as it is, with the radii and
// groups of all particles (scene_of). All that this points at is to be kept as long as the plan.
struct SharedMeetings {
  const Scene* whole = nullptr;   // a scene that compiles; null: no part
  std::span<const Vec3> start{};  // m: of its particles, from its origin, as the state of all at the start has them
  // The whole's numbers of the part's particles.
  std::span<const std::uint32_t> numbers{};
  // The whole's numbers of all particles, in the order in which they are told: each part's own ones stand together, in its own
  // order; this part's from `first` on.
  std::span<const std::uint32_t> told{};
  std::size_t first = 0;
  void* context = nullptr;
  // A record of so many bytes for each that is told, of which this part's own stand in their places: fills in the others'.
  // Called by all parts that have particles, once a sub-step. Allocates nothing.
  void (*tell)(void* context, std::byte* records, std::size_t each) noexcept = nullptr;
};

// Some formulas are chosen by the fastest particle of all: with these numbers of the whole batch in Options::elsewhere, a
// part's bits are those that it has in the whole.
struct PartContext {
  double W = 0;                       // 1/s^2: the highest stiffness over mass, of any particle and axis
  double g = 0;                       // 1/s: the highest damping over mass
  bool anchors_differ = false;        // springs whose methods keep them apart have anchors of their own
  bool springs_damp = false;          // any spring between particles does
  std::optional<double> rho{};        // NetworkLimit::rho of the whole's plan; none: as this plan's own springs ask for
  bool closes_substeps = false;       // skins hold particles, which each sub-step ends with
  Exchange exchange{};                // of the halo, where springs lead out of the part
  const SweptPart* sweeps = nullptr;  // of networks by `sequential` that are no sheets
  SharedBirths births{};              // of LifecyclePlan
  SharedMeetings meetings{};          // of particles that meet
};

using Elsewhere [[deprecated("dvdx::PartContext")]] = PartContext;

// The same numbers of the scene's first `count` particles.
[[nodiscard]] DVDX_EXPORT PartContext elsewhere_of(const Scene& scene, std::size_t count);

}  // namespace dvdx
