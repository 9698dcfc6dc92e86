// Particles that meet as a pass takes them: pairs within reach, and the pulses that keep them apart.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

// Problem  A pair (i, j) with inverse masses w wants the distance d. q0 is x_i - x_j when the sub-step begins, q1 as the flows
//          leave it, and D = q1 - q0. The test sweeps the chord q0 + f D. Where |q0| > d and the chord reaches d, first at f,
//          the normal is n = (q0 + f D)/d. Where |q0| <= d it is q0/|q0|, and f = 0. So a pair that has passed through is
//          brought back. A pair that misses takes the normal of its closest approach, and has C > 0.
// Impact   A pair bounces with restitution e if it approaches faster than pairs at rest do (4 g h). In each round every
//          particle names the pair that meets first (then the faster, then the lower number). A pair that both of its particles
//          name acts with its full masses, unless a particle near it is hit before:
//            J = -(1 + e) v_n/(w_i + w_j),  Coulomb min(|v_t|/(w_i + w_j), mu J),  dv = w J,  dx = (1 - f) h dv,
//          This is Brown's integral: v' = -e v_n at f, whatever h. Pairs that act are disjoint, so their order does not matter.
//          A particle that was hit goes on from f as if it had come there in a straight line: its start moves by -f h dv.
// Contact  C = n.(q1 + dx_i - dx_j) - d >= 0 holds for all pairs at once, and for surfaces, whose w_j is 0. The dx that has
//          least sum m |dx|^2 is dx_i = w_i sum n l, with l >= 0 and l C = 0: a projection onto half spaces. It never raises
//          the kinetic energy if nothing overlaps at the start. Each round computes, from y,
//            l = max(0, y - C/(w_i k_i + w_j k_j)),   y = l + beta (l - l_before),
//          k: the number of a particle's pulses that act. The rows of the scaled matrix sum to at most 1, so a round descends.
//          The last round has beta 0. The first round solves a lone pair, and later rounds leave it so. The first y is a part
//          of the contact's pulse in the sub-step before, so a pile is carried by more rounds than one sub-step has. A pulse
//          that has grown is kept up to twice its first y plus the weight of a pair: pulses of impacts do not last.
//          Friction: the same for the slip within the sub-step, cut to mu l.
// Rest     Rounds leave a part of g h^2 in each sub-step. Along a slope no later sub-step sees it, and piles would flow for
//          ever. So a ball that touches and would move by less than half of g h^2 stays where the sub-step found it. It keeps
//          its velocity: a ball that should slide or fall gains g h in each sub-step, and soon moves. The rule is off without
//          friction, and while a surface or a particle with w = 0 moves, which slower particles must follow.
// Left out Neighbours in a sheet are all within reach, and hardly any of them act. An idle pair begins to act where
//          C + n.(dx_i - dx_j) < 0, so not before |dx_i| + |dx_j| is as long as C. Pairs farther apart than the pushes of the
//          sub-step before are called far. Rounds and sums leave them out until a push is half as long as the least C of them.
//          Their pulses are 0 until then, so no bit depends on it.
// Sums     A pair's pulse is computed once and taken by both sides. A particle sums in ascending order of its partners'
//          numbers. Particles with equally many pulses stand side by side. Momentum is kept to rounding. The pairs within reach
//          depend on the state alone, so no bit depends on the age of a list.
// Limits   Particles do not rotate: balls do not roll. A pair that pushes bring nearer by more than the margin meets in the
//          next sub-step only. A round carries a push one particle on, so a deep pile is soft. A grain at rest has the velocity
//          -g h/2, which the next sub-step takes back, as in leapfrog.
// Source   R. Tonge, F. Benevolenti and A. Voroshilov, Mass splitting for jitter-free parallel rigid body simulation, 2012 (k);
//          Y. Nesterov, 1983 (y); E. Brown, integral contributions (impacts).

