#include "scene_io/motion_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "scene_io/described.hpp"

namespace dvdx::tool {
namespace {

MotionKey read_key(const Node& node) {
  auto key = DescribedReader{}.read<MotionKey>(node);
  if (!node.json().contains("jump")) return key;
  const auto jump = node.at("jump");
  if (!jump.json().is_boolean()) jump.refuse("true or false");
  if (jump.json().get<bool>()) key.arrival = Arrival::jump;
  return key;
}

Motion read_motion(const Node& node) {
  const Fields fields(node, "a motion", {"center", "keys"});
  Motion motion{.center = fields.vector("center", {}), .keys = {}};
  const auto list = fields.required("keys");
  for (const auto& key : list.elements("a list of at least one key")) {
    motion.keys.push_back(read_key(key));
    const std::size_t k = motion.keys.size() - 1;
    if (k == 0 || motion.keys[k].time > motion.keys[k - 1].time) continue;
    key.at("time").refuse(fmt::format("a time after that of the key before, {:g} s", motion.keys[k - 1].time));
  }
  if (motion.keys.empty()) list.refuse("a list of at least one key");
  return motion;
}

std::vector<std::size_t> read_followers(const Node& node, const Population& population,
                                        const std::optional<NetworkReader>& networks) {
  return particles_of(networks ? networks->read_group(node, population) : read_ids(node, population), population);
}

}  // namespace

std::size_t MotionNames::index_of(const Node& node) const {
  const auto found = std::find(names_.begin(), names_.end(), node.text());
  if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  if (names_.empty()) node.refuse("left out, or the name of a motion of the scene, which has none");
  const std::vector<std::string_view> known(names_.begin(), names_.end());
  node.refuse(one_of(known));
}

MotionNames read_motions(const Fields& fields, Scene& scene) {
  MotionNames names;
  const auto node = fields.optional("motions");
  if (!node) return names;
  if (!node->json().is_object()) node->refuse("an object of named motions");
  for (const auto& [name, value] : node->json().items()) {
    names.add(name);
    scene.add(read_motion(node->at(name)));
  }
  return names;
}

void read_kinematic(const Fields& fields, SceneFile& file, const Population& population, const MotionNames& motions,
                    const std::optional<NetworkReader>& networks) {
  const auto list = fields.optional("kinematic");
  if (!list) return;
  std::map<std::size_t, std::string> taken;
  for (const std::size_t id : file.scene.fixed) taken.emplace(id, "fixed");
  for (const auto& node : list->elements("a list of objects with particles and motion")) {
    const Fields group(node, "a group of kinematic particles", {"particles", "motion"});
    const auto ids = group.required("particles");
    Kinematic followers{.particles = read_followers(ids, population, networks),
                        .motion = motions.index_of(group.required("motion"))};
    for (const std::size_t id : followers.particles) {
      const auto [before, is_first] = taken.emplace(id, ids.path());
      if (!is_first)
        ids.fail(fmt::format("has particle {}, which is in {} already: may be in one of them", population.number_of(id),
                             before->second));
    }
    file.scene.add(std::move(followers));
  }
}

}  // namespace dvdx::tool
