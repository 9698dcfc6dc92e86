// The contact pass, wide. Formulas only: where they come from stands in contact.hpp, their scalar twin in
// contact_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>
#include <utility>

#include "isa/lanes.hpp"
#include "passes/contact/bend.inl.hpp"
#include "passes/contact/contact.hpp"
#include "passes/contact/contact_log.hpp"
#include "passes/contact/shape.inl.hpp"
#include "passes/terms.hpp"
#include "passes/three.inl.hpp"
#include "passes/trajectory.inl.hpp"

namespace dvdx {
namespace {

// ---------------------------------------------------------------------------------- surfaces that move

template <class V, Arithmetic arithmetic>
Three<V> cross_product(const Three<V>& a, const Three<V>& b) noexcept {
  return {{subtract_product<arithmetic>(a[1] * b[2], a[2], b[1]), subtract_product<arithmetic>(a[2] * b[0], a[0], b[2]),
           subtract_product<arithmetic>(a[0] * b[1], a[1], b[0])}};
}

template <class V, Arithmetic arithmetic>
V by_powers(const std::array<Scalar<V>, 7>& terms, V x) noexcept {
  V sum(terms[6]);
  for (std::size_t n = 6; n-- > 0;) sum = multiply_add<arithmetic>(sum, x, V(terms[n]));
  return sum;
}

// r, turned by w.
template <class V, Arithmetic arithmetic>
Three<V> turned_by(const Three<V>& w, const Three<V>& r) noexcept {
  const V square = dot<arithmetic>(w, w);
  const V a = by_powers<V, arithmetic>(turn_sine<Scalar<V>>, square);
  const V b = by_powers<V, arithmetic>(turn_versine<Scalar<V>>, square);
  const Three<V> once = cross_product<V, arithmetic>(w, r);
  const Three<V> twice = cross_product<V, arithmetic>(w, once);
  return multiply_add<arithmetic>(b, twice, multiply_add<arithmetic>(a, once, r));
}

// From the axis' point to x, t before the end.
template <class V, Arithmetic arithmetic>
Three<V> arm_of(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  return multiply_add<arithmetic>(t, three<V>(surface.u), x) - three<V>(surface.at);
}

// That of the surface at x, t before the end.
template <class V, Arithmetic arithmetic>
Three<V> velocity_at(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  const Three<V> u = three<V>(surface.u);
  if (surface.movement != Movement::turns) return u;
  return u + cross_product<V, arithmetic>(three<V>(surface.omega), arm_of<V, arithmetic>(surface, x, t));
}

// Where a surface takes what lies at x, t before the end.
template <class V, Arithmetic arithmetic>
Three<V> taken_along(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  if (surface.movement != Movement::turns) return multiply_add<arithmetic>(t, three<V>(surface.u), x);
  return three<V>(surface.at) + turned_by<V, arithmetic>(t * three<V>(surface.omega), arm_of<V, arithmetic>(surface, x, t));
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Trajectory<V> as_seen(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t) noexcept {
  Trajectory<V> seen = m;
  seen.x0 = taken_along<V, arithmetic>(surface, m.x0, t);
  seen.v0 = m.v0 - velocity_at<V, arithmetic>(surface, m.x0, t);
  if (surface.movement == Movement::turns) seen.v0 = turned_by<V, arithmetic>(t * three<V>(surface.omega), seen.v0);
  seen.v1 = m.v1 - velocity_at<V, arithmetic>(surface, m.x1, V(Scalar<V>(0)));
  return seen;
}

// The trajectory itself where the surface rests, else how it sees it, in `room`.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline const Trajectory<V>& seen_from(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t,
                                                             Trajectory<V>& room) noexcept {
  if (surface.movement == Movement::rest) return m;
  room = as_seen<V, arithmetic>(surface, m, t);
  return room;
}

// l and q of a bent path.
template <class V>
struct Slip {
  bool is_there;
  Three<V> l, q;
};

template <class V>
Slip<V> slip_of(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Trajectory<V>& seen, V t) noexcept {
  const Three<V> none = three<V>(V(Scalar<V>(0)));
  if (surface.movement == Movement::rest) return {false, none, none};
  const Three<V> l = t * (seen.v0 - m.v0);
  if (surface.movement != Movement::turns) return {true, l, none};
  return {true, l, ((seen.x1 - seen.x0) - (m.x1 - m.x0)) - l};
}

// ---------------------------------------------------------------------------------- what every particle pays for

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch_plane(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                      const Three<V>& middle) noexcept {
  const Three<V> n = three<V>(surface.n);
  const V d(surface.d);
  const Mask<V> ends_inside = dot<arithmetic>(n, m.x1) < d;
  return surface.finds_dips ? ends_inside | (dot<arithmetic>(n, middle) < d) : ends_inside;
}

// Outside a sphere the path is safe where it stays behind the tangent plane whose normal points to its start.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch_sphere(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                       const Three<V>& middle) noexcept {
  const Three<V> c = three<V>(surface.center);
  const V zero(Scalar<V>(0));
  const V square(surface.radius * surface.radius);
  const Three<V> r1 = m.x1 - c;
  const Three<V> rm = middle - c;
  if (surface.side < 0) {
    const Mask<V> ends_outside = dot<arithmetic>(r1, r1) > square;
    return surface.finds_dips ? ends_outside | (dot<arithmetic>(rm, rm) > square) : ends_outside;
  }
  const Three<V> r0 = m.x0 - c;
  const V reach = square * dot<arithmetic>(r0, r0);
  const V along1 = dot<arithmetic>(r0, r1);
  const V along_m = dot<arithmetic>(r0, rm);
  const Mask<V> near1 = (along1 <= zero) | (along1 * along1 <= reach);
  return surface.finds_dips ? near1 | (along_m <= zero) | (along_m * along_m <= reach) : near1;
}

// Of a plane or a sphere: nothing is called, so that the loop around it keeps its registers.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch_simple(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                       const Three<V>& middle) noexcept {
  if (surface.shape == Shape::plane) return may_touch_plane<V, arithmetic>(surface, m, middle);
  return may_touch_sphere<V, arithmetic>(surface, m, middle);
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                const Three<V>& middle) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return may_touch_plane<V, arithmetic>(surface, m, middle);
    case Shape::sphere:
      return may_touch_sphere<V, arithmetic>(surface, m, middle);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return may_touch_solid<V, arithmetic>(surface, m, middle);
}

