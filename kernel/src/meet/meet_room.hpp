// Memory for particles that meet while a state is stepped.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "contact/surfaces/surface.hpp"
#include "meet/lists.hpp"
#include "meet/meet_rules.hpp"
#include "meet/rounds.hpp"
#include "work/tasks.hpp"

namespace dvdx {

// A fixed number, so that nothing depends on threads.
inline constexpr std::size_t particles_per_meeting_task = 1024;
inline constexpr std::size_t slices_per_meeting_task = particles_per_meeting_task / meeting_lanes;

// A particle as its part sends it to the other parts of a larger scene at the end of a sub-step.
template <class T>
struct SharedParticle {
  Point<T> start{}, end{}, velocity{};  // m, m, m/s
  T w = 0;                              // 1/kg
};

// Arrays of particles are indexed by the particle's number.
template <class T>
struct MeetRoom {
  MeetRoom() = default;
  explicit MeetRoom(const MeetShape& shape)
      : particles(shape.particles),
        lists(shape.particles, shape.particles * shape.most_neighbours, most_pairs(shape)),
        start(shape.particles),
        end(shape.particles),
        velocity(shape.particles),
        hits(shape.particles),
        shift(shape.particles),
        listed(shape.particles),
        a(shape.particles),
        tasks(tasks_of(shape.particles, particles_per_meeting_task)),
        pairs(most_pairs(shape) / meeting_lanes),
        separations(pairs.size()),
        wanted(most_pairs(shape)),
        pulses(2 * wanted.size() + whole_lanes(shape.particles * shape.walls) + 1),
        ordered(wanted.size()),
        own_end(shape.particles),
        first_lower(shape.particles + 2),
        lower(wanted.size()),
        counts(shape.particles),
        slices(tasks.size() * slices_per_meeting_task),
        summed(slices.size() * meeting_lanes),
        summed_w(summed.size()),
        places(2 * wanted.size() + shape.particles * shape.walls +
               tasks.size() * meeting_lanes * (shape.most_neighbours + shape.walls)),
        pushed(shape.particles + tasks.size()),
        kept_pairs(wanted.size()),
        wall_pairs(whole_lanes(shape.particles * shape.walls) / meeting_lanes),
        wall_separations(wall_pairs.size()),
        wall_mu(wall_pairs.size() * meeting_lanes),
        walls(shape.particles * shape.walls),
        wall_count(shape.walls != 0 ? shape.particles : 0),
        first_wall(wall_count.size()),
        hit_wall(wall_count.size()),
        best(shape.particles, no_partner),
        kept_pulses(wanted.size()),
        kept_walls(walls.size()),
        kept_wall_surfaces(walls.size()),
        kept_wall_count(wall_count.size()),
        walls_each(shape.walls),
        parts(shape.has_births ? shape.particles : 0, std::uint8_t{1}),
        shared(shape.is_shared ? shape.particles : 0) {}

  [[nodiscard]] std::size_t bytes() const noexcept {
    constexpr std::size_t each = 6 * sizeof(MeetPush<T>) + sizeof(T) + 14;
    return lists.bytes() + each * start.size() + sizeof(MeetPush<T>) * pushed.size() +
           (sizeof(MetPairs) + sizeof(Separations<T>)) * (pairs.size() + wall_pairs.size()) +
           (sizeof(T) + 8 + sizeof(MetPair) + sizeof(Pulse<T>)) * wanted.size() + sizeof(Pulse<T>) * pulses.size() +
           sizeof(SumSlice) * slices.size() + (4 + sizeof(T)) * summed.size() + 4 * places.size() +
           sizeof(MeetTask) * tasks.capacity() + (sizeof(MetWall<T>) + sizeof(Pulse<T>) + 4) * walls.size() +
           sizeof(T) * wall_mu.size() + 7 * wall_count.size() + parts.size() + sizeof(SharedParticle<T>) * shared.size();
  }

