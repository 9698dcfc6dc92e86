// The time of impact, scalar: written by hand beside time_of_impact.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "contact/pass/impact_state_reference.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
T discriminant(T s0, T d0, T c) noexcept {
  return subtract_product<arithmetic>(d0 * d0, 4 * c, s0);
}

template <class T>
T first_root(T s0, T d0, T c, T disc) noexcept {
  const T root = disc > 0 ? std::sqrt(disc) : T(0);
  if (d0 < 0) return (s0 + s0) / (root - d0);
  return (d0 + (s0 > 0 ? root : d0)) / (-2 * c);
}

template <class T, class GapAt>
T refined(const GapAt& gap, T f, T end, int steps, bool halves, T close) noexcept {
  T low = 0;
  T high = end;
  for (int step = 0; step < steps; ++step) {
    const auto [s, slope] = gap(f);
    (s < 0 ? high : low) = f;
    const T next = f - s / slope;
    if (slope < 0 && next >= low && next <= high) {
      f = next;
    } else if (halves && !(std::abs(s) <= close)) {
      f = T(0.5) * (low + high);
    }
  }
  return f;
}

template <class T>
struct Gap {
  T s, slope;
};
template <class T>
struct Lowest {
  T f, s;
};

template <Arithmetic arithmetic, class T>
class PlanePath {
 public:
  PlanePath(const Surface<T>& surface, const Particle<T>& p, const ImpactState<arithmetic, PathForm::flow, T>& state, T s0,
            const Slip<T>& slip) noexcept
      : state_(state),
        path_(flow_path(p, state)),
        n_(surface.n),
        s0_(s0),
        slips_(slip.is_there),
        l_(dot<arithmetic>(n_, slip.l)),
        q_(dot<arithmetic>(n_, slip.q)) {}

  [[nodiscard]] Gap<T> operator()(T f) const noexcept {
    const Responses<T> P = (*state_.bending)(f * state_.left);
    const Gap<T> gap{s0_ + dot<arithmetic>(n_, path_.way(P)), state_.left * dot<arithmetic>(n_, path_.rate(P))};
    if (!slips_) return gap;
    return {multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, q_, l_), gap.s),
            multiply_add<arithmetic>(f + f, q_, gap.slope + l_)};
  }

  [[nodiscard]] Lowest<T> lowest(T f, int steps) const noexcept {
    for (int step = 0; step < steps; ++step) {
      const Responses<T> P = (*state_.bending)(f * state_.left);
      Vector<T> second;
      for (std::size_t k = 0; k < 3; ++k) {
        const T pull = multiply_add<arithmetic>(state_.bending->q[k], P.P0[k], state_.bending->w[k] * P.P1[k]);
        second[k] = subtract_product<arithmetic>(path_.F[k] * P.P0[k], path_.u[k], pull);
      }
      if (path_.drive != nullptr) second = sum_of(second, driven<arithmetic>(*path_.drive, P.P1, P.P2, P.P3));
      T slope = dot<arithmetic>(n_, path_.rate(P));
      T bend = state_.left * dot<arithmetic>(n_, second);
      if (slips_) {
        slope = multiply_add<arithmetic>(state_.left, slope, multiply_add<arithmetic>(f + f, q_, l_));
        bend = multiply_add<arithmetic>(state_.left, bend, q_ + q_);
      }
      const T next = f - slope / bend;
      if (next > 0 && next < 1) f = next;
    }
    return {f, (*this)(f).s};
  }

 private:
  const ImpactState<arithmetic, PathForm::flow, T>& state_;
  FlowPath<arithmetic, T> path_;
  Vector<T> n_;
  T s0_;
  bool slips_;
  T l_, q_;
};

// p: the path as the surface sees it; own: the path itself.
template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross_plane(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p, const Particle<T>& own,
                             const ImpactState<arithmetic, form, T>& state, bool is_held, T low) noexcept {
  T s0 = touch<arithmetic>(surface, p.x0).s;
  if (is_held || s0 < 0) s0 = 0;
  const T s1 = touch<arithmetic>(surface, p.x1).s;
  const T d0 = surface.sweep == ContactPath::line ? s1 - s0 : state.t * dot<arithmetic>(surface.n, p.v0);
  const T c = (s1 - s0) - d0;
  const T disc = discriminant<arithmetic>(s0, d0, c);
  if (is_held && (surface.response == Response::end_on_surface || d0 <= 0 || d0 * d0 <= -(low * c))) return std::nullopt;
  if constexpr (form == PathForm::parabola) {
    const bool dips = surface.finds_dips && d0 < 0 && disc > 0 && -d0 < c + c;
    if (!(s1 < 0 || dips)) return std::nullopt;
    const T f = first_root(s0, d0, c, disc);
    return f < 1 ? f : T(1);
  } else {
    T f = first_root(s0, d0, c, disc);
    if (!(f < 1)) f = 1;
    if (surface.sweep == ContactPath::line) return s1 < 0 ? std::optional<T>(f) : std::nullopt;
    const PlanePath<arithmetic, T> path(surface, own, state, s0, slip_of(surface, own, p, state.t));
    T end = 1;
    if (!(s1 < 0)) {
      if (!(surface.finds_dips && d0 < 0 && multiply_add<arithmetic>(terms.bend.corner, d0, s0) < 0)) return std::nullopt;
      const Lowest<T> lowest = path.lowest(-d0 / (c + c), terms.bend.newton_steps);
      if (!(lowest.s < 0)) return std::nullopt;
      const T d = lowest.f * d0;
      const T b = (lowest.s - s0) - d;
      f = lowest.f * first_root(s0, d, b, discriminant<arithmetic>(s0, d, b));
      end = lowest.f;
    }
    return refined(path, f, end, terms.bend.newton_steps, terms.bend.is_far, T(-1));
  }
}