// t: what remains of the step; corner: the part of it after which the path's tangents meet, in seconds.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> may_touch_moving(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t, V corner) noexcept {
  const Trajectory<V> seen = as_seen<V, arithmetic>(surface, m, t);
  const Three<V> middle = multiply_add<arithmetic>(corner, seen.v0, seen.x0);
  const Mask<V> near = may_touch<V, arithmetic>(surface, seen, middle);
  return surface.is_searched ? near & overlaps(surface, seen, middle) : near;
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                const Three<V>& middle, V t, V corner) noexcept {
  if (surface.movement != Movement::rest) return may_touch_moving<V, arithmetic>(surface, m, t, corner);
  const Mask<V> near = may_touch<V, arithmetic>(surface, m, middle);
  return surface.is_searched ? near & overlaps(surface, m, middle) : near;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> may_touch_any(const Terms<Scalar<V>>& terms, const Trajectory<V>& m) noexcept {
  const V corner(terms.h * terms.bend.corner);
  const Three<V> middle = multiply_add<arithmetic>(corner, m.v0, m.x0);
  Mask<V> touches(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    touches = touches | may_touch<V, arithmetic>(terms.surfaces[j], m, middle, V(terms.h), corner);
  }
  return touches;
}

// Made once a block: what is read through `terms` could alias the particles and would be read again for every batch.
template <class V, Arithmetic arithmetic>
class TouchTest {
  using T = Scalar<V>;

 public:
  explicit TouchTest(const Terms<T>& terms) noexcept
      : first_(terms.surfaces), end_(terms.surfaces + terms.surface_count), corner_(terms.h * terms.bend.corner) {}

  struct Sums {};
  [[gnu::always_inline]] void add(std::size_t, const Trajectory<V>&, Sums&) const noexcept {}

  [[gnu::always_inline]] Mask<V> operator()(const Trajectory<V>& m, const Sums&) const noexcept {
    const Three<V> middle = multiply_add<arithmetic>(corner_, m.v0, m.x0);
    Mask<V> touches(false);
    for (const Surface<T>* surface = first_; surface != end_; ++surface) {
      touches = touches | may_touch_simple<V, arithmetic>(*surface, m, middle);
    }
    return touches;
  }

 private:
  const Surface<T>* first_;
  const Surface<T>* end_;
  V corner_;
};

// The same for a single plane, axis by axis as soon as it has moved, which takes fewer registers. Where dips do
// not count nothing is below minus infinity.
template <class V, Arithmetic arithmetic>
class PlaneTouchTest {
  using T = Scalar<V>;

 public:
  explicit PlaneTouchTest(const Terms<T>& terms) noexcept
      : n_(three<V>(terms.surfaces[0].n)),
        d_(terms.surfaces[0].d),
        corner_(terms.h * terms.bend.corner),
        middle_d_(terms.surfaces[0].finds_dips ? terms.surfaces[0].d : -std::numeric_limits<T>::infinity()) {}

  struct Sums {
    V end, middle;
  };
  [[gnu::always_inline]] void add(std::size_t axis, const Trajectory<V>& m, Sums& sums) const noexcept {
    accumulate(axis, m.x1[axis], sums.end);
    accumulate(axis, multiply_add<arithmetic>(corner_, m.v0[axis], m.x0[axis]), sums.middle);
  }
  [[gnu::always_inline]] Mask<V> operator()(const Trajectory<V>&, const Sums& sums) const noexcept {
    return (sums.end < d_) | (sums.middle < middle_d_);
  }

 private:
  [[gnu::always_inline]] void accumulate(std::size_t axis, V x, V& sum) const noexcept {
    sum = axis == 0 ? n_[0] * x : multiply_add<arithmetic>(n_[axis], x, sum);
  }

  Three<V> n_;
  V d_, corner_, middle_d_;
};

// ---------------------------------------------------------------------------------- geometry

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
  // At the very centre every direction is as good: the second axis.
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

// What surrounds lanes: of planes at rest, all of them looked at, the loops over surfaces call nothing and test nothing.
enum class Surroundings { any, planes };

template <class V, Arithmetic arithmetic, Surroundings surroundings>
[[gnu::always_inline]] inline Touch<V> touch(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  if constexpr (surroundings == Surroundings::planes) {
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

// The numbers of the surfaces that hold lanes for the rest of their step, -1 where there are fewer than three, and what they
// changed at its end.
template <class V>
struct Held {
  V a, b, c;
  Three<V> dx, dv;
};

template <class V>
Held<V> not_held() noexcept {
  const V none(Scalar<V>(-1));
  const V zero(Scalar<V>(0));
  return {none, none, none, three<V>(zero), three<V>(zero)};
}

// Lanes during one step. `last` is the number of the surface that was hit last, `t` what remains of the step.
template <class V, Arithmetic arithmetic, PathForm form>
struct Course {
  V direction, t, last;
  Mask<V> active, loose;  // loose: near a surface, and did not hit it
  Held<V> held;
  Mask<V> strayed = Mask<V>(false);  // out of the region where the list of surfaces holds
};
template <class V, Arithmetic arithmetic>
struct Course<V, arithmetic, PathForm::flow> {
  V direction, t, last;
  Mask<V> active, loose;
  Held<V> held;
  const Bending<V, arithmetic>* bending;
  V h, left;         // the whole step, s, and the part of it that remains
  Responses<V> end;  // those of what remains
  Drive<V> drive;    // where forces depend on time
  Mask<V> strayed = Mask<V>(false);
};

// Lanes at x that are out of the region where the list of surfaces holds are worked out again.
template <class V, class AnyCourse>
void watch(const Terms<Scalar<V>>& terms, AnyCourse& course, const Three<V>& x, Mask<V> lanes) noexcept {
  if (terms.whole == nullptr) return;
  Mask<V> is_within(true);
  for (std::size_t k = 0; k < 3; ++k) {
    is_within = is_within & (x[k] >= V(terms.region.low[k])) & (x[k] <= V(terms.region.high[k]));
  }
  course.strayed = course.strayed | (lanes & !is_within);
}

// D1 P + D2 P' + D3 P'': what forces of time add to a path or a velocity.
template <class V, Arithmetic arithmetic>
Three<V> driven(const Drive<V>& drive, const Three<V>& first, const Three<V>& second, const Three<V>& third) noexcept {
  Three<V> sum;
  for (std::size_t k = 0; k < 3; ++k) {
    sum[k] = multiply_add<arithmetic>(drive.D3[k], third[k],
                                      multiply_add<arithmetic>(drive.D2[k], second[k], drive.D1[k] * first[k]));
  }
  return sum;
}

// A path of PathForm::flow: from its start, u P1 + F P2, and what forces of time add.
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

// 1/P of a response, and 0 where nothing is left of a step.
template <class V>
V inverse(V P) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const Mask<V> is_left = differ(P, zero);
  return select<V>(is_left, quotient<V>(one, select<V>(is_left, P, one)), zero);
}

template <class V, Arithmetic arithmetic>
FlowPath<V, arithmetic> flow_path(const Trajectory<V>& m, const Course<V, arithmetic, PathForm::flow>& course) noexcept {
  FlowPath<V, arithmetic> path{course.h * m.v0, {}, course.bending->is_driven() ? &course.drive : nullptr};
  const auto& P = course.end;
  Three<V> way = m.x1 - m.x0;
  if (path.drive != nullptr) way = way - driven<V, arithmetic>(course.drive, P.P3, P.P4, P.P5);
  for (std::size_t k = 0; k < 3; ++k) {
    path.F[k] = subtract_product<arithmetic>(way[k], path.u[k], P.P1[k]) * inverse(P.P2[k]);
  }
  return path;
}

template <class V, Arithmetic arithmetic>
Three<V> along(const Three<V>& start, const Path<V>& path, V f) noexcept {
  return multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, path.a, path.u), start);
}

// ---------------------------------------------------------------------------------- time of impact

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

// Whether what was hit last is not hit again.
template <class V>
Mask<V> stays(const Surface<Scalar<V>>& surface, V d0, V c, V low) noexcept {
  if (surface.response == Response::end_on_surface) return Mask<V>(true);
  return (d0 <= V(Scalar<V>(0))) | (d0 * d0 <= -(low * c));
}

// Newton's steps for the first zero of `gap`, from f on, which keep between 0, where it is positive, and `end`, where it is
// negative. `gap` returns it and its slope at f. Up to `close` it is none, and no half is taken: that would lead away from a
// path that begins on the surface and goes along it.
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
  PlanePath(const Surface<T>& surface, const Trajectory<V>& m, const Course<V, arithmetic, PathForm::flow>& course, V s0,
            const Slip<V>& slip) noexcept
      : course_(course),
        path_(flow_path<V, arithmetic>(m, course)),
        n_(three<V>(surface.n)),
        s0_(s0),
        slips_(slip.is_there),
        l_(dot<arithmetic>(n_, slip.l)),
        q_(dot<arithmetic>(n_, slip.q)) {}

  [[nodiscard]] Gap<V> operator()(V f) const noexcept {
    const Responses<V> P = (*course_.bending)(f * course_.left);
    const Gap<V> gap{s0_ + dot<arithmetic>(n_, path_.way(P)), course_.left * dot<arithmetic>(n_, path_.rate(P))};
    if (!slips_) return gap;
    return {multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, q_, l_), gap.s),
            multiply_add<arithmetic>(f + f, q_, gap.slope + l_)};
  }

  [[nodiscard]] Lowest<V> lowest(V f, int steps) const noexcept {
    const V zero(T(0));
    const V one(T(1));
    const auto& [w, q] = std::pair(course_.bending->w, course_.bending->q);
    for (int step = 0; step < steps; ++step) {
      const Responses<V> P = (*course_.bending)(f * course_.left);
      Three<V> second;
      for (std::size_t k = 0; k < 3; ++k) {
        const V pull = multiply_add<arithmetic>(q[k], P.P0[k], w[k] * P.P1[k]);
        second[k] = subtract_product<arithmetic>(path_.F[k] * P.P0[k], path_.u[k], pull);
      }
      if (path_.drive != nullptr) second = second + driven<V, arithmetic>(*path_.drive, P.P1, P.P2, P.P3);
      V slope = dot<arithmetic>(n_, path_.rate(P));
      V bend = course_.left * dot<arithmetic>(n_, second);
      if (slips_) {
        slope = multiply_add<arithmetic>(course_.left, slope, multiply_add<arithmetic>(f + f, q_, l_));
        bend = multiply_add<arithmetic>(course_.left, bend, q_ + q_);
      }
      const V next = f - quotient<V>(slope, bend);
      f = select<V>((next > zero) & (next < one), next, f);
    }
    return {f, (*this)(f).s};
  }

 private:
  const Course<V, arithmetic, PathForm::flow>& course_;
  FlowPath<V, arithmetic> path_;
  Three<V> n_;
  V s0_;
  bool slips_;
  V l_, q_;
};

