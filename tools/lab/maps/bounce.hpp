// An impact by analysis: the energy after a step with a bounce, by Brown's pulse alone. One particle moves above a plane at x =
// 0 under a force towards it; the flow between impacts is exact.
#pragma once

#include <vector>

#include "dvdx/method.hpp"

namespace dvdx::tool::stability {

struct Motion {
  double x = 0, v = 0;  // m, m/s
};

// The forces between impacts: a constant acceleration, a spring with its anchor in the plane, a drag.
struct Pulling {
  double gravity = 0;  // m/s^2, towards the plane
  double W = 0;        // 1/s^2
  double drag = 0;     // 1/s; not together with a spring
};

[[nodiscard]] Motion flowed(const Pulling& pulling, Motion start, double t);

// The energy of one kilogram: kinetic, the spring's and gravity's.
[[nodiscard]] double energy_of(const Pulling& pulling, Motion at);

struct Impact {
  double restitution = 1;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
};

// One step h from a start above the plane, by the flow and the pulses of all impacts.
[[nodiscard]] Motion bounced(const Pulling& pulling, Motion start, double h, const Impact& impact);

// A particle that hits the plane within a step.
struct Bounce {
  Pulling pulling;
  double speed = 1;  // m/s, speed of the exact flow at the plane
  Impact impact;
};

// Starts from which the exact flow meets the plane at the middles of equal parts of a step h. Each must lie above the plane: h
// is at most the flight that ends there. Starts that Brown's response leaves on the plane with a velocity into it are left out:
// rounding decides whether they end up inside, where that velocity is removed.
[[nodiscard]] std::vector<Motion> starts_of(const Bounce& bounce, double h);

// The ratio of the energy after the step to that before it, averaged over starts_of.
[[nodiscard]] double energy_growth(const Bounce& bounce, double h);

}  // namespace dvdx::tool::stability
