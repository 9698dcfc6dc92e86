// The time of impact, wide. The scalar twin: time_of_impact_reference.hpp. Surfaces that move: moving.inl.hpp turns the path.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/impact_state.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Crossing {
  V f;
  Mask<V> hits;
};

template <class V, Arithmetic arithmetic>
V discriminant(V s0, V d0, V c) noexcept {
  return subtract_product<arithmetic>(d0 * d0, V(Scalar<V>(4)) * c, s0);
}

template <class V>
V first_root(V s0, V d0, V c, V disc) noexcept {
  const V zero(Scalar<V>(0));
  const V root = square_root(select<V>(disc > zero, disc, zero));
  const Mask<V> approaches = d0 < zero;
  const V above = select<V>(approaches, s0 + s0, d0 + select<V>(s0 > zero, root, d0));
  const V below = select<V>(approaches, root - d0, V(Scalar<V>(-2)) * c);
  return quotient<V>(above, below);
}

// Whether lanes on the surface that was hit last do not hit it again.
template <class V>
Mask<V> stays(const Surface<Scalar<V>>& surface, V d0, V c, V low) noexcept {
  if (surface.response == Response::end_on_surface) return Mask<V>(true);
  return (d0 <= V(Scalar<V>(0))) | (d0 * d0 <= -(low * c));
}

// Finds the first zero of `gap` by Newton's steps from f, between 0, where it is positive, and `end`, where it is negative.
// gap(f) returns it and its slope. halves: a step that leaves the bracket bisects it, unless the gap is at most `close`; there,
// bisection would lead away from a path that begins on the surface and goes along it.
template <class V, class GapAt>
V refined(const GapAt& gap, V f, V end, int steps, bool halves, V close) noexcept {
  const V zero(Scalar<V>(0));
  const V half(Scalar<V>(0.5));
  V low = zero;
  V high = end;
  for (int step = 0; step < steps; ++step) {
    const auto [s, slope] = gap(f);
    const Mask<V> is_beyond = s < zero;
    high = select<V>(is_beyond, f, high);
    low = select<V>(is_beyond, low, f);
    const V next = f - quotient<V>(s, slope);
    const Mask<V> is_good = (slope < zero) & (next >= low) & (next <= high);
    const V otherwise = halves ? select<V>(xsimd::abs(s) <= close, f, half * (low + high)) : f;
    f = select<V>(is_good, next, otherwise);
  }
  return f;
}

template <class V>
struct Gap {
  V s, slope;  // slope: per f
};

// The lowest point of a path that starts towards a plane and ends outside, and the distance there.
template <class V>
struct Lowest {
  V f, s;
};

template <class V, Arithmetic arithmetic>
class PlanePath {
  using T = Scalar<V>;

 public:
  PlanePath(const Surface<T>& surface, const Trajectory<V>& m, const ImpactState<V, arithmetic, PathForm::flow>& state, V s0,
            const Slip<V>& slip) noexcept
      : state_(state),
        path_(flow_path<V, arithmetic>(m, state)),
        n_(three<V>(surface.n)),
        s0_(s0),
        slips_(slip.is_there),
        l_(dot<arithmetic>(n_, slip.l)),
        q_(dot<arithmetic>(n_, slip.q)) {}

  [[nodiscard]] Gap<V> operator()(V f) const noexcept {
    const Responses<V> P = (*state_.bending)(f * state_.left);
    const Gap<V> gap{s0_ + dot<arithmetic>(n_, path_.way(P)), state_.left * dot<arithmetic>(n_, path_.rate(P))};
    if (!slips_) return gap;
    return {multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, q_, l_), gap.s),
            multiply_add<arithmetic>(f + f, q_, gap.slope + l_)};
  }

  [[nodiscard]] Lowest<V> lowest(V f, int steps) const noexcept {
    const V zero(T(0));
    const V one(T(1));
    const auto& [w, q] = std::pair(state_.bending->w, state_.bending->q);
    for (int step = 0; step < steps; ++step) {
      const Responses<V> P = (*state_.bending)(f * state_.left);
      Three<V> second;
      for (std::size_t k = 0; k < 3; ++k) {
        const V pull = multiply_add<arithmetic>(q[k], P.P0[k], w[k] * P.P1[k]);
        second[k] = subtract_product<arithmetic>(path_.F[k] * P.P0[k], path_.u[k], pull);
      }
      if (path_.drive != nullptr) second = second + driven<V, arithmetic>(*path_.drive, P.P1, P.P2, P.P3);
      V slope = dot<arithmetic>(n_, path_.rate(P));
      V bend = state_.left * dot<arithmetic>(n_, second);
      if (slips_) {
        slope = multiply_add<arithmetic>(state_.left, slope, multiply_add<arithmetic>(f + f, q_, l_));
        bend = multiply_add<arithmetic>(state_.left, bend, q_ + q_);
      }
      const V next = f - quotient<V>(slope, bend);
      f = select<V>((next > zero) & (next < one), next, f);
    }
    return {f, (*this)(f).s};
  }

 private:
  const ImpactState<V, arithmetic, PathForm::flow>& state_;
  FlowPath<V, arithmetic> path_;
  Three<V> n_;
  V s0_;
  bool slips_;
  V l_, q_;
};

