// Particles that meet, as a pass takes them: pairs within reach, and the pulses that keep them apart.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

// Problem  A pair (i, j) with inverse masses w wants the distance d. q0 and q1 are x_i - x_j when the sub-step begins and as
//          the flows leave it, D = q1 - q0. It is swept: where |q0| > d and the chord comes as near as d, first at f, the
//          normal is n = (q0 + f D)/d; where |q0| <= d it is q0/|q0| and f = 0. A pair that has passed through is so brought
//          back. A pair that misses has the normal of its closest approach, and C > 0.
// Impact   Approaches faster than what rests (4 g h), e: restitution. Each round every particle names the pair that meets first
//          (then the faster, then the lower number); pairs that name each other, before any near them, act with full masses,
//            J = -(1 + e) v_n/(w_i + w_j),  Coulomb min(|v_t|/(w_i + w_j), mu J),  dv = w J,  dx = (1 - f) h dv,
//          Brown's integral: v' = -e v_n at f, whatever h. Pairs that act are disjoint, so that no order matters. A particle
//          that has been hit goes on from f as if it had come straight to there: its start is moved by -f h dv.
// Contact  C = n.(q1 + dx_i - dx_j) - d >= 0 for all pairs at once, and for surfaces, whose w_j is 0. The dx of least
//          sum m |dx|^2 is dx_i = w_i sum n l, with l >= 0 and l C = 0: a projection onto half spaces. From starts that
//          overlap nowhere the kinetic energy never rises by it. Each round, from y,
//            l = max(0, y - C/(w_i k_i + w_j k_j)),   y = l + beta (l - l_before),
//          k: the pulses of a particle that act. The rows of the scaled matrix have a sum of at most 1, so the round descends.
//          The last round has beta 0. A pair alone is solved by the first round, and stays so. The first y is a part of the
//          pulse that the contact had in the sub-step before, so that a pile is carried by more rounds than one sub-step has.
//          A pulse that has grown counts at most twice its first y and the weight of a pair: those of impacts do not last.
//          Friction: the same for the slip within the sub-step, cut to mu l.
// Rest     Rounds leave a part of g h^2 of each sub-step, along slopes too, where nothing tells the next sub-step of it: piles
//          would flow for ever. So a ball that touches and would go by less than half of g h^2 stays where the sub-step
//          found it. It keeps its velocity: what should slide or fall gains g h each sub-step, and soon goes. It is not so
//          while a surface or a particle without mass moves, which slower ones must follow, nor without friction.
// Left out Neighbours in a sheet are all within reach, and hardly any of them act. A pair that does not act begins to where
//          C + n.(dx_i - dx_j) < 0, not before |dx_i| + |dx_j| is as long as C. So those farther apart than pushes of the
//          sub-step before go are far: rounds and sums leave them out until a push is half as long as the least C of them.
//          Their pulses are 0 till then: no bit depends on it.
// Sums     A pair's pulse is worked out once, and taken by both sides; a particle sums by ascending numbers of its partners,
//          lower ones first. Particles with as many pulses stand side by side. Momentum is kept to rounding. Which pairs are
//          within reach depends on nothing but the state, so no bit depends on how old a list is.
// Limits   Particles turn about nothing: balls do not roll. Pairs that pushes bring nearer than their margin within a sub-step
//          meet in the next one. Rounds carry a push by so many particles: a deep pile is soft. A grain at rest has the
//          velocity -g h/2 that the next sub-step takes back, as in leapfrog.
// Source   R. Tonge, F. Benevolenti and A. Voroshilov, Mass splitting for jitter-free parallel rigid body simulation, 2012 (k);
//          Y. Nesterov, 1983 (y); E. Brown, integral contributions (impacts).

