// JSON text to a tree, stricter than the parser underneath: no duplicate keys, no overflowing numbers, bounded depth, and a
// message that says where.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace dvdx::tool {

// Arrays and objects within one another; a scene needs 7.
inline constexpr std::size_t max_json_depth = 32;

// `name` is what messages call the input. Throws Fault (bad_scene).
[[nodiscard]] nlohmann::json parse_json(const std::string& name, std::string_view text);

// A value as a message shows it: its JSON, cut where it is long.
[[nodiscard]] std::string shown(const nlohmann::json& value);

}  // namespace dvdx::tool
