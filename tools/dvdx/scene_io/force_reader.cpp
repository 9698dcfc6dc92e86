#include "scene_io/force_reader.hpp"

#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t most_terms = 8;  // of a polynomial

std::optional<Method> own_method(const Fields& fields) {
  const auto field = fields.optional("method");
  return field ? std::optional(field->choice(methods)) : std::nullopt;
}

PerAxis per_axis(const Node& node, const Population& population) {
  if (node.json().is_array()) return PerAxis(node.vector(not_negative));
  return read_scalars(node, population, not_negative);
}

Anchor anchor_of(const Node& node, const Population& population) {
  if (node.json().is_string()) {
    if (node.json() != "start") node.refuse("\"start\", [x, y, z] or an object with one of values, uniform, file, lattice");
    return at_start;
  }
  auto vectors = read_vectors(node, population);
  if (const auto* all = std::get_if<Vec3>(&vectors)) return *all;
  if (auto* each = std::get_if<std::vector<Vec3>>(&vectors)) return std::move(*each);
  return each_of(vectors, population.run().count);
}

Force read_constant(const Node& node) {
  const Fields fields(node, "a constant force", {"type", "method", "acceleration"});
  return Constant{.acceleration = fields.required("acceleration").vector(), .method = own_method(fields)};
}

Force read_polynomial(const Node& node) {
  const Fields fields(node, "a polynomial force", {"type", "method", "acceleration"});
  const auto field = fields.required("acceleration");
  const auto terms = field.elements("a list of 1 to 8 terms [x, y, z]");
  if (terms.empty() || terms.size() > most_terms) {
    field.fail("has " + std::to_string(terms.size()) + " terms: must have 1 to " + std::to_string(most_terms));
  }
  Polynomial force{.acceleration = {}, .method = own_method(fields)};
  for (const auto& term : terms) force.acceleration.push_back(term.vector());
  return force;
}

Force read_sinusoid(const Node& node) {
  const Fields fields(node, "a sinusoid force", {"type", "method", "acceleration", "angular_frequency", "phase"});
  return Sinusoid{.acceleration = fields.required("acceleration").vector(),
                  .angular_frequency = fields.required("angular_frequency").number(),
                  .phase = fields.number("phase", any_number, 0),
                  .method = own_method(fields)};
}

Force read_spring(const Node& node, const Population& population) {
  const Fields fields(node, "a spring", {"type", "method", "stiffness", "damping", "anchor"});
  return Spring{.stiffness = per_axis(fields.required("stiffness"), population),
                .damping = fields.number("damping", not_negative, 0),
                .anchor = anchor_of(fields.required("anchor"), population),
                .method = own_method(fields)};
}

Force read_radial_spring(const Node& node, const Population& population) {
  const Fields fields(node, "a radial spring", {"type", "method", "stiffness", "damping", "anchor", "rest_length"});
  return RadialSpring{.stiffness = read_scalars(fields.required("stiffness"), population, not_negative),
                      .damping = fields.number("damping", not_negative, 0),
                      .anchor = anchor_of(fields.required("anchor"), population),
                      .rest_length = read_scalars(fields.required("rest_length"), population, not_negative),
                      .method = own_method(fields)};
}

Force read_drag(const Node& node, const Population& population) {
  const Fields fields(node, "a drag", {"type", "method", "coefficient", "wind", "expansion"});
  return Drag{.coefficient = per_axis(fields.required("coefficient"), population),
              .wind = fields.vector("wind", {}),
              .expansion = fields.choice("expansion", expansions, Expansion::exact),
              .method = own_method(fields)};
}

}  // namespace

Force read_force(const Node& node, const Population& population) {
  switch (node.type_for("force").choice(force_types)) {
    case ForceType::constant:
      return read_constant(node);
    case ForceType::polynomial:
      return read_polynomial(node);
    case ForceType::sinusoid:
      return read_sinusoid(node);
    case ForceType::spring:
      return read_spring(node, population);
    case ForceType::radial_spring:
      return read_radial_spring(node, population);
    case ForceType::drag:
      return read_drag(node, population);
  }
  node.refuse("a force");
}

}  // namespace dvdx::tool
