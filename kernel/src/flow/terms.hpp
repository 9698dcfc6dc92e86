// The input of the hot loops: the rounded coefficients of a plan, the offsets of one step, and a block of particles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "flow/bend.hpp"
#include "flow/near.hpp"

namespace dvdx {

// The motion of a block's particles between impacts. Each flow has a wide body and a scalar twin in flow/.
enum class Flow : std::uint8_t {
  drift,       // no spring: x += S v + Q,  v += P - B v
  fused,       // springs to one anchor:  x += S v - C e,  v -= A e + B v,  e = x - c
  fused_each,  // an anchor for each particle
  shear,       // oscillating, in three shears: x += d,  v = u
  shear_each,
  driven_fused,  // with the offsets P and Q of other accelerations
  driven_fused_each,
  driven_shear,
  driven_shear_each,
  rate_drift,  // coefficients for each particle; always driven
  rate_fused,
  rate_shear,
};
inline constexpr std::size_t flows = 12;

constexpr bool is_rate(Flow flow) noexcept { return flow >= Flow::rate_drift; }
constexpr bool is_shear(Flow flow) noexcept {
  return flow == Flow::shear || flow == Flow::shear_each || flow == Flow::driven_shear || flow == Flow::driven_shear_each ||
         flow == Flow::rate_shear;
}
constexpr bool is_drift(Flow flow) noexcept { return flow == Flow::drift || flow == Flow::rate_drift; }
constexpr bool is_driven(Flow flow) noexcept { return flow == Flow::drift || flow >= Flow::driven_fused; }
constexpr bool has_anchor_each(Flow flow) noexcept {
  return flow == Flow::fused_each || flow == Flow::shear_each || flow == Flow::driven_fused_each ||
         flow == Flow::driven_shear_each || flow == Flow::rate_fused || flow == Flow::rate_shear;
}

// The work of a step besides the flow; an index of the kernel table.
enum class StepFeatures : std::uint8_t { none, contact, radial, radial_contact };
inline constexpr std::size_t feature_sets = 4;

constexpr bool has_contacts(StepFeatures features) noexcept {
  return features == StepFeatures::contact || features == StepFeatures::radial_contact;
}
constexpr bool has_radial(StepFeatures features) noexcept {
  return features == StepFeatures::radial || features == StepFeatures::radial_contact;
}
constexpr StepFeatures features_of(std::size_t radial_springs, std::size_t contacts) noexcept {
  return static_cast<StepFeatures>((contacts != 0 ? 1 : 0) + (radial_springs != 0 ? 2 : 0));
}

// Beside radial springs, which take longer than any flow, one body serves all flows of a kind: one anchor or one for each
// particle, driven or not, turned or not. Each batch tests for these once an axis.
constexpr Flow kind_of(Flow flow) noexcept {
  if (is_rate(flow) || is_drift(flow)) return flow;
  return is_shear(flow) ? Flow::shear : Flow::fused;
}
constexpr bool is_asked(Flow flow, StepFeatures features) noexcept {
  return has_radial(features) && !is_rate(flow) && !is_drift(flow);
}

// Position-independent accelerations whose effect differs from particle to particle (rate flows only).
inline constexpr std::size_t max_sources = 16;

// The position-independent part of one step, made in float64 for each step and rounded.
template <class T>
struct Offsets {
  std::array<T, 3> P, Q;                                // dv and dx, the same for all particles
  std::array<std::array<T, 3>, max_sources> amplitude;  // of every source that a rate flow has, by axis
  std::array<std::array<T, 3>, 3> drive;                // D1, D2, D3 of flow/bend.hpp, m, by axis
};

template <class T>
struct FusedAxis {
  T A{}, B{}, C{}, S{};  // see forces/contribution.hpp; S = h - D
};

// Whether some axis turns by more than a right angle in a step: its sign is then -1.
enum class Turn : std::uint8_t { none, turned };

template <class T>
struct ShearAxis {
  T sign{}, t1{}, s{}, t2{}, kappa{};  // see forces/shear.hpp
};

template <class T>
struct Rates {
  AxisColumns<T> A{}, B{}, C{}, S{};       // rate_drift, rate_fused
  AxisColumns<T> sign{}, t1{}, s{}, t2{};  // rate_shear, which is undamped
  std::size_t sources = 0;                 // number of the following that are used
  std::array<AxisColumns<T>, max_sources> gain_v{}, gain_x{};
};

template <class T>
struct Surface;  // contact/surfaces/surface.hpp
template <class T>
class ContactLog;  // contact/report/contact_log.hpp
template <class T>
struct RadialTerms;  // flow/radial.hpp

template <class T>
struct Terms {
  Flow flow = Flow::drift;  // where one body serves several
  std::array<FusedAxis<T>, 3> fused{};
  std::array<ShearAxis<T>, 3> shear{};
  Turn turn = Turn::none;
  std::array<T, 3> anchor{};     // uniform anchor
  AxisColumns<T> anchor_each{};  // or one for each particle
  Rates<T> rates{};
  const Surface<T>* surfaces = nullptr;
  std::size_t surface_count = 0;
  const SurfaceGroup* groups = nullptr;  // of group_size surfaces each, where blocks search
  bool moves = false;                    // whether some surface moves
  bool searches = false;                 // whether each block looks for the surfaces near it (flow/near.hpp)
  bool are_planes = false;               // whether all surfaces are planes, and no block searches
  bool pushes = false;                   // whether some surface pushes out particles that start inside; blocks search then
  const Terms* whole = nullptr;          // in a block's own terms: the terms with all surfaces
  Region<T> region{};                    // ... and the region for which its list is valid
  int impacts = 0;                       // the most of a particle in a step that are resolved in time order
  T h = 0;                               // the whole step, s
  Bend<T> bend{};                        // of the paths on which impacts are looked for
  const RadialTerms<T>* radial = nullptr;
  std::size_t radial_count = 0;
  std::size_t kicks = 0;     // number of radial springs that kick at the middle of the step; they stand first
  bool are_bounded = false;  // whether blocks search, and all surfaces rest and lie in a box:
  Region<T> bound{};         // ... this one, about the boxes that overlaps() tests
};

inline constexpr std::size_t max_block = 1024;  // particles

// Particles that are stepped while they stay in first-level cache: contiguous columns, `count` a multiple of 16 (the elements
// beyond the particles are padding). `first` is the index of x[.][0] in the plan's own columns.
template <class T>
struct Block {
  std::array<T*, 3> x{}, v{};
  // Where the last flow left the particles, if springs moved them since: contacts count that to this flow. Null: at x.
  std::array<const T*, 3> from{};
  // The sweeps' shift, added first if nothing but the flow acts: x += to_x shift, v += to_v shift, shift = 0. Null: none.
  std::array<T*, 3> shift{};
  T to_x{}, to_v{};
  std::size_t first = 0, count = 0;
  ContactLog<T>* log = nullptr;  // null: contacts are not logged
};

// offsets[n * offsets_per_step] belongs to step n. If springs kick at the middle of a step, offsets[... + 1] belongs to its
// second half.
template <class T>
struct Steps {
  const Offsets<T>* offsets = nullptr;
  std::size_t offsets_per_step = 0;  // 0: all steps share the first (and, with kicks, the second)
  std::size_t count = 0;
};

template <class T>
using StepBlock = void (*)(const Block<T>&, const Terms<T>&, const Steps<T>&);

}  // namespace dvdx
