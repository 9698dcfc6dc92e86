// The part of JSON Schema that tools/scene.schema.json uses. An unknown keyword is an error, so that the schema cannot contain
// a rule that nothing checks.
#pragma once

#include <nlohmann/json.hpp>

namespace dvdx::test {

class Schema {
 public:
  explicit Schema(nlohmann::json root) : root_(std::move(root)) {}
  [[nodiscard]] bool accepts(const nlohmann::json& value) const { return accepts(root_, value); }

 private:
  [[nodiscard]] bool accepts(const nlohmann::json& schema, const nlohmann::json& value) const;
  [[nodiscard]] bool accepts_keyword(const std::string& keyword, const nlohmann::json& schema,
                                     const nlohmann::json& value) const;

  nlohmann::json root_;
};

// A scene with another value at a JSON pointer. value: JSON, or null, which removes the key.
inline nlohmann::json with_value(const char* scene, const char* where, const char* value) {
  nlohmann::json changed = nlohmann::json::parse(scene);
  const nlohmann::json::json_pointer at(where);
  if (value != nullptr) {
    changed[at] = nlohmann::json::parse(value);
  } else {
    changed[at.parent_pointer()].erase(at.back());
  }
  return changed;
}

}  // namespace dvdx::test
