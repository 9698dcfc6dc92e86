// dvdx verify: every way to run a scene against the scalar reference, bit by bit; fast arithmetic by bounds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "output/console.hpp"
#include "run/progress.hpp"
#include "scene_io/names.hpp"
#include "scene_io/scene_reader.hpp"
#include "scene_io/steps.hpp"
#include "verify/verify_live.hpp"
#include "verify/verify_matrix.hpp"

namespace dvdx::tool {
namespace {

// The scenes that run if none is named: one for each kind of pass.
constexpr std::array built_in = {
    R"({"format": "dvdx-scene/1", "name": "springs", "step": 0.01, "duration": 4,
        "particles": {"count": 1000, "position": {"uniform": {"min": [-1, -1, -1], "max": [1, 1, 1], "seed": 1}}},
        "forces": [{"type": "spring", "stiffness": 40, "anchor": "start"}, {"type": "constant", "acceleration": [0, -9.81, 0]},
                   {"type": "spring", "stiffness": [3, 5, 9], "anchor": [0.1, 0.2, 0.3]}]})",
    R"({"format": "dvdx-scene/1", "name": "wind", "step": 0.01, "duration": 4,
        "particles": {"count": 3000, "mass": {"uniform": {"min": 0.5, "max": 2, "seed": 2}},
                      "position": {"uniform": {"min": [-1, -1, -1], "max": [1, 1, 1], "seed": 3}}},
        "forces": [{"type": "spring", "stiffness": {"uniform": {"min": 1, "max": 90, "seed": 4}}, "damping": 0.3, "anchor": "start"},
                   {"type": "drag", "coefficient": 0.2, "wind": [3, 0, 1]},
                   {"type": "sinusoid", "acceleration": [2, 0, 0.6], "angular_frequency": 4.1},
                   {"type": "polynomial", "acceleration": [[0, 1, 0], [0, 0, 0.2]]}]})",
    R"({"format": "dvdx-scene/1", "name": "bounces", "step": 0.01, "duration": 4,
        "particles": {"count": 1000, "position": {"uniform": {"min": [-1, 0.1, -1], "max": [1, 2, 1], "seed": 5}},
                      "velocity": {"uniform": {"min": [-3, -3, -3], "max": [3, 3, 3], "seed": 6}}},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.05}],
        "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.6, "friction": 0.3},
                     {"type": "plane", "normal": [1, 0, 0], "offset": -1, "restitution": 1, "sweep": "line"},
                     {"type": "sphere", "center": [0, 0, 0], "radius": 3, "side": "inside", "restitution": 0.5}]})",
    R"({"format": "dvdx-scene/1", "name": "bodies", "step": 0.01, "duration": 2,
        "particles": {"count": 1000, "position": {"uniform": {"min": [-1, 0.1, -1], "max": [1, 2, 1], "seed": 12}}},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
        "motions": {"turn": {"keys": [{"time": 0}, {"time": 0.7, "rotation": [0, 2, 0.5]},
                                      {"time": 2, "translation": [0, 0.3, 0], "rotation": [0, 4, 1]}]}},
        "contacts": [{"type": "box", "center": [0, 1.2, 0], "half_extents": [1.3, 1.3, 1.3], "side": "inside", "friction": 0.2},
                     {"type": "box", "center": [0.4, 0.3, 0], "half_extents": [0.3, 0.2, 0.4], "rotation": [0.2, 0.4, 0],
                      "restitution": 0.4, "motion": "turn"},
                     {"type": "capsule", "ends": [[-0.6, 0.2, -0.4], [-0.2, 0.5, 0.4]], "radius": [0.1, 0.2], "thickness": 0.02,
                      "restitution": 0.3, "friction": 0.4, "motion": "turn", "push_out": 0.4},
                     {"type": "convex", "restitution": 0.2,
                      "planes": [{"normal": [0, -1, 0], "offset": 0}, {"normal": [1, 1, 0], "offset": 0.2},
                                 {"normal": [-1, 1, 0], "offset": 0.2}, {"normal": [0, 1, 1], "offset": 0.3},
                                 {"normal": [0, 1, -1], "offset": 0.3}]}]})",
    R"({"format": "dvdx-scene/1", "name": "radial springs", "step": 0.01, "duration": 4,
        "particles": {"count": 1000, "position": {"uniform": {"min": [-1, -1, -1], "max": [1, 1, 1], "seed": 7}}},
        "forces": [{"type": "radial_spring", "stiffness": 40, "damping": 0.1, "anchor": [0, 1, 0], "rest_length": 0.5},
                   {"type": "radial_spring", "stiffness": 5, "anchor": "start", "rest_length": 0.2, "method": "exact"},
                   {"type": "constant", "acceleration": [0, -9.81, 0]}]})",
    R"({"format": "dvdx-scene/1", "name": "separate methods", "step": 0.01, "duration": 4, "method": "average_acceleration",
        "particles": {"count": 1000, "position": {"uniform": {"min": [-1, -1, -1], "max": [1, 1, 1], "seed": 8}}},
        "forces": [{"type": "spring", "stiffness": 40, "damping": 0.5, "anchor": [0, 0, 0]},
                   {"type": "spring", "stiffness": 9, "anchor": [0.2, 0, 0], "method": "pulse"},
                   {"type": "drag", "coefficient": 0.3, "expansion": "first_order", "wind": [1, 0, 0]},
                   {"type": "sinusoid", "acceleration": [1, 0, 0], "angular_frequency": 3, "method": "symplectic_euler"}]})",
    R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.02, "duration": 2,
        "network": {"type": "grid", "rows": 61, "columns": 67, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                    "mass": 0.5, "structural": 40, "shear": 10, "bend": 1, "damping": 0.001, "fixed": "corners_top"},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.0005, "wind": [2, 0, 1]}],
        "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": -0.2, "friction": 0.3}]})",
    R"({"format": "dvdx-scene/1", "name": "sheet in sweeps", "step": 0.02, "duration": 2,
        "network": {"type": "grid", "rows": 61, "columns": 67, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                    "mass": 0.5, "structural": 400, "shear": 100, "bend": 10, "scheme": "sequential", "fixed": "edge_top"},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "sinusoid", "acceleration": [3, 0, 0], "angular_frequency": 5}]})",
    R"({"format": "dvdx-scene/1", "name": "two sheets", "step": 0.02, "duration": 2,
        "network": [{"type": "grid", "rows": 9, "columns": 17, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                     "mass": 0.5, "structural": 40, "shear": 10, "bend": 1, "scheme": "fourth_order", "fixed": "edge_top"},
                    {"type": "grid", "rows": 1, "columns": 30, "origin": [0, 0, 1], "edge_u": [2, 0, 0], "edge_v": [0, 0, 0],
                     "mass": 0.1, "structural": 90, "bend": 2, "scheme": "fourth_order"},
                    {"type": "springs", "pairs": [[140, 153], [152, 182], [145, 168]], "stiffness": {"values": [5, 50, 9]},
                     "rest_length": "start", "scheme": "fourth_order"}],
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})",
    R"({"format": "dvdx-scene/1", "name": "two sheets, swept", "step": 0.02, "duration": 2,
        "network": [{"type": "grid", "rows": 9, "columns": 17, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                     "mass": 0.5, "structural": 40, "shear": 10, "damping": 0.01, "scheme": "sequential", "fixed": "edge_top"},
                    {"type": "grid", "rows": 8, "columns": 8, "origin": [0, -1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                     "mass": 0.2, "structural": 90, "scheme": "sequential"}],
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
        "contacts": [{"type": "sphere", "center": [0.5, -1.5, 0.5], "radius": 0.4}]})",
    R"({"format": "dvdx-scene/1", "name": "pair by pair", "step": 0.01, "duration": 1,
        "network": {"type": "grid", "rows": 9, "columns": 17, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                    "mass": 0.5, "structural": 40, "shear": 10, "bend": 1, "scheme": "accumulate", "method": "average_acceleration",
                    "fixed": "edge_top"},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})",
    R"({"format": "dvdx-scene/1", "name": "grains", "step": 0.01, "duration": 0.15,
        "particles": {"count": 80,
                      "position": {"lattice": {"min": [0, 0.06, 0], "max": [0.35, 2, 0.35], "spacing": 0.105, "jitter": 0.002, "seed": 13}}},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
        "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.4},
                     {"type": "sphere", "center": [0.15, -0.1, 0.15], "radius": 0.12},
                     {"type": "box", "center": [0.16, 1, 0.16], "half_extents": [0.23, 1.2, 0.23], "side": "inside"}],
        "meet": {"radius": {"uniform": {"min": 0.03, "max": 0.05, "seed": 14}}, "restitution": 0.3, "friction": 0.4}})",
    R"({"format": "dvdx-scene/1", "name": "cloth on cloth", "step": 0.02, "duration": 0.2,
        "network": [{"type": "grid", "rows": 8, "columns": 9, "origin": [0, 0.002, 0], "edge_u": [0.08, 0, 0], "edge_v": [0, 0, 0.07],
                     "mass": 0.005, "structural": 50, "shear": 20, "damping": 0.002, "scheme": "sequential", "substeps": 4},
                    {"type": "grid", "rows": 8, "columns": 8, "origin": [0.01, 0.015, 0], "edge_u": [0.07, 0.01, 0.01], "edge_v": [-0.01, 0, 0.07],
                     "mass": 0.005, "structural": 50, "shear": 20, "damping": 0.002, "scheme": "sequential", "substeps": 4}],
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
        "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.4}],
        "meet": {"thickness": 0.009, "friction": 0.3}})",
    R"({"format": "dvdx-scene/1", "name": "coming and going", "step": 0.01, "duration": 1, "capacity": 20000,
        "particles": {"count": 1500, "position": {"uniform": {"min": [-1, 0, -1], "max": [1, 2, 1], "seed": 9}}},
        "emitters": [{"type": "disc", "center": [0, 0.1, 0], "normal": [0, 1, 0], "radius": 0.1, "rate": 40000,
                      "velocity": [0, 5, 0], "spread": 1, "lifetime": {"min": 0.1, "max": 0.5}, "seed": 10},
                     {"type": "box", "min": [-1, 1, -1], "max": [1, 2, 1], "rate": 7777.7, "spread": [1, 0, 1], "seed": 11}],
        "removal": {"boundaries": [{"normal": [1, 0, 0], "offset": -0.9}], "not_finite": "removed"},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.5, "wind": [2, 0, 0]}],
        "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.4}]})"};

