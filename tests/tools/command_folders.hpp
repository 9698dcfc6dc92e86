// Folders with a scene, as working directories of the command.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/scratch_folder.hpp"

namespace command_folders {

using dvdx::test::ScratchFolder;
using namespace std::string_literals;

inline constexpr const char* fall = R"({
  "format": "dvdx-scene/1", "name": "fall", "step": 0.125, "duration": 1.25,
  "particles": {"count": 20, "position": {"uniform": {"min": [0, 1, 0], "max": [1, 9, 1], "seed": 3}}},
  "forces": [{"type": "constant", "acceleration": [0, -8, 0]},
             {"type": "spring", "stiffness": 2, "anchor": "start", "method": "symplectic_euler"}],
  "fixed": [7]
})";

class Folder : public ScratchFolder {
 public:
  explicit Folder(const std::string& name) : ScratchFolder("command-" + name) { write("fall.json", fall); }
};

inline constexpr const char* sheet = R"({
  "format": "dvdx-scene/1", "name": "sheet", "step": 0.03125, "duration": 0.5,
  "network": {"type": "grid", "rows": 5, "columns": 6, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 0.8],
              "mass": 0.3, "structural": 40, "shear": 10, "bend": 1, "damping": 0.01, "fixed": "corners_top"},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]
})";

class SheetFolder : public ScratchFolder {
 public:
  explicit SheetFolder(const std::string& name) : ScratchFolder("command-" + name) { write("sheet.json", sheet); }
};

inline constexpr const char* jet = R"({
  "format": "dvdx-scene/1", "name": "jet", "step": 0.015625, "duration": 2, "capacity": 70,
  "emitters": [{"type": "disc", "center": [0, 0.1, 0], "normal": [0, 1, 0], "radius": 0.1, "rate": 100, "velocity": [0, 4, 0],
                "spread": 0.5, "lifetime": {"min": 0.2, "max": 0.9}, "seed": 4}],
  "removal": {"boundaries": [{"normal": [0, 1, 0], "offset": 0}]},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]
})";

}  // namespace command_folders
