// The fields described by dvdx/fields.hpp, compared with the schema of scenes, the docs and Python.
#include "dvdx/fields.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "scene/text.hpp"
#include "support/paths.hpp"

namespace fields_test {

using namespace dvdx;
using Json = nlohmann::ordered_json;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// ---- the schema

Json number(const Range& range, const char* type = "number") {
  const auto bound = [](double value) { return std::floor(value) == value ? Json(std::llround(value)) : Json(value); };
  Json schema{{"type", type}};
  if (range.min > std::numeric_limits<double>::lowest()) {
    schema[range.least == Range::Least::included ? "minimum" : "exclusiveMinimum"] = bound(range.min);
  }
  if (range.max < std::numeric_limits<double>::max()) schema["maximum"] = bound(range.max);
  return schema;
}

Json reference(const std::string& to) { return {{"$ref", "#/$defs/" + to}}; }

Json list(const Json& items, std::size_t least, std::size_t most) {
  return {{"type", "array"}, {"items", items}, {"minItems", least}, {"maxItems", most}};
}

template <class T>
struct Type {};
template <class T>
Json schema_of(Type<std::optional<T>>, const Range& range) {
  return schema_of(Type<T>(), range);
}
template <class E>
requires std::is_enum_v<E> Json schema_of(Type<E>, const Range&) { return {{"enum", words<E>}}; }
Json schema_of(Type<Method>, const Range&) { return reference("method"); }
Json schema_of(Type<double>, const Range& range) { return number(range); }
Json schema_of(Type<int>, const Range& range) { return number(range, "integer"); }
Json schema_of(Type<std::size_t>, const Range&) { return {{"type", "string"}}; }
Json schema_of(Type<Scalars>, const Range&) { return reference("scalars"); }
Json schema_of(Type<PerAxis>, const Range&) { return reference("per_axis"); }
Json schema_of(Type<Anchor>, const Range&) { return reference("anchor"); }
Json schema_of(Type<Vec3>, const Range& range) {
  return number(range) == number({}) ? reference("vector") : list(number(range), 3, 3);
}
Json schema_of(Type<std::array<Vec3, 2>>, const Range&) { return list(reference("vector"), 2, 2); }
Json schema_of(Type<std::array<double, 2>>, const Range& range) {
  return {{"oneOf", {number(range), list(number(range), 2, 2)}}};
}
Json schema_of(Type<std::vector<Vec3>>, const Range&) { return list(reference("vector"), 1, 8); }

void set_required(Json& object, std::string_view name, bool is_required) {
  Json& all = object["required"];
  const auto found = std::find(all.begin(), all.end(), name);
  if (is_required && found == all.end()) all.push_back(name);
  if (!is_required && found != all.end()) all.erase(found);
}

template <class Struct>
void set_fields(Json& object);
template <class Struct, class Element>
requires requires(const Element* element) { describe(element); }
void set_field(Json& object, const Field<Struct, std::vector<Element>>& field) {
  set_fields<Element>(object["properties"][std::string(field.name)]["items"]);
}
template <class Struct, class Value>
void set_field(Json& object, const Field<Struct, Value>& field) {
  Json schema = field.about.empty() ? Json::object() : Json{{"description", field.about}};
  schema.update(schema_of(Type<Value>(), field.range));
  object["properties"][std::string(field.name)] = schema;
  if (object.contains("required")) set_required(object, field.name, field.is_required);
}
template <class Struct>
void set_field(Json& object, const Normal<Struct>& field) {
  object["properties"][std::string(field.name)] = reference("vector");
  set_required(object, field.name, true);
}
void set_field(Json& object, const OnlyWord& field) { object["properties"][std::string(field.name)] = {{"const", field.word}}; }
void set_field(Json& object, const Key& key) { CHECK(object["properties"].contains(std::string(key.name))); }

template <class Struct>
void set_fields(Json& object) {
  if (!description<Struct>.type.empty()) object["properties"]["type"] = {{"const", description<Struct>.type}};
  for_each_field<Struct>([&](const auto& field) { set_field(object, field); });
}
template <class... Structs>
void set_types(std::variant<Structs...>*, Json& schema) {
  std::size_t k = 0;
  (set_fields<Structs>(schema["oneOf"][k++]), ...);
}

std::string flat(const Json& json) {
  if (!json.is_structured()) return json.dump();
  std::string text;
  for (const auto& [key, value] : json.items()) {
    text += (text.empty() ? "" : ", ") + (json.is_object() ? Json(key).dump() + ": " : "") + flat(value);
  }
  return json.is_object() ? "{" + text + "}" : "[" + text + "]";
}

// Packs as many one-line members as fit into a line of 128 columns.
std::string laid_out(const Json& json, std::size_t indent, std::size_t column) {
  constexpr std::size_t width = 128;
  const std::string whole = flat(json);
  if (column + whole.size() < width || !json.is_structured()) return whole;
  std::vector<std::string> lines;
  for (const auto& [key, value] : json.items()) {
    const std::string name = json.is_object() ? Json(key).dump() + ": " : "";
    const std::string member = name + laid_out(value, indent + 2, indent + 2 + name.size());
    const bool fits = !lines.empty() && (lines.back() + member).find('\n') == std::string::npos;
    if (fits && lines.back().size() + member.size() + 2 < width) {
      lines.back() += ", " + member;
    } else {
      lines.push_back(std::string(indent + 2, ' ') + member);
    }
  }
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "\n" : ",\n") + line;
  text += "\n" + std::string(indent, ' ');
  return json.is_object() ? "{" + text + "}" : "[" + text + "]";
}

