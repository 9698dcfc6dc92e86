// Compares two numbers up to a relative error. doctest::Approx adds one to the scale of its bound, and so accepts any value if
// the expected one is small against the bound.
#pragma once

#include <cmath>
#include <ostream>

namespace dvdx::test {

// True if |value - expected| <= bound |expected|; an expected 0 accepts 0 only. A failing CHECK prints it.
struct Closeness {
  double value, expected, bound;

  [[nodiscard]] double error() const noexcept {
    return value == expected ? 0 : std::abs(value - expected) / std::abs(expected);
  }
  explicit operator bool() const noexcept { return error() <= bound; }

  friend std::ostream& operator<<(std::ostream& out, const Closeness& at) {
    const auto digits = out.precision(17);
    out << at.value << " instead of " << at.expected;
    out.precision(3);
    out << ", relative error " << at.error() << ", allowed " << at.bound;
    out.precision(digits);
    return out;
  }
};

[[nodiscard]] inline Closeness is_close(double value, double expected, double bound) noexcept {
  return {value, expected, bound};
}

}  // namespace dvdx::test
