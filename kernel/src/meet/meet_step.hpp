// Particles that meet, at the end of a sub-step: meet/meet.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "contact/report/contact_recorder.hpp"
#include "math/vec3.hpp"
#include "meet/meet_contacts.hpp"
#include "meet/meet_impacts.hpp"
#include "meet/meet_near.hpp"
#include "meet/meet_share.hpp"
#include "meet/meet_substep.hpp"

namespace dvdx {

// The particles of a scene that meet. origin: m, of the working columns; slowest, parting: see MeetSubstep.
template <class T>
struct MeetingsOfScene {
  const MeetRules<T>& rules;
  const ParticleOrder& order;
  const Vec3& origin;
  T slowest, parting;
};

template <class T>
class MeetStep {
 public:
  // particles: their number. A part of a larger scene takes the number of the whole instead.
  MeetStep(const MeetingsOfScene<T>& scene, MeetRoom<T>& room, const WorkColumns<T>& work, std::size_t particles,
           const PartContext& elsewhere, const MeetKernels<T>& kernels, const ParallelFor& parallel,
           ContactReport::Parts* report) noexcept
      : order_(scene.order),
        origin_(scene.origin),
        room_(room),
        work_(work),
        report_(report),
        of_{.rules = scene.rules,
            .room = room,
            .kernels = kernels,
            .parallel = parallel,
            .slowest = scene.slowest,
            .parting = scene.parting},
        share_(elsewhere, order_, room_, work_) {
    room_.set_count(share_.is_there() ? share_.particles() : particles);
  }

  // Called when a sub-step begins.
  void begin_driven_paths() noexcept {
    if (share_.is_there()) return share_.begin_driven_paths();
    of_.over_particles([&](std::size_t i) { room_.start[i] = {at(work_.x, i), of_.rules.radii()[i]}; });
  }

  enum class Found { all, too_many };
  // Called when its flows have ended. The surfaces are where they are at its end; h != 0.
  Found meet(const Surface<T>* surfaces, std::size_t surface_count, T h) noexcept {
    of_.surfaces = surfaces;
    of_.surface_count = surface_count;
    of_.h = h;
    take();
    straighten();
    if (find_strays() == ListAge::stale && list() == Found::too_many) {
      room_.pair_count = 0;
      room_.is_kept = false;
      return Found::too_many;
    }
    if (MeetNear<T>(of_).find() == MeetNear<T>::Found::too_many) return Found::too_many;
    ++room_.substeps;
    if (room_.pair_count == 0 && of_.rules.are_balls_alike()) {
      room_.is_kept = false;
      return Found::all;
    }
    MeetImpacts<T>(of_).bounce();
    MeetContacts<T>(of_).push_apart();
    put_back();
    if (report_ != nullptr) report();
    return Found::all;
  }

 private:
  using Task = typename MeetRoom<T>::MeetTask;

  [[nodiscard]] Point<T> at(const std::array<T*, 3>& columns, std::size_t i) const noexcept {
    const std::size_t element = order_.of[i];
    return {columns[0][element], columns[1][element], columns[2][element]};
  }

