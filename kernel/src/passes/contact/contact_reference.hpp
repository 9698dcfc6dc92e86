// The contact pass, scalar: written by hand beside contact.inl.hpp, the same letters in the same order of operations.
// Derivations and sources stand in contact.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "passes/contact/bend_reference.hpp"
#include "passes/contact/contact.hpp"
#include "passes/contact/contact_log.hpp"
#include "passes/contact/recording_reference.hpp"
#include "passes/contact/shape_reference.hpp"
#include "passes/particle.hpp"
#include "passes/terms.hpp"

namespace dvdx::reference {

// ---------------------------------------------------------------------------------- surfaces that move

template <Arithmetic arithmetic, class T>
Vector<T> cross_product(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {subtract_product<arithmetic>(a[1] * b[2], a[2], b[1]), subtract_product<arithmetic>(a[2] * b[0], a[0], b[2]),
          subtract_product<arithmetic>(a[0] * b[1], a[1], b[0])};
}

template <Arithmetic arithmetic, class T>
T by_powers(const std::array<T, 7>& terms, T x) noexcept {
  T sum = terms[6];
  for (std::size_t n = 6; n-- > 0;) sum = multiply_add<arithmetic>(sum, x, terms[n]);
  return sum;
}

// r, turned by w.
template <Arithmetic arithmetic, class T>
Vector<T> turned_by(const Vector<T>& w, const Vector<T>& r) noexcept {
  const T square = dot<arithmetic>(w, w);
  const T a = by_powers<arithmetic>(turn_sine<T>, square);
  const T b = by_powers<arithmetic>(turn_versine<T>, square);
  const Vector<T> once = cross_product<arithmetic>(w, r);
  const Vector<T> twice = cross_product<arithmetic>(w, once);
  Vector<T> to;
  for (std::size_t k = 0; k < 3; ++k) to[k] = multiply_add<arithmetic>(b, twice[k], multiply_add<arithmetic>(a, once[k], r[k]));
  return to;
}

template <class T>
Vector<T> scaled_by(T s, const Vector<T>& a) noexcept {
  return {s * a[0], s * a[1], s * a[2]};
}

// From the axis' point to x, t before the end.
template <Arithmetic arithmetic, class T>
Vector<T> arm_of(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  Vector<T> arm;
  for (std::size_t k = 0; k < 3; ++k) arm[k] = multiply_add<arithmetic>(t, surface.u[k], x[k]) - surface.at[k];
  return arm;
}

// That of the surface at x, t before the end.
template <Arithmetic arithmetic, class T>
Vector<T> velocity_at(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  if (surface.movement != Movement::turns) return surface.u;
  const Vector<T> turn = cross_product<arithmetic>(surface.omega, arm_of<arithmetic>(surface, x, t));
  return {surface.u[0] + turn[0], surface.u[1] + turn[1], surface.u[2] + turn[2]};
}

// Where a surface takes what lies at x, t before the end.
template <Arithmetic arithmetic, class T>
Vector<T> taken_along(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  Vector<T> to;
  if (surface.movement != Movement::turns) {
    for (std::size_t k = 0; k < 3; ++k) to[k] = multiply_add<arithmetic>(t, surface.u[k], x[k]);
    return to;
  }
  const Vector<T> arm = turned_by<arithmetic>(scaled_by(t, surface.omega), arm_of<arithmetic>(surface, x, t));
  for (std::size_t k = 0; k < 3; ++k) to[k] = surface.at[k] + arm[k];
  return to;
}

template <Arithmetic arithmetic, class T>
Particle<T> seen_from(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  if (surface.movement == Movement::rest) return p;
  Particle<T> seen = p;
  seen.x0 = taken_along<arithmetic>(surface, p.x0, t);
  seen.v0 = difference(p.v0, velocity_at<arithmetic>(surface, p.x0, t));
  if (surface.movement == Movement::turns) seen.v0 = turned_by<arithmetic>(scaled_by(t, surface.omega), seen.v0);
  seen.v1 = difference(p.v1, velocity_at<arithmetic>(surface, p.x1, T(0)));
  return seen;
}

// l and q of a bent path, both 0 at rest.
template <class T>
struct Slip {
  bool is_there = false;
  Vector<T> l{}, q{};
};

template <class T>
Slip<T> slip_of(const Surface<T>& surface, const Particle<T>& p, const Particle<T>& seen, T t) noexcept {
  Slip<T> slip;
  slip.is_there = surface.movement != Movement::rest;
  if (!slip.is_there) return slip;
  slip.l = scaled_by(t, difference(seen.v0, p.v0));
  if (surface.movement == Movement::turns) {
    slip.q = difference(difference(difference(seen.x1, seen.x0), difference(p.x1, p.x0)), slip.l);
  }
  return slip;
}

// ---------------------------------------------------------------------------------- does anything happen at all

template <Arithmetic arithmetic, class T>
bool may_touch_plane(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  if (dot<arithmetic>(surface.n, p.x1) < surface.d) return true;
  return surface.finds_dips && dot<arithmetic>(surface.n, middle) < surface.d;
}

template <Arithmetic arithmetic, class T>
bool may_touch_sphere(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  const Vector<T> r0 = difference(p.x0, surface.center);
  const Vector<T> r1 = difference(p.x1, surface.center);
  const Vector<T> rm = difference(middle, surface.center);
  const T square = surface.radius * surface.radius;
  if (surface.side < 0) {
    if (dot<arithmetic>(r1, r1) > square) return true;
    return surface.finds_dips && dot<arithmetic>(rm, rm) > square;
  }
  const T reach = square * dot<arithmetic>(r0, r0);
  const auto is_near = [&](const Vector<T>& r) {
    const T along = dot<arithmetic>(r0, r);
    return along <= 0 || along * along <= reach;
  };
  return is_near(r1) || (surface.finds_dips && is_near(rm));
}

template <Arithmetic arithmetic, class T>
bool may_touch(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return may_touch_plane<arithmetic>(surface, p, middle);
    case Shape::sphere:
      return may_touch_sphere<arithmetic>(surface, p, middle);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return may_touch_solid<arithmetic>(surface, p, middle);
}

// t: what remains of the step; corner: the part of it after which the path's tangents meet, in seconds.
template <Arithmetic arithmetic, class T>
bool may_touch_moving(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle, T t, T corner) noexcept {
  if (surface.movement == Movement::rest) {
    return may_touch<arithmetic>(surface, p, middle) && (!surface.is_searched || overlaps(surface, p, middle));
  }
  const Particle<T> seen = seen_from<arithmetic>(surface, p, t);
  Vector<T> between;
  for (std::size_t k = 0; k < 3; ++k) between[k] = multiply_add<arithmetic>(corner, seen.v0[k], seen.x0[k]);
  return may_touch<arithmetic>(surface, seen, between) && (!surface.is_searched || overlaps(surface, seen, between));
}

template <Arithmetic arithmetic, class T>
bool may_touch(const Terms<T>& terms, const Particle<T>& p) noexcept {
  const T corner = terms.h * terms.bend.corner;
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(corner, p.v0[k], p.x0[k]);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (may_touch_moving<arithmetic>(terms.surfaces[j], p, middle, terms.h, corner)) return true;
  }
  return false;
}

