// Air on triangles of cloth: the pulse of a duration t. It changes velocities alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "springs/network.hpp"

// Equation      of one triangle, with s = (x_b - x_a) x (x_c - x_a) = 2 A n, N = |s|, u = wind - (v_a + v_b + v_c)/3, U = |u|,
//               c = |s.u| / (N U), sigma = s.u, D drag, L lift, rho the air's density:
//                 F = rho N U/4 ((D c - L c^2) u + L c U n),   n = s sign(sigma) / N
//               with q = rho U A/2 = rho N U/4. A corner of inverse mass w takes w F/3.
// Mass          A particle is a corner of k triangles, which act at once. Each triangle is given a kth part of the particle's
//               mass, with the particle's velocity, and moves that part alone. The particle's velocity then is the mean of its
//               parts (mass splitting: Tonge, Benevolenski and Voroshilov 2012). The triangle's u changes by
//                 u' = -W F,   W = sum over its corners of k w / 9.
//               If all triangles meet the same air, the parts stay together and the split changes nothing.
// Solution      u' = -W F turns u in the plane of u and n, away from n, and shortens it:
//                 U' = -(W rho N/4) D c U^2,   phi' = (W rho N/4) U L c sin phi,   c = cos phi
//               U c shrinks at the relative rate (W rho N U/4)(D c + L sin^2 phi). So with
//                 eta = t W rho N U/8,   x = L eta,   y = D c eta,   z = sin^2 phi = 1 - c^2
//               the coefficients at the middle of t are those at its start over 1 + x z + y, and the pulse is
//                 a = 1 + x z,   u(t) = a / (a + 2 y) R u,   tan(angle of R / 2) = lambda sin phi,
//                 l = L c (1 + x) / (1 + 2 x z + y + x^2 (1 + 3 z)/2),   lambda = eta l
//               The factor is exact if L = 0, or if c = 1 and the air meets the cloth face on: 1 / (1 + 2 y) then solves
//               U' = -const U^2. Otherwise both are right to second order in t.
// Limits        0 < a / (a + 2 y) <= 1 and lambda sin phi <= cos phi / (1 + sin phi) = tan((90 deg - phi)/2) for every t:
//               u is never lengthened, never turned beyond the triangle's plane, and so never reversed. Proof of the second:
//               (x + x^2)(sin phi + z) <= 1 + 2 x z + x^2 (1 + 3 z)/2 term by term, with sin phi <= (1 + z)/2 and, for the
//               part x sin phi (1 - sin phi) that is left over, 1 + x^2 (1 - sin phi)^2/2 >= x (1 - sin phi) sqrt 2. The
//               energy of a part relative to the wind changes by (|u(t)|^2 - |u|^2) / (2 W) <= 0, and the mean of the parts has
//               no more than they have together. So the cloth gains none, whatever the step and the density are.
// Step          One triangle's change of momentum is p(u) = (u - u(t)) / W, with everything divided by eta, so that W may be 0:
//                 b = a + 2 y,   m = 1 + lambda^2 z
//                 p = t rho N U / (4 b m) ((D c m + a l (lambda z - c)) u + a l (U / N) s sign(sigma))
//               This assumes that neighbours move the corners within t as the triangle itself does. Hence two stages:
//                 first   p_1 = p(u),   g = (w/3) sum of the p_1 at a particle / 2: the change of v in half of t
//                 second  e = mean of g over the corners - W p_1/2,   p_2 = p(u - e U^2 / (U^2 + 4 e^2)),
//               and v += (w/3) sum of the p at a particle, p = p_2 where p_2.u >= W p_2^2/2, else p_1. The condition is that
//               the parts gain no energy relative to the wind, which p_1 always meets. e is of first order in t, and its factor
//               is 1 but for second order, so p is p_2 below some t if D > 0. If all meet the same air, e is 0. The pulse is in
//               the middle of the springs' pulse: u is made of the mean of the velocities before and after that.
// Order         Second in t. If D = 0, the part of e that is left is of first order.
// Source        The force: the contract of the scene's files; drag and lift of a flat plate as in Keckeisen et al. 2004.

namespace dvdx {

// A triangle with an eta above this, or NaN, counts as bad and meets no air.
template <class T>
inline constexpr T most_air = sizeof(T) == 4 ? T(1e+15) : T(1e+100);

// One pulse of one network.
template <class T>
struct AirPulse {
  T rate{};  // t rho/8
  T push{};  // t rho/12
  T drag{}, lift{};
  std::array<T, 3> wind{};  // m/s
};

enum class AirStage : std::uint8_t { first, second };

// A grid's cells. Each is cut into two triangles: (row, column), (row + 1, column + 1), (row, column + 1), and the same first
// two with (row + 1, column). Both stand at the element of (row, column). W below 0: no triangle.
template <class T>
struct GridAirTerms {
  std::size_t rows = 0, columns = 0, pitch = 0;
  const T *W_right = nullptr, *W_below = nullptr;
  std::array<T*, 3> p_right{}, p_below{};  // N s: p_1/3 of each triangle
  std::array<T*, 3> g{};                   // m/s, of each particle
};

// A list of any triangles. First each triangle is computed, then each particle's sum in the order of the triangles' numbers.
template <class T>
struct TriangleTerms {
  const std::int32_t *a = nullptr, *b = nullptr, *c = nullptr;  // elements of each triangle's corners
  const T* W = nullptr;                                         // below 0: no triangle
  const std::uint32_t* first_slot = nullptr;                    // of each slice of particles, and one more
  const std::int32_t* slots = nullptr;  // 16 triangles each; unused ones are of a triangle with W below 0
  std::array<T*, 3> p{};                // N s: p/3 of each triangle
  std::array<T*, 3> g{};                // m/s, of each particle
};

template <class T>
struct AirKernels {
  // v_next = (v + v_next) / 2 for elements [from, to), multiples of 16
  void (*middle)(const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  // A stage for rows [from, to); the air meets v_next
  void (*grid)(const GridAirTerms<T>&, const AirPulse<T>&, const WorkColumns<T>&, AirStage, std::size_t from,
               std::size_t to) = nullptr;
  // triangles: p of a stage for triangles [from, to), multiples of 16. gather: its result at the particles of slices [from, to)
  void (*triangles)(const TriangleTerms<T>&, const AirPulse<T>&, const WorkColumns<T>&, AirStage, std::size_t from,
                    std::size_t to) = nullptr;
  void (*gather)(const TriangleTerms<T>&, const WorkColumns<T>&, AirStage, std::size_t from, std::size_t to) = nullptr;
};

}  // namespace dvdx