// A path as a surface sees it. If forces bend it, `bent` and `slip` are the path, and `way` has its curvature at the start.
template <Arithmetic arithmetic, class T>
struct SeenPath {
  Path<T> way;
  bool is_flow;
  FlowPath<arithmetic, T> bent;
  Slip<T> slip;
};

template <Arithmetic arithmetic, PathForm form, class T>
SeenPath<arithmetic, T> seen_path_of(const Surface<T>& surface, const Particle<T>& p, [[maybe_unused]] const Particle<T>& own,
                                     const ImpactState<arithmetic, form, T>& state) noexcept {
  SeenPath<arithmetic, T> way;
  way.way = path(surface, p, state.t);
  way.is_flow = form == PathForm::flow && surface.sweep == ContactPath::curve;
  if constexpr (form == PathForm::flow) {
    way.bent = flow_path(own, state);
    way.slip = slip_of(surface, own, p, state.t);
    if (!way.is_flow || !surface.finds_dips) return way;
    const T half_square = T(0.5) * (state.left * state.left);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T& a = way.way.a[axis];
      a = half_square * subtract_product<arithmetic>(way.bent.F[axis], state.bending->q[axis], way.bent.u[axis]);
      if (way.slip.is_there) a = a + way.slip.q[axis];
    }
  }
  return way;
}

// Sets the place and the tangent at the part `at` of a path that forces bend, from `start` on.
template <Arithmetic arithmetic, PathForm form, class T>
void go_along(const Vector<T>& start, const SeenPath<arithmetic, T>& bend, const ImpactState<arithmetic, form, T>& state, T at,
              Vector<T>& x, Vector<T>& tangent) noexcept {
  const Responses<T> P = (*state.bending)(at * state.left);
  const Vector<T> passed = bend.bent.way(P);
  const Vector<T> rate = bend.bent.rate(P);
  const Slip<T>& slip = bend.slip;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    x[axis] = start[axis] + passed[axis];
    tangent[axis] = state.left * rate[axis];
    if (!slip.is_there) continue;
    x[axis] = multiply_add<arithmetic>(at, multiply_add<arithmetic>(at, slip.q[axis], slip.l[axis]), x[axis]);
    tangent[axis] = multiply_add<arithmetic>(at + at, slip.q[axis], tangent[axis] + slip.l[axis]);
  }
}

template <class T>
struct SphereEnd {
  T f, g, slope;
};

// way(f, r, tangent) sets r and the tangent at f.
template <Arithmetic arithmetic, class T, class Way>
SphereEnd<T> newton_to_sphere(const Surface<T>& surface, const Way& way, T f, int steps, bool halves) noexcept {
  const T k = surface.half_curvature;
  const T square = surface.radius * surface.radius;
  T low = 0;
  T high = 1;
  for (int step = 0;; ++step) {
    Vector<T> r, tangent;
    way(f, r, tangent);
    const T g = k * (dot<arithmetic>(r, r) - square);
    const T slope = (k + k) * dot<arithmetic>(r, tangent);
    if (step == steps) return {f, g, slope};
    if (halves) (g < 0 ? high : low) = f;
    const T next = f - g / slope;
    if (slope < 0 && next >= low && next <= high) {
      f = next;
    } else if (halves) {
      f = T(0.5) * (low + high);
    }
  }
}

