// Contacts of pairs, a register of them at once: rounds_reference.hpp in lanes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "meet/impacts.inl.hpp"
#include "meet/records.inl.hpp"
#include "meet/rounds.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

// Pushes the contacts of a register that act. Returns their pulses, 0 in lanes that do not act.
template <class V>
[[gnu::always_inline]] inline Three<V> push_contacts(Separations<Scalar<V>>& contacts, std::size_t lane, Mask<V> acts,
                                                     const Three<V>& moved, V w, V gap, V mu, V beta) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
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
  const V square = inner(sticks, sticks);
  const Three<V> along = select(square > most * most, quotient(most, square_root(square)) * sticks, sticks);
  const Three<V> along_y = along + beta * (along - was_along);
  store_lanes(contacts.normal.data() + lane, select<V>(acts, normal, was_normal));
  store_lanes(contacts.normal_y.data() + lane, select<V>(acts, normal_y, was_normal_y));
  store_axes(contacts.along, lane, select(acts, along, was_along));
  store_axes(contacts.along_y, lane, select(acts, along_y, was_along_y));
  return select(acts, normal_y * n + along_y, three<V>(zero));
}

// Stores a register of pulses from p on, as both sides take them.
template <class V>
[[gnu::always_inline]] inline void store_pulses(Pulse<Scalar<V>>* pulses, Pulse<Scalar<V>>* against, std::size_t p,
                                                const Three<V>& vector, V number) noexcept {
  scatter_records(pulses[p].vector.data(), records_in_a_row<V>.data(),
                  records_of(std::array<V, 4>{vector[0], vector[1], vector[2], number}));
  if (against == nullptr) return;
  const Three<V> opposite = V(Scalar<V>(-1)) * vector;
  scatter_records(against[p].vector.data(), records_in_a_row<V>.data(),
                  records_of(std::array<V, 4>{opposite[0], opposite[1], opposite[2], number}));
}

// As begin_contact() of meet.inl.hpp.
template <class V>
Scalar<V> begin_pairs(const BeginTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), one(T(1)), h(terms.h), lowest(std::numeric_limits<T>::lowest());
  const MetParticles<T>& of = terms.particles;
  V least(std::numeric_limits<T>::max());
  for (std::size_t p = from; p < to; p += V::size) {
    const std::size_t lane = p % meeting_lanes;
    const MetPairs& pairs = terms.pairs[p / meeting_lanes];
    Separations<T>& contacts = terms.contacts[p / meeting_lanes];
    const RecordLanes<V> at_i(pairs.i.data() + lane), at_j(pairs.j.data() + lane);
    Three<V> q1 = at_i.of(of.end).three - at_j.of(of.end).three;
    if (terms.has_impacts) {
      const Three<V> moved_i = at_i.of(of.shift).three + h * at_i.of(of.hits).three;
      q1 = q1 + (moved_i - (at_j.of(of.shift).three + h * at_j.of(of.hits).three));
    }
    const Three<V> q0 = at_i.of(of.start).three - at_j.of(of.start).three;
    const V d = load_lanes<V>(terms.wanted + p);
    const Three<V> D = q1 - q0;
    const V a = inner(D, D);
    const V b = inner(q0, D);
    const V from_start = inner(q0, q0);
    const V c = from_start - d * d;
    const V root = b * b - a * c;
    const V touch = quotient(c, square_root(root) - b);
    const V back = negative(b);
    const V nearest = select<V>(back > zero, select<V>(back < a, quotient(back, a), one), zero);
    const V f = select<V>((b < zero) & (root > zero) & (touch < one), touch, nearest);
    const Three<V> n = direction(select(from_start > d * d, q0 + f * D, q0));
    const V gap = inner(n, q1) - d;
    const auto kept = columns_of(gather_records<V>(terms.pulses[p].vector.data(), records_in_a_row<V>.data()));
    const V normal = kept[3];
    const Three<V> along = across(Three<V>{{kept[0], kept[1], kept[2]}}, n);
    store_axes(contacts.n, lane, n);
    store_axes(contacts.slip, lane, across(D, n));
    store_axes(contacts.along, lane, along);
    store_axes(contacts.along_y, lane, along);
    store_lanes(contacts.gap.data() + lane, gap);
    for (auto* const lanes : {&contacts.normal, &contacts.normal_y, &contacts.begun}) store_lanes(lanes->data() + lane, normal);
    const Mask<V> acts = (gap < zero) | (normal > zero);
    store_pulses(terms.pulses, terms.against, p, normal * n + along, select<V>(acts, one, zero));
    V bound = select<V>(acts, lowest, gap);
    if (to - p < V::size) bound = select<V>(first_lanes<V>(to - p), bound, least);
    least = select<V>(bound < least, bound, least);
  }
  return *std::min_element(lanes_at(least), lanes_at(least) + V::size);
}

