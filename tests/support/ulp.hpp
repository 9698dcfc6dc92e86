// Distances between floating-point numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace dvdx::test {

// |value - exact| in units in the last place of `exact` (or of the smallest normal number).
template <class T>
double ulps(T value, double exact) noexcept {
  int exponent = 0;
  std::frexp(std::max(std::abs(exact), static_cast<double>(std::numeric_limits<T>::min())), &exponent);
  const double ulp = std::ldexp(1.0, exponent - std::numeric_limits<T>::digits);
  return std::abs(static_cast<double>(value) - exact) / ulp;
}

// |value - exact| relative to `scale`, in machine epsilons of T.
template <class T>
double epsilons(T value, double exact, double scale) noexcept {
  if (static_cast<double>(value) == exact) return 0;
  return std::abs(static_cast<double>(value) - exact) /
         (std::abs(scale) * static_cast<double>(std::numeric_limits<T>::epsilon()));
}

// The largest value seen, and the root mean square of all.
class Worst {
 public:
  void see(double value) noexcept {
    worst_ = value <= worst_ ? worst_ : value;  // a NaN sticks
    squares_ += value * value;
    ++count_;
  }
  [[nodiscard]] double worst() const noexcept { return worst_; }
  [[nodiscard]] double rms() const noexcept { return std::sqrt(squares_ / std::max(count_, 1)); }
  [[nodiscard]] int count() const noexcept { return count_; }

 private:
  double worst_ = 0, squares_ = 0;
  int count_ = 0;
};

}  // namespace dvdx::test
