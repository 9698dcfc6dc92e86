// Room for particles that meet while a state is stepped.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "compile/meet.hpp"
#include "execute/tasks.hpp"
#include "passes/contact/contact.hpp"
#include "passes/meet/lists.hpp"

namespace dvdx {

// A fixed number, so that nothing depends on threads.
inline constexpr std::size_t particles_per_meeting_task = 1024;

// How a near pair goes, of those that are in no round hit; and what the last round that looked at it found.
enum class PairGoes : std::uint8_t { slowly, fast, into_impact };

// All by particles' numbers.
template <class T>
struct MeetRoom {
  MeetRoom() = default;
  explicit MeetRoom(const MeetShape& shape)
      : lists(shape.particles, shape.particles * shape.most_neighbours,
              shape.particles * shape.most_neighbours + most_pairs(shape)),
        x0(shape.particles),
        x1(shape.particles),
        v(shape.particles),
        dv(shape.particles),
        shift(shape.particles),
        listed_at(shape.particles),
        pushed(shape.particles),
        w(shape.particles),
        last(shape.particles),
        strays(shape.particles),
        allowed(shape.particles),
        a(shape.particles),
        tasks(tasks_of(shape.particles, particles_per_meeting_task)),
        pairs(most_pairs(shape) / meeting_lanes),
        separations(pairs.size()),
        pulses(pairs.size() * meeting_lanes),
        goes(pulses.size()),
        own_end(shape.particles),
        lower_end(shape.particles),
        kept_pairs(pairs.size()),
        kept_pulses(pulses.size()),
        walls(shape.particles * shape.walls),
        wall_count(shape.walls != 0 ? shape.particles : 0),
        first_wall(wall_count.size()),
        hit_wall(wall_count.size()),
        best(shape.particles, no_partner),
        hit_in(shape.particles),
        kept_walls(walls.size()),
        kept_wall_surfaces(walls.size()),
        kept_wall_count(wall_count.size()),
        walls_each(shape.walls) {}

  [[nodiscard]] std::size_t bytes() const noexcept {
    return lists.bytes() + (sizeof(Point<T>) * 6 + sizeof(MeetPush<T>) + sizeof(T) * 5 + 13) * x0.size() +
           (2 * sizeof(MetPairs) + sizeof(Separations<T>)) * pairs.size() + (2 * sizeof(Pulse<T>) + 1) * pulses.size() +
           sizeof(MeetTask) * tasks.size() + (sizeof(MetWall<T>) + sizeof(Pulse<T>) + 4) * walls.size() + 7 * wall_count.size();
  }

  [[nodiscard]] MetParticles<T> met() const noexcept {
    return {.x0 = x0.data(),
            .x1 = x1.data(),
            .v = v.data(),
            .dv = dv.data(),
            .shift = shift.data(),
            .w = w.data(),
            .last = last.data()};
  }
  [[nodiscard]] MetPair pair(std::size_t p) const noexcept { return pair_in(pairs, p); }
  void put_pair(std::size_t p, const MetPair& pair) noexcept {
    pairs[p / meeting_lanes].i[p % meeting_lanes] = pair.i;
    pairs[p / meeting_lanes].j[p % meeting_lanes] = pair.j;
  }
  // With which this sub-step begins, from a task's kept_first on.
  [[nodiscard]] MetPair kept_pair(std::size_t k) const noexcept { return pair_in(kept_pairs, k); }
  // The last sub-step's pairs are what this one begins with.
  void turn_over() noexcept {
    std::swap(pairs, kept_pairs);
    std::swap(pulses, kept_pulses);
  }
  // use(i, j, pulse), by i, then by j: those from which the next sub-step goes on.
  template <class Use>
  void for_each_kept(const Use& use) const {
    if (!is_kept) return;
    for (const MeetTask& task : tasks) {
      for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
        if (pulses[p].number > 0) use(std::size_t{pair(p).i}, pair(p).j, pulses[p]);
      }
    }
  }
  // Pairs come by i, then by j, and take no more than their room.
  void begin_keeping() noexcept {
    pair_count = 0;
    for (MeetTask& task : tasks) task.first = task.near = 0;
    std::fill(kept_wall_count.begin(), kept_wall_count.end(), std::uint8_t{0});
  }
  void keep(std::size_t k, const MetPair& of, const Pulse<T>& pulse) noexcept {
    MeetTask& task = tasks[of.i / particles_per_meeting_task];
    if (task.near == 0) task.first = static_cast<std::uint32_t>(k);
    ++task.near;
    put_pair(k, of);
    pulses[k] = pulse;
  }
  // An impact stands where the separation of its pair will.
  [[nodiscard]] Impact<T> impact(std::size_t p) const noexcept {
    const Separation<T> of = separations[p / meeting_lanes].of(p % meeting_lanes);
    return {of.n, of.gap, of.normal};
  }
  void put_impact(std::size_t p, const Impact<T>& impact) noexcept {
    Separation<T> of;
    of.n = impact.n;
    of.gap = impact.f;
    of.normal = impact.speed;
    separations[p / meeting_lanes].put(p % meeting_lanes, of);
  }
  static constexpr std::size_t whole_lanes(std::size_t pairs) noexcept {
    return tasks_of(pairs, meeting_lanes) * meeting_lanes;
  }
  // Each task's pairs begin a block, and leave a place.
  static constexpr std::size_t most_pairs(const MeetShape& shape) noexcept {
    return whole_lanes(shape.particles * shape.most_neighbours / 2) +
           tasks_of(shape.particles, particles_per_meeting_task) * meeting_lanes;
  }
  // In a sub-step, by places in lists: the numbers of near pairs; then of impacts, each task's from its first on.
  [[nodiscard]] std::span<std::uint32_t> numbers() noexcept {
    return lists.spare().last(std::max(lists.room(), pulses.size()));
  }
  // The numbers of near pairs, by their higher particle, then by the other.
  [[nodiscard]] std::span<std::uint32_t> lower_near() noexcept { return lists.spare().first(lists.room()); }
  // use(pair): near ones of the last sub-step.
  template <class Use>
  void for_each_pair(const Use& use) const {
    for (const MeetTask& task : tasks) {
      for (std::uint32_t p = task.first; pair_count != 0 && p < task.first + task.near; ++p) use(pair(p));
    }
  }

