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

Contact carried(Plane plane, const MovedPose& pose) noexcept {
  const Vec3 n = unit(plane.normal);
  plane.normal = turned(pose.turn, n);
  plane.offset = dot(unit(plane.normal), pose.place(scaled(n, plane.offset)));
  return plane;
}

Contact carried(Sphere sphere, const MovedPose& pose) noexcept {
  sphere.center = pose.place(sphere.center);
  return sphere;
}

}  // namespace

template <class T>
void move_surface(Surface<T>& surface, const Contact& contact, const MovedPose& pose, const Vec3& origin) noexcept {
  const Contact there = std::visit([&](const auto& c) { return carried(c, pose); }, contact);
  std::visit([&](const auto& c) { set_shape(surface, c, origin); }, there);
  const Vec3 at{(pose.center[0] + pose.translation[0]) - origin[0], (pose.center[1] + pose.translation[1]) - origin[1],
                (pose.center[2] + pose.translation[2]) - origin[2]};
  surface.u = rounded<T>(pose.velocity);
  surface.omega = rounded<T>(pose.angular_velocity);
  surface.at = rounded<T>(at);
  constexpr std::array<T, 3> none{};
  surface.movement = surface.omega != none ? Movement::turns : (surface.u != none ? Movement::shifts : Movement::rest);
}

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

template void move_surface<float>(Surface<float>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
template void move_surface<double>(Surface<double>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
template Surface<float> make_surface<float>(const Contact&, const Vec3&, bool) noexcept;
template Surface<double> make_surface<double>(const Contact&, const Vec3&, bool) noexcept;

}  // namespace dvdx
