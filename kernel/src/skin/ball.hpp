// Particles that may not leave a ball, or not enter one: near a skin, in front of it, on a tether. The balls move.
// Which particle is tethered to which: skin/tethers.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dvdx/network.hpp"
#include "springs/network.hpp"

// Equation      e = x - c, |e| <= r (`at_most`) or |e| >= r (`at_least`), c the ball's center, which moves at c'.
//               All below is in its frame: e, and u = v - c'. Particles do not move the ball, so each is solved by itself.
// Solution      Over a sub-step h, n = e at its start, and e, u are where flows and pulses alone lead. If the bound is broken,
//               it was reached at the part f: |p| = r, p = n + f (e - n), and tau = (1 - f) h is left. A particle that was on
//               the ball already (on_ball) has f = 0 and p = n r/|n|. Then a constraint's paired pulses act, one end given:
//                 position pulse   e' = e + s p,  |e'| = r,   and u' = u + s p / tau
//                 velocity pulse   u'' = u' + m e',  so that u''.e' = 0,  as far as both together pull (or push): m is at most
//                                  -s / tau for `at_most`, at least that for `at_least`
// Energy        If nothing else acts within tau, e = p + tau u and e' = p + tau u', so u'.e' = tau |u'|^2/2 = -u'.p, and u'
//               keeps the part of u across p. Hence |u''|^2 = |u'|^2 - (u'.e'/r)^2 = |u|^2 - (u.p/r)^2: the part along p is
//               lost, the part across it is kept to the last digit, whatever h is. If m is cut off,
//               |u''|^2 = |u|^2 - 2 (s/tau) tau |u'|^2 <= |u|^2. Forces within tau do work on another way than without the
//               ball. The pulses are right to second order in this work.
// Violated      A particle that begins beyond the bound (a target that jumps, a radius below the start) is first set onto the
//               ball, at n r/|n|, and e moves along with n. This gives no velocity.
// Order         Second in h for a particle that stays on the ball. An impact on it costs one order for its moment.
// Limits        If e' is 90 degrees or more from p, the sub-step is too long for paired pulses. `at_most` then has
//               e' = e r/|e|. `at_least` keeps only the part across p of the rest of the way, so e' lies on the plane that
//               touches the ball at p. A particle that has gone right through the ball does the same. Both lose the part of u
//               that breaks the bound, and gain nothing. r = 0 is the center and its velocity. A particle whose x or v is not
//               finite, or that is held, is left alone.

namespace dvdx {

template <class T>
struct BallTerms {
  const std::int32_t* element = nullptr;  // of each particle; in unused lanes one beyond the particles
  const T* r = nullptr;                   // m
  std::array<T*, 3> c{}, u{};             // m and m/s: centers and their velocities at the sub-step's end
  std::array<T*, 3> n{};                  // m: the particles' positions relative to the centers at its start
  T per_step{};                           // 1/h
};

// The least part of a sub-step that counts as left after a bound was reached. A pulse in a shorter time would only amplify
// rounding; the velocity pulse corrects the remainder.
template <class T>
inline constexpr T least_part_left = T(1) / T(16);

// A particle is on the ball if |n|^2 is this near to r^2, relative to r^2.
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