template <class V>
void push_pairs(const RoundTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), one(T(1));
  const V mu(terms.mu), beta(terms.beta);
  const Records<V> added_last = records_of(std::array<V, 4>{one, one, one, V(T(-1))});
  for (std::size_t p = from; p < to; p += V::size) {
    const std::size_t lane = p % meeting_lanes;
    const MetPairs& pairs = terms.pairs[p / meeting_lanes];
    Separations<T>& contacts = terms.contacts[p / meeting_lanes];
    Records<V> apart = RecordLanes<V>(pairs.i.data() + lane).records(terms.pushed);
    const Records<V> other = RecordLanes<V>(pairs.j.data() + lane).records(terms.pushed);
    for (std::size_t k = 0; k < 4; ++k) apart.at[k] = apart.at[k] - added_last.at[k] * other.at[k];
    const auto [x, y, z, w] = columns_of(apart);
    const Three<V> moved{{x, y, z}};
    const V gap = load_lanes<V>(contacts.gap.data() + lane) + inner(load_axes<V>(contacts.n, lane), moved);
    const V number = columns_of(gather_records<V>(terms.pulses[p].vector.data(), records_in_a_row<V>.data()))[3];
    const Mask<V> acts = number > zero;
    Three<V> vector = three<V>(zero);
    if (any_lane<V>(acts)) {
      const V mu_of = terms.mus != nullptr ? load_lanes<V>(terms.mus + p) : mu;
      vector = push_contacts<V>(contacts, lane, acts, moved, w, gap, mu_of, beta);
    }
    store_pulses(terms.pulses, terms.against, p, vector, select<V>(acts | (gap < zero), one, zero));
  }
}

// Sums whole records, without turning them into columns first.
template <class V>
Scalar<V> sum_pulses(const SumTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const T* const pulses = terms.pulses->vector.data();
  V longest(T(0));
  for (std::size_t lane = from * meeting_lanes; lane < to * meeting_lanes; lane += V::size) {
    const SumSlice& slice = terms.slices[lane / meeting_lanes];
    const std::uint32_t* places = terms.places + slice.first + lane % meeting_lanes;
    Records<V> sum = records_of(V(T(0)));
    for (std::uint32_t k = 0; k < slice.count; ++k, places += meeting_lanes) {
      const Records<V> more = gather_records<V>(pulses, places);
      for (std::size_t r = 0; r < 4; ++r) sum.at[r] = sum.at[r] + more.at[r];
    }
    const Records<V> w = records_of(load_lanes<V>(terms.w + lane));
    for (std::size_t r = 0; r < 4; ++r) sum.at[r] = w.at[r] * sum.at[r];
    scatter_records(terms.pushed->dx.data(), terms.particles + lane, sum);
    const auto [x, y, z, number] = columns_of(sum);
    const V square = inner(Three<V>{{x, y, z}}, Three<V>{{x, y, z}});
    longest = select<V>(square > longest, square, longest);
  }
  return *std::max_element(lanes_at(longest), lanes_at(longest) + V::size);
}

}  // namespace
}  // namespace dvdx
