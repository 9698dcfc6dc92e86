// Faces of cloth that meet bodies: a network's faces meet bodies narrower than its cells. Only tears and changes modify it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "contact/faces/face.hpp"
#include "dvdx/scene.hpp"
#include "math/moved_pose.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// A body narrower than this many times the longest side of the triangles may slip between particles, or nearly so.
inline constexpr double width_of_cells = 1.5;

// Returns the least width of a surface with its thickness, m; 0 for a convex body with a tip of less than 30 degrees to its
// middle. Returns none for surfaces that no face meets: planes, meshes, and surfaces with particles inside.
[[nodiscard]] std::optional<double> least_width(const Contact& contact);

// Returns the longest side of a network's triangles at rest, m, or none without triangles. start: the particles' positions.
[[nodiscard]] std::optional<double> longest_side(const Network& network, std::span<const Vec3> start);

// A body, placed by its contact.
struct ThinBody {
  std::size_t contact = 0;
  double width = 0;  // m
  std::optional<std::size_t> motion{};
  Vec3 center{};  // m, in the world
  std::array<Vec3, 3> axes{};
  FaceBody shape{};

  // pose: of the body's motion, about `pose.center`; origin: of the columns' coordinates, m.
  [[nodiscard]] BodyPose at(const MovedPose& pose, const Vec3& origin) const noexcept;
};

// Triangles side by side, and the particles at their corners.
struct FacePatch {
  std::uint32_t first = 0, end = 0;                // range of triangles
  std::uint32_t first_corner = 0, end_corner = 0;  // range of the list of corners
};

struct FaceNetwork {
  std::size_t network = 0;
  double side = 0;  // m
  std::size_t first_patch = 0, end_patch = 0;

  [[nodiscard]] bool is_wider_than(const ThinBody& body) const noexcept { return body.width < width_of_cells * side; }
};

class FaceContacts {
 public:
  using Corners = std::array<std::uint32_t, 3>;  // elements of the working columns
  static constexpr std::uint32_t nowhere = ~std::uint32_t{0};

  // The scene has been checked; start: the particles' positions.
  FaceContacts(const Scene& scene, std::span<const Vec3> start, const ParticleOrder& order);

  // Whether no body is narrower than a network's cells.
  [[nodiscard]] bool empty() const noexcept { return bodies_.empty(); }
  [[nodiscard]] const std::vector<ThinBody>& bodies() const noexcept { return bodies_; }
  [[nodiscard]] const std::vector<FaceNetwork>& networks() const noexcept { return networks_; }
  [[nodiscard]] const std::vector<FacePatch>& patches() const noexcept { return patches_; }
  [[nodiscard]] const std::vector<std::uint32_t>& corners() const noexcept { return corners_; }
  // The first corner of a triangle with a torn side is `nowhere`.
  [[nodiscard]] const std::vector<Corners>& triangles() const noexcept { return triangles_; }
  [[nodiscard]] std::size_t bytes() const noexcept;

  // Removes triangles with a torn side from the scene's networks[network].
  void tear(std::size_t network, std::span<const Pair> pairs, const ParticleOrder& order) noexcept;
  // Returns true if a contact may replace contacts[index] without changing which faces meet which bodies.
  [[nodiscard]] bool can_set(std::size_t index, const Contact& contact) const;
  void set_contact(std::size_t index, const Contact& contact) noexcept;

 private:
  void add(std::size_t index, const Network& network, double side, const ParticleOrder& order);

  std::vector<ThinBody> bodies_;
  std::vector<FaceNetwork> networks_;
  std::vector<FacePatch> patches_;
  std::vector<std::uint32_t> corners_;
  std::vector<Corners> triangles_;
  std::vector<double> sides_;  // m: the longest of every network with triangles
};

}  // namespace dvdx