// ---------------------------------------------------------------------------------- geometry

template <Arithmetic arithmetic, class T>
Touch<T> touch_sphere(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Vector<T> r = difference(x, surface.center);
  const T length = std::sqrt(dot<arithmetic>(r, r));
  const T s = surface.side * (length - surface.radius);
  if (length > 0) {
    const T scale = surface.side / length;
    return {{scale * r[0], scale * r[1], scale * r[2]}, s};
  }
  return {{surface.side * r[0], surface.side, surface.side * r[2]}, s};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch(const Surface<T>& surface, const Vector<T>& x) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return {surface.n, dot<arithmetic>(surface.n, x) - surface.d};
    case Shape::sphere:
      return touch_sphere<arithmetic>(surface, x);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return touch_solid<arithmetic>(surface, x);
}

template <class T>
struct Path {
  Vector<T> u{}, a{};
};

template <class T>
Path<T> path(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  const Vector<T> chord = difference(p.x1, p.x0);
  if (goes_straight(surface)) return {chord, {}};
  Path<T> path;
  for (std::size_t k = 0; k < 3; ++k) {
    path.u[k] = t * p.v0[k];
    path.a[k] = chord[k] - path.u[k];
  }
  return path;
}

// The surfaces that hold a particle for the rest of its step, and what they changed at its end.
template <class T>
struct Held {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::size_t a = none, b = none, c = none;
  Vector<T> dx{}, dv{};

  [[nodiscard]] bool has(std::size_t j) const noexcept { return a == j || b == j || c == j; }
};

// What is left of a particle's step.
template <Arithmetic arithmetic, PathForm form, class T>
struct Course {
  T direction, t;
  std::size_t last;  // the surface hit last, or the count of surfaces
  Held<T> held{};
  const Bending<arithmetic, T>* bending = nullptr;
  T h = 0, left = 1;
  Responses<T> end{};
  Drive<T> drive{};
  Recording<T>* recording = nullptr;  // null: nobody asks
};

template <Arithmetic arithmetic, class T>
Vector<T> driven(const Drive<T>& drive, const Vector<T>& first, const Vector<T>& second, const Vector<T>& third) noexcept {
  Vector<T> sum;
  for (std::size_t k = 0; k < 3; ++k) {
    sum[k] = multiply_add<arithmetic>(drive.D3[k], third[k],
                                      multiply_add<arithmetic>(drive.D2[k], second[k], drive.D1[k] * first[k]));
  }
  return sum;
}

template <class T>
Vector<T> sum_of(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

template <Arithmetic arithmetic, class T>
struct FlowPath {
  Vector<T> u{}, F{};
  const Drive<T>* drive = nullptr;

  [[nodiscard]] Vector<T> way(const Responses<T>& P) const noexcept {
    Vector<T> way;
    for (std::size_t k = 0; k < 3; ++k) way[k] = multiply_add<arithmetic>(F[k], P.P2[k], u[k] * P.P1[k]);
    return drive != nullptr ? sum_of(way, driven<arithmetic>(*drive, P.P3, P.P4, P.P5)) : way;
  }
  [[nodiscard]] Vector<T> rate(const Responses<T>& P) const noexcept {
    Vector<T> rate;
    for (std::size_t k = 0; k < 3; ++k) rate[k] = multiply_add<arithmetic>(F[k], P.P1[k], u[k] * P.P0[k]);
    return drive != nullptr ? sum_of(rate, driven<arithmetic>(*drive, P.P2, P.P3, P.P4)) : rate;
  }
};

template <class T>
T inverse(T P) noexcept {
  return P != 0 ? 1 / P : T(0);
}

template <Arithmetic arithmetic, class T>
FlowPath<arithmetic, T> flow_path(const Particle<T>& p, const Course<arithmetic, PathForm::flow, T>& course) noexcept {
  FlowPath<arithmetic, T> path;
  const auto& P = course.end;
  Vector<T> way = difference(p.x1, p.x0);
  if (course.bending->is_driven()) {
    path.drive = &course.drive;
    way = difference(way, driven<arithmetic>(course.drive, P.P3, P.P4, P.P5));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    path.u[k] = course.h * p.v0[k];
    path.F[k] = subtract_product<arithmetic>(way[k], path.u[k], P.P1[k]) * inverse(P.P2[k]);
  }
  return path;
}

template <Arithmetic arithmetic, class T>
Vector<T> along(const Vector<T>& start, const Path<T>& path, T f) noexcept {
  Vector<T> x;
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, path.a[k], path.u[k]), start[k]);
  }
  return x;
}

