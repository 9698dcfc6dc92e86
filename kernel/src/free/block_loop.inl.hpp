// The one loop over a block: load, move, store. Passes only see registers.
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "contact/pass/contact.inl.hpp"
#include "contact/pass/near.inl.hpp"
#include "flow/affine.inl.hpp"
#include "flow/radial.inl.hpp"
#include "flow/rate.inl.hpp"
#include "flow/terms.hpp"
#include "simd/trajectory.inl.hpp"

namespace dvdx {
namespace {

// Where nothing couples the axes, one after the other goes through all steps: two streams at a time, which do not collide in
// the cache however the caller's six arrays lie (six streams a multiple of 4096 bytes apart took 0.78 instead of 0.27 ns).
template <class V, class OneAxis>
void run_axes(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  const std::size_t count = block.count;
  const std::size_t first = block.first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Scalar<V>* const x = block.x[axis];
    Scalar<V>* const v = block.v[axis];
    std::size_t grouped = 0;
    if (steps.offsets_per_step == 0 && is_worth_groups<V>(steps.count)) {
      const OneAxis affine(terms, steps.offsets[0], axis);
      const std::size_t repeats = steps.count;
      for (; grouped + group_registers * V::size <= count; grouped += group_registers * V::size) {
        run_group<V>(affine, Columns<V>(), x + grouped, v + grouped, first + grouped, repeats);
      }
    }
    for (std::size_t n = 0; n < steps.count; ++n) {
      const OneAxis affine(terms, steps.offsets[n * steps.offsets_per_step], axis);
      for (std::size_t i = grouped; i < count; i += V::size) {
        const AxisState<V> end = affine(load_lanes<V>(x + i), load_lanes<V>(v + i), first + i);
        store_lanes(x + i, end.x);
        store_lanes(v + i, end.v);
      }
    }
  }
}

// One step, from where the sweeps have moved the particles.
template <class V, class OneAxis, Arithmetic arithmetic>
void run_axes_shifted(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  const V to_x(block.to_x);
  const V to_v(block.to_v);
  const V zero(Scalar<V>(0));
  const bool moves_x = block.to_x != 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const OneAxis affine(terms, steps.offsets[0], axis);
    Scalar<V>* const x_column = block.x[axis];
    Scalar<V>* const v_column = block.v[axis];
    Scalar<V>* const shift_column = block.shift[axis];
    for (std::size_t i = 0; i < block.count; i += V::size) {
      const V shift = load_lanes<V>(shift_column + i);
      V x = load_lanes<V>(x_column + i);
      if (moves_x) x = multiply_add<arithmetic>(to_x, shift, x);
      const V v = multiply_add<arithmetic>(to_v, shift, load_lanes<V>(v_column + i));
      const AxisState<V> end = affine(x, v, block.first + i);
      store_lanes(x_column + i, end.x);
      store_lanes(v_column + i, end.v);
      store_lanes(shift_column + i, zero);
    }
  }
}

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

// The register's particles at i, moved by all but contacts.
template <class V, class OneAxis, Extras extra, Arithmetic arithmetic>
[[gnu::always_inline]] inline Trajectory<V> move_batch(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                                       const Offsets<Scalar<V>>* offsets, std::size_t i) noexcept {
  Trajectory<V> m = load_trajectory<V>(particles, i);
  const Affine<V, OneAxis> affine(terms, offsets[0]);
  affine(m, particles.first + i);
  if constexpr (extra == Extras::radial || extra == Extras::radial_contact) {
    if (terms.kicks != 0) {
      radial_kick<V, arithmetic>(terms, m, particles.first + i);
      const Affine<V, OneAxis> second_half(terms, offsets[1]);
      second_half(m, particles.first + i);
    }
    radial_contribution<V, arithmetic>(terms, m, particles.first + i);
  }
  if constexpr (has_contacts(extra)) {
    if (particles.from[0] != nullptr) {
      for (std::size_t axis = 0; axis < 3; ++axis) m.x0[axis] = load_lanes<V>(particles.from[axis] + i);
    }
  }
  return m;
}

template <class V, class OneAxis, Extras extra, Arithmetic arithmetic>
[[gnu::noinline]] void move_batch_to(Trajectory<V>& m, const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                     const Offsets<Scalar<V>>* offsets, std::size_t i) noexcept {
  m = move_batch<V, OneAxis, extra, arithmetic>(particles, terms, offsets, i);
}

