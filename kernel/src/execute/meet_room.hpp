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
      : particles(shape.particles),
        lists(shape.particles, shape.particles * shape.most_neighbours,
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
        walls_each(shape.walls),
        parts(shape.has_births ? shape.particles : 0, std::uint8_t{1}) {}

  [[nodiscard]] std::size_t bytes() const noexcept {
    return lists.bytes() + (sizeof(Point<T>) * 6 + sizeof(MeetPush<T>) + sizeof(T) * 5 + 13) * x0.size() +
           (2 * sizeof(MetPairs) + sizeof(Separations<T>)) * pairs.size() + (2 * sizeof(Pulse<T>) + 1) * pulses.size() +
           sizeof(MeetTask) * tasks.capacity() + (sizeof(MetWall<T>) + sizeof(Pulse<T>) + 4) * walls.size() +
           7 * wall_count.size() + parts.size();
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
  // From the next sub-step on there are so many particles, at most those that there is room for: new ones have the highest
  // numbers. Where some have gone by no renumber(), what is kept of pairs may be others' by now.
  void be_of(std::size_t count) noexcept {
    if (count == particles) return;
    if (count < particles) {
      forget();
      clear_from(count);
    }
    resize(count);
  }
  // The next sub-step is of another state.
  void forget() noexcept {
    is_kept = false;
    std::fill(parts.begin(), parts.end(), std::uint8_t{1});
  }
  // after[i]: the number that particle i has from now on, which ascends with i, or no_partner if it has gone. `count` are left,
  // with what is kept of them.
  void renumber(std::span<const std::uint32_t> after, std::size_t count) noexcept {
    std::uint32_t kept = 0;
    for (MeetTask& task : tasks) {
      const std::uint32_t first = task.first;
      const std::uint32_t end = pair_count != 0 ? first + task.near : first;
      task.first = task.near = 0;
      for (std::uint32_t p = first; p < end; ++p) {
        const MetPair old = pair(p);
        const MetPair now{after[old.i], after[old.j]};
        if (now.i != no_partner && now.j != no_partner) keep(kept++, now, Pulse<T>(pulses[p]));
      }
    }
    pair_count = kept;
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (after[i] != no_partner) move(i, after[i]);
    }
    clear_from(count);
    resize(count);
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
    bool has_movers = false;              // particles without mass that meet and move
    std::array<double, 3> way{}, gone{};  // m: sums
    std::uint32_t ways = 0, gones = 0;
    double reaches = 0;  // m: a sum over those that are listed
    std::uint32_t listed = 0;
  };
  std::size_t particles = 0;  // that there are
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
  // Whether a particle may still be within another that it was born in, those that are to come too. Empty where none are born.
  std::vector<std::uint8_t> parts{};
  std::size_t pair_count = 0;
  std::size_t most = 0;  // pairs of the particle that has most
  std::uint64_t rebuilt = 0, substeps = 0;
  bool has_impacts = false;  // in the last sub-step

 private:
  void resize(std::size_t count) noexcept {
    particles = count;
    tasks.resize(tasks_of(count, particles_per_meeting_task));  // within what the constructor took
    lists.be_of(count);
    is_listed = false;
  }
  // All that a step leaves of a particle to the next one, and its last place.
  void move(std::size_t from, std::size_t to) noexcept {
    x1[to] = x1[from];
    for (std::size_t s = 0; s < walls_each; ++s) {
      kept_walls[to * walls_each + s] = kept_walls[from * walls_each + s];
      kept_wall_surfaces[to * walls_each + s] = kept_wall_surfaces[from * walls_each + s];
    }
    if (walls_each != 0) kept_wall_count[to] = kept_wall_count[from];
    if (!parts.empty()) parts[to] = parts[from];
  }
  // Those from this number on are as if they had never been.
  void clear_from(std::size_t first) noexcept {
    for (std::size_t i = first; i < particles; ++i) {
      dv[i] = shift[i] = {};
      last[i] = 0;
      hit_in[i] = 0;
      if (walls_each != 0) kept_wall_count[i] = 0;
      if (!parts.empty()) parts[i] = 1;
    }
  }

  static MetPair pair_in(const std::vector<MetPairs>& pairs, std::size_t p) noexcept {
    return {pairs[p / meeting_lanes].i[p % meeting_lanes], pairs[p / meeting_lanes].j[p % meeting_lanes]};
  }
};

}  // namespace dvdx