// ---------------------------------------------------------------------------------- time of impact

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
  PlanePath(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, PathForm::flow, T>& course, T s0,
            const Slip<T>& slip) noexcept
      : course_(course),
        path_(flow_path(p, course)),
        n_(surface.n),
        s0_(s0),
        slips_(slip.is_there),
        l_(dot<arithmetic>(n_, slip.l)),
        q_(dot<arithmetic>(n_, slip.q)) {}

  [[nodiscard]] Gap<T> operator()(T f) const noexcept {
    const Responses<T> P = (*course_.bending)(f * course_.left);
    const Gap<T> gap{s0_ + dot<arithmetic>(n_, path_.way(P)), course_.left * dot<arithmetic>(n_, path_.rate(P))};
    if (!slips_) return gap;
    return {multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, q_, l_), gap.s),
            multiply_add<arithmetic>(f + f, q_, gap.slope + l_)};
  }

  [[nodiscard]] Lowest<T> lowest(T f, int steps) const noexcept {
    for (int step = 0; step < steps; ++step) {
      const Responses<T> P = (*course_.bending)(f * course_.left);
      Vector<T> second;
      for (std::size_t k = 0; k < 3; ++k) {
        const T pull = multiply_add<arithmetic>(course_.bending->q[k], P.P0[k], course_.bending->w[k] * P.P1[k]);
        second[k] = subtract_product<arithmetic>(path_.F[k] * P.P0[k], path_.u[k], pull);
      }
      if (path_.drive != nullptr) second = sum_of(second, driven<arithmetic>(*path_.drive, P.P1, P.P2, P.P3));
      T slope = dot<arithmetic>(n_, path_.rate(P));
      T bend = course_.left * dot<arithmetic>(n_, second);
      if (slips_) {
        slope = multiply_add<arithmetic>(course_.left, slope, multiply_add<arithmetic>(f + f, q_, l_));
        bend = multiply_add<arithmetic>(course_.left, bend, q_ + q_);
      }
      const T next = f - slope / bend;
      if (next > 0 && next < 1) f = next;
    }
    return {f, (*this)(f).s};
  }

 private:
  const Course<arithmetic, PathForm::flow, T>& course_;
  FlowPath<arithmetic, T> path_;
  Vector<T> n_;
  T s0_;
  bool slips_;
  T l_, q_;
};

// p: as the surface sees it; own: as it is.
template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross_plane(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p, const Particle<T>& own,
                             const Course<arithmetic, form, T>& course, bool is_held, T low) noexcept {
  T s0 = touch<arithmetic>(surface, p.x0).s;
  if (is_held || s0 < 0) s0 = 0;
  const T s1 = touch<arithmetic>(surface, p.x1).s;
  const T d0 = surface.sweep == ContactPath::line ? s1 - s0 : course.t * dot<arithmetic>(surface.n, p.v0);
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
    const PlanePath<arithmetic, T> path(surface, own, course, s0, slip_of(surface, own, p, course.t));
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

// A path as a surface sees it. Where forces bend it, `way` has its curvature at its start, and `bent` and `slip` are the path.
template <Arithmetic arithmetic, class T>
struct Way {
  Path<T> way;
  bool is_flow;
  FlowPath<arithmetic, T> bent;
  Slip<T> slip;
};

template <Arithmetic arithmetic, PathForm form, class T>
Way<arithmetic, T> way_of(const Surface<T>& surface, const Particle<T>& p, [[maybe_unused]] const Particle<T>& own,
                          const Course<arithmetic, form, T>& course) noexcept {
  Way<arithmetic, T> way;
  way.way = path(surface, p, course.t);
  way.is_flow = form == PathForm::flow && surface.sweep == ContactPath::curve;
  if constexpr (form == PathForm::flow) {
    way.bent = flow_path(own, course);
    way.slip = slip_of(surface, own, p, course.t);
    if (!way.is_flow || !surface.finds_dips) return way;
    const T half_square = T(0.5) * (course.left * course.left);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T& a = way.way.a[axis];
      a = half_square * subtract_product<arithmetic>(way.bent.F[axis], course.bending->q[axis], way.bent.u[axis]);
      if (way.slip.is_there) a = a + way.slip.q[axis];
    }
  }
  return way;
}

// To the part `at` of a path that forces bend, from `start`.
template <Arithmetic arithmetic, PathForm form, class T>
void go_along(const Vector<T>& start, const Way<arithmetic, T>& bend, const Course<arithmetic, form, T>& course, T at,
              Vector<T>& x, Vector<T>& tangent) noexcept {
  const Responses<T> P = (*course.bending)(at * course.left);
  const Vector<T> passed = bend.bent.way(P);
  const Vector<T> rate = bend.bent.rate(P);
  const Slip<T>& slip = bend.slip;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    x[axis] = start[axis] + passed[axis];
    tangent[axis] = course.left * rate[axis];
    if (!slip.is_there) continue;
    x[axis] = multiply_add<arithmetic>(at, multiply_add<arithmetic>(at, slip.q[axis], slip.l[axis]), x[axis]);
    tangent[axis] = multiply_add<arithmetic>(at + at, slip.q[axis], tangent[axis] + slip.l[axis]);
  }
}

template <class T>
struct SphereEnd {
  T f, g, slope;
};

// way(f, r, tangent)
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