// m: as the surface sees it; own: as it is.
template <class V, Arithmetic arithmetic, PathForm form>
Crossing<V> cross_plane(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                        [[maybe_unused]] const Trajectory<V>& own, const Course<V, arithmetic, form>& course, Mask<V> held,
                        V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V start = touch<V, arithmetic>(surface, m.x0).s;
  const V s0 = select<V>(held | (start < zero), zero, start);
  const V s1 = touch<V, arithmetic>(surface, m.x1).s;
  const V d0 = surface.sweep == ContactPath::line ? s1 - s0 : course.t * dot<arithmetic>(three<V>(surface.n), m.v0);
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
    const PlanePath<V, arithmetic> path(surface, own, course, s0, slip_of(surface, own, m, course.t));
    V end = one;
    if (surface.finds_dips) {
      const Mask<V> may_dip =
          course.active & (!kept) & (!hits) & (d0 < zero) & (multiply_add<arithmetic>(V(terms.bend.corner), d0, s0) < zero);
      if (any_lane<V>(may_dip)) {
        const Lowest<V> lowest = path.lowest(quotient<V>(-d0, c + c), terms.bend.newton_steps);
        const Mask<V> dips = may_dip & (lowest.s < zero);
        const V d = lowest.f * d0;
        const V b = (lowest.s - s0) - d;
        const V part = first_root(s0, d, b, discriminant<V, arithmetic>(s0, d, b));
        f = select<V>(dips, lowest.f * part, f);
        end = select<V>(dips, lowest.f, end);
        hits = hits | dips;
      }
    }
    hits = course.active & hits & !kept;
    if (any_lane<V>(hits)) f = refined(path, f, end, terms.bend.newton_steps, terms.bend.is_far, V(T(-1)));
    return {f, hits};
  }
}

// A path as a surface sees it. Where forces bend it, `way` has its curvature at its start, and `bent` and `slip` are the path.
template <class V, Arithmetic arithmetic>
struct Way {
  Path<V> way;
  bool is_flow;
  FlowPath<V, arithmetic> bent;
  Slip<V> slip;
};

