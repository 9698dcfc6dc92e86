// Particles that may not leave a ball, or not enter one: near a skin, in front of it, on a tether. The balls move.
// Which particle is tethered to which: skin/tethers.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dvdx/network.hpp"
#include "springs/network.hpp"

// Equation      e = x - c, |e| <= r (`at_most`) or |e| >= r (`at_least`), c the ball's center, which moves at c'.
//               All below is in its frame: e, and u = v - c'. Nothing else moves the ball: each particle is solved by itself.
// Solution      Over a sub-step h, with n = e at its start and e, u where flows and pulses alone lead. If the bound is broken,
//               it was reached at the part f, |p| = r, p = n + f (e - n), and tau = (1 - f) h is left. A particle that was on
//               the ball already (on_ball) has f = 0 and p = n r/|n|. Then a constraint's paired pulses, one end given:
//                 position pulse   e' = e + s p,  |e'| = r,   and u' = u + s p / tau
//                 velocity pulse   u'' = u' + m e',  so that u''.e' = 0,  as far as both together pull (or push): m is at most
//                                  -s / tau of `at_most`, at least that of `at_least`
// Energy        Where nothing else acts within tau: e = p + tau u and e' = p + tau u', so u'.e' = tau |u'|^2/2 = -u'.p, and u'
//               has of u what is across p. Hence |u''|^2 = |u'|^2 - (u'.e'/r)^2 = |u|^2 - (u.p/r)^2: what goes along the bound
//               is lost, what goes across it is kept to the last digit, whatever h is. Where m is cut off
//               |u''|^2 = |u|^2 - 2 (s/tau) tau |u'|^2 <= |u|^2. Forces within tau do work on another way than without the
//               ball, of which the pulses are right to second order.
// Violated      A particle that begins beyond the bound (a target that jumps, a radius below the start) is set onto the ball
//               first, at n r/|n|, and e is moved as n is. No velocity comes of that.
// Order         Second in h for a particle that stays on the ball; an impact on it costs one order for its moment.
// Limits        Where e' is 90 degrees or more from p the sub-step is too long for pairs. For `at_most` e' = e r/|e|. For
//               `at_least` e' keeps of the rest of the way what is across p, and lies on the plane that touches the ball there;
//               so does what has gone right through the ball. Both lose of u what breaks the bound, and gain nothing.
//               r = 0 is the center and its velocity. A particle whose x or v is not finite, or that is held, is left alone.

namespace dvdx {

template <class T>
struct BallTerms {
  const std::int32_t* element = nullptr;  // of each particle; where there is none, one beyond the particles
  const T* r = nullptr;                   // m
  std::array<T*, 3> c{}, u{};             // m and m/s: centers and their velocities at the sub-step's end
  std::array<T*, 3> n{};                  // m: where the particles were from the centers at its start
  T per_step{};                           // 1/h
};

// A bound that is reached so late in the sub-step is taken for one reached here: a pulse in a shorter time would only amplify
// rounding, and the velocity pulse makes good what it leaves.
template <class T>
inline constexpr T least_part_left = T(1) / T(16);

// A particle whose |n|^2 is so near to r^2, relative to it, is on the ball.
template <class T>
inline constexpr T on_ball = sizeof(T) == 4 ? T(1e-3) : T(1e-8);

// Balls [from, to), multiples of 16
template <class T>
struct BallKernels {
  // n = x - c
  void (*prepare)(const BallTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  // both pulses; then n = x - c
  void (*keep)(const BallTerms<T>&, Bound, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
};

}  // namespace dvdx