// A distance below which rounding alone keeps a particle off a curved surface. Told apart from none, it would be an impact of
// its own with the square root of it: 1e-8 m/s in float64.
template <class T>
T at_surface(const Surface<T>& surface, const Particle<T>& own, const Vector<T>& r) noexcept {
  return 4 * std::numeric_limits<T>::epsilon() * ((one_norm(own.x0) + one_norm(r)) + surface.radius);
}

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross_sphere(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p, const Particle<T>& own,
                              const Course<arithmetic, form, T>& course, bool is_held, T low) noexcept {
  const T k = surface.half_curvature;
  const T square = surface.radius * surface.radius;
  const Way<arithmetic, T> bend = way_of(surface, p, own, course);
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
    const auto on_flow = [&](T at, Vector<T>& r, Vector<T>& tangent) { go_along(r0, bend, course, at, r, tangent); };
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
                             const Course<arithmetic, form, T>& course, bool is_held, T low) noexcept {
  const Way<arithmetic, T> bend = way_of(surface, p, own, course);
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
      go_along(p.x0, bend, course, at, x, tangent);
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

// ---------------------------------------------------------------------------------- friction

template <class T>
T kept_by_friction(T slide, T hold, T length) noexcept {
  if (!(hold > 0)) return 1;
  if (hold >= length) return 0;
  return 1 - slide / length;
}

// ---------------------------------------------------------------------------------- resting

template <class T>
struct Holder {
  std::size_t number = Held<T>::none;
  T s = 0, s0 = 0, mu = 0, hold = 0;
  Vector<T> n{};
  Vector<T> x0{}, v0{};  // the start as the surface sees it
  Vector<T> V{};         // its velocity at the end
};

template <Arithmetic arithmetic, class T>
Holder<T> holder_of(std::size_t number, const Surface<T>& surface, T s, T s0, const Vector<T>& n, const Particle<T>& p,
                    const Particle<T>& seen) noexcept {
  Holder<T> holder{
      .number = number, .s = s, .s0 = s0, .mu = surface.mu, .hold = surface.hold, .n = n, .x0 = seen.x0, .v0 = seen.v0};
  if (surface.movement != Movement::rest) holder.V = velocity_at<arithmetic>(surface, p.x1, T(0));
  return holder;
}

// s1: the distance at the end; s0 becomes that at the start.
template <Arithmetic arithmetic, PathForm form, class T>
bool may_hold(const Surface<T>& surface, T s1, const Particle<T>& p, const Course<arithmetic, form, T>& course, bool is_last,
              T& s0) noexcept {
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T low = 4 * low_bounce * eps * one_norm(p.x0);
  const T near = 2 * eps * ((one_norm(p.x0) + one_norm(p.x1)) + (surface.radius + surface.radius));
  const T d0 = course.t * dot<arithmetic>(start.n, p.v0);
  const T c = s1 - d0;
  s0 = start.s;
  if (!(s0 >= T(-0.5) * near && (is_last || s0 <= near))) return false;
  if (d0 > 0) return d0 * d0 <= -(low * c);
  return -d0 <= -(c + c) && surface.e * -d0 <= (1 - surface.e) * -c;
}

template <class T>
struct Two {
  T a, b;
};

template <Arithmetic arithmetic, class T>
Two<T> solve_two(T a, T b, T kappa) noexcept {
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  const T alone_a = a < 0 ? -a : T(0);
  const T alone_b = b < 0 ? -b : T(0);
  if (!(det > 64 * std::numeric_limits<T>::epsilon())) return {alone_a, 0};
  const T scale = 1 / det;
  const T both_a = scale * (kappa * b - a);
  const T both_b = scale * (kappa * a - b);
  if (both_a < 0) return {0, alone_b};
  if (both_b < 0) return {alone_a, 0};
  return {both_a, both_b};
}

template <class T>
struct HeldEnd {
  Vector<T> x{}, v{}, v0{};
  T slide = 0, hold = 0;
  std::array<T, 3> removed{};  // by each holder along its normal, of the end's velocity
};

template <Arithmetic arithmetic, class T>
HeldEnd<T> held_by_one(const Holder<T>& a, const Particle<T>& p, T direction) noexcept {
  const T vn = dot<arithmetic>(a.n, p.v1);
  const bool is_pressed = direction * vn < 0;
  const T removed = is_pressed ? std::abs(vn) : T(0);
  const T vn0 = dot<arithmetic>(a.n, p.v0);
  HeldEnd<T> end{.x = {}, .v = p.v1, .v0 = p.v0, .slide = a.mu * removed, .hold = a.hold * removed, .removed = {removed, 0, 0}};
  for (std::size_t k = 0; k < 3; ++k) {
    end.x[k] = subtract_product<arithmetic>(p.x1[k], a.s, a.n[k]);
    if (is_pressed) end.v[k] = subtract_product<arithmetic>(p.v1[k], vn, a.n[k]);
    if (direction * vn0 < 0) end.v0[k] = subtract_product<arithmetic>(p.v0[k], vn0, a.n[k]);
  }
  return end;
}

template <Arithmetic arithmetic, class T>
HeldEnd<T> held_by_two(const Holder<T>& a, const Holder<T>& b, const Particle<T>& p, T direction) noexcept {
  const T kappa = dot<arithmetic>(a.n, b.n);
  const Two<T> way = solve_two<arithmetic>(a.s, b.s, kappa);
  const auto pressures = [&](const Vector<T>& v) {
    return solve_two<arithmetic>(direction * dot<arithmetic>(a.n, v), direction * dot<arithmetic>(b.n, v), kappa);
  };
  const Two<T> removed = pressures(p.v1);
  const Two<T> removed0 = pressures(p.v0);
  HeldEnd<T> end;
  for (std::size_t k = 0; k < 3; ++k) {
    end.x[k] = multiply_add<arithmetic>(way.b, b.n[k], multiply_add<arithmetic>(way.a, a.n[k], p.x1[k]));
    const T along_a = multiply_add<arithmetic>(direction * removed.a, a.n[k], p.v1[k]);
    end.v[k] = multiply_add<arithmetic>(direction * removed.b, b.n[k], along_a);
    const T along_a0 = multiply_add<arithmetic>(direction * removed0.a, a.n[k], p.v0[k]);
    end.v0[k] = multiply_add<arithmetic>(direction * removed0.b, b.n[k], along_a0);
  }
  end.slide = multiply_add<arithmetic>(b.mu, removed.b, a.mu * removed.a);
  end.hold = multiply_add<arithmetic>(b.hold, removed.b, a.hold * removed.a);
  end.removed = {removed.a, removed.b, 0};
  return end;
}

// A particle as what holds it sees it; V: the velocity which that has at the particle's end, before it is held; more: what of
// it is not the first holder's.
template <class T>
struct Against {
  Particle<T> p;
  Vector<T> V{}, more{};
};

template <class T>
Against<T> against_one(const Terms<T>& terms, const Holder<T>& a, const Particle<T>& p) noexcept {
  if (!terms.moves) return {p};
  return {{.x0 = a.x0, .v0 = a.v0, .x1 = p.x1, .v1 = difference(p.v1, a.V)}, a.V};
}

template <Arithmetic arithmetic, class T>
Against<T> against_two(const Terms<T>& terms, const Holder<T>& a, const Holder<T>& b, const Particle<T>& p, T t) noexcept {
  if (!terms.moves) return {p};
  const T kappa = dot<arithmetic>(a.n, b.n);
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  const bool is_wedge = det > 64 * std::numeric_limits<T>::epsilon();
  const T share = is_wedge ? 1 / det * dot<arithmetic>(b.n, difference(b.V, a.V)) : T(0);
  Against<T> against{{.x0 = a.x0, .v0 = a.v0, .x1 = p.x1, .v1 = p.v1}};
  for (std::size_t k = 0; k < 3; ++k) {
    const T more = share * subtract_product<arithmetic>(b.n[k], kappa, a.n[k]);
    against.V[k] = a.V[k] + more;
    against.more[k] = more;
    against.p.x0[k] = multiply_add<arithmetic>(t, more, a.x0[k]);
    against.p.v0[k] = a.v0[k] - more;
    against.p.v1[k] = p.v1[k] - against.V[k];
  }
  return against;
}

template <Arithmetic arithmetic, PathForm form, class T>
Holder<T> deepest(const Terms<T>& terms, const Particle<T>& p, const Course<arithmetic, form, T>& course,
                  const Vector<T>& x) noexcept {
  Holder<T> found;
  T depth = -2 * std::numeric_limits<T>::epsilon() * one_norm(p.x1);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const T s = touch<arithmetic>(surface, x).s;
    if (!(s < depth) || course.held.has(j)) continue;
    const Touch<T> end = touch<arithmetic>(surface, p.x1);
    const Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
    T s0 = 0;
    if (!may_hold(surface, end.s, seen, course, course.last == j, s0)) continue;
    depth = s;
    found = holder_of<arithmetic>(j, surface, end.s, s0, end.n, p, seen);
  }
  return found;
}

