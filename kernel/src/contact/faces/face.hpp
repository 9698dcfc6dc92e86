// Bodies as the triangles of cloth meet them: docs/math.md has the derivation in short.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "contact/faces/closest.hpp"

// Equation  A point p = sum w_i x_i of a triangle, w the weights of its corners, moves by the pulse J as its corners move by
//             dv_i = w_i J / m_i,   so that   dv_p = K J,  K = sum w_i^2 / m_i.
//           The momentum of the corners changes by J, their angular momentum by p x J.
// Solution  p is the point of the triangle that is nearest to the core of the body, at the distance d; the body is what is
//           nearer than r. Where d < r
//             x_i += w_i / (m_i K) ((r - d) n - what slid, at most mu times what was pushed)
//             v_i += w_i / (m_i K) dv,   dv as of an impact of a particle with the velocity sum w_i v_i (surface.hpp)
//           Speed at the impact, in a part of a sub-step that ends with the speed u and had the mean speed U, is
//             u_f = u - 2 (1 - f) (u - U),
//           f the fraction at which p came in; of what lies still it is 0, so that nothing that rests bounces.
// Step      Once a sub-step, after all else. The way of a sub-step is gone along in so many parts that nothing moves by more
//           than r/2 relative to a body in one of them: what was outside has not passed the core, and n leads back.
// Limits    Cloth that goes farther than 64 r in a sub-step may pass. A triangle that the core pierces, as at the start, has
//           no side and is left alone.
// Source    R. Bridson, R. Fedkiw and J. Anderson, Robust treatment of collisions, contact and friction for cloth animation,
//           2002 (pulses by weights).

namespace dvdx {

// Parts of a sub-step.
inline constexpr int most_face_parts = 128;

// In the body's own axes, from its center. All that is nearer to the core than the radius is the body: edges of boxes and of
// convex bodies are rounded by it.
struct FaceBody {
  std::vector<CoreBall> core;
  double radius = 0;      // m, > 0
  Vec3 low{}, high{};     // m: the box about the body
  double e = 0, tau = 1;  // what an impact leaves of the normal velocity, and of the tangential one
  double mu = 0;          // Coulomb's, finite
  double push_out = std::numeric_limits<double>::infinity();  // m/s: what was inside already is moved no faster
};

// How a body lies in the columns' coordinates, and moves.
struct BodyPose {
  Vec3 center{};                                                // m
  std::array<Vec3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // of the body
  Vec3 velocity{}, angular_velocity{};                          // m/s, rad/s: at and about `at`
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

// About points, along the axes of the columns.
struct FaceBox {
  Vec3 low{far_out, far_out, far_out}, high{-far_out, -far_out, -far_out};

  // A number that is NaN keeps out of it.
  void add(const Vec3& x) noexcept {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = x[k] < low[k] ? x[k] : low[k];
      high[k] = x[k] > high[k] ? x[k] : high[k];
    }
  }
  // m: no point of it is nearer to the box about the body; below 0 where they may overlap.
  [[nodiscard]] double gap_to(const FaceBody& body, const BodyPose& pose) const noexcept;

 private:
  static constexpr double far_out = 1e300;
};

// Three corners in a part of a sub-step.
struct FaceCorners {
  std::array<double, 3> w{};                    // 1/kg; 0: held
  std::array<Vec3, 3> was{}, now{}, to{}, v{};  // m: at the part's start and end, and at the sub-step's end; m/s
};
// The part `number` (from 1) of `count` of a sub-step of h seconds, which may be negative.
struct FacePart {
  int number = 1, count = 1;
  double h = 0;
};

// A body's pulse on a triangle: on its corners, and on itself.
struct FacePulse {
  std::array<double, 3> share{};  // of each corner: w_i / (m_i K)
  Vec3 move{}, move_on{};         // m, of the point now and at the sub-step's end
  Vec3 dv{};                      // m/s
  Vec3 impulse{}, x{};            // N s, on the body; m, where
  bool is_impact = false;
};

// Whether a triangle with these corners, m, may touch the body. One that is not finite touches nothing.
[[nodiscard]] bool may_meet(const FaceBody& body, const BodyPose& pose, const std::array<Vec3, 3>& corners) noexcept;

// Whether the body moves corners that it may meet, and how.
[[nodiscard]] bool find_pulse(const FaceBody& body, const BodyPose& pose, const FaceCorners& corners, const FacePart& part,
                              FacePulse& pulse) noexcept;

}  // namespace dvdx
