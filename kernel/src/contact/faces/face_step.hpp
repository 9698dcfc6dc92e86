// Faces of cloth on bodies narrower than its cells, at the end of a sub-step: contact/faces/face.hpp. Many threads search for
// near faces. One thread gives the pulses, triangle by triangle, so that no result depends on threads.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "contact/faces/face_contacts.hpp"
#include "contact/faces/face_room.hpp"
#include "contact/report/contact_recorder.hpp"
#include "motion/driven.hpp"
#include "motion/pose_track.hpp"
#include "springs/network.hpp"
#include "work/tasks.hpp"

namespace dvdx {

// Faces that meet bodies, and the motions that carry the bodies. elements: of a working column; origin: of the columns, m.
struct FacesOfScene {
  const FaceContacts& faces;
  std::size_t elements;
  const Vec3& origin;
  const std::vector<PoseTrack>& tracks;
  const std::vector<DrivenMotion>& motions;
};

template <class T>
class FaceStep {
 public:
  // work: the columns as the flows leave them; report: null, or receives the pulses.
  FaceStep(const FacesOfScene& of, FaceRoom<T>& room, const WorkColumns<T>& work, const ParallelFor& parallel,
           ContactReport::Parts* report) noexcept
      : of_(of), faces_(of.faces), room_(room), work_(work), parallel_(parallel), report_(report) {}

  // Begins a call, perhaps with another state.
  void prepare() noexcept {
    room_.travelled = 0;
    std::fill(room_.due.begin(), room_.due.end(), -std::numeric_limits<double>::infinity());
    note_places();
  }
  // Begins a step where the last one left the particles.
  void begin_driven_paths(const Clock& clock) noexcept {
    room_.travelled += farthest_way();
    note_places();
    for (std::size_t b = 0; b < bodies().size(); ++b) room_.poses[b] = pose_at(bodies()[b], clock);
  }

  // Resolves the end of the sub-step from `start` to `end`, of h seconds. Returns whether anything was moved.
  bool meet(const Clock& start, const Clock& end, double h) noexcept {
    if (h == 0) return false;
    const double way = carry_bodies(start, end);
    room_.travelled += way + farthest_way();
    find_near(way);
    pushed_ = 0;
    if (!room_.near.empty()) meet_near(start, h, way);
    if (sums_) sums_->join(*report_);
    sums_.reset();
    room_.travelled += pushed_;
    note_places();
    return pushed_ != 0;
  }

 private:
  static constexpr std::size_t patches_per_task = 64;

  [[nodiscard]] const std::vector<ThinBody>& bodies() const noexcept { return faces_.bodies(); }
  [[nodiscard]] std::size_t elements() const noexcept { return of_.elements; }
  [[nodiscard]] static Vec3 at(const std::array<T*, 3>& columns, std::size_t i) noexcept {
    return {double{columns[0][i]}, double{columns[1][i]}, double{columns[2][i]}};
  }

  // ---- ways travelled: a far patch is not looked at again before it can have come near ---------------------------------

