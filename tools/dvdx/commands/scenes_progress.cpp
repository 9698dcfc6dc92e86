#include "commands/scenes_progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "output/console.hpp"

namespace dvdx::tool {

using namespace std::chrono_literals;

ScenesProgress::ScenesProgress(std::size_t scenes)
    : scenes_(scenes), is_terminal_(isatty(STDERR_FILENO) != 0), next_(std::chrono::steady_clock::now() + 500ms) {}

ScenesProgress::~ScenesProgress() {
  if (is_terminal_) print_progress("\r\x1b[K");
}

void ScenesProgress::scene(std::size_t index, const std::string& name) {
  index_ = index;
  name_ = printable(name);
}

void ScenesProgress::at(double part, const std::string& what) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + (is_terminal_ ? 100ms : 10000ms);
  const double whole = (static_cast<double>(index_) + part) / static_cast<double>(scenes_);
  print_progress(
      fmt::format("{}{:3.0f} %  {}: {}{}", is_terminal_ ? "\r" : "", 100 * whole, name_, what, is_terminal_ ? "\x1b[K" : "\n"));
}

}  // namespace dvdx::tool
