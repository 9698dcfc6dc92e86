#include "contact/surfaces/make_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "math/elementary.hpp"
#include "math/vec3.hpp"
#include "scene/convex_body.hpp"
#include "scene/signed_distance.hpp"

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
  surface.d = static_cast<T>((plane.offset + plane.thickness) - dot(n, origin));
}

template <class T>
void set_shape(Surface<T>& surface, const Sphere& sphere, const Vec3& origin) noexcept {
  const double side = sphere.side == Side::outside ? 1 : -1;
  surface.shape = Shape::sphere;
  surface.center = rounded<T>(difference(sphere.center, origin));
  const double radius = sphere.radius + side * sphere.thickness;
  surface.radius = static_cast<T>(radius);
  surface.side = static_cast<T>(side);
  surface.half_curvature = static_cast<T>(side / (2 * radius));
}

// Returns the radius of the ball that contains a body, a little larger than rounding requires.
template <class T>
T bound(double radius) noexcept {
  return static_cast<T>(radius * (1 + 8 * static_cast<double>(std::numeric_limits<T>::epsilon())));
}
template <class T>
void set_bound(Surface<T>& surface, double radius) noexcept {
  surface.radius = bound<T>(radius);
}

// ---- bodies: shape, and place by the pose ----------------------------------------------------------------------------

// Returns true if one end sphere contains the other.
bool is_ball(const Capsule& capsule) noexcept {
  return length(difference(capsule.ends[1], capsule.ends[0])) <= std::abs(capsule.radius[1] - capsule.radius[0]);
}

template <class T>
void set_body(Surface<T>& surface, const Capsule& capsule) noexcept {
  const double half_length = length(difference(capsule.ends[1], capsule.ends[0])) / 2;
  const auto [first, second] = capsule.radius;
  const double largest = std::max(first, second);
  Solid<T>& solid = surface.solid;
  surface.shape = Shape::capsule;
  if (is_ball(capsule)) {
    solid.middle_radius = static_cast<T>(largest + capsule.thickness);
    return set_bound(surface, largest + capsule.thickness);
  }
  const double slope = (second - first) / (2 * half_length);
  solid.half_length = static_cast<T>(half_length);
  solid.middle_radius = static_cast<T>((first + second) / 2 + capsule.thickness);
  solid.slope = static_cast<T>(slope);
  solid.lean = static_cast<T>(slope / std::sqrt((1 - slope) * (1 + slope)));
  set_bound(surface, half_length + largest + capsule.thickness);
}
template <class T>
void place_body(Surface<T>& surface, const Capsule& capsule, const MovedPose& pose, const Vec3& origin) noexcept {
  const Vec3 a = pose.place(capsule.ends[0]);
  const Vec3 b = pose.place(capsule.ends[1]);
  const bool ball = is_ball(capsule);
  const Vec3& larger = capsule.radius[1] > capsule.radius[0] ? b : a;
  Vec3 center{};
  for (std::size_t k = 0; k < 3; ++k) center[k] = ball ? larger[k] : a[k] + (b[k] - a[k]) / 2;
  surface.center = rounded<T>(difference(center, origin));
  const Vec3 w = ball ? Vec3{0, 1, 0} : unit(difference(b, a));
  surface.solid.axes = {rounded<T>(w), rounded<T>(across(w)[0]), rounded<T>(across(w)[1])};
}

template <class T>
void set_axes(Surface<T>& surface, const Quaternion& turn) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    Vec3 axis{};
    axis[k] = 1;
    surface.solid.axes[k] = rounded<T>(turned(turn, axis));
  }
}

template <class T>
void set_body(Surface<T>& surface, const OrientedBox& box) noexcept {
  surface.shape = Shape::box;
  surface.solid.half_extents = rounded<T>(box.half_extents);
  surface.solid.thickness = static_cast<T>(box.thickness);
  set_bound(surface, length(box.half_extents) + box.thickness);
}
template <class T>
void place_body(Surface<T>& surface, const OrientedBox& box, const MovedPose& pose, const Vec3& origin) noexcept {
  surface.center = rounded<T>(difference(pose.place(box.center), origin));
  set_axes(surface, pose.turn * quaternion(box.rotation));
}

