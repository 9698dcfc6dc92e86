// The values of a scene that may differ from particle to particle.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "dvdx/fields.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

// Whether particles have numbers of their own.
inline bool is_each(const Scalars& value) noexcept { return !value.is_uniform(); }
inline bool is_each(const PerAxis& value) noexcept { return !value.is_uniform(); }
inline bool is_each(const Anchor& value) noexcept { return !std::holds_alternative<Vec3>(value); }

template <class Value>
inline constexpr bool may_differ =
    std::is_same_v<Value, Scalars> || std::is_same_v<Value, PerAxis> || std::is_same_v<Value, Anchor>;

// Calls use(name, value) for each value of a force that may differ.
template <class AForce, class Use>
void for_each_particle_value(AForce& force, const Use& use) {
  for_each_field<std::remove_const_t<AForce>>([&](const auto& field) {
    if constexpr (may_differ<std::remove_cvref_t<decltype(force.*field.value)>>) use(field.name, force.*field.value);
  });
}

// The same for a scene: its mass, and the values of its forces as "forces[i].name". Origins do not count.
template <class AScene, class Use>
void for_each_particle_value_of(AScene& scene, const Use& use) {
  use(std::string("mass"), scene.mass);
  for (std::size_t i = 0; i < scene.forces.size(); ++i) {
    const auto with_path = [&](std::string_view name, auto& value) {
      use("forces[" + std::to_string(i) + "]." + std::string(name), value);
    };
    std::visit([&](auto& force) { for_each_particle_value(force, with_path); }, scene.forces[i]);
  }
}

inline bool has_values_each(const Scene& scene) {
  bool is_any = scene.origin.is_each();
  for_each_particle_value_of(scene, [&](const std::string&, const auto& value) { is_any = is_any || is_each(value); });
  return is_any;
}

inline bool is_at_start(const Force& force) {
  bool is_any = false;
  const auto look = [&](std::string_view, const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Anchor>) is_any = std::holds_alternative<AtStart>(value);
  };
  std::visit([&](const auto& f) { for_each_particle_value(f, look); }, force);
  return is_any;
}

// Whether any force is anchored at each particle's start position.
inline bool stands_at_start(const Scene& scene) { return std::any_of(scene.forces.begin(), scene.forces.end(), is_at_start); }

// Whether networks or constraints join particles.
inline bool joins_particles(const Scene& scene) { return !scene.networks.empty() || !scene.constraints.empty(); }

// m/s: the speed at which particles inside a contact leave it, if it has one.
inline const std::optional<double>& push_out_of(const Contact& contact) {
  return std::visit([](const auto& c) -> const std::optional<double>& { return c.push_out; }, contact);
}

// The motion that carries a contact, if any.
inline const std::optional<std::size_t>& motion_of(const Contact& contact) {
  return std::visit([](const auto& c) -> const std::optional<std::size_t>& { return c.motion; }, contact);
}

// Whether the particle is fixed. Requires a sorted list, as a plan's scene has.
inline bool is_fixed(const Scene& scene, std::size_t particle) {
  return std::binary_search(scene.fixed.begin(), scene.fixed.end(), particle);
}

// Whether a motion carries the particle.
inline bool is_kinematic(const Scene& scene, std::size_t particle) {
  return std::any_of(scene.kinematic.begin(), scene.kinematic.end(), [&](const Kinematic& followers) {
    return std::find(followers.particles.begin(), followers.particles.end(), particle) != followers.particles.end();
  });
}

// 1/kg of each of `count` particles, 0 if it is fixed or kinematic.
inline std::vector<double> inverse_masses(const Scene& scene, std::size_t count) {
  std::vector<double> w(count);
  for (std::size_t i = 0; i < count; ++i) w[i] = 1 / scene.mass[i];
  for (const std::size_t i : scene.fixed) w[i] = 0;
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) w[i] = 0;
  }
  return w;
}

inline bool is_any_carried(const std::vector<Contact>& contacts) {
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return motion_of(c).has_value(); });
}

// Whether anything follows a motion.
inline bool has_followers(const Scene& scene) { return !scene.kinematic.empty() || is_any_carried(scene.contacts); }

// Whether the scene is stepped in a workspace's columns, sub-step by sub-step.
inline bool steps_in_columns(const Scene& scene) {
  return joins_particles(scene) || has_followers(scene) || !scene.skins.empty() || scene.meet.has_value();
}

}  // namespace dvdx
