// Room for particles that meet while a state is stepped.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "compile/meet.hpp"
#include "execute/tasks.hpp"
#include "passes/contact/contact.hpp"
#include "passes/meet/lists.hpp"

namespace dvdx {

// A fixed number, so that nothing depends on threads.
inline constexpr std::size_t particles_per_meeting_task = 1024;

// How far a particle is pushed in a round, m, and 1/kg by all pulses that act on it.
template <class T>
struct MeetPush {
  Point<T> dx{};
  T w = 0;
};

// All by particles' numbers. A pair has one place from one list to the next, and there what it keeps from sub-step to sub-step.
template <class T>
struct MeetRoom {
  MeetRoom() = default;
  explicit MeetRoom(const MeetShape& shape)
      : lists(shape.particles, shape.particles * shape.most_neighbours),
        is_near(lists.room()),
        pulses(lists.room()),
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
        pairs(whole_lanes(shape.particles * shape.most_neighbours / 2) + tasks.size() * meeting_lanes),
        separations(pairs.size() / meeting_lanes),
        walls(shape.particles * shape.walls),
        wall_count(shape.walls != 0 ? shape.particles : 0),
        hit_wall(wall_count.size()),
        best(shape.particles, no_partner),
        is_hit(shape.particles),
        kept_walls(walls.size()),
        kept_wall_surfaces(walls.size()),
        kept_wall_count(wall_count.size()),
        walls_each(shape.walls) {}

  [[nodiscard]] std::size_t bytes() const noexcept {
    return lists.bytes() + is_near.size() + sizeof(Pulse<T>) * pulses.size() +
           (sizeof(Point<T>) * 6 + sizeof(MeetPush<T>) + sizeof(T) * 5 + 5) * x0.size() + sizeof(MetPair) * pairs.size() +
           sizeof(Separations<T>) * separations.size() + sizeof(MeetTask) * tasks.size() +
           (sizeof(MetWall<T>) + sizeof(Pulse<T>) + 4) * walls.size() + 3 * wall_count.size();
  }

  // use(i, j, pulse), by i, then by j: those from which the next sub-step goes on.
  template <class Use>
  void for_each_kept(const Use& use) const {
    for (std::size_t k = 0; keeps == Keeps::by_pairs && k < kept_count; ++k) {
      use(std::size_t{pairs[k].i}, pairs[k].j, kept_by_pair(k));
    }
    for (std::size_t i = 0; keeps == Keeps::in_places && i < w.size(); ++i) {
      for (std::size_t place = lists.first(i); place < lists.first(i + 1); ++place) {
        if (pulses[place].number > 0) use(i, lists.partner(place), pulses[place]);
      }
    }
  }

  // Beside pairs[k].
  [[nodiscard]] Pulse<T> kept_by_pair(std::size_t k) const noexcept {
    const Separation<T> of = separations[k / meeting_lanes].of(k % meeting_lanes);
    return {of.along, of.normal};
  }
  void keep_by_pair(std::size_t k, const Pulse<T>& pulse) noexcept {
    Separation<T> of;
    of.along = pulse.vector;
    of.normal = pulse.number;
    separations[k / meeting_lanes].put(k % meeting_lanes, of);
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
  // use(pair): near ones of the last sub-step.
  template <class Use>
  void for_each_pair(const Use& use) const {
    for (const MeetTask& task : tasks) {
      for (std::uint32_t p = task.first; pair_count != 0 && p < task.first + task.near; ++p) use(pairs[p]);
    }
  }

  // turn(along): as a state turns.
  template <class Turn>
  void turn_kept(const Turn& turn) {
    for (std::size_t k = 0; keeps == Keeps::by_pairs && k < kept_count; ++k) {
      Pulse<T> pulse = kept_by_pair(k);
      turn(pulse.vector);
      keep_by_pair(k, pulse);
    }
    for (Pulse<T>& pulse : pulses) turn(pulse.vector);
    for (Pulse<T>& pulse : kept_walls) turn(pulse.vector);
  }

  struct MeetTask {
    std::uint32_t first = 0;    // the number of its first pair
    std::uint32_t near = 0;     // its pairs
    std::uint32_t fast = 0;     // those of them that may be impacts
    std::uint32_t impacts = 0;  // in this round, in the pairs' room from the first on
    std::uint32_t most = 0;     // pairs of a particle
    bool hits_walls = false;
    bool is_stale = false;
    std::array<double, 3> way{}, gone{};  // m: sums
    std::uint32_t ways = 0, gones = 0;
  };
  enum class Near : std::uint8_t { no, yes, fast };
  enum class Keeps { nothing, in_places, by_pairs };

  PairLists<T> lists{};
  bool is_listed = false;
  T skin = 0;                      // m: that the lists have beyond what is near
  std::vector<Near> is_near{};     // of the lists, in this sub-step
  std::vector<Pulse<T>> pulses{};  // of the lists
  std::vector<Point<T>> x0{}, x1{}, v{}, dv{}, shift{};
  std::vector<Point<T>> listed_at{};  // where each was when the lists were built
  std::vector<MeetPush<T>> pushed{};
  std::vector<T> w{}, last{};
  std::vector<T> strays{};   // m: how far each goes in this sub-step beside what all do
  std::vector<T> allowed{};  // m: the strays that the lists allow for
  std::vector<T> a{};
  std::vector<MeetTask> tasks{};
  std::vector<MetPair> pairs{};  // by i, then by j; those of each task from a whole number of lanes on
  std::vector<Separations<T>> separations{};
  std::vector<MetWall<T>> walls{};  // walls_each for each particle
  std::vector<std::uint8_t> wall_count{};
  std::vector<std::uint8_t> hit_wall{};  // of an impact round: which of a particle's
  std::vector<std::uint32_t> best{};     // of an impact round
  std::vector<std::uint8_t> is_hit{};    // by any impact of this sub-step
  // With which the next sub-step begins, the last one having been kept_h long: those of pairs, and walls_each of each
  // particle with surfaces.
  Keeps keeps = Keeps::nothing;
  std::size_t kept_count = 0;  // by pairs
  std::vector<Pulse<T>> kept_walls{};
  std::vector<std::uint32_t> kept_wall_surfaces{};
  std::vector<std::uint8_t> kept_wall_count{};
  T kept_h = 0;  // s
  std::size_t walls_each = 0;
  std::size_t pair_count = 0;
  std::size_t most = 0;  // pairs of the particle that has most
  std::uint64_t rebuilt = 0, substeps = 0;
  bool has_impacts = false;  // in the last sub-step
};

}  // namespace dvdx
