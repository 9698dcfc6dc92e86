// Edges between two surfaces that springs press a particle onto, scalar: written by hand beside edge.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/pass/respond_reference.hpp"

namespace dvdx::reference {

// A particle was pressed onto a surface b and, after the part f of the remaining step, onto a. Resolves both together.
template <Arithmetic arithmetic, PathForm form, class T>
void settle_in_edge(const Terms<T>& terms, const Pressed<T>& before, T f, Particle<T>& p,
                    ImpactState<arithmetic, form, T>& state) noexcept {
  constexpr T eps = std::numeric_limits<T>::epsilon();
  if (before.by == Supports<T>::none || state.pressed.by == Supports<T>::none || before.by == state.pressed.by) return;
  const Surface<T>& a = terms.surfaces[state.pressed.by];
  const Surface<T>& b = terms.surfaces[before.by];
  const auto distance = [&](const Surface<T>& surface) {
    const bool moves = surface.movement != Movement::rest;
    return touch<arithmetic>(surface, moves ? taken_along<arithmetic>(surface, p.x0, state.t) : p.x0).s;
  };
  const T sb = distance(b);
  const T way = std::abs(terms.h) * one_norm(before.v);
  const T sizes = ((one_norm(p.x0) + one_norm(p.x1)) + (b.radius + b.radius)) + way;
  const T near = 8 * eps * sizes + b.falls_away * (way * way);
  if (!(sb <= near)) return;
  const Meeting<T> of_a = meeting<arithmetic>(a, p.x0, state.t);
  const Meeting<T> of_b = meeting<arithmetic>(b, p.x0, state.t);
  const T kappa = dot<arithmetic>(of_a.n, of_b.n);
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  if (!(det > 64 * eps)) return;
  const T scale = 1 / det;
  const bool is_at_once = f <= 16 * eps;
  const T flat = most_pulses * (1 - kappa);
  const T reach = (before.removed + before.removed) * (flat < 1 ? flat : T(1));
  if (!is_at_once && kappa > 0 && !(state.pressed.removed <= reach)) return;

  const Vector<T> across = [&] {  // to b, along a
    Vector<T> to;
    for (std::size_t k = 0; k < 3; ++k) to[k] = scale * subtract_product<arithmetic>(of_b.n[k], kappa, of_a.n[k]);
    return to;
  }();
  const T share = dot<arithmetic>(of_b.n, difference(of_b.V, of_a.V));
  Vector<T> V;
  for (std::size_t k = 0; k < 3; ++k) V[k] = multiply_add<arithmetic>(share, across[k], of_a.V[k]);
  const Vector<T> u = difference(is_at_once ? before.v : p.v0, V);
  const T ua = state.direction * dot<arithmetic>(of_a.n, u);
  const T ub = state.direction * dot<arithmetic>(of_b.n, u);
  Two<T> taken{scale * (kappa * ub - ua), scale * (kappa * ua - ub)};
  if (is_at_once && !(taken.b >= 0 && taken.a >= 0)) {
    taken = taken.b >= 0 ? Two<T>{0, ub < 0 ? -ub : T(0)} : Two<T>{ua < 0 ? -ua : T(0), 0};
  }
  const bool is_edge = taken.a != 0 && taken.b != 0;
  Vector<T> along;
  for (std::size_t k = 0; k < 3; ++k) {
    const T by_a = multiply_add<arithmetic>(state.direction * taken.a, of_a.n[k], u[k]);
    along[k] = multiply_add<arithmetic>(state.direction * taken.b, of_b.n[k], by_a);
  }
  // In a flat edge both pulses are large against the velocity left. Friction would act on their rounding errors: solve again.
  const T left_a = dot<arithmetic>(of_a.n, along);
  const T left_b = dot<arithmetic>(of_b.n, along);
  const T more_a = is_edge ? scale * (kappa * left_b - left_a) : T(0);
  const T more_b = is_edge ? scale * (kappa * left_a - left_b) : T(0);
  for (std::size_t k = 0; k < 3; ++k) {
    along[k] = multiply_add<arithmetic>(more_b, of_b.n[k], multiply_add<arithmetic>(more_a, of_a.n[k], along[k]));
  }
  const T pressed_a = taken.a > 0 ? taken.a : T(0);
  const T pressed_b = taken.b > 0 ? taken.b : T(0);
  const T slide = multiply_add<arithmetic>(b.mu, pressed_b, a.mu * pressed_a);
  const T hold = multiply_add<arithmetic>(b.hold, pressed_b, a.hold * pressed_a);
  const T kept = kept_by_friction(slide, hold, std::sqrt(dot<arithmetic>(along, along)));
  const T sa = distance(a);
  const T onto_a = is_edge ? scale * (kappa * sb - sa) : T(0);
  const T onto_b = is_edge ? scale * (kappa * sa - sb) : T(0);
  const Vector<T> told = p.v0;
  for (std::size_t k = 0; k < 3; ++k) {
    const T shift = multiply_add<arithmetic>(onto_b, of_b.n[k], onto_a * of_a.n[k]);
    const T after = multiply_add<arithmetic>(kept, along[k], V[k]);
    const T pulse = after - p.v0[k];
    p.x0[k] = p.x0[k] + shift;
    p.x1[k] = p.x1[k] + shift;
    if constexpr (form == PathForm::parabola) {
      p.x1[k] = multiply_add<arithmetic>(state.t, pulse, p.x1[k]);
      p.v1[k] = after + (p.v1[k] - p.v0[k]);
    } else {
      p.x1[k] = multiply_add<arithmetic>(state.h * state.end.P1[k], pulse, p.x1[k]);
      p.v1[k] =
          multiply_add<arithmetic>(state.end.P0[k], after, subtract_product<arithmetic>(p.v1[k], state.end.P0[k], p.v0[k]));
    }
    p.v0[k] = after;
  }
  state.pressed.v = p.v0;
  if (state.recording == nullptr) return;
  // Both impacts are logged already. The rest is split by the multiples of the normals, its friction by the friction limits.
  const Vector<T> rest = difference(p.v0, told);
  const T rest_a = dot<arithmetic>(of_a.n, rest);
  const T rest_b = dot<arithmetic>(of_b.n, rest);
  const T by_a = scale * (rest_a - kappa * rest_b);
  const T by_b = scale * (rest_b - kappa * rest_a);
  const T share_b = hold > 0 ? b.hold * pressed_b / hold : T(0.5);
  Vector<T> dv_a, dv_b;
  for (std::size_t k = 0; k < 3; ++k) {
    const T along_edge = rest[k] - by_a * of_a.n[k] - by_b * of_b.n[k];
    dv_b[k] = by_b * of_b.n[k] + share_b * along_edge;
    dv_a[k] = rest[k] - dv_b[k];
  }
  state.recording->push(EventKind::hold, state.last, p.x0, of_a.n, dv_a, state.t);
  state.recording->push(EventKind::hold, before.by, p.x0, of_b.n, dv_b, state.t);
}

}  // namespace dvdx::reference
