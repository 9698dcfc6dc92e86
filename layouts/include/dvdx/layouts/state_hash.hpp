// A hash of a state.
#pragma once

#include <cstdint>
#include <string>

#include "dvdx/export.h"
#include "dvdx/layouts/state.hpp"

namespace dvdx {

// FNV-1a, 64 bits, over the little-endian bytes of x, y, z, vx, vy, vz, particle by particle: the same for every layout.
// `dvdx run --json` prints it.
template <class T>
[[nodiscard]] DVDX_EXPORT std::uint64_t state_hash(const State<T>& state) noexcept;

// Continues a hash: `before` is the hash of all particles before these, or empty_state_hash.
inline constexpr std::uint64_t empty_state_hash = 0xCBF29CE484222325U;
template <class T>
[[nodiscard]] DVDX_EXPORT std::uint64_t state_hash(const State<T>& state, std::uint64_t before) noexcept;

// 16 hexadecimal digits.
[[nodiscard]] DVDX_EXPORT std::string hash_text(std::uint64_t hash);

extern template std::uint64_t state_hash(const State<float>&) noexcept;
extern template std::uint64_t state_hash(const State<double>&) noexcept;
extern template std::uint64_t state_hash(const State<float>&, std::uint64_t) noexcept;
extern template std::uint64_t state_hash(const State<double>&, std::uint64_t) noexcept;

}  // namespace dvdx
