// Impacts in the order of time, scalar: written by hand beside impact.inl.hpp.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "contact/pass/clamp_reference.hpp"
#include "contact/pass/edge_reference.hpp"
#include "contact/pass/respond_reference.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p,
                       const ImpactState<arithmetic, form, T>& state, bool is_held, T low) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane(terms, surface, seen, p, state, is_held, low);
    case Shape::sphere:
      return cross_sphere(terms, surface, seen, p, state, is_held, low);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return cross_solid(surface, seen, p, state, is_held, low);
}

// Returns whether there was an impact.
template <Arithmetic arithmetic, PathForm form, class T>
bool resolve_earliest(const Terms<T>& terms, Particle<T>& p, ImpactState<arithmetic, form, T>& state) noexcept {
  const T low = 4 * low_bounce * std::numeric_limits<T>::epsilon() * one_norm(p.x0);
  const T corner = terms.bend.corner * state.t;
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(corner, p.v0[k], p.x0[k]);
  T earliest = 2;
  std::size_t which = terms.surface_count;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (state.supports.has(j) || !may_touch_moving<arithmetic>(surface, p, middle, state.t, corner)) continue;
    if (leaves(surface, state)) continue;
    const std::optional<T> f = cross(terms, surface, p, state, state.last == j, low);
    if (f && *f < earliest) {
      earliest = *f;
      which = j;
    }
  }
  if (which == terms.surface_count) return false;
  state.last = which;
  const Pressed<T> before = state.pressed;
  respond(terms.surfaces[which], p, state, earliest);
  settle_in_edge(terms, before, earliest, p, state);
  hold(terms, p, state);
  return true;
}

template <Arithmetic arithmetic, PathForm form, class T>
void resolve_all(const Terms<T>& terms, Particle<T>& p, ImpactState<arithmetic, form, T>& state) noexcept {
  Leaving<T> leaving;
  if (terms.pushes) push_out(terms, p, state, leaving);
  hold(terms, p, state);
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest(terms, p, state)) break;
  }
  if (state.recording != nullptr) state.recording->let_go(1);
  T tolerance = 0;
  std::size_t before = terms.surface_count;
  for (int round = 0; round < clamp_rounds; ++round) {
    bool is_clamped = false;
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const T size = one_norm(p.x1);
      const bool is_held = state.supports.has(j);
      if (round == 0 && is_held && terms.surfaces[j].shape == Shape::plane) continue;
      if (!(touch<arithmetic>(terms.surfaces[j], p.x1).s < -(tolerance * size))) continue;
      if (leaves(terms.surfaces[j], state)) continue;
      is_clamped = true;
      const Vector<T> v = p.v1;
      const bool ends =
          before != terms.surface_count && before != j && is_pinched(terms.surfaces[before], terms.surfaces[j], p, state);
      if (!ends) clamp(terms.surfaces[j], p, state, state.last == j || is_held, size);
      if (state.recording != nullptr) {
        const Vector<T> dv = difference(p.v1, v);
        const T own = terms.surfaces[j].hold;
        const Vector<T> dv_j = ends ? scaled_by(own / (own + terms.surfaces[before].hold), dv) : dv;
        state.recording->push(EventKind::hold, j, p.x1, {}, dv_j, T(0));
        if (ends) state.recording->push(EventKind::hold, before, p.x1, {}, difference(dv, dv_j), T(0));
      }
      if (ends) return;
      before = j;
    }
    if (!is_clamped) return;
    tolerance = 2 * std::numeric_limits<T>::epsilon();
  }
}

}  // namespace dvdx::reference
