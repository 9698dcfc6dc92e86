// Reads a scene from a scene file, format "dvdx-scene/1". docs/scene.md describes the format.
#pragma once

#include <algorithm>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene_io/particle_values.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

[[nodiscard]] std::uint64_t available_memory();  // bytes

// One of several ranks that hold a scene's particles together.
struct RankShare {
  std::size_t rank = 0, ranks = 1;
  [[nodiscard]] Run of(std::size_t particles) const noexcept {
    const auto start = [&](std::size_t r) { return particles / ranks * r + std::min(r, particles % ranks); };
    return {.first = start(rank), .count = start(rank + 1) - start(rank)};
  }
};

struct ReadOptions {
  std::vector<std::string> overrides{};             // of --set
  std::optional<std::uint64_t> seed{};              // draws other values than the scene's own seeds
  std::size_t scalar_bytes = sizeof(float);         // of a number of the state
  std::uint64_t memory_bytes = available_memory();  // that the particles may take
  RankShare share{};                                // of the particles of a scene that can be split by ranges
  std::string scheme{}, substeps{};                 // that will replace the networks' own; empty: none will
  ReadTopology topology = ReadTopology::yes;
};

// Throws Fault: input_output if the file cannot be read, bad_scene if its contents are not a scene. The message names the file,
// the path of the key, the value, and the valid values.
[[nodiscard]] SceneFile read_scene(const std::string& path, const ReadOptions& options = {});

// Returns the file's JSON with the replacements of `options`, not yet checked as a scene. Throws as read_scene.
[[nodiscard]] nlohmann::json read_json(const std::string& path, const ReadOptions& options = {});

// The same as read_scene from text; files that it refers to are looked for beside `path`.
[[nodiscard]] SceneFile parse_scene(const std::string& path, std::string_view text, const ReadOptions& options = {});

}  // namespace dvdx::tool
