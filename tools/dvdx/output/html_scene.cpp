#include "output/html_scene.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "output/radii.hpp"
#include "scene_io/names.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_shown = 50000;    // of particles that nothing joins
constexpr std::size_t most_anchored = 2000;  // springs to anchors that are drawn

std::string name_of(Side side) { return side == Side::inside ? "inside" : "outside"; }

Json json_of(const Plane& plane) { return {{"type", "plane"}, {"normal", plane.normal}, {"offset", plane.offset}}; }
Json json_of(const Sphere& sphere) {
  return {{"type", "sphere"}, {"center", sphere.center}, {"radius", sphere.radius}, {"side", name_of(sphere.side)}};
}
Json json_of(const Capsule& capsule) { return {{"type", "capsule"}, {"ends", capsule.ends}, {"radii", capsule.radius}}; }
Json json_of(const OrientedBox& box) {
  return {{"type", "box"},
          {"center", box.center},
          {"half_extents", box.half_extents},
          {"rotation", box.rotation},
          {"side", name_of(box.side)}};
}
Json json_of(const Convex& convex) {
  Json planes = Json::array();
  for (const Face& face : convex.planes) planes.push_back({{"normal", face.normal}, {"offset", face.offset}});
  return {{"type", "convex"}, {"planes", std::move(planes)}};
}
Json json_of(const TriangleMesh& mesh) {
  return {{"type", "mesh"}, {"vertices", mesh.vertices}, {"triangles", mesh.triangles}};
}

Json json_of(const Contact& contact) {
  const auto with_motion = [](const auto& shape) {
    Json json = json_of(shape);
    if (shape.motion) json["motion"] = *shape.motion;
    return json;
  };
  return std::visit(with_motion, contact);
}

Json json_of(const Motion& motion) {
  Json keys = Json::array();
  for (const auto& key : motion.keys) {
    keys.push_back({{"time", key.time}, {"translation", key.translation}, {"rotation", key.rotation}});
    if (key.arrival == Arrival::jump) keys.back()["jump"] = true;
  }
  return {{"center", motion.center}, {"keys", std::move(keys)}};
}

// A grid's particles, and the sides of its cells at rest, m: along its rows, and down its columns.
Json json_of(const Grid& grid, const Numbering& numbering) {
  const auto side = [](const Vec3& edge, std::size_t points) {
    return std::hypot(edge[0], edge[1], edge[2]) / static_cast<double>(points - 1);
  };
  return {{"first", numbering.number_of(grid.first)},
          {"columns", grid.columns},
          {"count", grid.rows * grid.columns},
          {"sides", {side(grid.edge_u, grid.columns), side(grid.edge_v, grid.rows)}}};
}

// One spring's anchors: a point for all particles, one each, or "start".
Json json_of(const Anchor& anchor, const Numbering& numbering) {
  if (const auto* point = std::get_if<Vec3>(&anchor)) return *point;
  if (const auto* points = std::get_if<std::vector<Vec3>>(&anchor)) return by_number(*points, numbering);
  return "start";
}

Vec3 gravity_of(const Scene& scene) {
  Vec3 gravity{};
  for (const auto& force : scene.forces) {
    const auto* constant = std::get_if<Constant>(&force);
    for (std::size_t axis = 0; constant != nullptr && axis < 3; ++axis) gravity[axis] += constant->acceleration[axis];
  }
  return gravity;
}

// Particles that are held, at rest or by a motion.
std::vector<std::size_t> pins_of(const Scene& scene, const Numbering& numbering) {
  std::vector<std::size_t> pins = scene.fixed;
  for (const auto& followers : scene.kinematic) {
    pins.insert(pins.end(), followers.particles.begin(), followers.particles.end());
  }
  for (std::size_t& pin : pins) pin = numbering.number_of(pin);
  return pins;
}

