// Chains that share no particle, wide: sixteen side by side, with sub-steps of their own where their tension needs them. The
// scalar twin: chain_reference.hpp; the derivation: constraint.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "constraint/chain.inl.hpp"

namespace dvdx {
namespace {

// The chains of a register.
template <class V>
struct SomeChains {
  std::size_t first = 0, links = 0;
  std::size_t number = 0;  // of the first one
};

template <class V, class Use>
void for_some_chains(const ChainTerms<Scalar<V>>& terms, std::size_t from, std::size_t to, const Use& use) noexcept {
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; lane += V::size) {
      use(SomeChains<V>{terms.first[bundle] + lane, terms.links[bundle], bundle * slice + lane});
    }
  }
}

template <class V, Arithmetic arithmetic>
void prepare_lone_chains(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t from,
                         std::size_t to) noexcept {
  prepare_chains<V, arithmetic>(terms, x, from, to);
  for_some_chains<V>(terms, from, to,
                     [&](const SomeChains<V>& chains) { keep<V>(terms, x, chains.first, chains.links, terms.start); });
}

// The frame in which energies do not depend on a common velocity: that of the first end if it is held, otherwise that of the
// centre of mass, which pulses do not move.
template <class V, Arithmetic arithmetic, class Get>
Three<V> frame_of(const ChainTerms<Scalar<V>>& terms, const SomeChains<V>& chains, const Get& get) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const Mask<V> is_free = load_lanes<V>(terms.w + chains.first) > zero;
  const Three<V> held = get(chains.first);
  if (!any_lane<V>(is_free)) return held;
  Three<V> sum = three<V>(zero);
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    sum = multiply_add<arithmetic>(load_lanes<V>(terms.m + e), get(e), sum);
  }
  const V whole = load_lanes<V>(terms.whole + chains.number);
  return select(is_free, quotient(V(T(1)), select<V>(is_free, whole, V(T(1)))) * sum, held);
}

// The rounding of chains before their pulses.
template <class V>
struct ChainGrain {
  V grain;  // of a position
  V noise;  // of the energy, times h^2
};

// Returns the rounding, and keeps positions and velocities.
template <class V, Arithmetic arithmetic>
ChainGrain<V> begin_lone(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                         const SomeChains<V>& chains) noexcept {
  using T = Scalar<V>;
  V reach = V(T(0));
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const Three<V> at = gather_axes<V>(x, terms.a + e);
    store_axes<V>(terms.kept, e, at);
    store_axes<V>(terms.kept_v, e, gather_axes<V>(v, terms.a + e));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const V along = magnitude(at[axis]);
      reach = select<V>(along > reach, along, reach);
    }
  }
  const V grain = V(std::numeric_limits<T>::epsilon()) * reach;
  const V off = multiply_add<arithmetic>(V(chain_tolerance<T>), load_lanes<V>(terms.longest + chains.number), grain);
  return {grain, (V(grains<T>) * load_lanes<V>(terms.whole + chains.number)) * (off * off)};
}

// The outcome of the pulses of one sub-step, or of several.
template <class V>
struct ChainCourse {
  Mask<V> is_lost;  // lengths have not converged
  V transverse;     // (h omega)^2
  V given;          // twice the energy that the pulses give
  V carried, moving;
};

template <class V>
V transverse_of(const ChainTerms<Scalar<V>>& terms, const SomeChains<V>& chains) noexcept {
  using T = Scalar<V>;
  V most = V(T(0));
  V below = V(T(0));
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const V above = k < chains.links ? magnitude(load_lanes<V>(terms.s + e)) : V(T(0));
    const V here = V(T(2)) * load_lanes<V>(terms.w + e) * (below + above);
    most = select<V>(here > most, here, most);
    below = above;
  }
  return most;
}

// Corrects the lengths. Returns the lanes in which they do not converge.
template <class V, Arithmetic arithmetic>
Mask<V> place_lone(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const SomeChains<V>& chains, Mask<V> where,
                   V grain) noexcept {
  const V zero(Scalar<V>(0));
  Mask<V> is_lost = zero > zero;
  for (int step = 0;; ++step) {
    const Verdict<V> verdict = eliminate_lengths<V, arithmetic>(terms, x, chains.first, chains.links, grain);
    is_lost = is_lost | (where & verdict.is_astray);
    where = where & verdict.is_off & !is_lost;
    if (!any_lane<V>(where)) return is_lost;
    if (step == terms.newton) return is_lost | (where & verdict.is_far);
    substitute<V, arithmetic, Solved::positions_summed>(terms, x, chains.first, chains.links, where);
  }
}