struct VerifyOptions {
  std::vector<std::string> scenes;
  std::string arithmetic = "all";
  bool json = false;
};

std::vector<SceneFile> scenes_of(const VerifyOptions& options) {
  std::vector<SceneFile> scenes;
  const ReadOptions read{.scalar_bytes = sizeof(double)};
  for (const auto& path : options.scenes) scenes.push_back(read_scene(path, read));
  if (!scenes.empty()) return scenes;
  for (const char* text : built_in) scenes.push_back(parse_scene("built-in", text, read));
  return scenes;
}

std::uint64_t steps_of(const SceneFile& file) {
  const auto steps = steps_in(file.duration, file.step);
  if (!steps) throw Fault(Exit::bad_scene, fmt::format("{}: duration {}: must be {}", file.path, file.duration, steps.error()));
  return *steps;
}

std::string words(const Configuration& way) {
  const std::string block = way.block == 0 ? "the plan's own blocks" : fmt::format("blocks of {}", way.block);
  return fmt::format("{}, {} arithmetic, {}, {} thread{}, {}", name(way.isa), name(way.arithmetic),
                     name_in(layouts, way.layout), way.threads, way.threads == 1 ? "" : "s", block);
}

void print_difference(const Verdict& verdict) {
  const Difference& d = *verdict.first;
  const std::string twin = d.way.arithmetic == Arithmetic::fast ? "one thread over soa" : "the reference";
  print_answer(fmt::format("DIFFERENT    {}, {}: {}: particle {}, step {}, {}: {} has {}, this {}\n", printable(verdict.scene),
                           name_in(precisions, verdict.precision), words(d.way), d.particle, d.step, d.field, twin, d.reference,
                           d.value));
}

