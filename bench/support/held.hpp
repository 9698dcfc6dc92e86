// Particles together with their memory, in every layout that is timed.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <vector>

#include "dvdx/layouts/aos.hpp"
#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/layouts/soa.hpp"
#include "support/plain.hpp"

namespace dvdx::bench {

template <class T>
struct Held {
  std::shared_ptr<void> memory;
  State<T> state;
};
template <class T>
using Hold = Held<T> (*)(std::size_t count);

// Starts particles within 1 m of the origin, slower than 1 m/s, the same in every layout and count.
template <class T>
void scatter_about(State<T>& state) {
  std::size_t seed = 1;
  const auto next = [&seed] {
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    return static_cast<T>(static_cast<double>(seed >> 11) / 4503599627370496.0 - 1);
  };
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = next();
      state.v[axis][i] = next();
    }
  }
  state.clock = {};
}

template <class T>
Held<T> hold_padded(std::size_t count) {
  auto memory = std::make_shared<Soa<T>>(count);
  return {memory, memory->view()};
}

// Six separate arrays, `pitch` elements apart and exactly full.
template <class T>
Held<T> hold_apart(std::size_t count, std::size_t pitch) {
  const auto memory = std::make_shared<AlignedArray<T>>(aligned_array<T>(6 * pitch + 4096 / sizeof(T)));
  T* p = memory->get();
  return {memory, soa(p, p + pitch, p + 2 * pitch, p + 3 * pitch, p + 4 * pitch, p + 5 * pitch, count)};
}
template <class T>
Held<T> hold_full(std::size_t count) {
  return hold_apart<T>(count, column_pitch<T>(count));
}
// The distance is a multiple of 4096 bytes, as in large allocations.
template <class T>
Held<T> hold_pages(std::size_t count) {
  constexpr std::size_t page = 4096 / sizeof(T);
  return hold_apart<T>(count, (count + page - 1) / page * page);
}

template <class T>
Held<T> hold_aos(std::size_t count) {
  struct Particle {
    T position[3], age, velocity[3], size;
  };
  const auto memory = std::make_shared<std::vector<Particle>>(count);
  Particle& first = memory->front();
  return {memory, aos(&first.position[0], &first.velocity[0], sizeof(Particle), count)};
}

template <class T, std::size_t Tile>
Held<T> hold_tiles(std::size_t count) {
  auto memory = std::make_shared<Aosoa<T, Tile>>(count);
  return {memory, memory->view()};
}

// Contiguous layouts only.
template <class T>
PlainArrays<T> arrays_of(const State<T>& state) {
  return {
      {state.x[0].base, state.x[1].base, state.x[2].base}, {state.v[0].base, state.v[1].base, state.v[2].base}, state.count};
}

template <class T>
bool is_same_bits(const State<T>& a, const State<T>& b, std::size_t count) {
  const auto same = [](T p, T q) { return std::memcmp(&p, &q, sizeof(T)) == 0; };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < count; ++i) {
      if (!same(a.x[axis][i], b.x[axis][i]) || !same(a.v[axis][i], b.v[axis][i])) return false;
    }
  }
  return true;
}

}  // namespace dvdx::bench
