// Particles that meet, at the end of a sub-step: passes/meet/meet.hpp. Pairs by tasks of fixed sizes; sums by particle, in the
// order of numbers: no result depends on threads, nor on the age of a list.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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
    if (find_near() == Found::too_many) return Found::too_many;
    ++room_.substeps;
    if (room_.pair_count == 0 && rules_.are_balls_alike()) {
      room_.kept_h = 0;
      return Found::all;
    }
    find_walls();
    bounce();
    push_apart();
    put_back();
    if (report_ != nullptr) tell();
    return Found::all;
  }

 private:
  static constexpr std::size_t per_task = particles_per_meeting_task;

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
            .dx = room_.dx.data(),
            .w = room_.w.data(),
            .k = room_.k.data(),
            .last = room_.last.data()};
  }

  template <class Use>
  void over(std::size_t count, const Use& use) const noexcept {
    for_each_task(parallel_, tasks_of(count, per_task), [&](std::size_t task) {
      const std::size_t end = std::min(count, (task + 1) * per_task);
      for (std::size_t n = task * per_task; n < end; ++n) use(n);
    });
  }
  template <class Use>
  void over_particles(const Use& use) const noexcept {
    over(particles(), use);
  }
  template <class Use>
  void over_pairs(const Use& use) const noexcept {
    over(room_.pair_count, [&](std::size_t p) { use(room_.pairs[p], p); });
  }
  // use(meeting, sign): those of a particle in the order of their partners, then its surfaces.
  template <class Use>
  void over_meetings_of(std::size_t i, const Use& use) const noexcept {
    for (std::size_t s = room_.others[i]; s < room_.others[i + 1]; ++s) use(room_.pairs[room_.other[s]], T(-1));
    for (std::size_t p = room_.own[i]; p < room_.own[i + 1]; ++p) use(room_.pairs[p], T(1));
    for (std::size_t s = 0; s < walls_of(i); ++s) use(wall(i, s), T(1));
  }
  [[nodiscard]] std::size_t walls_of(std::size_t i) const noexcept { return room_.walls_each != 0 ? room_.wall_count[i] : 0; }
  [[nodiscard]] MetPair<T>& wall(std::size_t i, std::size_t s) const noexcept { return room_.walls[i * room_.walls_each + s]; }

  void take() noexcept {
    over_particles([&](std::size_t i) {
      room_.x1[i] = at(work_.x, i);
      room_.v[i] = at(work_.v, i);
      room_.w[i] = work_.w[order_.of[i]];
      room_.dv[i] = room_.shift[i] = room_.dx[i] = {};
      room_.last[i] = 0;
    });
  }

  // ---- what is near: which pairs those are depends on this sub-step alone --------------------------------------------------

  // m: what pushes may add to the ways.
  [[nodiscard]] T margin() const noexcept { return T(0.1) * rules_.least_radius(); }
  [[nodiscard]] T nominal_skin() const noexcept { return T(0.3) * rules_.least_radius(); }
  [[nodiscard]] T near(std::size_t i, std::size_t j) const noexcept {
    const T strays = room_.strays[i] + room_.strays[j];
    const T most = rules_.least_radius();
    return wanted(i, j) + margin() + (strays < most ? strays : most);
  }

  static bool is_finite(const Point<T>& x) noexcept {
    return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
  }
  // The mean, by numbers, of what is finite.
  template <class Difference>
  [[nodiscard]] Point<T> mean(const Difference& difference) const noexcept {
    std::array<double, 3> sum{};
    double count = 0;
    for (std::size_t i = 0; i < particles(); ++i) {
      const Point<T> d = difference(i);
      if (!(rules_.radii()[i] >= 0) || !is_finite(d)) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += double{d[axis]};
      count += 1;
    }
    Point<T> mean{};
    for (std::size_t axis = 0; axis < 3 && count > 0; ++axis) mean[axis] = static_cast<T>(sum[axis] / count);
    return mean;
  }
  static T size(const Point<T>& d) noexcept { return std::sqrt(inner(d, d)); }

  enum class Lists { fresh, stale };
  Lists find_strays() noexcept {
    const auto way = [&](std::size_t i) { return minus(room_.x1[i], room_.x0[i]); };
    const Point<T> all = mean(way);
    over_particles([&](std::size_t i) { room_.strays[i] = size(minus(way(i), all)); });
    if (!room_.is_listed) return Lists::stale;
    const auto gone = [&](std::size_t i) { return minus(room_.x1[i], room_.listed_at[i]); };
    const Point<T> by = mean(gone);
    const T half = T(0.495) * room_.skin;
    for (std::size_t i = 0; i < particles(); ++i) {
      if (!(rules_.radii()[i] >= 0)) continue;
      const T used = size(minus(gone(i), by)) + 2 * room_.strays[i];
      if (!(used <= half + room_.allowed[i]))
        return Lists::stale;  // what is not finite is in no list, and always asks for new ones
    }
    return Lists::fresh;
  }

  Found list() noexcept {
    ++room_.rebuilt;
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
        return Found::all;
      }
    }
    room_.is_listed = false;
    return Found::too_many;
  }

  // Lists pairs that may meet in this sub-step.
  Found find_near() noexcept {
    over_particles([&](std::size_t i) {
      std::uint32_t count = 0;
      const std::uint32_t* const from = room_.lists.begin(i);
      std::uint8_t* const flags = room_.is_near.data() + room_.lists.first(i);
      for (const std::uint32_t* j = from; j != room_.lists.end(i); ++j) {
        const bool is_near = (room_.w[i] > 0 || room_.w[*j] > 0) &&
                             comes_within(minus(room_.x0[i], room_.x0[*j]), minus(room_.x1[i], room_.x1[*j]), near(i, *j));
        flags[j - from] = is_near ? 1 : 0;
        count += is_near ? 1 : 0;
      }
      room_.own[i + 1] = count;
    });
    room_.own[0] = 0;
    std::fill(room_.others.begin(), room_.others.end(), 0U);
    room_.most = 0;
    for (std::size_t i = 0; i < particles(); ++i) {
      const std::uint8_t* const flags = room_.is_near.data() + room_.lists.first(i);
      const std::uint32_t* const from = room_.lists.begin(i);
      for (const std::uint32_t* j = from; j != room_.lists.end(i); ++j) {
        if (flags[j - from] != 0) ++room_.others[*j + 1];
      }
    }
    for (std::size_t i = 0; i < particles(); ++i) {
      room_.most = std::max<std::size_t>(room_.most, room_.own[i + 1] + room_.others[i + 1]);
      room_.own[i + 1] += room_.own[i];
      room_.others[i + 1] += room_.others[i];
    }
    room_.pair_count = 0;
    if (room_.most > static_cast<std::size_t>(rules_.meet().most_neighbours)) return Found::too_many;
    room_.pair_count = room_.own[particles()];
    const T mu = static_cast<T>(std::min(rules_.meet().friction, 1e6));
    const T e = static_cast<T>(rules_.meet().restitution);
    over_particles([&](std::size_t i) {
      std::size_t p = room_.own[i];
      const std::uint8_t* const flags = room_.is_near.data() + room_.lists.first(i);
      const std::uint32_t* const from = room_.lists.begin(i);
      for (const std::uint32_t* j = from; j != room_.lists.end(i); ++j) {
        if (flags[j - from] == 0) continue;
        MetPair<T>& pair = room_.pairs[p++];
        pair.i = static_cast<std::uint32_t>(i);
        pair.j = *j;
        pair.mu = mu;
        pair.e = e;
      }
    });
    for (std::size_t p = 0; p < room_.pair_count; ++p) {
      room_.other[room_.others[room_.pairs[p].j]++] = static_cast<std::uint32_t>(p);
    }
    for (std::size_t i = particles(); i > 0; --i) room_.others[i] = room_.others[i - 1];
    room_.others[0] = 0;
    return Found::all;
  }

  [[nodiscard]] bool has_pairs(std::size_t i) const noexcept {
    return room_.own[i + 1] != room_.own[i] || room_.others[i + 1] != room_.others[i];
  }

  // Surfaces near each particle that something may push, and those that flows have not kept it off.
  void find_walls() noexcept {
    if (room_.walls_each == 0) return;
    over_particles([&](std::size_t i) {
      room_.wall_count[i] = 0;
      const T more = rules_.off_surfaces(i);
      if (!(room_.w[i] > 0) || !(has_pairs(i) || more > 0)) return;
      const T reach = more + (margin() + room_.strays[i]);
      const Point<T> way = minus(room_.x1[i], room_.x0[i]);
      for (std::size_t s = 0; s < surface_count_; ++s) {
        const Off<T> off = off_surface(surfaces_[s], room_.x1[i]);
        if (!(off.distance < reach)) continue;
        MetPair<T> found;
        found.i = static_cast<std::uint32_t>(i);
        found.surface = static_cast<std::uint32_t>(s);
        found.n = off.n;
        found.gap = off.distance - more;
        found.mu = surfaces_[s].mu;
        found.e = surfaces_[s].e;
        found.way = times(h_, velocity_of(surfaces_[s], room_.x1[i]));
        found.start = found.gap - inner(found.n, minus(way, found.way));
        keep(i, found);
      }
    });
  }
  // The deepest ones, in the order of the surfaces.
  void keep(std::size_t i, const MetPair<T>& found) noexcept {
    std::size_t count = room_.wall_count[i];
    if (count == room_.walls_each) {
      std::size_t least = 0;
      for (std::size_t s = 1; s < count; ++s) {
        if (wall(i, s).gap > wall(i, least).gap) least = s;
      }
      if (!(found.gap < wall(i, least).gap)) return;
      for (std::size_t s = least; s + 1 < count; ++s) wall(i, s) = wall(i, s + 1);
      --count;
    }
    wall(i, count) = found;
    room_.wall_count[i] = static_cast<std::uint8_t>(count + 1);
  }

  // ---- impacts ------------------------------------------------------------------------------------------------------------

  // The one that meets first, of these the fastest, and of these that with the lower number.
  static bool comes_before(const MetPair<T>& a, const MetPair<T>& b) noexcept {
    if (a.f != b.f) return a.f < b.f;
    return a.speed > b.speed;
  }

  void bounce() noexcept {
    const T slowest = m_.slowest_bounce();
    for (int round = 0; round < most_impact_rounds; ++round) {
      if (!find_impacts(slowest)) return;
      name_impacts();
      over_pairs([&](const MetPair<T>& pair, std::size_t p) {
        if (room_.best[pair.i] == p && room_.best[pair.j] == p) hit(pair);
      });
      const auto walls = static_cast<std::uint32_t>(room_.pairs.size());
      over_particles([&](std::size_t i) {
        if (room_.best[i] == no_partner || room_.best[i] < walls) return;
        MetPair<T>& of = wall(i, room_.best[i] - walls);
        of.impulse = plus(of.impulse, impulse_of(of, met(), h_));
        hit(of);
      });
    }
  }
  // Whether there is any.
  bool find_impacts(T slowest) noexcept {
    const std::size_t tasks = tasks_of(particles(), per_task);
    for_each_task(parallel_, tasks, [&](std::size_t task) {
      bool is_any = false;
      const auto look = [&](MetPair<T>& of, T d) {
        find_impact(of, met(), d, h_, slowest);
        is_any = is_any || of.f <= 1;
      };
      for (std::size_t i = task * per_task; i < std::min(particles(), (task + 1) * per_task); ++i) {
        for (std::size_t p = room_.own[i]; p < room_.own[i + 1]; ++p) look(room_.pairs[p], wanted(i, room_.pairs[p].j));
        for (std::size_t s = 0; s < walls_of(i); ++s) look(wall(i, s), T(0));
      }
      room_.has_impacts[task] = is_any ? 1 : 0;
    });
    return std::find(room_.has_impacts.begin(), room_.has_impacts.end(), 1) != room_.has_impacts.end();
  }
  // Each particle's.
  void name_impacts() noexcept {
    const auto walls = static_cast<std::uint32_t>(room_.pairs.size());
    over_particles([&](std::size_t i) {
      const MetPair<T>* best = nullptr;
      std::uint32_t named = no_partner;
      const auto look = [&](const MetPair<T>& meeting, std::uint32_t number) {
        if (meeting.f > 1 || (best != nullptr && !comes_before(meeting, *best))) return;
        best = &meeting;
        named = number;
      };
      for (std::size_t s = room_.others[i]; s < room_.others[i + 1]; ++s) look(room_.pairs[room_.other[s]], room_.other[s]);
      for (std::size_t p = room_.own[i]; p < room_.own[i + 1]; ++p) look(room_.pairs[p], static_cast<std::uint32_t>(p));
      for (std::size_t s = 0; s < walls_of(i); ++s) look(wall(i, s), walls + static_cast<std::uint32_t>(s));
      room_.best[i] = named;
    });
  }
  void hit(const MetPair<T>& meeting) noexcept {
    const Point<T> impulse = impulse_of(meeting, met(), h_);
    const auto take_pulse = [&](std::size_t i, T sign) {
      const Point<T> dv = times(sign * room_.w[i], impulse);
      room_.dv[i] = plus(room_.dv[i], dv);
      room_.shift[i] = minus(room_.shift[i], times(meeting.f * h_, dv));
      room_.last[i] = meeting.f;
    };
    take_pulse(meeting.i, T(1));
    if (meeting.j != no_partner) take_pulse(meeting.j, T(-1));
  }

  // ---- contacts -----------------------------------------------------------------------------------------------------------

  void push_apart() noexcept {
    begin_contacts();
    sum_pulses();
    const int rounds = rules_.meet().rounds;
    for (int round = 0; round < rounds; ++round) {
      const T beta = round + 1 < rounds ? T(beta_of_rounds) : T(0);
      over_pairs([&](MetPair<T>& pair, std::size_t) { push(pair, met(), beta); });
      over_particles([&](std::size_t i) {
        for (std::size_t s = 0; s < walls_of(i); ++s) push(wall(i, s), met(), beta);
      });
      sum_pulses();
    }
    keep_pulses();
  }
  // From the pulses of the sub-step before.
  void begin_contacts() noexcept {
    const T ratio = room_.kept_h != 0 ? h_ / room_.kept_h : T(0);
    const T scale = T(kept_part) * (ratio * ratio);
    const auto scaled_by = [scale](const KeptPulse<T>& of) {
      return KeptPulse<T>{of.j, scale * of.normal, times(scale, of.along)};
    };
    over_particles([&](std::size_t i) {
      std::size_t k = room_.kept_h != 0 ? room_.kept_first[i] : 0;
      const std::size_t end = room_.kept_h != 0 ? room_.kept_first[i + 1] : 0;
      for (std::size_t p = room_.own[i]; p < room_.own[i + 1]; ++p) {
        MetPair<T>& pair = room_.pairs[p];
        while (k < end && room_.kept[k].j < pair.j) ++k;
        const bool is_kept = k < end && room_.kept[k].j == pair.j;
        begin_contact(pair, met(), wanted(i, pair.j), h_, is_kept ? scaled_by(room_.kept[k]) : KeptPulse<T>{});
      }
      for (std::size_t s = 0; s < walls_of(i); ++s) {
        const KeptPulse<T>* const first = room_.kept_walls.data() + i * room_.walls_each;
        const KeptPulse<T>* const last = first + (room_.kept_h != 0 ? room_.kept_wall_count[i] : 0);
        const auto found = std::find_if(first, last, [&](const KeptPulse<T>& of) { return of.j == wall(i, s).surface; });
        begin_contact(wall(i, s), met(), T(0), h_, found != last ? scaled_by(*found) : KeptPulse<T>{});
      }
    });
  }
  // The ways that pulses move each particle, and how many act on it.
  void sum_pulses() noexcept {
    over_particles([&](std::size_t i) {
      Point<T> sum{};
      T k = 0;
      over_meetings_of(i, [&](const MetPair<T>& meeting, T sign) {
        sum = plus(sum, times(sign, meeting.pulse));
        k += meeting.is_active ? T(1) : T(0);
      });
      room_.dx[i] = times(room_.w[i], sum);
      room_.k[i] = k;
    });
  }
  void keep_pulses() noexcept {
    const T weight = m_.slowest_bounce() / 4 * std::abs(h_);
    const auto weight_of = [&](const MetPair<T>& of) {
      return weight / (of.j == no_partner ? room_.w[of.i] : room_.w[of.i] + room_.w[of.j]);
    };
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < particles(); ++i) {
      room_.kept_first[i] = count;
      for (std::size_t p = room_.own[i]; p < room_.own[i + 1]; ++p) {
        if (room_.pairs[p].normal > 0) room_.kept[count++] = kept(room_.pairs[p], weight_of(room_.pairs[p]));
      }
      std::size_t walls = 0;
      for (std::size_t s = 0; s < walls_of(i); ++s) {
        const MetPair<T>& of = wall(i, s);
        if (of.normal > 0) room_.kept_walls[i * room_.walls_each + walls++] = kept(of, weight_of(of));
      }
      if (room_.walls_each != 0) room_.kept_wall_count[i] = static_cast<std::uint8_t>(walls);
    }
    room_.kept_first[particles()] = count;
    room_.kept_h = h_;
  }
  void put_back() noexcept {
    over_particles([&](std::size_t i) {
      if (!(room_.w[i] > 0)) return;
      const Point<T> moved = plus(plus(room_.shift[i], times(h_, room_.dv[i])), room_.dx[i]);
      const Point<T> given = plus(room_.dv[i], times(1 / h_, room_.dx[i]));
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
          const MetPair<T>& of = wall(i, s);
          const bool is_hit = of.impulse != Point<T>{};
          if (surfaces_[of.surface].contact != contact || !(is_hit || of.normal > 0)) continue;
          if (!sums) sums.emplace(contact);
          const Point<T> on = times(T(-1), plus(of.impulse, times(1 / h_, of.pulse)));
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
