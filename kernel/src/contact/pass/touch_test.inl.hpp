// The test which lanes may touch a surface within the step, wide. Every particle pays for it. The scalar twin:
// touch_test_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/moving.inl.hpp"
#include "contact/pass/push_out.inl.hpp"
#include "contact/surfaces/shape.inl.hpp"
#include "flow/terms.hpp"

namespace dvdx {
namespace {

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch_plane(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                      const Three<V>& middle) noexcept {
  const Three<V> n = three<V>(surface.n);
  const V d(surface.d);
  const Mask<V> ends_inside = dot<arithmetic>(n, m.x1) < d;
  return surface.finds_dips ? ends_inside | (dot<arithmetic>(n, middle) < d) : ends_inside;
}

// Outside a sphere, with r counted from its center, a path touches nothing while it stays in front of the tangent plane that
// faces its start, n.r > R with n = r0/|r0|. Without the root: r is near if r0.r <= 0 or (r0.r)^2 <= R^2 |r0|^2.
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

// For a plane or a sphere. It calls nothing, so that the loop around it keeps its registers.
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

// t: the remaining time of the step, s; corner: the time after which the tangents at both ends of the path meet, s.
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
    if (!pushes_out(terms.surfaces[j])) continue;
    touches = touches | start_on<V, arithmetic>(terms.surfaces[j], m.x0, V(terms.h)).is_inside;
  }
  return touches;
}

// Made once a block: data behind `terms` could alias the particles, and would be read again for every batch.
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

// The same for a single plane. It adds up axis by axis, each as soon as it has moved, which takes fewer registers. If dips do
// not count, the offset for them is minus infinity: nothing is below it.
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

}  // namespace
}  // namespace dvdx
