// Test setups of particles that fall onto bodies.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>

#include "dvdx/plan.hpp"
#include "kernel/passes/joined_run.hpp"
#include "math/vec3.hpp"
#include "support/scenes.hpp"

namespace dvdx::test {

inline constexpr Vec3 gravity{0, -9.81, 0};

template <class C>
C touched(C contact) {
  contact.restitution = 0.5;
  contact.friction = 0.3;
  contact.viscosity = 0.1;
  return contact;
}

inline Joined cloud(std::size_t count) {
  Joined joined;
  joined.name = "cloud";
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({scatter(i, 0), 0.3 + 0.7 * scatter(i, 1), scatter(i, 2)});
    joined.v.push_back({2 * scatter(i, 3), scatter(i, 4), scatter(i, 5)});
  }
  joined.scene.add(Constant{.acceleration = gravity});
  return joined;
}

// The same scene with an additional common velocity must end in the same place, except for that displacement.
inline void check_in_moving_frame(Joined still, double drag) {
  constexpr Vec3 boost{1.5, -0.75, 2.25};
  if (drag != 0) still.scene.add(Drag{.coefficient = drag});
  Joined moving = still;
  for (Vec3& v : moving.v) {
    for (std::size_t k = 0; k < 3; ++k) v[k] += boost[k];
  }
  if (drag != 0) std::get<Drag>(moving.scene.forces.back()).wind = boost;
  for (Contact& contact : moving.scene.contacts) std::visit([](auto& c) { c.motion = 0; }, contact);
  moving.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 16, .translation = scaled(boost, 16)}}});
  const std::size_t steps = 120;  // 2 s
  const auto wanted = stepped<double>(still, {.isa = best_isa()}, steps);
  const auto got = stepped<double>(moving, {.isa = best_isa()}, steps);
  const double t = static_cast<double>(steps) * still.step;
  double most = 0;
  for (std::size_t i = 0; i < wanted.size(); i += 6) {
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(got[i + k] - t * boost[k] - wanted[i + k]));
  }
  CHECK_MESSAGE(most < 1e-9, "drag " << drag << ": " << most << " m");
}

}  // namespace dvdx::test
