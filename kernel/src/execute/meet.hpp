// Particles that meet, at the end of a sub-step: passes/meet/meet.hpp. Pairs by tasks of fixed sizes; sums by particle, in the
// order of numbers: no result depends on threads, nor on the age of a list.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "compile/joined_motion.hpp"
#include "execute/contact_recorder.hpp"
#include "execute/tasks.hpp"
#include "execute/workspace.hpp"
#include "math/vec3.hpp"
#include "passes/meet/meet.inl.hpp"
#include "passes/meet/surface.hpp"

namespace dvdx {

template <class T>
class MeetStep {
 public:
  MeetStep(const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace, const WorkColumns<T>& work,
           const ParallelFor& parallel, ContactReport::Parts* report) noexcept
      : m_(motion),
        rules_(*motion.joints().meet),
        order_(motion.joints().order),
        room_(workspace.meet),
        work_(work),
        parallel_(parallel),
        report_(report) {}

  // A sub-step begins.
  void set_out() noexcept {
    over_particles([&](std::size_t i) { room_.x0[i] = at(work_.x, i); });
  }

  enum class Found { all, too_many };
  // Its flows have ended. The surfaces are where they are at its end; h != 0.
  Found meet(const Surface<T>* surfaces, std::size_t surface_count, T h) noexcept {
    surfaces_ = surfaces;
    surface_count_ = surface_count;
    h_ = h;
    take();
    if (find_strays() == Lists::stale && list() == Found::too_many) return Found::too_many;
    find_near();
    if (count_near() == Found::too_many) return Found::too_many;
    ++room_.substeps;
    if (room_.pair_count == 0 && rules_.are_balls_alike()) {
      room_.keeps = Keeps::nothing;
      return Found::all;
    }
    bounce();
    push_apart();
    put_back();
    if (report_ != nullptr) tell();
    return Found::all;
  }

 private:
  static constexpr std::size_t per_task = particles_per_meeting_task;
  using Near = typename MeetRoom<T>::Near;
  using Keeps = typename MeetRoom<T>::Keeps;
  using Task = typename MeetRoom<T>::MeetTask;

  [[nodiscard]] std::size_t particles() const noexcept { return rules_.particles(); }
  [[nodiscard]] Point<T> at(const std::array<T*, 3>& columns, std::size_t i) const noexcept {
    const std::size_t element = order_.of[i];
    return {columns[0][element], columns[1][element], columns[2][element]};
  }
  [[nodiscard]] T wanted(std::size_t i, std::size_t j) const noexcept { return rules_.radii()[i] + rules_.radii()[j]; }
  [[nodiscard]] MetParticles<T> met() const noexcept {
    return {.x0 = room_.x0.data(),
            .x1 = room_.x1.data(),
            .v = room_.v.data(),
            .dv = room_.dv.data(),
            .shift = room_.shift.data(),
            .w = room_.w.data(),
            .last = room_.last.data()};
  }

  // use(task, first particle, end)
  template <class Use>
  void over_tasks(const Use& use) const noexcept {
    for_each_task(parallel_, room_.tasks.size(), [&](std::size_t task) {
      use(room_.tasks[task], task * per_task, std::min(particles(), (task + 1) * per_task));
    });
  }
  template <class Use>
  void over_particles(const Use& use) const noexcept {
    over_tasks([&](const Task&, std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) use(i);
    });
  }
  [[nodiscard]] std::size_t walls_of(std::size_t i) const noexcept { return room_.walls_each != 0 ? room_.wall_count[i] : 0; }
  [[nodiscard]] MetWall<T>& wall(std::size_t i, std::size_t s) const noexcept { return room_.walls[i * room_.walls_each + s]; }