template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::always_inline]] inline Way<V, arithmetic> way_of(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                        [[maybe_unused]] const Trajectory<V>& own,
                                                        const Course<V, arithmetic, form>& course) noexcept {
  Way<V, arithmetic> way;
  way.way = path(surface, m, course.t);
  way.is_flow = form == PathForm::flow && surface.sweep == ContactPath::curve;
  if constexpr (form == PathForm::flow) {
    way.bent = flow_path<V, arithmetic>(own, course);
    way.slip = slip_of(surface, own, m, course.t);
    if (!way.is_flow || !surface.finds_dips) return way;
    const V half_square = V(Scalar<V>(0.5)) * (course.left * course.left);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      V& a = way.way.a[axis];
      a = half_square * subtract_product<arithmetic>(way.bent.F[axis], course.bending->q[axis], way.bent.u[axis]);
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
  const Course<V, arithmetic, PathForm::flow>& course;
  void operator()(V f, Three<V>& r, Three<V>& tangent) const noexcept {
    const Responses<V> P = (*course.bending)(f * course.left);
    r = r0 + path.way(P);
    tangent = course.left * path.rate(P);
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

// A distance below which rounding alone keeps lanes off a curved surface. Told apart from none, it would be an impact of its
// own with the square root of it: 1e-8 m/s in float64.
template <class V>
V at_surface(const Surface<Scalar<V>>& surface, const Trajectory<V>& own, const Three<V>& r) noexcept {
  return V(4 * std::numeric_limits<Scalar<V>>::epsilon()) * ((one_norm(own.x0) + one_norm(r)) + V(surface.radius));
}

template <class V, Arithmetic arithmetic, PathForm form>
Crossing<V> cross_sphere(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                         const Trajectory<V>& own, const Course<V, arithmetic, form>& course, Mask<V> held, V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V k(surface.half_curvature);
  const V square(surface.radius * surface.radius);
  const auto bend = way_of<V, arithmetic, form>(surface, m, own, course);
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
      end = newton_to_sphere<V, arithmetic>(surface, SphereFlow<V, arithmetic>{r0, bend.bent, bend.slip, course}, f, steps,
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

// Of a body with a signed distance.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Crossing<V> cross_solid(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                          [[maybe_unused]] const Trajectory<V>& own, const Course<V, arithmetic, form>& course,
                                          Mask<V> held, V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const auto bend = way_of<V, arithmetic, form>(surface, m, own, course);
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
          ? march<V, arithmetic>(surface, m.x0, way.u, way.a, {start.n, select<V>(held, zero, start.s)}, course.active & !kept)
          : approach<V, arithmetic>(surface, m.x0, way.u, way.a, {start.n, s0}, tolerance, course.active & !kept);
  const V secant = first_root(s0, d0, c, discriminant<V, arithmetic>(s0, d0, c));
  V f = select<V>(found.arrives, found.f, select<V>(secant < one, secant, one));
  Mask<V> hits = (s1 < zero) | found.arrives;
  if constexpr (form == PathForm::flow) {
    if (bend.is_flow && any_lane<V>(course.active & hits & !kept)) {
      const SphereFlow<V, arithmetic> along_it{m.x0, bend.bent, bend.slip, course};
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
                  const Course<V, arithmetic, form>& course, Mask<V> held, V low) noexcept {
  Trajectory<V> room;
  const Trajectory<V>& seen = seen_from<V, arithmetic>(surface, m, course.t, room);
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane<V, arithmetic, form>(terms, surface, seen, m, course, held, low);
    case Shape::sphere:
      return cross_sphere<V, arithmetic, form>(terms, surface, seen, m, course, held, low);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return cross_solid<V, arithmetic, form>(surface, seen, m, course, held, low);
}

// ---------------------------------------------------------------------------------- friction

// What friction that can take away `slide` leaves of a tangential velocity; all of it vanishes up to `hold`.
template <class V>
V kept_by_friction(V slide, V hold, V length) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V kept = select<V>(hold >= length, zero, one - quotient<V>(slide, length));
  return select<V>(hold > zero, kept, one);
}

// ---------------------------------------------------------------------------------- resting

// A surface that holds lanes: its number (-1: none), its normal and distance at the end of the step as nothing would hold them,
// the distance at the start, its friction.
template <class V>
struct Holder {
  V number, s, s0, mu, hold;
  Three<V> n;
};

template <class V>
Holder<V> no_holder() noexcept {
  const V zero(Scalar<V>(0));
  return {V(Scalar<V>(-1)), zero, zero, zero, zero, three<V>(zero)};
}

template <class V>
Holder<V> select(const Mask<V>& where, const Holder<V>& a, const Holder<V>& b) noexcept {
  return {select<V>(where, a.number, b.number), select<V>(where, a.s, b.s),       select<V>(where, a.s0, b.s0),
          select<V>(where, a.mu, b.mu),         select<V>(where, a.hold, b.hold), select(where, a.n, b.n)};
}

template <class V>
Mask<V> is_among(const Held<V>& held, V number) noexcept {
  return (held.a == number) | (held.b == number) | (held.c == number);
}

// Which surfaces may hold lanes from here on: they stand on them, and neither leave them higher than rounding nor come faster
// than forces bring them to rest on them within the step. Looked at once for each of the first surfaces.
template <class V, Arithmetic arithmetic, PathForm form, Surroundings surroundings>
class Candidates {
  using T = Scalar<V>;

 public:
  Candidates(const Terms<T>& terms, const Trajectory<V>& m, const Course<V, arithmetic, form>& course) noexcept
      : end_size(one_norm(m.x1)), terms_(terms), m_(m), course_(course), size_(one_norm(m.x0)) {}

  struct Candidate {
    Mask<V> may_hold;
    V s0;  // the distance at the start
  };

  // s1: the distance at the end.
  [[nodiscard]] [[gnu::always_inline]] inline Candidate of(std::size_t j, V s1) noexcept {
    if (surroundings == Surroundings::planes || j >= kept) return look(j, s1);
    if (!is_known_[j]) known_[j] = look(j, s1);
    is_known_[j] = true;
    return known_[j];
  }

  V end_size;  // the sum of the end's coordinates

 private:
  [[nodiscard]] Candidate look(std::size_t j, V s1) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    if constexpr (surroundings == Surroundings::planes) return look(j, s1, m_, size_);
    Trajectory<V> room;
    const Trajectory<V>& m = seen_from<V, arithmetic>(surface, m_, course_.t, room);
    return look(j, s1, m, surface.movement == Movement::rest ? size_ : one_norm(m.x0));
  }

  [[nodiscard]] [[gnu::always_inline]] inline Candidate look(std::size_t j, V s1, const Trajectory<V>& m,
                                                             V size) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    const Touch<V> start = touch<V, arithmetic, surroundings>(surface, m.x0);
    const V low = V(4 * low_bounce * std::numeric_limits<T>::epsilon()) * size;
    const V near = V(2 * std::numeric_limits<T>::epsilon()) * ((size + end_size) + V(surface.radius + surface.radius));
    const V d0 = course_.t * dot<arithmetic>(start.n, m.v0);
    const V c = s1 - d0;
    const Mask<V> stands = (start.s >= V(T(-0.5)) * near) & ((course_.last == V(static_cast<T>(j))) | (start.s <= near));
    const Mask<V> leaves = d0 > V(T(0));
    const Mask<V> stays_low = d0 * d0 <= -(low * c);
    const Mask<V> comes_slow = (-d0 <= -(c + c)) & (V(surface.e) * -d0 <= V(T(1) - surface.e) * -c);
    return {stands & ((leaves & stays_low) | ((!leaves) & comes_slow)), start.s};
  }

  static constexpr std::size_t kept = 6;  // a box

  const Terms<T>& terms_;
  const Trajectory<V>& m_;
  const Course<V, arithmetic, form>& course_;
  V size_;
  Candidate known_[kept];
  bool is_known_[kept] = {};
};

// The multiples of two normals, whose product is kappa, that bring the distances (or velocities) a and b to 0: neither of them
// negative, and one alone where that is enough.
template <class V>
struct Two {
  V a, b;
};

// Of two normals: their product, and 1/(1 - kappa^2) where they are not parallel.
template <class V>
struct Wedge {
  V kappa, scale;
  Mask<V> is_wedge;
};

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Wedge<V> wedge_of(const Three<V>& a, const Three<V>& b) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  const V kappa = dot<arithmetic>(a, b);
  const V det = subtract_product<arithmetic>(one, kappa, kappa);
  const Mask<V> is_wedge = det > V(64 * std::numeric_limits<T>::epsilon());
  return {kappa, quotient<V>(one, select<V>(is_wedge, det, one)), is_wedge};
}

template <class V>
[[gnu::always_inline]] inline Two<V> solve_two(V a, V b, const Wedge<V>& wedge) noexcept {
  const V zero(Scalar<V>(0));
  const V both_a = wedge.scale * (wedge.kappa * b - a);
  const V both_b = wedge.scale * (wedge.kappa * a - b);
  const V alone_a = select<V>(a < zero, -a, zero);
  const V alone_b = select<V>(b < zero, -b, zero);
  const Mask<V> only_b = wedge.is_wedge & (both_a < zero);
  const Mask<V> only_a = (!wedge.is_wedge) | ((!only_b) & (both_b < zero));
  return {select<V>(only_b, zero, select<V>(only_a, alone_a, both_a)),
          select<V>(only_b, alone_b, select<V>(only_a, zero, both_b))};
}

// Where lanes end, the velocity along what holds them before friction takes `slide` off it (up to `hold` all of it), and that
// with which they start along it.
template <class V>
struct HeldEnd {
  Three<V> x, v, v0;
  V slide, hold;
};

template <class V>
HeldEnd<V> select(const Mask<V>& where, const HeldEnd<V>& a, const HeldEnd<V>& b) noexcept {
  return {select(where, a.x, b.x), select(where, a.v, b.v), select(where, a.v0, b.v0), select<V>(where, a.slide, b.slide),
          select<V>(where, a.hold, b.hold)};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline HeldEnd<V> held_by_one(const Holder<V>& a, const Trajectory<V>& m, V direction) noexcept {
  const V zero(Scalar<V>(0));
  const V vn = dot<arithmetic>(a.n, m.v1);
  const Mask<V> is_pressed = direction * vn < zero;
  const V removed = select<V>(is_pressed, magnitude(vn), zero);
  const V vn0 = dot<arithmetic>(a.n, m.v0);
  return {subtract_product<arithmetic>(m.x1, a.s, a.n), select(is_pressed, subtract_product<arithmetic>(m.v1, vn, a.n), m.v1),
          select(direction * vn0 < zero, subtract_product<arithmetic>(m.v0, vn0, a.n), m.v0), a.mu * removed, a.hold * removed};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline HeldEnd<V> held_by_two(const Holder<V>& a, const Holder<V>& b, const Trajectory<V>& m,
                                                     V direction) noexcept {
  const Wedge<V> wedge = wedge_of<V, arithmetic>(a.n, b.n);
  const Two<V> way = solve_two(a.s, b.s, wedge);
  const auto along_both = [&](const Three<V>& v, const Two<V>& removed) {
    return multiply_add<arithmetic>(direction * removed.b, b.n, multiply_add<arithmetic>(direction * removed.a, a.n, v));
  };
  const auto pressures = [&](const Three<V>& v) {
    return solve_two(direction * dot<arithmetic>(a.n, v), direction * dot<arithmetic>(b.n, v), wedge);
  };
  const Two<V> removed = pressures(m.v1);
  return {multiply_add<arithmetic>(way.b, b.n, multiply_add<arithmetic>(way.a, a.n, m.x1)), along_both(m.v1, removed),
          along_both(m.v0, pressures(m.v0)), multiply_add<arithmetic>(b.mu, removed.b, a.mu * removed.a),
          multiply_add<arithmetic>(b.hold, removed.b, a.hold * removed.a)};
}

// Of the surfaces that may hold lanes, the one whose inside their end x lies deepest in, with its normal and distance at the
// end as nothing would hold them.
template <class V, Arithmetic arithmetic, PathForm form, Surroundings surroundings>
Holder<V> deepest(const Terms<Scalar<V>>& terms, Candidates<V, arithmetic, form, surroundings>& candidates, const Three<V>& x1,
                  const Held<V>& held, const Three<V>& x, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  Holder<V> found = no_holder<V>();
  V depth = V(-2 * std::numeric_limits<T>::epsilon()) * candidates.end_size;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const V number(static_cast<T>(j));
    const V s = touch<V, arithmetic, surroundings>(surface, x).s;
    const Mask<V> is_new = lanes & (s < depth) & !is_among(held, number);
    if (!any_lane<V>(is_new)) continue;
    const Touch<V> end = touch<V, arithmetic, surroundings>(surface, x1);
    const auto candidate = candidates.of(j, end.s);
    const Mask<V> is_it = is_new & candidate.may_hold;
    depth = select<V>(is_it, s, depth);
    found = select(is_it, Holder<V>{number, end.s, candidate.s0, V(surface.mu), V(surface.hold), end.n}, found);
  }
  return found;
}

// Lanes that a third surface keeps from moving along the edge of two: two of the three may do, else they stay where they are.
template <class V, Arithmetic arithmetic>
HeldEnd<V> held_by_three(const Holder<V>& a, const Holder<V>& b, const Holder<V>& c, const Trajectory<V>& m,
                         V direction) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V depth = V(-2 * std::numeric_limits<T>::epsilon()) * one_norm(m.x1);
  const auto leaves = [&](const Holder<V>& first, const Holder<V>& other) {
    const Two<V> way = solve_two(first.s, c.s, wedge_of<V, arithmetic>(first.n, c.n));
    const V s = multiply_add<arithmetic>(way.b, dot<arithmetic>(c.n, other.n),
                                         multiply_add<arithmetic>(way.a, dot<arithmetic>(first.n, other.n), other.s));
    return s >= depth;
  };
  const Mask<V> leaves_b = leaves(a, b);
  const Mask<V> leaves_a = leaves(b, a);
  const HeldEnd<V> end = held_by_two<V, arithmetic>(select(leaves_b, a, b), c, m, direction);
  return select(leaves_b | leaves_a, end, HeldEnd<V>{m.x0, three<V>(zero), three<V>(zero), zero, zero});
}

// Lanes as what holds them sees them; v: the velocity which that has at the lanes' end, before they are held; more: what of it
// is not the first holder's.
template <class V>
struct Against {
  Trajectory<V> m;
  Three<V> v, more;
};

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Against<V> against_one(const Terms<Scalar<V>>& terms, const Holder<V>& a, const Trajectory<V>& m,
                                         V t) noexcept {
  using T = Scalar<V>;
  const Three<V> none = three<V>(V(T(0)));
  Against<V> against{m, none, none};
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Mask<V> is_it = a.number == V(static_cast<T>(j));
    if (surface.movement == Movement::rest || !any_lane<V>(is_it)) continue;
    const Trajectory<V> seen = as_seen<V, arithmetic>(surface, m, t);
    const Three<V> v = velocity_at<V, arithmetic>(surface, m.x1, V(T(0)));
    against.m.x0 = select(is_it, seen.x0, against.m.x0);
    against.m.v0 = select(is_it, seen.v0, against.m.v0);
    against.v = select(is_it, v, against.v);
  }
  against.m.v1 = m.v1 - against.v;
  return against;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Against<V> against_two(const Terms<Scalar<V>>& terms, const Holder<V>& a, const Holder<V>& b,
                                         const Trajectory<V>& m, V t) noexcept {
  const Against<V> one = against_one<V, arithmetic>(terms, a, m, t);
  const Three<V> other = against_one<V, arithmetic>(terms, b, m, t).v;
  const Wedge<V> wedge = wedge_of<V, arithmetic>(a.n, b.n);
  const V share = select<V>(wedge.is_wedge, wedge.scale * dot<arithmetic>(b.n, other - one.v), V(Scalar<V>(0)));
  const Three<V> more = share * subtract_product<arithmetic>(b.n, wedge.kappa, a.n);
  Against<V> against = one;
  against.v = one.v + more;
  against.more = more;
  against.m.x0 = multiply_add<arithmetic>(t, more, one.m.x0);
  against.m.v0 = one.m.v0 - more;
  against.m.v1 = m.v1 - against.v;
  return against;
}

template <class V>
Against<V> select(const Mask<V>& where, const Against<V>& a, const Against<V>& b) noexcept {
  return {{select(where, a.m.x0, b.m.x0), select(where, a.m.v0, b.m.v0), select(where, a.m.x1, b.m.x1),
           select(where, a.m.v1, b.m.v1)},
          select(where, a.v, b.v),
          select(where, a.more, b.more)};
}

// What holds lanes that end at x goes there by this.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Three<V> velocity_of(const Terms<Scalar<V>>& terms, const Holder<V>& a, const Against<V>& against,
                                       const Three<V>& x) noexcept {
  using T = Scalar<V>;
  Three<V> v = against.v;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Mask<V> is_it = a.number == V(static_cast<T>(j));
    if (surface.movement != Movement::turns || !any_lane<V>(is_it)) continue;
    v = select(is_it, velocity_at<V, arithmetic>(surface, x, V(T(0))) + against.more, v);
  }
  return v;
}

