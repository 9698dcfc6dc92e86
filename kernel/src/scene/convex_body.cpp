#include "scene/convex_body.hpp"

#include <algorithm>
#include <cmath>

#include "math/vec3.hpp"

namespace dvdx {
namespace {

// Normals that differ by less count as parallel, and points count as on a plane within this part of the body's coordinates.
constexpr double tolerance = 1e-9;

}  // namespace

ConvexBody::ConvexBody(const Convex& convex) {
  for (const Face& face : convex.planes) faces_.push_back({unit(face.normal), face.offset + convex.thickness});
  if (!is_bounded()) {
    fault_ = Fault::unbounded;
    return;
  }
  const std::vector<Vec3> found = corners();
  if (found.empty()) {
    fault_ = Fault::empty;
    return;
  }
  for (const Vec3& corner : found) center_ = sum(center_, scaled(corner, 1 / static_cast<double>(found.size())));
  for (const Vec3& corner : found) radius_ = std::max(radius_, distance(center_, corner));
  const auto has_depth = [&](const Face& face) { return face.offset - dot(face.normal, center_) > tolerance * radius_; };
  if (!std::all_of(faces_.begin(), faces_.end(), has_depth)) fault_ = Fault::empty;
}

// An unbounded body has a direction d with n.d <= 0 for all normals, along an edge of two of its planes.
bool ConvexBody::is_bounded() const {
  const auto leads_out = [&](const Vec3& d) {
    return std::all_of(faces_.begin(), faces_.end(), [&](const Face& face) { return dot(face.normal, d) <= tolerance; });
  };
  bool has_edge = false;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    for (std::size_t j = i + 1; j < faces_.size(); ++j) {
      const Vec3 d = cross(faces_[i].normal, faces_[j].normal);
      if (length(d) < tolerance) continue;
      has_edge = true;
      const Vec3 along = unit(d);
      if (leads_out(along) || leads_out(scaled(along, -1))) return false;
    }
  }
  return has_edge;
}

// Returns the intersections of three planes that lie behind all other planes.
std::vector<Vec3> ConvexBody::corners() const {
  std::vector<Vec3> found;
  double size = 0;
  for (const Face& face : faces_) size = std::max(size, std::abs(face.offset));
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    for (std::size_t j = i + 1; j < faces_.size(); ++j) {
      const Vec3 ij = cross(faces_[i].normal, faces_[j].normal);
      for (std::size_t k = j + 1; k < faces_.size(); ++k) {
        const double det = dot(ij, faces_[k].normal);
        if (std::abs(det) < tolerance) continue;
        const Vec3 jk = scaled(cross(faces_[j].normal, faces_[k].normal), faces_[i].offset / det);
        const Vec3 ki = scaled(cross(faces_[k].normal, faces_[i].normal), faces_[j].offset / det);
        const Vec3 point = sum(sum(jk, ki), scaled(ij, faces_[k].offset / det));
        const double near = tolerance * (size + length(point));
        const auto is_behind = [&](const Face& face) { return dot(face.normal, point) - face.offset <= near; };
        if (std::all_of(faces_.begin(), faces_.end(), is_behind)) found.push_back(point);
      }
    }
  }
  return found;
}

}  // namespace dvdx