// m: one for all balls, or one for each that is shown.
Json json_of(const std::vector<double>& radii, std::size_t stride) {
  if (std::equal(radii.begin() + 1, radii.end(), radii.begin())) return radii.front();
  Json shown = Json::array();
  for (std::size_t i = 0; i < radii.size(); i += stride) shown.push_back(static_cast<float>(radii[i]));
  return shown;
}

void add_scene(const Output& output, Json& json) {
  const auto& file = *output.scene;
  json["name"] = file.name;
  json["about"] = file.about;
  json["method"] = word(file.scene.method);
  json["gravity"] = gravity_of(file.scene);
  json["step"] = file.step;
  json["duration"] = file.duration;
  json["reference"] = output.reference_text;
  json["contacts"] = Json::array();
  for (const auto& contact : file.scene.contacts) json["contacts"].push_back(json_of(contact));
  json["motions"] = Json::array();
  for (const auto& motion : file.scene.motions) json["motions"].push_back(json_of(motion));
  json["pins"] = stride_of(output) == 1 ? Json(pins_of(file.scene, *output.numbering)) : Json::array();
  if (const auto radii = radii_of(output); !radii.empty()) json["radii"] = json_of(radii, stride_of(output));
  json["nets"] = output.topology->nets;
  json["sheets"] = Json::array();
  for (const auto& network : file.scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) json["sheets"].push_back(json_of(*grid, *output.numbering));
  }
  json["anchors"] = Json::array();
  if (output.counts == Counts::fixed && output.particles <= most_anchored) {
    for (const auto& force : file.scene.forces) {
      if (const auto anchor = anchor_of(force)) json["anchors"].push_back(json_of(*anchor, *output.numbering));
    }
  }
}

using Rest = std::pair<Pair, float>;

Pair with_lower_first(const Pair& ends) { return {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])}; }

void add_rests(const std::vector<Pair>& pairs, const Scalars& lengths, const Numbering& numbering, std::vector<Rest>& rests) {
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    rests.emplace_back(with_lower_first(numbering.numbers_of(pairs[n])), static_cast<float>(lengths[n]));
  }
}

// Returns the lengths of springs and rods that are not those of the start, sorted by their ends.
std::vector<Rest> rests_of(const Scene& scene, const Numbering& numbering) {
  std::vector<Rest> rests;
  for (const auto& network : scene.networks) {
    const auto* springs = std::get_if<Springs>(&network);
    if (springs != nullptr && springs->rest_length) add_rests(springs->pairs, *springs->rest_length, numbering, rests);
  }
  for (const auto& constraint : scene.constraints) {
    const auto* distance = std::get_if<Distance>(&constraint);
    if (distance != nullptr && distance->bound == Bound::equal && distance->length) {
      add_rests(distance->pairs, *distance->length, numbering, rests);
    }
  }
  std::stable_sort(rests.begin(), rests.end(), [](const Rest& a, const Rest& b) { return a.first < b.first; });
  return rests;
}

}  // namespace

std::vector<float> rest_lengths(const Output& output) {
  std::vector<float> lengths(output.topology->lines.size());
  if (output.scene == nullptr) return lengths;
  const auto rests = rests_of(output.scene->scene, *output.numbering);
  std::size_t n = 0;
  for (const auto& line : output.topology->lines) {
    const auto ends = with_lower_first(line);
    const auto found =
        std::lower_bound(rests.begin(), rests.end(), ends, [](const Rest& a, const Pair& b) { return a.first < b; });
    if (found != rests.end() && found->first == ends) lengths[n] = found->second;
    ++n;
  }
  return lengths;
}

std::size_t stride_of(const Output& output) {
  if (*output.topology != no_topology) return 1;
  return std::max<std::size_t>(1, (output.particles + most_shown - 1) / most_shown);
}

Json scene_json(const Output& output) {
  Json json{{"every", stride_of(output)}, {"states", output.states}};
  if (output.scene != nullptr) add_scene(output, json);
  return json;
}

}  // namespace dvdx::tool
