#include "closed_form/surface.hpp"

#include <variant>

namespace dvdx::tool::impacts {
namespace {

void set_shape(Surface& surface, const Plane& plane, const Vector& origin) {
  surface.n = unit(vector_of(plane.normal));
  surface.d = static_cast<Real>(plane.offset) + static_cast<Real>(plane.thickness) - dot(surface.n, origin);
}

void set_shape(Surface& surface, const Sphere& sphere, const Vector& origin) {
  surface.is_plane = false;
  surface.center = vector_of(sphere.center) - origin;
  surface.side = sphere.side == Side::outside ? 1 : -1;
  surface.radius = sphere.radius + surface.side * static_cast<Real>(sphere.thickness);
}

template <class Other>
void set_shape(Surface&, const Other&, const Vector&) {
  throw NotCovered("may meet a capsule, a box or a convex body");
}

}  // namespace

Surface surface_of(const Contact& contact, const Vector& origin) {
  Surface surface;
  std::visit(
      [&](const auto& c) {
        set_shape(surface, c, origin);
        surface.e = static_cast<Real>(c.restitution) * std::exp(-static_cast<Real>(c.normal_viscosity));
        surface.tau = std::exp(-static_cast<Real>(c.viscosity));
        // A surface that removes all tangential velocity also holds a resting particle. (A double's exp(-746) is zero.)
        const bool holds = c.viscosity > 745;
        surface.mu = holds ? std::numeric_limits<Real>::infinity() : static_cast<Real>(c.friction);
      },
      contact);
  return surface;
}

}  // namespace dvdx::tool::impacts
