#include "scene_io/overrides.hpp"

#include <charconv>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>
#include <vector>

#include "scene_io/fault.hpp"
#include "scene_io/json_text.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;
using Part = std::variant<std::string, std::size_t>;  // a key or an index

[[noreturn]] void misuse(const std::string& assignment, const std::string& what) {
  throw Fault(Exit::usage, "--set " + assignment + ": " + what);
}

// forces[2].stiffness -> "forces", 2, "stiffness"
std::vector<Part> parts_of(const std::string& assignment, std::string_view path) {
  constexpr const char* form = "must be path=value, such as forces[0].stiffness=40";
  std::vector<Part> parts;
  while (!path.empty()) {
    if (path.front() == '[') {
      std::size_t index = 0;
      const auto [end, error] = std::from_chars(path.data() + 1, path.data() + path.size(), index);
      if (error != std::errc{} || end == path.data() + path.size() || *end != ']' || parts.empty()) misuse(assignment, form);
      parts.emplace_back(index);
      path.remove_prefix(static_cast<std::size_t>(end - path.data()) + 1);
    } else {
      if (!parts.empty()) {
        if (path.front() != '.') misuse(assignment, form);
        path.remove_prefix(1);
      }
      const auto key = path.substr(0, path.find_first_of(".["));
      if (key.empty()) misuse(assignment, form);
      parts.emplace_back(std::string(key));
      path.remove_prefix(key.size());
    }
  }
  if (parts.empty()) misuse(assignment, form);
  return parts;
}

json value_of(const std::string& assignment, const std::string& text) {
  try {
    return parse_json("--set " + assignment, text);
  } catch (const Fault& fault) {
    const bool meant_as_json = !text.empty() && std::string_view("{[\"").find(text.front()) != std::string_view::npos;
    if (meant_as_json) throw Fault(Exit::usage, fault.what());
    return text;
  }
}

struct Walk {
  const std::string& file;
  std::string path{};

  [[noreturn]] void fail(const std::string& what) const {
    throw Fault(Exit::bad_scene, file + ": " + path + " (from --set) " + what);
  }

  json& into(json& value, const Part& part, bool is_last) {
    const auto* key = std::get_if<std::string>(&part);
    return key != nullptr ? into_key(value, *key, is_last) : into_index(value, std::get<std::size_t>(part));
  }

  json& into_key(json& value, const std::string& key, bool is_last) {
    path += (path.empty() ? "" : ".") + key;
    if (!value.is_object() || (!is_last && !value.contains(key))) fail("is not in the scene");
    return value[key];
  }

  json& into_index(json& value, std::size_t index) {
    path += "[" + std::to_string(index) + "]";
    if (!value.is_array() || index >= value.size()) fail("is not in the scene");
    return value[index];
  }
};

}  // namespace

void apply_override(json& scene, const std::string& file, const std::string& assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos) misuse(assignment, "must be path=value, such as forces[0].stiffness=40");
  const auto parts = parts_of(assignment, std::string_view(assignment).substr(0, equals));
  json value = value_of(assignment, assignment.substr(equals + 1));
  Walk walk{file};
  json* at = &scene;
  for (std::size_t i = 0; i < parts.size(); ++i) at = &walk.into(*at, parts[i], i + 1 == parts.size());
  *at = std::move(value);
}

}  // namespace dvdx::tool
