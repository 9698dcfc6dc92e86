// The input of the constraint passes: constraints in colours, none of which has two at a particle that can move, and the table
// of passes that one instruction set provides.
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
// 1.5e-1. Where a link turns by more than 45 degrees in a sub-step, the sub-step is too long for the chain's fast motion: its
// particles then follow each other from the fixed end, which keeps lengths and loses energy.
//
// Lone chain, whose particles no other constraint moves: it takes sub-steps of its own where it needs them. A link's tension
// is s |n| / h^2 in units of the largest w, and across the chain it is a spring of T/l, so that RATTLE, which is leapfrog
// there, is stable below
//   (h omega)^2 <= max 2 w_k (|s_{k-1}| + |s_k|) < 4        (Gershgorin)
// and the s that Newton's steps have found tell it. With u = W J^T s / h and u' = W J^T m, the flow of a constant acceleration
// and J v_n = 0, the sub-step changes the energy by
//   (|u|^2 - |u'|^2) / 2,   |u|^2 = sum of m u^2
// the work of the two pulses: the first gives what the second takes. A sub-step is refused where that is more than 1e-4 of the
// kinetic energy, seen from the held end or else the centre of mass, and than 5e-3 of m (h a)^2, what the forces do, where
// (h omega)^2 > 2, or lengths do not converge. The chain then goes from start in 2, 4, ... of its own along a parabola to
// x*, v*,
//   v0 = 2 (x* - x_n)/h - v*,   a = (v* - v0)/h
// until all of them will do: 2^10 at most, or 2^8 for the energy's sake alone. Rounding is allowed for: positions are known to
// 2^-52 (2^-23) of the largest coordinate. Limits: drag, springs and contacts within the sub-step act as the constant
// acceleration that has their end. Where 2^10 do not converge (ends drawn further apart than the chain is long, or a chain
// drawn straight, which no tension holds against gravity) its particles follow each other, and what is held at both ends and
// finds no lengths so stays as it was at the start. 2 to 40 rods with loads of 1 to 1e4 of their masses from the horizontal, 60
// and 240 Hz, 10 s: energy within 2e-3; RATTLE alone gave up to 8 times what there was. 1000 rods held at both ends, 60 Hz:
// lengths to 3e-14, by 64 sub-steps of their own.
//
// Limits: `at_most` constraints that share particles. Sweeps of pulses along n have no end there: each one's rounding, and what
// few sweeps leave, becomes a velocity over h, and from links as tight as w lambda > l the pulses turn links over. But the
// states in which no |d_k| is above l_k are a convex set, and the nearest one to x* is where
//   x = x* - W J(x)^T lambda,   lambda >= 0,   lambda_k (|d_k| - l_k) = 0
// (implicit Euler's step: first order, and not farther from x_n than x* is wherever x_n is in the set, so that it takes energy
// and gives none), and the velocity is v* on the cone of what keeps taut links taut, the nearest one again (Moreau 1988).
// A chain that no other constraint shares a particle with is solved whole. Newton's step Delta on what its own pulses have
// moved already, with u_k = d_k/|d_k|, k_k = lambda_k / l_k (how stiff a pulled link is across), m = 1/w:
//   m_k (own_k + Delta_k) = lambda_k u_k - lambda_{k-1} u_{k-1} + k_k (Delta_{k+1} - Delta_k) - k_{k-1} (Delta_k - Delta_{k-1})
//   u_k . (Delta_{k+1} - Delta_k) = l_k - |d_k|   of links that act,   lambda_k = 0 of the others
// where along u_k the stiffness only adds to lambda_k. Without it the light links of a loaded bridge are thrown over the line
// in each step. Elimination from the first particle on carries Delta_k = rest_k + P_k f, f the force from beyond:
//   g = u - k P u,   B = (m + k_k + k_{k+1} - k_k^2 P)^-1,   q = B g,   y = u.P u + g.q
//   P' = B - q q^T / y,   rest' = B f' - q force,   f' = k rest - m own,   force = (g.B f' - u.rest - gap) / y
// Links act that pull, or are too long; one whose lambda turns out as a push is let go at the next step. Where some link is as
// tight as lambda > l m, the first step finds only lambda. In velocity k = 0, and gap = -u.d'.
// A chain of 24 links that hangs at rest, float, 60 Hz, 10 s: fastest 5e-5 m/s by 8 to 100 iterations, where sweeps reached
// 14 to 4911 m/s; a bridge of 100 of 1 kg with 80 kg in its middle: stretched by 1.4e-5, where sweeps left 1 and more.
//
// Crossing limits, as a sheet's: visited in turns, each to the dual's maximum over its own pulse p = (w_a + w_b) lambda u, a
// vector that turns with the link. The visit takes its pulse back and projects anew (Dykstra 1983):
//   e = d + p,   p' = (1 - l/|e|) e where |e| > l, else 0,   the ends move by +- w / (w_a + w_b) (p' - p)
// Each visit raises the dual, Sum of lambda (u.d* - l) less half of m |g|^2 with g what the pulses move, which begins at 0. So
//   m |x - x_n|^2 <= m |x* - x_n|^2 + 2 Sum of lambda (|d_n| - l)
// after any number of visits: what begins within its limits is given no energy, and beyond them no more than springs give back.
// Rest: with v_n = 0 and constant forces x* - x_n is a h^2/2 and v* is a h, so that p holds x where it was and 2 p/h takes v*
// away, though few sweeps leave links too long. So velocity pulses begin with 2 |p| / h along u, and sweeps over
//   mu' = max(0, mu + u.d')   of links that are taut
// take back where an impact asks for less. From mu = |p| / h a sheet of 16 x 16 that hangs by its upper row kept 7e-2 m/s by
// 32 sweeps at 60 Hz; so 1e-5, in float. Colours are visited in one order: it came two to four times as near as forwards and
// backwards.
// Limits: pulses spread by one link a visit. 24 x 32, 60 Hz, the first row held, 32 iterations: 2.1e-2 too long, 100 4.7e-3;
// 16 x 16 5.2e-3, in sub-steps of 1/240 s 3.3e-4. A row drawn straight between two held corners at its own length could bear
// its sheet by an infinite tension alone: 2e-2 too long by 32 iterations in sub-steps of 1/240 s, 6e-3 by 200.
//
// Line: e = x - p, and the pulses take away what e and v have along two unit vectors across the line. Point: x = at, v = 0.
//
// Limits: several constraints at a particle are visited one after the other (Gauss-Seidel), forwards and backwards, or where
// limits cross forwards twice. A constraint both of whose ends are fixed, or whose ends coincide, or that has an end which is
// not finite, contributes nothing.
// A jump over a bound (from one side of `at_least` to the other) within a sub-step is not seen.

