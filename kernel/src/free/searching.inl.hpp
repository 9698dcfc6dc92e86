// A block among many surfaces. It searches for those near it (flow/near.hpp), and steps without contacts if there are none.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "contact/pass/near.inl.hpp"
#include "free/batch.inl.hpp"

namespace dvdx {
namespace {

// Bounds of one axis' positions and velocities, and of where a step takes them.
template <class V>
class PhaseBox {
  using T = Scalar<V>;

 public:
  PhaseBox(const T* x, const T* v, std::size_t count) noexcept {
    Bounds<V> at, speed, more_at, more_speed;  // two of each hide each other's latency
    std::size_t i = 0;
    for (; i + 2 * V::size <= count; i += 2 * V::size) {
      at.take(load_lanes<V>(x + i));
      speed.take(load_lanes<V>(v + i));
      more_at.take(load_lanes<V>(x + i + V::size));
      more_speed.take(load_lanes<V>(v + i + V::size));
    }
    at.take(more_at);
    speed.take(more_speed);
    for (; i < count; i += V::size) {
      at.take(load_lanes<V>(x + i));
      speed.take(load_lanes<V>(v + i));
    }
    x_[0] = at.lowest();
    x_[1] = at.highest();
    v_[0] = speed.lowest();
    v_[1] = speed.highest();
  }

  // Takes a step. low and high are widened to the step's paths. way is raised to how far these go.
  template <class OneAxis>
  void step(const OneAxis& affine, T corner, T& low, T& high, T& way) noexcept {
    const PhaseBox before = *this;
    bool is_first = true;
    for (const T x : before.x_) {
      for (const T v : before.v_) {
        const AxisState<V> end = affine(V(x), V(v), 0);
        alignas(64) T x1[V::size];
        alignas(64) T v1[V::size];
        store_lanes(x1, end.x);
        store_lanes(v1, end.v);
        x_[0] = is_first || x1[0] < x_[0] ? x1[0] : x_[0];
        x_[1] = is_first || x1[0] > x_[1] ? x1[0] : x_[1];
        v_[0] = is_first || v1[0] < v_[0] ? v1[0] : v_[0];
        v_[1] = is_first || v1[0] > v_[1] ? v1[0] : v_[1];
        is_first = false;
        for (const T reached : {x, x1[0], x + corner * v}) {
          low = reached < low ? reached : low;
          high = reached > high ? reached : high;
        }
        const T went = x1[0] < x ? x - x1[0] : x1[0] - x;
        way = went > way ? went : way;
      }
    }
  }

 private:
  T x_[2], v_[2];
};

// Widens the bounds to paths that start where the flow before has left the particles.
template <class V>
void take_start(const Block<Scalar<V>>& particles, std::size_t axis, Scalar<V>& low, Scalar<V>& high, Scalar<V>& way) noexcept {
  Bounds<V> start;
  Bounds<V> shifts;
  for (std::size_t i = 0; i < particles.count; i += V::size) {
    const V from = load_lanes<V>(particles.from[axis] + i);
    start.take(from);
    shifts.take(magnitude(load_lanes<V>(particles.x[axis] + i) - from));
  }
  const Scalar<V> shift = shifts.highest();
  low = (start.lowest() < low ? start.lowest() : low) - shift;
  high = (start.highest() > high ? start.highest() : high) + shift;
  way = way + shift;
}

// The region of the block's trajectories in all of its steps, if it touches nothing.
template <class V, class OneAxis>
[[gnu::noinline]] Region<Scalar<V>> region_of_all(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                                  const Steps<Scalar<V>>& steps) noexcept {
  using T = Scalar<V>;
  Region<T> box;
  T way = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    PhaseBox<V> at(particles.x[axis], particles.v[axis], particles.count);
    T& low = box.low[axis] = std::numeric_limits<T>::infinity();
    T& high = box.high[axis] = -std::numeric_limits<T>::infinity();
    for (std::size_t n = 0; n < steps.count; ++n) {
      const OneAxis affine(terms, steps.offsets[n * steps.offsets_per_step], axis);
      at.step(affine, terms.h * terms.bend.corner, low, high, way);
    }
    if (particles.from[axis] != nullptr) take_start<V>(particles, axis, low, high, way);
  }
  return widened(box, way);
}

// Where the particles' paths start, as contacts see them.
template <class T>
std::array<const T*, 3> start_of(const Block<T>& particles) noexcept {
  if (particles.from[0] != nullptr) return particles.from;
  return {particles.x[0], particles.x[1], particles.x[2]};
}

// The side of the box about all surfaces on which a particle at x is furthest out.
template <class T>
struct Side {
  std::size_t axis = 0;
  T side = 1, limit = 0;  // beyond: side x > limit
  T out = 0;              // m; not positive: it is nowhere out
};

template <class T>
Side<T> side_of(const Region<T>& bound, const std::array<const T*, 3>& x) noexcept {
  Side<T> found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const T above = *x[axis] - bound.high[axis];
    const T below = bound.low[axis] - *x[axis];
    if (above > found.out) found = {axis, T(1), bound.high[axis], above};
    if (below > found.out) found = {axis, T(-1), -bound.low[axis], below};
  }
  return found;
}

