// A sub-step of particles that meet, as its parts see it. Work is cut into tasks of fixed sizes; sums are by particle, in the
// order of numbers: no result depends on threads, nor on the age of a list.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "compile/joined_motion.hpp"
#include "execute/meet_room.hpp"
#include "execute/tasks.hpp"
#include "passes/contact/contact.hpp"
#include "passes/meet/meet.inl.hpp"
#include "passes/meet/rounds.hpp"

namespace dvdx {

template <class T>
struct MeetSubstep {
  using Task = typename MeetRoom<T>::MeetTask;

  const MeetRules<T>& rules;
  MeetRoom<T>& room;
  const MeetKernels<T>& kernels;
  ParallelFor parallel;
  T slowest = 0;                         // m/s: what approaches no faster does not bounce
  T parting = 0;                         // m/s: a pair of which one was born within the other parts no faster; 0: none was
  const Surface<T>* surfaces = nullptr;  // where they are at the end
  std::size_t surface_count = 0;
  T h = 0;  // s

  // use(task, first particle, end)
  template <class Use>
  void over_tasks(const Use& use) const noexcept {
    for_each_task(parallel, room.tasks.size(), [&](std::size_t task) {
      use(room.tasks[task], task * particles_per_meeting_task,
          std::min(room.particles, (task + 1) * particles_per_meeting_task));
    });
  }
  template <class Use>
  void over_particles(const Use& use) const noexcept {
    over_tasks([&](const Task&, std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) use(i);
    });
  }

  [[nodiscard]] T wanted(std::size_t i, std::size_t j) const noexcept { return rules.wanted(i, j); }
  // The distance that a pair is to have at the end, which it begins at q0.
  [[nodiscard]] T wanted(const MetPair& pair, const Point<T>& q0) const noexcept {
    const T d = wanted(pair.i, pair.j);
    if (parting == 0 || (room.parts[pair.i] | room.parts[pair.j]) == 0) return d;
    return std::min(d, std::sqrt(inner(q0, q0)) + parting * std::abs(h));
  }
  [[nodiscard]] T mu() const noexcept { return static_cast<T>(std::min(rules.meet().friction, 1e6)); }
  [[nodiscard]] std::size_t walls_of(std::size_t i) const noexcept { return room.walls_each != 0 ? room.wall_count[i] : 0; }
  [[nodiscard]] MetWall<T>& wall(std::size_t i, std::size_t s) const noexcept { return room.walls[room.first_wall[i] + s]; }
  [[nodiscard]] Point<T> moved_by_impacts(std::size_t i) const noexcept { return plus(room.shift[i], times(h, room.dv[i])); }
  [[nodiscard]] std::span<MetWall<T>> walls_of(const Task& task) const noexcept {
    return {room.walls.data() + task.first_wall, task.walls};
  }
  // m: what pushes may add to the ways.
  [[nodiscard]] T margin() const noexcept { return T(0.1) * rules.least_radius(); }
};

}  // namespace dvdx