// Ends the step of lanes on the surfaces that hold them from here on: an active set of at most three, the deepest first.
template <class V, Arithmetic arithmetic, PathForm form, Surroundings surroundings = Surroundings::any>
void hold(const Terms<Scalar<V>>& terms, Trajectory<V>& m, Course<V, arithmetic, form>& course, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V none(T(-1));
  constexpr bool is_any = surroundings == Surroundings::any;
  if constexpr (is_any) watch(terms, course, m.x1, lanes);
  Candidates<V, arithmetic, form, surroundings> candidates(terms, m, course);
  Holder<V> a = no_holder<V>();
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const V number(static_cast<T>(j));
    const Touch<V> end = touch<V, arithmetic, surroundings>(surface, m.x1);
    const Mask<V> is_deeper = lanes & (end.s < a.s);
    if (!any_lane<V>(is_deeper)) continue;
    const auto candidate = candidates.of(j, end.s);
    a = select(is_deeper & candidate.may_hold, Holder<V>{number, end.s, candidate.s0, V(surface.mu), V(surface.hold), end.n},
               a);
  }
  const Mask<V> is_held = a.number >= zero;
  auto& held = course.held;
  held.a = select<V>(lanes, a.number, held.a);
  held.b = select<V>(lanes, none, held.b);
  held.c = select<V>(lanes, none, held.c);
  if (!any_lane<V>(is_held)) return;

  const bool moves = is_any && terms.moves;
  Against<V> moved;
  if (moves) moved = against_one<V, arithmetic>(terms, a, m, course.t);
  const auto against = [&]() -> const Trajectory<V>& { return moves ? moved.m : m; };
  HeldEnd<V> end = held_by_one<V, arithmetic>(a, against(), course.direction);
  if constexpr (is_any) watch(terms, course, end.x, is_held);
  const Holder<V> b = deepest<V, arithmetic, form, surroundings>(terms, candidates, m.x1, held, end.x, is_held);
  const Mask<V> has_b = b.number >= zero;
  if (any_lane<V>(has_b)) {
    if (moves) moved = select(has_b, against_two<V, arithmetic>(terms, a, b, m, course.t), moved);
    end = select(has_b, held_by_two<V, arithmetic>(a, b, against(), course.direction), end);
    held.b = select<V>(has_b, b.number, held.b);
    if constexpr (is_any) watch(terms, course, end.x, has_b);
    const Holder<V> c = deepest<V, arithmetic, form, surroundings>(terms, candidates, m.x1, held, end.x, has_b);
    const Mask<V> has_c = c.number >= zero;
    if (any_lane<V>(has_c)) {
      end = select(has_c, held_by_three<V, arithmetic>(a, b, c, against(), course.direction), end);
      held.c = select<V>(has_c, c.number, held.c);
    }
  }
  // Friction brakes all through the step.
  const V kept = kept_by_friction(end.slide, end.hold, square_root(dot<arithmetic>(end.v, end.v)));
  const Three<V> rubbed = kept * end.v;
  end.x = multiply_add<arithmetic>(V(T(0.5)) * course.t, rubbed - end.v, end.x);
  end.v = rubbed;

  // Rounding alone must not make a resting particle creep.
  const V motion = magnitude(course.t) * one_norm(end.v0 + end.v);
  const Mask<V> rests = motion < V(std::numeric_limits<T>::epsilon() / 4) * candidates.end_size;
  const V sunk = select<V>(held.b < zero, a.s0, zero);
  end.x = select(rests, subtract_product<arithmetic>(against().x0, sunk, a.n), end.x);
  if (moves) {
    end.v = end.v + velocity_of<V, arithmetic>(terms, a, moved, end.x);
    end.v0 = m.v0 + (end.v0 - moved.m.v0);
  }
  held.dx = select(is_held, end.x - m.x1, held.dx);
  held.dv = select(is_held, end.v - m.v1, held.dv);
  m.x1 = select(is_held, end.x, m.x1);
  m.v1 = select(is_held, end.v, m.v1);
  m.v0 = select(is_held, end.v0, m.v0);
}

// ---------------------------------------------------------------------------------- impacts

// What is left of the tangential velocity at an impact, and of infinitely many where they are over within the step. What lay or
// slid on the surface before comes to none.
template <class V, Arithmetic arithmetic, PathForm form>
V kept_by_viscosity(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Course<V, arithmetic, form>& course,
                    const Three<V>& gain, Mask<V> is_over) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  if (surface.tau == 1) return one;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<V> start = touch<V, arithmetic>(surface, m.x0);
  const V low = V(low_bounce * eps) * (one_norm(m.x0) + V(surface.radius));
  const V out = course.direction * dot<arithmetic>(start.n, m.v0);
  const V own = magnitude(dot<arithmetic>(start.n, gain));
  const V rounding = V(4 * eps) * one_norm(m.v0);
  const Mask<V> is_out = out > V(T(0));
  const Mask<V> stays_low = (out <= rounding) | (out * out * magnitude(course.t) <= V(T(2)) * own * low);
  const Mask<V> comes_slow = -out <= own + rounding;
  const Mask<V> rests = (start.s <= V(T(4)) * low) & ((is_out & stays_low) | ((!is_out) & comes_slow));
  return select<V>(rests, one, select<V>(is_over, V(T(0)), V(surface.tau)));
}

// A particle at the part f of what remains.
template <class V>
struct Moment {
  Three<V> x, v;
};

template <class V, Arithmetic arithmetic, PathForm form>
Moment<V> moment(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Course<V, arithmetic, form>& course,
                 const Three<V>& gain, V f) noexcept {
  if constexpr (form == PathForm::parabola) {
    return {along<V, arithmetic>(m.x0, path(surface, m, course.t), f), multiply_add<arithmetic>(f, gain, m.v0)};
  } else {
    const Responses<V> P = (*course.bending)(f * course.left);
    const auto& end = course.end;
    const bool is_driven = course.bending->is_driven();
    const V frequency = quotient<V>(V(Scalar<V>(1)), course.h);
    Three<V> v1 = m.v1;
    if (is_driven) v1 = v1 - frequency * driven<V, arithmetic>(course.drive, end.P2, end.P3, end.P4);
    Moment<V> at;
    for (std::size_t k = 0; k < 3; ++k) {
      const V pull = subtract_product<arithmetic>(v1[k], m.v0[k], end.P0[k]) * inverse(end.P1[k]);
      at.v[k] = multiply_add<arithmetic>(pull, P.P1[k], m.v0[k] * P.P0[k]);
    }
    if (is_driven) at.v = at.v + frequency * driven<V, arithmetic>(course.drive, P.P2, P.P3, P.P4);
    at.x = surface.sweep == ContactPath::line ? along<V, arithmetic>(m.x0, path(surface, m, course.t), f)
                                              : m.x0 + flow_path<V, arithmetic>(m, course).way(P);
    return at;
  }
}

// The normal and the velocity of a surface where it meets lanes at x, t before the end.
template <class V>
struct Meeting {
  Three<V> n, v;
};

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Meeting<V> meeting(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  const Three<V> n = touch<V, arithmetic>(surface, taken_along<V, arithmetic>(surface, x, t)).n;
  const Three<V> v = velocity_at<V, arithmetic>(surface, x, t);
  if (surface.movement != Movement::turns) return {n, v};
  return {turned_by<V, arithmetic>((-t) * three<V>(surface.omega), n), v};
}