// A flow's own functions for loops that are compiled once for all flows.
template <class V, Arithmetic arithmetic>
struct Moves {
  using T = Scalar<V>;

  // Moves the register of particles at i by the whole step: step_batch.
  bool (*step)(const Block<T>&, const Terms<T>&, const Offsets<T>*, std::size_t i, Waiting<V, arithmetic>&, Dormant<V>&);
  // Moves it by everything but contacts.
  void (*batch)(Trajectory<V>& m, const Block<T>& particles, const Terms<T>& terms, const Offsets<T>* offsets, std::size_t i);
  StepBlock<T> alone;  // without contacts
  // Null beside radial springs. region_of_all is null if particles differ, too.
  std::size_t (*untouched)(const Block<T>&, const Terms<T>&, const Offsets<T>&, std::size_t);
  std::size_t (*beside)(const Block<T>&, const Terms<T>&, const Offsets<T>&, const Side<T>&);
  Region<T> (*region_of_all)(const Block<T>&, const Terms<T>&, const Steps<T>&);
};

// The region of the block's trajectories in this step.
template <class V, Arithmetic arithmetic>
Region<Scalar<V>> region_of(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                            const Offsets<Scalar<V>>* offsets) noexcept {
  using T = Scalar<V>;
  const V corner(terms.h * terms.bend.corner);
  Bounds<V> bounds[3];
  V way(T(0));
  for (std::size_t i = 0; i < particles.count; i += V::size) {
    Trajectory<V> m;
    moves.batch(m, particles, terms, offsets, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds[axis].take(m.x0[axis]);
      bounds[axis].take(m.x1[axis]);
      bounds[axis].take(multiply_add<arithmetic>(corner, m.v0[axis], m.x0[axis]));
      way = high_bound(way, magnitude(m.x1[axis] - m.x0[axis]));
    }
  }
  Region<T> box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = bounds[axis].lowest();
    box.high[axis] = bounds[axis].highest();
  }
  return widened(box, Bounds<V>{V(T(0)), way}.highest());
}

template <class V, Arithmetic arithmetic>
void step_batches(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                  const Offsets<Scalar<V>>* offsets, Dormant<V>& still) noexcept {
  Waiting<V, arithmetic> waiting(still);
  for (std::size_t i = 0; i < particles.count; i += V::size) {
    if (still.are_all(i)) continue;
    moves.step(particles, terms, offsets, i, waiting, still);
    waiting.resolve_full(particles, terms, offsets[0]);
  }
  waiting.resolve_all(particles, terms, offsets[0]);
}

// Steps with the surfaces of the list alone.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] void step_near(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& particles,
                                 const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>* offsets, const NearList& near,
                                 const Region<Scalar<V>>& region, Dormant<V>& still) noexcept {
  using T = Scalar<V>;
  Surface<T> surfaces[most_near];
  Terms<T> own = terms;
  own.surfaces = surfaces;
  own.surface_count = near.count;
  own.whole = &terms;
  own.region = region;
  for (std::size_t j = 0; j < near.count; ++j) surfaces[j] = terms.surfaces[near.at[j]];
  step_batches<V, arithmetic>(moves, particles, own, offsets, still);
}

