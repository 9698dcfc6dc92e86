// The ways of particles in a sub-step, as passes take them: from the columns that flows step into records of four, and how far
// each strays from what all go by.
#pragma once

#include <array>
#include <cstdint>

#include "meet/meet.hpp"

namespace dvdx {

template <class T>
struct WayTerms {
  const std::uint32_t* elements = nullptr;  // of each particle, in the columns, below 2^31; null: the records have been filled
  std::array<const T*, 3> x{}, v{};
  const T* w = nullptr;
  const MetStart<T>* start = nullptr;
  const MetListed<T>* listed = nullptr;
  MetEnd<T>* end = nullptr;
  MetVelocity<T>* velocity = nullptr;
};

// Over particles that have a radius and whose ways are finite, below the root of what is. Particles are dealt to meeting_lanes
// sums in turn, which are then added in double: the same on every instruction set.
struct WaySums {
  std::array<double, 3> way{}, gone{};  // m: in this sub-step, and since lists were built
  std::uint32_t ways = 0, gones = 0;    // how many
  bool has_movers = false;              // some have no mass, and move
};

template <class T>
struct StrayTerms {
  const MetStart<T>* start = nullptr;
  const MetListed<T>* listed = nullptr;
  MetEnd<T>* end = nullptr;
  Point<T> way{}, gone{};  // m: of all
  T allowed = 0;           // m: that lists allow each beside its own allowance
};

// Whether lists are to be built again: for particles that are not finite always.
enum class ListAge { fresh, stale };

}  // namespace dvdx
