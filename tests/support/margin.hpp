// The margin of a test: the largest use of its bounds over many comparisons that are checked as one.
#pragma once

#include <cmath>
#include <string>
#include <utility>

namespace dvdx::test {

// The largest ratio of an error to its bound, and its place. A NaN stays the worst.
class Margin {
 public:
  template <class Where>
  void see(double error, double allowed, Where&& where) {
    ++count_;
    const double used = error == 0 ? 0 : error / allowed;
    if (std::isnan(worst_) || used <= worst_) return;
    worst_ = used;
    where_ = std::forward<Where>(where)();
  }
  [[nodiscard]] bool is_kept() const noexcept { return count_ > 0 && worst_ <= 1; }
  [[nodiscard]] double worst() const noexcept { return worst_; }
  [[nodiscard]] std::string words() const {
    return std::to_string(worst_) + " of what is allowed, of " + std::to_string(count_) + " comparisons, at " + where_;
  }

 private:
  double worst_ = 0;
  int count_ = 0;
  std::string where_;
};

}  // namespace dvdx::test
