// A cursor over a scene's JSON that knows its path, and the checks that every key goes through.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dvdx/fields.hpp"

namespace dvdx::tool {

template <class E>
struct Named {
  std::string_view name;
  E value;
};

// "a", "b" or "c"
[[nodiscard]] std::string one_of(std::span<const std::string_view> names);
[[nodiscard]] std::string_view nearest(std::string_view word, std::span<const std::string_view> known);

class Node {
 public:
  Node(const nlohmann::json& value, std::string path, const std::string& file)
      : value_(&value), path_(std::move(path)), file_(&file) {}

  [[nodiscard]] const nlohmann::json& json() const noexcept { return *value_; }
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] const std::string& file() const noexcept { return *file_; }

  [[nodiscard]] Node at(const std::string& key) const;
  [[nodiscard]] Node at(std::size_t index) const;
  [[nodiscard]] std::vector<Node> elements(std::string_view valid) const;
  // Returns the key `type` of an object, on which its other keys depend. what: the thing that it describes, such as "force".
  [[nodiscard]] Node type_for(std::string_view what) const;

  // "<file>: <path> is <value>: must be <valid>"
  [[noreturn]] void refuse(std::string_view valid) const;
  // "<file>: <path> <what>"
  [[noreturn]] void fail(std::string_view what) const;

  [[nodiscard]] double number(const Range& range = Range::finite) const;
  [[nodiscard]] std::uint64_t whole(std::uint64_t min, std::uint64_t max) const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::array<double, 3> vector(const Range& range = Range::finite) const;
  [[nodiscard]] std::array<double, 3> direction() const;                            // a vector that is not zero
  [[nodiscard]] std::size_t choice(std::span<const std::string_view> names) const;  // the index of the name

  template <class E, std::size_t N>
  [[nodiscard]] E choice(const std::array<Named<E>, N>& table) const {
    std::array<std::string_view, N> names;
    for (std::size_t i = 0; i < N; ++i) names[i] = table[i].name;
    return table[choice(std::span<const std::string_view>(names))].value;
  }

 private:
  const nlohmann::json* value_;
  std::string path_;
  const std::string* file_;
};

// An object whose keys are all known. `what` is the thing it describes, with its article: "a spring".
class Fields {
 public:
  Fields(const Node& node, std::string_view what, std::vector<std::string_view> known);

  [[nodiscard]] Node required(const std::string& key) const;
  [[nodiscard]] std::optional<Node> optional(const std::string& key) const;

  [[nodiscard]] double number(const std::string& key, const Range& range, double otherwise) const;
  [[nodiscard]] std::array<double, 3> vector(const std::string& key, const std::array<double, 3>& otherwise) const;

  template <class E, std::size_t N>
  [[nodiscard]] E choice(const std::string& key, const std::array<Named<E>, N>& table, E otherwise) const {
    const auto field = optional(key);
    return field ? field->choice(table) : otherwise;
  }

  [[nodiscard]] const Node& node() const noexcept { return node_; }

 private:
  Node node_;
  std::string what_;
};

}  // namespace dvdx::tool
