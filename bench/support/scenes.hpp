// The timed scenes, each named after its flow or pass.
#pragma once

#include <cstddef>

#include "dvdx/scene.hpp"
#include "support/plain.hpp"

namespace dvdx::bench {

inline constexpr double frame = 1.0 / 60;  // s

Scene fall();                     // gravity and drag in wind: drift
Scene meadow();                   // gravity, one damped spring, drag in wind: fused
Scene gusts();                    // the same with a wind that swings: driven_fused
Scene swing();                    // one undamped spring: shear
Scene stalks();                   // damped springs to each particle's start: driven_fused_each
Scene masses(std::size_t count);  // meadow with a mass for each particle: coefficients each
Scene overdamped();               // decays to the origin within 300 frames, into denormal numbers
Scene ring();                     // one radial spring of rest length 1
Scene with(Scene scene, Contact contact);

Plane far_floor(Vec3 normal);  // a plane that no particle reaches
Plane floor();                 // y = 0, restitution 1
Plane ground();                // y = 0, restitution 0, friction 0.5
Sphere far_shell();            // all particles are inside, none reaches it

template <class T>
PlainForces<T> plain_meadow();

}  // namespace dvdx::bench