template <class V, Arithmetic arithmetic, PathForm form>
void respond(const Surface<Scalar<V>>& surface, Trajectory<V>& m, Course<V, arithmetic, form>& course, V f,
             Mask<V> hits) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const Three<V> gain = m.v1 - m.v0;
  const auto [xf, vf] = moment<V, arithmetic, form>(surface, m, course, gain, f);
  const V rest = one - f;
  const V t = rest * course.t;
  const bool moves = surface.movement != Movement::rest;
  Meeting<V> met;
  if (moves) {
    met = meeting<V, arithmetic>(surface, xf, t);
  } else {
    met.n = touch<V, arithmetic>(surface, xf).n;
  }
  const Three<V> n = met.n;
  const Three<V> vr = moves ? vf - met.v : vf;
  const V vn = dot<arithmetic>(n, vr);
  const Mask<V> acts = hits & (course.direction * vn <= zero);

  // An impact whose bounces would all be over within the step is the last of them. What holds a lane up to here, and its
  // friction, do not press.
  const Mask<V> was_held = course.held.a >= zero;
  const Three<V> forces = select(was_held, gain - course.held.dv, gain);
  const V pressed = rest * (course.direction * dot<arithmetic>(n, forces));
  const Mask<V> is_over = V(surface.e + surface.e) * magnitude(vn) <= V(surface.e - 1) * pressed;
  const bool may_settle = surface.response == Response::resume && surface.e > 0;
  const V e = may_settle ? select<V>(is_over, zero, V(surface.e)) : V(surface.e);
  Trajectory<V> room;
  const V tau = kept_by_viscosity<V, arithmetic, form>(surface, seen_from<V, arithmetic>(surface, m, course.t, room), course,
                                                       gain, may_settle ? is_over : Mask<V>(false));
  const Three<V> vt = tau * subtract_product<arithmetic>(vr, vn, n);
  const V slide = V(surface.mu) * ((one + e) * magnitude(vn));
  const V kept = surface.mu == 0 ? one : kept_by_friction(slide, slide, square_root(dot<arithmetic>(vt, vt)));
  const Three<V> away = subtract_product<arithmetic>(kept * vt, e * vn, n);
  const Three<V> after = moves ? away + met.v : away;

  // What held a lane up to here need not hold it in the rest.
  const Three<V> x1 = select(was_held, subtract_product<arithmetic>(m.x1, rest * rest, course.held.dx), m.x1);
  const Three<V> way = x1 - xf;
  const V beyond = dot<arithmetic>(n, moves ? subtract_product<arithmetic>(way, t, met.v) : way);
  Three<V> moved = subtract_product<arithmetic>(x1, beyond, n);
  Three<V> v1;
  if constexpr (form == PathForm::parabola) {
    if (surface.response == Response::resume) moved = multiply_add<arithmetic>(t, after - vf, x1);
    v1 = multiply_add<arithmetic>(rest, gain, after);
  } else {
    const V left = rest * course.left;
    const Responses<V> P = (*course.bending)(left);
    for (std::size_t k = 0; k < 3; ++k) {
      const V pulse = after[k] - vf[k];
      if (surface.response == Response::resume) moved[k] = multiply_add<arithmetic>(course.h * P.P1[k], pulse, x1[k]);
      v1[k] = multiply_add<arithmetic>(P.P0[k], pulse, m.v1[k]);
    }
    if (course.bending->is_driven()) {
      const V passed = f * course.left;
      const Drive<V>& drive = course.drive;
      const Three<V> D2 = multiply_add<arithmetic>(passed, drive.D3, drive.D2);
      const V half = V(Scalar<V>(0.5)) * passed;
      const Three<V> D1 = multiply_add<arithmetic>(passed, multiply_add<arithmetic>(half, drive.D3, drive.D2), drive.D1);
      course.drive = {select(hits, D1, drive.D1), select(hits, D2, drive.D2), drive.D3};
    }
    course.left = select<V>(hits, left, course.left);
    course.end = select(hits, P, course.end);
  }
  v1 = select(was_held, subtract_product<arithmetic>(v1, rest, course.held.dv), v1);

  m.x1 = select(acts, moved, select(hits, x1, m.x1));
  m.v1 = select(acts, v1, select(hits & was_held, subtract_product<arithmetic>(m.v1, rest, course.held.dv), m.v1));
  m.x0 = select(hits, xf, m.x0);
  m.v0 = select(acts, after, select(hits, vf, m.v0));
  course.t = select<V>(hits, t, course.t);
}

// Lanes whose path may touch a surface that does not hold them.
template <class V, Arithmetic arithmetic, PathForm form, Surroundings surroundings = Surroundings::any>
class Nearness {
  using T = Scalar<V>;

 public:
  Nearness(const Terms<T>& terms, const Trajectory<V>& m, const Course<V, arithmetic, form>& course) noexcept
      : terms_(terms),
        m_(m),
        course_(course),
        corner_(V(terms.bend.corner) * course.t),
        middle_(multiply_add<arithmetic>(corner_, m.v0, m.x0)) {}

  void watch_ends(Course<V, arithmetic, form>& course, Mask<V> lanes) const noexcept {
    if constexpr (surroundings == Surroundings::planes) return;
    watch(terms_, course, m_.x1, lanes);
    watch(terms_, course, middle_, lanes);
  }

  [[nodiscard]] Mask<V> operator()(std::size_t j) const noexcept {
    return may_touch(j) & !is_among(course_.held, V(static_cast<T>(j)));
  }

 private:
  [[nodiscard]] [[gnu::always_inline]] Mask<V> may_touch(std::size_t j) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    if constexpr (surroundings == Surroundings::planes) {
      return may_touch_plane<V, arithmetic>(surface, m_, middle_);
    } else {
      return dvdx::may_touch<V, arithmetic>(surface, m_, middle_, course_.t, corner_);
    }
  }

  const Terms<T>& terms_;
  const Trajectory<V>& m_;
  const Course<V, arithmetic, form>& course_;
  V corner_;
  Three<V> middle_;
};

// The earliest impact of every lane; false where none remains.
template <class V, Arithmetic arithmetic, PathForm form>
bool resolve_earliest(const Terms<Scalar<V>>& terms, Trajectory<V>& m, Course<V, arithmetic, form>& course) noexcept {
  using T = Scalar<V>;
  const V low = V(4 * low_bounce * std::numeric_limits<T>::epsilon()) * one_norm(m.x0);
  const Nearness<V, arithmetic, form> near(terms, m, course);
  near.watch_ends(course, course.active);
  V earliest(T(2));
  V which(T(-1));
  Mask<V> any_near(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const V number(static_cast<T>(j));
    const Mask<V> lanes = course.active & near(j);
    if (!any_lane<V>(lanes)) continue;
    any_near = any_near | lanes;
    const Crossing<V> crossing = cross<V, arithmetic, form>(terms, terms.surfaces[j], m, course, course.last == number, low);
    const Mask<V> is_earlier = lanes & crossing.hits & (crossing.f < earliest);
    earliest = select<V>(is_earlier, crossing.f, earliest);
    which = select<V>(is_earlier, number, which);
  }
  course.active = course.active & (which >= V(T(0)));
  course.loose = (course.loose | any_near) & !course.active;
  if (!any_lane<V>(course.active)) return false;
  course.last = select<V>(course.active, which, course.last);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Mask<V> hits = which == V(static_cast<T>(j));
    if (any_lane<V>(hits)) respond<V, arithmetic, form>(terms.surfaces[j], m, course, earliest, hits);
  }
  hold<V, arithmetic, form>(terms, m, course, course.active);
  return true;
}

template <class V, Arithmetic arithmetic, PathForm form>
void clamp(const Surface<Scalar<V>>& surface, Trajectory<V>& m, const Course<V, arithmetic, form>& course, Mask<V> held,
           Mask<V> inside, V size) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const Three<V> n = touch<V, arithmetic>(surface, m.x1).n;
  Trajectory<V> room;
  const Trajectory<V>& seen = seen_from<V, arithmetic>(surface, m, course.t, room);
  const V vn = dot<arithmetic>(n, seen.v1);
  const V removed = magnitude(vn);
  const Three<V> vt = subtract_product<arithmetic>(seen.v1, vn, n);
  const V length = square_root(dot<arithmetic>(vt, vt));
  const V kept = kept_by_friction(V(surface.mu) * removed, V(surface.hold) * removed, length);
  const Mask<V> is_pressed = inside & (course.direction * vn < zero);
  const Three<V> slower = select(is_pressed, kept * vt, seen.v1);
  const V motion = magnitude(course.t) * one_norm(seen.v0 + slower);
  const Mask<V> rests = held & (motion < V(std::numeric_limits<T>::epsilon() / 4) * size);
  const Three<V> base = select(rests, seen.x0, m.x1);
  const Touch<V> there = touch<V, arithmetic>(surface, base);
  m.x1 = select(inside, subtract_product<arithmetic>(base, there.s, there.n), m.x1);
  if (surface.movement == Movement::rest) {
    m.v1 = slower;
  } else {
    m.v1 = select(is_pressed, slower + velocity_at<V, arithmetic>(surface, m.x1, V(T(0))), m.v1);
  }
}

