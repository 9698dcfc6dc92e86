// The emission pass over registers of doubles, operation by operation as in emission_reference.hpp.
#pragma once

#include <array>

#include "flow/rate.inl.hpp"
#include "lifecycle/pass/emission.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

template <class V>
using Words = xsimd::batch<std::uint64_t, typename V::arch_type>;

// The full product of each lane's lower 32 bits with `factor`.
template <class W>
W times(W lanes, std::uint32_t factor) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(W) == 64) return W(_mm512_mul_epu32(lanes, _mm512_set1_epi64(factor)));
#elif defined(__AVX2__)
  if constexpr (sizeof(W) == 32) return W(_mm256_mul_epu32(lanes, _mm256_set1_epi64x(factor)));
#elif defined(__SSE2__)
  if constexpr (sizeof(W) == 16) return W(_mm_mul_epu32(lanes, _mm_set1_epi64x(factor)));
#elif defined(__aarch64__)
  return W(vmull_u32(vmovn_u64(lanes), vdup_n_u32(factor)));
#endif
}

// A whole number below 2^52 as a double: it is the mantissa of 2^52 plus itself.
template <class V>
V whole(Words<V> number) noexcept {
  return xsimd::bitwise_cast<V>(number | Words<V>(std::uint64_t{0x4330000000000000})) - V(0x1p52);
}

// Four numbers in [0, 1) of the lanes' births, by Philox as in dvdx/counter_random.hpp. Each lane has a counter, and each word
// is in the lower half of its lane. The upper halves reach no product.
template <class V>
std::array<V, 4> draw(std::uint64_t seed, Words<V> birth, std::uint32_t group) noexcept {
  using W = Words<V>;
  W c0 = birth, c1 = birth >> 32, c2(std::uint64_t{group}), c3(std::uint64_t{1});
  auto k0 = static_cast<std::uint32_t>(seed), k1 = static_cast<std::uint32_t>(seed >> 32U);
  for (int round = 0; round < 10; ++round) {
    const W a = times(c0, 0xD2511F53U);
    const W b = times(c2, 0xCD9E8D57U);
    c0 = (b >> 32) ^ c1 ^ W(std::uint64_t{k0});
    c1 = b;
    c2 = (a >> 32) ^ c3 ^ W(std::uint64_t{k1});
    c3 = a;
    k0 += 0x9E3779B9U;
    k1 += 0xBB67AE85U;
  }
  const auto unit = [](W word) { return whole<V>(word & W(std::uint64_t{0xffffffff})) * V(0x1p-32); };
  return {unit(c0), unit(c1), unit(c2), unit(c3)};
}

// 0, 1, ... in memory. Put together lane by lane for each register, they took a quarter of its time.
template <class T>
inline constexpr std::array<T, 8> lane_numbers = {0, 1, 2, 3, 4, 5, 6, 7};

template <class V>
Words<V> numbers_from(std::uint64_t first) noexcept {
  return Words<V>(first) + Words<V>::load_unaligned(lane_numbers<std::uint64_t>.data());
}

template <class V>
V in_box(double least, double most, V u) noexcept {
  const V x = V(least) + V(most - least) * u;
  return select<V>(x > V(most), V(most), x);
}

template <class V>
Three<V> birth_place(const EmissionTerms& terms, const std::array<V, 4>& u) noexcept {
  const auto& [x, y, z] = terms.origin;
  if (terms.shape == EmissionShape::disc) {
    const V r = square_root(u[0]);
    const auto turn = sincos_lanes(V(two_pi) * u[1]);
    const V a = r * turn.cos, b = r * turn.sin;
    const auto& [p, q] = terms.radii;
    return {{V(x) + (a * V(p[0]) + b * V(q[0])), V(y) + (a * V(p[1]) + b * V(q[1])), V(z) + (a * V(p[2]) + b * V(q[2]))}};
  }
  if (terms.shape == EmissionShape::box) {
    return {{in_box(x, terms.most[0], u[0]), in_box(y, terms.most[1], u[1]), in_box(z, terms.most[2], u[2])}};
  }
  return {{V(x), V(y), V(z)}};
}

template <class V>
V off_middle(double half_side, V u) noexcept {
  return V(half_side) * (V(2.0) * u - V(1.0));
}

template <class V>
Three<V> birth_velocity(const EmissionTerms& terms, Words<V> birth) noexcept {
  const auto& [x, y, z] = terms.velocity;
  if (terms.spread == EmissionSpread::none) return {{V(x), V(y), V(z)}};
  const std::array<V, 4> u = draw<V>(terms.seed, birth, 1);
  if (terms.spread == EmissionSpread::ball) {
    const V c = V(2.0) * u[0] - V(1.0);
    const auto turn = sincos_lanes(V(two_pi) * u[1]);
    V most = u[2];
    for (const V other : {u[3], draw<V>(terms.seed, birth, 2)[0]}) most = select<V>(other > most, other, most);
    const V r = V(terms.radius) * most;
    const V s = r * square_root(V(1.0) - c * c);
    return {{V(x) + s * turn.cos, V(y) + s * turn.sin, V(z) + r * c}};
  }
  const auto& [a, b, c] = terms.half_sides;
  return {{V(x) + off_middle(a, u[0]), V(y) + off_middle(b, u[1]), V(z) + off_middle(c, u[2])}};
}

// The rest of the step for the lanes' births, number i of this call and those after it.
template <class V>
V remaining_step(const EmissionTerms& terms, const Births& births, std::size_t i) noexcept {
  const V number = V(static_cast<double>(i)) + load_lanes<V>(lane_numbers<double>.data());
  V remaining = (V(births.lead) - number) * V(terms.interval);
  remaining = select<V>(remaining < V(0.0), V(0.0), remaining);
  return select<V>(remaining > V(births.step), V(births.step), remaining);
}

template <class V>
void emit(const EmissionTerms& terms, const Births& births, Born& born) noexcept {
  for (std::size_t i = 0; i < births.count; i += V::size) {
    const Words<V> birth = numbers_from<V>(births.first + i);
    const std::array<V, 4> u = draw<V>(terms.seed, birth, 0);
    const Three<V> x = birth_place(terms, u), v = birth_velocity<V>(terms, birth);
    const V remaining = remaining_step<V>(terms, births, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      store_lanes(&born.x[axis][i], x[axis] + v[axis] * remaining);
      store_lanes(&born.v[axis][i], v[axis]);
    }
    store_lanes(&born.age[i], remaining);
    const V lifetime(terms.lifetime);
    store_lanes(&born.lifetime[i], terms.lifetime_range > 0 ? lifetime + V(terms.lifetime_range) * u[3] : lifetime);
  }
}

}  // namespace
}  // namespace dvdx
