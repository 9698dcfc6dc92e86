// A convex body that planes bound: its corners, a point within it, and the ball around that point that holds it.
#pragma once

#include <cstddef>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx {

inline constexpr std::size_t fewest_planes = 4, most_planes = 64;

class ConvexBody {
 public:
  // Requires finite normals of length > 0 and finite offsets.
  explicit ConvexBody(const Convex& convex);

  // The reason why the planes bound no body.
  enum class Fault { none, empty, unbounded };
  [[nodiscard]] Fault fault() const noexcept { return fault_; }

  [[nodiscard]] const std::vector<Face>& faces() const noexcept { return faces_; }  // unit normals, moved out by the thickness
  [[nodiscard]] const Vec3& center() const noexcept { return center_; }             // within the body, m
  [[nodiscard]] double radius() const noexcept { return radius_; }                  // m, about the center
  [[nodiscard]] std::vector<Vec3> corners() const;                                  // m; one for each three planes that meet

 private:
  [[nodiscard]] bool is_bounded() const;

  std::vector<Face> faces_;
  Vec3 center_{};
  double radius_ = 0;
  Fault fault_ = Fault::none;
};

}  // namespace dvdx
