#include "network_syntax.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "names.hpp"

namespace dvdx::tool {
namespace {

enum class Kind { grid, mesh, springs };
enum class Scheme { leapfrog, fourth_order, sequential, accumulate };
enum class Order { symmetric, forward };
enum class Joint { distance, point, line };

constexpr std::array<Named<Kind>, 3> kinds{{{"grid", Kind::grid}, {"mesh", Kind::mesh}, {"springs", Kind::springs}}};
constexpr std::array<Named<Scheme>, 4> schemes{{{"leapfrog", Scheme::leapfrog},
                                                {"fourth_order", Scheme::fourth_order},
                                                {"sequential", Scheme::sequential},
                                                {"accumulate", Scheme::accumulate}}};
constexpr std::array<Named<Order>, 2> orders{{{"symmetric", Order::symmetric}, {"forward", Order::forward}}};
constexpr std::array<Named<Joint>, 3> joints{{{"distance", Joint::distance}, {"point", Joint::point}, {"line", Joint::line}}};
constexpr std::array<std::string_view, 2> grid_groups{"corners_top", "edge_top"};
constexpr std::uint64_t most_rows = 1 << 20;
constexpr std::uint64_t most_substeps = 1000000;

std::vector<Node> networks_of(const Node& network) {
  if (network.json().is_array()) return network.elements("");
  return {network};
}

Kind kind_of(const Node& network) {
  if (!network.json().is_object()) network.refuse("an object, or a list of objects");
  if (!network.json().contains("type")) network.fail("has no type: must be a grid, a mesh or springs");
  return network.at("type").choice(kinds);
}

std::vector<std::string_view> known_keys(Kind kind) {
  std::vector<std::string_view> keys{"type", "damping", "fixed", "scheme", "substeps", "method", "theta", "sweep"};
  const auto add = [&](std::initializer_list<std::string_view> more) { keys.insert(keys.end(), more); };
  if (kind == Kind::grid) add({"rows", "columns", "origin", "edge_u", "edge_v", "mass", "structural", "shear", "bend"});
  if (kind == Kind::mesh) add({"file", "mass", "edge", "bend"});
  if (kind == Kind::springs) add({"pairs", "stiffness", "rest_length"});
  return keys;
}

void check_direction(const Node& node) {
  const auto direction = node.vector();
  if (direction == Vec3{}) node.refuse("a vector that is not zero");
}

void check_grid(const Fields& fields) {
  (void)fields.required("rows").whole(1, most_rows);
  (void)fields.required("columns").whole(1, most_rows);
  (void)fields.required("origin").vector();
  check_direction(fields.required("edge_u"));
  check_direction(fields.required("edge_v"));
  (void)fields.required("mass").number(positive);
  for (const char* key : {"structural", "shear", "bend"}) (void)fields.number(key, not_negative, 0);
}

void check_mesh(const Fields& fields) {
  if (!fields.required("file").text().ends_with(".obj")) fields.required("file").refuse("the name of an .obj file");
  (void)fields.required("mass").number(positive);
  for (const char* key : {"edge", "bend"}) (void)fields.number(key, not_negative, 0);
}

void check_pairs(const Node& node, const Population& population) {
  for (const auto& pair : node.elements("a list of pairs [i, j]")) {
    const auto ids = pair.elements("a pair [i, j]");
    if (ids.size() != 2) pair.refuse("a pair [i, j]");
    if (read_ids(pair, population).size() != 2) pair.refuse("a pair [i, j]");
  }
}

void check_lengths(const Fields& fields, const std::string& key, const Range& range) {
  const auto node = fields.required(key);
  if (node.json() == "start") return;
  const Population pairs{.count = fields.node().json()["pairs"].size(), .folder = {}};
  (void)read_scalars(node, pairs, range);
}

void check_springs(const Fields& fields, const Population& population) {
  check_pairs(fields.required("pairs"), population);
  const Population pairs{.count = fields.node().json()["pairs"].size(), .folder = population.folder};
  (void)read_scalars(fields.required("stiffness"), pairs, not_negative);
  check_lengths(fields, "rest_length", not_negative);
}

void check_fixed(const Node& node, Kind kind, const Population& population) {
  const auto check_group = [&](const Node& group) {
    if (kind != Kind::grid) group.refuse("a particle id");
    (void)group.choice(std::span<const std::string_view>(grid_groups));
  };
  if (node.json().is_string()) return check_group(node);
  const std::uint64_t last = population.count && *population.count > 0 ? *population.count - 1 : ~std::uint64_t{0};
  for (const auto& element : node.elements("a list of particle ids")) {
    if (element.json().is_string()) {
      check_group(element);
    } else {
      (void)element.whole(0, last);
    }
  }
}

void check_substeps(const Node& node) {
  if (node.json() != "auto") (void)node.whole(1, most_substeps);
}

void check_network(const Node& network, const Population& population) {
  const auto kind = kind_of(network);
  const Fields fields(network, "a network of type " + std::string(name_in(kinds, kind)), known_keys(kind));
  if (kind == Kind::grid) check_grid(fields);
  if (kind == Kind::mesh) check_mesh(fields);
  if (kind == Kind::springs) check_springs(fields, population);
  (void)fields.number("damping", not_negative, 0);
  (void)fields.number("theta", half_to_one, 0.55);
  (void)fields.choice("scheme", schemes, Scheme::leapfrog);
  (void)fields.choice("sweep", orders, Order::symmetric);
  (void)fields.choice("method", methods, Method::combined);
  if (const auto fixed = fields.optional("fixed")) check_fixed(*fixed, kind, population);
  if (const auto substeps = fields.optional("substeps")) check_substeps(*substeps);
}

void check_constraint(const Node& node, const Population& population) {
  if (!node.json().is_object()) node.refuse("an object");
  if (!node.json().contains("type")) node.fail("has no type: must be a distance, a point or a line");
  const std::uint64_t last = population.count && *population.count > 0 ? *population.count - 1 : ~std::uint64_t{0};
  const auto joint = node.at("type").choice(joints);
  if (joint == Joint::distance) {
    const Fields fields(node, "a distance constraint", {"type", "pairs", "length"});
    check_pairs(fields.required("pairs"), population);
    check_lengths(fields, "length", positive);
  } else if (joint == Joint::point) {
    const Fields fields(node, "a point constraint", {"type", "particle", "at"});
    (void)fields.required("particle").whole(0, last);
    (void)fields.required("at").vector();
  } else {
    const Fields fields(node, "a line constraint", {"type", "particle", "through", "direction"});
    (void)fields.required("particle").whole(0, last);
    (void)fields.required("through").vector();
    check_direction(fields.required("direction"));
  }
}

}  // namespace

NetworkParticles particles_of_networks(const Node& network) {
  NetworkParticles particles;
  for (const auto& node : networks_of(network)) {
    const auto kind = kind_of(node);
    if (kind == Kind::springs) continue;
    particles.made = true;
    if (kind == Kind::mesh) {
      particles.count.reset();
      continue;
    }
    const Fields fields(node, "a network of type grid", known_keys(kind));
    const auto made = fields.required("rows").whole(1, most_rows) * fields.required("columns").whole(1, most_rows);
    if (particles.count) *particles.count += made;
  }
  return particles;
}

void check_networks(const Node& network, const Population& population) {
  for (const auto& node : networks_of(network)) check_network(node, population);
}

void check_constraints(const Node& constraints, const Population& population) {
  for (const auto& node : constraints.elements("a list of constraints")) check_constraint(node, population);
}

}  // namespace dvdx::tool
