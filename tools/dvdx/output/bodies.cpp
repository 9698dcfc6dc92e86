#include "output/bodies.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <variant>

namespace dvdx::tool {
namespace {

constexpr std::size_t around = 48;   // sides of a circle
constexpr std::size_t quarter = 12;  // rows from a pole to the equator

void add_quad(std::vector<Patch>& patches, const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  patches.push_back({a, b, c});
  patches.push_back({a, c, d});
}

Corner turned_inside(const Corner& corner) { return {corner.place, scaled(corner.normal, -1)}; }

std::vector<Patch> inside_out(std::vector<Patch> patches) {
  for (Patch& patch : patches) {
    patch = {turned_inside(patch[0]), turned_inside(patch[2]), turned_inside(patch[1])};
  }
  return patches;
}

// A circle of a surface: its middle, its radius, and the normal's parts along the axis and outwards.
struct Ring {
  Vec3 middle{};
  double radius = 0;
  double along = 0, out = 0;  // of the normal
};

std::vector<Patch> turned_about(const Vec3& axis, const std::vector<Ring>& rings) {
  const Vec3 u = across(axis);
  const Vec3 w = cross(axis, u);
  const auto corner = [&](const Ring& ring, std::size_t k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(around);
    const Vec3 outwards = sum(scaled(u, std::cos(angle)), scaled(w, std::sin(angle)));
    return Corner{sum(ring.middle, scaled(outwards, ring.radius)), sum(scaled(axis, ring.along), scaled(outwards, ring.out))};
  };
  std::vector<Patch> patches;
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    for (std::size_t k = 0; k < around; ++k) {
      add_quad(patches, corner(rings[r], k), corner(rings[r], k + 1), corner(rings[r + 1], k + 1), corner(rings[r + 1], k));
    }
  }
  return patches;
}

// Adds the rings of a ball about `center`, from one angle to the axis down to a smaller one.
void add_rings(std::vector<Ring>& rings, const Vec3& center, double radius, const Vec3& axis, double from, double to) {
  const auto rows = static_cast<std::size_t>(std::ceil((from - to) / (0.5 * std::numbers::pi) * static_cast<double>(quarter)));
  for (std::size_t row = 0; row <= rows; ++row) {
    const double angle = from + (to - from) * static_cast<double>(row) / static_cast<double>(std::max<std::size_t>(rows, 1));
    rings.push_back({.middle = sum(center, scaled(axis, radius * std::cos(angle))),
                     .radius = radius * std::sin(angle),
                     .along = std::cos(angle),
                     .out = std::sin(angle)});
  }
}

std::vector<Patch> surface(const Plane& /*plane*/) { return {}; }

std::vector<Patch> surface(const Sphere& sphere) {
  const Vec3 axis{0, 1, 0};
  std::vector<Ring> rings;
  add_rings(rings, sphere.center, sphere.radius, axis, std::numbers::pi, 0);
  auto patches = turned_about(axis, rings);
  return sphere.side == Side::inside ? inside_out(std::move(patches)) : patches;
}

std::vector<Patch> surface(const Capsule& capsule) {
  const Vec3 between = difference(capsule.ends[1], capsule.ends[0]);
  const double apart = length(between);
  const double thinner = capsule.radius[0] - capsule.radius[1];
  if (apart <= std::abs(thinner)) {  // one ball holds the other
    const std::size_t larger = thinner >= 0 ? 0 : 1;
    return surface(Sphere{.center = capsule.ends[larger], .radius = capsule.radius[larger]});
  }
  const Vec3 axis = scaled(between, 1 / apart);
  const double meet = std::acos(thinner / apart);  // where the cone touches both, from the axis
  std::vector<Ring> rings;
  add_rings(rings, capsule.ends[0], capsule.radius[0], axis, std::numbers::pi, meet);
  add_rings(rings, capsule.ends[1], capsule.radius[1], axis, meet, 0);
  return turned_about(axis, rings);
}

// A flat face, its corners counter-clockwise about the normal.
void add_face(std::vector<Patch>& patches, const std::vector<Vec3>& corners, const Vec3& normal) {
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    patches.push_back({Corner{corners[0], normal}, Corner{corners[k], normal}, Corner{corners[k + 1], normal}});
  }
}

std::vector<Patch> surface(const OrientedBox& box) {
  std::vector<Patch> patches;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      std::vector<Vec3> corners;
      for (const auto& [u, w] : {std::pair(-1.0, -1.0), std::pair(1.0, -1.0), std::pair(1.0, 1.0), std::pair(-1.0, 1.0)}) {
        Vec3 at{};
        at[axis] = side * box.half_extents[axis];
        at[(axis + 1) % 3] = u * side * box.half_extents[(axis + 1) % 3];
        at[(axis + 2) % 3] = w * box.half_extents[(axis + 2) % 3];
        corners.push_back(sum(box.center, rotated(at, box.rotation)));
      }
      Vec3 normal{};
      normal[axis] = side;
      add_face(patches, corners, rotated(normal, box.rotation));
    }
  }
  return box.side == Side::inside ? inside_out(std::move(patches)) : patches;
}

