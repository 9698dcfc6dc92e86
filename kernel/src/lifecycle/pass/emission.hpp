// The emission pass: where particles are born, how fast, and how long they will live.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dvdx/values.hpp"

namespace dvdx {

enum class EmissionShape { point, disc, box };
enum class EmissionSpread { none, ball, box };

// A compiled emitter.
struct EmissionTerms {
  EmissionShape shape = EmissionShape::point;
  EmissionSpread spread = EmissionSpread::none;
  Vec3 origin{};                // the point, the disc's centre, the box's least corner, m
  Vec3 most{};                  // the box's other corner, m
  std::array<Vec3, 2> radii{};  // of the disc, at right angles to its normal and to each other, m
  Vec3 velocity{};              // m/s
  Vec3 half_sides{};            // of the box of velocities, m/s
  double radius = 0;            // of the ball of velocities, m/s
  double lifetime = 0;          // s, the least
  double lifetime_range = 0;    // s
  double interval = 0;          // s, from a birth to the next
  std::uint64_t seed = 0;
};

inline constexpr std::size_t born_together = 256;  // at most, in one call
inline constexpr double two_pi = 0x1.921fb54442d18p+2;

// Births first, first + 1, ..., counted from 0. `lead`: births from `first` to the end of the step, so that number first + i
// has (lead - i) * interval seconds left in it, at least 0 and at most `step`.
struct Births {
  std::uint64_t first = 0;
  std::size_t count = 0;
  double lead = 0;
  double step = 0;  // s
};

// The births of a call. In every field, elements up to the next multiple of 8 are written.
struct Born {
  using Values = std::array<double, born_together>;
  alignas(64) std::array<Values, 3> x;
  alignas(64) std::array<Values, 3> v;
  alignas(64) Values age, lifetime;
};

using Emit = void (*)(const EmissionTerms& terms, const Births& births, Born& born) noexcept;

}  // namespace dvdx
