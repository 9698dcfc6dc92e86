// The contract of every time in a report: a warm-up, then the least of at least five repeats; only one if a run takes over 2 s.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace dvdx::tool::report {

struct Least {
  double seconds = std::numeric_limits<double>::infinity();
  int repeats = 0;
};

// Times run(), but not prepare(). The caller does the warm-up.
template <class Prepare, class Run>
Least least_of(Prepare&& prepare, Run&& run) {
  constexpr int enough = 5;
  constexpr int most = 15;
  constexpr double long_run = 2;       // s
  constexpr double worth_more = 2e-2;  // s: below this, a few more repeats cost nothing
  Least least;
  double spent = 0;
  while (least.repeats < enough || (least.repeats < most && spent < worth_more)) {
    prepare();
    const auto before = std::chrono::steady_clock::now();
    run();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    least.seconds = std::min(least.seconds, seconds);
    ++least.repeats;
    spent += seconds;
    if (seconds > long_run) break;
  }
  return least;
}

}  // namespace dvdx::tool::report
