// Contacts of particles that meet, in rounds: passes/meet/meet.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "execute/meet_substep.hpp"

namespace dvdx {

template <class T>
class MeetContacts {
 public:
  explicit MeetContacts(const MeetSubstep<T>& of) noexcept : of_(of), room_(of.room) {}

  void push_apart() noexcept {
    begin();
    sum_pulses();
    const int rounds = of_.rules.meet().rounds;
    const T beta = of_.rules.are_balls() ? T(beta_of_balls) : T(beta_of_cloth);
    for (int round = 0; round < rounds; ++round) {
      push_all(round + 1 < rounds ? beta : T(0));
      sum_pulses();
    }
    keep_pulses();
  }

 private:
  using Task = typename MeetSubstep<T>::Task;
  using Lanes = typename Separations<T>::Lanes;
  using Three = typename Separations<T>::Three;

  // From the pulses of the sub-step before.
  void begin() noexcept {
    if (of_.parting != 0) see_who_parts();
    const T ratio = room_.is_kept ? of_.h / room_.kept_h : T(0);
    const T scale = T(kept_part) * (ratio * ratio);
    of_.over_tasks([&](const Task& task, std::size_t, std::size_t) {
      begin_pairs(task, scale);
      for (MetWall<T>& wall : of_.walls_of(task)) begin_wall(wall, scale);
    });
  }
  // A birth parts until no other is deeper in it than pairs part by in a sub-step.
  void see_who_parts() noexcept {
    const auto is_deep = [&](const MetPair& pair) {
      const Point<T> apart = minus(room_.x0[pair.i], room_.x0[pair.j]);
      const T least = of_.wanted(pair.i, pair.j) - of_.parting * std::abs(of_.h);
      return least > 0 && inner(apart, apart) < least * least;
    };
    of_.over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      const std::uint32_t* const lower_near = room_.lower_near().data();
      std::uint32_t own = task.first;
      for (std::size_t i = from; i < end; ++i) {
        const std::uint32_t own_end = task.first + room_.own_end[i];
        bool parts = false;
        if (room_.parts[i] != 0) {
          for (std::uint32_t p = own; p < own_end; ++p) parts = parts || is_deep(room_.pair(p));
          for (std::uint32_t lower = room_.lists.first_lower(i); lower < room_.lower_end[i]; ++lower) {
            parts = parts || is_deep(room_.pair(lower_near[lower]));
          }
        }
        room_.parts[i] = parts ? 1 : 0;
        own = own_end;
      }
    });
  }
  static Pulse<T> scaled(T scale, const Pulse<T>& of) noexcept { return {times(scale, of.vector), scale * of.number}; }

  // Pairs and kept ones ascend both.
  void begin_pairs(const Task& task, T scale) noexcept {
    std::uint32_t k = task.kept_first;
    const std::uint32_t kept_end = room_.is_kept ? k + task.kept : k;
    for (std::uint32_t p = task.first; p < task.first + task.near; p += meeting_lanes) {
      Three q0{}, q1{};
      Lanes d{};
      PulseLanes<T> pulses{};
      const std::uint32_t count = std::min<std::uint32_t>(meeting_lanes, task.first + task.near - p);
      for (std::uint32_t lane = 0; lane < count; ++lane) {
        const MetPair pair = room_.pair(p + lane);
        Point<T> end_at = minus(room_.x1[pair.i], room_.x1[pair.j]);
        if (room_.has_impacts) end_at = plus(end_at, minus(of_.moved_by_impacts(pair.i), of_.moved_by_impacts(pair.j)));
        const Point<T> start_at = minus(room_.x0[pair.i], room_.x0[pair.j]);
        Separations<T>::put(q0, lane, start_at);
        Separations<T>::put(q1, lane, end_at);
        d[lane] = of_.wanted(pair, start_at);
        while (k < kept_end && room_.kept_pair(k) < pair) ++k;
        if (k < kept_end && room_.kept_pair(k) == pair) pulses.put(lane, scaled(scale, room_.kept_pulses[k]));
      }
      begin_contacts_of(room_.separations[p / meeting_lanes], q0, q1, d, pulses);
      for (std::uint32_t lane = 0; lane < meeting_lanes; ++lane) room_.pulses[p + lane] = pulses.of(lane);
    }
  }
  void begin_wall(MetWall<T>& wall, T scale) noexcept {
    const std::size_t i = wall.particle;
    const std::uint32_t* const first = room_.kept_wall_surfaces.data() + i * room_.walls_each;
    const std::uint32_t* const last = first + (room_.is_kept ? room_.kept_wall_count[i] : 0);
    const std::uint32_t* const found = std::find(first, last, wall.surface);
    const Point<T> moved = of_.moved_by_impacts(i);
    wall.contact.gap = wall.contact.gap + inner(wall.contact.n, moved);
    const Point<T> D = minus(plus(minus(room_.x1[i], room_.x0[i]), moved), wall.way);
    const auto kept_at = static_cast<std::size_t>(found - room_.kept_wall_surfaces.data());
    wall.pulse = begin_contact(wall.contact, D, found != last ? scaled(scale, room_.kept_walls[kept_at]) : Pulse<T>{});
  }

  void push_all(T beta) noexcept {
    const RoundTerms<T> terms{.pairs = room_.pairs.data(),
                              .contacts = room_.separations.data(),
                              .pulses = room_.pulses.data(),
                              .pushed = room_.pushed.data(),
                              .mu = of_.mu(),
                              .beta = beta};
    of_.over_tasks([&](const Task& task, std::size_t, std::size_t) {
      of_.kernels.push(terms, task.first, task.first + task.near);
      for (MetWall<T>& wall : of_.walls_of(task)) {
        const MeetPush<T>& pushed = room_.pushed[wall.particle];
        push(wall.contact, wall.pulse, pushed.dx, pushed.w, wall.mu, beta);
      }
    });
  }
  // How far pulses move each particle, by those of partners in the order of their numbers, then by surfaces.
  void sum_pulses() noexcept {
    of_.over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      const std::uint32_t* const lower_near = room_.lower_near().data();
      const Pulse<T>* own = room_.pulses.data() + task.first;
      const Pulse<T>* const first_own = own;
      const MetWall<T>* wall = room_.walls.data() + task.first_wall;
      for (std::size_t i = from; i < end; ++i) {
        T x = 0, y = 0, z = 0, number = 0;  // numbers are whole and so exact
        const std::uint32_t* const lower_end = lower_near + room_.lower_end[i];
        for (const std::uint32_t* lower = lower_near + room_.lists.first_lower(i); lower != lower_end; ++lower) {
          const Pulse<T>& pulse = room_.pulses[*lower];
          x -= pulse.vector[0];
          y -= pulse.vector[1];
          z -= pulse.vector[2];
          number += pulse.number;
        }
        const auto take = [&](const Pulse<T>& pulse) {
          x += pulse.vector[0];
          y += pulse.vector[1];
          z += pulse.vector[2];
          number += pulse.number;
        };
        for (const Pulse<T>* const own_end = first_own + room_.own_end[i]; own != own_end; ++own) take(*own);
        for (const MetWall<T>* const wall_end = wall + of_.walls_of(i); wall != wall_end; ++wall) take(wall->pulse);
        room_.pushed[i] = {times(room_.w[i], Point<T>{x, y, z}), room_.w[i] * number};
      }
    });
  }

  void keep_pulses() noexcept {
    const T weight = of_.slowest / 4 * std::abs(of_.h);
    of_.over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
        const MetPair pair = room_.pair(p);
        const Separation<T> contact = room_.separations[p / meeting_lanes].of(p % meeting_lanes);
        room_.pulses[p] = kept(contact, weight / (room_.w[pair.i] + room_.w[pair.j]));
      }
      for (std::size_t i = from; i < end && room_.walls_each != 0; ++i) keep_walls(i, weight);
    });
    room_.is_kept = true;
    room_.kept_h = of_.h;
  }
  void keep_walls(std::size_t i, T weight) noexcept {
    std::uint8_t count = 0;
    for (std::size_t s = 0; s < of_.walls_of(i); ++s) {
      const MetWall<T>& wall = of_.wall(i, s);
      if (!(wall.contact.normal > 0)) continue;
      const std::size_t at = i * room_.walls_each + count++;
      room_.kept_walls[at] = kept(wall.contact, weight / room_.w[i]);
      room_.kept_wall_surfaces[at] = wall.surface;
    }
    room_.kept_wall_count[i] = count;
  }

  const MeetSubstep<T>& of_;
  MeetRoom<T>& room_;
};

}  // namespace dvdx
