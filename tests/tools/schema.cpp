#include "tools/schema.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <stdexcept>

namespace dvdx::test {
namespace {

using nlohmann::json;
using Check = std::function<bool(const json& argument, const json& value)>;

bool is_type(const std::string& type, const json& value) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number_integer() || (value.is_number() && std::floor(value.get<double>()) == value);
  throw std::invalid_argument("schema type " + type);
}

bool all_different(const json& list) { return std::set<json>(list.begin(), list.end()).size() == list.size(); }

bool has_all(const json& keys, const json& value) {
  return std::all_of(keys.begin(), keys.end(), [&](const json& key) { return value.contains(key.get<std::string>()); });
}

// A keyword accepts values of every kind other than its own.
const std::map<std::string, Check>& checks() {
  static const std::map<std::string, Check> table{
      {"type", [](const json& a, const json& v) { return is_type(a, v); }},
      {"const", [](const json& a, const json& v) { return a == v; }},
      {"enum", [](const json& a, const json& v) { return std::find(a.begin(), a.end(), v) != a.end(); }},
      {"required", [](const json& a, const json& v) { return !v.is_object() || has_all(a, v); }},
      {"dependentRequired",
       [](const json& a, const json& v) {
         return std::all_of(a.items().begin(), a.items().end(), [&](const auto& item) {
           return !v.is_object() || !v.contains(item.key()) || has_all(item.value(), v);
         });
       }},
      {"minItems", [](const json& a, const json& v) { return !v.is_array() || v.size() >= a.get<std::size_t>(); }},
      {"maxItems", [](const json& a, const json& v) { return !v.is_array() || v.size() <= a.get<std::size_t>(); }},
      {"uniqueItems", [](const json& a, const json& v) { return !v.is_array() || !a.get<bool>() || all_different(v); }},
      {"minimum", [](const json& a, const json& v) { return !v.is_number() || v >= a; }},
      {"maximum", [](const json& a, const json& v) { return !v.is_number() || v <= a; }},
      {"exclusiveMinimum", [](const json& a, const json& v) { return !v.is_number() || v > a; }},
      {"exclusiveMaximum", [](const json& a, const json& v) { return !v.is_number() || v < a; }},
      {"pattern", [](const json& a, const json& v) {
         return !v.is_string() || std::regex_search(v.get<std::string>(), std::regex(a.get<std::string>()));
       }}};
  return table;
}

bool is_remark(const std::string& keyword) {
  static const std::set<std::string> remarks{"$schema", "$id", "$defs", "title", "description"};
  return remarks.contains(keyword);
}

}  // namespace

bool Schema::accepts(const json& schema, const json& value) const {
  for (const auto& item : schema.items()) {
    if (!is_remark(item.key()) && !accepts_keyword(item.key(), schema, value)) return false;
  }
  return true;
}

bool Schema::accepts_keyword(const std::string& keyword, const json& schema, const json& value) const {
  const auto& argument = schema[keyword];
  const auto count = [&] {
    return std::count_if(argument.begin(), argument.end(), [&](const json& s) { return accepts(s, value); });
  };
  if (keyword == "$ref") return accepts(root_[json::json_pointer(argument.get<std::string>().substr(1))], value);
  if (keyword == "oneOf") return count() == 1;
  if (keyword == "anyOf") return count() >= 1;
  if (keyword == "items") {
    return !value.is_array() || std::all_of(value.begin(), value.end(), [&](const json& v) { return accepts(argument, v); });
  }
  if (keyword == "properties") {
    if (!value.is_object()) return true;
    return std::all_of(argument.items().begin(), argument.items().end(), [&](const auto& item) {
      return !value.contains(item.key()) || accepts(item.value(), value[item.key()]);
    });
  }
  if (keyword == "additionalProperties") {
    if (!value.is_object()) return true;
    const json known = schema.value("properties", json::object());
    return std::all_of(value.items().begin(), value.items().end(), [&](const auto& item) {
      return known.contains(item.key()) || (argument.is_object() && accepts(argument, item.value()));
    });
  }
  const auto check = checks().find(keyword);
  if (check == checks().end()) throw std::invalid_argument("schema keyword " + keyword);
  return check->second(argument, value);
}

}  // namespace dvdx::test