void print_far(const Verdict& verdict) {
  print_answer(fmt::format("FAR          {}, {}: fast arithmetic is {:.3g} ulp from separate after one step; at most {:.3g}\n",
                           printable(verdict.scene), name_in(precisions, verdict.precision), verdict.fast.first_ulps,
                           verdict.fast.bound()));
}

std::string ulps_text(const std::vector<Isa>& isas, double ulps) { return isas.empty() ? "-" : fmt::format("{:.3g}", ulps); }

std::string isas_text(const std::vector<Isa>& isas) { return isas.empty() ? "not run" : listed(isas); }

void print_table(const std::vector<Verdict>& verdicts) {
  print_answer(fmt::format("{:<18} {:<20} {:>22} {:>24} {:>6} {:>10} {:>16} {:>10}\n", "scene", "", "all: particles, steps",
                           "sample: particles, steps", "runs", "differing", "contracted, ulp", "fast, ulp"));
  std::size_t runs = 0;
  std::size_t differing = 0;
  for (const Verdict& v : verdicts) {
    print_answer(fmt::format("{:<18} {:<20} {:>12} x {:>7} {:>14} x {:>7} {:>6} {:>10} {:>16} {:>10}\n", printable(v.scene),
                             name_in(precisions, v.precision), v.particles, v.steps, v.sample, v.sample_steps, v.runs,
                             v.differing, ulps_text(v.contracted.isas, v.contracted.ulps),
                             ulps_text(v.fast.isas, v.fast.ulps)));
    runs += v.runs;
    differing += v.differing;
  }
  const Verdict& front = verdicts.front();
  print_answer(
      fmt::format("separate     {}; contracted {}; fast {}; layouts soa, aos, aosoa; 1, 2, 3, 5 threads; 5 block sizes\n",
                  isas_text(front.isas), isas_text(front.contracted.isas), isas_text(front.fast.isas)));
  std::size_t far = 0;
  for (const Verdict& v : verdicts) {
    if (v.first) print_difference(v);
    if (v.fast.is_near()) continue;
    print_far(v);
    ++far;
  }
  print_answer(differing != 0 ? fmt::format("FAILED       {} numbers differ in {} runs\n", differing, runs)
               : far != 0     ? fmt::format("FAILED       fast arithmetic is far from separate in {} scenes\n", far)
                              : fmt::format("same bits    in all {} runs\n", runs));
}

