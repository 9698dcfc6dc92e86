// Particles that meet and are stepped by several parts. Each part sends its own particles, and computes the meetings of all.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "meet/meet_room.hpp"
#include "springs/network.hpp"
#include "topology/particle_order.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
class MeetShare {
 public:
  MeetShare(const PartContext& elsewhere, const ParticleOrder& order, MeetRoom<T>& room, const WorkColumns<T>& work) noexcept
      : all_(elsewhere.meetings), is_own_(elsewhere.exchange.is_own), order_(order), room_(room), work_(work) {}

  // Whether the plan is one of several parts.
  [[nodiscard]] bool is_there() const noexcept { return all_.whole != nullptr; }
  [[nodiscard]] std::size_t particles() const noexcept { return all_.told.size(); }

  // Called when a sub-step begins.
  void begin_driven_paths() const noexcept {
    over_own([&](std::size_t k, SharedParticle<T>& shared) { shared.start = at(work_.x, k); });
  }
  // Called when its flows have ended: sends the own particles, and receives all of them into the room.
  void exchange(const std::vector<T>& radii, const ParallelFor& parallel) const noexcept {
    over_own([&](std::size_t k, SharedParticle<T>& shared) {
      shared.end = at(work_.x, k);
      shared.velocity = at(work_.v, k);
      shared.w = work_.w[order_.of[k]];
    });
    all_.tell(all_.context, static_cast<std::byte*>(static_cast<void*>(room_.shared.data())), sizeof(SharedParticle<T>));
    over_tasks(parallel, particles(), [&](std::size_t t) {
      const SharedParticle<T>& shared = room_.shared[t];
      const std::uint32_t i = all_.told[t];
      room_.start[i] = {shared.start, radii[i]};
      room_.end[i].x = shared.end;
      room_.velocity[i] = {shared.velocity, shared.w};
    });
  }
  // Copies from the room back to the part's particles, those in its halo too.
  void put_back(const ParallelFor& parallel) const noexcept {
    over_tasks(parallel, all_.numbers.size(), [&](std::size_t k) {
      const std::uint32_t i = all_.numbers[k];
      if (!(room_.velocity[i].w > 0)) return;
      const std::size_t element = order_.of[k];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work_.x[axis][element] = room_.end[i].x[axis];
        work_.v[axis][element] = room_.velocity[i].v[axis];
      }
    });
  }
  // use(number) for the part's own particles.
  template <class Use>
  void over_own_numbers(const Use& use) const noexcept {
    for (std::size_t k = 0; k < all_.numbers.size(); ++k) {
      if (is_own(k)) use(std::size_t{all_.numbers[k]});
    }
  }

 private:
  [[nodiscard]] bool is_own(std::size_t k) const noexcept { return is_own_ == nullptr || is_own_[k] != 0; }
  template <class Use>
  void over_own(const Use& use) const noexcept {
    std::size_t next = all_.first;
    for (std::size_t k = 0; k < all_.numbers.size(); ++k) {
      if (is_own(k)) use(k, room_.shared[next++]);
    }
  }
  template <class Use>
  static void over_tasks(const ParallelFor& parallel, std::size_t count, const Use& use) noexcept {
    for_each_task(parallel, tasks_of(count, particles_per_meeting_task), [&](std::size_t task) {
      const std::size_t end = std::min(count, (task + 1) * particles_per_meeting_task);
      for (std::size_t k = task * particles_per_meeting_task; k < end; ++k) use(k);
    });
  }
  [[nodiscard]] Point<T> at(const std::array<T*, 3>& columns, std::size_t k) const noexcept {
    const std::size_t element = order_.of[k];
    return {columns[0][element], columns[1][element], columns[2][element]};
  }

  const SharedMeetings& all_;
  const std::uint8_t* is_own_;
  const ParticleOrder& order_;
  MeetRoom<T>& room_;
  const WorkColumns<T>& work_;
};

}  // namespace dvdx
