// Logs the effect of contacts on particles. The wide pass logs particles that a single plane holds or throws back, a register
// at a time. The scalar twin resolves all other particles that touch a surface if a block has a log.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dvdx/isa.hpp"
#include "flow/terms.hpp"
#include "simd/particle.hpp"

namespace dvdx {

// A change dv of a particle's velocity by a surface, at x, at the time t before the end of the flow.
template <class T>
struct ContactPush {
  std::size_t particle = 0;  // its index in the plan's columns
  std::size_t contact = 0;
  std::array<T, 3> x{}, dv{};
  T t = 0;
};

// The same for particles side by side, with 0 in the other lanes.
template <class T>
struct ContactPushes {
  static constexpr std::size_t most = 16;
  std::size_t first = 0;    // index of lane 0 in the plan's columns
  std::uint64_t lanes = 0;  // lane k is bit k
  std::array<std::uint32_t, most> contact{};
  alignas(64) std::array<std::array<T, most>, 3> x{}, dv{}, n{};  // n: only of impacts
  alignas(64) std::array<T, most> t{};
};

template <class T>
class ContactLog;

// Looks for touches of a particle, resolves them and logs them.
template <class T>
using ResolveLogged = void (*)(const Terms<T>&, const Offsets<T>&, reference::Particle<T>&, std::size_t particle,
                               ContactLog<T>&);

// Receives the effects of contacts on some particles, on one thread.
template <class T>
class ContactLog {
 public:
  explicit ContactLog(ResolveLogged<T> resolve_) noexcept : resolve(resolve_) {}
  ContactLog(const ContactLog&) = delete;
  ContactLog& operator=(const ContactLog&) = delete;

  virtual void take_impact(const ContactPush<T>& push, const std::array<T, 3>& normal) noexcept = 0;
  // A push by a surface that holds a particle, spread evenly about the given time, or that puts it back outside.
  virtual void take_hold(const ContactPush<T>& push) noexcept = 0;
  virtual void take_impacts(const ContactPushes<T>& pushes) noexcept = 0;
  virtual void take_holds(const ContactPushes<T>& pushes) noexcept = 0;

  const ResolveLogged<T> resolve;

 protected:
  ~ContactLog() = default;
};

template <class T>
ResolveLogged<T> resolve_logged(Arithmetic arithmetic) noexcept;

extern template ResolveLogged<float> resolve_logged<float>(Arithmetic) noexcept;
extern template ResolveLogged<double> resolve_logged<double>(Arithmetic) noexcept;

}  // namespace dvdx
