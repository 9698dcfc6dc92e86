// Distances from surfaces, and the state of a path between impacts, wide. The scalar twin: impact_state_reference.hpp.
#pragma once

#include <cstddef>

#include "contact/pass/moving.inl.hpp"
#include "contact/surfaces/shape.inl.hpp"
#include "flow/bend.inl.hpp"
#include "flow/terms.hpp"

namespace dvdx {
namespace {

template <class V, Arithmetic arithmetic>
Touch<V> touch_plane(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  const Three<V> n = three<V>(surface.n);
  return {n, dot<arithmetic>(n, x) - V(surface.d)};
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Touch<V> touch_sphere(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V side(surface.side);
  const Three<V> r = x - three<V>(surface.center);
  const V length = square_root(dot<arithmetic>(r, r));
  const Mask<V> has_direction = length > zero;
  const V scale = quotient<V>(side, select<V>(has_direction, length, one));
  // At the very centre any direction will do: the second axis.
  return {{{scale * r[0], select<V>(has_direction, scale * r[1], side), scale * r[2]}}, side * (length - V(surface.radius))};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Touch<V> touch(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return touch_plane<V, arithmetic>(surface, x);
    case Shape::sphere:
      return touch_sphere<V, arithmetic>(surface, x);
    case Shape::capsule:
      return touch_capsule<V, arithmetic>(surface, x);
    case Shape::box:
      return touch_box<V, arithmetic>(surface, x);
    case Shape::convex:
      return touch_convex<V, arithmetic>(surface, x);
    case Shape::mesh:
      break;
  }
  return touch_mesh<V, arithmetic>(surface, x);
}

// The surfaces of a scene. planes: all are planes at rest, none is searched for; loops over them call nothing and test nothing.
enum class SurfaceMix { any, planes };

template <class V, Arithmetic arithmetic, SurfaceMix mix>
[[gnu::always_inline]] inline Touch<V> touch(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  if constexpr (mix == SurfaceMix::planes) {
    return touch_plane<V, arithmetic>(surface, x);
  } else {
    return touch<V, arithmetic>(surface, x);
  }
}

template <class V>
struct Path {
  Three<V> u, a;
};

template <class V>
Path<V> path(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t) noexcept {
  const Three<V> chord = m.x1 - m.x0;
  if (goes_straight(surface)) return {chord, three<V>(V(Scalar<V>(0)))};
  const Three<V> u = t * m.v0;
  return {u, chord - u};
}

// Indices of the surfaces that hold lanes for the rest of the step (-1: none), and the changes that these made to its end.
template <class V>
struct Supports {
  V a, b, c;
  Three<V> dx, dv;
};

template <class V>
Supports<V> no_supports() noexcept {
  const V none(Scalar<V>(-1));
  const V zero(Scalar<V>(0));
  return {none, none, none, three<V>(zero), three<V>(zero)};
}

// The last impact of lanes of a network on a surface without restitution: its index or -1, the normal velocity that it took,
// and the velocity before.
template <class V>
struct Pressed {
  V by, removed;
  Three<V> v;
};

// Lanes that leave surfaces inside which they start: the place and the time (before the end) of the start, and which lanes.
template <class V>
struct Leaving {
  Three<V> x0;
  V t;
  Mask<V> lanes;
};

// The state of lanes in a step. last: the index of the surface that was hit last; t: the remaining time of the step, s.
template <class V, Arithmetic arithmetic, PathForm form>
struct ImpactState {
  V direction, t, last;
  Mask<V> active, loose;  // loose: near a surface, but did not hit it
  Supports<V> supports;
  Mask<V> strayed = Mask<V>(false);     // outside the region for which the list of surfaces is valid
  const Leaving<V>* leaving = nullptr;  // null: no lane leaves a surface inside which it starts
};
template <class V, Arithmetic arithmetic>
struct ImpactState<V, arithmetic, PathForm::flow> {
  V direction, t, last;
  Mask<V> active, loose;
  Supports<V> supports;
  const Bending<V, arithmetic>* bending;
  V h, left;         // the whole step, s, and the part of it that remains
  Responses<V> end;  // of the remaining step
  Drive<V> drive;    // where forces depend on time
  Mask<V> strayed = Mask<V>(false);
  const Leaving<V>* leaving = nullptr;
};

// Marks lanes at x outside the region for which the list of surfaces is valid. They are resolved again with all surfaces.
template <class V, class AnyImpactState>
void watch(const Terms<Scalar<V>>& terms, AnyImpactState& state, const Three<V>& x, Mask<V> lanes) noexcept {
  if (terms.whole == nullptr) return;
  Mask<V> is_within(true);
  for (std::size_t k = 0; k < 3; ++k) {
    is_within = is_within & (x[k] >= V(terms.region.low[k])) & (x[k] <= V(terms.region.high[k]));
  }
  state.strayed = state.strayed | (lanes & !is_within);
}

// Returns D1 P + D2 P' + D3 P'', which forces of time add to a path or a velocity.
template <class V, Arithmetic arithmetic>
Three<V> driven(const Drive<V>& drive, const Three<V>& first, const Three<V>& second, const Three<V>& third) noexcept {
  Three<V> sum;
  for (std::size_t k = 0; k < 3; ++k) {
    sum[k] = multiply_add<arithmetic>(drive.D3[k], third[k],
                                      multiply_add<arithmetic>(drive.D2[k], second[k], drive.D1[k] * first[k]));
  }
  return sum;
}

// A path of PathForm::flow: from its start, u P1 + F P2, plus the part that forces of time add.
template <class V, Arithmetic arithmetic>
struct FlowPath {
  Three<V> u, F;
  const Drive<V>* drive;  // null: no force depends on time

  [[nodiscard]] Three<V> way(const Responses<V>& P) const noexcept {
    Three<V> way;
    for (std::size_t k = 0; k < 3; ++k) way[k] = multiply_add<arithmetic>(F[k], P.P2[k], u[k] * P.P1[k]);
    return drive != nullptr ? way + driven<V, arithmetic>(*drive, P.P3, P.P4, P.P5) : way;
  }
  [[nodiscard]] Three<V> rate(const Responses<V>& P) const noexcept {
    Three<V> rate;
    for (std::size_t k = 0; k < 3; ++k) rate[k] = multiply_add<arithmetic>(F[k], P.P1[k], u[k] * P.P0[k]);
    return drive != nullptr ? rate + driven<V, arithmetic>(*drive, P.P2, P.P3, P.P4) : rate;
  }
};

// Returns 1/P of a response, or 0 if nothing is left of a step.
template <class V>
V inverse(V P) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const Mask<V> is_left = differ(P, zero);
  return select<V>(is_left, quotient<V>(one, select<V>(is_left, P, one)), zero);
}

template <class V, Arithmetic arithmetic>
FlowPath<V, arithmetic> flow_path(const Trajectory<V>& m, const ImpactState<V, arithmetic, PathForm::flow>& state) noexcept {
  FlowPath<V, arithmetic> path{state.h * m.v0, {}, state.bending->is_driven() ? &state.drive : nullptr};
  const auto& P = state.end;
  Three<V> way = m.x1 - m.x0;
  if (path.drive != nullptr) way = way - driven<V, arithmetic>(state.drive, P.P3, P.P4, P.P5);
  for (std::size_t k = 0; k < 3; ++k) {
    path.F[k] = subtract_product<arithmetic>(way[k], path.u[k], P.P1[k]) * inverse(P.P2[k]);
  }
  return path;
}

template <class V, Arithmetic arithmetic>
Three<V> along(const Three<V>& start, const Path<V>& path, V f) noexcept {
  return multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, path.a, path.u), start);
}

}  // namespace
}  // namespace dvdx
