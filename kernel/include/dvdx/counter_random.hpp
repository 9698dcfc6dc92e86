// Seeded random numbers that depend on (seed, particle, axis) alone.
#pragma once

#include <array>
#include <cstdint>

namespace dvdx {

// Philox4x32-10 (Salmon, Moraes, Dror, Shaw: "Parallel random numbers: as easy as 1, 2, 3", 2011): a keyed mixing of a
// 128-bit counter, ten rounds of two 32x32-bit multiplications.
[[nodiscard]] constexpr std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                                                std::array<std::uint32_t, 2> key) noexcept {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53U} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57U} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32U) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32U) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key = {key[0] + 0x9E3779B9U, key[1] + 0xBB67AE85U};
  }
  return counter;
}

// Returns a multiple of 2^-53 in [0, 1). The counter is (particle low, particle high, axis, 0), the key (seed low, seed high).
[[nodiscard]] constexpr double unit_value(std::uint64_t seed, std::uint64_t particle, std::uint32_t axis) noexcept {
  const auto bits = philox4x32({static_cast<std::uint32_t>(particle), static_cast<std::uint32_t>(particle >> 32U), axis, 0},
                               {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)});
  const std::uint64_t word = bits[0] | (std::uint64_t{bits[1]} << 32U);
  return static_cast<double>(word >> 11U) * 0x1p-53;
}

}  // namespace dvdx
