#include "contact/faces/face_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "math/elementary.hpp"
#include "scene/convex_body.hpp"
#include "topology/triangles.hpp"
#include "work/columns.hpp"

namespace dvdx {
namespace {

// The radius that rounds the edges of bodies, as a part of their half width. Convex bodies: at most rounding_of_tip of the
// triangles' sides, as a tip of the angle a recedes by 1/sin(a/2) - 1 times the radius.
constexpr double rounding_of_box = 0.25, rounding_of_convex = 0.125, rounding_of_tip = 1.0 / 32;
// A tip is sharp if one of its planes is less than this off the direction to the body's middle, as a sine.
constexpr double sharp = 0.5;
constexpr std::size_t cells_of_patch = 4;  // along a row and along a column of a grid
constexpr std::size_t triangles_of_patch = 2 * cells_of_patch * cells_of_patch;

// ---- widths -----------------------------------------------------------------------------------------------------------------

std::optional<double> width_of(const Plane&) { return std::nullopt; }
std::optional<double> width_of(const TriangleMesh&) { return std::nullopt; }
std::optional<double> width_of(const Sphere& sphere) {
  if (sphere.side == Side::inside) return std::nullopt;
  return 2 * (sphere.radius + sphere.thickness);
}
std::optional<double> width_of(const Capsule& capsule) {
  return 2 * (std::min(capsule.radius[0], capsule.radius[1]) + capsule.thickness);
}
std::optional<double> width_of(const OrientedBox& box) {
  if (box.side == Side::inside) return std::nullopt;
  const auto& [a, b, c] = box.half_extents;
  return 2 * (std::min({a, b, c}) + box.thickness);
}
std::optional<double> width_of(const Convex& convex) {
  const ConvexBody body(convex);
  const std::vector<Vec3> corners = body.corners();
  double width = std::numeric_limits<double>::infinity();
  for (const Face& face : body.faces()) {
    double depth = 0;
    for (const Vec3& corner : corners) depth = std::max(depth, face.offset - dot(face.normal, corner));
    width = std::min(width, depth);
  }
  for (const Vec3& corner : corners) {
    const Vec3 inwards = unit(difference(body.center(), corner));
    double least = 1;
    for (const Face& face : body.faces()) {
      if (std::abs(dot(face.normal, corner) - face.offset) > 1e-9 * body.radius()) continue;
      least = std::min(least, -dot(face.normal, inwards));
    }
    if (least < sharp) return 0.0;
  }
  return width;
}

// ---- shapes -----------------------------------------------------------------------------------------------------------------

void set_axes(ThinBody& body, const Quaternion& turn) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    Vec3 axis{};
    axis[k] = 1;
    body.axes[k] = turned(turn, axis);
  }
}

// side: the longest side of all triangles, m.
void set_core(ThinBody&, const Plane&, double) noexcept {}
void set_core(ThinBody&, const TriangleMesh&, double) noexcept {}
void set_core(ThinBody& body, const Sphere& sphere, double /*side*/) {
  body.center = sphere.center;
  body.shape.core.assign(1, CoreBall{});
  body.shape.radius = sphere.radius + sphere.thickness;
}
void set_core(ThinBody& body, const Capsule& capsule, double /*side*/) {
  const auto& [a, b] = capsule.ends;
  const double least = std::min(capsule.radius[0], capsule.radius[1]);
  const double half = distance(a, b) / 2;
  for (std::size_t k = 0; k < 3; ++k) body.center[k] = a[k] + (b[k] - a[k]) / 2;
  if (half > 0) {
    const Vec3 w = unit(difference(b, a));
    body.axes = {w, across(w)[0], across(w)[1]};
  }
  body.shape.core.assign(2, CoreBall{});
  for (std::size_t k = 0; k < 2; ++k) {
    body.shape.core[k] = {{k == 0 ? -half : half, 0, 0}, capsule.radius[k] - least};
  }
  body.shape.radius = least + capsule.thickness;
}
void set_core(ThinBody& body, const OrientedBox& box, double /*side*/) {
  const auto& [a, b, c] = box.half_extents;
  const double off = rounding_of_box * std::min({a, b, c});
  body.center = box.center;
  set_axes(body, quaternion(box.rotation));
  body.shape.core.assign(8, CoreBall{});
  for (std::size_t n = 0; n < 8; ++n) {
    for (std::size_t k = 0; k < 3; ++k) {
      body.shape.core[n].at[k] = (n >> k & 1U) != 0 ? box.half_extents[k] - off : off - box.half_extents[k];
    }
  }
  body.shape.radius = off + box.thickness;
}
void set_core(ThinBody& body, const Convex& convex, double side) {
  const ConvexBody whole(convex);
  double least = std::numeric_limits<double>::infinity();
  for (const Face& face : whole.faces()) least = std::min(least, face.offset - dot(face.normal, whole.center()));
  const double off = std::min(rounding_of_convex * least, rounding_of_tip * side);
  Convex smaller = convex;
  smaller.thickness = convex.thickness - off;
  body.center = whole.center();
  body.shape.core.clear();
  for (const Vec3& corner : ConvexBody(smaller).corners()) {
    body.shape.core.push_back({difference(corner, body.center), 0});
  }
  body.shape.radius = off;
}

