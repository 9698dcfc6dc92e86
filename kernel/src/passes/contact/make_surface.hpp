// From a scene's contact to what the contact pass reads.
#pragma once

#include "dvdx/scene.hpp"
#include "math/moved_pose.hpp"
#include "passes/contact/contact.hpp"

namespace dvdx {

// `finds_dips`: whether a parabola is close to the particles' paths (damping q < 1 and angle z < 2 in a step). Ignored for a
// line. The surface counts positions from `origin`.
template <class T>
Surface<T> make_surface(const Contact& contact, const Vec3& origin, bool finds_dips) noexcept;

// The shape, place and motion of a surface whose contact is carried to `pose`.
template <class T>
void move_surface(Surface<T>& surface, const Contact& contact, const MovedPose& pose, const Vec3& origin) noexcept;

extern template void move_surface<float>(Surface<float>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
extern template void move_surface<double>(Surface<double>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
extern template Surface<float> make_surface<float>(const Contact&, const Vec3&, bool) noexcept;
extern template Surface<double> make_surface<double>(const Contact&, const Vec3&, bool) noexcept;

}  // namespace dvdx
