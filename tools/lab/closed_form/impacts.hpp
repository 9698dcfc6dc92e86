// The exact motion of particles between planes and spheres under constant accelerations and linear drag, in long double, from
// impact to impact. It shares no formula and no step with the kernel, so that a wrong contact law of the kernel shows as an
// error.
//
// Flight.   Each axis is a sum of a constant, a line or parabola, and an exponential.
// Impact.   The first zero of the gaps' functions, reached by steps of lower bounds: no dip between two samples can be missed.
//           v_n' = -e v_n, v_t' = tau v_t less Coulomb's min(mu (1 + e) |v_n|, |tau v_t|), with e = restitution
//           exp(-normal_viscosity) and tau = exp(-viscosity).
// Settling. Infinitely many impacts with e < 1 end at a finite time. The remaining ones are closed once they take less than
//           1e-15 of the run. With a viscosity they leave no tangential velocity, as each multiplies it by tau.
// Resting.  On one, two or three planes the normal forces hold the particle. Friction mu N opposes the sliding velocity, or
//           holds any force up to that size. Straight and frictionless slides are exponentials again. A slide on one plane that
//           friction and another force bend is a Taylor series of order 30 in long double. Viscosity does not act on a resting
//           particle.
//
// Not covered, and reported as such: forces other than constants and drag; a particle that starts inside a surface; slides on
// spheres (resting on one is covered); slides along a sphere and a plane together; drag that differs between axes and changes
// the normal force; more than 200 000 impacts of one particle.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>

#include "closed_form/closed_form.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::tool {

struct ImpactPath {
  Path path;
  std::uint64_t most_impacts = 0;  // the maximum over particles
};

struct NoImpactPath {
  std::string why;
};

// Two ways to compute the same path that round differently everywhere: positions counted from the world's origin or from an
// arbitrary place, and series cut at other steps. Their difference measures the rounding error that impacts amplify.
enum class PathOrigin { world, displaced };

// Paths of all particles at the times unit * counts[0], unit * counts[1], ... (rising, the first 0).
[[nodiscard]] std::variant<ImpactPath, NoImpactPath> impact_path(const SceneFile& file, double unit,
                                                                 std::span<const std::uint64_t> counts,
                                                                 PathOrigin counted_from = PathOrigin::world);

}  // namespace dvdx::tool