template <Arithmetic arithmetic, class T>
HeldEnd<T> held_by_three(const Holder<T>& a, const Holder<T>& b, const Holder<T>& c, const Particle<T>& p,
                         T direction) noexcept {
  const T depth = -2 * std::numeric_limits<T>::epsilon() * one_norm(p.x1);
  const auto leaves = [&](const Holder<T>& first, const Holder<T>& other) {
    const Two<T> way = solve_two<arithmetic>(first.s, c.s, dot<arithmetic>(first.n, c.n));
    const T s = multiply_add<arithmetic>(way.b, dot<arithmetic>(c.n, other.n),
                                         multiply_add<arithmetic>(way.a, dot<arithmetic>(first.n, other.n), other.s));
    return s >= depth;
  };
  if (leaves(a, b)) {
    HeldEnd<T> end = held_by_two<arithmetic>(a, c, p, direction);
    end.removed = {end.removed[0], 0, end.removed[1]};
    return end;
  }
  if (leaves(b, a)) {
    HeldEnd<T> end = held_by_two<arithmetic>(b, c, p, direction);
    end.removed = {0, end.removed[0], end.removed[1]};
    return end;
  }
  return {.x = p.x0};
}

// What each of the holders did to the particle, which ends at p: along its normal, and of the friction as much as it presses.
template <Arithmetic arithmetic, PathForm form, class T>
void record_hold(const std::array<const Holder<T>*, 3>& holders, const HeldEnd<T>& end, const Vector<T>& friction,
                 const Particle<T>& p, const Course<arithmetic, form, T>& course) noexcept {
  const Vector<T>& dv = course.held.dv;
  std::array<T, 3> removed = end.removed;
  if (holders[2]->number != Held<T>::none && removed == std::array<T, 3>{}) {
    removed = multiples(holders[0]->n, holders[1]->n, holders[2]->n, scaled_by(course.direction, dv));
  }
  std::size_t main = 0;
  while (main < 2 && !(removed[main] > 0)) ++main;
  if (!(removed[main] > 0)) main = 0;
  std::array<Vector<T>, 3> shares{};
  shares[main] = dv;
  for (std::size_t k = 0; k < 3; ++k) {
    if (k == main || !(removed[k] > 0)) continue;
    const T part = end.slide > 0 ? (holders[k]->mu * removed[k]) / end.slide : T(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shares[k][axis] = (course.direction * removed[k]) * holders[k]->n[axis] + part * friction[axis];
      shares[main][axis] = shares[main][axis] - shares[k][axis];
    }
  }
  // A force that holds all the time gives more than is left of it at the end, where springs and drag act on that.
  Vector<T> grown{1, 1, 1};
  if constexpr (form == PathForm::flow) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (course.end.P1[axis] != 0) grown[axis] = course.left / course.end.P1[axis];
    }
  }
  course.recording->begin_hold(p.x0, p.x1, course.t);
  for (std::size_t k = 0; k < 3; ++k) {
    if (shares[k] == Vector<T>{}) continue;
    course.recording->hold(holders[k]->number, {grown[0] * shares[k][0], grown[1] * shares[k][1], grown[2] * shares[k][2]});
  }
}

