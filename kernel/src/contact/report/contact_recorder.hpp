// Turns the effects of contacts on particles into the sums and events of a report.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "contact/report/contact_log.hpp"
#include "dvdx/contact_report.hpp"
#include "dvdx/plan.hpp"
#include "math/exact_sum.hpp"
#include "motion/driven.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// The point about which the torque of a contact is taken: its place at the end of the flow, m in the world, and its velocity.
struct TorqueCenter {
  Vec3 at{}, velocity{};
};

// The words of one contact: the hits, then three sums of the impulse and three of its torque.
inline constexpr std::size_t contact_sums = 6;
inline constexpr std::size_t contact_words = 1 + contact_sums * exact_words;

struct ContactReport::Parts {
  Parts(std::size_t contacts, std::span<ContactEvent> room_)
      : words(contacts * contact_words), centers(contacts), room(room_) {}

  std::vector<std::int64_t> words;
  std::vector<TorqueCenter> centers;
  std::span<ContactEvent> room;
  std::atomic<std::size_t> claimed{0};   // events that asked for room, also those that found none
  std::atomic<std::uint64_t> joined{0};  // sums joined since the last carry
  std::size_t kept = 0;                  // events, in order
  std::uint64_t lost = 0;
  std::uint64_t steps = 0;
};

// Begin and end a call of step(), on the calling thread.
void begin_report(ContactReport::Parts& report, const Scene& scene) noexcept;
void end_report(ContactReport::Parts& report, std::size_t steps) noexcept;

// Impulse and torque of particles side by side, 0 where there is none.
using ContactTerms = std::array<std::array<double, ExactLanes::lanes>, contact_sums>;

// The sums of one contact on one thread, until they join the report.
class ContactSums {
 public:
  explicit ContactSums(std::size_t contact) noexcept : contact_(contact) {}

  [[nodiscard]] std::size_t contact() const noexcept { return contact_; }
  void count_hits(int hits) noexcept { hits_ += hits; }
  void add(const Vec3& impulse, const Vec3& torque) noexcept;
  void add(const ContactTerms& terms) noexcept;
  void join(ContactReport::Parts& report) noexcept;

 private:
  static constexpr std::uint32_t most_terms = 1U << 28U;
  static constexpr std::size_t few_waiting = 4;

  void add(std::size_t sum, double term) noexcept;
  void add_waiting() noexcept;

  std::size_t contact_;
  std::int64_t hits_ = 0;
  std::uint32_t terms_ = 0;
  std::array<std::array<std::int64_t, exact_words>, contact_sums> words_{};
  std::array<std::size_t, contact_sums> first_{exact_words, exact_words, exact_words, exact_words, exact_words, exact_words};
  std::array<std::size_t, contact_sums> end_{};
  std::array<ExactLanes, contact_sums> lanes_{};
  ContactTerms waiting_;  // of single particles, until they fill the lanes
  std::size_t waiting_count_ = 0;
};

// The particle at an element of a plan's columns, if surfaces can move it.
class LoggedParticles {
 public:
  // Elements in the order of the state, from particle `first` on.
  LoggedParticles(const Scene& scene, std::size_t first, std::size_t count) noexcept
      : scene_(scene), first_(first), count_(count) {}
  // Elements of `order`, with particles below `count`. is_own: null, or 0 for particles that another part of the batch logs.
  LoggedParticles(const Scene& scene, const ParticleOrder& order, std::size_t count, std::span<const double> inverse_masses,
                  const std::uint8_t* is_own) noexcept
      : scene_(scene), count_(count), order_(&order), inverse_masses_(inverse_masses), is_own_(is_own) {}

  [[nodiscard]] std::optional<std::size_t> number(std::size_t element) const noexcept;
  // Whether element i is particle first() + i.
  [[nodiscard]] bool are_in_order() const noexcept { return order_ == nullptr && scene_.fixed.empty(); }
  [[nodiscard]] std::size_t first() const noexcept { return first_; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] double mass(std::size_t number) const noexcept { return scene_.mass[number]; }  // kg
  [[nodiscard]] Vec3 origin() const noexcept { return scene_.origin.at(0); }                    // m, of all particles

 private:
  const Scene& scene_;
  std::size_t first_ = 0, count_ = 0;
  const ParticleOrder* order_ = nullptr;
  std::span<const double> inverse_masses_;
  const std::uint8_t* is_own_ = nullptr;
};

// The log of one task.
template <class T>
class ContactRecorder final : public ContactLog<T> {
 public:
  ContactRecorder(ContactReport::Parts& report, const LoggedParticles& particles, Arithmetic arithmetic) noexcept
      : ContactLog<T>(resolve_logged<T>(arithmetic)), report_(report), particles_(particles) {}
  ~ContactRecorder();

  // Begins a flow of the report's step `step`, from `start` on, of h seconds.
  void begin(std::uint64_t step, const Clock& start, double h) noexcept {
    step_ = step;
    start_ = start;
    h_ = h;
  }
  void take_impact(const ContactPush<T>& push, const std::array<T, 3>& normal) noexcept override;
  void take_hold(const ContactPush<T>& push) noexcept override;
  void take_impacts(const ContactPushes<T>& pushes) noexcept override;
  void take_holds(const ContactPushes<T>& pushes) noexcept override;

 private:
  struct Impulse {
    std::size_t particle = 0;
    Vec3 x{}, on_surface{};
  };

  std::optional<Impulse> add(const ContactPush<T>& push, bool is_hit) noexcept;
  // Particles side by side: numbers, masses, and as `lanes` those that surfaces can move.
  struct Side {
    std::array<std::size_t, ExactLanes::lanes> particle;
    std::array<double, ExactLanes::lanes> mass;  // kg
    std::uint64_t lanes;
  };
  [[nodiscard]] Side side_of(const ContactPushes<T>& pushes) const noexcept;
  void add(const ContactPushes<T>& pushes, bool are_hits) noexcept;
  void add(const ContactPushes<T>& pushes, const Side& side, bool are_hits) noexcept;
  static constexpr int few = 6;  // fewer lanes of one contact are added one by one
  void add_each(const ContactPushes<T>& pushes, std::uint64_t lanes, bool are_hits) noexcept;
  void keep_event(const Impulse& impulse, std::size_t contact, const std::array<T, 3>& normal, T t) noexcept;
  ContactSums& sums_of(std::size_t contact) noexcept;

  ContactReport::Parts& report_;
  const LoggedParticles& particles_;
  std::uint64_t step_ = 0;
  Clock start_{};
  double h_ = 1;
  std::array<std::optional<ContactSums>, 4> sums_;  // of the contacts touched last
};

extern template class ContactRecorder<float>;
extern template class ContactRecorder<double>;

}  // namespace dvdx
