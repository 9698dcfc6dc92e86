// Two pieces of work timed in turn, so that other load on the machine affects both alike.
#pragma once

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <vector>

namespace dvdx::bench {

// One thread's work is timed by the thread's own clock, which stops while other programs have the core. The work of several
// threads is timed by wall time, the only clock that covers them.
enum class Timer { thread, wall };

inline double now(Timer timer) {
  std::timespec time{};
  clock_gettime(timer == Timer::thread ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Effort {
  int rounds = 11;        // pairs
  int samples = 4;        // of each side in a round; the shortest counts
  double seconds = 2e-3;  // minimum duration of a sample
  Timer timer = Timer::thread;
};

struct Race {
  double a = 0, b = 0;                         // shortest times, s
  double median = 0, lowest = 0, highest = 0;  // of a/b, paired by round
};

template <class Work>
double time_of(Work& work, int repeats, Timer timer) {
  const double start = now(timer);
  for (int i = 0; i < repeats; ++i) work();
  return (now(timer) - start) / repeats;
}

template <class Work>
int repeats_for(Work& work, const Effort& effort) {
  work();
  int repeats = 1;
  while (repeats < (1 << 24) && time_of(work, repeats, effort.timer) * repeats < effort.seconds) repeats *= 2;
  return repeats;
}

template <class Work>
double shortest_of(Work& work, int repeats, int samples, Timer timer) {
  double shortest = time_of(work, repeats, timer);
  for (int i = 1; i < samples; ++i) shortest = std::min(shortest, time_of(work, repeats, timer));
  return shortest;
}

template <class Work>
double shortest(const Effort& effort, Work work) {
  return shortest_of(work, repeats_for(work, effort), effort.rounds * effort.samples / 2 + 1, effort.timer);
}

template <class A, class B>
Race race(const Effort& effort, A a, B b) {
  const int repeats_a = repeats_for(a, effort), repeats_b = repeats_for(b, effort);
  Race result{.a = 1e9, .b = 1e9};
  std::vector<double> ratios;
  for (int round = 0; round < effort.rounds; ++round) {
    const bool is_a_first = round % 2 == 0;
    double of_a = 0, of_b = 0;
    if (is_a_first) of_a = shortest_of(a, repeats_a, effort.samples, effort.timer);
    of_b = shortest_of(b, repeats_b, effort.samples, effort.timer);
    if (!is_a_first) of_a = shortest_of(a, repeats_a, effort.samples, effort.timer);
    result.a = std::min(result.a, of_a);
    result.b = std::min(result.b, of_b);
    ratios.push_back(of_a / of_b);
  }
  std::sort(ratios.begin(), ratios.end());
  result.median = ratios[ratios.size() / 2];
  result.lowest = ratios.front();
  result.highest = ratios.back();
  return result;
}

}  // namespace dvdx::bench