// The register's particles at i, moved by the whole step. Returns whether any of them touched a surface or lay still.
template <class V, class OneAxis, Extras extra, Arithmetic arithmetic>
[[gnu::noinline]] bool step_batch(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                  const Offsets<Scalar<V>>* offsets, std::size_t i, Waiting<V, arithmetic>& waiting,
                                  Still<V>& still) noexcept {
  Trajectory<V> m;
  if constexpr (extra == Extras::contact) {
    // The original never has its address taken, and is copied register by register, so that it stays in registers.
    const Trajectory<V> moved = move_batch<V, OneAxis, extra, arithmetic>(particles, terms, offsets, i);
    m = {copied(moved.x0), copied(moved.v0), copied(moved.x1), copied(moved.v1)};
  } else {
    move_batch_to<V, OneAxis, extra, arithmetic>(m, particles, terms, offsets, i);
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

// Batches from i on, up to the first that may touch a surface, which is left as it was. Nothing is called in this loop, so that
// the coefficients stay in registers.
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

// ---- many surfaces: flow/near.hpp --------------------------------------------------------------------------------

// Where one axis' values lie, and where a step takes them.
template <class V>
class Rectangle {
  using T = Scalar<V>;

 public:
  Rectangle(const T* x, const T* v, std::size_t count) noexcept {
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

  // low, high: take what the step's paths lie between. way: takes how far they go.
  template <class OneAxis>
  void step(const OneAxis& affine, T corner, T& low, T& high, T& way) noexcept {
    const Rectangle before = *this;
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

// The paths start where the flow before has left the particles.
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

// Where the block's trajectories lie in all of its steps, if it touches nothing.
template <class V, class OneAxis>
[[gnu::noinline]] Region<Scalar<V>> region_of_all(const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
                                                  const Steps<Scalar<V>>& steps) noexcept {
  using T = Scalar<V>;
  Region<T> box;
  T way = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Rectangle<V> at(particles.x[axis], particles.v[axis], particles.count);
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

// A flow's own part of loops that are made once for all flows.
template <class V, Arithmetic arithmetic>
struct Moves {
  using T = Scalar<V>;

  // The register's particles at i, moved by the whole step: step_batch.
  bool (*step)(const Block<T>&, const Terms<T>&, const Offsets<T>*, std::size_t i, Waiting<V, arithmetic>&, Still<V>&);
  // By all but contacts.
  void (*batch)(Trajectory<V>& m, const Block<T>& particles, const Terms<T>& terms, const Offsets<T>* offsets, std::size_t i);
  StepBlock<T> alone;  // as without contacts
  // Null beside radial springs; `region_of_all` where particles differ, too.
  std::size_t (*untouched)(const Block<T>&, const Terms<T>&, const Offsets<T>&, std::size_t);
  std::size_t (*beside)(const Block<T>&, const Terms<T>&, const Offsets<T>&, const Side<T>&);
  Region<T> (*region_of_all)(const Block<T>&, const Terms<T>&, const Steps<T>&);
};

// Where the block's trajectories lie in this step.
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
                  const Offsets<Scalar<V>>* offsets, Still<V>& still) noexcept {
  Waiting<V, arithmetic> waiting(still);
  for (std::size_t i = 0; i < particles.count; i += V::size) {
    if (still.are_all(i)) continue;
    moves.step(particles, terms, offsets, i, waiting, still);
    waiting.resolve_full(particles, terms, offsets[0]);
  }
  waiting.resolve_all(particles, terms, offsets[0]);
}

// With the surfaces of the list alone.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] void step_near(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& particles,
                                 const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>* offsets, const NearList& near,
                                 const Region<Scalar<V>>& region, Still<V>& still) noexcept {
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

// Registers from the first on, up to one of which some particle may leave the side, which is left as it was.
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

// Particles from i of the block on.
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

enum class Particles { alike, each };

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
  Still<V> still(particles, terms, steps);
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

// Step after step. Whether any particle touched a surface or lay still.
template <class V, Arithmetic arithmetic>
bool run_steps(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
               const Steps<Scalar<V>>& steps, Still<V>& still) noexcept {
  Waiting<V, arithmetic> waiting(still);
  const bool looks_ahead = moves.untouched != nullptr && !terms.moves && particles.from[0] == nullptr;
  bool has_touched = false;
  for (std::size_t n = 0; n < steps.count; ++n) {
    const auto* offsets = steps.offsets + n * steps.offsets_per_step;
    bool touched = false;  // the batch before: where many do, a batch is not moved twice
    for (std::size_t i = 0; i < particles.count; i += V::size) {
      if (!touched && looks_ahead) i = moves.untouched(particles, terms, offsets[0], i);
      if (i < particles.count) touched = still.are_all(i) || moves.step(particles, terms, offsets, i, waiting, still);
      has_touched = has_touched || touched;
      waiting.resolve_full(particles, terms, offsets[0]);
    }
    waiting.resolve_all(particles, terms, offsets[0]);
  }
  return has_touched;
}

// Among planes: some steps at a time, as without contacts where none of them is near.
template <class V, Arithmetic arithmetic>
void run_among_planes(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms,
                      const Steps<Scalar<V>>& steps) noexcept {
  Still<V> still(block, terms, steps);
  bool has_touched = false;
  for (std::size_t done = 0; done < steps.count;) {
    const std::size_t left = steps.count - done;
    const Steps<Scalar<V>> some{.offsets = steps.offsets + done * steps.offsets_per_step,
                                .offsets_per_step = steps.offsets_per_step,
                                .count = left < 2 * looked_at_steps ? left : looked_at_steps};
    if (!has_touched && !is_any_near(terms, moves.region_of_all(block, terms, some))) {
      moves.alone(block, terms, some);
    } else {
      has_touched = run_steps<V, arithmetic>(moves, block, terms, some, still);
    }
    done += some.count;
  }
}

template <class V, Arithmetic arithmetic>
void run_block(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms,
               const Steps<Scalar<V>>& steps) noexcept {
  if (terms.searches) return run_searching<V, arithmetic>(moves, block, terms, steps);
  if (moves.region_of_all != nullptr && terms.are_planes && !terms.moves && steps.count >= looked_at_steps) {
    return run_among_planes<V, arithmetic>(moves, block, terms, steps);
  }
  Still<V> still(block, terms, steps);
  run_steps<V, arithmetic>(moves, block, terms, steps, still);
}

template <class V, class OneAxis, Arithmetic arithmetic>
void run_radial(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  for (std::size_t n = 0; n < steps.count; ++n) {
    const Offsets<Scalar<V>>* const offsets = steps.offsets + n * steps.offsets_per_step;
    for (std::size_t i = 0; i < block.count; i += V::size) {
      store_trajectory<V>(block, i, move_batch<V, OneAxis, Extras::radial, arithmetic>(block, terms, offsets, i));
    }
  }
}

template <class V, class OneAxis, Extras extra, Particles particles_are, Arithmetic arithmetic>
constexpr Moves<V, arithmetic> moves_of() noexcept {
  Moves<V, arithmetic> moves{};
  moves.step = step_batch<V, OneAxis, extra, arithmetic>;
  moves.batch = move_batch_to<V, OneAxis, extra, arithmetic>;
  if constexpr (extra == Extras::radial_contact) moves.alone = run_radial<V, OneAxis, arithmetic>;
  if constexpr (extra == Extras::contact) {
    moves.alone = run_axes<V, OneAxis>;
    moves.untouched = step_untouched<V, OneAxis, arithmetic>;
    moves.beside = step_beside<V, OneAxis, arithmetic>;
    if constexpr (particles_are == Particles::alike) moves.region_of_all = region_of_all<V, OneAxis>;
  }
  return moves;
}

template <class V, Flow flow, Extras extra, Turn turn, Arithmetic arithmetic>
void step_turned(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  using OneAxis =
      std::conditional_t<is_asked(flow, extra), AxisFlowOfKind<V, flow, arithmetic>, AxisFlow<V, flow, turn, arithmetic>>;
  if constexpr (extra == Extras::none) {
    if (block.shift[0] != nullptr) return run_axes_shifted<V, OneAxis, arithmetic>(block, terms, steps);
    run_axes<V, OneAxis>(block, terms, steps);
  } else if constexpr (extra == Extras::radial) {
    run_radial<V, OneAxis, arithmetic>(block, terms, steps);
  } else {
    constexpr auto particles_are = is_rate(flow) || has_anchor_each(flow) ? Particles::each : Particles::alike;
    static constexpr Moves<V, arithmetic> moves = moves_of<V, OneAxis, extra, particles_are, arithmetic>();
    run_block<V, arithmetic>(moves, block, terms, steps);
  }
}

template <class V, Flow flow, Extras extra, Arithmetic arithmetic>
void step_block(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  constexpr bool always_turns = flow == Flow::rate_shear;
  if constexpr (is_shear(flow) && !is_asked(flow, extra)) {
    if (always_turns || terms.turn == Turn::turned) {
      return step_turned<V, flow, extra, Turn::turned, arithmetic>(block, terms, steps);
    }
  }
  if constexpr (!always_turns) step_turned<V, flow, extra, Turn::none, arithmetic>(block, terms, steps);
}

template <class T, class Arch, Flow flow, Arithmetic arithmetic>
constexpr std::array<StepBlock<T>, extras> step_blocks() noexcept {
  using V = Lanes<T, Arch>;
  return {step_block<V, flow, Extras::none, arithmetic>, step_block<V, flow, Extras::contact, arithmetic>,
          step_block<V, kind_of(flow), Extras::radial, arithmetic>,
          step_block<V, kind_of(flow), Extras::radial_contact, arithmetic>};
}

template <class T, class Arch, Arithmetic arithmetic, std::size_t... flow>
constexpr std::array<std::array<StepBlock<T>, extras>, flows> all_flows(std::index_sequence<flow...>) noexcept {
  return {step_blocks<T, Arch, static_cast<Flow>(flow), arithmetic>()...};
}

}  // namespace
}  // namespace dvdx
