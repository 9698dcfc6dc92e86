// The ways of particles, which are their displacements in a sub-step, as passes take them. The passes copy the columns that
// flows step into records of four, and find how far each particle strays from the mean way of all.
#pragma once

#include <array>
#include <cstdint>

#include "meet/meet.hpp"

namespace dvdx {

template <class T>
struct WayTerms {
  const std::uint32_t* elements = nullptr;  // of each particle, in the columns, below 2^31; null: records are filled
  std::array<const T*, 3> x{}, v{};
  const T* w = nullptr;
  const MetStart<T>* start = nullptr;
  const MetListed<T>* listed = nullptr;
  MetEnd<T>* end = nullptr;
  MetVelocity<T>* velocity = nullptr;
};

// Sums over particles that have a radius and a way whose square is finite. Particles are dealt to meeting_lanes sums in turn,
// which are then added in double: the same on every instruction set.
struct WaySums {
  std::array<double, 3> way{}, gone{};  // m: in this sub-step, and since lists were built
  std::uint32_t ways = 0, gones = 0;    // the number of terms
  bool has_movers = false;              // a particle with w = 0 moves
};

template <class T>
struct StrayTerms {
  const MetStart<T>* start = nullptr;
  const MetListed<T>* listed = nullptr;
  MetEnd<T>* end = nullptr;
  Point<T> way{}, gone{};  // m: the means over all
  T allowed = 0;           // m: what lists allow each particle besides its own allowance
};

// Whether lists must be built again. A particle that is not finite always makes them stale.
enum class ListAge { fresh, stale };

}  // namespace dvdx