template <class V, Arithmetic arithmetic, PathForm form>
void clamp_all(const Terms<Scalar<V>>& terms, Trajectory<V>& m, Course<V, arithmetic, form>& course, Mask<V> touches) noexcept {
  using T = Scalar<V>;
  watch(terms, course, m.x1, touches);
  V tolerance(T(0));
  for (int round = 0; round < clamp_rounds; ++round) {
    Mask<V> is_clamped(false);
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const auto& surface = terms.surfaces[j];
      const V size = one_norm(m.x1);
      const V number(static_cast<T>(j));
      const Mask<V> is_held = is_among(course.held, number);
      // A plane that holds a lane has it where it should be.
      const Mask<V> is_looked_at = round == 0 && surface.shape == Shape::plane ? touches & !is_held : touches;
      const Mask<V> inside = is_looked_at & (touch<V, arithmetic>(surface, m.x1).s < -(tolerance * size));
      if (!any_lane<V>(inside)) continue;
      is_clamped = is_clamped | inside;
      clamp<V, arithmetic, form>(surface, m, course, (course.last == number) | is_held, inside, size);
      watch(terms, course, m.x1, inside);
    }
    touches = touches & is_clamped;
    if (!any_lane<V>(touches)) return;
    tolerance = V(2 * std::numeric_limits<T>::epsilon());
  }
}

template <class T>
bool has_body(const Terms<T>& terms) noexcept {
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (terms.surfaces[j].shape != Shape::plane) return true;
  }
  return false;
}

// Whether surfaces may hold lanes at their start. None: it has been looked at.
enum class Standing { unknown, none };

// Only lanes in `touches` change, so that a particle's bits do not depend on its neighbours.
template <class V, Arithmetic arithmetic, PathForm form>
void resolve_all(const Terms<Scalar<V>>& terms, Mask<V> touches, Standing standing, Trajectory<V>& m,
                 Course<V, arithmetic, form>& course) noexcept {
  if (standing == Standing::unknown) hold<V, arithmetic, form>(terms, m, course, touches);
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest<V, arithmetic, form>(terms, m, course)) break;
  }
  // What was near nothing in the end but planes that hold it is outside. (Of a body the two tests round in different ways.)
  const Mask<V> lanes = has_body(terms) ? touches : touches & (course.loose | course.active);
  if (any_lane<V>(lanes)) clamp_all<V, arithmetic, form>(terms, m, course, lanes);
}

template <class V, Arithmetic arithmetic>
Course<V, arithmetic, PathForm::parabola> course_of(const Terms<Scalar<V>>& terms, Mask<V> touches) noexcept {
  using T = Scalar<V>;
  return {.direction = V(terms.h < 0 ? T(-1) : T(1)),
          .t = V(terms.h),
          .last = V(T(-1)),
          .active = touches,
          .loose = Mask<V>(false),
          .held = not_held<V>()};
}

// Both return the lanes that have strayed.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> resolve_on_parabolas(const Terms<Scalar<V>>& terms, Mask<V> touches, Standing standing,
                                               Trajectory<V>& m) noexcept {
  auto course = course_of<V, arithmetic>(terms, touches);
  resolve_all<V, arithmetic, PathForm::parabola>(terms, touches, standing, m, course);
  return course.strayed;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> resolve_in_flow(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets, Mask<V> touches,
                                          Standing standing, Trajectory<V>& m, const Bending<V, arithmetic>& bending) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  Course<V, arithmetic, PathForm::flow> course{.direction = V(terms.h < 0 ? T(-1) : T(1)),
                                               .t = V(terms.h),
                                               .last = V(T(-1)),
                                               .active = touches,
                                               .loose = Mask<V>(false),
                                               .held = not_held<V>(),
                                               .bending = &bending,
                                               .h = V(terms.h),
                                               .left = one,
                                               .end = bending(one),
                                               .drive = {}};
  if (bending.is_driven()) {
    course.drive = {three<V>(offsets.drive[0]), three<V>(offsets.drive[1]), three<V>(offsets.drive[2])};
  }
  resolve_all<V, arithmetic, PathForm::flow>(terms, touches, standing, m, course);
  return course.strayed;
}

// The commonest impact straight on: lanes that come from above the only plane, bounce off it once along their parabolas, and do
// not come near it again. The formulas and their order are those of resolve_all. Returns the lanes that are left.
template <class V>
bool is_one_plane(const Terms<Scalar<V>>& terms) noexcept {
  const Surface<Scalar<V>>& surface = terms.surfaces[0];
  return terms.surface_count == 1 && !terms.moves && !terms.searches && terms.bend.degree == 0 && terms.impacts > 1 &&
         surface.shape == Shape::plane && surface.sweep == ContactPath::curve && surface.response == Response::resume &&
         surface.tau == 1;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> bounce_once(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m) noexcept {
  using T = Scalar<V>;
  const Surface<T>& surface = terms.surfaces[0];
  const V zero(T(0));
  const V one(T(1));
  const V d(surface.d);
  const V direction(terms.h < 0 ? T(-1) : T(1));
  const V h(terms.h);
  const Three<V> n = three<V>(surface.n);
  const V start = dot<arithmetic>(n, m.x0) - d;
  const V near = V(4 * std::numeric_limits<T>::epsilon()) * (one_norm(m.x0) + V(surface.radius));
  const Mask<V> stands = magnitude(start) <= near;
  if (!any_lane<V>(touches & !stands)) return touches;

  const V s0 = select<V>(start < zero, zero, start);
  const V s1 = dot<arithmetic>(n, m.x1) - d;
  const V d0 = h * dot<arithmetic>(n, m.v0);
  const V c = (s1 - s0) - d0;
  const V disc = discriminant<V, arithmetic>(s0, d0, c);
  V f = first_root(s0, d0, c, disc);
  f = select<V>(f < one, f, one);
  Mask<V> hits = s1 < zero;
  if (surface.finds_dips) hits = hits | ((d0 < zero) & (disc > zero) & (-d0 < c + c));

  const Three<V> gain = m.v1 - m.v0;
  const Three<V> xf = along<V, arithmetic>(m.x0, path(surface, m, h), f);
  const Three<V> vf = multiply_add<arithmetic>(f, gain, m.v0);
  const V vn = dot<arithmetic>(n, vf);
  const V rest = one - f;
  const V t = rest * h;
  const V pressed = rest * (direction * dot<arithmetic>(n, gain));
  const Mask<V> is_over = V(surface.e + surface.e) * magnitude(vn) <= V(surface.e - 1) * pressed;
  const V e = surface.e > 0 ? select<V>(is_over, zero, V(surface.e)) : V(surface.e);
  Three<V> vt = subtract_product<arithmetic>(vf, vn, n);
  if (surface.mu != 0) {
    const V slide = V(surface.mu) * ((one + e) * magnitude(vn));
    vt = kept_by_friction(slide, slide, square_root(dot<arithmetic>(vt, vt))) * vt;
  }
  const Three<V> after = subtract_product<arithmetic>(vt, e * vn, n);
  const Three<V> x1 = multiply_add<arithmetic>(t, after - vf, m.x1);
  const Three<V> v1 = multiply_add<arithmetic>(rest, gain, after);

  const Three<V> middle = multiply_add<arithmetic>(V(terms.bend.corner) * t, after, xf);
  const Mask<V> comes_back = (dot<arithmetic>(n, x1) < d) | (dot<arithmetic>(n, middle) < d);
  const Mask<V> bounces = direction * vn <= zero;
  const Mask<V> left = touches & (stands | (hits & (comes_back | !bounces)));
  const Mask<V> done = touches & hits & !left;
  m.x1 = select(done, x1, m.x1);
  m.v1 = select(done, v1, m.v1);
  return left;
}

// ---------------------------------------------------------------------------------- which lanes are worked out together

// What surfaces hold is done with; lanes that may meet another one are left. Most of what touches a surface lies on it.
template <class V>
struct Settled {
  Mask<V> busy;  // lanes that are not done with
  Standing standing;
  Mask<V> strayed;
};

template <class V, Arithmetic arithmetic, Surroundings surroundings>
[[gnu::noinline]] Settled<V> settle(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m) noexcept {
  auto course = course_of<V, arithmetic>(terms, touches);
  hold<V, arithmetic, PathForm::parabola, surroundings>(terms, m, course, touches);
  const Nearness<V, arithmetic, PathForm::parabola, surroundings> near(terms, m, course);
  near.watch_ends(course, touches);
  Mask<V> busy(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) busy = busy | near(j);
  busy = busy & touches;
  const Mask<V> is_held = touches & (course.held.a >= V(Scalar<V>(0)));
  const bool holds = any_lane<V>(is_held);
  const Mask<V> lanes = touches & !busy;
  if constexpr (surroundings == Surroundings::any) {
    if (has_body(terms) && any_lane<V>(lanes)) clamp_all<V, arithmetic, PathForm::parabola>(terms, m, course, lanes);
  }
  return {busy & !course.strayed, holds ? Standing::unknown : Standing::none, course.strayed};
}

// Lanes one by one: x0, v0, x1, v1 of each, and which of them are chosen (not 0).
template <class V>
struct Unpacked {
  using T = Scalar<V>;
  static constexpr std::size_t count = 12;

  Unpacked(const Trajectory<V>& m, Mask<V> chosen) noexcept {
    store_lanes(is_chosen, select<V>(chosen, V(T(1)), V(T(0))));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      store_lanes(numbers[axis], m.x0[axis]);
      store_lanes(numbers[3 + axis], m.v0[axis]);
      store_lanes(numbers[6 + axis], m.x1[axis]);
      store_lanes(numbers[9 + axis], m.v1[axis]);
    }
  }

  alignas(64) T numbers[count][V::size];
  alignas(64) T is_chosen[V::size];
};