TEST_CASE("the schema of scenes follows the described fields; a failure writes it to scene.schema.json") {
  const std::string text = text_of(dvdx::test::schema());
  Json schema = Json::parse(text);
  Json& definitions = schema["$defs"];
  Json& scene = schema["properties"];
  set_types(static_cast<Force*>(nullptr), definitions["force"]);
  set_types(static_cast<Contact*>(nullptr), definitions["contact"]);
  set_fields<Aerodynamics>(definitions["aerodynamics"]);
  set_fields<Grid>(definitions["network"]["oneOf"][0]);
  set_fields<MotionKey>(scene["motions"]["additionalProperties"]["properties"]["keys"]["items"]);
  set_fields<Wind>(scene["wind"]["oneOf"][1]);
  for (Json& emitter : definitions["emitter"]["oneOf"]) set_fields<Emitter>(emitter);
  for (Json& network : definitions["network"]["oneOf"]) set_fields<Coupling>(network);
  set_fields<Removal>(scene["removal"]);
  set_fields<Tethers>(scene["tethers"]["items"]);
  set_fields<Meet>(scene["meet"]);
  const std::string wanted = laid_out(schema, 0, 0) + "\n";
  CHECK((text == wanted));
  if (text != wanted) std::ofstream("scene.schema.json") << wanted;
}

// ---- docs and Python: every name, and every number that stands where none is given

template <class Struct, class Look>
void look_for_fields(const Look& look) {
  for_each_field<Struct>([&](const auto& field) {
    if constexpr (requires { field.range; }) {
      std::string otherwise;
      if constexpr (requires { text(Struct{}.*field.value); }) {
        if (!field.is_required) otherwise = text(Struct{}.*field.value);
      }
      CAPTURE(description<Struct>.name);
      look(std::string(description<Struct>.type), std::string(field.name), otherwise);
    }
  });
}
template <class... Structs, class Look>
void look_for_types(std::variant<Structs...>* /*of*/, const Look& look) {
  (look_for_fields<Structs>(look), ...);
}

TEST_CASE("docs/scene.md has each field of forces and contacts, with its default") {
  const std::string docs = text_of(std::filesystem::path(dvdx::test::schema()).parent_path() / "../docs/scene.md");
  const auto look = [&](const std::string& /*type*/, const std::string& name, const std::string& otherwise) {
    const std::string words = "`" + name + "`" + (otherwise.empty() ? "" : " (" + otherwise);
    CHECK_MESSAGE(docs.find(words) != std::string::npos, words);
  };
  look_for_types(static_cast<Force*>(nullptr), look);
  look_for_types(static_cast<Contact*>(nullptr), look);
}

TEST_CASE("Python's methods have each field of forces and contacts, with its default") {
  const std::string python = text_of(std::filesystem::path(dvdx::test::schema()).parent_path() / "python/dvdx/__init__.py");
  const auto look = [&](const std::string& type, const std::string& name, const std::string& otherwise) {
    const std::size_t begin = python.find("def " + type + "(");
    const std::string method = python.substr(begin, python.find(") -> Scene", begin) - begin);
    const std::string words = name + ": " + (otherwise.empty() || otherwise[0] == '[' ? "" : "float = " + otherwise);
    CHECK_MESSAGE((method.find(words) != std::string::npos || name == "motion"), words);  // contact_motion() gives it
  };
  look_for_types(static_cast<Force*>(nullptr), look);
  look_for_types(static_cast<Contact*>(nullptr), look);
}

}  // namespace fields_test
