// Collects the effects of contacts on one particle in one flow for a log. Only the scalar twin uses it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "contact/report/contact_log.hpp"
#include "contact/surfaces/shape_reference.hpp"
#include "contact/surfaces/surface.hpp"

namespace dvdx::reference {

// A particle that stays on a surface makes no event.
enum class EventKind { impact, hold };

// A holding surface acts until the end of the flow or the next impact. Its push is logged when that time is known.
template <class T>
class Recording {
 public:
  Recording(ContactLog<T>& log, const Terms<T>& terms, std::size_t particle) noexcept
      : log_(log), surfaces_(terms.surfaces), particle_(particle) {}

  // Logs that the surface changed the velocity by dv at x, at the time t before the end.
  void push(EventKind kind, std::size_t surface, const Vector<T>& x, const Vector<T>& n, const Vector<T>& dv, T t) noexcept {
    if (kind == EventKind::impact) return log_.take_impact({particle_, contact_of(surface), x, dv, t}, n);
    log_.take_hold({particle_, contact_of(surface), x, dv, t});
  }

  // Begins a hold from x0 to x1 that lasts for t, up to the end of the flow.
  void begin_hold(const Vector<T>& x0, const Vector<T>& x1, T t) noexcept {
    x0_ = x0;
    x1_ = x1;
    t_ = t;
  }
  void hold(std::size_t surface, const Vector<T>& dv) noexcept { held_[count_++] = {contact_of(surface), dv}; }
  // Ends the hold after the part f of its time.
  void let_go(T f) noexcept {
    const T middle = f / 2;
    Vector<T> x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = x0_[k] + middle * (x1_[k] - x0_[k]);
    for (std::size_t n = 0; n < count_; ++n) {
      const auto& [contact, dv] = held_[n];
      log_.take_hold({particle_, contact, x, {f * dv[0], f * dv[1], f * dv[2]}, t_ - middle * t_});
    }
    count_ = 0;
  }

 private:
  struct Hold {
    std::size_t contact = 0;
    Vector<T> dv{};
  };

  [[nodiscard]] std::size_t contact_of(std::size_t surface) const noexcept { return surfaces_[surface].contact; }

  ContactLog<T>& log_;
  const Surface<T>* surfaces_;
  std::size_t particle_;
  Vector<T> x0_{}, x1_{};
  T t_ = 0;
  std::array<Hold, 3> held_{};
  std::size_t count_ = 0;
};

// Returns the multiples of three normals that sum up to v, or zeros if one is negative or the normals are nearly dependent.
template <class T>
std::array<T, 3> multiples(const Vector<T>& a, const Vector<T>& b, const Vector<T>& c, const Vector<T>& v) noexcept {
  const auto product = [](const Vector<T>& x, const Vector<T>& y, const Vector<T>& z) {
    return x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
  };
  const T det = product(a, b, c);
  const std::array<T, 3> of{product(v, b, c) / det, product(a, v, c) / det, product(a, b, v) / det};
  const bool is_sound = std::abs(det) > T(1e-3) && of[0] >= 0 && of[1] >= 0 && of[2] >= 0;
  return is_sound ? of : std::array<T, 3>{};
}

}  // namespace dvdx::reference
