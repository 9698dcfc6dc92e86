#include "tune/words.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/json_text.hpp"
#include "scene_io/names.hpp"
#include "scene_io/overrides.hpp"
#include "scene_io/seeds.hpp"

namespace dvdx::tool::tune {
namespace {

using Setting = std::pair<std::string, std::string>;  // path and value

bool is_accumulate(const Candidate& candidate) {
  return candidate.coupling && candidate.coupling->scheme == Scheme::accumulate;
}

// The settings by which a candidate differs from a scene with defaults only, without step and precision.
std::vector<Setting> settings_of(const SceneOptions& options, const SceneFile& file, const Candidate& candidate) {
  std::vector<Setting> settings{{"method", std::string(word(candidate.method))}};
  for (std::size_t n = 0; n < file.scene.forces.size(); ++n) {
    const auto& force = file.scene.forces[n];
    const auto path = fmt::format("forces[{}].", n);
    if (std::visit([](const auto& each) { return each.method.has_value(); }, force)) {
      settings.emplace_back(path + "method", word(candidate.method));
    }
    const auto* drag = std::get_if<Drag>(&force);
    if (drag != nullptr && drag->expansion != candidate.expansion) {
      settings.emplace_back(path + "expansion", word(candidate.expansion));
    }
  }
  if (!candidate.coupling) return settings;
  const auto& coupling = *candidate.coupling;
  for (const auto& path : network_paths(options)) {
    settings.emplace_back(path + ".scheme", word(coupling.scheme));
    settings.emplace_back(path + ".substeps", std::to_string(candidate.substeps()));
    if (coupling.scheme == Scheme::sequential) {
      if (coupling.theta) settings.emplace_back(path + ".theta", fmt::format("{}", *coupling.theta));
      settings.emplace_back(path + ".sweep", word(coupling.sweeps));
    }
    if (is_accumulate(candidate)) {
      settings.emplace_back(path + ".method", word(coupling.method));
      settings.emplace_back(path + ".axis", word(coupling.axis));
    }
  }
  return settings;
}

// Returns true if --method, --scheme or --substeps is a shorter way to set the path.
bool has_option(const std::string& path) {
  return path.ends_with("method") || path.ends_with(".scheme") || path.ends_with(".substeps");
}

nlohmann::json json_of(const SceneOptions& options) {
  const auto text = read_file(options.scene, scene_limit);
  if (!text) throw Fault(Exit::input_output, options.scene + ": " + text.error());
  auto root = parse_json(options.scene, *text);
  for (const auto& assignment : options.overrides) apply_override(root, options.scene, assignment);
  return root;
}

bool is_number(const std::string& text) { return text.find_first_not_of("0123456789.e-+") == std::string::npos; }

}  // namespace

std::vector<std::string> network_paths(const SceneOptions& options) {
  const auto root = json_of(options);
  if (!root.contains("network")) return {};
  if (!root["network"].is_array()) return {"network"};
  std::vector<std::string> paths;
  for (std::size_t n = 0; n < root["network"].size(); ++n) paths.push_back(fmt::format("network[{}]", n));
  return paths;
}

std::size_t seeds_in(const SceneOptions& options) { return count_seeds(json_of(options)); }

std::vector<std::string> run_options(const SceneOptions& options, const SceneFile& file, const Candidate& candidate) {
  std::vector<std::string> words{options.scene};
  const auto add = [&](const std::string& option, const std::string& value) {
    words.push_back(option);
    words.push_back(value);
  };
  for (const auto& assignment : options.overrides) add("--set", assignment);
  if (options.seed) add("--seed", std::to_string(*options.seed));
  if (options.duration) add("--duration", fmt::format("{}", *options.duration));
  add("--step", fmt::format("{}", candidate.step));
  add("--precision", std::string(name_in(precisions, candidate.precision)));
  // Pairs with their own method would lose it to --method.
  const bool by_options = !is_accumulate(candidate);
  if (by_options) add("--method", std::string(word(candidate.method)));
  if (by_options && candidate.coupling) {
    add("--scheme", std::string(word(candidate.coupling->scheme)));
    add("--substeps", std::to_string(candidate.substeps()));
  }
  for (const auto& [path, value] : settings_of(options, file, candidate)) {
    if (!by_options || !has_option(path)) add("--set", path + "=" + value);
  }
  return words;
}

std::vector<std::string> scene_lines(const SceneOptions& options, const SceneFile& file, const Candidate& candidate) {
  std::vector<std::string> lines{fmt::format("\"step\": {}", candidate.step)};
  for (const auto& [path, value] : settings_of(options, file, candidate)) {
    const auto dot = path.rfind('.');
    const auto key = dot == std::string::npos ? path : path.substr(dot + 1);
    const auto line = fmt::format("\"{}\": {}", key, is_number(value) ? value : '"' + value + '"');
    lines.push_back(dot == std::string::npos ? line : fmt::format("{}: {}", path.substr(0, dot), line));
  }
  return lines;
}

}  // namespace dvdx::tool::tune
