// Which faces of cloth meet which bodies: those of networks whose cells are wider than a body. Immutable but for what tears.
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

// A body may slip between particles, or nearly so, that is narrower than so many times the longest side of their triangles.
inline constexpr double width_of_cells = 1.5;

// m: how wide a surface is where it is narrowest, its thickness included; 0 of a convex body with a tip of less than 30 degrees
// to its middle. None of what no face meets: planes, what particles are inside of, and meshes.
[[nodiscard]] std::optional<double> least_width(const Contact& contact);

// The longest side of a network's triangles at rest, m; none of a network without. start: the particles' positions.
[[nodiscard]] std::optional<double> longest_side(const Network& network, std::span<const Vec3> start);

// A body and where its contact has it.
struct ThinBody {
  std::size_t contact = 0;
  double width = 0;  // m
  std::optional<std::size_t> motion{};
  Vec3 center{};  // m, in the world
  std::array<Vec3, 3> axes{};
  FaceBody shape{};

  // pose: of its motion, with center `pose.center`; origin: of the columns' coordinates.
  [[nodiscard]] BodyPose at(const MovedPose& pose, const Vec3& origin) const noexcept;
};

// Triangles side by side, and the particles at their corners.
struct FacePatch {
  std::uint32_t first = 0, end = 0;                // of the triangles
  std::uint32_t first_corner = 0, end_corner = 0;  // of the list of corners
};

struct FaceNetwork {
  std::size_t network = 0;
  double side = 0;  // m
  std::size_t first_patch = 0, end_patch = 0;

  [[nodiscard]] bool is_wider_than(const ThinBody& body) const noexcept { return body.width < width_of_cells * side; }
};

class FaceContacts {
 public:
  using Corners = std::array<std::uint32_t, 3>;  // elements
  static constexpr std::uint32_t nowhere = ~std::uint32_t{0};

  // The scene has been checked; start: the particles' positions.
  FaceContacts(const Scene& scene, std::span<const Vec3> start, const ParticleOrder& order);

  // Whether no body is narrower than a network's cells.
  [[nodiscard]] bool empty() const noexcept { return bodies_.empty(); }
  [[nodiscard]] const std::vector<ThinBody>& bodies() const noexcept { return bodies_; }
  [[nodiscard]] const std::vector<FaceNetwork>& networks() const noexcept { return networks_; }
  [[nodiscard]] const std::vector<FacePatch>& patches() const noexcept { return patches_; }
  [[nodiscard]] const std::vector<std::uint32_t>& corners() const noexcept { return corners_; }
  // The first corner is nowhere where a side is torn.
  [[nodiscard]] const std::vector<Corners>& triangles() const noexcept { return triangles_; }
  [[nodiscard]] std::size_t bytes() const noexcept;

  // Takes away what has a torn side, in the scene's networks[network].
  void tear(std::size_t network, std::span<const Pair> pairs, const ParticleOrder& order) noexcept;
  // Whether a contact may take the place of contacts[index] without a change of what meets what.
  [[nodiscard]] bool can_set(std::size_t index, const Contact& contact) const;
  void set_contact(std::size_t index, const Contact& contact) noexcept;

 private:
  void add(std::size_t index, const Network& network, double side, const ParticleOrder& order);

  std::vector<ThinBody> bodies_;
  std::vector<FaceNetwork> networks_;
  std::vector<FacePatch> patches_;
  std::vector<std::uint32_t> corners_;
  std::vector<Corners> triangles_;
  std::vector<double> sides_;  // of every network with triangles
};

}  // namespace dvdx
