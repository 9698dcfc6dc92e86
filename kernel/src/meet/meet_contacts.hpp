// Contacts of particles that meet, in rounds: meet/meet.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "meet/meet_substep.hpp"

namespace dvdx {

template <class T>
class MeetContacts {
 public:
  explicit MeetContacts(const MeetSubstep<T>& of) noexcept : of_(of), room_(of.room) {}

  void push_apart() noexcept {
    begin();
    longest_ = 0;
    far_ = reaches_far() ? Far::taken : Far::left;
    deal_out();
    sum_pulses();
    const int rounds = of_.rules.meet().rounds;
    const T beta = of_.rules.are_balls() ? T(beta_of_balls) : T(beta_of_cloth);
    for (int round = 0; round < rounds; ++round) {
      if (far_ == Far::left && reaches_far()) {
        far_ = Far::taken;
        deal_out();
      }
      push_all(round + 1 < rounds ? beta : T(0));
      sum_pulses();
    }
    room_.longest = longest_;
    keep_pulses();
  }

 private:
  using Task = typename MeetSubstep<T>::Task;

  // Whether far pairs take part. None of them acts before pushes are as long as its gap, so no bit depends on it.
  enum class Far { left, taken };
  [[nodiscard]] bool reaches_far() const noexcept {
    const double most = 2.001 * double{longest_};  // a push on both sides, and a margin above rounding
    return std::any_of(room_.tasks.begin(), room_.tasks.end(), [&](const Task& task) { return task.least_far <= most; });
  }

  // Begins all contacts with the pulses of the sub-step before.
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
    of_.over_numbered_tasks([&](std::size_t number, Task& task, std::size_t, std::size_t) {
      take_kept(task, scale);
      if (of_.parting != 0) part(task);
      of_.kernels.begin(terms, task.first, task.first + task.close);
      task.least_far = double{of_.kernels.begin(terms, task.first_far, task.first_far + task.near - task.close)};
      std::uint32_t wall = task.first_wall;
      for (; wall < task.first_wall + task.walls; ++wall) begin_wall(wall, number, scale);
      for (; wall % meeting_lanes != 0; ++wall) leave_out_wall(wall, number);
    });
  }
  // A birth keeps parting until it overlaps no other by more than a pair parts in a sub-step.
  void see_who_parts() noexcept {
    const auto is_deep = [&](const MetPair& pair) {
      const Point<T> apart = minus(room_.start[pair.i].x, room_.start[pair.j].x);
      const T least = of_.wanted(pair.i, pair.j) - of_.parting * std::abs(of_.h);
      return least > 0 && inner(apart, apart) < least * least;
    };
    of_.over_particles([&](std::size_t i) {
      bool parts = false;
      if (room_.parts[i] != 0) of_.over_pairs_of(i, [&](const MetPair& pair) { parts = parts || is_deep(pair); });
      room_.parts[i] = parts ? 1 : 0;
    });
  }
  void part(const Task& task) noexcept {
    over_pairs(task, [&](std::uint32_t p) {
      const MetPair pair = room_.pair(p);
      if ((room_.parts[pair.i] | room_.parts[pair.j]) == 0) return;
      room_.wanted[p] = of_.parted(room_.wanted[p], minus(room_.start[pair.i].x, room_.start[pair.j].x));
    });
  }
  // use(number) for a task's pairs, by i, then by j.
  template <class Use>
  void over_pairs(const Task& task, const Use& use) const noexcept {
    for (std::uint32_t k = task.first; k < task.first + task.near; ++k) use(room_.ordered[k] & ~pair_is_far);
  }
  static Pulse<T> scaled(T scale, const Pulse<T>& of) noexcept { return {times(scale, of.vector), scale * of.number}; }