// m: the trajectory as the surface sees it; own: the trajectory itself.
template <class V, Arithmetic arithmetic, PathForm form>
Crossing<V> cross_plane(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                        [[maybe_unused]] const Trajectory<V>& own, const ImpactState<V, arithmetic, form>& state, Mask<V> held,
                        V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V start = touch<V, arithmetic>(surface, m.x0).s;
  const V s0 = select<V>(held | (start < zero), zero, start);
  const V s1 = touch<V, arithmetic>(surface, m.x1).s;
  const V d0 = surface.sweep == ContactPath::line ? s1 - s0 : state.t * dot<arithmetic>(three<V>(surface.n), m.v0);
  const V c = (s1 - s0) - d0;
  const V disc = discriminant<V, arithmetic>(s0, d0, c);
  V f = first_root(s0, d0, c, disc);
  Mask<V> hits = s1 < zero;
  const Mask<V> kept = held & stays(surface, d0, c, low);
  if constexpr (form == PathForm::parabola) {
    if (surface.finds_dips) hits = hits | ((d0 < zero) & (disc > zero) & (-d0 < c + c));
    return {select<V>(f < one, f, one), hits & !kept};
  } else {
    f = select<V>(f < one, f, one);
    if (surface.sweep == ContactPath::line) return {f, hits & !kept};
    const PlanePath<V, arithmetic> path(surface, own, state, s0, slip_of(surface, own, m, state.t));
    V end = one;
    if (surface.finds_dips) {
      const Mask<V> may_dip =
          state.active & (!kept) & (!hits) & (d0 < zero) & (multiply_add<arithmetic>(V(terms.bend.corner), d0, s0) < zero);
      if (any_lane<V>(may_dip)) {
        const Lowest<V> lowest = path.lowest(quotient<V>(negative(d0), c + c), terms.bend.newton_steps);
        const Mask<V> dips = may_dip & (lowest.s < zero);
        const V d = lowest.f * d0;
        const V b = (lowest.s - s0) - d;
        const V part = first_root(s0, d, b, discriminant<V, arithmetic>(s0, d, b));
        f = select<V>(dips, lowest.f * part, f);
        end = select<V>(dips, lowest.f, end);
        hits = hits | dips;
      }
    }
    hits = state.active & hits & !kept;
    if (any_lane<V>(hits)) f = refined(path, f, end, terms.bend.newton_steps, terms.bend.is_far, V(T(-1)));
    return {f, hits};
  }
}

// A path as a surface sees it. If forces bend it, `bent` and `slip` are the path, and `way` has its curvature at the start.
template <class V, Arithmetic arithmetic>
struct SeenPath {
  Path<V> way;
  bool is_flow;
  FlowPath<V, arithmetic> bent;
  Slip<V> slip;
};

template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::always_inline]] inline SeenPath<V, arithmetic> seen_path_of(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                                   [[maybe_unused]] const Trajectory<V>& own,
                                                                   const ImpactState<V, arithmetic, form>& state) noexcept {
  SeenPath<V, arithmetic> way;
  way.way = path(surface, m, state.t);
  way.is_flow = form == PathForm::flow && surface.sweep == ContactPath::curve;
  if constexpr (form == PathForm::flow) {
    way.bent = flow_path<V, arithmetic>(own, state);
    way.slip = slip_of(surface, own, m, state.t);
    if (!way.is_flow || !surface.finds_dips) return way;
    const V half_square = V(Scalar<V>(0.5)) * (state.left * state.left);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      V& a = way.way.a[axis];
      a = half_square * subtract_product<arithmetic>(way.bent.F[axis], state.bending->q[axis], way.bent.u[axis]);
      if (way.slip.is_there) a = a + way.slip.q[axis];
    }
  }
  return way;
}

