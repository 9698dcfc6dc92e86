// One register of particles through a step: load, move, store.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "contact/pass/contact.inl.hpp"
#include "flow/affine.inl.hpp"
#include "flow/radial.inl.hpp"
#include "flow/terms.hpp"
#include "simd/trajectory.inl.hpp"

namespace dvdx {
namespace {

template <class V, class OneAxis>
class Affine {
 public:
  Affine(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets) noexcept
      : axes_{{terms, offsets, 0}, {terms, offsets, 1}, {terms, offsets, 2}} {}

  [[gnu::always_inline]] void operator()(Trajectory<V>& m, std::size_t i) const noexcept {
    move(m, i, 0);  // no loop: one that is not unrolled keeps all of m in memory
    move(m, i, 1);
    move(m, i, 2);
  }

  [[gnu::always_inline]] void move(Trajectory<V>& m, std::size_t i, std::size_t axis) const noexcept {
    const AxisState<V> end = axes_[axis](m.x1[axis], m.v1[axis], i);
    m.x1[axis] = end.x;
    m.v1[axis] = end.v;
  }

 private:
  OneAxis axes_[3];
};

template <class V>
[[gnu::always_inline]] inline Trajectory<V> load_trajectory(const Block<Scalar<V>>& particles, std::size_t i) noexcept {
  Trajectory<V> m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    m.x1[axis] = m.x0[axis] = load_lanes<V>(particles.x[axis] + i);
    m.v1[axis] = m.v0[axis] = load_lanes<V>(particles.v[axis] + i);
  }
  return m;
}

template <class V>
[[gnu::always_inline]] inline void store_trajectory(const Block<Scalar<V>>& particles, std::size_t i,
                                                    const Trajectory<V>& m) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    store_lanes(particles.x[axis] + i, m.x1[axis]);
    store_lanes(particles.v[axis] + i, m.v1[axis]);
  }
}

// Moves the register of particles at i by everything but contacts.
template <class V, class OneAxis, StepFeatures features, Arithmetic arithmetic>
[[gnu::always_inline]] inline Trajectory<V> move_batch(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                                       const Offsets<Scalar<V>>* offsets, std::size_t i) noexcept {
  Trajectory<V> m = load_trajectory<V>(particles, i);
  const Affine<V, OneAxis> affine(terms, offsets[0]);
  affine(m, particles.first + i);
  if constexpr (features == StepFeatures::radial || features == StepFeatures::radial_contact) {
    if (terms.kicks != 0) {
      radial_kick<V, arithmetic>(terms, m, particles.first + i);
      const Affine<V, OneAxis> second_half(terms, offsets[1]);
      second_half(m, particles.first + i);
    }
    radial_contribution<V, arithmetic>(terms, m, particles.first + i);
  }
  if constexpr (has_contacts(features)) {
    if (particles.from[0] != nullptr) {
      for (std::size_t axis = 0; axis < 3; ++axis) m.x0[axis] = load_lanes<V>(particles.from[axis] + i);
    }
  }
  return m;
}

template <class V, class OneAxis, StepFeatures features, Arithmetic arithmetic>
[[gnu::noinline]] void move_batch_to(Trajectory<V>& m, const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                     const Offsets<Scalar<V>>* offsets, std::size_t i) noexcept {
  m = move_batch<V, OneAxis, features, arithmetic>(particles, terms, offsets, i);
}

// Moves the register of particles at i by the whole step. Returns true if any of them touched a surface or lay still.
template <class V, class OneAxis, StepFeatures features, Arithmetic arithmetic>
[[gnu::noinline]] bool step_batch(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                  const Offsets<Scalar<V>>* offsets, std::size_t i, Waiting<V, arithmetic>& waiting,
                                  Dormant<V>& still) noexcept {
  Trajectory<V> m;
  if constexpr (features == StepFeatures::contact) {
    // `moved` stays in registers: its address is never taken, and it is copied register by register.
    const Trajectory<V> moved = move_batch<V, OneAxis, features, arithmetic>(particles, terms, offsets, i);
    m = {copied(moved.x0), copied(moved.v0), copied(moved.x1), copied(moved.v1)};
  } else {
    move_batch_to<V, OneAxis, features, arithmetic>(m, particles, terms, offsets, i);
  }
  const std::uint64_t were_still = still.of(i);
  const std::uint64_t touching =
      resolve_contacts<V, arithmetic>(terms, offsets[0], m, particles.first, i, were_still, waiting, particles.log) |
      were_still;
  if (touching != 0 && still.looks()) still.look(m, i, touching);
  store_trajectory<V>(particles, i, m);
  return touching != 0;
}

template <class V, class Affine, class Test>
[[gnu::always_inline]] inline void move_axis(const Block<Scalar<V>>& particles, const Affine& affine, const Test& may_touch,
                                             Trajectory<V>& m, typename Test::Sums& sums, std::size_t i,
                                             std::size_t axis) noexcept {
  m.x1[axis] = m.x0[axis] = load_lanes<V>(particles.x[axis] + i);
  m.v1[axis] = m.v0[axis] = load_lanes<V>(particles.v[axis] + i);
  affine.move(m, particles.first + i, axis);
  may_touch.add(axis, m, sums);
}

// Steps batches from i on, up to the first that may touch a surface, which stays as it was. The loop calls nothing, so that the
// coefficients stay in registers.
template <class V, class OneAxis, class Test>
std::size_t step_untouched_by(const Block<Scalar<V>> particles, const Terms<Scalar<V>>& terms,
                              const Offsets<Scalar<V>>& offsets, std::size_t i) noexcept {
  const Affine<V, OneAxis> affine(terms, offsets);
  const Test may_touch(terms);
  for (; i < particles.count; i += V::size) {
    Trajectory<V> m;
    typename Test::Sums sums;
    move_axis(particles, affine, may_touch, m, sums, i, 0);
    move_axis(particles, affine, may_touch, m, sums, i, 1);
    move_axis(particles, affine, may_touch, m, sums, i, 2);
    if (any_lane<V>(may_touch(m, sums))) break;
    store_trajectory<V>(particles, i, m);
  }
  return i;
}

template <class V, class OneAxis, Arithmetic arithmetic>
std::size_t step_untouched(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                           std::size_t i) noexcept {
  const bool is_plane = terms.surface_count == 1 && terms.surfaces[0].shape == Shape::plane;
  if (!is_plane) return step_untouched_by<V, OneAxis, TouchTest<V, arithmetic>>(particles, terms, offsets, i);
  return step_untouched_by<V, OneAxis, PlaneTouchTest<V, arithmetic>>(particles, terms, offsets, i);
}

}  // namespace
}  // namespace dvdx
