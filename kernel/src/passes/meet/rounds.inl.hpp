// A round of pairs, a register of them at once: rounds_reference.hpp in lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "isa/lanes.hpp"
#include "passes/meet/rounds.hpp"
#include "passes/three.inl.hpp"

namespace dvdx {
namespace {

template <class V>
using LaneIndex = std::array<std::uint32_t, V::size>;

template <class V>
[[gnu::always_inline]] inline Three<V> across(const Three<V>& a, const Three<V>& n) noexcept {
  return a - dot<Arithmetic::separate>(a, n) * n;
}
template <class V>
[[gnu::always_inline]] inline Three<V> load_axes(const std::array<std::array<Scalar<V>, meeting_lanes>, 3>& axes,
                                                 std::size_t lane) noexcept {
  return {{load_lanes<V>(axes[0].data() + lane), load_lanes<V>(axes[1].data() + lane), load_lanes<V>(axes[2].data() + lane)}};
}
template <class V>
[[gnu::always_inline]] inline void store_axes(std::array<std::array<Scalar<V>, meeting_lanes>, 3>& axes, std::size_t lane,
                                              const Three<V>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(axes[axis].data() + lane, value[axis]);
}
// Where the records of particles begin.
template <class V>
[[gnu::always_inline]] inline std::array<V, 4> pushes_of(const MeetPush<Scalar<V>>* pushed, const std::uint32_t* i) noexcept {
  LaneIndex<V> at;
  for (std::size_t k = 0; k < V::size; ++k) at[k] = 4 * i[k];
  return columns_of(gather_records<V>(pushed->dx.data(), at.data()));
}

// Those of a register whose contacts act: what they give, which is 0 where one does not act.
template <class V>
[[gnu::always_inline]] inline Three<V> push_contacts(Separations<Scalar<V>>& contacts, std::size_t lane, Mask<V> acts,
                                                     const Three<V>& moved, V w, V gap, Scalar<V> mu_of_all,
                                                     Scalar<V> beta_of_all) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), mu(mu_of_all), beta(beta_of_all);
  const Three<V> n = load_axes<V>(contacts.n, lane);
  const V was_normal = load_lanes<V>(contacts.normal.data() + lane);
  const V was_normal_y = load_lanes<V>(contacts.normal_y.data() + lane);
  const V wanted = was_normal_y - quotient(gap, w);
  const V normal = select<V>(wanted > zero, wanted, zero);
  const V normal_y = normal + beta * (normal - was_normal);
  const Three<V> was_along = load_axes<V>(contacts.along, lane);
  const Three<V> was_along_y = load_axes<V>(contacts.along_y, lane);
  const Three<V> slides = load_axes<V>(contacts.slip, lane) + across(moved, n);
  const Three<V> sticks = was_along_y - quotient(V(T(1)), w) * slides;
  const V most = mu * normal;
  const V square = dot<Arithmetic::separate>(sticks, sticks);
  const Three<V> along = select(square > most * most, quotient(most, square_root(square)) * sticks, sticks);
  const Three<V> along_y = along + beta * (along - was_along);
  store_lanes(contacts.normal.data() + lane, select<V>(acts, normal, was_normal));
  store_lanes(contacts.normal_y.data() + lane, select<V>(acts, normal_y, was_normal_y));
  store_axes(contacts.along, lane, select(acts, along, was_along));
  store_axes(contacts.along_y, lane, select(acts, along_y, was_along_y));
  return select(acts, normal_y * n + along_y, three<V>(zero));
}

template <class V>
void push_pairs(const RoundTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), one(T(1));
  LaneIndex<V> in_a_row;
  for (std::size_t k = 0; k < V::size; ++k) in_a_row[k] = static_cast<std::uint32_t>(4 * k);
  for (std::size_t p = from; p < to; p += V::size) {
    const std::size_t lane = p % meeting_lanes;
    const MetPairs& pairs = terms.pairs[p / meeting_lanes];
    Separations<T>& contacts = terms.contacts[p / meeting_lanes];
    const std::array<V, 4> a = pushes_of<V>(terms.pushed, pairs.i.data() + lane);
    const std::array<V, 4> b = pushes_of<V>(terms.pushed, pairs.j.data() + lane);
    const Three<V> moved{{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
    const V gap = load_lanes<V>(contacts.gap.data() + lane) + dot<Arithmetic::separate>(load_axes<V>(contacts.n, lane), moved);
    T* const pulses = terms.pulses[p].vector.data();
    const V number = columns_of(gather_records<V>(pulses, in_a_row.data()))[3];
    const Mask<V> acts = number > zero;
    Three<V> vector = three<V>(zero);
    if (any_lane<V>(acts)) vector = push_contacts<V>(contacts, lane, acts, moved, a[3] + b[3], gap, terms.mu, terms.beta);
    const V goes_on = select<V>(acts | (gap < zero), one, zero);
    scatter_records(pulses, in_a_row.data(), records_of(std::array<V, 4>{vector[0], vector[1], vector[2], goes_on}));
  }
}

}  // namespace
}  // namespace dvdx
