// Which pairs may meet in a sub-step, and which surfaces: both depend on this sub-step alone.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "execute/meet_substep.hpp"
#include "passes/meet/surface.hpp"

namespace dvdx {

template <class T>
class MeetNear {
 public:
  explicit MeetNear(const MeetSubstep<T>& of) noexcept : of_(of), room_(of.room) {}

  enum class Found { all, too_many };
  // From the lists: the room's pairs, and where each particle finds its own.
  Found find() noexcept {
    find_pairs();
    const bool have_room = number_tasks();
    if (have_room) number_pairs();
    count();
    room_.most = 0;
    for (const Task& task : room_.tasks) room_.most = std::max<std::size_t>(room_.most, task.most);
    if (have_room && room_.most <= static_cast<std::size_t>(of_.rules.meet().most_neighbours)) return Found::all;
    room_.pair_count = 0;
    room_.is_kept = false;
    return Found::too_many;
  }

 private:
  using Task = typename MeetSubstep<T>::Task;
  enum class Near { no, yes, fast };

  [[nodiscard]] Near how_near(std::size_t i, std::size_t j) const noexcept {
    if (!(room_.w[i] > 0 || room_.w[j] > 0)) return Near::no;
    const T strays = room_.strays[i] + room_.strays[j];
    const T most = of_.rules.least_radius();
    const T reach = of_.wanted(i, j) + of_.margin() + (strays < most ? strays : most);
    const Point<T> q1 = minus(room_.x1[i], room_.x1[j]);
    const T off = inner(q1, q1);
    if (off * T(0.999) > (reach + strays) * (reach + strays)) return Near::no;
    const bool is_at_end = strays < reach && off < T(0.999) * (reach * reach);
    if (!is_at_end && !comes_within(minus(room_.x0[i], room_.x0[j]), q1, reach)) return Near::no;
    const Point<T> u = minus(room_.v[i], room_.v[j]);
    return inner(u, u) > of_.slowest * of_.slowest ? Near::fast : Near::yes;
  }
  // Until pairs are numbered, a listed one that is near has the number 0, or 1 if it is fast.
  void find_pairs() noexcept {
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.kept_first = task.first;
      task.kept = task.near;
      task.near = task.fast = 0;
      std::uint32_t* const numbers = room_.numbers().data();
      for (std::size_t i = from; i < end; ++i) {
        for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) {
          const Near near = how_near(i, room_.lists.partner(place));
          numbers[place] = near == Near::no ? no_partner : (near == Near::fast ? 1U : 0U);
          task.near += near != Near::no ? 1U : 0U;
          task.fast += near == Near::fast ? 1U : 0U;
        }
        room_.own_end[i] = task.near;
      }
    });
  }
  // Each task's pairs begin a block, and leave one place at its end.
  bool number_tasks() noexcept {
    std::size_t count = 0;
    std::size_t first = 0;
    for (const Task& task : room_.tasks) {
      first += MeetRoom<T>::whole_lanes(task.near + 1);
      count += task.near;
    }
    room_.pair_count = count;
    if (first > room_.pulses.size()) return false;  // which only too many neighbours take
    first = 0;
    for (Task& task : room_.tasks) {
      task.first = static_cast<std::uint32_t>(first);
      first += MeetRoom<T>::whole_lanes(task.near + 1);
    }
    return true;
  }
  void number_pairs() noexcept {
    room_.turn_over();
    of_.over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      std::uint32_t p = task.first;
      std::uint32_t* const numbers = room_.numbers().data();
      for (std::size_t i = from; i < end; ++i) {
        for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) {
          const std::uint32_t near = numbers[place];
          room_.put_pair(p, {static_cast<std::uint32_t>(i), room_.lists.partner(place)});
          room_.goes[p] = near == 1 ? PairGoes::fast : PairGoes::slowly;
          numbers[place] = near == no_partner ? no_partner : p;
          p += near == no_partner ? 0U : 1U;
        }
      }
      for (; p % meeting_lanes != 0; ++p) room_.put_pair(p, {.i = 0, .j = 0});
    });
  }
  // Surfaces too.
  void count() noexcept {
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.most = 0;
      task.first_wall = static_cast<std::uint32_t>(from * room_.walls_each);
      task.walls = 0;
      std::uint32_t own = 0;
      const std::uint32_t* const numbers = room_.numbers().data();
      std::uint32_t* const lower_near = room_.lower_near().data();
      for (std::size_t i = from; i < end; ++i) {
        std::uint32_t lower = room_.lists.first_lower(i);
        const std::uint32_t first = lower;
        for (const std::uint32_t* place = room_.lists.lower_begin(i); place != room_.lists.lower_end(i); ++place) {
          const std::uint32_t number = numbers[*place];
          lower_near[lower] = number;
          lower += number == no_partner ? 0U : 1U;
        }
        room_.lower_end[i] = lower;
        const std::uint32_t count = (lower - first) + (room_.own_end[i] - own);
        own = room_.own_end[i];
        task.most = std::max(task.most, count);
        if (room_.walls_each == 0) continue;
        room_.first_wall[i] = task.first_wall + task.walls;
        find_walls(i, count != 0);
        task.walls += room_.wall_count[i];
      }
    });
  }

  // Surfaces near a particle that something may push, and those that flows have not kept it off.
  void find_walls(std::size_t i, bool has_pairs) noexcept {
    room_.wall_count[i] = 0;
    const T more = of_.rules.off_surfaces(i);
    if (!(room_.w[i] > 0) || !(has_pairs || more > 0)) return;
    const T reach = more + (of_.margin() + room_.strays[i]);
    const Point<T>& x = room_.x1[i];
    for (std::size_t s = 0; s < of_.surface_count; ++s) {
      const Surface<T>& surface = of_.surfaces[s];
      if (surface.shape == Shape::plane && !(inner(surface.n, x) - surface.d < reach)) continue;
      const Off<T> off = off_surface(surface, x);
      if (!(off.distance < reach)) continue;
      MetWall<T> found;
      found.particle = static_cast<std::uint32_t>(i);
      found.surface = static_cast<std::uint32_t>(s);
      found.contact.n = off.n;
      found.contact.gap = off.distance - more;
      found.mu = surface.mu;
      found.e = surface.e;
      found.way = times(of_.h, velocity_of(surface, x));
      found.start = found.contact.gap - inner(off.n, minus(minus(x, room_.x0[i]), found.way));
      keep(i, found);
    }
  }
  // The deepest ones, in the order of the surfaces.
  void keep(std::size_t i, const MetWall<T>& found) noexcept {
    std::size_t count = room_.wall_count[i];
    if (count == room_.walls_each) {
      std::size_t least = 0;
      for (std::size_t s = 1; s < count; ++s) {
        if (of_.wall(i, s).contact.gap > of_.wall(i, least).contact.gap) least = s;
      }
      if (!(found.contact.gap < of_.wall(i, least).contact.gap)) return;
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
