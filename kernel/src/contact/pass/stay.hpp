// Particles that stand still, and stay so under the pulses of a network.
//
// Pulse.   Springs act between flows, as a change of velocity at one time. Gravity and holding surfaces act all through a flow.
//          If a pulse h F pulls a particle along a surface and friction should hold it, friction brakes it only in the next
//          flow. Meanwhile it moves by F h^2/2, in every sub-step: a creep of F h/2. Pulses of fourth_order also differ, one of
//          them is negative, and two flows go back. No single flow shows what the whole sub-step does.
// Rule.    A particle stands still at the end of a flow if v = V, the velocity of the surface that it is on. It is judged by
//          the impulse of a whole sub-step,
//            P = (v - V) / b + g / a,
//          v after the next pulse, V that of the surface at the end of the next flow, g the velocity that the other forces give
//          in that flow, b and a the parts of the sub-step that pulse and flow make up (a < 0 in flows that go back, and g with
//          it). P is the same in every flow if the force is constant. One, two or three surfaces that move by V take from P
//          what rest_reference.hpp takes from a velocity, by their normal pulses and friction. If nothing is left, the particle
//          stays with them, at rest to the last bit. Otherwise it goes on as any other.
// Wait.    In the first flow of a step the next pulse is not known yet, so a particle that stands still waits. If it does not
//          stay after the pulse, it gets the missed velocity of the other forces: g of the next flow, scaled by the durations.
// Limits.  A particle that hangs still at a surface's height and is not pressed waits once, for half a sub-step. A force that
//          changes within a sub-step is judged by its value in each flow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "flow/terms.hpp"
#include "simd/particle.hpp"

namespace dvdx {

inline constexpr std::uint32_t no_surface = 0xFFFFFFFF;

enum class Asked { stands, stays };

// The numbers by which the impulse of a sub-step follows from one flow.
template <class T>
struct SubstepImpulse {
  T t = 0;       // s: duration of the flow
  T pulses = 0;  // 1/b: such pulses in a sub-step; 0: none yet in this step, so particles that stand still wait
  T flows = 0;   // 1/a: flows of this duration in a sub-step
  T owed = 0;    // flows of this duration that particles have waited for
};

template <class T>
struct StayKernels {
  // Judges a particle that stood still at x0 on the surface `carrier`, or on surfaces at rest if there is no such index. v0:
  // its velocity after the pulse; v1: the velocity that the other forces give it in the flow. Returns the surface that it stays
  // or waits on, and sets x1 and v1 to its end, or returns no_surface.
  std::uint32_t (*stays)(const Terms<T>&, const SubstepImpulse<T>&, std::size_t carrier,
                         reference::Particle<T>&) noexcept = nullptr;
  // Returns the moving surface on which a particle stands still at the time t before the end of a flow, or no_surface. movers:
  // for each motion one of its surfaces, or no_surface.
  std::uint32_t (*carrier)(const Terms<T>&, std::span<const std::uint32_t> movers, T t, const std::array<T, 3>& x,
                           const std::array<T, 3>& v) noexcept = nullptr;
};

template <class T>
StayKernels<T> stay_kernels(Arithmetic arithmetic) noexcept;

extern template StayKernels<float> stay_kernels<float>(Arithmetic) noexcept;
extern template StayKernels<double> stay_kernels<double>(Arithmetic) noexcept;

}  // namespace dvdx
