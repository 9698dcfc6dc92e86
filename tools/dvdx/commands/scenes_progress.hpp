// Shows on stderr how far a measurement is: on one line of a terminal, otherwise a line every ten seconds.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace dvdx::tool {

class ScenesProgress {
 public:
  explicit ScenesProgress(std::size_t scenes);
  ScenesProgress(const ScenesProgress&) = delete;
  ScenesProgress& operator=(const ScenesProgress&) = delete;
  ~ScenesProgress();  // erases the line

  void scene(std::size_t index, const std::string& name);
  // part: how much of the scene is done, 0 to 1.
  void at(double part, const std::string& what);

 private:
  std::size_t scenes_;
  std::size_t index_ = 0;
  std::string name_;
  bool is_terminal_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace dvdx::tool
