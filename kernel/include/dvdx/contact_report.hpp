// Reports of a scene's contacts: sums for each contact, and the impacts one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dvdx/export.h"
#include "dvdx/values.hpp"

namespace dvdx {

// The effect of all particles on one contact's surface: impacts, resting contact, and corrections that put particles back
// outside. Pulses between a body and faces of cloth (Scene::faces) count as well; events are those of particles alone.
struct ContactSum {
  std::uint64_t hits = 0;  // impacts; a face counts once in each sub-step in which it approaches
  Vec3 impulse{};          // N s, on the surface
  Vec3 torque_impulse{};   // N m s, about the moved center of its motion, else about its own center or the origin
};

// An impact. Resting on a surface makes none.
struct ContactEvent {
  std::uint64_t step = 0;  // the step at whose end the particle has bounced: the first is 1
  double time = 0;         // s, of the scene
  std::size_t particle = 0;
  std::size_t contact = 0;
  Vec3 x{};        // m, the place in the world
  Vec3 n{};        // the surface's normal there, of length 1
  Vec3 impulse{};  // N s, on the surface
};

// Collects the reports of one state's steps. A moved-from report has no contacts and records nothing. The sums are exact and
// rounded once: they depend on neither instruction set, threads, blocks nor layout, nor on how the particles are split among
// several reports that are added up.
class DVDX_EXPORT ContactReport {
 public:
  struct Parts;  // private to the library

  // `contacts` is the number of the plan's contacts. Events go to `room`, memory of the caller's; further events are only
  // counted. An empty room keeps none.
  explicit ContactReport(std::size_t contacts, std::span<ContactEvent> room = {});
  ContactReport(ContactReport&&) noexcept;
  ContactReport& operator=(ContactReport&&) noexcept;
  ~ContactReport();

  [[nodiscard]] std::size_t contacts() const noexcept;
  [[nodiscard]] ContactSum of(std::size_t contact) const noexcept;  // all 0 for an index out of range
  // In the order of step, particle, time.
  [[nodiscard]] std::span<const ContactEvent> events() const noexcept;
  [[nodiscard]] std::uint64_t lost() const noexcept;  // events without room; which of a call's events are kept is unspecified
  // Steps taken so far. The next step's events are numbered from here.
  [[nodiscard]] std::uint64_t steps() const noexcept;
  void set_steps(std::uint64_t steps) noexcept;

  void clear_events() noexcept;
  void clear() noexcept;  // clears the sums too; steps() stays

  // The sums as whole numbers that add up one by one: to store them, to go on with them, to join reports of the parts of a
  // state. Their number depends on contacts() alone.
  [[nodiscard]] std::span<const std::int64_t> words() const noexcept;
  void add(std::span<const std::int64_t> words) noexcept;

  [[nodiscard]] Parts* parts() noexcept { return parts_; }  // private to the library; null if moved from

 private:
  Parts* parts_;  // owned
};

}  // namespace dvdx
