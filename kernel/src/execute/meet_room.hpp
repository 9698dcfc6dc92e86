// Room for particles that meet while a state is stepped.
#pragma once

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

// All by particles' numbers.
template <class T>
struct MeetRoom {
  MeetRoom() = default;
  explicit MeetRoom(const MeetShape& shape)
      : lists(shape.particles, shape.particles * shape.most_neighbours),
        is_near(shape.particles * shape.most_neighbours),
        x0(shape.particles),
        x1(shape.particles),
        v(shape.particles),
        dv(shape.particles),
        shift(shape.particles),
        dx(shape.particles),
        listed_at(shape.particles),
        w(shape.particles),
        k(shape.particles),
        last(shape.particles),
        strays(shape.particles),
        allowed(shape.particles),
        a(shape.particles),
        pairs(shape.particles * shape.most_neighbours / 2),
        own(shape.particles + 1),
        others(shape.particles + 1),
        other(pairs.size()),
        walls(shape.particles * shape.walls),
        wall_count(shape.walls != 0 ? shape.particles : 0),
        best(shape.particles),
        has_impacts(tasks_of(shape.particles, particles_per_meeting_task)),
        kept(pairs.size()),
        kept_first(shape.particles + 1),
        kept_walls(walls.size()),
        kept_wall_count(wall_count.size()),
        walls_each(shape.walls) {}

  [[nodiscard]] std::size_t bytes() const noexcept {
    return lists.bytes() + is_near.size() + sizeof(Point<T>) * 7 * x0.size() + sizeof(T) * 6 * w.size() +
           sizeof(MetPair<T>) * (pairs.size() + walls.size()) + 4 * (own.size() + others.size() + other.size() + best.size()) +
           2 * wall_count.size() + has_impacts.size() + sizeof(KeptPulse<T>) * (kept.size() + kept_walls.size()) +
           4 * kept_first.size();
  }

  PairLists<T> lists{};
  bool is_listed = false;
  T skin = 0;                           // m: that the lists have beyond what is near
  std::vector<std::uint8_t> is_near{};  // of the lists, in this sub-step
  std::vector<Point<T>> x0{}, x1{}, v{}, dv{}, shift{}, dx{};
  std::vector<Point<T>> listed_at{};  // where each was when the lists were built
  std::vector<T> w{}, k{}, last{};
  std::vector<T> strays{};   // m: how far each goes in this sub-step beside what all do
  std::vector<T> allowed{};  // m: the strays that the lists allow for
  std::vector<T> a{};
  std::vector<MetPair<T>> pairs{};             // by i, then by j
  std::vector<std::uint32_t> own{}, others{};  // where those of each particle begin, with higher and with lower partners
  std::vector<std::uint32_t> other{};          // numbers of those with lower partners
  std::vector<MetPair<T>> walls{};             // walls_each for each particle
  std::vector<std::uint8_t> wall_count{};
  std::vector<std::uint32_t> best{};        // of an impact round
  std::vector<std::uint8_t> has_impacts{};  // of each task
  // The pulses of the sub-step before, of h_kept: of pairs by i, then by j, and walls_each of each particle with surfaces.
  std::vector<KeptPulse<T>> kept{};
  std::vector<std::uint32_t> kept_first{};
  std::vector<KeptPulse<T>> kept_walls{};
  std::vector<std::uint8_t> kept_wall_count{};
  T kept_h = 0;  // s; 0: nothing is kept
  std::size_t walls_each = 0;
  std::size_t pair_count = 0;
  std::size_t most = 0;  // pairs of the particle that has most
  std::uint64_t rebuilt = 0, substeps = 0;
};

}  // namespace dvdx