  // turn(along): as a state turns.
  template <class Turn>
  void turn_kept(const Turn& turn) {
    for (Pulse<T>& pulse : pulses) turn(pulse.vector);
    for (Pulse<T>& pulse : kept_walls) turn(pulse.vector);
  }

  struct MeetTask {
    std::uint32_t first = 0;                 // the number of its first pair
    std::uint32_t near = 0;                  // its pairs
    std::uint32_t kept_first = 0, kept = 0;  // in the sub-step before
    std::uint32_t fast = 0;                  // those of them that may be impacts
    std::uint32_t impacts = 0;               // in this round, in the pairs' room from the first on
    std::uint32_t most = 0;                  // pairs of a particle
    std::uint32_t first_wall = 0, walls = 0;
    bool hits_walls = false;
    bool is_stale = false;
    bool has_movers = false;  // particles without mass that meet and move
    std::array<double, 3> way{}, gone{};  // m: sums
    std::uint32_t ways = 0, gones = 0;
  };
  PairLists<T> lists{};
  bool is_listed = false;
  std::uint64_t listed_by = 0;  // the rules' fingerprint
  T skin = 0;                   // m: that the lists have beyond what is near
  std::vector<Point<T>> x0{}, x1{}, v{}, dv{}, shift{};
  std::vector<Point<T>> listed_at{};  // where each was when the lists were built
  std::vector<MeetPush<T>> pushed{};
  std::vector<T> w{}, last{};
  std::vector<T> strays{};   // m: how far each goes in this sub-step beside what all do
  std::vector<T> allowed{};  // m: the strays that the lists allow for
  std::vector<T> a{};
  std::vector<MeetTask> tasks{};
  std::vector<MetPairs> pairs{};  // near ones, by i, then by j; those of each task from a block on
  std::vector<Separations<T>> separations{};
  std::vector<Pulse<T>> pulses{};  // of each pair; between sub-steps those that are kept
  std::vector<PairGoes> goes{};
  // By particle: where its own pairs end, counted from its task's first, and where those end in which its number is the
  // higher one. These begin in lower_near where the list of them does.
  std::vector<std::uint32_t> own_end{}, lower_end{};
  std::vector<MetPairs> kept_pairs{};
  std::vector<Pulse<T>> kept_pulses{};
  std::vector<MetWall<T>> walls{};  // each task's beside each other, by particles
  std::vector<std::uint8_t> wall_count{};
  std::vector<std::uint32_t> first_wall{};
  std::vector<std::uint8_t> hit_wall{};  // of an impact round: which of a particle's
  std::vector<std::uint32_t> best{};     // of an impact round
  std::vector<std::uint8_t> hit_in{};    // the last round of this sub-step in which an impact hit it, from 1; 0: none
  // With which the next sub-step begins, the last one having been kept_h long: those of pairs, and walls_each of each
  // particle with surfaces.
  bool is_kept = false;
  std::vector<Pulse<T>> kept_walls{};
  std::vector<std::uint32_t> kept_wall_surfaces{};
  std::vector<std::uint8_t> kept_wall_count{};
  T kept_h = 0;  // s
  std::size_t walls_each = 0;
  std::size_t pair_count = 0;
  std::size_t most = 0;  // pairs of the particle that has most
  std::uint64_t rebuilt = 0, substeps = 0;
  bool has_impacts = false;  // in the last sub-step

 private:
  static MetPair pair_in(const std::vector<MetPairs>& pairs, std::size_t p) noexcept {
    return {pairs[p / meeting_lanes].i[p % meeting_lanes], pairs[p / meeting_lanes].j[p % meeting_lanes]};
  }
};

}  // namespace dvdx
