// A scene with one of everything, and the reader's message about a text.
#pragma once

#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "support/paths.hpp"
#include "tools/schema.hpp"

namespace scene_texts {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::Schema;
using nlohmann::json;

// One of everything, for three particles.
inline constexpr const char* full_scene = R"({
  "format": "dvdx-scene/1", "name": "full", "about": "one of everything", "step": 0.25, "duration": 2, "method": "exact",
  "particles": {
    "count": 3,
    "mass": {"values": [1, 2, 3]},
    "position": {"uniform": {"min": [0, 1, 2], "max": [1, 1, 4], "seed": 5}},
    "velocity": [1, 2, 3]
  },
  "forces": [
    {"type": "constant", "acceleration": [0, -9.81, 0], "method": "pulse"},
    {"type": "polynomial", "acceleration": [[1, 0, 0], [0, 2, 0]]},
    {"type": "sinusoid", "acceleration": [1, 0, 0], "angular_frequency": 2},
    {"type": "spring", "stiffness": {"uniform": {"min": 1, "max": 2, "seed": 1}}, "anchor": "start"},
    {"type": "radial_spring", "stiffness": 4, "damping": 0.5, "anchor": {"values": [[0,0,0],[1,1,1],[2,2,2]]}, "rest_length": 1},
    {"type": "drag", "coefficient": [1, 2, 3], "wind": [4, 5, 6], "expansion": "first_order"}
  ],
  "contacts": [
    {"type": "plane", "normal": [0, 3, 4], "offset": -1, "restitution": 0.5, "friction": 0.2},
    {"type": "sphere", "center": [1, 2, 3], "radius": 9, "side": "inside", "viscosity": 0.1, "normal_viscosity": 0.3,
     "response": "seed", "sweep": "line", "motion": "lift"},
    {"type": "capsule", "ends": [[0, 1, 0], [2, 1, 0]], "radius": [0.5, 0.25], "thickness": 0.125, "push_out": 0.75},
    {"type": "capsule", "ends": [[0, 1, 0], [0, 1, 0]], "radius": 2, "friction": 0.5},
    {"type": "box", "center": [1, 0, 0], "half_extents": [4, 5, 6], "rotation": [0, 0.5, 0], "side": "inside"},
    {"type": "convex", "planes": [{"normal": [-1, 0, 0], "offset": 0}, {"normal": [0, -2, 0], "offset": 0},
                                  {"normal": [0, 0, -1], "offset": 0}, {"normal": [0, 3, 4], "offset": 1.5},
                                  {"normal": [1, 0, 0], "offset": 1}]}
  ],
  "motions": {
    "arm": {"keys": [{"time": 0}]},
    "lift": {"center": [0, 1, 0], "keys": [{"time": -1, "translation": [0, 1, 0]}, {"time": 2, "rotation": [0, 3, 0], "jump": true}]}
  },
  "kinematic": [{"particles": [1], "motion": "lift"}],
  "skins": [{"particles": [2, 0], "points": [[0, 0, 0], [1, 0, 0]], "at_most": [0.5, 0], "motion": "arm",
             "backstop": {"normals": [[0, 1, 0], [0, 0, 1]], "offset": [0.25, 0], "radius": 2}}],
  "meet": {"radius": {"values": [0.1, 0.2, 0.3]}, "restitution": 0.3, "friction": 0.5, "rounds": 6, "most_neighbours": 32,
           "apart_at_start": true, "groups": {"of": [0, 1, 1], "meet": [[0, 1], [1, 1]]}},
  "fixed": [2]
})";

inline const ReadOptions plenty{.memory_bytes = 1000000000};

// The reader's error; empty if there is none. An error must have the exit code of a bad scene.
inline std::string message_of(std::string_view text, const ReadOptions& options = plenty,
                              const std::string& path = "hail.json") {
  try {
    (void)parse_scene(path, text, options);
    return "";
  } catch (const Fault& fault) {
    CHECK(fault.exit() == Exit::bad_scene);
    return fault.what();
  }
}

inline Schema scene_schema() {
  std::ifstream file(dvdx::test::schema());
  return Schema(json::parse(file));
}

}  // namespace scene_texts
