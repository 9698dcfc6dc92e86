// Information for a plan that steps one part of a state: about the particles of the other parts, and how to exchange data.
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

// Three columns with a number for each particle. The owners of halo particles send the values of these.
struct HaloColumns {
  std::array<void*, 3> columns{};          // x, y, z
  std::size_t scalar_bytes = 0;            // float's or double's
  const std::uint32_t* element = nullptr;  // each particle's index in the columns
};

// The halo exchange between the pulses of a part's step: a part lacks some springs of its halo's particles. A plan with an
// exchange keeps its particles in the order of their numbers.
struct Exchange {
  void* context = nullptr;
  // start() begins to send the own particles that other parts hold, while the step computes the rest of the same columns.
  // finish() puts the received particles in place. Each finish() follows its start(). A pair of calls is made once a pulse, and
  // once more for each of its passes over damping springs. `sequential` makes it once a sub-step, after the sweeps, for a sheet
  // or a list that is swept as one, and after each colour of a sweep for other networks (SweptPart). `accumulate` makes it
  // twice a sub-step, for the pairs' sums on x and on v. Both allocate nothing. Both null: the plan steps no part.
  void (*start)(void* context, const HaloColumns& columns) noexcept = nullptr;
  void (*finish)(void* context, const HaloColumns& columns) noexcept = nullptr;
  // For each particle, 0 if no other part holds it. Null: any may be held, and all columns are complete before start().
  const std::uint8_t* is_told = nullptr;
  // For each particle, 0 if another part owns it; that part reports its contacts. Null: all are this part's.
  const std::uint8_t* is_own = nullptr;
  // The number of pulses that a large sheet's part (dvdx/partition.hpp) makes between exchanges, while rows are in cache. It
  // then exchanges positions and after them velocities. 1: exchanges velocities after each pulse.
  std::uint32_t pulses_per_telling = 1;
};

// The order in which a part's sweeps take springs, as in the whole (Part::sweeps): for a part of a list that `sequential`
// sweeps. Must live as long as the plan.
struct SweptPart {
  // For each of the part's own pieces, the index after its last particle. The halo's particles follow the pieces.
  std::vector<std::uint32_t> piece_ends;
  // For each spring, in ascending order of its ends, the lesser end first: 0 within a piece. Springs between pieces are taken
  // by colours 1 to `colours`; all parts exchange their halo after each colour.
  std::vector<std::uint32_t> colour_of;
  std::uint32_t colours = 0;
  // For a list that the whole's sweeps walk as a sheet: the whole's columns, and the most rows or columns that a spring leads
  // across, 1 or 2. The part's particles are then whole rows in order, and the fields above are empty. 0 columns: pieces.
  std::uint32_t columns = 0, reach = 1;
};

// Parts share the births of each step. The random numbers of a birth depend on its number alone, so each part makes its own
// births. All parts step by the same calls, each with the particles that it made or was given.
struct SharedBirths {
  std::uint32_t part = 0, parts = 1;
  void* context = nullptr;
  // Returns the number of particles of all parts; this part has `here`. It decides which births find room. All parts call it
  // together, once in a call of LifecyclePlan::step with births, and up to twice a step while births might find no room.
  // Allocates nothing.
  std::uint64_t (*count_all)(void* context, std::uint64_t here) noexcept = nullptr;
};

// For particles that meet (Scene::meet): in each sub-step a part computes the meetings of all particles, from records that the
// parts exchange, and applies the results to its own. The part's scene keeps the whole's `meet`, with the radii and groups of
// all particles (scene_of). Everything that this points at must live as long as the plan.
struct SharedMeetings {
  const Scene* whole = nullptr;   // a scene that compiles; null: no part
  std::span<const Vec3> start{};  // m: start positions of all particles of the whole, from its origin
  // The whole's indices of the part's particles.
  std::span<const std::uint32_t> numbers{};
  // The whole's indices of all particles, in the order of the records: each part's own particles stand together, in that part's
  // order; this part's begin at `first`.
  std::span<const std::uint32_t> told{};
  std::size_t first = 0;
  void* context = nullptr;
  // Fills in the other parts' records; this part's own are in their places. There is a record of `each` bytes for each entry of
  // `told`. All parts that have particles call it once a sub-step. Allocates nothing.
  void (*tell)(void* context, std::byte* records, std::size_t each) noexcept = nullptr;
};

// Some formulas are chosen by the fastest of all particles. With these numbers of the whole batch in Options::elsewhere, a
// part's bits are those that it has in the whole.
struct PartContext {
  double W = 0;                       // 1/s^2: the highest stiffness over mass, of any particle and axis
  double g = 0;                       // 1/s: the highest damping over mass
  bool anchors_differ = false;        // whether springs that their methods do not combine have different anchors
  bool springs_damp = false;          // whether any spring between particles damps
  std::optional<double> rho{};        // NetworkLimit::rho of the whole's plan; none: by this plan's own springs
  bool closes_substeps = false;       // whether each sub-step ends with skins, as some hold particles
  Exchange exchange{};                // of the halo, if springs lead out of the part
  const SweptPart* sweeps = nullptr;  // for networks by `sequential` that are no sheets
  SharedBirths births{};              // for LifecyclePlan
  SharedMeetings meetings{};          // for particles that meet
};

using Elsewhere [[deprecated("dvdx::PartContext")]] = PartContext;

// Returns W, g, anchors_differ and closes_substeps for the scene's first `count` particles.
[[nodiscard]] DVDX_EXPORT PartContext elsewhere_of(const Scene& scene, std::size_t count);

}  // namespace dvdx
