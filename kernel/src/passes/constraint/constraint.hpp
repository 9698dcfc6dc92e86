// What the constraint passes read: constraints in colours, none of which has two at a particle that can move, and the table of
// passes that one instruction set provides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dvdx/isa.hpp"
#include "dvdx/network.hpp"

// Equation: C(x) = 0 with Jacobian J and inverse masses W, held by a force along J^T,
//   x' = v,   v' = W (F + J^T lambda),   C(x) = 0,   so that J v = 0
//
// Solution over a sub-step h from x_n: Brown's generic recipe, a pulse along J that brings the position into compliance and
// one that brings the velocity, paired as RATTLE pairs them (Andersen 1983). With x*, v* where the forces alone lead
//   position pulse   x_{n+1} = x* + W J(x_n)^T s   so that C(x_{n+1}) = 0,   and the velocity which takes it there,
//                    v = v* + W J(x_n)^T s / h
//   velocity pulse   v_{n+1} = v + W J(x_{n+1})^T m   so that J(x_{n+1}) v_{n+1} = 0
// of second order, and its own inverse with -h where the flow is. A pendulum from 90 degrees at 60 Hz, position error over 2 s:
// Brown's pulses with J(x_{n+1}) 1.2e-1 m, with J(x_n) 4.6e-2 m, position-based dynamics 2.2e-1 m, paired 1.6e-3 m.
//
// Distance: d = x_b - x_a, n = d at x_n (of any length), and the ends move by -+ (w / (w_a + w_b)) s n:
//   |d + s n| = l,   s = (l^2 - d.d) / (d.n + sqrt((d.n)^2 - n.n (d.d - l^2)))      the nearer root, without cancellation
//   m = -(d.u) / d.d along d
// Where there is no root, or d has turned away from n by 90 degrees or more, s = l/|d| - 1 along d, and the velocity is left to
// its own pulse.
// Bounds (<= l, >= l) act where they are violated: the sum of a constraint's pulses keeps the sign in which it can pull (or
// push), and the velocity pulse acts where the position pulse did. Where the bound was free at x_n, the violation began at the
// part f of the sub-step: |n + f (d - n)| = l on the straight line from n to d (as Brown has it); then n is that direction, and
// the velocity takes s / ((1 - f) h). A bob thrown until its rope of 1 m goes taut, 200 throws at 60 Hz: rms error of the
// energy after it 1.11e-2 J/kg and of the position 7.1e-4 m, against 1.28e-2 and 8.4e-4 with n at x_n.
//
// Chain: links d_k between particles k and k+1, each of which joins two at most, so that only neighbours meet in
//   d_k + (w_k + w_{k+1}) s_k n_k - w_k s_{k-1} n_{k-1} - w_{k+1} s_{k+1} n_{k+1},   of length l_k
// Newton's step for all s is one tridiagonal system, solved by elimination; the velocity pulse is another. A rope of 100 links
// of 1 cm swinging from the horizontal, 16 sub-steps of 1/960 s over 4 s: lengths to 1e-14, where 8 sweeps over its links leave
// 1.5e-1. Where a link turns by more than 45 degrees in a sub-step, or Newton's steps do not converge, the sub-step is too long
// for the chain's fast motion (of the order of sqrt(tension / (mass length)) of a link): its particles then follow each other
// from the fixed end, which keeps lengths and loses energy.
//
// Line: e = x - p, and the pulses take away what e and v have along two unit vectors across the line. Point: x = at, v = 0.
//
// Limits: several constraints at a particle are visited one after the other (Gauss-Seidel), forwards and backwards. A
// constraint both of whose ends are fixed, or whose ends coincide, or that has an end which is not finite, contributes nothing.
// What jumps over a bound (from one side of `at_least` to the other) within a sub-step is not seen.