// Lanes that meet surfaces wait here until they fill a register: one of them would take as long as all.
template <class V, Arithmetic arithmetic>
class Waiting {
  using T = Scalar<V>;

 public:
  // m: lanes from i of the block on, before anything touched them.
  void take(const Trajectory<V>& m, Mask<V> busy, std::size_t i) noexcept {
    const Unpacked<V> lanes(m, busy);
    for (std::size_t k = 0; k < V::size; ++k) {
      if (lanes.is_chosen[k] == T(0)) continue;
      for (std::size_t n = 0; n < numbers; ++n) numbers_[n][count_] = lanes.numbers[n][k];
      at_[count_++] = i + k;
    }
  }

  [[nodiscard]] bool is_full() const noexcept { return count_ >= V::size; }

  // Those that fill a register, or all: back into the block.
  void resolve(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets) noexcept {
    const std::size_t n = count_ < V::size ? count_ : V::size;
    if (n == 0) return;
    for (std::size_t k = n; k < V::size; ++k) {
      for (auto& column : numbers_) column[k] = column[0];
      at_[k] = at_[0];
    }
    Trajectory<V> m = first_waiting();
    const Mask<V> strayed = resolve(particles, terms, offsets, first_lanes<V>(n), m);
    if (terms.whole != nullptr && any_lane<V>(strayed)) {
      Trajectory<V> again = first_waiting();
      resolve(particles, *terms.whole, offsets, strayed, again);
      m.x1 = select(strayed, again.x1, m.x1);
      m.v1 = select(strayed, again.v1, m.v1);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put_back(m.x1[axis], particles.x[axis], n);
      put_back(m.v1[axis], particles.v[axis], n);
    }
    for (std::size_t k = n; k < count_; ++k) {
      for (auto& column : numbers_) column[k - n] = column[k];
      at_[k - n] = at_[k];
    }
    count_ -= n;
  }

 private:
  static constexpr std::size_t numbers = Unpacked<V>::count;

  [[nodiscard]] Trajectory<V> first_waiting() const noexcept {
    Trajectory<V> m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      m.x0[axis] = load_lanes<V>(numbers_[axis]);
      m.v0[axis] = load_lanes<V>(numbers_[3 + axis]);
      m.x1[axis] = load_lanes<V>(numbers_[6 + axis]);
      m.v1[axis] = load_lanes<V>(numbers_[9 + axis]);
    }
    return m;
  }

  Mask<V> resolve(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets, Mask<V> lanes,
                  Trajectory<V>& m) const noexcept {
    if (terms.bend.degree == 0) return resolve_on_parabolas<V, arithmetic>(terms, lanes, Standing::unknown, m);
    const Bending<V, arithmetic> bending(terms.bend, particles.first, at_);
    return resolve_in_flow<V, arithmetic>(terms, offsets, lanes, Standing::unknown, m, bending);
  }

  void put_back(V value, T* to, std::size_t n) const noexcept {
    alignas(64) T lanes[V::size];
    store_lanes(lanes, value);
    for (std::size_t k = 0; k < n; ++k) to[at_[k]] = lanes[k];
  }

  T numbers_[numbers][2 * V::size];
  std::size_t at_[2 * V::size];
  std::size_t count_ = 0;
};

template <class V>
[[gnu::always_inline]] inline Three<V> copied(const Three<V>& a) noexcept {
  return {{a[0], a[1], a[2]}};
}

template <class V>
std::size_t lanes_in(Mask<V> mask) noexcept {
  using T = Scalar<V>;
  alignas(64) T lanes[V::size];
  store_lanes(lanes, select<V>(mask, V(T(1)), V(T(0))));
  std::size_t count = 0;
  for (const T lane : lanes) count += lane != T(0) ? 1 : 0;
  return count;
}

// Lanes of particles from `first` on, one after the other by the scalar twin.
template <class V>
[[gnu::noinline]] void resolve_logged(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets, Mask<V> touches,
                                      Trajectory<V>& m, std::size_t first, ContactLog<Scalar<V>>& log) noexcept {
  using T = Scalar<V>;
  Unpacked<V> lanes(m, touches);
  auto& numbers = lanes.numbers;
  for (std::size_t k = 0; k < V::size; ++k) {
    if (lanes.is_chosen[k] == T(0)) continue;
    const auto three_from = [&](std::size_t n) {
      return std::array<T, 3>{numbers[n][k], numbers[n + 1][k], numbers[n + 2][k]};
    };
    reference::Particle<T> p{three_from(0), three_from(3), three_from(6), three_from(9)};
    log.resolve(terms, offsets, p, first + k, log);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      numbers[6 + axis][k] = p.x1[axis];
      numbers[9 + axis][k] = p.v1[axis];
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    m.x1[axis] = load_lanes<V>(numbers[6 + axis]);
    m.v1[axis] = load_lanes<V>(numbers[9 + axis]);
  }
}

// Lanes from i of the plan's columns on; returns those that have strayed.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> resolve_busy(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                   Mask<V> lanes, Standing standing, Trajectory<V>& m, std::size_t i) noexcept {
  if (terms.bend.degree == 0) return resolve_on_parabolas<V, arithmetic>(terms, lanes, standing, m);
  const Bending<V, arithmetic> bending(terms.bend, i);
  return resolve_in_flow<V, arithmetic>(terms, offsets, lanes, standing, m, bending);
}

// Lanes from i of the block on. Whether any of them touched a surface. Those that wait end later than m says.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline bool resolve_contacts(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                    Trajectory<V>& m, std::size_t first, std::size_t i,
                                                    Waiting<V, arithmetic>& waiting, ContactLog<Scalar<V>>* log) noexcept {
  const Mask<V> touches = terms.moves || terms.searches
                              ? may_touch_any<V, arithmetic>(terms, {copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)})
                              : TouchTest<V, arithmetic>(terms)(m, {});
  if (!any_lane<V>(touches)) [[likely]]
    return false;
  // The original never has its address taken, and is copied register by register, so that it stays in registers elsewhere.
  Trajectory<V> copy{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
  if (log != nullptr) {
    resolve_logged<V>(terms, offsets, touches, copy, first + i, *log);
    m.x1 = copied(copy.x1);
    m.v1 = copied(copy.v1);
    return true;
  }
  const Mask<V> left = is_one_plane<V>(terms) ? bounce_once<V, arithmetic>(terms, touches, copy) : touches;
  if (!any_lane<V>(left)) {
    m.x1 = copied(copy.x1);
    m.v1 = copied(copy.v1);
    return true;
  }
  const Settled<V> settled = terms.are_planes && !terms.moves ? settle<V, arithmetic, Surroundings::planes>(terms, left, copy)
                                                              : settle<V, arithmetic, Surroundings::any>(terms, left, copy);
  Mask<V> strayed = settled.strayed;
  if (any_lane<V>(settled.busy)) {
    Trajectory<V> fresh{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
    if (2 * lanes_in<V>(settled.busy) < V::size) {
      waiting.take(fresh, settled.busy, i);
    } else {
      strayed = strayed | resolve_busy<V, arithmetic>(terms, offsets, settled.busy, settled.standing, fresh, first + i);
      copy.x1 = select(settled.busy, fresh.x1, copy.x1);
      copy.v1 = select(settled.busy, fresh.v1, copy.v1);
    }
  }
  if (terms.whole != nullptr && any_lane<V>(strayed)) {
    Trajectory<V> again{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
    resolve_busy<V, arithmetic>(*terms.whole, offsets, strayed, Standing::unknown, again, first + i);
    copy.x1 = select(strayed, again.x1, copy.x1);
    copy.v1 = select(strayed, again.v1, copy.v1);
  }
  m.x1 = copied(copy.x1);
  m.v1 = copied(copy.v1);
  return true;
}

}  // namespace
}  // namespace dvdx
