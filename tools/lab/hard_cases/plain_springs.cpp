#include "hard_cases/plain_springs.hpp"

#include <algorithm>
#include <cmath>

namespace dvdx::tool::stability {
namespace {

using Bodies = std::vector<Start>;

Vec3 between(const Vec3& a, const Vec3& b) { return {b[0] - a[0], b[1] - a[1], b[2] - a[2]}; }
double length(const Vec3& d) { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }

// x' and v' of every body.
void rates(const PlainSprings& system, const Bodies& at, Bodies& out) {
  for (std::size_t i = 0; i < at.size(); ++i) {
    out[i] = {at[i].v, system.mass[i] > 0 ? system.gravity : Vec3{}};
    if (system.mass[i] == 0 || (system.drag == 0 && system.anchor == 0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out[i].v[axis] -= system.drag * at[i].v[axis] + system.anchor * (at[i].x[axis] - system.bodies[i].x[axis]);
    }
  }
  for (const Link& link : system.links) {
    const Vec3 d = between(at[link.a].x, at[link.b].x);
    const double r = length(d);
    if (r == 0) continue;
    double pull = link.stiffness * (1 - link.rest_length / r);
    if (link.damping != 0) {
      const Vec3 u = between(at[link.a].v, at[link.b].v);
      pull += link.damping * (d[0] * u[0] + d[1] * u[1] + d[2] * u[2]) / (r * r);
    }
    const double to_a = system.mass[link.a] > 0 ? pull / system.mass[link.a] : 0;
    const double to_b = system.mass[link.b] > 0 ? pull / system.mass[link.b] : 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out[link.a].v[axis] += to_a * d[axis];
      out[link.b].v[axis] -= to_b * d[axis];
    }
  }
}

// at + h rate
void moved(const Bodies& at, const Bodies& rate, double h, Bodies& out) {
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out[i].x[axis] = at[i].x[axis] + h * rate[i].x[axis];
      out[i].v[axis] = at[i].v[axis] + h * rate[i].v[axis];
    }
  }
}

}  // namespace

double PlainSprings::energy() const {
  double sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum += mass[i] * (bodies[i].v[axis] * bodies[i].v[axis] / 2 - gravity[axis] * bodies[i].x[axis]);
    }
  }
  for (const Link& link : links) {
    const double stretch = length(between(bodies[link.a].x, bodies[link.b].x)) - link.rest_length;
    sum += link.stiffness * stretch * stretch / 2;
  }
  return sum;
}

std::vector<Start> run_plain(const PlainSprings& system, double seconds, std::size_t steps) {
  const double h = seconds / static_cast<double>(steps);
  Bodies at = system.bodies;
  Bodies stage = at;
  Bodies k1 = at;
  Bodies k2 = at;
  Bodies k3 = at;
  Bodies k4 = at;
  for (std::size_t n = 0; n < steps; ++n) {
    rates(system, at, k1);
    moved(at, k1, h / 2, stage);
    rates(system, stage, k2);
    moved(at, k2, h / 2, stage);
    rates(system, stage, k3);
    moved(at, k3, h, stage);
    rates(system, stage, k4);
    moved(at, k1, h / 6, at);
    moved(at, k2, h / 3, at);
    moved(at, k3, h / 3, at);
    moved(at, k4, h / 6, at);
  }
  return at;
}

Scene scene_of(const PlainSprings& system, const Coupling& coupling) {
  Scene scene;
  std::vector<double> mass = system.mass;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    if (mass[i] > 0) continue;
    mass[i] = 1;
    scene.fixed.push_back(i);
  }
  scene.mass = std::move(mass);
  const double heaviest = *std::max_element(system.mass.begin(), system.mass.end());
  if (system.gravity != Vec3{}) scene.add(Constant{.acceleration = system.gravity});
  if (system.drag != 0) scene.add(Drag{.coefficient = system.drag * heaviest});
  if (system.anchor != 0) scene.add(Spring{.stiffness = system.anchor * heaviest, .anchor = at_start});
  Springs springs;
  std::vector<double> stiffness;
  std::vector<double> rest_length;
  for (const Link& link : system.links) {
    springs.pairs.push_back({static_cast<std::uint32_t>(link.a), static_cast<std::uint32_t>(link.b)});
    stiffness.push_back(link.stiffness);
    rest_length.push_back(link.rest_length);
  }
  springs.stiffness = std::move(stiffness);
  springs.rest_length = std::move(rest_length);
  springs.damping = system.links.empty() ? 0 : system.links.front().damping;
  scene.add(Network(std::move(springs)));
  scene.coupling = coupling;
  return scene;
}

}  // namespace dvdx::tool::stability
