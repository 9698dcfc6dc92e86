#include "scene_io/fields.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene_io/fault.hpp"
#include "scene_io/json_text.hpp"

namespace dvdx::tool {
namespace {

// Levenshtein's distance: insertions, deletions and substitutions.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

std::string listed(std::span<const std::string_view> words) {
  std::string text;
  for (const auto word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

}  // namespace

std::string one_of(std::span<const std::string_view> names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += '"' + std::string(names[i]) + '"';
  }
  return text;
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> known) {
  const auto distance = [&](std::string_view other) { return edit_distance(word, other); };
  const auto best = std::min_element(known.begin(), known.end(), [&](auto a, auto b) { return distance(a) < distance(b); });
  const bool close = best != known.end() && distance(*best) <= std::max<std::size_t>(2, best->size() / 3);
  return close ? *best : std::string_view{};
}

Node Node::at(const std::string& key) const { return {(*value_)[key], path_.empty() ? key : path_ + "." + key, *file_}; }

Node Node::at(std::size_t index) const { return {(*value_)[index], path_ + "[" + std::to_string(index) + "]", *file_}; }

std::vector<Node> Node::elements(std::string_view valid) const {
  if (!value_->is_array()) refuse(valid);
  std::vector<Node> nodes;
  nodes.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) nodes.push_back(at(i));
  return nodes;
}

void Node::fail(std::string_view what) const {
  throw Fault(Exit::bad_scene, *file_ + ": " + (path_.empty() ? "the scene" : path_) + " " + std::string(what));
}

void Node::refuse(std::string_view valid) const { fail("is " + shown(*value_) + ": must be " + std::string(valid)); }

double Node::number(const Range& range) const {
  if (!value_->is_number() || !range.holds(value_->get<double>())) refuse(range.in_file);
  return value_->get<double>();
}

// 3 and 3.0 are the same number to JSON.
std::uint64_t Node::whole(std::uint64_t min, std::uint64_t max) const {
  const std::string valid = "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  if (!value_->is_number()) refuse(valid);
  std::uint64_t whole = 0;
  if (value_->is_number_unsigned()) {
    whole = value_->get<std::uint64_t>();
  } else {
    const auto number = value_->get<double>();
    if (!(number >= 0 && number < 0x1p64) || number != std::floor(number)) refuse(valid);
    whole = static_cast<std::uint64_t>(number);
  }
  if (whole < min || whole > max) refuse(valid);
  return whole;
}

std::string Node::text() const {
  if (!value_->is_string()) refuse("a string");
  return value_->get<std::string>();
}

std::array<double, 3> Node::vector(const Range& range) const {
  if (!value_->is_array() || value_->size() != 3) refuse("a list of 3 numbers");
  return {at(0).number(range), at(1).number(range), at(2).number(range)};
}

Node Node::type_for(std::string_view what) const {
  if (!json().is_object()) refuse("an object");
  if (json().contains("type")) return at("type");
  throw Fault(Exit::bad_scene, file() + ": " + path() + ".type is missing: a " + std::string(what) + " needs it");
}

std::array<double, 3> Node::direction() const {
  const auto direction = vector();
  if (direction == std::array<double, 3>{}) refuse("a vector that is not zero");
  return direction;
}

std::size_t Node::choice(std::span<const std::string_view> names) const {
  const auto valid = one_of(names);
  if (!value_->is_string()) refuse(valid);
  const auto found = std::find(names.begin(), names.end(), value_->get_ref<const std::string&>());
  if (found == names.end()) refuse(valid);
  return static_cast<std::size_t>(found - names.begin());
}

Fields::Fields(const Node& node, std::string_view what, std::vector<std::string_view> known) : node_(node), what_(what) {
  if (!node.json().is_object()) node.refuse("an object with the keys " + listed(known));
  for (const auto& item : node.json().items()) {
    if (std::find(known.begin(), known.end(), item.key()) != known.end()) continue;
    const auto close = nearest(item.key(), known);
    node.at(item.key())
        .fail("is not a key of " + what_ + ": " + (close.empty() ? "" : "did you mean " + std::string(close) + "? ") +
              "Known are " + listed(known));
  }
}

Node Fields::required(const std::string& key) const {
  if (const auto field = optional(key)) return *field;
  const std::string path = node_.path().empty() ? key : node_.path() + "." + key;
  throw Fault(Exit::bad_scene, node_.file() + ": " + path + " is missing: " + what_ + " needs it");
}

std::optional<Node> Fields::optional(const std::string& key) const {
  if (!node_.json().contains(key)) return std::nullopt;
  return node_.at(key);
}

double Fields::number(const std::string& key, const Range& range, double otherwise) const {
  const auto field = optional(key);
  return field ? field->number(range) : otherwise;
}

std::array<double, 3> Fields::vector(const std::string& key, const std::array<double, 3>& otherwise) const {
  const auto field = optional(key);
  return field ? field->vector() : otherwise;
}

}  // namespace dvdx::tool
