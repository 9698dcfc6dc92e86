#include "scene_io/constraint_reader.hpp"

#include <array>
#include <utility>
#include <variant>

#include "scene_io/names.hpp"
#include "scene_io/pair_reader.hpp"

namespace dvdx::tool {
namespace {

enum class Joint { distance, point, line };

constexpr std::array<Named<Joint>, 3> joints{{{"distance", Joint::distance}, {"point", Joint::point}, {"line", Joint::line}}};

Distance read_distance(const Node& node, const Population& population) {
  const Fields fields(node, "a distance constraint", {"type", "pairs", "length", "bound"});
  auto pairs = read_pairs(fields.required("pairs"), population);
  const auto of_pairs = population_of(pairs, population);
  return {.pairs = std::move(pairs),
          .length = read_lengths(fields.required("length"), of_pairs, Range::positive),
          .bound = fields.choice("bound", named_choices<Bound>, Bound::equal)};
}

std::uint32_t particle_in(const Fields& fields, const Population& population) {
  return static_cast<std::uint32_t>(read_particle(fields.required("particle"), population));
}

OnPoint read_point(const Node& node, const Population& population) {
  const Fields fields(node, "a point constraint", {"type", "particle", "at"});
  return {.particle = particle_in(fields, population), .at = fields.required("at").vector()};
}

OnLine read_line(const Node& node, const Population& population) {
  const Fields fields(node, "a line constraint", {"type", "particle", "through", "direction"});
  return {.particle = particle_in(fields, population),
          .through = fields.required("through").vector(),
          .direction = fields.required("direction").direction()};
}

Constraint read_constraint(const Node& node, const Population& population) {
  if (!node.json().is_object()) node.refuse("an object");
  if (!node.json().contains("type")) node.fail("has no type: must be a distance, a point or a line");
  switch (node.at("type").choice(joints)) {
    case Joint::distance:
      return read_distance(node, population);
    case Joint::point:
      return read_point(node, population);
    case Joint::line:
      return read_line(node, population);
  }
  node.refuse("a constraint");
}

}  // namespace

void read_constraints(const Node& constraints, SceneFile& file, const Population& population, ReadTopology topology) {
  for (const auto& node : constraints.elements("a list of constraints")) {
    auto constraint = read_constraint(node, population);
    const auto* const distance = std::get_if<Distance>(&constraint);
    if (distance != nullptr && topology == ReadTopology::yes) add_lines(distance->pairs, file);
    file.scene.add(std::move(constraint));
  }
}

}  // namespace dvdx::tool