// Applies both pulses. On entry x and v are where the forces alone have led.
template <class V, Arithmetic arithmetic>
ChainCourse<V> pulse_chain(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                           const SomeChains<V>& chains, Mask<V> where, V per_step, V grain) noexcept {
  const V zero(Scalar<V>(0));
  begin_chain<V, arithmetic>(terms, Round::first, x, chains.first, chains.links);
  const Mask<V> is_lost = place_lone<V, arithmetic>(terms, x, chains, where, grain);
  if (!any_lane<V>(where & !is_lost)) return {is_lost, zero, zero, zero, zero};
  const V transverse = transverse_of<V>(terms, chains);
  const Pushed<V> first = push_chain<V, arithmetic>(terms, v, chains.first, chains.links, where, per_step);
  aim_chain<V, arithmetic>(terms, x, chains.first, chains.links, zero == zero);
  const auto speed = [&](std::size_t e) { return gather_axes<V>(v, terms.a + e); };
  const Three<V> frame = frame_of<V, arithmetic>(terms, chains, speed);
  const Pushed<V> second = solve_velocities<V, arithmetic>(terms, v, chains.first, chains.links, where, frame);
  return {is_lost, transverse, first.carried - second.carried, first.carried + second.carried, second.moving};
}

// slight: twice an energy that counts as none.
template <class V, Arithmetic arithmetic>
Mask<V> gives_too_much(const ChainCourse<V>& course, V slight) noexcept {
  return magnitude(course.given) > multiply_add<arithmetic>(V(most_given<Scalar<V>>), course.moving, slight);
}

// Takes `parts` sub-steps of the chains' own from start, with v0 and a.
template <class V, Arithmetic arithmetic>
ChainCourse<V> take_parts(const ChainTerms<Scalar<V>>& own, const SomeChains<V>& chains, Mask<V> where, V parts,
                          V grain) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V h = quotient(V(own.step), parts);
  const V per_h = V(own.per_step) * parts;
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    store_axes<V>(own.own_x, e, load_axes<V>(own.start, e));
    store_axes<V>(own.own_v, e, load_axes<V>(own.kept, e));
  }
  aim_chain<V, arithmetic>(own, own.own_x, chains.first, chains.links, zero == zero);
  ChainCourse<V> all{zero > zero, zero, zero, zero, zero};
  for (V part = zero;; part = part + V(T(1))) {
    const Mask<V> goes_on = where & !all.is_lost & (part < parts);
    if (!any_lane<V>(goes_on)) return all;
    for (std::size_t k = 0; k <= chains.links; ++k) {
      const std::size_t e = chains.first + k * slice;
      const Three<V> a = load_axes<V>(own.kept_v, e);
      const Three<V> v = load_axes<V>(own.own_v, e);
      const Three<V> x = load_axes<V>(own.own_x, e);
      const Three<V> path = multiply_add<arithmetic>(V(T(0.5)) * h, a, v);
      store_axes<V>(own.own_x, e, select(goes_on, multiply_add<arithmetic>(h, path, x), x));
      store_axes<V>(own.own_v, e, select(goes_on, multiply_add<arithmetic>(h, a, v), v));
    }
    const ChainCourse<V> course = pulse_chain<V, arithmetic>(own, own.own_x, own.own_v, chains, goes_on, per_h, grain);
    const Mask<V> is_placed = goes_on & !course.is_lost;
    all.transverse = select<V>(is_placed & (course.transverse > all.transverse), course.transverse, all.transverse);
    const Mask<V> is_stiff = is_placed & (course.transverse > V(most_transverse<T>)) & (parts < V(most_parts<T>));
    all.is_lost = all.is_lost | course.is_lost | is_stiff;
    const Mask<V> is_taken = goes_on & !all.is_lost;
    all.given = select<V>(is_taken, all.given + course.given, all.given);
    all.moving = select<V>(is_taken & (course.moving > all.moving), course.moving, all.moving);
  }
}

// Puts chains as they were at the start, moved along with their first ends since.
template <class V>
void stay(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v, const SomeChains<V>& chains,
          Mask<V> where) noexcept {
  const Three<V> way = gather_axes<V>(x, terms.a + chains.first) - load_axes<V>(terms.start, chains.first);
  const Three<V> speed = gather_axes<V>(v, terms.a + chains.first);
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const auto put = [&](const Axes<Scalar<V>>& columns, const Three<V>& to) {
      const Three<V> now = gather_axes<V>(columns, terms.a + e);
      scatter_movable<V>(columns, terms.a + e, select(where, to, now), terms.w + e);
    };
    put(x, load_axes<V>(terms.start, e) + way);
    put(v, speed);
  }
}