template <Arithmetic arithmetic, PathForm form, class T>
void hold(const Terms<T>& terms, Particle<T>& p, Course<arithmetic, form, T>& course) noexcept {
  constexpr std::size_t none = Held<T>::none;
  Holder<T> a;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Touch<T> end = touch<arithmetic>(surface, p.x1);
    if (!(end.s < a.s)) continue;
    const Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
    T s0 = 0;
    if (!may_hold(surface, end.s, seen, course, course.last == j, s0)) continue;
    a = holder_of<arithmetic>(j, surface, end.s, s0, end.n, p, seen);
  }
  auto& held = course.held;
  held.a = a.number;
  held.b = held.c = none;
  if (a.number == none) return;

  Holder<T> b, c;
  Against<T> against = against_one(terms, a, p);
  HeldEnd<T> end = held_by_one<arithmetic>(a, against.p, course.direction);
  b = deepest(terms, p, course, end.x);
  if (b.number != none) {
    against = against_two<arithmetic>(terms, a, b, p, course.t);
    end = held_by_two<arithmetic>(a, b, against.p, course.direction);
    held.b = b.number;
    c = deepest(terms, p, course, end.x);
    if (c.number != none) {
      end = held_by_three<arithmetic>(a, b, c, against.p, course.direction);
      held.c = c.number;
    }
  }
  const T kept = kept_by_friction(end.slide, end.hold, std::sqrt(dot<arithmetic>(end.v, end.v)));
  Vector<T> friction;
  for (std::size_t k = 0; k < 3; ++k) {
    const T rubbed = kept * end.v[k];
    friction[k] = rubbed - end.v[k];
    end.x[k] = multiply_add<arithmetic>(T(0.5) * course.t, friction[k], end.x[k]);
    end.v[k] = rubbed;
  }
  const T motion = std::abs(course.t) * one_norm(sum_of(end.v0, end.v));
  if (motion < std::numeric_limits<T>::epsilon() / 4 * one_norm(p.x1)) {
    const T sunk = held.b == none ? a.s0 : T(0);
    for (std::size_t k = 0; k < 3; ++k) end.x[k] = subtract_product<arithmetic>(against.p.x0[k], sunk, a.n[k]);
  }
  if (terms.moves) {
    const Surface<T>& surface = terms.surfaces[a.number];
    end.v =
        sum_of(end.v, surface.movement == Movement::turns ? sum_of(velocity_at<arithmetic>(surface, end.x, T(0)), against.more)
                                                          : against.V);
    end.v0 = sum_of(p.v0, difference(end.v0, against.p.v0));
  }
  held.dx = difference(end.x, p.x1);
  held.dv = difference(end.v, p.v1);
  p.x1 = end.x;
  p.v1 = end.v;
  p.v0 = end.v0;
  if (course.recording != nullptr) record_hold({&a, &b, &c}, end, friction, p, course);
}

// ---------------------------------------------------------------------------------- impacts

// What is left of the tangential velocity at an impact. What lay or slid on the surface before comes to none.
template <Arithmetic arithmetic, PathForm form, class T>
T kept_by_viscosity(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, form, T>& course,
                    const Vector<T>& gain, bool is_over) noexcept {
  if (surface.tau == 1) return 1;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T low = low_bounce * eps * (one_norm(p.x0) + surface.radius);
  const T out = course.direction * dot<arithmetic>(start.n, p.v0);
  const T own = std::abs(dot<arithmetic>(start.n, gain));
  const T rounding = 4 * eps * one_norm(p.v0);
  const bool stays_low = out <= rounding || out * out * std::abs(course.t) <= 2 * own * low;
  const bool comes_slow = -out <= own + rounding;
  const bool rests = start.s <= 4 * low && (out > 0 ? stays_low : comes_slow);
  return rests ? T(1) : is_over ? T(0) : surface.tau;
}

template <class T>
struct Moment {
  Vector<T> x, v;
};

template <Arithmetic arithmetic, PathForm form, class T>
Moment<T> moment(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, form, T>& course,
                 const Vector<T>& gain, T f) noexcept {
  Moment<T> at;
  if constexpr (form == PathForm::parabola) {
    at.x = along<arithmetic>(p.x0, path(surface, p, course.t), f);
    for (std::size_t k = 0; k < 3; ++k) at.v[k] = multiply_add<arithmetic>(f, gain[k], p.v0[k]);
    return at;
  } else {
    const Responses<T> P = (*course.bending)(f * course.left);
    const auto& end = course.end;
    const bool is_driven = course.bending->is_driven();
    const T frequency = 1 / course.h;
    const Vector<T> drive_end = driven<arithmetic>(course.drive, end.P2, end.P3, end.P4);
    const Vector<T> drive_here = driven<arithmetic>(course.drive, P.P2, P.P3, P.P4);
    for (std::size_t k = 0; k < 3; ++k) {
      const T v1 = is_driven ? p.v1[k] - frequency * drive_end[k] : p.v1[k];
      const T pull = subtract_product<arithmetic>(v1, p.v0[k], end.P0[k]) * inverse(end.P1[k]);
      at.v[k] = multiply_add<arithmetic>(pull, P.P1[k], p.v0[k] * P.P0[k]);
      if (is_driven) at.v[k] = at.v[k] + frequency * drive_here[k];
    }
    if (surface.sweep == ContactPath::line) {
      at.x = along<arithmetic>(p.x0, path(surface, p, course.t), f);
      return at;
    }
    const Vector<T> way = flow_path(p, course).way(P);
    for (std::size_t k = 0; k < 3; ++k) at.x[k] = p.x0[k] + way[k];
    return at;
  }
}