namespace dvdx {

template <class T>
using Axes = std::array<T*, 3>;  // working columns

// Columns of one element a constraint; lanes without one join an element beyond the particles to itself.
template <class T>
struct PairTerms {
  const std::int32_t *a = nullptr, *b = nullptr;
  const T* l = nullptr;
  const T *share_a = nullptr, *share_b = nullptr;  // w / (w_a + w_b)
  // d at the sub-step's start, or where a bound was reached; then d at its end. For crossing limits p; then u, m along it, and
  // 1 where they act in place of 1 / d.d.
  Axes<T> n{};
  T* s = nullptr;        // sum of the position pulses, in units of n
  T* m = nullptr;        // of a bound: sum of the velocity pulses, in units of d
  T* inverse = nullptr;  // 1 / d.d, 0 where no velocity pulse acts
  T* rate = nullptr;     // of a bound: 1 / ((1 - f) h)
  T per_step{};          // 1/h
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
  const T* m = nullptr;                // 1/w, 0 where fixed
  const std::int32_t* self = nullptr;  // each element's own number: `a` of columns of the chains' own
  // For each chain of a bundle: the sum of its m, and its longest link.
  const T *whole = nullptr, *longest = nullptr;
  Axes<T> n{};                         // d at the sub-step's start, then at its end; 0 where a link contributes nothing
  Axes<T> kept{};                      // x before the position pulses; then v0
  T* s = nullptr;                      // sum of the position pulses
  T *over = nullptr, *rest = nullptr;  // elimination: x_k = rest - over x_{k+1}
  // For lone chains. Sub-steps of their own end in columns of their own.
  Axes<T> start{};   // x at the sub-step's start
  Axes<T> kept_v{};  // v before the position pulses; then a
  Axes<T> own_x{}, own_v{};
  T step{}, per_step{};  // h, 1/h
  int newton = 1;        // steps at most
};

// Chains of limits, in bundles as ChainTerms has them; columns of one element a particle, or the link from it to the next.
template <class T>
struct LimitTerms {
  const std::uint32_t* first = nullptr;  // of each bundle
  const std::uint32_t* links = nullptr;  // of the longest chain of each bundle
  const std::int32_t* a = nullptr;
  const T* l = nullptr;
  const T* mass = nullptr;         // in units of the chain's smallest, 0 where fixed
  Axes<T> own{}, kept{};           // what the chain's own pulses have moved a particle by, now and before this visit
  Axes<T> apart{};                 // d without them
  Axes<T> along{}, n{};            // directions: of the links that act, and at the sub-step's end
  Axes<T> yield{}, yield_cross{};  // P, its diagonal, and yz, xz, xy
  Axes<T> rest{}, share{};         // elimination: Delta = rest + P f, lambda = force + share . f
  T* force = nullptr;
  T* lambda = nullptr;  // pulls, >= 0
  T *gap = nullptr, *stiffness = nullptr;
  T rate{}, sign{};  // 1/|h| and the sign of h
  int steps = 1;     // of Newton's at most, each visit
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
  void (*prepare_lone_chains)(const ChainTerms<T>&, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  // position pulses
  void (*solve_pair_positions)(const PairTerms<T>&, Bound, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*solve_chain_positions)(const ChainTerms<T>&, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*solve_limit_positions)(const LimitTerms<T>&, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*solve_crossing_positions)(const PairTerms<T>&, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  void (*solve_line_positions)(const LineTerms<T>&, Round, const Axes<T>& x, std::size_t from, std::size_t to) = nullptr;
  // the velocity that the position pulses take; then n = d
  void (*update_pair_velocities)(const PairTerms<T>&, Bound, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                 std::size_t to) = nullptr;
  void (*update_chain_velocities)(const ChainTerms<T>&, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                  std::size_t to) = nullptr;
  void (*update_limit_velocities)(const LimitTerms<T>&, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                  std::size_t to) = nullptr;
  void (*update_crossing_velocities)(const PairTerms<T>&, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                     std::size_t to) = nullptr;
  void (*update_line_velocities)(const LineTerms<T>&, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  // velocity pulses
  void (*solve_pair_velocities)(const PairTerms<T>&, Bound, Time, Round, const Axes<T>& v, std::size_t from,
                                std::size_t to) = nullptr;
  void (*solve_chain_velocities)(const ChainTerms<T>&, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  void (*solve_limit_velocities)(const LimitTerms<T>&, Round, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  void (*solve_crossing_velocities)(const PairTerms<T>&, Time, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  void (*solve_line_velocities)(const LineTerms<T>&, const Axes<T>& v, std::size_t from, std::size_t to) = nullptr;
  // Everything about chains that share no particle with another constraint.
  void (*solve_lone_chains)(const ChainTerms<T>&, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                            std::size_t to) = nullptr;
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

// For lone chains. Lengths that Newton's steps leave no nearer than this have not converged.
template <class T>
inline constexpr T chain_lost = sizeof(T) == 4 ? T(1e-3) : T(1e-8);
// (h omega)^2 of the fastest transverse motion, at most: RATTLE is stable below 4.
template <class T>
inline constexpr T most_transverse = T(2);
// The most that pulses may give or take: of the kinetic energy, and of what the pulses themselves carry.
template <class T>
inline constexpr T most_given = T(1e-4);
template <class T>
inline constexpr T most_given_by_pulses = T(1e-5);
template <class T>
inline constexpr T most_given_by_forces = T(5e-3);
// Rounding of positions, over this many of its own sub-steps, is no energy given.
template <class T>
inline constexpr T grains = T(1000);
// Sub-steps of its own that a lone chain takes in one of the scene's.
template <class T>
inline constexpr T most_parts = T(1024);
// More than these help lengths alone.
template <class T>
inline constexpr T most_parts_for_energy = T(256);
// A limit is right to this part of its length, in position; and, a sub-step, in velocity.
template <class T>
inline constexpr T limit_tolerance = sizeof(T) == 4 ? T(1e-6) : T(2e-15);
template <class T>
inline constexpr T limit_rate_tolerance = sizeof(T) == 4 ? T(5e-6) : T(1e-13);
// A link that is shorter than its limit by less than this part is tried as a taut one at first.
template <class T>
inline constexpr T limit_near = T(0.05);
// At a sub-step's end a link of this part of its squared limit is taut.
template <class T>
inline constexpr T least_taut = T(1 - 1e-5);
// A chain yields at least this much to the force along a link, in units of its lightest particle's: each step of Newton's is
// one of the proximal point method, which ends where a step without it would, and stays bounded where a chain is drawn
// straight.
template <class T>
inline constexpr T least_yield = sizeof(T) == 4 ? T(1e-6) : T(1e-12);

}  // namespace dvdx
