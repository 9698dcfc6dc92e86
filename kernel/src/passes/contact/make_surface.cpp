#include "passes/contact/make_surface.hpp"

#include <algorithm>
#include <limits>

#include "math/elementary.hpp"
#include "math/vec3.hpp"

namespace dvdx {
namespace {

template <class T>
std::array<T, 3> rounded(const Vec3& v) noexcept {
  return {static_cast<T>(v[0]), static_cast<T>(v[1]), static_cast<T>(v[2])};
}

template <class T>
void set_shape(Surface<T>& surface, const Plane& plane, const Vec3& origin) noexcept {
  surface.shape = Shape::plane;
  const Vec3 n = unit(plane.normal);
  surface.n = rounded<T>(n);
  surface.d = static_cast<T>(plane.offset - dot(n, origin));
}

template <class T>
void set_shape(Surface<T>& surface, const Sphere& sphere, const Vec3& origin) noexcept {
  const double side = sphere.side == Side::outside ? 1 : -1;
  surface.shape = Shape::sphere;
  surface.center = rounded<T>(difference(sphere.center, origin));
  surface.radius = static_cast<T>(sphere.radius);
  surface.side = static_cast<T>(side);
  surface.half_curvature = static_cast<T>(side / (2 * sphere.radius));
}

template <class T>
void set_impact(Surface<T>& surface, double restitution, double friction, double viscosity, double normal_viscosity) noexcept {
  constexpr auto limits = std::numeric_limits<T>{};
  surface.e = static_cast<T>(restitution * exp_negative(normal_viscosity));
  surface.tau = static_cast<T>(exp_negative(viscosity));
  surface.mu = static_cast<T>(std::min(friction, static_cast<double>(limits.max())));
  // A surface that leaves no tangential velocity holds a resting particle, too.
  if (surface.tau <= 0) surface.mu = limits.max();
  surface.hold = std::max(surface.mu, 8 * limits.epsilon());
}

}  // namespace

template <class T>
Surface<T> make_surface(const Contact& contact, const Vec3& origin, bool finds_dips) noexcept {
  Surface<T> surface;
  std::visit(
      [&](const auto& c) {
        set_shape(surface, c, origin);
        set_impact(surface, c.restitution, c.friction, c.viscosity, c.normal_viscosity);
        surface.sweep = c.sweep;
        surface.response = c.response;
        surface.finds_dips = finds_dips && c.sweep == ContactPath::curve;
      },
      contact);
  return surface;
}

template Surface<float> make_surface<float>(const Contact&, const Vec3&, bool) noexcept;
template Surface<double> make_surface<double>(const Contact&, const Vec3&, bool) noexcept;

}  // namespace dvdx
