// From a scene's contact to what the contact pass reads.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "dvdx/scene.hpp"
#include "math/moved_pose.hpp"
#include "passes/contact/contact.hpp"

namespace dvdx {

// A convex body's faces, as the pass reads them.
template <class T>
using Faces = std::vector<std::array<T, 4>>;

// Of which a contact is made: an inside box is its six planes, so that a particle may lie in its corners.
[[nodiscard]] std::size_t parts_of(const Contact& contact) noexcept;

// Whether a contact keeps memory of its own (the faces of a convex body).
[[nodiscard]] bool has_faces(const Contact& contact) noexcept;

// `finds_dips`: whether a parabola is close to the particles' paths (damping q < 1 and angle z < 2 in a step). Ignored for a
// line. The surface counts positions from `origin`. A convex body has faces from add_faces.
template <class T>
Surface<T> make_surface(const Contact& contact, const Vec3& origin, bool finds_dips, std::size_t part = 0) noexcept;

// Those of a convex body, which `surface` points to from then on.
template <class T>
void add_faces(Surface<T>& surface, const Convex& body, const Vec3& origin, Faces<T>& faces);

// The shape, place and motion of a surface whose contact is carried to `pose`.
template <class T>
void move_surface(Surface<T>& surface, const Contact& contact, const MovedPose& pose, const Vec3& origin) noexcept;

extern template void add_faces<float>(Surface<float>&, const Convex&, const Vec3&, Faces<float>&);
extern template void add_faces<double>(Surface<double>&, const Convex&, const Vec3&, Faces<double>&);
extern template void move_surface<float>(Surface<float>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
extern template void move_surface<double>(Surface<double>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
extern template Surface<float> make_surface<float>(const Contact&, const Vec3&, bool, std::size_t) noexcept;
extern template Surface<double> make_surface<double>(const Contact&, const Vec3&, bool, std::size_t) noexcept;

}  // namespace dvdx