namespace dvdx {

inline constexpr std::uint32_t no_partner = std::numeric_limits<std::uint32_t>::max();
inline constexpr int most_impact_rounds = 8;
inline constexpr double beta_of_balls = 0.8;
inline constexpr double beta_of_cloth = 0.5;
inline constexpr double part_at_rest = 0.5;  // of g h^2: what touches and goes by less in a sub-step stays
inline constexpr double kept_part = 0.4;     // of a contact's pulse, with which its next sub-step begins

template <class T>
using Point = std::array<T, 3>;

// The distance that a pair wants: balls the sum of their radii; cloth of several thicknesses the larger one.
enum class Wanted : std::uint8_t { sum, larger };
template <class T>
constexpr T wanted_of(Wanted wanted, T r_i, T r_j) noexcept {
  return wanted == Wanted::sum ? r_i + r_j : 2 * (r_i < r_j ? r_j : r_i);
}

// A meeting as a particle takes it in a round: the pulse in kg m, and 1 where it acts, else 0. Between sub-steps it is that
// with which the next one begins: the pulse along the surface, and the normal one.
template <class T>
struct Pulse {
  Point<T> vector{};
  T number = 0;
};

// C and what keeps it, in the rounds.
template <class T>
struct Separation {
  Point<T> n{};     // from j to i
  T gap = 0;        // C as the impacts leave it, m
  Point<T> slip{};  // what slides in the sub-step, along the surface, m
  T normal = 0, normal_y = 0;
  Point<T> along{}, along_y{};
  T begun = 0;  // the normal pulse that the sub-step began with
};

// Where an impact is within the sub-step.
template <class T>
struct Impact {
  Point<T> n{};  // from j to i
  T f = 2;       // 2: none
  T speed = 0;   // of the approach, m/s
};

// How far a particle is pushed in a round, m, and 1/kg by all pulses that act on it.
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

// As many pairs. Those of no meaning are of the first particle.
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
  T start = 0;     // how far it is off when the sub-step begins, m
  Point<T> way{};  // how far it goes in the sub-step, m
  Point<T> n{};    // from the surface
  T gap = 0;       // when the sub-step ends, m
  Impact<T> impact{};
  Point<T> impulse{};  // of impacts, kg m/s
};

// A particle in a sub-step, by its number: records of four.
template <class T>
struct MetStart {
  Point<T> x{};  // when the sub-step begins, m
  T r = 0;       // m
};
template <class T>
struct MetEnd {
  Point<T> x{};  // as the flows leave it, m
  T strays = 0;  // how far it goes in this sub-step beside what all do, m
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

// Whether the chord of a pair comes nearer than this.
template <class T>
bool comes_within(const Point<T>& q0, const Point<T>& q1, T distance) noexcept;

// The impact of a pair, with d the wanted distance and h the sub-step, or of a particle with a surface.
template <class T>
Impact<T> find_impact(std::size_t i, std::size_t j, const MetParticles<T>& of, T d, T h, T slowest) noexcept;
template <class T>
void find_impact(MetWall<T>& wall, std::size_t i, const MetParticles<T>& of, T h, T slowest) noexcept;
// The impulse on a particle that goes by u, m/s, against what it meets. w: of both, 1/kg.
template <class T>
Point<T> impulse_of(const Point<T>& n, const Point<T>& u, T w, T e, T mu) noexcept;

// The contact of a pair after impacts, from q0 to q1 and begun with the pulse of the sub-step before, or of none; and that of a
// surface, against which a particle goes by D.
template <class T>
Pulse<T> begin_contact(Separation<T>& contact, const Point<T>& q0, const Point<T>& q1, T d, const Pulse<T>& kept) noexcept;
template <class T>
Pulse<T> begin_contact(Separation<T>& contact, const Point<T>& D, const Pulse<T>& kept) noexcept;
// One round: what has been pushed, m, and 1/kg by all pulses that act.
template <class T>
void push(Separation<T>& contact, Pulse<T>& pulse, const Point<T>& moved, T w, T mu, T beta) noexcept;
// The pulse that the next sub-step begins with. weight: the pulse of a pair that carries its own weight.
template <class T>
Pulse<T> kept(const Separation<T>& contact, T weight) noexcept;

}  // namespace dvdx
