// Particles that stand still under the pulses of a network, and stay.
//
// Pulse.   Springs act between flows, by a velocity at one time; gravity and what holds a particle act all through a flow.
//          Pulled along a surface by a pulse h F, a particle that friction should hold is braked only in the flow after it, and
//          goes F h^2/2 on the way, in each sub-step again: a creep of F h/2. Pulses of fourth_order besides differ, one of
//          them is negative, and two flows go back. In none of them does what a flow sees tell what a sub-step does.
// Rule.    A particle that stands still where a flow ends, v = V of the surface that it is on, is judged by the impulse of a
//          whole sub-step,
//            P = (v - V) / b + g / a,
//          v after the pulse since, V that of the surface at the end of the flow, g what the other forces give in the flow, b
//          and a the parts of the sub-step that pulse and flow are of (a < 0 in flows that go back, and g with it). It is the
//          same in every flow where the force is constant. The surfaces that go by V take from P what rest_reference.hpp
//          takes from a velocity: one, two or three of them, by their normal pulses and friction. Where nothing is left, the
//          particle stays with them, at rest to the last bit. Else it goes on as any does.
// Wait.    The pulse that follows the first flow of a step is not known in it: what stands still waits. Where it does not stay
//          after the pulse, it is given what it has missed of the other forces, g of the next flow by their durations.
// Limits.  One particle that hangs still at a surface's height and is not pressed waits for half a sub-step once. A force that
//          changes within a sub-step is judged by what it is in each of its flows.
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

// How the impulse of a sub-step follows from what one flow sees.
template <class T>
struct SubstepImpulse {
  T t = 0;       // s: the flow
  T pulses = 0;  // sub-steps' worth in a pulse: 0 where none has been since the step began, and what stands still waits
  T flows = 0;   // flows of this duration in a sub-step
  T owed = 0;    // flows of this duration that particles have waited for
};

template <class T>
struct StayKernels {
  // A particle that stood still with the surface `carrier`, or with surfaces at rest where there is none of that number, at x0,
  // has the velocity v0 after the pulse. The surface that it stays on, or waits on, or no_surface. v1: what the other forces
  // give it in the flow. Where there is one x1 and v1 are then its end.
  std::uint32_t (*stays)(const Terms<T>&, const SubstepImpulse<T>&, std::size_t carrier,
                         reference::Particle<T>&) noexcept = nullptr;
  // The surface that moves, on which a particle stands still t before the end of a flow, or no_surface. movers: a surface of
  // each motion, or none of it.
  std::uint32_t (*carrier)(const Terms<T>&, std::span<const std::uint32_t> movers, T t, const std::array<T, 3>& x,
                           const std::array<T, 3>& v) noexcept = nullptr;
};

template <class T>
StayKernels<T> stay_kernels(Arithmetic arithmetic) noexcept;

extern template StayKernels<float> stay_kernels<float>(Arithmetic) noexcept;
extern template StayKernels<double> stay_kernels<double>(Arithmetic) noexcept;

}  // namespace dvdx
