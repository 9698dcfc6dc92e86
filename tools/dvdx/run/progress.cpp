#include "run/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "output/console.hpp"

namespace dvdx::tool {
namespace {

using namespace std::chrono_literals;

constexpr auto bar_starts = 500ms;  // a run that is over by then needs no bar
constexpr auto bar_moves = 100ms;
constexpr auto line_comes = 10s;

std::string span_text(double seconds) {
  if (seconds < 60) return fmt::format("{:.0f} s", seconds);
  const auto minutes = static_cast<std::uint64_t>(seconds / 60);
  if (minutes < 60) return fmt::format("{} min {:02.0f} s", minutes, seconds - 60.0 * static_cast<double>(minutes));
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

}  // namespace

Progress::Form Progress::form_here() {
  if (isatty(STDERR_FILENO) == 0) return Form::lines;
  const char* plain = std::getenv("NO_COLOR");  // NOLINT(concurrency-mt-unsafe): read only
  return plain != nullptr && *plain != '\0' ? Form::bar : Form::coloured_bar;
}

Progress::Progress(std::uint64_t total, std::uint64_t done)
    : total_(total), before_(done), form_(form_here()), start_(Clock::now()) {
  next_ = start_ + (form_ == Form::lines ? Clock::duration(line_comes) : Clock::duration(bar_starts));
}

Progress::~Progress() {
  if (form_ != Form::lines) print_progress("\r\x1b[K");
}

void Progress::at(std::uint64_t done) {
  const auto now = Clock::now();
  if (now < next_ || done == before_) return;
  next_ = now + (form_ == Form::lines ? Clock::duration(line_comes) : Clock::duration(bar_moves));
  const double spent = std::chrono::duration<double>(now - start_).count();
  draw(done, spent * static_cast<double>(total_ - done) / static_cast<double>(done - before_));
}

void Progress::draw(std::uint64_t done, double seconds_left) {
  const double part = static_cast<double>(done) / static_cast<double>(total_);
  const auto text = fmt::format("{:3.0f} %, step {} of {}, {} left", 100 * part, done, total_, span_text(seconds_left));
  if (form_ == Form::lines) {
    print_progress(text + "\n");
    return;
  }
  constexpr std::size_t width = 30;
  const auto full = static_cast<std::size_t>(part * width);
  const bool coloured = form_ == Form::coloured_bar;
  print_progress(fmt::format("\r{}{}{}{} {}\x1b[K", coloured ? "\x1b[32m" : "", std::string(full, '#'),
                             coloured ? "\x1b[0m" : "", std::string(width - full, '-'), text));
}

}  // namespace dvdx::tool
