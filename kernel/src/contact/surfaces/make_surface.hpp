// Converts contacts of a scene to the surfaces that the contact pass reads.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "contact/surfaces/surface.hpp"
#include "dvdx/scene.hpp"
#include "math/moved_pose.hpp"

namespace dvdx {

// The planes of a convex body or the distance grid of a mesh, as the pass reads them. The struct must not move: `solid` points
// into it.
template <class T>
struct ShapeMemory {
  std::vector<std::array<T, 4>> faces;
  std::vector<T> values;
  Solid<T> solid;  // without its axes
  T radius = 0;    // m: of the ball that contains the body
};
// One for each contact of a scene; null for a contact without. Plans share the memory of equal shapes.
template <class T>
using ShapeMemories = std::vector<std::shared_ptr<const ShapeMemory<T>>>;

// Returns the number of surfaces of a contact. A box with particles inside is six planes: a particle may lie in its corners.
[[nodiscard]] std::size_t parts_of(const Contact& contact) noexcept;

[[nodiscard]] bool has_memory(const Contact& contact) noexcept;
// Returns true if both contacts have memory, and it is the same.
[[nodiscard]] bool have_same_memory(const Contact& a, const Contact& b) noexcept;

// finds_dips: whether a parabola is close to the particles' paths (damping q < 1 and angle z < 2 in a step); ignored for
// contacts that sweep a line. Positions are relative to `origin`. A surface with memory is complete after set_memory().
template <class T>
Surface<T> make_surface(const Contact& contact, const Vec3& origin, bool finds_dips, std::size_t part = 0) noexcept;

// For a mesh, this takes as long as computing its grid of distances.
template <class T>
std::shared_ptr<const ShapeMemory<T>> make_memory(const Contact& contact);
template <class T>
void set_memory(Surface<T>& surface, const ShapeMemory<T>& memory, const Vec3& origin) noexcept;

// Sets shape, place and motion of a surface whose contact is carried to `pose`.
template <class T>
void move_surface(Surface<T>& surface, const Contact& contact, const MovedPose& pose, const Vec3& origin) noexcept;

extern template std::shared_ptr<const ShapeMemory<float>> make_memory<float>(const Contact&);
extern template std::shared_ptr<const ShapeMemory<double>> make_memory<double>(const Contact&);
extern template void set_memory<float>(Surface<float>&, const ShapeMemory<float>&, const Vec3&) noexcept;
extern template void set_memory<double>(Surface<double>&, const ShapeMemory<double>&, const Vec3&) noexcept;
extern template void move_surface<float>(Surface<float>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
extern template void move_surface<double>(Surface<double>&, const Contact&, const MovedPose&, const Vec3&) noexcept;
extern template Surface<float> make_surface<float>(const Contact&, const Vec3&, bool, std::size_t) noexcept;
extern template Surface<double> make_surface<double>(const Contact&, const Vec3&, bool, std::size_t) noexcept;

}  // namespace dvdx
