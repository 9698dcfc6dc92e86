// The bend of a step's path by springs, drag and forces of time, as the contact pass reads it.
#pragma once

#include <array>
#include <cstddef>

// Motion.  One axis of a particle within a step, phi = 0..1 the part of it that has passed, w = W h^2, q = g h:
//            x'' = F - w (x - x0) - q x',   F = h^2 f - w (x0 - c) the force at x0, in m
//          Responses from rest: velocity after a unit pulse (P0), way after a unit pulse (P1), way after a unit force (P2):
//            P2(phi) = sum_k d_k phi^(k+2)/(k+2)!,  d_0 = 1, d_1 = -q, d_(k+1) = -q d_k - w d_(k-1)
//            P1 = P2',  P0 = P1' = 1 - q P1 - w P2
//            path      x = x0 + h v0 P1 + F P2        v = v0 P0 + (F/h) P1
//            pulse dv at f:  x1 += h dv P1(1 - f),  v1 += dv P0(1 - f)
//          F and F/h follow from the step's two ends. Nothing else need be known of the forces, and the path meets both ends,
//          whatever method made them.
// Forces of time.  F gains D1 phi + D2 phi^2/2 + D3 phi^3/6, the cubic through the forces at four times of the step. With
//          P_k = int P_(k-1) the path gains D1 P3 + D2 P4 + D3 P5, and the velocity the same with each P one index lower. P5
//          and P4 = P5' are then the series, and P_(k-1) = phi^(k-1)/(k-1)! - q P_k - w P_(k+1) leads down to P0. The response
//          to a pulse does not depend on forces.
// Series.  `degree` terms for arguments up to 1/2. Larger arguments are taken at phi / 2^halvings and doubled by composing the
//          flow with itself, which is as stable as the flow:
//            P2(2a) = P2 (1 + A) + P1^2,  P1(2a) = P1 (A + P0),  P0(2a) = P0^2 - w P1^2,  A = 1 - w P2
//            P3(2a) = P3 (1 + A) + P2 P1 + a P2,  P4(2a) = P4 (1 + A) + P3 P1 + a P3 + a^2/2 P2,
//            P5(2a) = P5 (1 + A) + P4 P1 + a P4 + a^2/2 P3 + a^3/6 P2
// Source:  Hochbruck and Ostermann, Acta Numerica 2010 (phi functions); the same functions as math/psi.hpp, P_k = phi^k psi_k.

namespace dvdx {

// A column of coefficients for each axis; isotropic ones point to the same memory three times.
template <class T>
using AxisColumns = std::array<const T*, 3>;

inline constexpr std::size_t most_bend_terms = 20;

template <class T>
struct Bend {
  std::array<T, 3> w{}, q{};                            // where all particles are alike
  AxisColumns<T> w_each{}, q_each{};                    // or one for each particle: null if all are alike
  std::size_t axes = 1;                                 // 1: all axes are alike
  std::size_t degree = 0;                               // terms of the series; 0: nothing bends paths, which are parabolas
  bool is_driven = false;                               // forces depend on time
  int halvings = 0;                                     // number of halvings of a step, for the series
  int newton_steps = 0;                                 // from the parabola's time of impact
  bool is_far = false;                                  // far from a parabola: a Newton step out of its bracket halves it
  T scale = 1;                                          // 2^-halvings
  T corner = T(0.5);                                    // a path of a step lies in the triangle x0, x0 + corner h v0, x1
  std::array<T, most_bend_terms> inverse_factorials{};  // 1/(k+2)!, driven 1/(k+5)!
};

}  // namespace dvdx