// The normal and the velocity of a surface where it meets a particle at x, t before the end.
template <class T>
struct Meeting {
  Vector<T> n, V{};
};

template <Arithmetic arithmetic, class T>
Meeting<T> meeting(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  if (surface.movement == Movement::rest) return {touch<arithmetic>(surface, x).n};
  const Vector<T> n = touch<arithmetic>(surface, taken_along<arithmetic>(surface, x, t)).n;
  const Vector<T> V = velocity_at<arithmetic>(surface, x, t);
  if (surface.movement != Movement::turns) return {n, V};
  return {turned_by<arithmetic>(scaled_by(-t, surface.omega), n), V};
}

// Whether a particle lies on a surface that it is pressed onto from here on. Of a sheet that rests, each pulse of its springs
// presses.
template <Arithmetic arithmetic, PathForm form, class T>
bool is_pressed_on(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, form, T>& course) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
  const Touch<T> start = touch<arithmetic>(surface, seen.x0);
  const T sizes = (one_norm(seen.x0) + one_norm(p.x1)) + (surface.radius + surface.radius);
  return start.s <= 2 * std::numeric_limits<T>::epsilon() * sizes && course.direction * dot<arithmetic>(start.n, seen.v0) <= 0;
}

template <Arithmetic arithmetic, PathForm form, class T>
void respond(const Surface<T>& surface, Particle<T>& p, Course<arithmetic, form, T>& course, T f) noexcept {
  const bool lies = course.recording != nullptr && is_pressed_on(surface, p, course);
  if (course.recording != nullptr) course.recording->let_go(f);
  const Vector<T> gain = difference(p.v1, p.v0);
  const auto [xf, vf] = moment(surface, p, course, gain, f);
  const T rest = 1 - f;
  const auto [n, V] = meeting<arithmetic>(surface, xf, rest * course.t);
  const bool moves = surface.movement != Movement::rest;
  const Vector<T> vr = moves ? difference(vf, V) : vf;
  const T vn = dot<arithmetic>(n, vr);
  const Vector<T> forces = course.held.a != Held<T>::none ? difference(gain, course.held.dv) : gain;
  const T pressed = rest * (course.direction * dot<arithmetic>(n, forces));
  const bool is_over = surface.response == Response::resume && surface.e > 0 &&
                       (surface.e + surface.e) * std::abs(vn) <= (surface.e - 1) * pressed;
  const T e = is_over ? T(0) : surface.e;
  const T tau = kept_by_viscosity(surface, seen_from<arithmetic>(surface, p, course.t), course, gain, is_over);
  course.t = rest * course.t;
  if constexpr (form == PathForm::flow) {
    const T passed = f * course.left;
    const T half = T(0.5) * passed;
    auto& [D1, D2, D3] = course.drive;
    for (std::size_t k = 0; k < 3 && course.bending->is_driven(); ++k) {
      D1[k] = multiply_add<arithmetic>(passed, multiply_add<arithmetic>(half, D3[k], D2[k]), D1[k]);
      D2[k] = multiply_add<arithmetic>(passed, D3[k], D2[k]);
    }
    course.left = rest * course.left;
    course.end = (*course.bending)(course.left);
  }
  p.x0 = xf;
  p.v0 = vf;
  const auto let_go = [&] {
    if (course.held.a == Held<T>::none) return;
    for (std::size_t k = 0; k < 3; ++k) p.v1[k] = subtract_product<arithmetic>(p.v1[k], rest, course.held.dv[k]);
  };
  if (course.held.a != Held<T>::none) {
    for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(p.x1[k], rest * rest, course.held.dx[k]);
  }
  if (!(course.direction * vn <= 0)) return let_go();

  Vector<T> vt;
  for (std::size_t k = 0; k < 3; ++k) vt[k] = tau * subtract_product<arithmetic>(vr[k], vn, n[k]);
  const T slide = surface.mu * ((1 + e) * std::abs(vn));
  const T kept = kept_by_friction(slide, slide, std::sqrt(dot<arithmetic>(vt, vt)));
  Vector<T> way = difference(p.x1, xf);
  for (std::size_t k = 0; k < 3 && moves; ++k) way[k] = subtract_product<arithmetic>(way[k], course.t, V[k]);
  const T beyond = dot<arithmetic>(n, way);
  for (std::size_t k = 0; k < 3; ++k) {
    T after = subtract_product<arithmetic>(kept * vt[k], e * vn, n[k]);
    if (moves) after = after + V[k];
    const T pulse = after - vf[k];
    if (surface.response == Response::end_on_surface) {
      p.x1[k] = subtract_product<arithmetic>(p.x1[k], beyond, n[k]);
    } else if (form == PathForm::parabola) {
      p.x1[k] = multiply_add<arithmetic>(course.t, pulse, p.x1[k]);
    } else {
      p.x1[k] = multiply_add<arithmetic>(course.h * course.end.P1[k], pulse, p.x1[k]);
    }
    p.v1[k] = form == PathForm::parabola ? multiply_add<arithmetic>(rest, gain[k], after)
                                         : multiply_add<arithmetic>(course.end.P0[k], pulse, p.v1[k]);
    p.v0[k] = after;
  }
  if (course.recording != nullptr) {
    const auto told = lies && e == 0 ? Told::hold : Told::impact;
    course.recording->push(told, course.last, xf, n, difference(p.v0, vf), course.t);
  }
  let_go();
}

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p,
                       const Course<arithmetic, form, T>& course, bool is_held, T low) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane(terms, surface, seen, p, course, is_held, low);
    case Shape::sphere:
      return cross_sphere(terms, surface, seen, p, course, is_held, low);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return cross_solid(surface, seen, p, course, is_held, low);
}

