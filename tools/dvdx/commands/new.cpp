// dvdx new: a scene to start from.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "commands/commands.hpp"
#include "files/part_file.hpp"
#include "output/console.hpp"

namespace dvdx::tool {
namespace {

struct Starter {
  std::string_view name;
  std::string_view text;
};

constexpr std::string_view cloth = R"({
  "format": "dvdx-scene/1",
  "name": "cloth",
  "about": "A cloth of 1 m x 1 m and 200 g falls onto a ball, held by two corners. Change first: rows and columns (its particles), structural, shear and bend (N/m: how stiff it is), damping, fixed (edge_top, corners_top or left out), wind; thickness keeps the cloth that far (m) off the ball. docs/scene.md has every key.",
  "step": 0.016666666666666666,
  "duration": 4.0,
  "network": {
    "type": "grid",
    "rows": 40,
    "columns": 40,
    "origin": [-0.5, 1.2, -0.5],
    "edge_u": [1, 0, 0],
    "edge_v": [0, 0, 1],
    "mass": 0.2,
    "structural": 80,
    "shear": 30,
    "bend": 1,
    "damping": 0.002,
    "fixed": "corners_top",
    "aerodynamics": {"density": 1.2, "drag": 1.0, "lift": 0.5}
  },
  "wind": {"mean": [0, 0, 0]},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
  "contacts": [
    {"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.5, "thickness": 0.01},
    {"type": "sphere", "center": [0, 0.8, 0.1], "radius": 0.25, "friction": 0.3, "thickness": 0.01}
  ]
}
)";

constexpr std::string_view rope = R"({
  "format": "dvdx-scene/1",
  "name": "rope",
  "about": "A rope of 2 m and 300 g swings from one end: a grid of one row. Change first: columns (its particles), structural (N/m: each piece between two particles), bend, fixed (the particles that are held, counted from 0). docs/scene.md has every key.",
  "step": 0.016666666666666666,
  "duration": 5.0,
  "network": {
    "type": "grid",
    "rows": 1,
    "columns": 60,
    "origin": [0, 2.5, 0],
    "edge_u": [2, 0, 0],
    "edge_v": [0, 0, 0],
    "mass": 0.3,
    "structural": 2000,
    "bend": 20,
    "damping": 0.01
  },
  "fixed": [0],
  "forces": [
    {"type": "constant", "acceleration": [0, -9.81, 0]},
    {"type": "drag", "coefficient": 0.0005}
  ],
  "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.5}]
}
)";

constexpr std::string_view fountain = R"({
  "format": "dvdx-scene/1",
  "name": "fountain",
  "about": "A nozzle throws up drops that fall back in a wind, splash and are gone within 3 s. Change first: rate (drops a second), velocity and spread (m/s), lifetime (s); capacity is the most that live at a time. docs/scene.md has every key.",
  "step": 0.016666666666666666,
  "duration": 8.0,
  "capacity": 12000,
  "particles": {"mass": 0.0005},
  "emitters": [
    {"type": "disc", "center": [0, 0.5, 0], "normal": [0, 1, 0], "radius": 0.04, "rate": 3000, "velocity": [0, 8, 0],
     "spread": 0.6, "lifetime": {"min": 2, "max": 3}, "seed": 1}
  ],
  "removal": {"outside": {"min": [-20, -1, -20], "max": [20, 20, 20]}, "not_finite": "removed"},
  "forces": [
    {"type": "constant", "acceleration": [0, -9.81, 0]},
    {"type": "drag", "coefficient": 0.00015, "wind": [1.5, 0, 0.4]}
  ],
  "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.25, "friction": 0.2}]
}
)";

constexpr std::string_view grains = R"({
  "format": "dvdx-scene/1",
  "name": "grains",
  "about": "500 grains of 6 cm fall onto a ball and a floor, meet and heap up. Change first: count, position (a lattice whose spacing is more than twice the radius, or a file), meet: radius, restitution (0: no bounce, 1: none lost), friction; without meet they pass through each other. docs/scene.md has every key.",
  "step": 0.016666666666666666,
  "duration": 4.0,
  "particles": {
    "count": 500,
    "mass": 0.1,
    "position": {"lattice": {"min": [-0.4, 1.3, -0.4], "max": [0.4, 3, 0.4], "spacing": 0.065, "jitter": 0.002, "seed": 1}}
  },
  "forces": [
    {"type": "constant", "acceleration": [0, -9.81, 0]},
    {"type": "drag", "coefficient": 0.002}
  ],
  "contacts": [
    {"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.3, "friction": 0.4},
    {"type": "sphere", "center": [0, 0.7, 0], "radius": 0.4, "restitution": 0.4, "friction": 0.2}
  ],
  "meet": {"radius": 0.03, "restitution": 0.3, "friction": 0.4}
}
)";

constexpr std::array<Starter, 4> starters{{{"cloth", cloth}, {"rope", rope}, {"fountain", fountain}, {"grains", grains}}};

std::vector<std::string> starter_names() {
  std::vector<std::string> names;
  for (const auto& starter : starters) names.emplace_back(starter.name);
  return names;
}

void write_starter(const std::string& kind, const std::filesystem::path& target) {
  check_target(target);
  if (std::filesystem::exists(target)) {
    throw Fault(Exit::input_output, target.string() + ": is there already, and is left as it is: name another file");
  }
  const auto named = [&](const Starter& starter) { return starter.name == kind; };
  PartFile file(target);
  file.write(std::find_if(starters.begin(), starters.end(), named)->text);
  file.commit();
  auto page = target;
  page.replace_extension(".html");
  print_answer(fmt::format("{:<12} {}\n{:<12} dvdx run {} --out {}\n", "written", target.string(), "next", target.string(),
                           page.string()));
}

}  // namespace

void add_new(CLI::App& app, Exit& /*exit*/) {
  auto kind = std::make_shared<std::string>();
  auto file = std::make_shared<std::string>();
  auto* command = app.add_subcommand("new", "Write a scene to start from");
  command->footer("dvdx new cloth mine.json");
  command->add_option("KIND", *kind, "what it is of")->required()->check(CLI::IsMember(starter_names()));
  command->add_option("FILE", *file, "a scene file (JSON) that is not there yet")->required();
  command->callback([kind, file] { write_starter(*kind, *file); });
}

}  // namespace dvdx::tool