template <class C>
void set_impact(FaceBody& shape, const C& contact) noexcept {
  constexpr double most = std::numeric_limits<double>::max();
  shape.e = contact.restitution * exp_negative(contact.normal_viscosity);
  shape.tau = exp_negative(contact.viscosity);
  shape.mu = shape.tau > 0 ? std::min(contact.friction, most) : most;
  shape.push_out = contact.push_out.value_or(std::numeric_limits<double>::infinity());
}

void set_body(ThinBody& body, const Contact& contact, double side) {
  body.axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::visit(
      [&](const auto& c) {
        set_core(body, c, side);
        set_impact(body.shape, c);
        body.motion = c.motion;
      },
      contact);
  FaceBody& shape = body.shape;
  for (std::size_t k = 0; k < 3; ++k) {
    shape.low[k] = std::numeric_limits<double>::infinity();
    shape.high[k] = -shape.low[k];
    for (const CoreBall& ball : shape.core) {
      shape.low[k] = std::min(shape.low[k], ball.at[k] - (ball.radius + shape.radius));
      shape.high[k] = std::max(shape.high[k], ball.at[k] + (ball.radius + shape.radius));
    }
  }
}

// Sorts triangles tile by tile, so that a patch is as wide as it is long.
void put_in_tiles(const Grid& grid, std::vector<Triangle>& triangles) {
  const auto tile = [&](const Triangle& t) {
    const std::size_t cell = t[0] - grid.first;
    return std::pair(cell / grid.columns / cells_of_patch, cell % grid.columns / cells_of_patch);
  };
  std::stable_sort(triangles.begin(), triangles.end(), [&](const Triangle& s, const Triangle& t) { return tile(s) < tile(t); });
}

}  // namespace

std::optional<double> least_width(const Contact& contact) {
  return std::visit([](const auto& c) { return width_of(c); }, contact);
}

std::optional<double> longest_side(const Network& network, std::span<const Vec3> start) {
  double longest = 0;
  if (const auto* grid = std::get_if<Grid>(&network)) {
    const std::size_t rows = grid->rows_of_whole != 0 ? grid->rows_of_whole : grid->rows;
    const Vec3 across = scaled(grid->edge_u, 1 / static_cast<double>(grid->columns - 1));
    const Vec3 down = scaled(grid->edge_v, 1 / static_cast<double>(rows - 1));
    return std::max({length(across), length(down), length(sum(across, down))});
  }
  const auto& springs = std::get<Springs>(network);
  for (const auto& [a, b, c] : springs.triangles) {
    longest = std::max({longest, distance(start[a], start[b]), distance(start[b], start[c]), distance(start[c], start[a])});
  }
  return springs.triangles.empty() ? std::nullopt : std::optional(longest);
}

BodyPose ThinBody::at(const MovedPose& pose, const Vec3& origin) const noexcept {
  BodyPose found{.center = difference(pose.place(center), origin),
                 .velocity = pose.velocity,
                 .angular_velocity = pose.angular_velocity,
                 .at = difference(sum(pose.center, pose.translation), origin)};
  for (std::size_t k = 0; k < 3; ++k) found.axes[k] = turned(pose.turn, axes[k]);
  return found;
}

