// Shows on stderr how far a run is: a bar on a terminal, otherwise a line every ten seconds.
#pragma once

#include <chrono>
#include <cstdint>

namespace dvdx::tool {

class Progress {
 public:
  explicit Progress(std::uint64_t total, std::uint64_t done = 0);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  // erases the bar

  void at(std::uint64_t done);

 private:
  using Clock = std::chrono::steady_clock;
  enum class Form { bar, coloured_bar, lines };
  static Form form_here();

  void draw(std::uint64_t done, double seconds_left);

  std::uint64_t total_;
  std::uint64_t before_;  // steps done when it began
  Form form_;
  Clock::time_point start_;
  Clock::time_point next_;
};

}  // namespace dvdx::tool
