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
    deal_out();
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

  // From the pulses of the sub-step before.
  void begin() noexcept {
    if (of_.parting != 0) see_who_parts();
    const T ratio = room_.is_kept ? of_.h / room_.kept_h : T(0);
    const T scale = T(kept_part) * (ratio * ratio);
    const BeginTerms<T> terms{.pairs = room_.pairs.data(),
                              .wanted = room_.wanted.data(),
                              .particles = room_.met(),
                              .has_impacts = room_.has_impacts,
                              .h = of_.h,
                              .contacts = room_.separations.data(),
                              .pulses = room_.pulses.data(),
                              .against = room_.against()};
    of_.over_tasks([&](const Task& task, std::size_t, std::size_t) {
      take_kept(task, scale);
      if (of_.parting != 0) part(task);
      of_.kernels.begin(terms, task.first, task.first + task.near);
      for (std::uint32_t wall = task.first_wall; wall < task.first_wall + task.walls; ++wall) begin_wall(wall, scale);
    });
  }
  // A birth parts until no other is deeper in it than pairs part by in a sub-step.
  void see_who_parts() noexcept {
    const auto is_deep = [&](const MetPair& pair) {
      const Point<T> apart = minus(room_.start[pair.i].x, room_.start[pair.j].x);
      const T least = of_.wanted(pair.i, pair.j) - of_.parting * std::abs(of_.h);
      return least > 0 && inner(apart, apart) < least * least;
    };
    of_.over_particles([&](std::size_t i) {
      bool parts = false;
      if (room_.parts[i] != 0) of_.over_pairs_of(i, [&](std::uint32_t p) { parts = parts || is_deep(room_.pair(p)); });
      room_.parts[i] = parts ? 1 : 0;
    });
  }
  void part(const Task& task) noexcept {
    for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
      const MetPair pair = room_.pair(p);
      if ((room_.parts[pair.i] | room_.parts[pair.j]) == 0) continue;
      room_.wanted[p] = of_.parted(room_.wanted[p], minus(room_.start[pair.i].x, room_.start[pair.j].x));
    }
  }
  static Pulse<T> scaled(T scale, const Pulse<T>& of) noexcept { return {times(scale, of.vector), scale * of.number}; }

  // Pairs and kept ones ascend both.
  void take_kept(const Task& task, T scale) noexcept {
    std::uint32_t k = task.kept_first;
    const std::uint32_t kept_end = room_.is_kept ? k + task.kept : k;
    for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
      const MetPair pair = room_.pair(p);
      while (k < kept_end && room_.kept_pair(k) < pair) ++k;
      const bool is_kept = k < kept_end && room_.kept_pair(k) == pair;
      room_.pulses[p] = is_kept ? scaled(scale, room_.kept_pulses[k]) : Pulse<T>{};
    }
    for (std::uint32_t p = task.first + task.near; p % meeting_lanes != 0; ++p) room_.pulses[p] = {};
  }
  void begin_wall(std::uint32_t number, T scale) noexcept {
    MetWall<T>& wall = room_.walls[number];
    const std::size_t i = wall.particle;
    const std::uint32_t* const first = room_.kept_wall_surfaces.data() + i * room_.walls_each;
    const std::uint32_t* const last = first + (room_.is_kept ? room_.kept_wall_count[i] : 0);
    const std::uint32_t* const found = std::find(first, last, wall.surface);
    const Point<T> moved = of_.moved_by_impacts(i);
    wall.contact.gap = wall.contact.gap + inner(wall.contact.n, moved);
    const Point<T> D = minus(plus(minus(room_.end[i].x, room_.start[i].x), moved), wall.way);
    const auto kept_at = static_cast<std::size_t>(found - room_.kept_wall_surfaces.data());
    const Pulse<T> kept = found != last ? scaled(scale, room_.kept_walls[kept_at]) : Pulse<T>{};
    room_.wall_pulse(number) = begin_contact(wall.contact, D, kept);
  }

  // Particles that have as many pulses stand side by side, those that have most first; those that have none get nothing.
  void deal_out() noexcept {
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.summed = task.most_summed = 0;
      for (std::size_t i = from; i < end; ++i) {
        const std::uint32_t count = pulses_of(i);
        task.summed += count;
        task.most_summed = std::max(task.most_summed, count);
        if (count == 0) room_.pushed[i] = {};
      }
    });
    std::uint32_t place = 0;
    for (Task& task : room_.tasks) {
      task.first_place = place;
      place += task.summed + static_cast<std::uint32_t>(meeting_lanes) * task.most_summed;
    }
    for_each_task(of_.parallel, room_.tasks.size(), [&](std::size_t number) { deal_out(number); });
  }
  [[nodiscard]] std::uint32_t pulses_of(std::size_t i) const noexcept {
    const std::uint32_t own = room_.own_end[i] - (i % particles_per_meeting_task != 0 ? room_.own_end[i - 1] : 0);
    return own + (room_.first_lower[i + 1] - room_.first_lower[i]) + static_cast<std::uint32_t>(of_.walls_of(i));
  }
  void deal_out(std::size_t number) noexcept {
    Task& task = room_.tasks[number];
    const std::size_t from = number * particles_per_meeting_task;
    const std::size_t end = std::min(room_.particles, from + particles_per_meeting_task);
    const std::size_t first_lane = number * particles_per_meeting_task;
    // Counted from the most down: where those with as many begin.
    std::array<std::uint16_t, 2 + most_pulses> begins{};
    for (std::size_t i = from; i < end; ++i) ++begins[task.most_summed - pulses_of(i) + 1];
    for (std::size_t k = 1; k <= task.most_summed; ++k) begins[k] = static_cast<std::uint16_t>(begins[k] + begins[k - 1]);
    const std::size_t all = task.most_summed != 0 ? begins[task.most_summed] : 0;
    for (std::size_t i = from; i < end; ++i) {
      const std::uint32_t count = pulses_of(i);
      if (count != 0) room_.summed[first_lane + begins[task.most_summed - count]++] = static_cast<std::uint32_t>(i);
    }
    task.slices = static_cast<std::uint32_t>(tasks_of(all, meeting_lanes));
    std::uint32_t place = task.first_place;
    for (std::size_t row = 0; row < task.slices; ++row) {
      const std::size_t lane = first_lane + row * meeting_lanes;
      const std::uint32_t count = pulses_of(room_.summed[lane]);
      room_.slices[number * slices_per_meeting_task + row] = {place, count};
      for (std::size_t k = 0; k < meeting_lanes; ++k) {
        const bool is_one = row * meeting_lanes + k < all;
        const std::size_t i = is_one ? room_.summed[lane + k] : room_.nobody(number);
        deal_out(i, is_one, room_.places.data() + place + k, count);
        room_.summed[lane + k] = static_cast<std::uint32_t>(4 * i);
        room_.summed_w[lane + k] = is_one ? room_.velocity[i].w : T(0);
      }
      place += count * static_cast<std::uint32_t>(meeting_lanes);
    }
  }
  // The places of a particle's pulses: of partners in the order of their numbers, then of surfaces.
  void deal_out(std::size_t i, bool is_one, std::uint32_t* place, std::uint32_t count) noexcept {
    std::uint32_t* const end = place + count * meeting_lanes;
    const auto put = [&](std::size_t pulse) {
      *place = static_cast<std::uint32_t>(4 * pulse);
      place += meeting_lanes;
    };
    if (is_one) {
      for (std::uint32_t k = room_.first_lower[i]; k < room_.first_lower[i + 1]; ++k) put(room_.wanted.size() + room_.lower[k]);
      const std::uint32_t first = room_.tasks[i / particles_per_meeting_task].first;
      const std::uint32_t own = i % particles_per_meeting_task != 0 ? room_.own_end[i - 1] : 0;
      for (std::uint32_t p = first + own; p < first + room_.own_end[i]; ++p) put(p);
      for (std::size_t s = 0; s < of_.walls_of(i); ++s) put(2 * room_.wanted.size() + room_.first_wall[i] + s);
    }
    while (place != end) put(room_.no_pulse());
  }

  void push_all(T beta) noexcept {
    const RoundTerms<T> terms{.pairs = room_.pairs.data(),
                              .contacts = room_.separations.data(),
                              .pulses = room_.pulses.data(),
                              .against = room_.against(),
                              .pushed = room_.pushed.data(),
                              .mu = of_.mu(),
                              .beta = beta};
    of_.over_tasks([&](const Task& task, std::size_t, std::size_t) {
      of_.kernels.push(terms, task.first, task.first + task.near);
      for (std::uint32_t number = task.first_wall; number < task.first_wall + task.walls; ++number) {
        MetWall<T>& wall = room_.walls[number];
        const MeetPush<T>& pushed = room_.pushed[wall.particle];
        Pulse<T> pulse{{}, room_.wall_pulse(number).number};
        push(wall.contact, pulse, pushed.dx, pushed.w, wall.mu, beta);
        room_.wall_pulse(number) = pulse;
      }
    });
  }
  // How far pulses move each particle.
  void sum_pulses() noexcept {
    const SumTerms<T> terms{.slices = room_.slices.data(),
                            .particles = room_.summed.data(),
                            .w = room_.summed_w.data(),
                            .places = room_.places.data(),
                            .pulses = room_.pulses.data(),
                            .pushed = room_.pushed.data()};
    for_each_task(of_.parallel, room_.tasks.size(), [&](std::size_t number) {
      const std::size_t first = number * slices_per_meeting_task;
      of_.kernels.sum(terms, first, first + room_.tasks[number].slices);
    });
  }

  void keep_pulses() noexcept {
    const T weight = of_.slowest / 4 * std::abs(of_.h);
    of_.over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
        const MetPair pair = room_.pair(p);
        const Separation<T> contact = room_.separations[p / meeting_lanes].of(p % meeting_lanes);
        room_.kept_pulses[p] = kept(contact, weight / (room_.velocity[pair.i].w + room_.velocity[pair.j].w));
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
      room_.kept_walls[at] = kept(wall.contact, weight / room_.velocity[i].w);
      room_.kept_wall_surfaces[at] = wall.surface;
    }
    room_.kept_wall_count[i] = count;
  }

  static constexpr std::size_t most_pulses = 255 + most_walls;  // of a particle

  const MeetSubstep<T>& of_;
  MeetRoom<T>& room_;
};

}  // namespace dvdx