namespace dvdx {

template <class T>
using Axes = std::array<T*, 3>;  // working columns

// Columns of one element a constraint; lanes without one join an element beyond the particles to itself.
template <class T>
struct PairTerms {
  const std::int32_t *a = nullptr, *b = nullptr;
  const T* l = nullptr;
  const T *share_a = nullptr, *share_b = nullptr;  // w / (w_a + w_b)
  Axes<T> n{};                                     // d at the sub-step's start, or where a bound was reached; then d at its end
  T* s = nullptr;                                  // sum of the position pulses, in units of n
  T* m = nullptr;                                  // of a bound: sum of the velocity pulses, in units of d
  T* inverse = nullptr;                            // 1 / d.d, 0 where no velocity pulse acts
  T* rate = nullptr;                               // of a bound: 1 / ((1 - f) h)
  T per_step{};                                    // 1/h
};

// Sixteen chains side by side make a bundle: element first[bundle] + 16 k + lane is particle k, and the link from it to the
// next. Links beyond a chain's end join an element beyond the particles.
template <class T>
struct ChainTerms {
  const std::uint32_t* first = nullptr;  // of each bundle
  const std::uint32_t* links = nullptr;  // of the longest chain of each bundle
  const std::int32_t* a = nullptr;
  const T* l = nullptr;
  const T* w = nullptr;                // relative to the chain's largest, 0 where fixed
  Axes<T> n{};                         // d at the sub-step's start, then at its end; 0 where a link contributes nothing
  Axes<T> kept{};                      // x before the position pulses
  T* s = nullptr;                      // sum of the position pulses
  T *over = nullptr, *rest = nullptr;  // elimination: x_k = rest - over x_{k+1}
  T per_step{};
  int newton = 1;  // steps at most
};

template <class T>
struct LineTerms {
  const std::int32_t* a = nullptr;
  Axes<T> p{}, n1{}, n2{};         // a point of the line, and two unit vectors across it
  T *s1 = nullptr, *s2 = nullptr;  // sums of the position pulses along n1 and n2
  T per_step{};
};

enum class Round : std::uint8_t { first, again };  // of a sub-step's sweeps: sums are 0 at the first

// A bound's velocity pulses keep the sign of its position pulses where time runs forwards.
enum class Time : std::uint8_t { forwards, backwards };

// Constraints [from, to) of one colour, multiples of 16; of chains, bundles.
template <class T>
struct ConstraintKernels {
  // n = d
  void (*prepare_pairs)(const PairTerms<T>&, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*prepare_chains)(const ChainTerms<T>&, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  // position pulses
  void (*solve_pair_positions)(const PairTerms<T>&, Bound, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*solve_chain_positions)(const ChainTerms<T>&, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*solve_line_positions)(const LineTerms<T>&, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  // the velocity that the position pulses take; then n = d
  void (*update_pair_velocities)(const PairTerms<T>&, Bound, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                 std::size_t to) = nullptr;
  void (*update_chain_velocities)(const ChainTerms<T>&, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                  std::size_t to) = nullptr;
  void (*update_line_velocities)(const LineTerms<T>&, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  // velocity pulses
  void (*solve_pair_velocities)(const PairTerms<T>&, Bound, Time, Round, const Axes<T>& v, std::size_t from,
                                std::size_t to) = nullptr;
  void (*solve_chain_velocities)(const ChainTerms<T>&, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  void (*solve_line_velocities)(const LineTerms<T>&, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
};

// The part of a sub-step that is taken to be left after a bound was reached is at least this: a pulse in a shorter time would
// only amplify rounding, and the velocity pulse makes good what it leaves.
template <class T>
inline constexpr T least_rest = T(1) / T(16);

// A chain whose squared lengths are all right to this needs no further step of Newton's.
template <class T>
inline constexpr T chain_tolerance = sizeof(T) == 4 ? T(2e-6) : T(4e-15);
// A link that has turned further in a sub-step (its cosine) is astray: the pulses along n would swing the chain up.
template <class T>
inline constexpr T least_turn = T(0.7);
// A pivot below this part of its link's own coefficient is taken for it: a chain drawn straight between two fixed ends.
template <class T>
inline constexpr T least_pivot = sizeof(T) == 4 ? T(1e-5) : T(1e-12);

}  // namespace dvdx