std::vector<std::string> names_of_isas(const std::vector<Isa>& isas) {
  std::vector<std::string> names;
  for (const Isa isa : isas) names.emplace_back(name(isa));
  return names;
}

nlohmann::ordered_json json_of(const Difference& d) {
  return {{"isa", name(d.way.isa)},
          {"arithmetic", name(d.way.arithmetic)},
          {"layout", name_in(layouts, d.way.layout)},
          {"threads", d.way.threads},
          {"block", d.way.block},
          {"particle", d.particle},
          {"step", d.step},
          {"field", d.field},
          {"reference", d.reference},
          {"value", d.value}};
}

nlohmann::ordered_json json_of(const Verdict& v) {
  nlohmann::ordered_json json = {{"scene", v.scene},
                                 {"precision", name_in(precisions, v.precision)},
                                 {"particles", v.particles},
                                 {"steps", v.steps},
                                 {"sample", {{"particles", v.sample}, {"steps", v.sample_steps}}},
                                 {"isas", names_of_isas(v.isas)},
                                 {"runs", v.runs},
                                 {"differing", v.differing},
                                 {"first_difference", nullptr},
                                 {"contracted", {{"isas", names_of_isas(v.contracted.isas)}, {"ulps", v.contracted.ulps}}},
                                 {"fast",
                                  {{"isas", names_of_isas(v.fast.isas)},
                                   {"ulps", v.fast.ulps},
                                   {"first_step", {{"ulps", v.fast.first_ulps}, {"at_most", v.fast.bound()}}}}}};
  if (v.first) json["first_difference"] = json_of(*v.first);
  return json;
}

void print_verdicts_json(const std::vector<Verdict>& verdicts, bool passed) {
  nlohmann::ordered_json json = {{"passed", passed}, {"scenes", nlohmann::ordered_json::array()}};
  for (const Verdict& verdict : verdicts) json["scenes"].push_back(json_of(verdict));
  print_json(json.dump(2) + "\n");
}

Exit verify(const VerifyOptions& options) {
  const auto scenes = scenes_of(options);
  std::optional<Arithmetic> only;
  if (options.arithmetic != "all") only = named(arithmetics, options.arithmetic);
  std::vector<Verdict> verdicts;
  {
    Progress progress(precisions.size() * scenes.size());
    for (const SceneFile& scene : scenes) {
      for (const auto& precision : precisions) {
        if (is_live(scene) && rounding_of(precision.value) == Rounding::compensated) continue;  // live scenes never are
        const auto verify_one = is_live(scene) ? verify_live : verify_scene;
        verdicts.push_back(verify_one(scene, steps_of(scene), precision.value, only));
        progress.at(verdicts.size());
      }
    }
  }
  const bool passed = std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.passed(); });
  if (options.json) {
    print_verdicts_json(verdicts, passed);
  } else {
    print_table(verdicts);
  }
  return passed ? Exit::done : Exit::verification_failed;
}

}  // namespace

void add_verify(CLI::App& app, Exit& exit) {
  auto options = std::make_shared<VerifyOptions>();
  auto* command =
      app.add_subcommand("verify", "Hold every instruction set, layout, thread count and block against the reference");
  command->footer("dvdx verify tools/scenes/*.json");
  command->add_option("SCENE", options->scenes, "scene files (JSON); a built-in set where none is given");
  auto names = names_of(arithmetics);
  names.emplace_back("all");
  command
      ->add_option("--arithmetic", options->arithmetic,
                   "one alone; fast is held by bounds, against the same instruction set bit by bit")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &exit] { exit = verify(*options); });
}

}  // namespace dvdx::tool
