// Predicts from the first quarter of a second whether a run takes longer than a minute.
#pragma once

#include <cstdint>
#include <optional>

namespace dvdx::tool {

class LongRunWatch {
 public:
  // seconds: the time of `steps` more steps. left: the steps after them. Returns a time in s once: that of all steps that are
  // left, if it is longer than a minute.
  std::optional<double> take(double seconds, std::uint64_t steps, std::uint64_t left) noexcept {
    if (is_judged_) return std::nullopt;
    seconds_ += seconds;
    steps_ += steps;
    is_judged_ = seconds_ >= enough;
    const double wanted = seconds_ / static_cast<double>(steps_) * static_cast<double>(left);
    return is_judged_ && wanted > most ? std::optional(wanted) : std::nullopt;
  }

  static constexpr double enough = 0.25;  // s: a bar of progress has not begun by then
  static constexpr double most = 60;      // s

 private:
  double seconds_ = 0;
  std::uint64_t steps_ = 0;
  bool is_judged_ = false;
};

}  // namespace dvdx::tool