// Removes the kinetic energy beyond that of the start, at v0, and the work of the forces on the way, by a.
template <class V, Arithmetic arithmetic>
void take_excess(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                 const SomeChains<V>& chains, Mask<V> where, const Axes<Scalar<V>>& v0, const Axes<Scalar<V>>& a) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const auto speed = [&](std::size_t e) { return gather_axes<V>(v, terms.a + e); };
  const auto first = [&](std::size_t e) { return load_axes<V>(v0, e); };
  const auto force = [&](std::size_t e) { return load_axes<V>(a, e); };
  const auto way = [&](std::size_t e) { return gather_axes<V>(x, terms.a + e) - load_axes<V>(terms.start, e); };
  const Three<V> frame = frame_of<V, arithmetic>(terms, chains, speed);
  const Three<V> frame_first = frame_of<V, arithmetic>(terms, chains, first);
  const Three<V> frame_force = frame_of<V, arithmetic>(terms, chains, force);
  const Three<V> frame_way = frame_of<V, arithmetic>(terms, chains, way);
  V now = zero;
  V before = zero;
  V work = zero;
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const V m = load_lanes<V>(terms.m + e);
    const Three<V> u = speed(e) - frame;
    const Three<V> u0 = first(e) - frame_first;
    now = multiply_add<arithmetic>(m, dot<arithmetic>(u, u), now);
    before = multiply_add<arithmetic>(m, dot<arithmetic>(u0, u0), before);
    work = multiply_add<arithmetic>(m, dot<arithmetic>(force(e) - frame_force, way(e) - frame_way), work);
  }
  const V most = multiply_add<arithmetic>(V(T(2)), work, before);
  const Mask<V> is_over = where & (now > most);
  const Mask<V> keeps_some = is_over & (most > zero);
  const V part = quotient(select<V>(keeps_some, most, zero), select<V>(keeps_some, now, V(T(1))));
  const V factor = square_root(part);
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const Three<V> u = speed(e);
    scatter_movable<V>(v, terms.a + e, select(is_over, frame + factor * (u - frame), u), terms.w + e);
  }
}

// If no sub-step is short enough, the particles follow each other. A chain held at both ends whose lengths are not found in
// this way, such as one drawn straight, stays.
template <class V, Arithmetic arithmetic>
void give_in(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
             const SomeChains<V>& chains, Mask<V> where) noexcept {
  using T = Scalar<V>;
  const V h(terms.step);
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const Three<V> a = load_axes<V>(terms.kept_v, e);
    const Three<V> v0 = load_axes<V>(terms.kept, e);
    const Three<V> path = multiply_add<arithmetic>(V(T(0.5)) * h, a, v0);
    store_axes<V>(terms.own_x, e, a);
    store_axes<V>(terms.own_v, e, v0);
    store_axes<V>(terms.kept, e, multiply_add<arithmetic>(h, path, load_axes<V>(terms.start, e)));
    store_axes<V>(terms.kept_v, e, multiply_add<arithmetic>(h, a, v0));
  }
  follow_and_correct<V, arithmetic>(terms, x, chains.first, chains.links, where);
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const Three<V> now = gather_axes<V>(v, terms.a + e);
    scatter_movable<V>(v, terms.a + e, select(where, load_axes<V>(terms.kept_v, e), now), terms.w + e);
  }
  aim_chain<V, arithmetic>(terms, x, chains.first, chains.links, where);
  const Mask<V> is_held = !(load_lanes<V>(terms.w + chains.first) > V(T(0)));
  const Mask<V> stays = where & is_held & eliminate_lengths<V, arithmetic>(terms, x, chains.first, chains.links).is_far;
  if (any_lane<V>(stays)) stay<V>(terms, x, v, chains, stays);
  aim_chain<V, arithmetic>(terms, x, chains.first, chains.links, where);
  solve_velocities<V, arithmetic>(terms, v, chains.first, chains.links, where);
  take_excess<V, arithmetic>(terms, x, v, chains, where, terms.own_v, terms.own_x);
}

