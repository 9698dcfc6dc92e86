// Sends the halo of a part of a larger scene, and does nothing else meanwhile. The lists of what is sent: dvdx/partition.hpp,
// made by topology/halo_lists.cpp.
#pragma once

#include <array>
#include <cstdint>

#include "dvdx/elsewhere.hpp"

namespace dvdx {

// element: of each of the part's particles, its element of the columns.
template <class T>
HaloColumns halo_of(const std::array<T*, 3>& columns, const std::uint32_t* element) noexcept {
  return {{columns[0], columns[1], columns[2]}, sizeof(T), element};
}

// Does nothing if a scene is whole.
inline void send(const Exchange& exchange, const HaloColumns& halo) noexcept {
  if (exchange.start == nullptr) return;
  exchange.start(exchange.context, halo);
  exchange.finish(exchange.context, halo);
}

}  // namespace dvdx