// ShapeMemory holds the rest of convex bodies and meshes.
template <class T>
void set_body(Surface<T>& surface, const Convex&) noexcept {
  surface.shape = Shape::convex;
}
template <class T>
void set_body(Surface<T>& surface, const TriangleMesh&) noexcept {
  surface.shape = Shape::mesh;
}
template <class T>
void place_at_home(Surface<T>& surface, const MovedPose& pose, const Vec3& origin) noexcept {
  surface.center = rounded<T>(difference(pose.place(surface.solid.home), origin));
  set_axes(surface, pose.turn);
}
template <class T>
void place_body(Surface<T>& surface, const Convex&, const MovedPose& pose, const Vec3& origin) noexcept {
  place_at_home(surface, pose, origin);
}
template <class T>
void place_body(Surface<T>& surface, const TriangleMesh&, const MovedPose& pose, const Vec3& origin) noexcept {
  place_at_home(surface, pose, origin);
}

// Returns the face `part` of a box with particles inside, as a plane that faces them.
Plane face_of(const OrientedBox& box, std::size_t part) noexcept {
  const std::size_t axis = part / 2;
  Vec3 outwards{};
  outwards[axis] = part % 2 == 0 ? 1 : -1;
  outwards = turned(quaternion(box.rotation), outwards);
  return {.normal = scaled(outwards, -1),
          .offset = -(dot(outwards, box.center) + box.half_extents[axis]),
          .restitution = box.restitution,
          .friction = box.friction,
          .viscosity = box.viscosity,
          .normal_viscosity = box.normal_viscosity,
          .response = box.response,
          .sweep = box.sweep,
          .thickness = box.thickness,
          .push_out = box.push_out,
          .motion = box.motion};
}

template <class T>
void set_impact(Surface<T>& surface, double restitution, double friction, double viscosity, double normal_viscosity) noexcept {
  constexpr auto limits = std::numeric_limits<T>{};
  surface.e = static_cast<T>(restitution * exp_negative(normal_viscosity));
  surface.tau = static_cast<T>(exp_negative(viscosity));
  surface.mu = static_cast<T>(std::min(friction, static_cast<double>(limits.max())));
  // A surface that leaves no tangential velocity also holds a resting particle.
  if (surface.tau <= 0) surface.mu = limits.max();
  surface.hold = std::max(surface.mu, 8 * limits.epsilon());
}

Plane carried(Plane plane, const MovedPose& pose) noexcept {
  const Vec3 n = unit(plane.normal);
  plane.normal = turned(pose.turn, n);
  plane.offset = dot(unit(plane.normal), pose.place(scaled(n, plane.offset)));
  return plane;
}

Sphere carried(Sphere sphere, const MovedPose& pose) noexcept {
  sphere.center = pose.place(sphere.center);
  return sphere;
}

// Calls the visitor with one part of a contact: a plane of a box with particles inside, otherwise the contact itself.
template <class Visitor>
void visit_part(const Contact& contact, std::size_t part, const Visitor& visitor) noexcept {
  const auto* box = std::get_if<OrientedBox>(&contact);
  if (box != nullptr && box->side == Side::inside) return visitor(face_of(*box, part));
  std::visit(visitor, contact);
}

template <class C>
constexpr bool is_body = !std::is_same_v<C, Plane> && !std::is_same_v<C, Sphere>;

template <class T>
void add_shape(ShapeMemory<T>& memory, const Convex& body) {
  const ConvexBody made(body);
  for (const Face& face : made.faces()) {
    const auto n = rounded<T>(face.normal);
    memory.faces.push_back({n[0], n[1], n[2], static_cast<T>(face.offset - dot(face.normal, made.center()))});
  }
  memory.solid.home = made.center();
  memory.solid.planes = memory.faces.data();
  memory.solid.plane_count = memory.faces.size();
  memory.radius = bound<T>(made.radius());
}

template <class T>
void add_shape(ShapeMemory<T>& memory, const TriangleMesh& mesh) {
  const DistanceGrid grid = sampled(mesh);
  memory.values.reserve(grid.values.size());
  for (const double value : grid.values) memory.values.push_back(static_cast<T>(value));
  Solid<T>& solid = memory.solid;
  solid.values = memory.values.data();
  for (std::size_t k = 0; k < 3; ++k) solid.nodes[k] = static_cast<std::uint32_t>(grid.nodes[k]);
  solid.home = grid.center;
  solid.half_extents = rounded<T>(grid.half_extents);
  solid.low = rounded<T>(grid.low);
  solid.cell = static_cast<T>(grid.cell);
  solid.inverse_cell = static_cast<T>(1 / grid.cell);
  solid.steepness = static_cast<T>(grid.steepness);
  double radius = 0;
  for (const Vec3& vertex : mesh.vertices) radius = std::max(radius, distance(vertex, grid.center));
  memory.radius = bound<T>(radius + mesh.thickness + 2 * grid.cell);  // between nodes, distances may be off by a cell
}