  [[nodiscard]] MetParticles<T> met() const noexcept {
    return {.start = start.data(), .end = end.data(), .velocity = velocity.data(), .hits = hits.data(), .shift = shift.data()};
  }
  [[nodiscard]] MetPair pair(std::size_t p) const noexcept { return pair_at(pairs.data(), p); }
  void put_pair(std::size_t p, const MetPair& pair) noexcept {
    pairs[p / meeting_lanes].i[p % meeting_lanes] = pair.i;
    pairs[p / meeting_lanes].j[p % meeting_lanes] = pair.j;
  }
  // `pulses` holds, after those of pairs: their opposites for the higher-numbered particles, those of surfaces, and a zero.
  [[nodiscard]] Pulse<T>* against() noexcept { return pulses.data() + wanted.size(); }
  [[nodiscard]] Pulse<T>& wall_pulse(std::size_t wall) noexcept { return pulses[2 * wanted.size() + wall]; }
  [[nodiscard]] std::size_t no_pulse() const noexcept { return pulses.size() - 1; }
  // The entry of `pushed` for lanes without a particle, and for the surface of a wall: it stays zero.
  [[nodiscard]] std::size_t nobody(std::size_t task) const noexcept { return start.size() + task; }
  // use(pair, pulse) for the near pairs of the last sub-step, by i, then by j.
  template <class Use>
  void for_each_pair(const Use& use) const {
    for (const MeetTask& task : tasks) {
      const std::uint32_t end_of_kept = pair_count != 0 ? task.kept_first + task.kept : task.kept_first;
      for (std::uint32_t k = task.kept_first; k < end_of_kept; ++k) use(kept_pairs[k], kept_pulses[k]);
    }
  }
  // use(i, j, pulse) for the pulses that the next sub-step begins with.
  template <class Use>
  void for_each_kept(const Use& use) const {
    if (!is_kept) return;
    for_each_pair([&](const MetPair& pair, const Pulse<T>& pulse) {
      if (pulse.number > 0) use(std::size_t{pair.i}, pair.j, pulse);
    });
  }
  // Prepares for keep(). Pairs must come by i, then by j, no more than there is room for.
  void begin_keeping() noexcept {
    pair_count = 0;
    for (MeetTask& task : tasks) task.kept_first = task.kept = 0;
    std::fill(kept_wall_count.begin(), kept_wall_count.end(), std::uint8_t{0});
  }
  void keep(const MetPair& of, const Pulse<T>& pulse) noexcept {
    MeetTask& task = tasks[of.i / particles_per_meeting_task];
    if (task.kept == 0) task.kept_first = static_cast<std::uint32_t>(pair_count);
    ++task.kept;
    kept_pairs[pair_count] = of;
    kept_pulses[pair_count++] = pulse;
  }
  // Sets the number of particles from the next sub-step on, at most that of the constructor. New ones have the highest numbers.
  // If particles went without renumber(), kept pulses may belong to others, so a lower count drops them.
  void set_count(std::size_t count) noexcept {
    if (count == particles) return;
    if (count < particles) {
      forget();
      clear_from(count);
    }
    resize(count);
  }
  // Drops what is kept: the next sub-step is of another state.
  void forget() noexcept {
    is_kept = false;
    std::fill(parts.begin(), parts.end(), std::uint8_t{1});
  }
  // after[i]: the new number of particle i, which ascends with i, or no_partner if it has gone. `count` particles are left, and
  // all that is kept of them.
  void renumber(std::span<const std::uint32_t> after, std::size_t count) noexcept {
    const std::size_t before = pair_count;
    pair_count = 0;
    for (MeetTask& task : tasks) {
      const std::uint32_t first = task.kept_first;
      const std::uint32_t old_end = before != 0 ? first + task.kept : first;
      task.kept_first = task.kept = 0;
      for (std::uint32_t k = first; k < old_end; ++k) {
        const MetPair now{after[kept_pairs[k].i], after[kept_pairs[k].j]};
        if (now.i != no_partner && now.j != no_partner) keep(now, Pulse<T>(kept_pulses[k]));
      }
    }
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (after[i] != no_partner) move(i, after[i]);
    }
    clear_from(count);
    resize(count);
  }
  static constexpr std::size_t whole_lanes(std::size_t pairs) noexcept {
    return tasks_of(pairs, meeting_lanes) * meeting_lanes;
  }
  // Includes a partly used block after the close pairs of each task, and another after the far ones.
  static constexpr std::size_t most_pairs(const MeetShape& shape) noexcept {
    return whole_lanes(shape.particles * shape.most_neighbours / 2) +
           2 * tasks_of(shape.particles, particles_per_meeting_task) * meeting_lanes;
  }
  // The near ones of the listed pairs. Those of a task begin at the place of its first listed pair.
  [[nodiscard]] std::uint32_t* near_i() noexcept { return lists.spare().data(); }
  [[nodiscard]] std::uint32_t* near_j() noexcept { return lists.spare().data() + lists.room(); }
  // Reuses that memory for the pair number of each impact.
  [[nodiscard]] std::uint32_t* pair_of_impact() noexcept { return lists.spare().data(); }
  // The pairs that a task tests in a round of impacts. The places of sums use this memory later.
  [[nodiscard]] std::uint32_t* candidates(std::size_t task) noexcept {
    return places.data() + tasks[task].first + task * meeting_lanes;
  }
  // Turns the kept pulses with the state: turn(along) turns one vector.
  template <class Turn>
  void turn_kept(const Turn& turn) {
    for (Pulse<T>& pulse : kept_pulses) turn(pulse.vector);
    for (Pulse<T>& pulse : kept_walls) turn(pulse.vector);
  }