  template <class Use>
  void over_elements(const Use& use) const noexcept {
    for_each_task(parallel_, tasks_of(elements(), particles_per_task), [&](std::size_t task) {
      const std::size_t from = task * particles_per_task;
      use(task, from, std::min(elements(), from + particles_per_task));
    });
  }
  void note_places() noexcept {
    over_elements([&](std::size_t /*task*/, std::size_t from, std::size_t to) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::copy_n(work_.x[axis] + from, to - from, room_.now[axis] + from);
      }
    });
  }
  // Returns the farthest way of any particle since its place was noted, m. A way that is NaN is ignored.
  [[nodiscard]] double farthest_way() noexcept {
    over_elements([&](std::size_t task, std::size_t from, std::size_t to) {
      T most = 0;
      for (std::size_t i = from; i < to; ++i) {
        const T a = work_.x[0][i] - room_.now[0][i];
        const T b = work_.x[1][i] - room_.now[1][i];
        const T c = work_.x[2][i] - room_.now[2][i];
        const T square = a * a + (b * b + c * c);
        most = square > most ? square : most;
      }
      room_.farthest[task] = most;
    });
    T most = 0;
    for (std::size_t task = 0; task < tasks_of(elements(), particles_per_task); ++task)
      most = std::max(most, room_.farthest[task]);
    return 1.001 * std::sqrt(double{most});
  }

  [[nodiscard]] BodyPose pose_at(const ThinBody& body, const Clock& clock) const noexcept {
    const MovedPose pose = body.motion ? of_.motions[*body.motion].at(of_.tracks[*body.motion], clock) : MovedPose{};
    return body.at(pose, of_.origin);
  }
  // Moves bodies to the end of the sub-step. Returns the farthest way of any point of a body, m.
  double carry_bodies(const Clock& start, const Clock& end) noexcept {
    double way = 0;
    for (std::size_t b = 0; b < bodies().size(); ++b) {
      const ThinBody& body = bodies()[b];
      if (!body.motion) continue;
      const BodyPose before = room_.poses[b];
      room_.poses[b] = body.at(of_.motions[*body.motion].at_end_of(of_.tracks[*body.motion], start, end), of_.origin);
      for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 y{};
        for (std::size_t k = 0; k < 3; ++k) y[k] = (corner >> k & 1U) != 0 ? body.shape.high[k] : body.shape.low[k];
        way = std::max(way, distance(before.place(y), room_.poses[b].place(y)));
      }
    }
    return way;
  }

  // ---- near patches -------------------------------------------------------------------------------------------------------

  void find_near(double way) noexcept {
    for (const FaceNetwork& network : faces_.networks()) {
      const std::size_t count = network.end_patch - network.first_patch;
      for_each_task(parallel_, tasks_of(count, patches_per_task), [&](std::size_t task) {
        const std::size_t first = network.first_patch + task * patches_per_task;
        for (std::size_t p = first; p < std::min(network.end_patch, first + patches_per_task); ++p) look_at(network, p, way);
      });
    }
    room_.near.clear();
    for (std::size_t p = 0; p < faces_.patches().size(); ++p) {
      if (!(room_.travelled < room_.due[p])) room_.near.push_back(static_cast<std::uint32_t>(p));
    }
  }
  // Finds when patch p may next be near a body, and the box about its way.
  void look_at(const FaceNetwork& network, std::size_t p, double way) noexcept {
    if (room_.travelled < room_.due[p]) return;
    const FacePatch& patch = faces_.patches()[p];
    FaceBox box;
    for (std::size_t n = patch.first_corner; n < patch.end_corner; ++n) {
      const std::size_t i = faces_.corners()[n];
      box.add(at(room_.now, i));
      box.add(at(work_.x, i));
    }
    room_.boxes[p] = box;
    double gap = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < bodies().size(); ++b) {
      if (network.is_wider_than(bodies()[b])) gap = std::min(gap, gap_to(b, box, way));
    }
    room_.due[p] = room_.travelled + (gap > 0 ? gap : 0);
  }
  // Returns a lower bound of the gap, m; above 0, nothing in the box touches the body in this sub-step.
  [[nodiscard]] double gap_to(std::size_t b, const FaceBox& box, double way) const noexcept {
    const FaceBody& shape = bodies()[b].shape;
    return 0.999 * box.gap_to(shape, room_.poses[b]) - (1e-6 * shape.radius + way);
  }

  // ---- meetings -----------------------------------------------------------------------------------------------------------

  void meet_near(const Clock& start, double h, double way) noexcept {
    const int count = parts_of(h, way);
    if (count == 0) return;
    gather_corners();
    for (int number = 1; number <= count; ++number) {
      const FacePart part{number, count, h};
      Clock now = start;
      now.advance(h / count * number, 1);
      go_on(part);
      for (const FaceNetwork& network : faces_.networks()) {
        for (std::size_t b = 0; b < bodies().size(); ++b) {
          if (room_.is_met[b] == 0 || !network.is_wider_than(bodies()[b])) continue;
          BodyPose pose = room_.poses[b];
          if (number != count && bodies()[b].motion) {
            const BodyPose then = pose_at(bodies()[b], now);
            pose.center = then.center;
            pose.axes = then.axes;
          }
          meet(network, b, pose, part, way);
        }
      }
    }
    for (const std::uint32_t i : room_.corners) room_.is_listed[i] = 0;
  }

  // Finds which bodies are met, and returns the number of parts of the sub-step; 0: nothing is met.
  [[nodiscard]] int parts_of(double h, double way) noexcept {
    double least = std::numeric_limits<double>::infinity();
    double fastest = 0;
    std::fill(room_.is_met.begin(), room_.is_met.end(), std::uint8_t{0});
    for (const FaceNetwork& network : faces_.networks()) {
      for (std::size_t b = 0; b < bodies().size(); ++b) {
        if (room_.is_met[b] != 0 || !network.is_wider_than(bodies()[b])) continue;
        const auto is_met = [&](std::uint32_t p) { return holds(network, p) && !(gap_to(b, room_.boxes[p], way) > 0); };
        if (std::none_of(room_.near.begin(), room_.near.end(), is_met)) continue;
        room_.is_met[b] = 1;
        const FaceBody& shape = bodies()[b].shape;
        least = std::min(least, shape.radius);
        const BodyPose& pose = room_.poses[b];
        const double arm = distance(pose.center, pose.at) + (length(shape.low) + length(shape.high));
        fastest = std::max(fastest, (length(pose.velocity) + length(pose.angular_velocity) * arm) * std::abs(h));
      }
    }
    if (!(least < std::numeric_limits<double>::infinity())) return 0;
    double farthest = 0;
    for (const std::uint32_t p : room_.near) {
      const FacePatch& patch = faces_.patches()[p];
      for (std::size_t n = patch.first_corner; n < patch.end_corner; ++n) {
        const std::size_t i = faces_.corners()[n];
        const double gone = length(difference(at(work_.x, i), at(room_.now, i)));
        if (gone > farthest) farthest = gone;
      }
    }
    const double parts = (farthest + fastest) / (0.5 * least);
    return parts < most_face_parts ? 1 + static_cast<int>(parts) : most_face_parts;
  }

  static bool holds(const FaceNetwork& network, std::uint32_t p) noexcept {
    return p >= network.first_patch && p < network.end_patch;
  }

  void gather_corners() noexcept {
    room_.corners.clear();
    for (const std::uint32_t p : room_.near) {
      const FacePatch& patch = faces_.patches()[p];
      for (std::size_t n = patch.first_corner; n < patch.end_corner; ++n) {
        const std::uint32_t i = faces_.corners()[n];
        if (room_.is_listed[i] != 0) continue;
        room_.is_listed[i] = 1;
        room_.corners.push_back(i);
      }
    }
  }

  void go_on(const FacePart& part) noexcept {
    const T left = static_cast<T>(part.count - part.number + 1);
    for (const std::uint32_t i : room_.corners) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        T& now = room_.now[axis][i];
        room_.was[axis][i] = now;
        const T to = work_.x[axis][i];
        now = part.number == part.count ? to : now + (to - now) / left;
      }
    }
  }

  void meet(const FaceNetwork& network, std::size_t b, const BodyPose& pose, const FacePart& part, double way) noexcept {
    for (const std::uint32_t p : room_.near) {
      if (!holds(network, p) || gap_to(b, room_.boxes[p], way) > 0) continue;
      const FacePatch& patch = faces_.patches()[p];
      for (std::size_t t = patch.first; t < patch.end; ++t) meet(faces_.triangles()[t], bodies()[b], pose, part);
    }
  }

  void meet(const FaceContacts::Corners& of, const ThinBody& body, const BodyPose& pose, const FacePart& part) noexcept {
    if (of[0] == FaceContacts::nowhere) return;
    FaceCorners corners;
    corners.now = {at(room_.now, of[0]), at(room_.now, of[1]), at(room_.now, of[2])};
    if (!may_meet(body.shape, pose, corners.now)) return;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = of[k];
      corners.w[k] = double{work_.w[i]};
      corners.was[k] = at(room_.was, i);
      corners.to[k] = at(work_.x, i);
      corners.v[k] = at(work_.v, i);
    }
    FacePulse pulse;
    if (!find_pulse(body.shape, pose, corners, part, pulse)) return;
    const auto add = [](const std::array<T*, 3>& columns, std::size_t i, const Vec3& by, double share) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        columns[axis][i] = static_cast<T>(double{columns[axis][i]} + share * by[axis]);
      }
    };
    for (std::size_t k = 0; k < 3; ++k) {
      add(room_.now, of[k], pulse.move, pulse.share[k]);
      add(work_.x, of[k], pulse.move_on, pulse.share[k]);
      add(work_.v, of[k], pulse.dv, pulse.share[k]);
    }
    pushed_ += *std::max_element(pulse.share.begin(), pulse.share.end()) * length(pulse.move_on);
    if (report_ != nullptr) report(body.contact, pulse);
  }

  void report(std::size_t contact, const FacePulse& pulse) noexcept {
    if (sums_ && sums_->contact() != contact) {
      sums_->join(*report_);
      sums_.reset();
    }
    if (!sums_) sums_.emplace(contact);
    const Vec3 arm = difference(sum(pulse.x, of_.origin), report_->centers[contact].at);
    sums_->add(pulse.impulse, cross(arm, pulse.impulse));
    if (pulse.is_impact) sums_->count_hits(1);
  }

  const FacesOfScene of_;
  const FaceContacts& faces_;
  FaceRoom<T>& room_;
  const WorkColumns<T>& work_;
  const ParallelFor& parallel_;
  ContactReport::Parts* report_;
  std::optional<ContactSums> sums_;  // of the contact that was met last
  double pushed_ = 0;                // m: no particle was pushed farther in this sub-step
};

}  // namespace dvdx