FaceContacts::FaceContacts(const Scene& scene, std::span<const Vec3> start, const ParticleOrder& order) {
  std::vector<std::pair<std::size_t, double>> wide;  // networks with triangles, and their longest sides
  const bool is_asked = scene.faces == Faces::automatic && !scene.contacts.empty();
  for (std::size_t n = 0; n < scene.networks.size() && is_asked; ++n) {
    if (const auto side = longest_side(scene.networks[n], start)) wide.emplace_back(n, *side);
  }
  for (const auto& [n, side] : wide) sides_.push_back(side);
  const double widest = sides_.empty() ? 0 : *std::max_element(sides_.begin(), sides_.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < scene.contacts.size() && !wide.empty(); ++i) {
    const auto width = least_width(scene.contacts[i]);
    if (!width || !(*width < width_of_cells * widest)) continue;
    ThinBody body{.contact = i, .width = *width};
    set_body(body, scene.contacts[i], widest);
    bodies_.push_back(std::move(body));
    least = std::min(least, *width);
  }
  for (const auto& [n, side] : wide) {
    if (least < width_of_cells * side) add(n, scene.networks[n], side, order);
  }
}

void FaceContacts::add(std::size_t index, const Network& network, double side, const ParticleOrder& order) {
  std::vector<Triangle> triangles = whole_triangles(network);
  if (const auto* grid = std::get_if<Grid>(&network)) put_in_tiles(*grid, triangles);
  FaceNetwork own{.network = index, .side = side, .first_patch = patches_.size()};
  for (std::size_t first = 0; first < triangles.size(); first += triangles_of_patch) {
    const std::size_t end = std::min(triangles.size(), first + triangles_of_patch);
    FacePatch patch;
    patch.first = static_cast<std::uint32_t>(triangles_.size());
    patch.first_corner = static_cast<std::uint32_t>(corners_.size());
    for (std::size_t t = first; t < end; ++t) {
      const auto& [a, b, c] = triangles[t];
      triangles_.push_back({order.of[a], order.of[b], order.of[c]});
      corners_.insert(corners_.end(), triangles_.back().begin(), triangles_.back().end());
    }
    const auto begin = corners_.begin() + patch.first_corner;
    std::sort(begin, corners_.end());
    corners_.erase(std::unique(begin, corners_.end()), corners_.end());
    patch.end = static_cast<std::uint32_t>(triangles_.size());
    patch.end_corner = static_cast<std::uint32_t>(corners_.size());
    patches_.push_back(patch);
  }
  own.end_patch = patches_.size();
  networks_.push_back(own);
}

std::size_t FaceContacts::bytes() const noexcept {
  return bytes_of(patches_) + bytes_of(corners_) + bytes_of(triangles_) + bytes_of(bodies_);
}

void FaceContacts::tear(std::size_t network, std::span<const Pair> pairs, const ParticleOrder& order) noexcept {
  const auto of = std::find_if(networks_.begin(), networks_.end(), [&](const FaceNetwork& n) { return n.network == network; });
  if (of == networks_.end() || of->first_patch == of->end_patch) return;
  const std::size_t end = patches_[of->end_patch - 1].end;
  for (const Pair& ends : pairs) {
    const std::uint32_t i = order.of[ends[0]], j = order.of[ends[1]];
    for (std::size_t t = patches_[of->first_patch].first; t < end; ++t) {
      Corners& corners = triangles_[t];
      const auto has = [&](std::uint32_t e) { return std::find(corners.begin(), corners.end(), e) != corners.end(); };
      if (has(i) && has(j)) corners[0] = nowhere;
    }
  }
}

bool FaceContacts::can_set(std::size_t index, const Contact& contact) const {
  const auto body = std::find_if(bodies_.begin(), bodies_.end(), [&](const ThinBody& b) { return b.contact == index; });
  const auto width = least_width(contact);
  const bool was_thin = body != bodies_.end();
  const auto is_thin = [&](double side) { return width && *width < width_of_cells * side; };
  if (!was_thin) return std::none_of(sides_.begin(), sides_.end(), is_thin);
  if (!width) return false;
  // The same networks must meet it, and its core must need no more balls than before: this must not allocate.
  ThinBody other{.contact = index, .width = *width};
  set_body(other, contact, sides_[0]);
  return other.shape.core.size() <= body->shape.core.capacity() && std::all_of(sides_.begin(), sides_.end(), [&](double side) {
           return is_thin(side) == (body->width < width_of_cells * side);
         });
}

// A convex body keeps its shape (have_same_memory): new corners would allocate.
void FaceContacts::set_contact(std::size_t index, const Contact& contact) noexcept {
  for (ThinBody& body : bodies_) {
    if (body.contact != index) continue;
    if (const auto* convex = std::get_if<Convex>(&contact)) {
      set_impact(body.shape, *convex);
      continue;
    }
    body.width = *least_width(contact);
    set_body(body, contact, 0);
  }
}

}  // namespace dvdx
