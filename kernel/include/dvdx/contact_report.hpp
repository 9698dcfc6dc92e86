// The effect of a scene's contacts on its particles: sums for each contact, and the impacts one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dvdx/export.h"
#include "dvdx/values.hpp"

namespace dvdx {

// All that particles have done to one contact's surface: by impacts, by resting on it, and where they were put back outside.
// Pulses of a body on faces of cloth (Scene::faces) count as well; events are those of particles alone.
struct ContactSum {
  std::uint64_t hits = 0;  // impacts; of a face one in each sub-step in which it comes in
  Vec3 impulse{};          // N s, on the surface
  Vec3 torque_impulse{};   // N m s, about the moved center of its motion, else about its own center or the origin
};

// An impact. Resting on a surface makes none.
struct ContactEvent {
  std::uint64_t step = 0;  // at whose end the particle has bounced: the first is 1
  double time = 0;         // s, of the scene
  std::size_t particle = 0;
  std::size_t contact = 0;
  Vec3 x{};        // m, where, in the world
  Vec3 n{};        // the surface's normal there, of length 1
  Vec3 impulse{};  // N s, on the surface
};

// Takes the reports of one state's steps; one that was moved from is of no contacts, and takes none. The sums are exact until
// they are rounded once: they depend on neither instruction set, threads, blocks nor layout, nor on how the particles are split
// among several reports that are added up.
class DVDX_EXPORT ContactReport {
 public:
  struct Parts;  // private to the library

  // For a plan whose scene has so many contacts. Events go to `room`, memory of the caller's; what does not fit there is
  // counted. Without room nothing is kept of them.
  explicit ContactReport(std::size_t contacts, std::span<ContactEvent> room = {});
  ContactReport(ContactReport&&) noexcept;
  ContactReport& operator=(ContactReport&&) noexcept;
  ~ContactReport();

  [[nodiscard]] std::size_t contacts() const noexcept;
  [[nodiscard]] ContactSum of(std::size_t contact) const noexcept;
  // In the order of step, particle, time.
  [[nodiscard]] std::span<const ContactEvent> events() const noexcept;
  [[nodiscard]] std::uint64_t lost() const noexcept;  // events that found no room. Which of a call's were kept is left open
  // Steps taken so far: events are numbered on from here.
  [[nodiscard]] std::uint64_t steps() const noexcept;
  void set_steps(std::uint64_t steps) noexcept;

  void clear_events() noexcept;
  void clear() noexcept;  // and the sums; steps() stays

  // The sums as whole numbers, each of which is added up by itself: to keep them, to go on with them, to join reports of the
  // parts of a state. As many for every report of so many contacts.
  [[nodiscard]] std::span<const std::int64_t> words() const noexcept;
  void add(std::span<const std::int64_t> words) noexcept;

  [[nodiscard]] Parts* parts() noexcept { return parts_; }  // private to the library; null where it was moved from

 private:
  Parts* parts_;  // owned
};

}  // namespace dvdx
