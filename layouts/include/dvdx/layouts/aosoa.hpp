// Array of structures of arrays: tiles of 8 or 16 particles, the six columns of a tile side by side.
#pragma once

#include <cstddef>

#include "dvdx/layouts/soa.hpp"

namespace dvdx {

// A view of the caller's tiles: tile j holds x[Tile], y[Tile], z[Tile], vx[Tile], vy[Tile], vz[Tile]. The last tile is whole in
// memory; its unused elements are padding that a step may overwrite.
template <std::size_t Tile, class T>
State<T> aosoa(T* tiles, std::size_t n) noexcept {
  static_assert(Tile == 8 || Tile == 16);
  const std::size_t capacity = (n + Tile - 1) / Tile * Tile;
  State<T> state{.x = {}, .v = {}, .count = n, .clock = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr auto stride = static_cast<std::ptrdiff_t>(6 * Tile * sizeof(T));
    state.x[axis] = {tiles + axis * Tile, stride, Tile, capacity};
    state.v[axis] = {tiles + (3 + axis) * Tile, stride, Tile, capacity};
  }
  return state;
}

// Owning tiles, aligned to 64 bytes.
template <class T, std::size_t Tile>
class DVDX_EXPORT Aosoa {
 public:
  explicit Aosoa(std::size_t count, const Memory& memory = {});
  [[nodiscard]] State<T> view() noexcept { return aosoa<Tile>(memory_.get(), count_); }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }

 private:
  std::size_t count_;
  AlignedArray<T> memory_;
};

extern template class Aosoa<float, 8>;
extern template class Aosoa<float, 16>;
extern template class Aosoa<double, 8>;
extern template class Aosoa<double, 16>;

}  // namespace dvdx