namespace dvdx {

inline constexpr std::uint32_t no_partner = std::numeric_limits<std::uint32_t>::max();
inline constexpr int most_impact_rounds = 8;
inline constexpr double beta_of_balls = 0.8;
inline constexpr double beta_of_cloth = 0.5;
inline constexpr double part_at_rest = 0.5;  // of g h^2: a touching ball that would move less in a sub-step stays
inline constexpr double kept_part = 0.4;     // of a contact's pulse: what its next sub-step begins with

template <class T>
using Point = std::array<T, 3>;

// The distance that a pair wants: for balls the sum of their radii, for cloth of several thicknesses the larger one.
enum class Wanted : std::uint8_t { sum, larger };
template <class T>
constexpr T wanted_of(Wanted wanted, T r_i, T r_j) noexcept {
  return wanted == Wanted::sum ? r_i + r_j : 2 * (r_i < r_j ? r_j : r_i);
}

// A meeting as one particle takes it in a round: the pulse in kg m, and 1 if it acts, otherwise 0. Between sub-steps it holds
// the pulse that the next sub-step begins with: `vector` along the surface, `number` the normal one.
template <class T>
struct Pulse {
  Point<T> vector{};
  T number = 0;
};

// A contact in the rounds: C, and the pulses that keep it from being negative.
template <class T>
struct Separation {
  Point<T> n{};     // from j to i
  T gap = 0;        // C as the impacts leave it, m
  Point<T> slip{};  // relative displacement along the surface in the sub-step, m
  T normal = 0, normal_y = 0;
  Point<T> along{}, along_y{};
  T begun = 0;  // the normal pulse that the sub-step began with
};

// An impact within the sub-step.
template <class T>
struct Impact {
  Point<T> n{};  // from j to i
  T f = 2;       // part of the sub-step; 2: no impact
  T speed = 0;   // of the approach, m/s
};

// How far a round pushes a particle, m. w: the particle's 1/kg times the number of pulses that act on it.
template <class T>
struct MeetPush {
  Point<T> dx{};
  T w = 0;
};

// A pair within reach.
struct MetPair {
  std::uint32_t i = 0, j = no_partner;
  bool operator<(const MetPair& other) const noexcept { return i != other.i ? i < other.i : j < other.j; }
  bool operator==(const MetPair&) const = default;
};

inline constexpr std::size_t meeting_lanes = 16;

// meeting_lanes pairs. Unused lanes hold the first particle twice.
struct MetPairs {
  std::array<std::uint32_t, meeting_lanes> i{}, j{};
};

inline MetPair pair_at(const MetPairs* pairs, std::size_t p) noexcept {
  const MetPairs& of = pairs[p / meeting_lanes];
  return {of.i.data()[p % meeting_lanes], of.j.data()[p % meeting_lanes]};
}

// Separations of pairs, a lane each.
template <class T>
struct Separations {
  using Lanes = std::array<T, meeting_lanes>;
  using Three = std::array<Lanes, 3>;
  Three n, slip, along, along_y;
  Lanes gap, normal, normal_y, begun;

  [[nodiscard]] Separation<T> of(std::size_t k) const noexcept {
    return {at(n, k),           gap.data()[k], at(slip, k),    normal.data()[k],
            normal_y.data()[k], at(along, k),  at(along_y, k), begun.data()[k]};
  }
  void put(std::size_t k, const Separation<T>& of) noexcept {
    put(n, k, of.n);
    gap.data()[k] = of.gap;
    put(slip, k, of.slip);
    normal.data()[k] = of.normal;
    normal_y.data()[k] = of.normal_y;
    put(along, k, of.along);
    put(along_y, k, of.along_y);
    begun.data()[k] = of.begun;
  }
  static Point<T> at(const Three& three, std::size_t k) noexcept {
    return {three[0].data()[k], three[1].data()[k], three[2].data()[k]};
  }
  static void put(Three& three, std::size_t k, const Point<T>& at) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) three[axis].data()[k] = at[axis];
  }
};

