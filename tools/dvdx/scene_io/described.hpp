// Structs of a scene that dvdx/fields.hpp describes, read from a scene file.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/fields.hpp"
#include "scene_io/fields.hpp"
#include "scene_io/motion_reader.hpp"
#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

// Returns the fields of a struct in a scene file. Unknown keys are refused.
template <class Struct>
[[nodiscard]] Fields fields_of(const Node& node) {
  std::vector<std::string_view> keys;
  if (!description<Struct>.type.empty()) keys.emplace_back("type");
  for_each_field<Struct>([&](const auto& field) { keys.push_back(field.name); });
  return {node, description<Struct>.name, std::move(keys)};
}

// Reads values by the types of their fields. population, motions: those that values may name; null if a struct names none.
struct DescribedReader {
  const Population* population = nullptr;
  const MotionNames* motions = nullptr;

  template <class Struct>
  [[nodiscard]] Struct read(const Node& node) const {
    Struct made;
    read_fields(fields_of<Struct>(node), made);
    return made;
  }
  // Reads the alternative that the key `type` names. what: the thing that it describes, such as "force".
  template <class Variant>
  [[nodiscard]] Variant read_one_of(const Node& node, std::string_view what) const {
    Variant made;
    const std::size_t type = node.type_for(what).choice(type_words<Variant>);
    [&]<std::size_t... k>(std::index_sequence<k...> /*alternatives*/) {
      ((k == type ? void(made = read<std::variant_alternative_t<k, Variant>>(node)) : void()), ...);
    }
    (std::make_index_sequence<std::variant_size_v<Variant>>());
    return made;
  }
  // Reads all fields except those that are a Key.
  template <class Struct>
  void read_fields(const Fields& fields, Struct& to) const {
    for_each_field<Struct>([&](const auto& field) { read_field(fields, field, to); });
  }

 private:
  template <class Struct, class Value>
  void read_field(const Fields& fields, const Field<Struct, Value>& field, Struct& to) const {
    const std::string name(field.name);
    if (const auto node = field.is_required ? fields.required(name) : fields.optional(name)) {
      value(*node, field.range, to.*field.value);
    }
  }
  template <class Struct>
  void read_field(const Fields& fields, const Normal<Struct>& field, Struct& to) const {
    to.*field.value = unit_vector(fields.required(std::string(field.name)));
  }
  template <class Struct>
  void read_field(const Fields& fields, const OnlyWord& field, Struct& /*to*/) const {
    if (const auto node = fields.optional(std::string(field.name))) (void)node->choice(std::span(&field.word, 1));
  }
  template <class Struct>
  void read_field(const Fields& /*fields*/, const Key& /*field*/, Struct& /*to*/) const {}

  static Vec3 unit_vector(const Node& node);
  void value(const Node& node, const Range& range, double& to) const { to = node.number(range); }
  void value(const Node& node, const Range& range, int& to) const;
  void value(const Node& node, const Range& range, Vec3& to) const { to = node.vector(range); }
  void value(const Node& node, const Range& range, std::array<double, 2>& to) const;
  void value(const Node& node, const Range& range, std::array<Vec3, 2>& to) const;
  void value(const Node& node, const Range& range, std::vector<Vec3>& to) const;
  void value(const Node& node, const Range& range, std::vector<Face>& to) const;
  void value(const Node& node, const Range& range, std::vector<Gust>& to) const;
  void value(const Node& node, const Range& range, Scalars& to) const { to = read_scalars(node, *population, range); }
  void value(const Node& node, const Range& range, PerAxis& to) const;
  void value(const Node& node, const Range& range, Anchor& to) const;
  void value(const Node& node, const Range& /*range*/, std::size_t& to) const { to = motions->index_of(node); }
  template <class E>
  requires std::is_enum_v<E>
  void value(const Node& node, const Range& /*range*/, E& to) const { to = static_cast<E>(node.choice(words<E>)); }
  template <class T>
  void value(const Node& node, const Range& range, std::optional<T>& to) const {
    value(node, range, to.emplace());
  }
};

}  // namespace dvdx::tool