  void take_kept(const Task& task, T scale) noexcept {
    std::uint32_t k = task.kept_first;
    const std::uint32_t kept_end = room_.is_kept ? k + task.kept : k;
    over_pairs(task, [&](std::uint32_t p) {
      const MetPair pair = room_.pair(p);
      while (k < kept_end && room_.kept_pairs[k] < pair) ++k;
      const bool is_kept = k < kept_end && room_.kept_pairs[k] == pair;
      room_.pulses[p] = is_kept ? scaled(scale, room_.kept_pulses[k]) : Pulse<T>{};
    });
  }
  void begin_wall(std::uint32_t number, std::size_t task, T scale) noexcept {
    const MetWall<T>& wall = room_.walls[number];
    const std::size_t i = wall.particle;
    const std::uint32_t* const first = room_.kept_wall_surfaces.data() + i * room_.walls_each;
    const std::uint32_t* const last = first + (room_.is_kept ? room_.kept_wall_count[i] : 0);
    const std::uint32_t* const found = std::find(first, last, wall.surface);
    const Point<T> moved = of_.moved_by_impacts(i);
    Separation<T> contact;
    contact.n = wall.n;
    contact.gap = wall.gap + inner(wall.n, moved);
    const Point<T> D = minus(plus(minus(room_.end[i].x, room_.start[i].x), moved), wall.way);
    const auto kept_at = static_cast<std::size_t>(found - room_.kept_wall_surfaces.data());
    const Pulse<T> kept = found != last ? scaled(scale, room_.kept_walls[kept_at]) : Pulse<T>{};
    room_.wall_pulse(number) = begin_contact(contact, D, kept);
    put_wall(number, {wall.particle, static_cast<std::uint32_t>(room_.nobody(task))}, contact, wall.mu);
  }
  void leave_out_wall(std::uint32_t number, std::size_t task) noexcept {
    const auto nobody = static_cast<std::uint32_t>(room_.nobody(task));
    room_.wall_pulse(number) = {};
    put_wall(number, {nobody, nobody}, {}, T(0));
  }
  void put_wall(std::uint32_t number, const MetPair& pair, const Separation<T>& contact, T mu) noexcept {
    const std::size_t lane = number % meeting_lanes;
    room_.wall_pairs[number / meeting_lanes].i[lane] = pair.i;
    room_.wall_pairs[number / meeting_lanes].j[lane] = pair.j;
    room_.wall_separations[number / meeting_lanes].put(lane, contact);
    room_.wall_mu[number] = mu;
  }

