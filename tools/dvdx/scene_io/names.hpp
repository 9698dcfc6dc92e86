// The words that scenes and the command line use for the choices of the library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "dvdx/fields.hpp"
#include "scene_io/fields.hpp"

namespace dvdx::tool {

template <class E>
inline constexpr auto named_choices = [] {
  std::array<Named<E>, words<E>.size()> all;
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = {words<E>[k], static_cast<E>(k)};
  return all;
}();
inline constexpr auto methods = named_choices<Method>;
inline constexpr auto schemes = named_choices<Scheme>;
inline constexpr std::uint64_t most_substeps = 1000000;  // a step

template <class E, std::size_t N>
[[nodiscard]] constexpr std::string_view name_in(const std::array<Named<E>, N>& table, E value) noexcept {
  for (const auto& entry : table) {
    if (entry.value == value) return entry.name;
  }
  return "?";
}

}  // namespace dvdx::tool