// Along a straight line or a parabola from r0.
template <class V, Arithmetic arithmetic>
struct SphereCurve {
  const Three<V>& r0;
  const Path<V>& way;
  void operator()(V f, Three<V>& r, Three<V>& tangent) const noexcept {
    r = along<V, arithmetic>(r0, way, f);
    tangent = multiply_add<arithmetic>(f + f, way.a, way.u);
  }
};
template <class V, Arithmetic arithmetic>
struct SphereFlow {
  const Three<V>& r0;
  const FlowPath<V, arithmetic>& path;
  const Slip<V>& slip;
  const ImpactState<V, arithmetic, PathForm::flow>& state;
  void operator()(V f, Three<V>& r, Three<V>& tangent) const noexcept {
    const Responses<V> P = (*state.bending)(f * state.left);
    r = r0 + path.way(P);
    tangent = state.left * path.rate(P);
    if (!slip.is_there) return;
    r = multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, slip.q, slip.l), r);
    tangent = multiply_add<arithmetic>(f + f, slip.q, tangent + slip.l);
  }
};

template <class V>
struct SphereEnd {
  V f, g, slope;
};

template <class V, Arithmetic arithmetic, class Way>
SphereEnd<V> newton_to_sphere(const Surface<Scalar<V>>& surface, const Way& way, V f, int steps, bool halves) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V half(T(0.5));
  const V k(surface.half_curvature);
  const V square(surface.radius * surface.radius);
  V low = zero;
  V high = one;
  for (int step = 0;; ++step) {
    Three<V> r, tangent;
    way(f, r, tangent);
    const V g = k * (dot<arithmetic>(r, r) - square);
    const V slope = (k + k) * dot<arithmetic>(r, tangent);
    if (step == steps) return {f, g, slope};
    if (halves) {
      const Mask<V> is_beyond = g < zero;
      high = select<V>(is_beyond, f, high);
      low = select<V>(is_beyond, low, f);
    }
    const V next = f - quotient<V>(g, slope);
    const Mask<V> is_good = (slope < zero) & (next >= low) & (next <= high);
    f = select<V>(is_good, next, halves ? half * (low + high) : f);
  }
}

// Returns the distance within which only rounding keeps lanes off a curved surface. If it did not count as 0, it would make an
// impact of its own with its square root: 1e-8 m/s in float64.
template <class V>
V at_surface(const Surface<Scalar<V>>& surface, const Trajectory<V>& own, const Three<V>& r) noexcept {
  return V(4 * std::numeric_limits<Scalar<V>>::epsilon()) * ((one_norm(own.x0) + one_norm(r)) + V(surface.radius));
}

template <class V, Arithmetic arithmetic, PathForm form>
Crossing<V> cross_sphere(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                         const Trajectory<V>& own, const ImpactState<V, arithmetic, form>& state, Mask<V> held,
                         V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V k(surface.half_curvature);
  const V square(surface.radius * surface.radius);
  const auto bend = seen_path_of<V, arithmetic, form>(surface, m, own, state);
  const Path<V>& way = bend.way;
  const Three<V> r0 = m.x0 - three<V>(surface.center);
  const Three<V> r1 = m.x1 - three<V>(surface.center);

  const V start = k * (dot<arithmetic>(r0, r0) - square);
  const V g0 = select<V>(held | (start < at_surface(surface, own, r0)), zero, start);
  const V g1 = k * (dot<arithmetic>(r1, r1) - square);
  const V d0 = (k + k) * dot<arithmetic>(r0, way.u);
  const V across = dot<arithmetic>(r0, way.a);
  const V b = k * (dot<arithmetic>(way.u, way.u) + (across + across));
  const V c = (g1 - g0) - d0;

  const V disc = discriminant<V, arithmetic>(g0, d0, b);
  const V taylor = first_root(g0, d0, b, disc);
  const Mask<V> found = (disc >= zero) & ((d0 < zero) | (b < zero)) & (taylor <= one);
  const V secant = first_root(g0, d0, c, discriminant<V, arithmetic>(g0, d0, c));
  V f = select<V>(found, taylor, secant);
  f = select<V>(f < one, f, one);

  SphereEnd<V> end;
  if constexpr (form == PathForm::flow) {
    if (bend.is_flow) {
      const int steps = terms.bend.is_far ? 3 * newton_steps : newton_steps;
      end = newton_to_sphere<V, arithmetic>(surface, SphereFlow<V, arithmetic>{r0, bend.bent, bend.slip, state}, f, steps,
                                            terms.bend.is_far && !surface.finds_dips);
    } else {
      end = newton_to_sphere<V, arithmetic>(surface, SphereCurve<V, arithmetic>{r0, way}, f, newton_steps, false);
    }
  } else {
    end = newton_to_sphere<V, arithmetic>(surface, SphereCurve<V, arithmetic>{r0, way}, f, newton_steps, false);
  }
  const V scale = (one_norm(r0) + one_norm(way.u)) + V(surface.radius);
  const Mask<V> dips = found & (end.slope < zero) & (end.g <= V(16 * std::numeric_limits<T>::epsilon()) * scale);
  return {end.f, ((g1 < zero) | dips) & !(held & stays(surface, d0, c, low))};
}