  struct MeetTask {
    std::uint32_t first = 0;                 // the number of its first close pair
    std::uint32_t close = 0;                 // how many there are
    std::uint32_t first_far = 0;             // the number of its first far one
    std::uint32_t near = 0;                  // its pairs of both kinds
    std::uint32_t kept_first = 0, kept = 0;  // of the sub-step before
    std::uint32_t candidates = 0;            // the number of its pairs that may be impacts
    std::uint32_t impacts = 0;               // in this round, stored in the pairs' room from `first` on
    std::uint32_t most = 0;                  // the most pairs of one particle
    std::uint32_t first_wall = 0, walls = 0;
    std::uint32_t summed = 0, most_summed = 0;  // pulses of all its particles, and the most of one particle
    std::uint32_t first_place = 0, slices = 0;
    double least_far = 0;  // m: the least gap of its far pairs
    double longest = 0;    // m^2: its longest push, squared
    bool hits_walls = false;
    bool is_stale = false;
    WaySums sums{};
    double reaches = 0;  // m: the sum of a, each cut at a bound, over listed particles
    std::uint32_t listed = 0;
  };
  std::size_t particles = 0;  // at present; at most the constructor's
  PairLists<T> lists{};
  bool is_listed = false;
  std::uint64_t listed_by = 0;  // the rules' fingerprint
  T skin = 0;                   // m: the lists' reach beyond what is near
  std::vector<MetStart<T>> start{};
  std::vector<MetEnd<T>> end{};
  std::vector<MetVelocity<T>> velocity{};
  std::vector<MetHits<T>> hits{};
  std::vector<MetShift<T>> shift{};
  std::vector<MetListed<T>> listed{};
  std::vector<T> a{};
  std::vector<MeetTask> tasks{};
  std::vector<MetPairs> pairs{};  // near ones: of each task the close ones from a block on, then the far ones from another
  std::vector<Separations<T>> separations{};
  std::vector<T> wanted{};         // m: by pairs
  std::vector<Pulse<T>> pulses{};  // of pairs, then those of against() and wall_pulse()
  // Pair numbers by i, then by j, each task's from its first on; far pairs have the bit pair_is_far.
  std::vector<std::uint32_t> ordered{};
  // By particle. own_end: where its own pairs end in `ordered`, counted from its task's first. first_lower: where in `lower`
  // the pairs begin in which its number is the higher one.
  std::vector<std::uint32_t> own_end{}, first_lower{}, lower{};
  std::vector<std::uint16_t> counts{};  // the number of pulses that each particle sums
  // Each task's particles that have pulses, by the number of pulses.
  std::vector<SumSlice> slices{};
  std::vector<std::uint32_t> summed{};
  std::vector<T> summed_w{};
  std::vector<std::uint32_t> places{};
  std::vector<MeetPush<T>> pushed{};  // by particle, then one per task for lanes without a particle
  std::vector<MetPair> kept_pairs{};  // by i, then by j
  // Walls in lanes, by their numbers. The partner is nobody.
  std::vector<MetPairs> wall_pairs{};
  std::vector<Separations<T>> wall_separations{};
  std::vector<T> wall_mu{};
  std::vector<MetWall<T>> walls{};  // each task's side by side, by particle
  std::vector<std::uint8_t> wall_count{};
  std::vector<std::uint32_t> first_wall{};
  std::vector<std::uint8_t> hit_wall{};  // in an impact round: which of a particle's walls it hits first
  std::vector<std::uint32_t> best{};     // in an impact round: a particle's first impact among its pairs
  // The pulses that the next sub-step begins with: those of pairs, and up to walls_each of each particle with surfaces. kept_h:
  // the length of the sub-step that left them.
  bool is_kept = false;
  std::vector<Pulse<T>> kept_pulses{};
  std::vector<Pulse<T>> kept_walls{};
  std::vector<std::uint32_t> kept_wall_surfaces{};
  std::vector<std::uint8_t> kept_wall_count{};
  T kept_h = 0;  // s
  std::size_t walls_each = 0;
  // Whether a particle may still be within another that it was born in; set for those yet to be born too. Empty without births.
  std::vector<std::uint8_t> parts{};
  std::vector<SharedParticle<T>> shared{};  // of a part of a larger scene, in the order in which they are sent
  std::size_t pair_count = 0;
  std::size_t most = 0;  // the most pairs of one particle
  std::uint64_t rebuilt = 0, substeps = 0;
  bool has_impacts = false;                   // in the last sub-step
  T longest = std::numeric_limits<T>::max();  // m: the longest push of the last sub-step

 private:
  void resize(std::size_t count) noexcept {
    particles = count;
    tasks.resize(tasks_of(count, particles_per_meeting_task));  // within the constructor's capacity
    lists.set_count(count);
    is_listed = false;
  }
  // Moves the values that a particle keeps between steps, and its last position, to a new number.
  void move(std::size_t from, std::size_t to) noexcept {
    end[to] = end[from];
    for (std::size_t s = 0; s < walls_each; ++s) {
      kept_walls[to * walls_each + s] = kept_walls[from * walls_each + s];
      kept_wall_surfaces[to * walls_each + s] = kept_wall_surfaces[from * walls_each + s];
    }
    if (walls_each != 0) kept_wall_count[to] = kept_wall_count[from];
    if (!parts.empty()) parts[to] = parts[from];
  }
  // Resets particles from this number on, as if they had never existed.
  void clear_from(std::size_t first) noexcept {
    for (std::size_t i = first; i < particles; ++i) {
      hits[i] = {};
      shift[i] = {};
      if (walls_each != 0) kept_wall_count[i] = 0;
      if (!parts.empty()) parts[i] = 1;
    }
  }
};

}  // namespace dvdx