// Whether there was an impact.
template <Arithmetic arithmetic, PathForm form, class T>
bool resolve_earliest(const Terms<T>& terms, Particle<T>& p, Course<arithmetic, form, T>& course) noexcept {
  const T low = 4 * low_bounce * std::numeric_limits<T>::epsilon() * one_norm(p.x0);
  const T corner = terms.bend.corner * course.t;
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(corner, p.v0[k], p.x0[k]);
  T earliest = 2;
  std::size_t which = terms.surface_count;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (course.held.has(j) || !may_touch_moving<arithmetic>(surface, p, middle, course.t, corner)) continue;
    const std::optional<T> f = cross(terms, surface, p, course, course.last == j, low);
    if (f && *f < earliest) {
      earliest = *f;
      which = j;
    }
  }
  if (which == terms.surface_count) return false;
  course.last = which;
  respond(terms.surfaces[which], p, course, earliest);
  hold(terms, p, course);
  return true;
}

template <Arithmetic arithmetic, PathForm form, class T>
void clamp(const Surface<T>& surface, Particle<T>& p, const Course<arithmetic, form, T>& course, bool is_held,
           T size) noexcept {
  const Vector<T> n = touch<arithmetic>(surface, p.x1).n;
  Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
  const T vn = dot<arithmetic>(n, seen.v1);
  if (course.direction * vn < 0) {
    const T removed = std::abs(vn);
    Vector<T> vt;
    for (std::size_t k = 0; k < 3; ++k) vt[k] = subtract_product<arithmetic>(seen.v1[k], vn, n[k]);
    const T kept = kept_by_friction(surface.mu * removed, surface.hold * removed, std::sqrt(dot<arithmetic>(vt, vt)));
    for (std::size_t k = 0; k < 3; ++k) seen.v1[k] = kept * vt[k];
    if (surface.movement == Movement::rest) p.v1 = seen.v1;
  }
  const Vector<T> sum = sum_of(seen.v0, seen.v1);
  const T motion = std::abs(course.t) * one_norm(sum);
  const bool rests = is_held && motion < std::numeric_limits<T>::epsilon() / 4 * size;
  const Vector<T> base = rests ? seen.x0 : p.x1;
  const Touch<T> there = touch<arithmetic>(surface, base);
  for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(base[k], there.s, there.n[k]);
  if (surface.movement == Movement::rest || !(course.direction * vn < 0)) return;
  p.v1 = sum_of(seen.v1, velocity_at<arithmetic>(surface, p.x1, T(0)));
}

template <Arithmetic arithmetic, PathForm form, class T>
void resolve_all(const Terms<T>& terms, Particle<T>& p, Course<arithmetic, form, T>& course) noexcept {
  hold(terms, p, course);
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest(terms, p, course)) break;
  }
  if (course.recording != nullptr) course.recording->let_go(1);
  T tolerance = 0;
  for (int round = 0; round < clamp_rounds; ++round) {
    bool is_clamped = false;
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const T size = one_norm(p.x1);
      const bool is_held = course.held.has(j);
      if (round == 0 && is_held && terms.surfaces[j].shape == Shape::plane) continue;
      if (!(touch<arithmetic>(terms.surfaces[j], p.x1).s < -(tolerance * size))) continue;
      is_clamped = true;
      const Vector<T> before = p.v1;
      clamp(terms.surfaces[j], p, course, course.last == j || is_held, size);
      if (course.recording != nullptr) course.recording->push(Told::hold, j, p.x1, {}, difference(p.v1, before), T(0));
    }
    if (!is_clamped) return;
    tolerance = 2 * std::numeric_limits<T>::epsilon();
  }
}

// i: the particle's number in the plan's columns.
template <Arithmetic arithmetic, class T>
void resolve_contacts(const Terms<T>& terms, const Offsets<T>& offsets, Particle<T>& p, std::size_t i,
                      Recording<T>* recording = nullptr) noexcept {
  if (!may_touch<arithmetic>(terms, p)) return;
  const T direction = terms.h < 0 ? T(-1) : T(1);
  if (terms.bend.degree == 0) {
    Course<arithmetic, PathForm::parabola, T> course{
        .direction = direction, .t = terms.h, .last = terms.surface_count, .recording = recording};
    resolve_all(terms, p, course);
    return;
  }
  const Bending<arithmetic, T> bending(terms.bend, i);
  Course<arithmetic, PathForm::flow, T> course{.direction = direction,
                                               .t = terms.h,
                                               .last = terms.surface_count,
                                               .bending = &bending,
                                               .h = terms.h,
                                               .left = 1,
                                               .end = bending(T(1)),
                                               .recording = recording};
  if (bending.is_driven()) course.drive = {offsets.drive[0], offsets.drive[1], offsets.drive[2]};
  resolve_all(terms, p, course);
}

// With all surfaces, also of a block that knows those near it: what strays from them would be told twice.
template <Arithmetic arithmetic, class T>
void resolve_and_log(const Terms<T>& terms, const Offsets<T>& offsets, Particle<T>& p, std::size_t i, ContactLog<T>& log) {
  const Terms<T>& all = terms.whole != nullptr ? *terms.whole : terms;
  Recording<T> recording(log, all, i);
  resolve_contacts<arithmetic>(all, offsets, p, i, &recording);
}

}  // namespace dvdx::reference