// The part of a polygon where normal . x <= offset.
std::vector<Vec3> cut_off(const std::vector<Vec3>& polygon, const Vec3& normal, double offset) {
  std::vector<Vec3> left;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3& a = polygon[k];
    const Vec3& b = polygon[(k + 1) % polygon.size()];
    const double above_a = dot(normal, a) - offset;
    const double above_b = dot(normal, b) - offset;
    if (above_a <= 0) left.push_back(a);
    if ((above_a < 0 && above_b > 0) || (above_a > 0 && above_b < 0)) {
      left.push_back(sum(a, scaled(difference(b, a), above_a / (above_a - above_b))));
    }
  }
  return left;
}

std::vector<Patch> surface(const Convex& convex) {
  double far_off = 0;
  for (const Face& face : convex.planes) far_off = std::max(far_off, std::abs(face.offset));
  const double wide = 1e3 * std::max(far_off, 1.0);
  std::vector<Patch> patches;
  for (const Face& face : convex.planes) {
    const Vec3 normal = unit(face.normal);
    const Vec3 u = scaled(across(normal), wide);
    const Vec3 w = cross(normal, u);
    const Vec3 middle = scaled(normal, face.offset);
    std::vector<Vec3> polygon{sum(middle, sum(u, w)), sum(middle, difference(w, u)), difference(middle, sum(u, w)),
                              sum(middle, difference(u, w))};
    for (const Face& other : convex.planes) {
      if (&other != &face) polygon = cut_off(polygon, unit(other.normal), other.offset);
    }
    add_face(patches, polygon, normal);
  }
  return patches;
}

std::vector<Patch> surface(const TriangleMesh& mesh) {
  std::vector<Patch> patches;
  for (const auto& [i, j, k] : mesh.triangles) {
    const std::vector<Vec3> corners{mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]};
    add_face(patches, corners, unit(cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]))));
  }
  return patches;
}

// Rotations as quaternions: w, then x, y, z.
using Turn = std::array<double, 4>;

Turn turn_of(const Vec3& rotation) {
  const double half = 0.5 * length(rotation);
  const Vec3 axis = scaled(unit(rotation), std::sin(half));
  return {std::cos(half), axis[0], axis[1], axis[2]};
}

// b after the inverse of a, the short way round, as a rotation vector.
Vec3 way_between(const Turn& a, const Turn& b) {
  const Vec3 from{-a[1], -a[2], -a[3]};
  const Vec3 to{b[1], b[2], b[3]};
  double w = b[0] * a[0] - dot(to, from);
  Vec3 v = sum(sum(scaled(from, b[0]), scaled(to, a[0])), cross(to, from));
  if (w < 0) {
    w = -w;
    v = scaled(v, -1);
  }
  return scaled(unit(v), 2 * std::atan2(length(v), w));
}

// One rotation after another, as a rotation vector.
Vec3 after(const Vec3& first, const Vec3& then) {
  const Turn inverse = turn_of(scaled(first, -1));
  return way_between(inverse, turn_of(then));
}

}  // namespace

std::vector<Patch> surface_of(const Contact& contact) {
  return std::visit([](const auto& shape) { return surface(shape); }, contact);
}

Pose pose_at(const Motion& motion, double time) {
  const auto is_later = [](double at, const MotionKey& key) { return at < key.time; };
  const auto next = std::upper_bound(motion.keys.begin(), motion.keys.end(), time, is_later);
  if (next == motion.keys.begin()) return {next->translation, next->rotation};
  const MotionKey& from = *(next - 1);
  if (next == motion.keys.end() || next->arrival == Arrival::jump) return {from.translation, from.rotation};
  const double part = (time - from.time) / (next->time - from.time);
  const Vec3 way = way_between(turn_of(from.rotation), turn_of(next->rotation));
  return {sum(from.translation, scaled(difference(next->translation, from.translation), part)),
          after(from.rotation, scaled(way, part))};
}

Patch carried(const Patch& patch, const Motion& motion, const Pose& pose) {
  Patch moved = patch;
  for (Corner& corner : moved) {
    const Vec3 turned = rotated(difference(corner.place, motion.center), pose.rotation);
    corner.place = sum(sum(motion.center, turned), pose.translation);
    corner.normal = rotated(corner.normal, pose.rotation);
  }
  return moved;
}

}  // namespace dvdx::tool