  // Sums are of what is finite.
  void take() noexcept {
    over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.way = task.gone = {};
      task.ways = task.gones = 0;
      for (std::size_t i = from; i < end; ++i) {
        room_.x1[i] = at(work_.x, i);
        room_.v[i] = at(work_.v, i);
        room_.w[i] = work_.w[order_.of[i]];
        if (!(rules_.radii()[i] >= 0)) continue;
        add(minus(room_.x1[i], room_.x0[i]), task.way, task.ways);
        add(minus(room_.x1[i], room_.listed_at[i]), task.gone, task.gones);
      }
      if (!room_.has_impacts) return;
      for (std::size_t i = from; i < end; ++i) {
        room_.dv[i] = room_.shift[i] = {};
        room_.last[i] = 0;
        room_.is_hit[i] = 0;
      }
    });
    room_.has_impacts = false;
  }
  static void add(const Point<T>& d, std::array<double, 3>& sum, std::uint32_t& count) noexcept {
    if (!is_finite(d)) return;
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += double{d[axis]};
    ++count;
  }

  // ---- what is near: which pairs those are depends on this sub-step alone --------------------------------------------------

  // m: what pushes may add to the ways.
  [[nodiscard]] T margin() const noexcept { return T(0.1) * rules_.least_radius(); }
  [[nodiscard]] T nominal_skin() const noexcept { return T(0.3) * rules_.least_radius(); }

  static bool is_finite(const Point<T>& x) noexcept {
    return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
  }
  // By tasks, which are the same on any number of threads.
  [[nodiscard]] Point<T> mean(std::array<double, 3> Task::*of, std::uint32_t Task::*count) const noexcept {
    std::array<double, 3> sum{};
    double all = 0;
    for (const Task& task : room_.tasks) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += (task.*of)[axis];
      all += task.*count;
    }
    Point<T> mean{};
    for (std::size_t axis = 0; axis < 3 && all > 0; ++axis) mean[axis] = static_cast<T>(sum[axis] / all);
    return mean;
  }
  static T size(const Point<T>& d) noexcept { return std::sqrt(inner(d, d)); }

  enum class Lists { fresh, stale };
  Lists find_strays() noexcept {
    const Point<T> all = mean(&Task::way, &Task::ways);
    const Point<T> by = mean(&Task::gone, &Task::gones);
    const T half = T(0.495) * room_.skin;
    over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.is_stale = false;
      for (std::size_t i = from; i < end; ++i) {
        const T strays = size(minus(minus(room_.x1[i], room_.x0[i]), all));
        room_.strays[i] = strays;
        if (!(rules_.radii()[i] >= 0)) continue;
        const T used = size(minus(minus(room_.x1[i], room_.listed_at[i]), by)) + 2 * strays;
        // A particle that is not finite is in no list, and always asks for new ones.
        task.is_stale = task.is_stale || !(used <= half + room_.allowed[i]);
      }
    });
    if (!room_.is_listed) return Lists::stale;
    const bool is_stale = std::any_of(room_.tasks.begin(), room_.tasks.end(), [](const Task& task) { return task.is_stale; });
    return is_stale ? Lists::stale : Lists::fresh;
  }

  Found list() noexcept {
    ++room_.rebuilt;
    take_pulses_out();
    room_.is_listed = true;
    for (const T skin : {nominal_skin(), T(0)}) {
      room_.skin = skin;
      const T ordinary = rules_.most_radius() + T(0.5) * nominal_skin();
      over_particles([&](std::size_t i) {
        room_.listed_at[i] = room_.x1[i];
        room_.allowed[i] = (skin > 0 ? 4 : 2) * room_.strays[i];
        const T a = rules_.radii()[i] + room_.allowed[i];
        room_.a[i] = rules_.radii()[i] >= 0 && std::isfinite(a) && is_finite(room_.x1[i]) ? a : T(-1);
      });
      const auto accepts = [&](std::uint32_t i, std::uint32_t j) { return rules_.accepts(i, j); };
      const T reach = (margin() + skin) * T(1.001);
      if (room_.lists.build(room_.x1.data(), room_.a.data(), ordinary, reach, accepts) == PairLists<T>::Found::all) {
        put_pulses_in();
        return Found::all;
      }
    }
    room_.is_listed = false;
    return Found::too_many;
  }

  // Before new lists are built.
  void take_pulses_out() noexcept {
    if (room_.keeps != Keeps::in_places) return;
    std::size_t count = 0;
    room_.for_each_kept([&](std::size_t i, std::uint32_t j, const Pulse<T>& pulse) {
      room_.keep_by_pair(count, pulse);
      room_.pairs[count++] = {.i = static_cast<std::uint32_t>(i), .j = j};
    });
    room_.kept_count = count;
    room_.keeps = Keeps::by_pairs;
  }
  // Those of pairs that are in no list any more are lost.
  void put_pulses_in() noexcept {
    if (room_.keeps != Keeps::by_pairs) return;
    std::fill_n(room_.pulses.begin(), room_.lists.first(particles()), Pulse<T>{});
    for (std::size_t k = 0; k < room_.kept_count; ++k) {
      const MetPair& pair = room_.pairs[k];
      const std::uint32_t* const first = room_.lists.begin(pair.i);
      const std::uint32_t* const found = std::lower_bound(first, room_.lists.end(pair.i), pair.j);
      if (found == room_.lists.end(pair.i) || *found != pair.j) continue;
      room_.pulses[room_.lists.first(pair.i) + static_cast<std::size_t>(found - first)] = room_.kept_by_pair(k);
    }
    room_.keeps = Keeps::in_places;
  }

  // Whether a pair may meet in this sub-step, and be an impact.
  [[nodiscard]] Near how_near(std::size_t i, std::size_t j, T slowest) const noexcept {
    if (!(room_.w[i] > 0 || room_.w[j] > 0)) return Near::no;
    const T strays = room_.strays[i] + room_.strays[j];
    const T most = rules_.least_radius();
    const T reach = wanted(i, j) + margin() + (strays < most ? strays : most);
    const Point<T> q1 = minus(room_.x1[i], room_.x1[j]);
    const T off = inner(q1, q1);
    if (off * T(0.999) > (reach + strays) * (reach + strays)) return Near::no;
    const bool is_at_end = strays < reach && off < T(0.999) * (reach * reach);
    if (!is_at_end && !comes_within(minus(room_.x0[i], room_.x0[j]), q1, reach)) return Near::no;
    const Point<T> u = minus(room_.v[i], room_.v[j]);
    return inner(u, u) > slowest * slowest ? Near::fast : Near::yes;
  }
  void find_near() noexcept {
    const T slowest = m_.slowest_bounce();
    over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.near = task.fast = 0;
      for (std::size_t i = from; i < end; ++i) {
        for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) {
          const Near near = how_near(i, room_.lists.partner(place), slowest);
          room_.is_near[place] = near;
          task.near += near != Near::no ? 1U : 0U;
          task.fast += near == Near::fast ? 1U : 0U;
        }
      }
    });
    std::size_t count = 0;
    std::size_t first = 0;
    for (Task& task : room_.tasks) {
      task.first = static_cast<std::uint32_t>(first);
      first += MeetRoom<T>::whole_lanes(task.near);
      count += task.near;
    }
    room_.pair_count = count;
  }
  // Surfaces too.
  Found count_near() noexcept {
    over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.most = 0;
      for (std::size_t i = from; i < end; ++i) {
        std::uint32_t count = 0;
        for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) {
          count += room_.is_near[place] != Near::no ? 1U : 0U;
        }
        for (const std::uint32_t* place = room_.lists.lower_begin(i); place != room_.lists.lower_end(i); ++place) {
          count += room_.is_near[*place] != Near::no ? 1U : 0U;
        }
        task.most = std::max(task.most, count);
        if (room_.walls_each != 0) find_walls(i, count != 0);
      }
    });
    room_.most = 0;
    for (const Task& task : room_.tasks) room_.most = std::max<std::size_t>(room_.most, task.most);
    if (room_.most <= static_cast<std::size_t>(rules_.meet().most_neighbours)) return Found::all;
    room_.pair_count = 0;
    return Found::too_many;
  }

  // Surfaces near a particle that something may push, and those that flows have not kept it off.
  void find_walls(std::size_t i, bool has_pairs) noexcept {
    room_.wall_count[i] = 0;
    const T more = rules_.off_surfaces(i);
    if (!(room_.w[i] > 0) || !(has_pairs || more > 0)) return;
    const T reach = more + (margin() + room_.strays[i]);
    const Point<T>& x = room_.x1[i];
    for (std::size_t s = 0; s < surface_count_; ++s) {
      const Surface<T>& surface = surfaces_[s];
      if (surface.shape == Shape::plane && !(inner(surface.n, x) - surface.d < reach)) continue;
      const Off<T> off = off_surface(surface, x);
      if (!(off.distance < reach)) continue;
      MetWall<T> found;
      found.surface = static_cast<std::uint32_t>(s);
      found.contact.n = off.n;
      found.contact.gap = off.distance - more;
      found.mu = surface.mu;
      found.e = surface.e;
      found.way = times(h_, velocity_of(surface, x));
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
        if (wall(i, s).contact.gap > wall(i, least).contact.gap) least = s;
      }
      if (!(found.contact.gap < wall(i, least).contact.gap)) return;
      for (std::size_t s = least; s + 1 < count; ++s) wall(i, s) = wall(i, s + 1);
      --count;
    }
    wall(i, count) = found;
    room_.wall_count[i] = static_cast<std::uint8_t>(count + 1);
  }

  // ---- impacts ------------------------------------------------------------------------------------------------------------

  // The one that meets first, of these the fastest, and of these that with the lower number.
  static bool comes_before(const Impact<T>& a, const Impact<T>& b) noexcept {
    if (a.f != b.f) return a.f < b.f;
    return a.speed > b.speed;
  }
  static constexpr std::uint8_t no_wall = std::numeric_limits<std::uint8_t>::max();

  // Impacts of a round stand where pairs will, each task's from its first on.
  template <class Use>
  void over_impacts(const Use& use) const noexcept {
    for (const Task& task : room_.tasks) {
      for (std::uint32_t p = task.first; p < task.first + task.impacts; ++p) use(room_.pairs[p], p);
    }
  }
  void bounce() noexcept {
    const T slowest = m_.slowest_bounce();
    for (int round = 0; round < most_impact_rounds; ++round) {
      if (!find_impacts(slowest, round)) return;
      room_.has_impacts = true;
      name_impacts();
      over_tasks([&](const Task& task, std::size_t, std::size_t) {
        for (std::uint32_t p = task.first; p < task.first + task.impacts; ++p) {
          const MetPair& pair = room_.pairs[p];
          if (is_named(pair.i, p) && is_named(pair.j, p)) hit(pair, room_.impact(p));
        }
      });
      over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
        if (!task.hits_walls) return;
        for (std::size_t i = from; i < end; ++i) {
          if (names_wall(i)) hit(i, wall(i, room_.hit_wall[i]));
        }
      });
      over_impacts([&](const MetPair& pair, std::uint32_t) { room_.best[pair.i] = room_.best[pair.j] = no_partner; });
    }
  }
  // Whether there is any.
  bool find_impacts(T slowest, int round) noexcept {
    over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.impacts = 0;
      task.hits_walls = false;
      for (std::size_t i = from; i < end && (round > 0 || task.fast != 0); ++i) find_impacts_of(i, slowest, task);
      for (std::size_t i = from; i < end && room_.walls_each != 0; ++i) find_impacts_on_walls(i, slowest, task);
    });
    return std::any_of(room_.tasks.begin(), room_.tasks.end(),
                       [](const Task& task) { return task.impacts != 0 || task.hits_walls; });
  }
  void find_impacts_of(std::size_t i, T slowest, Task& task) noexcept {
    for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) {
      const Near near = room_.is_near[place];
      if (near == Near::no) continue;
      const std::uint32_t j = room_.lists.partner(place);
      if (near != Near::fast && room_.is_hit[i] == 0 && room_.is_hit[j] == 0) continue;
      const Impact<T> impact = find_impact(i, j, met(), wanted(i, j), h_, slowest);
      if (impact.f > 1) continue;
      room_.pairs[task.first + task.impacts] = {.i = static_cast<std::uint32_t>(i), .j = j};
      room_.put_impact(task.first + task.impacts, impact);
      ++task.impacts;
    }
  }
  void find_impacts_on_walls(std::size_t i, T slowest, Task& task) noexcept {
    room_.hit_wall[i] = no_wall;
    for (std::size_t s = 0; s < walls_of(i); ++s) {
      MetWall<T>& of = wall(i, s);
      find_impact(of, i, met(), h_, slowest);
      if (of.impact.f > 1) continue;
      const bool is_first = room_.hit_wall[i] == no_wall || comes_before(of.impact, wall(i, room_.hit_wall[i]).impact);
      if (is_first) room_.hit_wall[i] = static_cast<std::uint8_t>(s);
      task.hits_walls = true;
    }
  }
  // Each particle's first among its pairs, which come in the order of numbers.
  void name_impacts() noexcept {
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
    if (room_.walls_each == 0 || room_.hit_wall[i] == no_wall) return false;
    const std::uint32_t best = room_.best[i];
    return best == no_partner || comes_before(wall(i, room_.hit_wall[i]).impact, room_.impact(best));
  }
  [[nodiscard]] bool is_named(std::size_t i, std::uint32_t p) const noexcept { return room_.best[i] == p && !names_wall(i); }
  void hit(const MetPair& pair, const Impact<T>& impact) noexcept {
    const Point<T> u = minus(plus(room_.v[pair.i], room_.dv[pair.i]), plus(room_.v[pair.j], room_.dv[pair.j]));
    const Point<T> impulse =
        impulse_of(impact.n, u, room_.w[pair.i] + room_.w[pair.j], static_cast<T>(rules_.meet().restitution), mu());
    take_impulse(pair.i, T(1), impulse, impact.f);
    take_impulse(pair.j, T(-1), impulse, impact.f);
  }
  void hit(std::size_t i, MetWall<T>& of) noexcept {
    const Point<T> u = minus(plus(room_.v[i], room_.dv[i]), times(1 / h_, of.way));
    const Point<T> impulse = impulse_of(of.contact.n, u, room_.w[i], of.e, of.mu);
    of.impulse = plus(of.impulse, impulse);
    take_impulse(i, T(1), impulse, of.impact.f);
  }
  void take_impulse(std::size_t i, T sign, const Point<T>& impulse, T f) noexcept {
    const Point<T> dv = times(sign * room_.w[i], impulse);
    room_.dv[i] = plus(room_.dv[i], dv);
    room_.shift[i] = minus(room_.shift[i], times(f * h_, dv));
    room_.last[i] = f;
    room_.is_hit[i] = 1;
  }
  [[nodiscard]] T mu() const noexcept { return static_cast<T>(std::min(rules_.meet().friction, 1e6)); }

  // ---- contacts -----------------------------------------------------------------------------------------------------------

  void push_apart() noexcept {
    begin_contacts();
    sum_pulses();
    const int rounds = rules_.meet().rounds;
    for (int round = 0; round < rounds; ++round) {
      const T beta = round + 1 < rounds ? T(beta_of_rounds) : T(0);
      push_all(beta);
      sum_pulses();
    }
    keep_pulses();
  }
  [[nodiscard]] Point<T> moved_by_impacts(std::size_t i) const noexcept { return plus(room_.shift[i], times(h_, room_.dv[i])); }
  // use(first pair, how many): of a task, in its lanes.
  template <class Use>
  static void over_lanes(const Task& task, const Use& use) noexcept {
    for (std::size_t p = 0; p < task.near; p += meeting_lanes)
      use(task.first + p, std::min<std::size_t>(meeting_lanes, task.near - p));
  }
  // From the pulses of the sub-step before.
  void begin_contacts() noexcept {
    const bool is_kept = room_.keeps == Keeps::in_places;
    const T ratio = is_kept ? h_ / room_.kept_h : T(0);
    const T scale = T(kept_part) * (ratio * ratio);
    const auto scaled_by = [scale](const Pulse<T>& of) { return Pulse<T>{times(scale, of.vector), scale * of.number}; };
    over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      std::uint32_t p = task.first;
      for (std::size_t i = from; i < end; ++i) {
        for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) {
          if (room_.is_near[place] == Near::no) {
            room_.pulses[place] = {};
          } else {
            room_.pairs[p++] = {static_cast<std::uint32_t>(i), room_.lists.partner(place), static_cast<std::uint32_t>(place)};
          }
        }
      }
      over_lanes(task, [&](std::size_t first, std::size_t count) {
        typename Separations<T>::Three q0{}, q1{};
        typename Separations<T>::Lanes d{};
        PulseLanes<T> pulses{};
        for (std::size_t k = 0; k < count; ++k) {
          const MetPair& pair = room_.pairs[first + k];
          Point<T> end_at = minus(room_.x1[pair.i], room_.x1[pair.j]);
          if (room_.has_impacts) end_at = plus(end_at, minus(moved_by_impacts(pair.i), moved_by_impacts(pair.j)));
          Separations<T>::put(q0, k, minus(room_.x0[pair.i], room_.x0[pair.j]));
          Separations<T>::put(q1, k, end_at);
          d[k] = wanted(pair.i, pair.j);
          if (is_kept) pulses.put(k, scaled_by(room_.pulses[pair.place]));
        }
        begin_contacts_of(room_.separations[first / meeting_lanes], q0, q1, d, pulses);
        for (std::size_t k = 0; k < count; ++k) room_.pulses[room_.pairs[first + k].place] = pulses.of(k);
      });
      for (std::size_t i = from; i < end; ++i) {
        for (std::size_t s = 0; s < walls_of(i); ++s) {
          MetWall<T>& of = wall(i, s);
          const std::uint32_t* const first = room_.kept_wall_surfaces.data() + i * room_.walls_each;
          const std::uint32_t* const last = first + (is_kept ? room_.kept_wall_count[i] : 0);
          const std::uint32_t* const found = std::find(first, last, of.surface);
          const Point<T> moved = moved_by_impacts(i);
          of.contact.gap = of.contact.gap + inner(of.contact.n, moved);
          const Point<T> D = minus(plus(minus(room_.x1[i], room_.x0[i]), moved), of.way);
          const auto kept_at = static_cast<std::size_t>(found - room_.kept_wall_surfaces.data());
          of.pulse = begin_contact(of.contact, D, found != last ? scaled_by(room_.kept_walls[kept_at]) : Pulse<T>{});
        }
      }
    });
  }
  void push_all(T beta) noexcept {
    over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      over_lanes(task, [&](std::size_t first, std::size_t count) {
        typename Separations<T>::Three moved{};
        typename Separations<T>::Lanes w{};
        PulseLanes<T> pulses{};
        for (std::size_t k = 0; k < count; ++k) {
          const MetPair& pair = room_.pairs[first + k];
          const MeetPush<T>& a = room_.pushed[pair.i];
          const MeetPush<T>& b = room_.pushed[pair.j];
          Separations<T>::put(moved, k, minus(a.dx, b.dx));
          w[k] = a.w + b.w;
          pulses.number[k] = room_.pulses[pair.place].number;
        }
        push_lanes(room_.separations[first / meeting_lanes], pulses, moved, w, mu(), beta);
        for (std::size_t k = 0; k < count; ++k) room_.pulses[room_.pairs[first + k].place] = pulses.of(k);
      });
      for (std::size_t i = from; i < end; ++i) {
        for (std::size_t s = 0; s < walls_of(i); ++s) {
          MetWall<T>& of = wall(i, s);
          push(of.contact, of.pulse, room_.pushed[i].dx, room_.pushed[i].w, of.mu, beta);
        }
      }
    });
  }
  // How far pulses move each particle, by those of partners in the order of their numbers, then by surfaces.
  void sum_pulses() noexcept {
    over_particles([&](std::size_t i) {
      std::array<T, 4> sum{};  // numbers too, which are whole and so exact
      for (const std::uint32_t* place = room_.lists.lower_begin(i); place != room_.lists.lower_end(i); ++place) {
        const Pulse<T>& pulse = room_.pulses[*place];
        sum = {sum[0] - pulse.vector[0], sum[1] - pulse.vector[1], sum[2] - pulse.vector[2], sum[3] - pulse.number};
      }
      sum[3] = -sum[3];
      const auto take_pulse = [&sum](const Pulse<T>& pulse) {
        sum = {sum[0] + pulse.vector[0], sum[1] + pulse.vector[1], sum[2] + pulse.vector[2], sum[3] + pulse.number};
      };
      for (std::size_t place = room_.lists.first(i); place < room_.lists.first(i + 1); ++place) take_pulse(room_.pulses[place]);
      for (std::size_t s = 0; s < walls_of(i); ++s) take_pulse(wall(i, s).pulse);
      room_.pushed[i] = {times(room_.w[i], Point<T>{sum[0], sum[1], sum[2]}), room_.w[i] * sum[3]};
    });
  }
  void keep_pulses() noexcept {
    const T weight = m_.slowest_bounce() / 4 * std::abs(h_);
    over_tasks([&](const Task& task, std::size_t from, std::size_t end) {
      for (std::uint32_t p = task.first; p < task.first + task.near; ++p) {
        const MetPair& pair = room_.pairs[p];
        const Separation<T> of = room_.separations[p / meeting_lanes].of(p % meeting_lanes);
        room_.pulses[pair.place] = kept(of, weight / (room_.w[pair.i] + room_.w[pair.j]));
      }
      for (std::size_t i = from; i < end && room_.walls_each != 0; ++i) {
        std::uint8_t walls = 0;
        for (std::size_t s = 0; s < walls_of(i); ++s) {
          const MetWall<T>& of = wall(i, s);
          if (!(of.contact.normal > 0)) continue;
          const std::size_t at = i * room_.walls_each + walls++;
          room_.kept_walls[at] = kept(of.contact, weight / room_.w[i]);
          room_.kept_wall_surfaces[at] = of.surface;
        }
        room_.kept_wall_count[i] = walls;
      }
    });
    room_.keeps = Keeps::in_places;
    room_.kept_h = h_;
  }
  void put_back() noexcept {
    over_particles([&](std::size_t i) {
      if (!(room_.w[i] > 0)) return;
      const Point<T>& dx = room_.pushed[i].dx;
      const Point<T> moved = plus(moved_by_impacts(i), dx);
      const Point<T> given = plus(room_.dv[i], times(1 / h_, dx));
      const Point<T> zero{};
      if (moved == zero && given == zero) return;
      room_.x1[i] = plus(room_.x1[i], moved);
      const Point<T> v = plus(room_.v[i], given);
      const std::size_t element = order_.of[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work_.x[axis][element] = room_.x1[i][axis];
        work_.v[axis][element] = v[axis];
      }
    });
  }

  // The report's part: pushes and impacts that surfaces take here, beside those that the flows tell.
  void tell() noexcept {
    for (std::size_t contact = 0; contact < report_->centers.size() && room_.walls_each != 0; ++contact) {
      std::optional<ContactSums> sums;
      for (std::size_t i = 0; i < particles(); ++i) {
        for (std::size_t s = 0; s < walls_of(i); ++s) {
          const MetWall<T>& of = wall(i, s);
          const bool is_hit = of.impulse != Point<T>{};
          if (surfaces_[of.surface].contact != contact || !(is_hit || of.contact.normal > 0)) continue;
          if (!sums) sums.emplace(contact);
          const Point<T> on = times(T(-1), plus(of.impulse, times(1 / h_, of.pulse.vector)));
          const Vec3 impulse{double{on[0]}, double{on[1]}, double{on[2]}};
          const Vec3 x{double{room_.x1[i][0]}, double{room_.x1[i][1]}, double{room_.x1[i][2]}};
          sums->add(impulse, cross(difference(sum(x, m_.origin()), report_->centers[contact].at), impulse));
          if (is_hit) sums->count_hits(1);
        }
      }
      if (sums) sums->join(*report_);
    }
  }

  const JoinedMotion<T>& m_;
  const MeetRules<T>& rules_;
  const ParticleOrder& order_;
  MeetRoom<T>& room_;
  const WorkColumns<T>& work_;
  const ParallelFor& parallel_;
  ContactReport::Parts* report_;
  const Surface<T>* surfaces_ = nullptr;
  std::size_t surface_count_ = 0;
  T h_ = 0;
};

}  // namespace dvdx