// Finds the crossing of a body with a signed distance.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Crossing<V> cross_solid(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                          [[maybe_unused]] const Trajectory<V>& own,
                                          const ImpactState<V, arithmetic, form>& state, Mask<V> held, V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const auto bend = seen_path_of<V, arithmetic, form>(surface, m, own, state);
  const Path<V>& way = bend.way;
  const Touch<V> start = touch<V, arithmetic>(surface, m.x0);
  const V s0 = select<V>(held | (start.s < at_surface(surface, own, m.x0)), zero, start.s);
  const V s1 = touch<V, arithmetic>(surface, m.x1).s;
  const V d0 = dot<arithmetic>(start.n, way.u);
  const V c = (s1 - s0) - d0;
  const V tolerance = V(16 * std::numeric_limits<T>::epsilon()) * ((one_norm(m.x0) + one_norm(way.u)) + V(surface.radius));
  const Mask<V> kept = held & stays(surface, d0, c, low);
  const Approach<V> found =
      surface.shape == Shape::mesh
          ? march<V, arithmetic>(surface, m.x0, way.u, way.a, {start.n, select<V>(held, zero, start.s)}, state.active & !kept)
          : approach<V, arithmetic>(surface, m.x0, way.u, way.a, {start.n, s0}, tolerance, state.active & !kept);
  const V secant = first_root(s0, d0, c, discriminant<V, arithmetic>(s0, d0, c));
  V f = select<V>(found.arrives, found.f, select<V>(secant < one, secant, one));
  Mask<V> hits = (s1 < zero) | found.arrives;
  if constexpr (form == PathForm::flow) {
    if (bend.is_flow && any_lane<V>(state.active & hits & !kept)) {
      const SphereFlow<V, arithmetic> along_it{m.x0, bend.bent, bend.slip, state};
      const auto gap = [&](V at) {
        Three<V> x, tangent;
        along_it(at, x, tangent);
        const Touch<V> there = touch<V, arithmetic>(surface, x);
        return Gap<V>{there.s, dot<arithmetic>(there.n, tangent)};
      };
      f = refined(gap, f, one, solid_newton_steps, true, at_surface(surface, own, m.x0));
      const Gap<V> end = gap(f);
      const V near = surface.shape == Shape::mesh ? V(surface.solid.cell / 1024) : tolerance;
      hits = (s1 < zero) | (found.arrives & (end.slope < zero) & (end.s <= near));
    }
  }
  return {f, hits & !kept};
}

template <class V, Arithmetic arithmetic, PathForm form>
Crossing<V> cross(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                  const ImpactState<V, arithmetic, form>& state, Mask<V> held, V low) noexcept {
  Trajectory<V> room;
  const Trajectory<V>& seen = seen_from<V, arithmetic>(surface, m, state.t, room);
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane<V, arithmetic, form>(terms, surface, seen, m, state, held, low);
    case Shape::sphere:
      return cross_sphere<V, arithmetic, form>(terms, surface, seen, m, state, held, low);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return cross_solid<V, arithmetic, form>(surface, seen, m, state, held, low);
}

}  // namespace
}  // namespace dvdx
