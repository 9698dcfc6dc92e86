// A number as the unevaluated sum of two doubles: about 32 digits, for coefficients that are made once.
#pragma once

#include <cmath>

// Error-free sums and products (Knuth, Dekker; Ogita, Rump and Oishi collect them). Only + - * / and std::fma, which is exact
// by definition wherever it runs, so the bits are the same everywhere.

namespace dvdx {

struct TwoDouble {
  double high = 0, low = 0;

  constexpr TwoDouble() = default;
  constexpr TwoDouble(double value) : high(value) {}  // NOLINT(google-explicit-constructor): a double is one
  constexpr TwoDouble(double h, double l) : high(h), low(l) {}
  [[nodiscard]] constexpr double value() const noexcept { return high + low; }
};

// a + b exactly, for any a and b.
[[nodiscard]] inline TwoDouble two_sum(double a, double b) noexcept {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

// a + b exactly, for |a| >= |b|.
[[nodiscard]] inline TwoDouble quick_two_sum(double a, double b) noexcept {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

// a * b exactly, where nothing underflows.
[[nodiscard]] inline TwoDouble two_product(double a, double b) noexcept {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

[[nodiscard]] inline TwoDouble operator+(TwoDouble a, TwoDouble b) noexcept {
  const TwoDouble high = two_sum(a.high, b.high);
  const TwoDouble low = two_sum(a.low, b.low);
  const TwoDouble sum = quick_two_sum(high.high, high.low + low.high);
  return quick_two_sum(sum.high, sum.low + low.low);
}

[[nodiscard]] inline TwoDouble operator-(TwoDouble a) noexcept { return {-a.high, -a.low}; }
[[nodiscard]] inline TwoDouble operator-(TwoDouble a, TwoDouble b) noexcept { return a + (-b); }

[[nodiscard]] inline TwoDouble operator*(TwoDouble a, TwoDouble b) noexcept {
  const TwoDouble high = two_product(a.high, b.high);
  return quick_two_sum(high.high, high.low + (a.high * b.low + a.low * b.high));
}

[[nodiscard]] inline TwoDouble operator/(TwoDouble a, TwoDouble b) noexcept {
  const double first = a.high / b.high;
  const TwoDouble rest = a - b * first;
  const double second = rest.high / b.high;
  const double third = (rest - b * second).high / b.high;
  return quick_two_sum(first, second) + third;
}

[[nodiscard]] inline TwoDouble operator/(TwoDouble a, double b) noexcept {
  const double first = a.high / b;
  return quick_two_sum(first, (std::fma(-first, b, a.high) + a.low) / b);
}

[[nodiscard]] inline TwoDouble operator*(TwoDouble a, double b) noexcept {
  const TwoDouble high = two_product(a.high, b);
  return quick_two_sum(high.high, high.low + a.low * b);
}
[[nodiscard]] inline TwoDouble operator*(double a, TwoDouble b) noexcept { return b * a; }

inline TwoDouble& operator+=(TwoDouble& a, TwoDouble b) noexcept { return a = a + b; }

// a * 2^n; exact.
[[nodiscard]] inline TwoDouble scaled(TwoDouble a, int n) noexcept { return {std::ldexp(a.high, n), std::ldexp(a.low, n)}; }

}  // namespace dvdx
