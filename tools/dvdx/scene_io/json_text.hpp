// Parses JSON text to a tree, more strictly than the underlying parser: no duplicate keys, no overflowing numbers, bounded
// depth, and messages that say where.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace dvdx::tool {

// Nesting depth of arrays and objects; a scene needs 7.
inline constexpr std::size_t max_json_depth = 32;

// `name` is what messages call the input. Throws Fault (bad_scene).
[[nodiscard]] nlohmann::json parse_json(const std::string& name, std::string_view text);

// Returns a value as a message shows it: its JSON, cut if it is long.
[[nodiscard]] std::string shown(const nlohmann::json& value);

}  // namespace dvdx::tool
