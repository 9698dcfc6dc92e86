// The input of the constraint passes, and the table of passes that one instruction set provides. Constraints are in colours: no
// two of a colour share a particle that can move.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dvdx/isa.hpp"
#include "dvdx/network.hpp"

// Equation: C(x) = 0 with Jacobian J and inverse masses W, held by a force along J^T,
//   x' = v,   v' = W (F + J^T lambda),   C(x) = 0,   so that J v = 0
//
// Solution over a sub-step h from x_n: Brown's generic recipe. One pulse along J brings the position into compliance, another
// one the velocity. They are paired as in RATTLE (Andersen 1983). With x*, v* where the forces alone lead
//   position pulse   x_{n+1} = x* + W J(x_n)^T s   so that C(x_{n+1}) = 0,   and the velocity which takes it there,
//                    v = v* + W J(x_n)^T s / h
//   velocity pulse   v_{n+1} = v + W J(x_{n+1})^T m   so that J(x_{n+1}) v_{n+1} = 0
// The order is 2, and the step is its own inverse with -h if the flow is. A pendulum from 90 degrees at 60 Hz, position error
// over 2 s: Brown's pulses with J(x_{n+1}) 1.2e-1 m, with J(x_n) 4.6e-2 m, position-based dynamics 2.2e-1 m, paired 1.6e-3 m.
//
// Distance: d = x_b - x_a, n = d at x_n (of any length), and the ends move by -+ (w / (w_a + w_b)) s n:
//   |d + s n| = l,   s = (l^2 - d.d) / (d.n + sqrt((d.n)^2 - n.n (d.d - l^2)))      the nearer root, without cancellation
//   m = -(d.u) / d.d along d
// If there is no root, or d has turned away from n by 90 degrees or more, s = l/|d| - 1 along d. The velocity then gets
// the velocity pulse alone.
// Bounds (<= l, >= l) act where they are violated. The sum of a constraint's pulses keeps the sign in which it can pull (or
// push). The velocity pulse acts where the position pulse did. If the bound was free at x_n, the violation began at the part f
// of the sub-step: |n + f (d - n)| = l on the straight line from n to d (as Brown has it). n is then that direction, and the
// velocity takes s / ((1 - f) h). A bob thrown until its rope of 1 m goes taut, 200 throws at 60 Hz: the rms error after it is
// 1.11e-2 J/kg of the energy and 7.1e-4 m of the position, against 1.28e-2 and 8.4e-4 with n at x_n.
//
// Chain: link d_k is between particles k and k+1. A particle joins at most two links, so only neighbouring links meet in
//   d_k + (w_k + w_{k+1}) s_k n_k - w_k s_{k-1} n_{k-1} - w_{k+1} s_{k+1} n_{k+1},   of length l_k
// Newton's step for all s is one tridiagonal system, solved by elimination; the velocity pulse is another. A rope of 100 links
// of 1 cm swinging from the horizontal, 16 sub-steps of 1/960 s over 4 s, keeps its lengths to 1e-14; 8 sweeps over its links
// leave 1.5e-1. If a link turns by more than 45 degrees in a sub-step, the sub-step is too long for the chain's fast motion.
// The particles then follow each other from the fixed end, which keeps lengths and loses energy.
//
// Lone chain: no other constraint moves its particles. It takes sub-steps of its own where it needs them. A link's tension is
// s |n| / h^2 in units of the largest w. Across the chain the link is a spring of T/l, and RATTLE, which is leapfrog there, is
// stable below
//   (h omega)^2 <= max 2 w_k (|s_{k-1}| + |s_k|) < 4        (Gershgorin)
// Newton's steps give the s of this bound. With u = W J^T s / h and u' = W J^T m, the flow of a constant acceleration and
// J v_n = 0, the sub-step changes the energy by
//   (|u|^2 - |u'|^2) / 2,   |u|^2 = sum of m u^2
// This is the work of the two pulses: the first gives energy, the second takes it. A sub-step is refused if its change is more
// than 1e-4 of the kinetic energy (seen from the held end, otherwise from the centre of mass) plus 5e-3 of m (h a)^2, the work
// of the forces. It is also refused if (h omega)^2 > 2, or if lengths do not converge. The chain then goes from its start in
// 2, 4, ... sub-steps of its own along a parabola to x*, v*,
//   v0 = 2 (x* - x_n)/h - v*,   a = (v* - v0)/h
// until all of them pass: 2^10 at most, or 2^8 if only the energy asks for more. Rounding is allowed for: positions are
// known to 2^-52 (2^-23) of the largest coordinate. Limits: drag, springs and contacts within the sub-step act as the constant
// acceleration with the same end. If 2^10 do not converge (ends drawn further apart than the chain is long, or a chain drawn
// straight, which no tension holds against gravity), the particles follow each other. A chain that is held at both ends and
// finds no lengths in this way stays as it was at the start. 2 to 40 rods with loads of 1 to 1e4 of their masses from the
// horizontal, 60 and 240 Hz, 10 s: energy within 2e-3; RATTLE alone gave up to 8 times the energy. 1000 rods held at both
// ends, 60 Hz: lengths to 3e-14, by 64 sub-steps of their own.
//
// Limits: `at_most` constraints that share particles. Sweeps of pulses along n do not settle there: the rounding of each pulse,
// and the error that few sweeps leave, become a velocity over h. From links as tight as w lambda > l the pulses turn links
// over. But the states in which no |d_k| is above l_k are a convex set, and the nearest one to x* is where
//   x = x* - W J(x)^T lambda,   lambda >= 0,   lambda_k (|d_k| - l_k) = 0
// This is implicit Euler's step, of first order. If x_n is in the set, x is not farther from x_n than x* is, so the step takes
// energy and gives none. The velocity is v* projected on the cone of velocities that keep taut links taut, the nearest one
// again (Moreau 1988).
// A chain that shares no particle with another constraint is solved whole. Newton's step Delta adds to what the chain's own
// pulses have moved already, with u_k = d_k/|d_k|, k_k = lambda_k / l_k (the stiffness of a pulled link across), m = 1/w:
//   m_k (own_k + Delta_k) = lambda_k u_k - lambda_{k-1} u_{k-1} + k_k (Delta_{k+1} - Delta_k) - k_{k-1} (Delta_k - Delta_{k-1})
//   u_k . (Delta_{k+1} - Delta_k) = l_k - |d_k|   of links that act,   lambda_k = 0 of the others
// Along u_k the stiffness only adds to lambda_k. Without it the light links of a loaded bridge are thrown over the line in each
// step. Elimination from the first particle on carries Delta_k = rest_k + P_k f, f the force from beyond:
//   g = u - k P u,   B = (m + k_k + k_{k+1} - k_k^2 P)^-1,   q = B g,   y = u.P u + g.q
//   P' = B - q q^T / y,   rest' = B f' - q force,   f' = k rest - m own,   force = (g.B f' - u.rest - gap) / y
// Links act if they pull or are too long. A link whose lambda turns out as a push is let go at the next step. If some link is
// as tight as lambda > l m, the first step finds only lambda. For velocities k = 0, and gap = -u.d'.
// A chain of 24 links that hangs at rest, float, 60 Hz, 10 s: fastest 5e-5 m/s by 8 to 100 iterations; sweeps reached 14 to
// 4911 m/s. A bridge of 100 of 1 kg with 80 kg in its middle: stretched by 1.4e-5; sweeps left 1 and more.
//
// Crossing limits, as those of a sheet, are visited in turn. A visit takes the dual to its maximum over the link's own pulse
// p = (w_a + w_b) lambda u, a vector that turns with the link. It takes its pulse back and projects anew (Dykstra 1983):
//   e = d + p,   p' = (1 - l/|e|) e where |e| > l, else 0,   the ends move by +- w / (w_a + w_b) (p' - p)
// Each visit raises the dual, Sum of lambda (u.d* - l) less half of m |g|^2 with g what the pulses move. It begins at 0. So
//   m |x - x_n|^2 <= m |x* - x_n|^2 + 2 Sum of lambda (|d_n| - l)
// after any number of visits. A state within its limits is given no energy; beyond them it gets no more than springs give back.
// Rest: with v_n = 0 and constant forces, x* - x_n is a h^2/2 and v* is a h. So p holds x where it was and 2 p/h takes v* away,
// though few sweeps leave links too long. Velocity pulses therefore begin with 2 |p| / h along u. Sweeps over
//   mu' = max(0, mu + u.d')   of links that are taut
// take back the excess if an impact asks for less. A sheet of 16 x 16 that hangs by its upper row, 32 sweeps at 60 Hz: begun
// with mu = |p| / h it kept 7e-2 m/s; with 2 |p| / h it keeps 1e-5, in float. Colours are visited in one order, which came two
// to four times as near as forwards and backwards.
// Limits: pulses spread by one link a visit. A sheet of 24 x 32, 60 Hz, the first row held, is 2.1e-2 too long by 32 iterations
// and 4.7e-3 by 100; 16 x 16 5.2e-3, in sub-steps of 1/240 s 3.3e-4. A row drawn straight between two held corners at its own
// length could bear its sheet only by an infinite tension: by 32 iterations it is 2e-2 too long in sub-steps of 1/240 s, by 200
// 6e-3.
//
// Line: e = x - p. The pulses remove the parts of e and v along two unit vectors across the line. Point: x = at, v = 0.
//
// Limits: several constraints at a particle are visited one after the other (Gauss-Seidel), forwards and backwards, or forwards
// twice where limits cross. A constraint contributes nothing if both its ends are fixed, its ends coincide, or an end is not
// finite. A jump over a bound (from one side of `at_least` to the other) within a sub-step is not seen.

