// Impacts of particles that meet: passes/meet/meet.hpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "execute/meet_substep.hpp"

namespace dvdx {

template <class T>
class MeetImpacts {
 public:
  explicit MeetImpacts(const MeetSubstep<T>& of) noexcept
      : of_(of), room_(of.room), rounds_in_order_(of.rules.meet().restitution > 0 ? most_rounds_in_order : 0) {}

  void bounce() noexcept {
    for (round_ = 0; round_ < rounds_in_order_ + most_impact_rounds; ++round_) {
      if (!find()) return;
      room_.has_impacts = true;
      name();
      of_.over_tasks([&](const Task& task, std::size_t, std::size_t) {
        over_impacts_of(task, [&](const MetPair& pair, std::uint32_t p) {
          const Impact<T> impact = room_.impact(p);
          const bool is_first = is_named(pair.i, p) && is_named(pair.j, p);
          if (is_first && !(waits(pair.i, impact.f) || waits(pair.j, impact.f))) hit(pair, impact);
        });
      });
      of_.over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
        if (!task.hits_walls) return;
        for (std::size_t i = from; i < end; ++i) {
          if (!names_wall(i)) continue;
          MetWall<T>& wall = of_.wall(i, room_.hit_wall[i]);
          if (!waits(i, wall.impact.f)) hit(i, wall);
        }
      });
      over_impacts([&](const MetPair& pair, std::uint32_t) { room_.best[pair.i] = room_.best[pair.j] = no_partner; });
    }
  }

 private:
  using Task = typename MeetSubstep<T>::Task;
  static constexpr std::uint8_t no_wall = std::numeric_limits<std::uint8_t>::max();
  static constexpr int most_rounds_in_order = 24;

  // The one that meets first, of these the fastest, and of these that with the lower number.
  static bool comes_before(const Impact<T>& a, const Impact<T>& b) noexcept {
    if (a.f != b.f) return a.f < b.f;
    return a.speed > b.speed;
  }
  // use(pair, its number)
  template <class Use>
  void over_impacts_of(const Task& task, const Use& use) const noexcept {
    for (std::uint32_t k = task.first; k < task.first + task.impacts; ++k)
      use(room_.pair(room_.numbers()[k]), room_.numbers()[k]);
  }
  template <class Use>
  void over_impacts(const Use& use) const noexcept {
    for (const Task& task : room_.tasks) over_impacts_of(task, use);
  }

  // Whether there is any.
  bool find() noexcept {
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.impacts = 0;
      task.hits_walls = false;
      if (round_ > 0 || task.fast != 0) find_pairs(task);
      for (std::size_t i = from; i < end && task.walls != 0; ++i) find_walls(i, task);
    });
    return std::any_of(room_.tasks.begin(), room_.tasks.end(),
                       [](const Task& task) { return task.impacts != 0 || task.hits_walls; });
  }
  void find_pairs(Task& task) noexcept {
    const MetParticles<T> particles = room_.met();
    for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
      const MetPair pair = room_.pair(p);
      PairGoes& goes = room_.goes[p];
      const int hit_in = std::max(room_.hit_in[pair.i], room_.hit_in[pair.j]);  // 0: in no round
      if (hit_in == 0 && goes == PairGoes::slowly) continue;
      if (round_ == 0 || hit_in == round_) {  // else as in the round before
        const Impact<T> impact = find_impact(pair.i, pair.j, particles, of_.wanted(pair.i, pair.j), of_.h, of_.slowest);
        goes = impact.f > 1 ? PairGoes::fast : PairGoes::into_impact;
        if (goes == PairGoes::into_impact) room_.put_impact(p, impact);
      }
      if (goes == PairGoes::into_impact) room_.numbers()[task.first + task.impacts++] = p;
    }
  }
  void find_walls(std::size_t i, Task& task) noexcept {
    room_.hit_wall[i] = no_wall;
    for (std::size_t s = 0; s < of_.walls_of(i); ++s) {
      MetWall<T>& wall = of_.wall(i, s);
      find_impact(wall, i, room_.met(), of_.h, of_.slowest);
      if (wall.impact.f > 1) continue;
      const bool is_first = room_.hit_wall[i] == no_wall || comes_before(wall.impact, of_.wall(i, room_.hit_wall[i]).impact);
      if (is_first) room_.hit_wall[i] = static_cast<std::uint8_t>(s);
      task.hits_walls = true;
    }
  }
  // Each particle's first among its pairs, which come in the order of numbers.
  void name() noexcept {
    over_impacts([&](const MetPair& pair, std::uint32_t p) {
      const Impact<T> impact = room_.impact(p);
      for (const std::uint32_t i : {pair.i, pair.j}) {
        std::uint32_t& best = room_.best[i];
        if (best == no_partner || comes_before(impact, room_.impact(best))) best = p;
      }
    });
  }
  // A wall is named where it comes before all pairs.
  [[nodiscard]] bool names_wall(std::size_t i) const noexcept {
    if (of_.walls_of(i) == 0 || room_.hit_wall[i] == no_wall) return false;
    const std::uint32_t best = room_.best[i];
    return best == no_partner || comes_before(of_.wall(i, room_.hit_wall[i]).impact, room_.impact(best));
  }
  [[nodiscard]] bool is_named(std::size_t i, std::uint32_t p) const noexcept { return room_.best[i] == p && !names_wall(i); }

  // The f of a particle's first impact.
  [[nodiscard]] T first_of(std::size_t i) const noexcept {
    if (names_wall(i)) return of_.wall(i, room_.hit_wall[i]).impact.f;
    return room_.best[i] != no_partner ? room_.impact(room_.best[i]).f : T(2);
  }
  // Whether a particle near this one is hit before, which may come in between.
  [[nodiscard]] bool waits(std::size_t i, T f) const noexcept {
    if (round_ >= rounds_in_order_) return false;
    const std::uint32_t* const lower_near = room_.lower_near().data();
    for (std::uint32_t k = room_.lists.first_lower(i); k < room_.lower_end[i]; ++k) {
      if (first_of(room_.pair(lower_near[k]).i) < f) return true;
    }
    const std::uint32_t first = room_.tasks[i / particles_per_meeting_task].first;
    const std::uint32_t own = i % particles_per_meeting_task != 0 ? room_.own_end[i - 1] : 0;
    for (std::uint32_t p = first + own; p < first + room_.own_end[i]; ++p) {
      if (first_of(room_.pair(p).j) < f) return true;
    }
    return false;
  }

  void hit(const MetPair& pair, const Impact<T>& impact) noexcept {
    const Point<T> u = minus(plus(room_.v[pair.i], room_.dv[pair.i]), plus(room_.v[pair.j], room_.dv[pair.j]));
    const Point<T> impulse =
        impulse_of(impact.n, u, room_.w[pair.i] + room_.w[pair.j], static_cast<T>(of_.rules.meet().restitution), of_.mu());
    take_impulse(pair.i, T(1), impulse, impact.f);
    take_impulse(pair.j, T(-1), impulse, impact.f);
  }
  void hit(std::size_t i, MetWall<T>& wall) noexcept {
    const Point<T> u = minus(plus(room_.v[i], room_.dv[i]), times(1 / of_.h, wall.way));
    const Point<T> impulse = impulse_of(wall.contact.n, u, room_.w[i], wall.e, wall.mu);
    wall.impulse = plus(wall.impulse, impulse);
    take_impulse(i, T(1), impulse, wall.impact.f);
  }
  void take_impulse(std::size_t i, T sign, const Point<T>& impulse, T f) noexcept {
    const Point<T> dv = times(sign * room_.w[i], impulse);
    room_.dv[i] = plus(room_.dv[i], dv);
    room_.shift[i] = minus(room_.shift[i], times(f * of_.h, dv));
    room_.last[i] = f;
    room_.hit_in[i] = static_cast<std::uint8_t>(round_ + 1);
  }

  const MeetSubstep<T>& of_;
  MeetRoom<T>& room_;
  int rounds_in_order_;  // before those in which none waits; without restitution there is no energy to keep
  int round_ = 0;
};

}  // namespace dvdx
