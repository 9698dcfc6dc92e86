// Impacts of particles that meet: meet/meet.hpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "meet/meet_substep.hpp"

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
        over_impacts_of(task, [&](const MetPair& pair, std::uint32_t k) {
          const Impact<T> impact = this->impact(k);
          const bool is_first = is_named(pair.i, k) && is_named(pair.j, k);
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

  [[nodiscard]] Impact<T> impact(std::uint32_t k) const noexcept { return impact_at(room_.separations.data(), k); }
  [[nodiscard]] MetPair pair_of(std::uint32_t k) const noexcept { return room_.pair(room_.pair_of_impact()[k]); }

  // Order of impacts: the one that meets first, then the faster, then the one with the lower number.
  static bool comes_before(const Impact<T>& a, const Impact<T>& b) noexcept {
    if (a.f != b.f) return a.f < b.f;
    return a.speed > b.speed;
  }
  [[nodiscard]] bool comes_before(std::uint32_t a, std::uint32_t b) const noexcept {
    const Impact<T> first = impact(a), second = impact(b);
    if (first.f != second.f || first.speed != second.speed) return comes_before(first, second);
    return pair_of(a) < pair_of(b);
  }
  // use(pair, the impact's number)
  template <class Use>
  void over_impacts_of(const Task& task, const Use& use) const noexcept {
    for (std::uint32_t k = task.first; k < task.first + task.impacts; ++k) use(pair_of(k), k);
  }
  template <class Use>
  void over_impacts(const Use& use) const noexcept {
    for (const Task& task : room_.tasks) over_impacts_of(task, use);
  }

  // Finds the impacts of this round. Returns true if there are any.
  bool find() noexcept {
    const ImpactTerms<T> terms{.pairs = room_.pairs.data(),
                               .wanted = room_.wanted.data(),
                               .particles = room_.met(),
                               .h = of_.h,
                               .slowest = of_.slowest,
                               .found = room_.separations.data(),
                               .pair_of = room_.pair_of_impact()};
    of_.over_numbered_tasks([&](std::size_t number, Task& task, std::size_t from, std::size_t end) {
      find_pairs(terms, task, room_.candidates(number));
      task.hits_walls = false;
      for (std::size_t i = from; i < end && task.walls != 0; ++i) find_walls(i, task);
    });
    return std::any_of(room_.tasks.begin(), room_.tasks.end(),
                       [](const Task& task) { return task.impacts != 0 || task.hits_walls; });
  }
  // Searches pairs again if one of their particles was hit in the round before. The other impacts stay as they were.
  void find_pairs(const ImpactTerms<T>& terms, Task& task, std::uint32_t* candidates) noexcept {
    std::uint32_t end = task.first;
    if (round_ > 0) {
      const auto before = static_cast<T>(round_);
      for (std::uint32_t k = task.first; k < task.first + task.impacts; ++k) {
        const MetPair pair = pair_of(k);
        if (std::max(room_.shift[pair.i].round, room_.shift[pair.j].round) == before) continue;
        put_impact(room_.separations.data(), end, impact(k));
        room_.pair_of_impact()[end++] = room_.pair_of_impact()[k];
      }
      task.candidates = static_cast<std::uint32_t>(
          of_.kernels.find_hit(terms, task.first, task.first_far + task.near - task.close, before, candidates));
    }
    task.impacts = static_cast<std::uint32_t>(of_.kernels.find_impacts(terms, candidates, task.candidates, end)) - task.first;
  }
  void find_walls(std::size_t i, Task& task) noexcept {
    if (round_ > 0 && room_.shift[i].round != static_cast<T>(round_)) {  // as in the round before
      task.hits_walls = task.hits_walls || room_.hit_wall[i] != no_wall;
      return;
    }
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
  // Finds the first impact of each particle among its pairs.
  void name() noexcept {
    over_impacts([&](const MetPair& pair, std::uint32_t k) {
      for (const std::uint32_t i : {pair.i, pair.j}) {
        std::uint32_t& best = room_.best[i];
        if (best == no_partner || comes_before(k, best)) best = k;
      }
    });
  }
  // A particle names a wall if the wall's impact comes before those of all its pairs.
  [[nodiscard]] bool names_wall(std::size_t i) const noexcept {
    if (of_.walls_of(i) == 0 || room_.hit_wall[i] == no_wall) return false;
    const std::uint32_t best = room_.best[i];
    return best == no_partner || comes_before(of_.wall(i, room_.hit_wall[i]).impact, impact(best));
  }
  [[nodiscard]] bool is_named(std::size_t i, std::uint32_t k) const noexcept { return room_.best[i] == k && !names_wall(i); }

  // The f of a particle's first impact.
  [[nodiscard]] T first_of(std::size_t i) const noexcept {
    if (names_wall(i)) return of_.wall(i, room_.hit_wall[i]).impact.f;
    return room_.best[i] != no_partner ? impact(room_.best[i]).f : T(2);
  }
  // Returns true if a particle near this one is hit before f, and so may come in between.
  [[nodiscard]] bool waits(std::size_t i, T f) const noexcept {
    if (round_ >= rounds_in_order_) return false;
    bool waits = false;
    of_.over_pairs_of(i, [&](const MetPair& pair) { waits = waits || first_of(pair.i == i ? pair.j : pair.i) < f; });
    return waits;
  }

  void hit(const MetPair& pair, const Impact<T>& impact) noexcept {
    const Point<T> u = minus(velocity_of(pair.i), velocity_of(pair.j));
    const Point<T> impulse = impulse_of(impact.n, u, room_.velocity[pair.i].w + room_.velocity[pair.j].w,
                                        static_cast<T>(of_.rules.meet().restitution), of_.mu());
    take_impulse(pair.i, T(1), impulse, impact.f);
    take_impulse(pair.j, T(-1), impulse, impact.f);
  }
  void hit(std::size_t i, MetWall<T>& wall) noexcept {
    const Point<T> u = minus(velocity_of(i), times(1 / of_.h, wall.way));
    const Point<T> impulse = impulse_of(wall.n, u, room_.velocity[i].w, wall.e, wall.mu);
    wall.impulse = plus(wall.impulse, impulse);
    take_impulse(i, T(1), impulse, wall.impact.f);
  }
  [[nodiscard]] Point<T> velocity_of(std::size_t i) const noexcept { return plus(room_.velocity[i].v, room_.hits[i].dv); }
  void take_impulse(std::size_t i, T sign, const Point<T>& impulse, T f) noexcept {
    const Point<T> dv = times(sign * room_.velocity[i].w, impulse);
    room_.hits[i] = {plus(room_.hits[i].dv, dv), f};
    room_.shift[i] = {minus(room_.shift[i].dx, times(f * of_.h, dv)), static_cast<T>(round_ + 1)};
  }

  const MeetSubstep<T>& of_;
  MeetRoom<T>& room_;
  int rounds_in_order_;  // rounds in which impacts wait; 0 without restitution, where there is no energy to keep
  int round_ = 0;
};

}  // namespace dvdx
