// Impacts of pairs, a register of them at once: impacts_reference.hpp in lanes.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "meet/impacts.hpp"
#include "meet/records.inl.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

// As direction() of meet.inl.hpp.
template <class V>
[[gnu::always_inline]] inline Three<V> direction(const Three<V>& q) noexcept {
  const V zero(Scalar<V>(0)), one(Scalar<V>(1));
  const V square = inner(q, q);
  const Three<V> along = quotient(one, square_root(square)) * q;
  return select(square > zero, along, Three<V>{{one, zero, zero}});
}

// As first_touch() of meet.inl.hpp, for pairs that are farther apart than d.
template <class V>
[[gnu::always_inline]] inline V first_touch(const Three<V>& q, const Three<V>& D, V d) noexcept {
  const V zero(Scalar<V>(0)), one(Scalar<V>(1)), never(Scalar<V>(2));
  const V a = inner(D, D);
  const V b = inner(q, D);
  const V c = inner(q, q) - d * d;
  const V square = b * b - a * c;
  const V f = quotient(c, square_root(square) - b);
  return select<V>((b < zero) & (square > zero) & (f < one), f, never);
}

template <class V>
struct ImpactLanes {
  Three<V> n;
  V f, speed;
  Mask<V> is_one;
};

// As find_impact() of meet.inl.hpp.
template <class V>
[[gnu::always_inline]] inline ImpactLanes<V> impacts_of(const ImpactTerms<Scalar<V>>& terms, const std::uint32_t* i,
                                                        const std::uint32_t* j, V d) noexcept {
  using T = Scalar<V>;
  const V one(T(1)), h(terms.h), slowest(terms.slowest), against(terms.h < 0 ? T(1) : T(-1));
  const RecordLanes<V> at_i(i), at_j(j);
  const MetParticles<T>& of = terms.particles;
  const MetRecord<V> hits_i = at_i.of(of.hits), hits_j = at_j.of(of.hits);
  const Three<V> v_i = at_i.of(of.velocity).three + hits_i.three, v_j = at_j.of(of.velocity).three + hits_j.three;
  const Three<V> u = v_i - v_j;
  const Mask<V> is_fast = inner(u, u) > slowest * slowest;
  const Three<V> shift_i = at_i.of(of.shift).three, shift_j = at_j.of(of.shift).three;
  const Three<V> to_i = at_i.of(of.end).three + (shift_i + h * hits_i.three);
  const Three<V> to_j = at_j.of(of.end).three + (shift_j + h * hits_j.three);
  const Three<V> q0 = (at_i.of(of.start).three - at_j.of(of.start).three) + (shift_i - shift_j);
  const Three<V> D = (to_i - to_j) - q0;
  const V last = select<V>(hits_i.mark < hits_j.mark, hits_j.mark, hits_i.mark);
  const Three<V> q = q0 + last * D;
  const Mask<V> is_apart = inner(q, q) > d * d;
  const V left = one - last;
  const Three<V> way = left * D;
  const V part = first_touch(q, way, d);
  ImpactLanes<V> impact;
  impact.f = select<V>(is_apart, last + left * part, last);
  impact.n = direction(select(is_apart, q + part * way, q));
  impact.speed = against * inner(impact.n, u);
  impact.is_one = is_fast & ~(is_apart & (part > one)) & (impact.speed > slowest);
  return impact;
}

template <class V>
std::size_t find_impacts(const ImpactTerms<Scalar<V>>& terms, const std::uint32_t* pairs, std::size_t count,
                         std::size_t at) noexcept {
  using T = Scalar<V>;
  std::array<std::uint32_t, V::size> i, j;
  std::array<T, V::size> wanted;
  std::array<std::array<T, V::size>, 5> lanes;
  for (std::size_t first = 0; first < count; first += V::size) {
    const std::size_t there = std::min<std::size_t>(V::size, count - first);
    for (std::size_t k = 0; k < V::size; ++k) {
      const std::size_t p = pairs[first + (k < there ? k : 0)];
      const MetPair pair = pair_at(terms.pairs, p);
      i[k] = pair.i;
      j[k] = pair.j;
      wanted[k] = terms.wanted[p];
    }
    const ImpactLanes<V> found = impacts_of<V>(terms, i.data(), j.data(), load_lanes<V>(wanted.data()));
    std::uint64_t bits = bits_of<V>(found.is_one) & ((std::uint64_t{1} << there) - 1);
    if (bits == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(lanes[axis].data(), found.n[axis]);
    store_lanes(lanes[3].data(), found.f);
    store_lanes(lanes[4].data(), found.speed);
    for (; bits != 0; bits &= bits - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(bits));
      put_impact(terms.found, at, Impact<T>{{lanes[0][k], lanes[1][k], lanes[2][k]}, lanes[3][k], lanes[4][k]});
      terms.pair_of[at++] = pairs[first + k];
    }
  }
  return at;
}

template <class V>
std::size_t find_hit(const ImpactTerms<Scalar<V>>& terms, std::size_t from, std::size_t to, Scalar<V> round,
                     std::uint32_t* pairs) noexcept {
  const auto* const rounds = &terms.particles.shift->round;
  const V wanted(round);
  std::size_t count = 0;
  std::array<std::uint32_t, V::size> numbers;
  std::array<std::int32_t, V::size> at_i, at_j;
  for (std::size_t p = from; p < to; p += V::size) {
    const MetPairs& of = terms.pairs[p / meeting_lanes];
    const std::size_t lane = p % meeting_lanes;
    for (std::size_t k = 0; k < V::size; ++k) {
      numbers[k] = static_cast<std::uint32_t>(p + k);
      at_i[k] = static_cast<std::int32_t>(4 * of.i[lane + k]);
      at_j[k] = static_cast<std::int32_t>(4 * of.j[lane + k]);
    }
    const V of_i = gather_lanes<V>(rounds, at_i.data()), of_j = gather_lanes<V>(rounds, at_j.data());
    std::uint64_t bits = bits_of<V>(select<V>(of_i > of_j, of_i, of_j) == wanted);
    if (to - p < V::size) bits &= (std::uint64_t{1} << (to - p)) - 1;
    if (bits != 0) count += store_chosen<V>(pairs + count, numbers.data(), bits);
  }
  return count;
}

}  // namespace
}  // namespace dvdx
