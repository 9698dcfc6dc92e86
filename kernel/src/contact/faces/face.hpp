// Narrow bodies as the triangles of cloth meet them. docs/math.md has a short derivation.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "contact/faces/closest.hpp"

// Equation  A pulse J on the point p = sum w_i x_i of a triangle, w the weights of its corners, moves the corners by
//             dv_i = w_i J / m_i,   so that   dv_p = K J,  K = sum w_i^2 / m_i.
//           The momentum of the corners changes by J, their angular momentum by p x J.
// Solution  p is the point of the triangle nearest to the core of the body, at the distance d. The body is all that is nearer
//           to the core than r. If d < r,
//             x_i += w_i / (m_i K) ((r - d) n - the slide),   the slide at most mu times the push
//             v_i += w_i / (m_i K) dv,   dv as of an impact of a particle with the velocity sum w_i v_i (surface.hpp)
//           In a part of a sub-step that ends with the speed u and had the mean speed U, the speed at the impact is
//             u_f = u - 2 (1 - f) (u - U),
//           f the fraction at which p came in. u_f is 0 for a point that lies still, so nothing at rest bounces.
// Step      Once a sub-step, after all else. The sub-step is divided into so many parts that nothing moves by more than r/2
//           relative to a body in one of them. Then a point from outside has not passed the core, and n leads back.
// Limits    Cloth that moves farther than 64 r in a sub-step may pass through. A triangle that the core pierces, for example at
//           the start, has no side and is left alone.
// Source    R. Bridson, R. Fedkiw and J. Anderson, Robust treatment of collisions, contact and friction for cloth animation,
//           2002 (pulses by weights).

namespace dvdx {

// The most parts of a sub-step.
inline constexpr int most_face_parts = 128;

// A body in its own axes, from its center: all points nearer to the core than `radius`, which rounds the edges of boxes and
// convex bodies.
struct FaceBody {
  std::vector<CoreBall> core;
  double radius = 0;      // m, > 0
  Vec3 low{}, high{};     // m: the box about the body
  double e = 0, tau = 1;  // parts of the normal and the tangential velocity that an impact leaves
  double mu = 0;          // Coulomb friction, finite
  double push_out = std::numeric_limits<double>::infinity();  // m/s: limit for a point that was already inside
};

// Pose and motion of a body in the columns' coordinates.
struct BodyPose {
  Vec3 center{};                                                // m
  std::array<Vec3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // of the body
  Vec3 velocity{}, angular_velocity{};                          // m/s, rad/s: at and about the point `at`
  Vec3 at{};                                                    // m

  [[nodiscard]] Vec3 to_body(const Vec3& x) const noexcept {
    const Vec3 r = difference(x, center);
    return {dot(axes[0], r), dot(axes[1], r), dot(axes[2], r)};
  }
  [[nodiscard]] Vec3 from_body(const Vec3& n) const noexcept {
    return sum(sum(scaled(axes[0], n[0]), scaled(axes[1], n[1])), scaled(axes[2], n[2]));
  }
  [[nodiscard]] Vec3 place(const Vec3& y) const noexcept { return sum(center, from_body(y)); }
  [[nodiscard]] Vec3 velocity_at(const Vec3& x) const noexcept {
    return sum(velocity, cross(angular_velocity, difference(x, at)));
  }
};

// The box about points, along the axes of the columns.
struct FaceBox {
  Vec3 low{far_out, far_out, far_out}, high{-far_out, -far_out, -far_out};

  // Ignores a coordinate that is NaN.
  void add(const Vec3& x) noexcept {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = x[k] < low[k] ? x[k] : low[k];
      high[k] = x[k] > high[k] ? x[k] : high[k];
    }
  }
  // Returns a lower bound of the distance to the box about the body, m; it is negative if the boxes may overlap.
  [[nodiscard]] double gap_to(const FaceBody& body, const BodyPose& pose) const noexcept;

 private:
  static constexpr double far_out = 1e300;
};

// The corners of a triangle in a part of a sub-step.
struct FaceCorners {
  std::array<double, 3> w{};                    // 1/kg; 0: held
  std::array<Vec3, 3> was{}, now{}, to{}, v{};  // m: at the part's start and end, and at the sub-step's end; v: m/s
};
// Part `number` (from 1) of `count` of a sub-step of h seconds; h may be negative.
struct FacePart {
  int number = 1, count = 1;
  double h = 0;
};

// The pulse of a body on a triangle, shared among the corners, and the reaction on the body.
struct FacePulse {
  std::array<double, 3> share{};  // of each corner: w_i / (m_i K)
  Vec3 move{}, move_on{};         // m: shift of the point now, and at the sub-step's end
  Vec3 dv{};                      // m/s
  Vec3 impulse{}, x{};            // N s, on the body; m, its point
  bool is_impact = false;
};

// Whether a triangle with these corners, m, may touch the body. A triangle that is not finite touches nothing.
[[nodiscard]] bool may_meet(const FaceBody& body, const BodyPose& pose, const std::array<Vec3, 3>& corners) noexcept;

// Returns true if the body moves corners that it may meet, and sets `pulse`.
[[nodiscard]] bool find_pulse(const FaceBody& body, const BodyPose& pose, const FaceCorners& corners, const FacePart& part,
                              FacePulse& pulse) noexcept;

}  // namespace dvdx
