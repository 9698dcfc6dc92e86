// Additions to a scene, which return indices.
#include "dvdx/scene.hpp"

#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

namespace dvdx {
namespace {

template <class Id, class Element>
Id add_to(std::vector<Element>& list, Element element) {
  list.push_back(std::move(element));
  return Id{list.size() - 1};
}

}  // namespace

ForceId add_force(Scene& scene, Force force) { return add_to<ForceId>(scene.forces, std::move(force)); }
ContactId add_contact(Scene& scene, Contact contact) { return add_to<ContactId>(scene.contacts, std::move(contact)); }
NetworkId add_network(Scene& scene, Network network) { return add_to<NetworkId>(scene.networks, std::move(network)); }
MotionId add_motion(Scene& scene, Motion motion) { return add_to<MotionId>(scene.motions, std::move(motion)); }
SkinId add_skin(Scene& scene, Skin skin) { return add_to<SkinId>(scene.skins, std::move(skin)); }

MotionId add_body(Scene& scene, Contact contact) {
  const MotionId motion = add_motion(scene);
  std::visit([&](auto& body) { body.motion = static_cast<std::size_t>(motion); }, contact);
  scene.contacts.push_back(std::move(contact));
  return motion;
}
PinsId add_pins(Scene& scene, std::vector<std::size_t> particles) {
  const auto motion = static_cast<std::size_t>(add_motion(scene));
  return add_to<PinsId>(scene.kinematic, Kinematic{.particles = std::move(particles), .motion = motion});
}

}  // namespace dvdx
