// --set: the assignments of a command line, one a line, applied to a scene with every feature.
#include <string>
#include <vector>

#include "fuzz/files.hpp"
#include "fuzz/targets.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "scene_io/text_lines.hpp"

namespace dvdx::fuzz {
namespace {

constexpr std::string_view scene = R"({"format": "dvdx-scene/1", "name": "all", "step": 0.1, "duration": 1,
 "particles": {"count": 4, "mass": {"values": [1, 2, 3, 4]}, "position": {"uniform": {"min": [0, 0, 0], "max": [1, 1, 1], "seed": 1}}},
 "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "spring", "stiffness": 4, "anchor": "start"}],
 "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0}],
 "network": {"type": "springs", "pairs": [[0, 1], [1, 2]], "stiffness": 3, "rest_length": "start"},
 "constraints": [{"type": "point", "particle": 3, "at": [0, 0, 0]}], "fixed": [0]})";

}  // namespace

void overrides(std::string_view bytes) {
  tool::ReadOptions options{.memory_bytes = most_bytes};
  for (tool::Lines lines(bytes); lines.more();) options.overrides.emplace_back(lines.next());
  try {
    (void)tool::parse_scene(files() + "/scene.json", scene, options);
  } catch (const tool::Fault& fault) {
    const bool is_told = fault.exit() == tool::Exit::bad_scene || fault.exit() == tool::Exit::usage;
    expect(is_told, "a bad assignment is a bad scene or a misuse");
  }
}

}  // namespace dvdx::fuzz
