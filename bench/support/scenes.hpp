// The scenes that are timed, each named for the flow or the pass that it takes.
#pragma once

#include <cstddef>

#include "dvdx/scene.hpp"
#include "support/plain.hpp"

namespace dvdx::bench {

inline constexpr double frame = 1.0 / 60;  // s

Scene fall();                     // gravity and drag in wind: drift
Scene meadow();                   // gravity, one damped spring, drag in wind: fused
Scene gusts();                    // and a wind that swings: driven_fused
Scene swing();                    // one spring that nothing damps: shear
Scene stalks();                   // damped springs to where each particle starts: driven_fused_each
Scene masses(std::size_t count);  // meadow with masses each: coefficients each
Scene overdamped();               // decays to the origin within 300 frames, into denormal numbers
Scene ring();                     // one radial spring of rest length 1
Scene with(Scene scene, Contact contact);

Plane far_floor(Vec3 normal);  // one that nothing reaches
Plane floor();                 // y = 0, restitution 1
Plane ground();                // y = 0, restitution 0, friction 0.5
Sphere far_shell();            // all particles inside, nothing reaches it

template <class T>
PlainForces<T> plain_meadow();

}  // namespace dvdx::bench