// Returns the distance within which only rounding keeps a particle off a curved surface. If it did not count as 0, it would
// make an impact of its own with its square root: 1e-8 m/s in float64.
template <class T>
T at_surface(const Surface<T>& surface, const Particle<T>& own, const Vector<T>& r) noexcept {
  return 4 * std::numeric_limits<T>::epsilon() * ((one_norm(own.x0) + one_norm(r)) + surface.radius);
}

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross_sphere(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p, const Particle<T>& own,
                              const ImpactState<arithmetic, form, T>& state, bool is_held, T low) noexcept {
  const T k = surface.half_curvature;
  const T square = surface.radius * surface.radius;
  const SeenPath<arithmetic, T> bend = seen_path_of(surface, p, own, state);
  const Path<T>& way = bend.way;
  const Vector<T> r0 = difference(p.x0, surface.center);
  const Vector<T> r1 = difference(p.x1, surface.center);

  T g0 = k * (dot<arithmetic>(r0, r0) - square);
  if (is_held || g0 < at_surface(surface, own, r0)) g0 = 0;
  const T g1 = k * (dot<arithmetic>(r1, r1) - square);
  const T d0 = (k + k) * dot<arithmetic>(r0, way.u);
  const T across = dot<arithmetic>(r0, way.a);
  const T b = k * (dot<arithmetic>(way.u, way.u) + (across + across));
  const T c = (g1 - g0) - d0;
  if (is_held && (surface.response == Response::end_on_surface || d0 <= 0 || d0 * d0 <= -(low * c))) return std::nullopt;

  const T disc = discriminant<arithmetic>(g0, d0, b);
  T f = first_root(g0, d0, b, disc);
  const bool found = disc >= 0 && (d0 < 0 || b < 0) && f <= 1;
  if (!found) f = first_root(g0, d0, c, discriminant<arithmetic>(g0, d0, c));
  if (!(f < 1)) f = 1;

  const auto on_curve = [&](T at, Vector<T>& r, Vector<T>& tangent) {
    r = along<arithmetic>(r0, way, at);
    for (std::size_t axis = 0; axis < 3; ++axis) tangent[axis] = multiply_add<arithmetic>(at + at, way.a[axis], way.u[axis]);
  };
  SphereEnd<T> end;
  if (bend.is_flow) {
    const auto on_flow = [&](T at, Vector<T>& r, Vector<T>& tangent) { go_along(r0, bend, state, at, r, tangent); };
    const int steps = terms.bend.is_far ? 3 * newton_steps : newton_steps;
    end = newton_to_sphere<arithmetic>(surface, on_flow, f, steps, terms.bend.is_far && !surface.finds_dips);
  } else {
    end = newton_to_sphere<arithmetic>(surface, on_curve, f, newton_steps, false);
  }
  const T scale = (one_norm(r0) + one_norm(way.u)) + surface.radius;
  const bool dips = found && end.slope < 0 && end.g <= 16 * std::numeric_limits<T>::epsilon() * scale;
  if (!(g1 < 0 || dips)) return std::nullopt;
  return end.f;
}

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross_solid(const Surface<T>& surface, const Particle<T>& p, const Particle<T>& own,
                             const ImpactState<arithmetic, form, T>& state, bool is_held, T low) noexcept {
  const SeenPath<arithmetic, T> bend = seen_path_of(surface, p, own, state);
  const Path<T>& way = bend.way;
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T s0 = is_held || start.s < at_surface(surface, own, p.x0) ? T(0) : start.s;
  const T s1 = touch<arithmetic>(surface, p.x1).s;
  const T d0 = dot<arithmetic>(start.n, way.u);
  const T c = (s1 - s0) - d0;
  const T tolerance = 16 * std::numeric_limits<T>::epsilon() * ((one_norm(p.x0) + one_norm(way.u)) + surface.radius);
  if (is_held && (surface.response == Response::end_on_surface || d0 <= 0 || d0 * d0 <= -(low * c))) return std::nullopt;
  const std::optional<T> found = surface.shape == Shape::mesh
                                     ? march<arithmetic>(surface, p.x0, way.u, way.a, {start.n, is_held ? T(0) : start.s})
                                     : approach<arithmetic>(surface, p.x0, way.u, way.a, {start.n, s0}, tolerance);
  if (!(s1 < 0 || found)) return std::nullopt;
  const T secant = first_root(s0, d0, c, discriminant<arithmetic>(s0, d0, c));
  T f = found ? *found : secant < 1 ? secant : T(1);
  if (!bend.is_flow) return f;
  if constexpr (form == PathForm::flow) {
    const auto gap = [&](T at) {
      Vector<T> x, tangent;
      go_along(p.x0, bend, state, at, x, tangent);
      const Touch<T> there = touch<arithmetic>(surface, x);
      return Gap<T>{there.s, dot<arithmetic>(there.n, tangent)};
    };
    f = refined(gap, f, T(1), solid_newton_steps, true, at_surface(surface, own, p.x0));
    const Gap<T> end = gap(f);
    const T near = surface.shape == Shape::mesh ? surface.solid.cell / 1024 : tolerance;
    if (!(s1 < 0 || (end.slope < 0 && end.s <= near))) return std::nullopt;
  }
  return f;
}

}  // namespace dvdx::reference