namespace dvdx {

template <class T>
using Axes = std::array<T*, 3>;  // working columns

// Columns with one element for each constraint. Lanes without one join an element beyond the particles to itself.
template <class T>
struct PairTerms {
  const std::int32_t *a = nullptr, *b = nullptr;
  const T* l = nullptr;
  const T *share_a = nullptr, *share_b = nullptr;  // w / (w_a + w_b)
  // d at the sub-step's start, or where a bound was reached; then d at its end. For crossing limits p, then u; m is then along
  // u, and `inverse` is 1 where they act.
  Axes<T> n{};
  T* s = nullptr;        // sum of the position pulses, in units of n
  T* m = nullptr;        // for a bound: sum of the velocity pulses, in units of d
  T* inverse = nullptr;  // 1 / d.d, 0 where no velocity pulse acts
  T* rate = nullptr;     // for a bound: 1 / ((1 - f) h)
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
  const std::int32_t* self = nullptr;  // each element's own index: the `a` of the chains' own columns
  // For each chain of a bundle: the sum of its m, and its longest link.
  const T *whole = nullptr, *longest = nullptr;
  Axes<T> n{};                         // d at the sub-step's start, then at its end; 0 where a link contributes nothing
  Axes<T> kept{};                      // x before the position pulses; then v0
  T* s = nullptr;                      // sum of the position pulses
  T *over = nullptr, *rest = nullptr;  // elimination: x_k = rest - over x_{k+1}
  // For lone chains, whose own sub-steps work in columns of their own.
  Axes<T> start{};   // x at the sub-step's start
  Axes<T> kept_v{};  // v before the position pulses; then a
  Axes<T> own_x{}, own_v{};
  T step{}, per_step{};  // h, 1/h
  int newton = 1;        // steps at most
};

// Chains of limits, in bundles as those of ChainTerms. An element stands for a particle, or for the link from it to the next.
template <class T>
struct LimitTerms {
  const std::uint32_t* first = nullptr;  // of each bundle
  const std::uint32_t* links = nullptr;  // of the longest chain of each bundle
  const std::int32_t* a = nullptr;
  const T* l = nullptr;
  const T* mass = nullptr;         // in units of the chain's smallest, 0 where fixed
  Axes<T> own{}, kept{};           // how far the chain's own pulses have moved a particle, now and before this visit
  Axes<T> apart{};                 // d without them
  Axes<T> along{}, n{};            // directions: of the links that act, and at the sub-step's end
  Axes<T> yield{}, yield_cross{};  // P, its diagonal, and yz, xz, xy
  Axes<T> rest{}, share{};         // elimination: Delta = rest + P f, lambda = force + share . f
  T* force = nullptr;
  T* lambda = nullptr;  // pulls, >= 0
  T *gap = nullptr, *stiffness = nullptr;
  T rate{}, sign{};  // 1/|h| and the sign of h
  int steps = 1;     // Newton's steps in a visit, at most
};

template <class T>
struct LineTerms {
  const std::int32_t* a = nullptr;
  Axes<T> p{}, n1{}, n2{};         // a point of the line, and two unit vectors across it
  T *s1 = nullptr, *s2 = nullptr;  // sums of the position pulses along n1 and n2
  T per_step{};
};

enum class Round : std::uint8_t { first, again };  // of a sub-step's sweeps: sums are 0 at the first

// A bound's velocity pulses keep the sign of its position pulses if time runs forwards, the opposite sign if it runs backwards.
enum class Time : std::uint8_t { forwards, backwards };

// Each pass takes constraints [from, to) of one colour, multiples of 16; of chains and limits, bundles.
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
  // adds the velocity of the position pulses; then n = d
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
  // All pulses of chains that share no particle with another constraint.
  void (*solve_lone_chains)(const ChainTerms<T>&, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                            std::size_t to) = nullptr;
};