  // Puts particles with equally many pulses side by side, those with the most first. Particles without pulses get no push.
  void deal_out() noexcept {
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.summed = task.most_summed = 0;
      for (std::size_t i = from; i < end; ++i) {
        std::uint32_t count = 0;
        over_pulses(i, [&](std::size_t) { ++count; });
        room_.counts[i] = static_cast<std::uint16_t>(count);
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
    of_.over_numbered_tasks(
        [&](std::size_t number, Task& task, std::size_t from, std::size_t end) { deal_out(number, task, from, end); });
  }
  // use(place) for each pulse that a particle sums: those of partners in the order of their numbers, then those of surfaces.
  template <class Use>
  void over_pulses(std::size_t i, const Use& use) const noexcept {
    const std::uint32_t left = far_ == Far::left ? pair_is_far : 0U;
    of_.over_lower(i, [&](std::uint32_t p) {
      if ((p & left) == 0) use(room_.wanted.size() + (p & ~pair_is_far));
    });
    of_.over_own(i, [&](std::uint32_t p) {
      if ((p & left) == 0) use(std::size_t{p & ~pair_is_far});
    });
    for (std::size_t s = 0; s < of_.walls_of(i); ++s) use(2 * room_.wanted.size() + room_.first_wall[i] + s);
  }
  void deal_out(std::size_t number, Task& task, std::size_t from, std::size_t end) noexcept {
    std::uint32_t* const summed = room_.summed.data() + from;
    // begins[d]: the place of the first particle with d pulses fewer than the most.
    std::array<std::uint16_t, 2 + most_pulses> begins{};
    for (std::size_t i = from; i < end; ++i) ++begins[task.most_summed - room_.counts[i] + 1];
    for (std::size_t k = 1; k <= task.most_summed; ++k) begins[k] = static_cast<std::uint16_t>(begins[k] + begins[k - 1]);
    const std::size_t all = begins[task.most_summed];
    for (std::size_t i = from; i < end; ++i) {
      if (room_.counts[i] != 0) summed[begins[task.most_summed - room_.counts[i]]++] = static_cast<std::uint32_t>(i);
    }
    task.slices = static_cast<std::uint32_t>(tasks_of(all, meeting_lanes));
    std::uint32_t place = task.first_place;
    for (std::size_t row = 0; row < task.slices; ++row) {
      const std::uint32_t count = room_.counts[summed[row * meeting_lanes]];
      room_.slices[number * slices_per_meeting_task + row] = {place, count};
      for (std::size_t lane = row * meeting_lanes; lane < (row + 1) * meeting_lanes; ++lane) {
        std::uint32_t* at = room_.places.data() + place + lane % meeting_lanes;
        std::uint32_t* const end_of_places = at + count * meeting_lanes;
        const auto put = [&](std::size_t pulse) {
          *at = static_cast<std::uint32_t>(4 * pulse);
          at += meeting_lanes;
        };
        const bool is_one = lane < all;
        const std::size_t i = is_one ? summed[lane] : room_.nobody(number);
        if (is_one) over_pulses(i, put);
        while (at != end_of_places) put(room_.no_pulse());
        summed[lane] = static_cast<std::uint32_t>(4 * i);
        room_.summed_w[from + lane] = is_one ? room_.velocity[i].w : T(0);
      }
      place += count * static_cast<std::uint32_t>(meeting_lanes);
    }
  }

  void push_all(T beta) noexcept {
    const RoundTerms<T> of_pairs{.pairs = room_.pairs.data(),
                                 .contacts = room_.separations.data(),
                                 .pulses = room_.pulses.data(),
                                 .against = room_.against(),
                                 .pushed = room_.pushed.data(),
                                 .mu = of_.mu(),
                                 .beta = beta};
    RoundTerms<T> of_walls = of_pairs;
    of_walls.pairs = room_.wall_pairs.data();
    of_walls.contacts = room_.wall_separations.data();
    of_walls.pulses = &room_.wall_pulse(0);
    of_walls.against = nullptr;
    of_walls.mus = room_.wall_mu.data();
    of_.over_tasks([&](const Task& task, std::size_t, std::size_t) {
      of_.kernels.push(of_pairs, task.first, task.first + task.close);
      if (far_ == Far::taken) of_.kernels.push(of_pairs, task.first_far, task.first_far + task.near - task.close);
      of_.kernels.push(of_walls, task.first_wall, task.first_wall + task.walls);
    });
  }
  // Sums the pulses of each particle into its push.
  void sum_pulses() noexcept {
    const SumTerms<T> terms{.slices = room_.slices.data(),
                            .particles = room_.summed.data(),
                            .w = room_.summed_w.data(),
                            .places = room_.places.data(),
                            .pulses = room_.pulses.data(),
                            .pushed = room_.pushed.data()};
    of_.over_numbered_tasks([&](std::size_t number, Task& task, std::size_t, std::size_t) {
      const std::size_t first = number * slices_per_meeting_task;
      task.longest = double{of_.kernels.sum(terms, first, first + task.slices)};
    });
    for (const Task& task : room_.tasks) longest_ = std::max(longest_, static_cast<T>(std::sqrt(task.longest)));
  }

  void keep_pulses() noexcept {
    const T weight = of_.slowest / 4 * std::abs(of_.h);
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.kept_first = task.first;
      task.kept = task.near;
      std::uint32_t k = task.first;
      over_pairs(task, [&](std::uint32_t p) {
        const MetPair pair = room_.pair(p);
        const Separations<T>& contacts = room_.separations[p / meeting_lanes];
        room_.kept_pairs[k] = pair;
        room_.kept_pulses[k] = {};
        if (contacts.normal.data()[p % meeting_lanes] > 0) {
          const T w = room_.velocity[pair.i].w + room_.velocity[pair.j].w;
          room_.kept_pulses[k] = kept(contacts.of(p % meeting_lanes), weight / w);
        }
        ++k;
      });
      for (std::size_t i = from; i < end && room_.walls_each != 0; ++i) keep_walls(i, weight);
    });
    room_.is_kept = true;
    room_.kept_h = of_.h;
  }
  void keep_walls(std::size_t i, T weight) noexcept {
    std::uint8_t count = 0;
    for (std::size_t s = 0; s < of_.walls_of(i); ++s) {
      const std::uint32_t number = room_.first_wall[i] + static_cast<std::uint32_t>(s);
      const Separation<T> contact = room_.wall_separations[number / meeting_lanes].of(number % meeting_lanes);
      if (!(contact.normal > 0)) continue;
      const std::size_t at = i * room_.walls_each + count++;
      room_.kept_walls[at] = kept(contact, weight / room_.velocity[i].w);
      room_.kept_wall_surfaces[at] = room_.walls[number].surface;
    }
    room_.kept_wall_count[i] = count;
  }

  static constexpr std::size_t most_pulses = 255 + most_walls;  // of a particle

  const MeetSubstep<T>& of_;
  MeetRoom<T>& room_;
  Far far_ = Far::left;
  T longest_ = 0;  // m: the longest push of the sub-step
};

}  // namespace dvdx
