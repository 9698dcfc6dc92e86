// Sums of doubles without any rounding, so that they depend neither on the order of the terms nor on how these are split. A sum
// is a whole number of 2^-1074, the smallest double, in words of 32 bits that have room for 2^31 carries.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace dvdx {

inline constexpr std::size_t exact_limbs = 66;               // 2098 bits
inline constexpr std::size_t exact_words = exact_limbs + 1;  // the last counts the terms that are not finite

// Calls add(word, number) for the words that a term falls into. Each number is below 2^33 in size.
template <class Add>
void for_each_word(double term, const Add& add) noexcept {
  const auto bits = std::bit_cast<std::uint64_t>(term);
  const auto exponent = static_cast<std::size_t>(bits >> 52U & 0x7ffU);
  if (exponent == 0x7ff) return add(exact_limbs, std::int64_t{1});
  const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52U) - 1);
  const std::uint64_t digits = exponent == 0 ? fraction : fraction | std::uint64_t{1} << 52U;
  if (digits == 0) return;
  const std::size_t place = exponent == 0 ? 0 : exponent - 1;
  const std::size_t first = place / 32;
  const std::size_t shift = place % 32;
  constexpr std::uint64_t low = 0xffffffff;
  const std::uint64_t a = (digits & low) << shift;
  const std::uint64_t b = (digits >> 32U) << shift;
  const std::int64_t sign = (bits >> 63U) != 0 ? -1 : 1;
  add(first, sign * static_cast<std::int64_t>(a & low));
  add(first + 1, sign * static_cast<std::int64_t>((a >> 32U) + (b & low)));
  if (b >> 32U != 0) add(first + 2, sign * static_cast<std::int64_t>(b >> 32U));
}

// Carries until every limb but the last is below 2^32 in size. The sum stays the same.
inline void carry(std::span<std::int64_t> limbs) noexcept {
  constexpr std::int64_t base = std::int64_t{1} << 32U;
  for (std::size_t k = 0; k + 1 < limbs.size(); ++k) {
    limbs[k + 1] += limbs[k] / base;
    limbs[k] %= base;
  }
}

// Many terms of like size side by side, which are then added exactly a few times in all instead of each by itself.
// If all |t| < 2^a, let u = 2^(a-31), v = 2^(a-62), M = 1.5 2^52 u and N = 1.5 2^52 v. As M's last digit is worth u,
// p = (M + t) - M is the multiple of u next to t, and t - p is exact; q = (N + (t - p)) - N is the multiple of v next to that.
// No p is above 2^a and no q above u/2, so sums of up to 2^22 of either are exact, in any order. The part of a term beyond v
// is taken by rest(): only terms below 2^(a-9) have one.
class ExactLanes {
 public:
  static constexpr std::size_t lanes = 16;

  // rest(term) takes the terms and parts that lanes cannot hold, and must take them exactly.
  template <class Rest>
  void add(const std::array<double, lanes>& terms, const Rest& rest) noexcept {
    // Compares bits as whole numbers, which are in the same order as the doubles' sizes: compilers vectorise that.
    const std::uint64_t below = std::bit_cast<std::uint64_t>(limit_) - 1;
    std::uint64_t any = 0;
    std::uint64_t above = 0;
    for (const double t : terms) {
      any |= size_bits(t);
      above |= below - size_bits(t);
    }
    if (any == 0) return;
    if (above >> 63U != 0) return add_large(terms, rest);
    add_small(terms, rest);
  }

  template <class Rest>
  void flush(const Rest& rest) noexcept {
    double p = 0;
    double q = 0;
    for (std::size_t k = 0; k < lanes; ++k) {
      p += p_[k];
      q += q_[k];
    }
    rest(p);
    rest(q);
    p_ = q_ = {};
    count_ = 0;
  }

 private:
  static constexpr std::uint32_t most = (std::uint32_t{1} << 22U) / lanes;
  static constexpr int largest_exponent = 900;  // beyond it M or v would leave the range of double

  static std::uint64_t size_bits(double t) noexcept { return std::bit_cast<std::uint64_t>(t) & ~std::uint64_t{0} >> 1U; }

  template <class Rest>
  void add_small(const std::array<double, lanes>& terms, const Rest& rest) noexcept {
    std::array<double, lanes> left;
    std::uint64_t any = 0;
    for (std::size_t k = 0; k < lanes; ++k) {
      const double p = (M_ + terms[k]) - M_;
      const double below = terms[k] - p;
      const double q = (N_ + below) - N_;
      p_[k] += p;
      q_[k] += q;
      left[k] = below - q;
      any |= size_bits(left[k]);
    }
    if (any != 0) {
      for (const double of : left) rest(of);
    }
    if (++count_ == most) flush(rest);
  }

  // For terms of which one reaches the present limit. Terms that no limit holds go to rest().
  template <class Rest>
  void add_large(const std::array<double, lanes>& terms, const Rest& rest) noexcept {
    std::array<double, lanes> fit = terms;
    double largest = 0;
    for (double& t : fit) {
      if (std::abs(t) < std::ldexp(1.0, largest_exponent)) {
        largest = std::max(largest, std::abs(t));
      } else {
        rest(t);
        t = 0;
      }
    }
    if (largest >= limit_) {
      flush(rest);
      const int a = std::max(std::ilogb(largest), -largest_exponent) + 3;
      limit_ = std::ldexp(1.0, a);
      M_ = std::ldexp(1.5, a - 31 + 52);
      N_ = std::ldexp(1.5, a - 62 + 52);
    }
    add_small(fit, rest);
  }

  double limit_ = 0, M_ = 0, N_ = 0;
  alignas(64) std::array<double, lanes> p_{}, q_{};
  std::uint32_t count_ = 0;
};

// The nearest double.
inline double rounded(std::span<const std::int64_t, exact_words> words) noexcept {
  if (words[exact_limbs] != 0) return std::numeric_limits<double>::quiet_NaN();
  constexpr std::size_t below = 2;  // zeros, so that the lowest limb has two below it
  std::array<std::int64_t, below + exact_limbs + 1> limbs{};
  std::copy_n(words.begin(), exact_limbs, limbs.begin() + below);
  carry(limbs);
  std::size_t top = limbs.size();
  while (top > 0 && limbs[top - 1] == 0) --top;
  if (top == 0) return 0;
  const double sign = limbs[--top] < 0 ? -1 : 1;
  if (sign < 0) {
    for (std::int64_t& limb : limbs) limb = -limb;
  }
  for (std::size_t k = 0; k < top; ++k) {  // borrow: all of one sign
    if (limbs[k] >= 0) continue;
    limbs[k] += std::int64_t{1} << 32U;
    --limbs[k + 1];
  }
  while (limbs[top] == 0) --top;
  const auto at = [&](std::size_t k) { return static_cast<std::uint64_t>(limbs[k]); };
  const std::uint64_t two = at(top) << 32U | at(top - 1);
  const auto free = static_cast<unsigned>(std::countl_zero(two));  // below 32
  std::uint64_t digits = two << free;
  const std::uint64_t third = at(top - 2) << free;
  digits |= third >> 32U;
  bool is_more = (third & 0xffffffffU) != 0;
  for (std::size_t k = 0; k + 2 < top; ++k) is_more = is_more || limbs[k] != 0;
  if (is_more) digits |= 1U;  // far below the last digit of a double: it only decides between two
  const int place = 32 * static_cast<int>(top - 1 - below) - static_cast<int>(free) - 1074;
  return sign * std::ldexp(static_cast<double>(digits), place);
}

}  // namespace dvdx