// Finds v0 and a of the parabola from start to x that ends with the velocity v. Returns twice an energy that is negligible
// beside that of the forces.
template <class V, Arithmetic arithmetic>
V unfold(const ChainTerms<Scalar<V>>& terms, const SomeChains<V>& chains) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V rate(terms.per_step);
  V forced = zero;
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const Three<V> way = load_axes<V>(terms.kept, e) - load_axes<V>(terms.start, e);
    const Three<V> v = load_axes<V>(terms.kept_v, e);
    const Three<V> v0 = subtract_product<arithmetic>(three<V>(zero) - v, V(T(-2)) * rate, way);
    const Three<V> a = rate * (v - v0);
    store_axes<V>(terms.kept, e, v0);
    store_axes<V>(terms.kept_v, e, a);
    forced = multiply_add<arithmetic>(load_lanes<V>(terms.m + e), dot<arithmetic>(a, a), forced);
  }
  return V(most_given_by_forces<T> * (terms.step * terms.step)) * forced;
}

template <class V>
void put_own(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
             const SomeChains<V>& chains, Mask<V> where) noexcept {
  for (std::size_t k = 0; k <= chains.links; ++k) {
    const std::size_t e = chains.first + k * slice;
    const auto put = [&](const Axes<Scalar<V>>& columns, const Axes<Scalar<V>>& own) {
      const Three<V> now = gather_axes<V>(columns, terms.a + e);
      scatter_movable<V>(columns, terms.a + e, select(where, load_axes<V>(own, e), now), terms.w + e);
    };
    put(x, terms.own_x);
    put(v, terms.own_v);
  }
}

// Takes sub-steps of the chains' own, at least twice as many each time until they suffice.
template <class V, Arithmetic arithmetic>
void march(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v, const SomeChains<V>& chains,
           const ChainGrain<V>& grain, V forced, Mask<V> where) noexcept {
  using T = Scalar<V>;
  const V most(most_parts<T>);
  ChainTerms<T> own = terms;
  own.a = terms.self;
  Mask<V> gives_in = forced > forced;
  V parts(T(2));
  for (Mask<V> is_open = where; any_lane<V>(is_open);) {
    const ChainCourse<V> course = take_parts<V, arithmetic>(own, chains, is_open, parts, grain.grain);
    const V per_h = parts * V(terms.per_step);
    const V slight = multiply_add<arithmetic>(grain.noise, per_h * per_h, forced);
    const Mask<V> gives = gives_too_much<V, arithmetic>(course, slight);
    const Mask<V> is_done = is_open & !course.is_lost & ((parts >= V(most_parts_for_energy<T>)) | !gives);
    put_own<V>(terms, x, v, chains, is_done);
    if (any_lane<V>(is_done & gives)) {
      take_excess<V, arithmetic>(terms, x, v, chains, is_done & gives, terms.kept, terms.kept_v);
    }
    const Mask<V> is_last = is_open & !is_done & !(parts < most);
    gives_in = gives_in | is_last;
    is_open = is_open & !is_done & !is_last;
    V factor(T(2));
    for (int k = 0; k < 8; ++k) {
      const Mask<V> needs_more = course.transverse > V(most_transverse<T>) * (factor * factor);
      factor = select<V>(needs_more, V(T(2)) * factor, factor);
    }
    const V more = parts * factor;
    parts = select<V>(more < most, more, most);
  }
  aim_chain<V, arithmetic>(terms, x, chains.first, chains.links, !gives_in);  // lanes that did not march have lost their n too
  if (any_lane<V>(gives_in)) give_in<V, arithmetic>(terms, x, v, chains, gives_in);
}

template <class V, Arithmetic arithmetic>
void solve_lone_chains(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v, std::size_t from,
                       std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  for_some_chains<V>(terms, from, to, [&](const SomeChains<V>& chains) {
    const ChainGrain<V> grain = begin_lone<V, arithmetic>(terms, x, v, chains);
    const ChainCourse<V> course = pulse_chain<V, arithmetic>(terms, x, v, chains, zero == zero, V(terms.per_step), grain.grain);
    const V noise = grain.noise;
    const V per_hh(terms.per_step * terms.per_step);
    const V slight = V(most_given_by_pulses<T>) * course.carried;
    Mask<V> is_wrong = course.is_lost | (course.transverse > V(most_transverse<T>));
    const Mask<V> is_loud = gives_too_much<V, arithmetic>(course, multiply_add<arithmetic>(noise, per_hh, slight));
    if (any_lane<V>(is_wrong | is_loud)) {
      const V forced = unfold<V, arithmetic>(terms, chains);
      const Mask<V> is_too_much = gives_too_much<V, arithmetic>(course, multiply_add<arithmetic>(noise, per_hh, forced));
      is_wrong = is_wrong | (is_loud & is_too_much);
      if (any_lane<V>(is_wrong)) march<V, arithmetic>(terms, x, v, chains, grain, forced, is_wrong);
    }
    keep<V>(terms, x, chains.first, chains.links, terms.start);
  });
}

}  // namespace
}  // namespace dvdx
