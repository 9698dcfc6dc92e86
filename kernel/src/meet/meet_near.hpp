// The pairs and surfaces that may meet in a sub-step. Both depend on this sub-step alone.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "meet/meet_substep.hpp"
#include "meet/surface.hpp"

namespace dvdx {

template <class T>
class MeetNear {
 public:
  explicit MeetNear(const MeetSubstep<T>& of) noexcept : of_(of), room_(of.room) {}

  enum class Found { all, too_many };
  // Fills the room's pairs from the lists, and the places of each particle's pairs.
  Found find() noexcept {
    find_pairs();
    const bool have_room = number_tasks();
    room_.most = 0;
    if (room_.pair_count == 0 && of_.rules.are_balls_alike()) return Found::all;  // the flows keep equal particles off surfaces
    count_pairs();
    for (const Task& task : room_.tasks) room_.most = std::max<std::size_t>(room_.most, task.most);
    if (!have_room || room_.most > static_cast<std::size_t>(of_.rules.meet().most_neighbours)) {
      room_.pair_count = 0;
      room_.is_kept = false;
      return Found::too_many;
    }
    put_pairs();
    find_lower();
    find_surfaces();
    return Found::all;
  }

 private:
  using Task = typename MeetSubstep<T>::Task;

  void find_pairs() noexcept {
    const WithinTerms<T> terms{.owners = room_.lists.owners(),
                               .partners = room_.lists.partners(),
                               .particles = room_.met(),
                               .wanted = of_.rules.wanted_by(),
                               .widest = 2 * of_.rules.most_radius(),
                               .margin = of_.margin(),
                               .most = of_.rules.least_radius(),
                               .far = of_.far(),
                               .slowest = of_.slowest,
                               .i = room_.near_i(),
                               .j = room_.near_j()};
    of_.over_numbered_tasks([&](std::size_t number, Task& task, std::size_t from, std::size_t end) {
      task.near = static_cast<std::uint32_t>(of_.kernels.find_within(terms, room_.lists.first(from), room_.lists.first(end)));
      task.close = 0;
      std::fill(room_.own_end.data() + from, room_.own_end.data() + end, 0U);
      over_near(number, [&](std::uint32_t, std::uint32_t i, std::uint32_t j) {
        task.close += (j & pair_is_far) == 0 ? 1U : 0U;
        ++room_.own_end[i & ~pair_goes_fast];
      });
    });
  }
  // Numbers the pairs: each task's close pairs begin a block, and so do its far ones.
  bool number_tasks() noexcept {
    std::size_t first = 0;
    room_.pair_count = 0;
    for (Task& task : room_.tasks) {
      task.first = static_cast<std::uint32_t>(first);
      first += MeetRoom<T>::whole_lanes(task.close);
      task.first_far = static_cast<std::uint32_t>(first);
      first += MeetRoom<T>::whole_lanes(task.near - task.close);
      room_.pair_count += task.near;
    }
    return first <= room_.wanted.size();  // false only if a particle has too many
  }
  // use(k, i, j) for the near pairs of a task, as the pass gives them.
  template <class Use>
  void over_near(std::size_t task, const Use& use) const noexcept {
    const std::size_t place = room_.lists.first(task * particles_per_meeting_task);
    const std::uint32_t* const i = room_.near_i() + place;
    const std::uint32_t* const j = room_.near_j() + place;
    for (std::uint32_t k = 0; k < room_.tasks[task].near; ++k) use(k, i[k], j[k]);
  }
  // Until find_lower() deals out places, first_lower[j + 2] is the number of pairs in which j is the higher one.
  void count_pairs() noexcept {
    std::fill_n(room_.first_lower.begin(), room_.particles + 2, 0U);
    for (std::size_t task = 0; task < room_.tasks.size(); ++task) {
      over_near(task, [&](std::uint32_t, std::uint32_t, std::uint32_t j) { ++room_.first_lower[(j & ~pair_is_far) + 2]; });
    }
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.most = 0;
      std::uint32_t own = 0;
      for (std::size_t i = from; i < end; ++i) {
        task.most = std::max(task.most, room_.own_end[i] + room_.first_lower[i + 2]);
        room_.own_end[i] = own += room_.own_end[i];
      }
    });
  }
  void put_pairs() noexcept {
    of_.over_numbered_tasks([&](std::size_t number, Task& task, std::size_t, std::size_t) {
      std::uint32_t* const candidates = room_.candidates(number);
      task.candidates = 0;
      std::array<std::uint32_t, 2> next{task.first, task.first_far};
      over_near(number, [&](std::uint32_t k, std::uint32_t i, std::uint32_t j) {
        const std::uint32_t far = j & pair_is_far;
        const std::uint32_t p = next[far != 0 ? 1 : 0]++;
        const MetPair pair{i & ~pair_goes_fast, j & ~pair_is_far};
        room_.ordered[task.first + k] = p | far;
        room_.put_pair(p, pair);
        room_.wanted[p] = of_.wanted(pair.i, pair.j);
        candidates[task.candidates] = p;
        task.candidates += i != pair.i ? 1U : 0U;
      });
      for (std::uint32_t p : next) {
        for (; p % meeting_lanes != 0; ++p) {
          room_.put_pair(p, {.i = 0, .j = 0});
          room_.wanted[p] = 0;
          room_.pulses[p] = {};
        }
      }
    });
  }
  // While places are dealt out, first_lower[j + 1] moves from the beginning of j's pairs to their end.
  void find_lower() noexcept {
    std::uint32_t before = 0;
    for (std::size_t j = 0; j < room_.particles; ++j) room_.first_lower[j + 2] = before += room_.first_lower[j + 2];
    for (std::size_t number = 0; number < room_.tasks.size(); ++number) {
      over_near(number, [&](std::uint32_t k, std::uint32_t, std::uint32_t j) {
        room_.lower[room_.first_lower[(j & ~pair_is_far) + 1]++] = room_.ordered[room_.tasks[number].first + k];
      });
    }
  }
  void find_surfaces() noexcept {
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.first_wall = static_cast<std::uint32_t>(from * room_.walls_each);
      task.walls = 0;
      std::uint32_t own = 0;
      for (std::size_t i = from; i < end && room_.walls_each != 0; ++i) {
        const bool has_pairs = room_.own_end[i] != own || room_.first_lower[i + 1] != room_.first_lower[i];
        own = room_.own_end[i];
        room_.first_wall[i] = task.first_wall + task.walls;
        find_walls(i, has_pairs);
        task.walls += room_.wall_count[i];
      }
    });
  }

  // Finds the surfaces near a particle if pairs may push it, or if its radius is more than flows keep it off by.
  void find_walls(std::size_t i, bool has_pairs) noexcept {
    room_.wall_count[i] = 0;
    const T more = of_.rules.off_surfaces(i);
    if (!(room_.velocity[i].w > 0) || !(has_pairs || more > 0)) return;
    const T reach = more + (of_.margin() + room_.end[i].strays);
    const Point<T>& x = room_.end[i].x;
    for (std::size_t s = 0; s < of_.surface_count; ++s) {
      const Surface<T>& surface = of_.surfaces[s];
      if (surface.shape == Shape::plane && !(inner(surface.n, x) - surface.d < reach)) continue;
      const Off<T> off = off_surface(surface, x);
      if (!(off.distance < reach)) continue;
      MetWall<T> found;
      found.particle = static_cast<std::uint32_t>(i);
      found.surface = static_cast<std::uint32_t>(s);
      found.n = off.n;
      found.gap = off.distance - more;
      found.mu = surface.mu;
      found.e = surface.e;
      found.way = times(of_.h, velocity_of(surface, x));
      found.start = found.gap - inner(off.n, minus(minus(x, room_.start[i].x), found.way));
      keep(i, found);
    }
  }
  // Keeps the deepest surfaces, in the order of the surfaces.
  void keep(std::size_t i, const MetWall<T>& found) noexcept {
    std::size_t count = room_.wall_count[i];
    if (count == room_.walls_each) {
      std::size_t least = 0;
      for (std::size_t s = 1; s < count; ++s) {
        if (of_.wall(i, s).gap > of_.wall(i, least).gap) least = s;
      }
      if (!(found.gap < of_.wall(i, least).gap)) return;
      for (std::size_t s = least; s + 1 < count; ++s) of_.wall(i, s) = of_.wall(i, s + 1);
      --count;
    }
    of_.wall(i, count) = found;
    room_.wall_count[i] = static_cast<std::uint8_t>(count + 1);
  }

  const MeetSubstep<T>& of_;
  MeetRoom<T>& room_;
};

}  // namespace dvdx
