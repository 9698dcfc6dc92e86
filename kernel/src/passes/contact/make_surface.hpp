// From a scene's contact to what the contact pass reads.
#pragma once

#include "dvdx/scene.hpp"
#include "passes/contact/contact.hpp"

namespace dvdx {

// `finds_dips`: whether a parabola is close to the particles' paths (damping q < 1 and angle z < 2 in a step). Ignored for a
// line.
template <class T>
Surface<T> make_surface(const Contact& contact, bool finds_dips) noexcept;

extern template Surface<float> make_surface<float>(const Contact&, bool) noexcept;
extern template Surface<double> make_surface<double>(const Contact&, bool) noexcept;

}  // namespace dvdx