// Steps registers from the first on, up to one with a particle that may leave the side. That one stays as it was.
template <class V, class OneAxis, Arithmetic arithmetic>
[[gnu::noinline]] std::size_t step_beside(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                          const Offsets<Scalar<V>>& offsets, const Side<Scalar<V>>& side) noexcept {
  const std::size_t a = side.axis;
  const std::size_t b = (a + 1) % 3;
  const std::size_t c = (a + 2) % 3;
  const std::array x{particles.x[a], particles.x[b], particles.x[c]};
  const std::array v{particles.v[a], particles.v[b], particles.v[c]};
  const Scalar<V>* const start = start_of(particles)[a];
  const OneAxis first(terms, offsets, a);
  const OneAxis second(terms, offsets, b);
  const OneAxis third(terms, offsets, c);
  const V sign(side.side);
  const V limit(side.limit);
  const V corner(terms.h * terms.bend.corner);
  std::size_t i = 0;
  const auto move = [&](const OneAxis& affine, std::size_t k) {
    const AxisState<V> end = affine(load_lanes<V>(x[k] + i), load_lanes<V>(v[k] + i), particles.first + i);
    store_lanes(x[k] + i, end.x);
    store_lanes(v[k] + i, end.v);
  };
  for (; i < particles.count; i += V::size) {
    const V x0 = load_lanes<V>(start + i);
    const V v0 = load_lanes<V>(v[0] + i);
    const AxisState<V> end = first(load_lanes<V>(x[0] + i), v0, particles.first + i);
    const V middle = multiply_add<arithmetic>(corner, v0, x0);
    const V nearest = low_bound(low_bound(sign * x0, sign * end.x), sign * middle);
    if (any_lane<V>(nearest <= limit)) break;
    store_lanes(x[0] + i, end.x);
    store_lanes(v[0] + i, end.v);
    move(second, 1);
    move(third, 2);
  }
  return i;
}

// The block's particles from i on.
template <class T>
Block<T> rest_of(const Block<T>& particles, std::size_t i) noexcept {
  Block<T> rest = particles;
  rest.count -= i;
  rest.first += i;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rest.x[axis] += i;
    rest.v[axis] += i;
    if (rest.from[axis] != nullptr) rest.from[axis] += i;
  }
  return rest;
}

template <class V, Arithmetic arithmetic>
void run_searching(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms,
                   const Steps<Scalar<V>>& steps) noexcept {
  using T = Scalar<V>;
  Block<T> particles = block;
  if (moves.beside != nullptr && steps.count == 1 && terms.are_bounded) {
    const Side<T> side = side_of(terms.bound, start_of(particles));
    if (side.out > 0) particles = rest_of(particles, moves.beside(particles, terms, steps.offsets[0], side));
    if (particles.count == 0) return;
  }
  NearList near;
  if (moves.region_of_all != nullptr) {
    find_near(terms, moves.region_of_all(particles, terms, steps), near);
    if (near.count == 0) return moves.alone(particles, terms, steps);
  }
  Dormant<V> still(particles, terms, steps);
  for (std::size_t n = 0; n < steps.count; ++n) {
    const Offsets<T>* offsets = steps.offsets + n * steps.offsets_per_step;
    const Region<T> region = region_of<V, arithmetic>(moves, particles, terms, offsets);
    find_near(terms, region, near);
    if (near.count == 0) {
      moves.alone(particles, terms, {.offsets = offsets, .offsets_per_step = 0, .count = 1});
    } else if (near.count <= most_near) {
      step_near<V, arithmetic>(moves, particles, terms, offsets, near, region, still);
    } else if (particles.count <= least_block) {
      step_batches<V, arithmetic>(moves, particles, terms, offsets, still);
    } else {
      const std::size_t half = particles.count / 2 / 16 * 16;
      const Steps<T> left{.offsets = offsets, .offsets_per_step = steps.offsets_per_step, .count = steps.count - n};
      Block<T> part = particles;
      part.count = half;
      run_searching<V, arithmetic>(moves, part, terms, left);
      return run_searching<V, arithmetic>(moves, rest_of(particles, half), terms, left);
    }
  }
}

}  // namespace
}  // namespace dvdx
