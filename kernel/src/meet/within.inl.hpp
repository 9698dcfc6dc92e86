// The listed pairs that may meet in a sub-step, a register of them at once: within_reference.hpp in lanes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "meet/records.inl.hpp"
#include "meet/within.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

// As comes_within() of meet.inl.hpp.
template <class V>
[[gnu::always_inline]] inline Mask<V> come_within(const Three<V>& q0, const Three<V>& q1, V distance) noexcept {
  const V zero(Scalar<V>(0)), one(Scalar<V>(1));
  const Three<V> D = q1 - q0;
  const V a = inner(D, D);
  const V b = negative(inner(q0, D));
  const V s = select<V>(b > zero, select<V>(b < a, quotient(b, a), one), zero);
  const Three<V> nearest = q0 + s * D;
  return inner(nearest, nearest) < distance * distance;
}

// As wanted_of() of meet.hpp.
template <class V>
[[gnu::always_inline]] inline V wanted_lanes(Wanted wanted, V r_i, V r_j) noexcept {
  if (wanted == Wanted::sum) return r_i + r_j;
  return V(Scalar<V>(2)) * select<V>(r_i < r_j, r_j, r_i);
}

// Lane k as bit k: the pairs of a register that are near, that go fast, and that are close.
struct NearLanes {
  std::uint64_t are_near, are_fast, are_close;
};
template <class V>
[[gnu::always_inline]] inline NearLanes look_at_pairs(const WithinTerms<Scalar<V>>& terms, const std::uint32_t* i,
                                                      const std::uint32_t* j) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), shorter(T(0.999)), most(terms.most);
  const RecordLanes<V> at_i(i), at_j(j);
  const MetRecord<V> end_i = at_i.of(terms.particles.end), end_j = at_j.of(terms.particles.end);
  const V strays = end_i.mark + end_j.mark;
  const V more = select<V>(strays < most, strays, most);
  const Three<V> q1 = end_i.three - end_j.three;
  const V off = inner(q1, q1);
  const V nearer = off * shorter;
  const V widest = V(terms.widest) + V(terms.margin) + more + strays;
  if (all_lanes<V>(nearer > widest * widest)) return {};
  const MetRecord<V> start_i = at_i.of(terms.particles.start), start_j = at_j.of(terms.particles.start);
  const V d = wanted_lanes(terms.wanted, start_i.mark, start_j.mark);
  const V reach = d + V(terms.margin) + more;
  const Mask<V> is_beyond = nearer > (reach + strays) * (reach + strays);
  const Mask<V> is_at_end = (strays < reach) & (off < shorter * (reach * reach));
  const Mask<V> comes = is_at_end | come_within(start_i.three - start_j.three, q1, reach);
  const MetRecord<V> velocity_i = at_i.of(terms.particles.velocity), velocity_j = at_j.of(terms.particles.velocity);
  const Mask<V> is_moved = (velocity_i.mark > zero) | (velocity_j.mark > zero);
  const Three<V> u = velocity_i.three - velocity_j.three;
  const V slowest(terms.slowest), close = d + V(terms.far);
  const Mask<V> is_fast = inner(u, u) > slowest * slowest;
  return {bits_of<V>(is_moved & comes & ~is_beyond), bits_of<V>(is_fast), bits_of<V>(is_fast | (off < close * close))};
}

template <class V>
std::size_t find_within(const WithinTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  std::size_t end = from;
  std::array<std::uint32_t, most_chosen<V>> i, j, near_i, near_j;
  for (std::size_t place = from; place < to; place += V::size) {
    const std::size_t count = std::min<std::size_t>(V::size, to - place);
    i.fill(terms.owners[place]);
    j.fill(terms.partners[place]);
    std::copy_n(terms.owners + place, count, i.begin());
    std::copy_n(terms.partners + place, count, j.begin());
    auto [are_near, are_fast, are_close] = look_at_pairs<V>(terms, i.data(), j.data());
    are_near &= (std::uint64_t{1} << count) - 1;
    if (are_near == 0) continue;
    for (std::size_t k = 0; k < V::size; ++k) {
      i[k] |= (are_fast >> k & 1U) != 0 ? pair_goes_fast : 0U;
      j[k] |= (are_close >> k & 1U) != 0 ? 0U : pair_is_far;
    }
    const bool have_room = to - end >= most_chosen<V>;
    const std::size_t near = store_chosen<V>(have_room ? terms.i + end : near_i.data(), i.data(), are_near);
    store_chosen<V>(have_room ? terms.j + end : near_j.data(), j.data(), are_near);
    if (!have_room) {
      std::copy_n(near_i.begin(), near, terms.i + end);
      std::copy_n(near_j.begin(), near, terms.j + end);
    }
    end += near;
  }
  return end - from;
}

}  // namespace
}  // namespace dvdx