  void take() noexcept {
    if (share_.is_there()) share_.exchange(of_.rules.radii(), of_.parallel);
    const WayTerms<T> terms{.elements = share_.is_there() ? nullptr : order_.of.data(),
                            .x = {work_.x[0], work_.x[1], work_.x[2]},
                            .v = {work_.v[0], work_.v[1], work_.v[2]},
                            .w = work_.w,
                            .start = room_.start.data(),
                            .listed = room_.listed.data(),
                            .end = room_.end.data(),
                            .velocity = room_.velocity.data()};
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.sums = of_.kernels.take_ways(terms, from, end);
      if (!room_.has_impacts) return;
      for (std::size_t i = from; i < end; ++i) {
        room_.hits[i] = {};
        room_.shift[i] = {};
      }
    });
    room_.has_impacts = false;
  }
  // A particle that surfaces have turned back has x1 - x0 other than v1 h. A pair may then come nearer along that chord while
  // its velocities part, and pushes would add speed. So its start moves to x1 - v1 h, as if it had come straight to its end,
  // which is its path since it was turned back. Particles that it met before are seen at its end alone.
  void straighten() noexcept {
    if (!(of_.rules.meet().restitution > 0) || of_.surface_count == 0) return;
    const T least = of_.slowest * std::abs(of_.h);
    of_.over_particles([&](std::size_t i) {
      if (!(room_.velocity[i].w > 0)) return;
      const Point<T> way = times(of_.h, room_.velocity[i].v);
      const Point<T> off = minus(minus(room_.end[i].x, way), room_.start[i].x);
      if (inner(off, off) > least * least + T(1e-6) * inner(way, way)) room_.start[i].x = plus(room_.start[i].x, off);
    });
  }

  [[nodiscard]] T nominal_skin() const noexcept { return T(0.3) * of_.rules.least_radius(); }

  static bool is_finite(const Point<T>& x) noexcept {
    return (x[0] - x[0]) + (x[1] - x[1]) + (x[2] - x[2]) == 0;  // else it is NaN
  }
  // The mean over all particles. It sums by tasks, whose size does not depend on the number of threads.
  [[nodiscard]] Point<T> mean(std::array<double, 3> WaySums::*of, std::uint32_t WaySums::*count) const noexcept {
    std::array<double, 3> sum{};
    double all = 0;
    for (const Task& task : room_.tasks) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += (task.sums.*of)[axis];
      all += task.sums.*count;
    }
    Point<T> mean{};
    for (std::size_t axis = 0; axis < 3 && all > 0; ++axis) mean[axis] = static_cast<T>(sum[axis] / all);
    return mean;
  }

  ListAge find_strays() noexcept {
    const StrayTerms<T> terms{.start = room_.start.data(),
                              .listed = room_.listed.data(),
                              .end = room_.end.data(),
                              .way = mean(&WaySums::way, &WaySums::ways),
                              .gone = mean(&WaySums::gone, &WaySums::gones),
                              .allowed = T(0.495) * room_.skin};
    of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
      task.is_stale = of_.kernels.find_strays(terms, from, end) == ListAge::stale;
    });
    if (!room_.is_listed || room_.listed_by != of_.rules.fingerprint()) return ListAge::stale;
    const bool is_stale = std::any_of(room_.tasks.begin(), room_.tasks.end(), [](const Task& task) { return task.is_stale; });
    return is_stale ? ListAge::stale : ListAge::fresh;
  }

  Found list() noexcept {
    ++room_.rebuilt;
    room_.is_listed = true;
    room_.listed_by = of_.rules.fingerprint();
    const double most = 4 * double{least_ordinary()};  // the most that one particle counts in the mean
    for (const T skin : {nominal_skin(), T(0)}) {
      room_.skin = skin;
      of_.over_tasks([&](Task& task, std::size_t from, std::size_t end) {
        double reaches = 0;
        std::uint32_t listed = 0;
        for (std::size_t i = from; i < end; ++i) {
          room_.listed[i] = {room_.end[i].x, (skin > 0 ? 4 : 2) * room_.end[i].strays};
          const T a = of_.rules.reach(i) + room_.listed[i].allowed;
          const bool meets = of_.rules.radii()[i] >= 0 && std::isfinite(a) && is_finite(room_.end[i].x);
          room_.a[i] = meets ? a : T(-1);
          reaches += meets ? std::min(double{a}, most) : 0;
          listed += meets ? 1U : 0U;
        }
        task.reaches = reaches;
        task.listed = listed;
      });
      const auto some = [&](std::uint32_t i, std::uint32_t j) { return of_.rules.accepts(i, j); };
      const Found found = of_.rules.accepts_all() ? build(AllPairs()) : build(some);
      if (found == Found::all) return Found::all;
    }
    room_.is_listed = false;
    return Found::too_many;
  }
  template <class Accepts>
  Found build(const Accepts& accepts) noexcept {
    const auto run = [&](std::size_t tasks, const auto& body) { for_each_task(of_.parallel, tasks, body); };
    const T reach = (of_.margin() + room_.skin) * T(1.001);
    const auto found =
        room_.lists.build(room_.listed.data(), room_.a.data(), ordinary(), reach, accepts, of_.kernels.near, run);
    return found == PairLists<T>::Found::all ? Found::all : Found::too_many;
  }

  // The largest a that cells are made for. It covers most particles: each with a larger one searches 125 cells, one by one. A
  // few fast particles do not widen the cells of all. No bit depends on it.
  [[nodiscard]] T ordinary() const noexcept {
    constexpr double wider = 1.5;
    double sum = 0;
    double listed = 0;
    for (const Task& task : room_.tasks) {
      sum += task.reaches;
      listed += task.listed;
    }
    return listed > 0 ? std::max(least_ordinary(), static_cast<T>(wider * sum / listed)) : least_ordinary();
  }
  [[nodiscard]] T least_ordinary() const noexcept { return of_.rules.most_reach() + T(0.5) * nominal_skin(); }

  // m: a touching particle that would move less than this stays; 0: all move.
  [[nodiscard]] T way_at_rest() const noexcept {
    if (!of_.rules.are_balls() || !(of_.rules.meet().friction > 0)) return 0;
    const bool has_movers =
        std::any_of(of_.surfaces, of_.surfaces + of_.surface_count, [](const Surface<T>& of) { return moves(of); }) ||
        std::any_of(room_.tasks.begin(), room_.tasks.end(), [](const Task& task) { return task.sums.has_movers; });
    return has_movers ? T(0) : T(part_at_rest / 4) * of_.slowest * std::abs(of_.h);
  }
  static bool moves(const Surface<T>& surface) noexcept {
    const Point<T> zero{};
    return surface.movement != Movement::rest && (surface.u != zero || surface.omega != zero);
  }

  void put_back() noexcept {
    const T at_rest = way_at_rest();
    of_.over_particles([&](std::size_t i) {
      if (!(room_.velocity[i].w > 0)) return;
      const Point<T>& dx = room_.pushed[i].dx;
      const Point<T> moved = plus(of_.moved_by_impacts(i), dx);
      const Point<T> given = plus(room_.hits[i].dv, times(1 / of_.h, dx));
      const Point<T> zero{};
      if (moved == zero && given == zero) return;
      const Point<T> end = plus(room_.end[i].x, moved);
      const Point<T> way = minus(end, room_.start[i].x);
      const bool rests = room_.pushed[i].w > 0 && inner(way, way) < at_rest * at_rest;
      room_.end[i].x = rests ? room_.start[i].x : end;
      const Point<T> v = plus(room_.velocity[i].v, given);
      if (share_.is_there()) {
        room_.velocity[i].v = v;
        return;
      }
      const std::size_t element = order_.of[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work_.x[axis][element] = room_.end[i].x[axis];
        work_.v[axis][element] = v[axis];
      }
    });
    if (share_.is_there()) share_.put_back(of_.parallel);
  }

  // Adds the pushes and impacts of meetings on surfaces to the report. The flows report the others.
  void report() noexcept {
    for (std::size_t contact = 0; contact < report_->centers.size() && room_.walls_each != 0; ++contact) {
      std::optional<ContactSums> sums;
      over_reported([&](std::size_t i) {
        for (std::size_t s = 0; s < of_.walls_of(i); ++s) {
          const MetWall<T>& of = of_.wall(i, s);
          const std::size_t number = room_.first_wall[i] + s;
          const T normal = room_.wall_separations[number / meeting_lanes].normal[number % meeting_lanes];
          const bool is_hit = of.impulse != Point<T>{};
          if (of_.surfaces[of.surface].contact != contact || !(is_hit || normal > 0)) continue;
          if (!sums) sums.emplace(contact);
          const Point<T> on = times(T(-1), plus(of.impulse, times(1 / of_.h, room_.wall_pulse(number).vector)));
          const Vec3 impulse{double{on[0]}, double{on[1]}, double{on[2]}};
          const Point<T>& end = room_.end[i].x;
          const Vec3 x{double{end[0]}, double{end[1]}, double{end[2]}};
          sums->add(impulse, cross(difference(sum(x, origin_), report_->centers[contact].at), impulse));
          if (is_hit) sums->count_hits(1);
        }
      });
      if (sums) sums->join(*report_);
    }
  }

  // use(i) for the particles that this part reports; other parts report theirs.
  template <class Use>
  void over_reported(const Use& use) const noexcept {
    if (share_.is_there()) return share_.over_own_numbers(use);
    for (std::size_t i = 0; i < room_.particles; ++i) use(i);
  }

  const ParticleOrder& order_;
  const Vec3& origin_;
  MeetRoom<T>& room_;
  const WorkColumns<T>& work_;
  ContactReport::Parts* report_;
  MeetSubstep<T> of_;
  MeetShare<T> share_;
};

}  // namespace dvdx
