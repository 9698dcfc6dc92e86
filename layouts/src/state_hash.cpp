#include "dvdx/layouts/state_hash.hpp"

#include <bit>
#include <type_traits>

namespace dvdx {
namespace {

template <class T>
std::uint64_t mix(std::uint64_t hash, T value) noexcept {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  const std::uint64_t bits = std::bit_cast<Bits>(value);
  for (unsigned byte = 0; byte < sizeof(T); ++byte) {
    hash = (hash ^ ((bits >> (8 * byte)) & 0xFFU)) * 0x100000001B3U;
  }
  return hash;
}

}  // namespace

template <class T>
std::uint64_t state_hash(const State<T>& state) noexcept {
  return state_hash(state, empty_state_hash);
}

template <class T>
std::uint64_t state_hash(const State<T>& state, std::uint64_t before) noexcept {
  std::uint64_t hash = before;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const auto& column : state.x) hash = mix<T>(hash, column[i]);
    for (const auto& column : state.v) hash = mix<T>(hash, column[i]);
  }
  return hash;
}

std::string hash_text(std::uint64_t hash) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = text.size(); i-- > 0; hash >>= 4U) text[i] = digits[hash & 15U];
  return text;
}

template std::uint64_t state_hash(const State<float>&) noexcept;
template std::uint64_t state_hash(const State<double>&) noexcept;
template std::uint64_t state_hash(const State<float>&, std::uint64_t) noexcept;
template std::uint64_t state_hash(const State<double>&, std::uint64_t) noexcept;

}  // namespace dvdx
