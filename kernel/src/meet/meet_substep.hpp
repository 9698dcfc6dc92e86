// A sub-step of particles that meet, as its stages share it. Work is cut into tasks of fixed sizes. Sums are by particle, in
// the order of numbers. So no result depends on threads, nor on the age of a list.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "contact/surfaces/surface.hpp"
#include "meet/meet.inl.hpp"
#include "meet/meet_room.hpp"
#include "meet/meet_rules.hpp"
#include "meet/rounds.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
struct MeetSubstep {
  using Task = typename MeetRoom<T>::MeetTask;

  const MeetRules<T>& rules;
  MeetRoom<T>& room;
  const MeetKernels<T>& kernels;
  ParallelFor parallel;
  T slowest = 0;                         // m/s: a pair that approaches no faster does not bounce
  T parting = 0;                         // m/s: a pair parts no faster if one was born within the other; 0: none was
  const Surface<T>* surfaces = nullptr;  // where they are at the end
  std::size_t surface_count = 0;
  T h = 0;  // s

  // use(task's number, task, first particle, end)
  template <class Use>
  void over_numbered_tasks(const Use& use) const noexcept {
    for_each_task(parallel, room.tasks.size(), [&](std::size_t number) {
      use(number, room.tasks[number], number * particles_per_meeting_task,
          std::min(room.particles, (number + 1) * particles_per_meeting_task));
    });
  }
  // use(task, first particle, end)
  template <class Use>
  void over_tasks(const Use& use) const noexcept {
    over_numbered_tasks([&](std::size_t, Task& task, std::size_t from, std::size_t end) { use(task, from, end); });
  }
  template <class Use>
  void over_particles(const Use& use) const noexcept {
    over_tasks([&](const Task&, std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) use(i);
    });
  }

  [[nodiscard]] T wanted(std::size_t i, std::size_t j) const noexcept { return rules.wanted(i, j); }
  // The distance that a pair is to have at the end if one was born within the other.
  [[nodiscard]] T parted(T d, const Point<T>& q0) const noexcept {
    return std::min(d, std::sqrt(inner(q0, q0)) + parting * std::abs(h));
  }
  [[nodiscard]] T mu() const noexcept { return static_cast<T>(std::min(rules.meet().friction, 1e6)); }
  [[nodiscard]] std::size_t walls_of(std::size_t i) const noexcept { return room.walls_each != 0 ? room.wall_count[i] : 0; }
  [[nodiscard]] MetWall<T>& wall(std::size_t i, std::size_t s) const noexcept { return room.walls[room.first_wall[i] + s]; }
  [[nodiscard]] Point<T> moved_by_impacts(std::size_t i) const noexcept {
    return plus(room.shift[i].dx, times(h, room.hits[i].dv));
  }
  // use(pair number, with pair_is_far if the pair is far). over_lower: pairs in which i has the higher number, by the lower
  // one. over_own: i's own pairs, by the higher one.
  template <class Use>
  void over_lower(std::size_t i, const Use& use) const noexcept {
    for (std::uint32_t k = room.first_lower[i]; k < room.first_lower[i + 1]; ++k) use(room.lower[k]);
  }
  template <class Use>
  void over_own(std::size_t i, const Use& use) const noexcept {
    const std::uint32_t first = room.tasks[i / particles_per_meeting_task].first;
    const std::uint32_t own = i % particles_per_meeting_task != 0 ? room.own_end[i - 1] : 0;
    for (std::uint32_t k = first + own; k < first + room.own_end[i]; ++k) use(room.ordered[k]);
  }
  // use(pair) for all pairs of particle i.
  template <class Use>
  void over_pairs_of(std::size_t i, const Use& use) const noexcept {
    over_lower(i, [&](std::uint32_t p) { use(room.pair(p & ~pair_is_far)); });
    over_own(i, [&](std::uint32_t p) { use(room.pair(p & ~pair_is_far)); });
  }
  // m: beyond the distance that a pair wants. Pairs farther apart take part in rounds only if pushes get longer than before.
  [[nodiscard]] T far() const noexcept {
    const T most = 4 * rules.most_radius();
    return T(0.01) * rules.least_radius() + (room.longest < most ? 3 * room.longest : most);
  }
  // m: how much nearer than their paths pushes may bring a pair.
  [[nodiscard]] T margin() const noexcept { return T(0.1) * rules.least_radius(); }
};

}  // namespace dvdx
