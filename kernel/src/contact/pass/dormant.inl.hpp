// Still lanes are lanes on surfaces in which a step has changed no bit. If the steps of a call are alike, no further step
// changes one either: a particle that lies in a corner is resolved once a call. A register of still lanes is skipped. In a
// register with others all lanes are moved, and the still ones are put back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "flow/terms.hpp"
#include "simd/lanes.hpp"
#include "simd/trajectory.inl.hpp"

namespace dvdx {
namespace {

// Returns the lanes without a differing bit: +0 differs from -0, and one NaN from another. A difference that leaves 1 when
// or-ed to it has only bits of 1; one that leaves 2 has only the bit of 2. These have no bit in common.
template <class V>
Mask<V> are_same_bits(const Trajectory<V>& m) noexcept {
  V difference = (m.x0[0] ^ m.x1[0]) | (m.v0[0] ^ m.v1[0]);
  for (std::size_t axis = 1; axis < 3; ++axis) {
    difference = difference | (m.x0[axis] ^ m.x1[axis]) | (m.v0[axis] ^ m.v1[axis]);
  }
  const V one(Scalar<V>(1));
  const V two(Scalar<V>(2));
  return ((difference | one) == one) & ((difference | two) == two);
}

template <class V>
class Dormant {
  using T = Scalar<V>;

 public:
  // Finds no lane still if steps differ (surfaces move, or forces depend on time), or if contacts are logged, since a resting
  // lane presses.
  Dormant(const Block<T>& particles, const Terms<T>& terms, const Steps<T>& steps) noexcept
      : looks_(steps.count > 1 && steps.offsets_per_step == 0 && !terms.moves && particles.log == nullptr &&
               particles.count <= max_block) {}

  [[nodiscard]] bool looks() const noexcept { return looks_; }

  // Returns the still lanes of the register at index i of the block; lane k is bit k.
  [[nodiscard]] std::uint64_t of(std::size_t i) const noexcept {
    return looks_ ? lanes_[i / word] >> (i % word) & all_of_register : 0;
  }
  [[nodiscard]] bool are_all(std::size_t i) const noexcept { return of(i) == all_of_register; }

  // Sets which of the `lanes` from index i on `are` still; all lie in one word.
  void set(std::size_t i, std::uint64_t lanes, std::uint64_t are) noexcept {
    std::uint64_t& all = lanes_[i / word];
    all = (all & ~(lanes << (i % word))) | are << (i % word);
  }
  // m: the register at index i, after its step. Puts still lanes back to their start, then finds the still lanes of `touching`.
  [[gnu::noinline]] void look(Trajectory<V>& m, std::size_t i, std::uint64_t touching) noexcept {
    const Mask<V> were = lanes_of<V>(of(i));
    m.x1 = select(were, m.x0, m.x1);
    m.v1 = select(were, m.v0, m.v1);
    set(i, all_of_register, touching & bits_of<V>(are_same_bits(m)));
  }

 private:
  static constexpr std::size_t word = 64;
  static constexpr std::uint64_t all_of_register = (std::uint64_t{1} << V::size) - 1;

  bool looks_;
  std::array<std::uint64_t, max_block / word> lanes_{};
};

}  // namespace
}  // namespace dvdx