template <class C>
constexpr bool is_with_memory = std::is_same_v<C, Convex> || std::is_same_v<C, TriangleMesh>;

}  // namespace

std::size_t parts_of(const Contact& contact) noexcept {
  const auto* box = std::get_if<OrientedBox>(&contact);
  return box != nullptr && box->side == Side::inside ? 6 : 1;
}

bool has_memory(const Contact& contact) noexcept {
  return std::visit([](const auto& c) { return is_with_memory<std::decay_t<decltype(c)>>; }, contact);
}

bool have_same_memory(const Contact& a, const Contact& b) noexcept {
  if (const auto* of_a = std::get_if<Convex>(&a), *of_b = std::get_if<Convex>(&b); of_a != nullptr && of_b != nullptr) {
    return of_a->planes == of_b->planes && of_a->thickness == of_b->thickness;
  }
  if (const auto* of_a = std::get_if<TriangleMesh>(&a), *of_b = std::get_if<TriangleMesh>(&b);
      of_a != nullptr && of_b != nullptr) {
    return of_a->vertices == of_b->vertices && of_a->triangles == of_b->triangles && of_a->cell == of_b->cell &&
           of_a->thickness == of_b->thickness;
  }
  return false;
}

template <class T>
std::shared_ptr<const ShapeMemory<T>> make_memory(const Contact& contact) {
  auto memory = std::make_shared<ShapeMemory<T>>();
  std::visit(
      [&](const auto& c) {
        if constexpr (is_with_memory<std::decay_t<decltype(c)>>) add_shape(*memory, c);
      },
      contact);
  return memory;
}

template <class T>
void set_memory(Surface<T>& surface, const ShapeMemory<T>& memory, const Vec3& origin) noexcept {
  surface.solid = memory.solid;
  surface.radius = memory.radius;
  place_at_home(surface, MovedPose{}, origin);
}

template <class T>
void move_surface(Surface<T>& surface, const Contact& contact, const MovedPose& pose, const Vec3& origin) noexcept {
  visit_part(contact, surface.part, [&](const auto& c) {
    if constexpr (is_body<std::decay_t<decltype(c)>>) {
      place_body(surface, c, pose, origin);
    } else {
      set_shape(surface, carried(c, pose), origin);
    }
  });
  const Vec3 at{(pose.center[0] + pose.translation[0]) - origin[0], (pose.center[1] + pose.translation[1]) - origin[1],
                (pose.center[2] + pose.translation[2]) - origin[2]};
  surface.u = rounded<T>(pose.velocity);
  surface.omega = rounded<T>(pose.angular_velocity);
  surface.at = rounded<T>(at);
  constexpr std::array<T, 3> none{};
  surface.movement = surface.omega != none ? Movement::turns : (surface.u != none ? Movement::shifts : Movement::rest);
}

template <class T>
Surface<T> make_surface(const Contact& contact, const Vec3& origin, bool finds_dips, std::size_t part) noexcept {
  Surface<T> surface;
  surface.part = static_cast<std::uint32_t>(part);
  visit_part(contact, part, [&](const auto& c) {
    if constexpr (is_body<std::decay_t<decltype(c)>>) {
      set_body(surface, c);
      place_body(surface, c, MovedPose{}, origin);
    } else {
      set_shape(surface, c, origin);
    }
    set_impact(surface, c.restitution, c.friction, c.viscosity, c.normal_viscosity);
    surface.push_out = static_cast<T>(c.push_out.value_or(0));
    surface.sweep = c.sweep;
    surface.response = c.response;
    surface.finds_dips = finds_dips && c.sweep == ContactPath::curve;
  });
  return surface;
}

template std::shared_ptr<const ShapeMemory<float>> make_memory<float>(const Contact&);
template std::shared_ptr<const ShapeMemory<double>> make_memory<double>(const Contact&);
template void set_memory<float>(Surface<float>&, const ShapeMemory<float>&, const Vec3&) noexcept;
template void set_memory<double>(Surface<double>&, const ShapeMemory<double>&, const Vec3&) noexcept;
template void move_surface<float>(Surface<float>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
template void move_surface<double>(Surface<double>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
template Surface<float> make_surface<float>(const Contact&, const Vec3&, bool, std::size_t) noexcept;
template Surface<double> make_surface<double>(const Contact&, const Vec3&, bool, std::size_t) noexcept;

}  // namespace dvdx