// A particle and a surface.
template <class T>
struct MetWall {
  std::uint32_t particle = 0, surface = 0;
  T mu = 0;        // Coulomb's coefficient
  T e = 0;         // restitution
  T start = 0;     // distance from the surface when the sub-step begins, m
  Point<T> way{};  // how far the surface moves in the sub-step, m
  Point<T> n{};    // from the surface
  T gap = 0;       // distance when the sub-step ends, m
  Impact<T> impact{};
  Point<T> impulse{};  // of impacts, kg m/s
};

// A particle in a sub-step, by its number, as records of four numbers.
template <class T>
struct MetStart {
  Point<T> x{};  // when the sub-step begins, m
  T r = 0;       // m
};
template <class T>
struct MetEnd {
  Point<T> x{};  // as the flows leave it, m
  T strays = 0;  // deviation from the mean displacement of all in this sub-step, m
};
template <class T>
struct MetListed {
  Point<T> x{};   // when the lists were built, m
  T allowed = 0;  // m: the strays that the lists allow for
};
template <class T>
struct MetVelocity {
  Point<T> v{};  // as the flows leave it, m/s
  T w = 0;       // 1/kg
};
template <class T>
struct MetHits {
  Point<T> dv{};  // by impacts, m/s
  T last = 0;     // the last impact's f
};
template <class T>
struct MetShift {
  Point<T> dx{};  // of the start, by impacts, m
  T round = 0;    // the last round of this sub-step in which an impact hit it, from 1; 0: none
};
template <class T>
struct MetParticles {
  const MetStart<T>* start = nullptr;
  const MetEnd<T>* end = nullptr;
  const MetVelocity<T>* velocity = nullptr;
  const MetHits<T>* hits = nullptr;
  const MetShift<T>* shift = nullptr;
};

template <class T>
Point<T> minus(const Point<T>& a, const Point<T>& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
Point<T> plus(const Point<T>& a, const Point<T>& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
Point<T> times(T s, const Point<T>& a) noexcept {
  return {s * a[0], s * a[1], s * a[2]};
}
template <class T>
T inner(const Point<T>& a, const Point<T>& b) noexcept {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

// Returns true if the chord of a pair comes nearer than `distance`.
template <class T>
bool comes_within(const Point<T>& q0, const Point<T>& q1, T distance) noexcept;

// Finds the impact of a pair, with d the wanted distance and h the sub-step, or of a particle with a surface.
template <class T>
Impact<T> find_impact(std::size_t i, std::size_t j, const MetParticles<T>& of, T d, T h, T slowest) noexcept;
template <class T>
void find_impact(MetWall<T>& wall, std::size_t i, const MetParticles<T>& of, T h, T slowest) noexcept;
// The impulse on a particle that moves by u, m/s, relative to its partner. w: the sum of both, 1/kg.
template <class T>
Point<T> impulse_of(const Point<T>& n, const Point<T>& u, T w, T e, T mu) noexcept;

// Begins the contact of a pair after impacts, from q0 to q1, or that of a surface, relative to which a particle moves by D.
// kept: the pulse of the sub-step before, or none.
template <class T>
Pulse<T> begin_contact(Separation<T>& contact, const Point<T>& q0, const Point<T>& q1, T d, const Pulse<T>& kept) noexcept;
template <class T>
Pulse<T> begin_contact(Separation<T>& contact, const Point<T>& D, const Pulse<T>& kept) noexcept;
// One round of a contact. moved: the relative push of both sides, m. w: the sum of 1/kg times acting pulses over both sides.
template <class T>
void push(Separation<T>& contact, Pulse<T>& pulse, const Point<T>& moved, T w, T mu, T beta) noexcept;
// The pulse that the next sub-step begins with. weight: the pulse of a pair that carries its own weight.
template <class T>
Pulse<T> kept(const Separation<T>& contact, T weight) noexcept;

}  // namespace dvdx