// The least part of a sub-step that counts as left after a bound was reached. A pulse in a shorter time would only amplify
// rounding; the velocity pulse corrects the remainder.
template <class T>
inline constexpr T least_rest = T(1) / T(16);

// A chain whose squared lengths are all right to this needs no further step of Newton's.
template <class T>
inline constexpr T chain_tolerance = sizeof(T) == 4 ? T(2e-6) : T(4e-15);
// The least cosine of a link's turn in a sub-step. Beyond it a link is astray: pulses along n would swing the chain up.
template <class T>
inline constexpr T least_turn = T(0.7);
// The least pivot, as a part of its link's own coefficient. It replaces smaller ones, which a chain drawn straight between two
// fixed ends has.
template <class T>
inline constexpr T least_pivot = sizeof(T) == 4 ? T(1e-5) : T(1e-12);

// For lone chains. Lengths that Newton's steps leave farther off than this have not converged.
template <class T>
inline constexpr T chain_lost = sizeof(T) == 4 ? T(1e-3) : T(1e-8);
// (h omega)^2 of the fastest transverse motion, at most: RATTLE is stable below 4.
template <class T>
inline constexpr T most_transverse = T(2);
// The most energy that pulses may give or take, as a part of: the kinetic energy; the energy of the pulses; that of the forces.
template <class T>
inline constexpr T most_given = T(1e-4);
template <class T>
inline constexpr T most_given_by_pulses = T(1e-5);
template <class T>
inline constexpr T most_given_by_forces = T(5e-3);
// Rounding of positions over this many of a chain's own sub-steps does not count as energy given.
template <class T>
inline constexpr T grains = T(1000);
// The sub-steps of its own that a lone chain takes in one of the scene's, at most.
template <class T>
inline constexpr T most_parts = T(1024);
// More sub-steps than these are taken for the sake of lengths alone.
template <class T>
inline constexpr T most_parts_for_energy = T(256);
// A limit holds if its length is right to limit_tolerance of it, and its velocity to limit_rate_tolerance of it a sub-step.
template <class T>
inline constexpr T limit_tolerance = sizeof(T) == 4 ? T(1e-6) : T(2e-15);
template <class T>
inline constexpr T limit_rate_tolerance = sizeof(T) == 4 ? T(5e-6) : T(1e-13);
// A link that is shorter than its limit by less than this part is tried as a taut one in the first step.
template <class T>
inline constexpr T limit_near = T(0.05);
// A link is taut at a sub-step's end if its squared length is at least this part of its squared limit.
template <class T>
inline constexpr T least_taut = T(1 - 1e-5);
// The least yield of a chain to the force along a link, in units of its lightest particle's. It makes each of Newton's steps
// one of the proximal point method: the steps end at the same place, and stay bounded if a chain is drawn straight.
template <class T>
inline constexpr T least_yield = sizeof(T) == 4 ? T(1e-6) : T(1e-12);

}  // namespace dvdx
