#include "scene_io/skin_reader.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>

#include "scene_io/described.hpp"

namespace dvdx::tool {
namespace {

std::vector<std::size_t> read_numbers(const Node& node, const Population& population,
                                      const std::optional<NetworkReader>& networks) {
  if (node.json() == "all") {
    std::vector<std::size_t> all(population.count);
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }
  if (networks) return networks->read_group(node, population);
  return read_ids(node, population);
}

// The particles that a skin names, and the entries of its lists that belong to them.
struct NamedParticles {
  std::size_t named = 0;
  std::vector<std::size_t> particles{};
  std::vector<std::size_t> entries{};
};

// A particle with several of the numbers is held as the first entry says.
NamedParticles named_by(const std::vector<std::size_t>& numbers, const Population& population) {
  NamedParticles held{.named = numbers.size()};
  std::vector<bool> is_there(population.numbering != nullptr ? population.numbering->numbers.size() : 0, false);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto particle = particle_of(numbers[k], population);
    if (!particle || (!is_there.empty() && is_there[*particle])) continue;
    if (!is_there.empty()) is_there[*particle] = true;
    held.particles.push_back(*particle);
    held.entries.push_back(k);
  }
  return held;
}

template <class Value>
std::vector<Value> entries_of(const Node& list, const std::vector<Value>& all, const NamedParticles& held) {
  if (all.size() != held.named) {
    list.fail(fmt::format("has {} entries: must have one for each of the skin's {} particles", all.size(), held.named));
  }
  std::vector<Value> own;
  for (const std::size_t entry : held.entries) own.push_back(all[entry]);
  return own;
}

Scalars read_of_skin(const Node& node, const NamedParticles& held, const Range& range) {
  if (!node.json().is_array()) return node.number(range);
  std::vector<double> each;
  for (const auto& number : node.elements("a number, or a list of them")) each.push_back(number.number(range));
  return entries_of(node, each, held);
}

std::vector<Vec3> read_points(const Node& node, const NamedParticles& held) {
  std::vector<Vec3> points;
  for (const auto& point : node.elements("a list of points")) points.push_back(point.vector());
  return entries_of(node, points, held);
}

Vec3 read_direction(const Node& node) {
  const Vec3 direction = node.vector();
  if (direction == Vec3{}) node.refuse("a vector of length > 0");
  return direction;
}

std::vector<Vec3> read_normals(const Node& node, const NamedParticles& held) {
  const auto& given = node.json();
  if (!given.is_array() || given.empty() || !given[0].is_array()) return {read_direction(node)};
  std::vector<Vec3> normals;
  for (const auto& normal : node.elements("a list of vectors")) normals.push_back(read_direction(normal));
  return entries_of(node, normals, held);
}

Backstop read_backstop(const Node& node, const NamedParticles& held) {
  const Fields fields(node, "a back-stop", {"normals", "offset", "radius"});
  Backstop backstop{.normals = read_normals(fields.required("normals"), held),
                    .radius = read_of_skin(fields.required("radius"), held, Range::positive)};
  if (const auto offset = fields.optional("offset")) backstop.offset = read_of_skin(*offset, held, Range::finite);
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
    const NamedParticles held = named_by(read_numbers(ids, population, networks), population);
    Skin skin{.particles = held.particles};
    if (const auto points = of.optional("points")) skin.points = read_points(*points, held);
    if (const auto at_most = of.optional("at_most")) skin.at_most = read_of_skin(*at_most, held, Range::non_negative);
    if (const auto backstop = of.optional("backstop")) skin.backstop = read_backstop(*backstop, held);
    if (const auto motion = of.optional("motion")) skin.motion = motions.index_of(*motion);
    for (const std::size_t id : skin.particles) {
      const auto [before, is_first] = taken.emplace(id, ids.path());
      if (!is_first)
        ids.fail(fmt::format("has particle {}, which is in {} already: may be in one of them", population.number_of(id),
                             before->second));
    }
    scene.add(std::move(skin));
  }
}

void read_tethers(const Fields& fields, Scene& scene) {
  const auto list = fields.optional("tethers");
  if (!list) return;
  for (const auto& node : list->elements("a list of tethers")) {
    const Fields of = fields_of<Tethers>(node);
    Tethers tethers;
    const auto network = of.optional("network");
    if (scene.networks.empty()) list->refuse("left out of a scene without networks");
    if (network) tethers.network = network->whole(0, scene.networks.size() - 1);
    DescribedReader{}.read_fields(of, tethers);
    scene.add(tethers);
  }
}

}  // namespace dvdx::tool
