#include "scene_io/skin_reader.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>

namespace dvdx::tool {
namespace {

std::vector<std::size_t> read_held(const Node& node, const Population& population,
                                   const std::optional<NetworkReader>& networks) {
  if (node.json() == "all") {
    std::vector<std::size_t> all(population.count);
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }
  if (networks) return networks->read_group(node, population);
  return read_ids(node, population);
}

void check_length(const Node& list, std::size_t size, std::size_t particles) {
  if (size == particles) return;
  list.fail(fmt::format("has {} entries: must have one for each of the skin's {} particles", size, particles));
}

Scalars read_of_skin(const Node& node, std::size_t particles, const Range& range) {
  if (!node.json().is_array()) return node.number(range);
  std::vector<double> each;
  for (const auto& number : node.elements("a number, or a list of them")) each.push_back(number.number(range));
  check_length(node, each.size(), particles);
  return each;
}

std::vector<Vec3> read_points(const Node& node, std::size_t particles) {
  std::vector<Vec3> points;
  for (const auto& point : node.elements("a list of points")) points.push_back(point.vector());
  check_length(node, points.size(), particles);
  return points;
}

Vec3 read_direction(const Node& node) {
  const Vec3 direction = node.vector();
  if (direction == Vec3{}) node.refuse("a vector of length > 0");
  return direction;
}

std::vector<Vec3> read_normals(const Node& node, std::size_t particles) {
  const auto& given = node.json();
  if (!given.is_array() || given.empty() || !given[0].is_array()) return {read_direction(node)};
  std::vector<Vec3> normals;
  for (const auto& normal : node.elements("a list of vectors")) normals.push_back(read_direction(normal));
  check_length(node, normals.size(), particles);
  return normals;
}

Backstop read_backstop(const Node& node, std::size_t particles) {
  const Fields fields(node, "a back-stop", {"normals", "offset", "radius"});
  Backstop backstop{.normals = read_normals(fields.required("normals"), particles),
                    .radius = read_of_skin(fields.required("radius"), particles, positive)};
  if (const auto offset = fields.optional("offset")) backstop.offset = read_of_skin(*offset, particles, any_number);
  return backstop;
}

}  // namespace

void read_skins(const Fields& fields, Scene& scene, const Population& population, const MotionNames& motions,
                const std::optional<NetworkReader>& networks) {
  const auto list = fields.optional("skins");
  if (!list) return;
  std::map<std::size_t, std::string> taken;
  for (const auto& node : list->elements("a list of skins")) {
    const Fields of(node, "a skin", {"particles", "points", "at_most", "backstop", "motion"});
    const auto ids = of.required("particles");
    Skin skin{.particles = read_held(ids, population, networks)};
    const std::size_t particles = skin.particles.size();
    if (const auto points = of.optional("points")) skin.points = read_points(*points, particles);
    if (const auto at_most = of.optional("at_most")) skin.at_most = read_of_skin(*at_most, particles, not_negative);
    if (const auto backstop = of.optional("backstop")) skin.backstop = read_backstop(*backstop, particles);
    if (const auto motion = of.optional("motion")) skin.motion = motions.index_of(*motion);
    for (const std::size_t id : skin.particles) {
      const auto [before, is_first] = taken.emplace(id, ids.path());
      if (!is_first)
        ids.fail(fmt::format("has particle {}, which is in {} already: may be in one of them", id, before->second));
    }
    scene.add(std::move(skin));
  }
}

void read_tethers(const Fields& fields, Scene& scene) {
  const auto list = fields.optional("tethers");
  if (!list) return;
  for (const auto& node : list->elements("a list of tethers")) {
    const Fields of(node, "tethers", {"network", "stretch"});
    Tethers tethers;
    const auto network = of.optional("network");
    if (scene.networks.empty()) list->refuse("left out of a scene without networks");
    if (network) tethers.network = network->whole(0, scene.networks.size() - 1);
    tethers.stretch = of.number("stretch", {.min = 1, .text = "a finite number >= 1"}, 1);
    scene.add(tethers);
  }
}

}  // namespace dvdx::tool
