// Surfaces as the contact pass reads them, and the derivation of its formulas.
#pragma once

#include <array>
#include <cstdint>

#include "contact/surfaces/shape.hpp"
#include "dvdx/method.hpp"

// Without contacts, a step runs from (x0, v0) to (x1, v1) in the time t. f in 0..1 is the fraction of it that has passed.
//
// Path.    curve:  x(f) = x0 + f (u + f a),  u = t v0,  a = x1 - x0 - u        (exact for a constant acceleration; bend.hpp
//                  has the path and the response where springs, drag or forces of time bend it)
//          line:   x(f) = x0 + f (x1 - x0)
// Impact.  The first f at which the distance s from the surface goes from + to -. For a plane s(f) = s0 + d0 f + c f^2 with
//          d0 = n.u, c = s1 - s0 - d0, and the root is taken in the form in which nothing cancels:
//            d0 < 0:   f = 2 s0 / (-d0 + sqrt(d0^2 - 4 c s0))
//            d0 >= 0:  f = (d0 + sqrt(d0^2 - 4 c s0)) / (-2 c)            (it first moves away, then returns: c < 0)
//          A path that ends outside has dipped below if d0 < 0, d0^2 > 4 c s0 and -d0 < 2 c. Between x0 and x1 the parabola
//          stays in the triangle x0, x0 + u/2, x1. If the last two points are outside, there is no impact; this is the test
//          that every particle pays for. (If x0 alone is inside, the particle is on its way out.)
// Pulse.   Brown's contribution of an impact: a velocity pulse at f, which by dx = Int Int a acts on the position for the
//          remaining step. With v_f = v0 + f (v1 - v0), v_n = n.v_f <= 0:
//            v_n' = -e v_n,   v_t' = tau v_t less Coulomb's min(mu (1 + e) |v_n|, |tau v_t|),   dv = v' - v_f
//            resume:  dx = (1-f) t dv      seed:  dx = -n n.(x1 - x(f))
//          `seed` is the second pulse of Brown's text, in the direction of the first. It ends the step on the surface (on its
//          tangent plane at x(f)) and does not change the way along it. The step does not look for the same surface again.
//          tau = exp(-viscosity) belongs to an impact. A particle that already lay or slid on the surface meets it in every
//          step, with v_n no more than the forces of a step give. It keeps v_t; otherwise viscosity would brake it once a step.
//          It lay there if it starts within rounding of the surface, leaves it no higher than rounding
//          (v_n^2 |t| <= 2 |n.(v1 - v0)| low), and comes no faster than |n.(v1 - v0)|.
//          In a network, pulses of springs press a resting particle onto the surface at any speed, or lift it. If the other
//          forces press more than springs lift, it is back within a sub-step s. So it also lay there if it starts no higher
//          than b s^2 / 2, which these forces, b = n.(v1 - v0)/t, make it fall in s, and comes no faster than b s.
//          The sweeps of generalized alpha also move positions before the flow, by x_b (b - a) of
//          springs/sweep/sweep_scheme.cpp. Contacts count this move as part of the flow's way, so a resting particle starts on
//          the surface. A surface that was just hit may hold the particle however deep inside a poor root of the path left it.
//          Energy with `resume`, e = tau = 1, mu = 0 and constant acceleration a_n: x1 and v1 become x1 + (1-f) t dv and
//          v1 + dv with dv = -2 v_n n, so E' - E = 2 v_n (v_n - n.v1 + (1-f) t a_n) = 0 for any f, as v is linear in time.
//          `resume` goes on with the remaining step as a new path and looks for every surface again; the one just left is at
//          s0 = 0 exactly.
// Settling. The bounces after an impact with e < 1 are over after 2 e |v_n| / (b (1-e)), b the acceleration onto the surface.
//          If that is within the step, the impact is the last: e = 0, and with tau < 1 no tangential velocity is left.
// Rest.    A surface may hold a particle that stands on it (4 eps of the coordinates). A particle that leaves the surface must
//          rise no higher than rounding (low_bounce). One that comes must be no faster than the forces and the surfaces that
//          already hold it can stop within the step, and its bounces must be over by then. (One wall may push it onto another
//          that the forces lead away from.) If the particle would end inside several of them, the deepest takes it back along
//          its normal; if another still has it inside, both do, with the multiples (kappa = n_a.n_b)
//            l_a = (kappa s_b - s_a)/(1 - kappa^2),  l_b = (kappa s_a - s_b)/(1 - kappa^2),   neither of them negative.
//          With a third, two of them hold it, or it does not move at all. The same multiples for the velocities are the pulses
//          of the normal forces, and Coulomb's friction takes at most sum mu l off the velocity along the surfaces, evenly
//          through the step. Impacts on other surfaces are looked for on the path that is held; after one, the holding surfaces
//          are found again. A particle whose velocity does not move it by half an ulp in the step stays where the path began,
//          since rounding alone must not make a resting particle creep.
// Clamp.   A particle that is inside after all impacts is put onto the surface. Its v_n < 0 is removed as by a plastic impact,
//          with Coulomb's friction of the velocity removed. Several surfaces take turns until all agree within rounding.
// Edge.    In a network, pulses begin a flow. An impact on a second surface at the same time takes both, by the multiples above
//          for v. An impact after a slide along the first does so too if kappa <= 0, or if it takes no more of the normal
//          velocity than 2 r min(1, 64 (1 - kappa)), r the normal velocity that the impact on the first took in this flow. With
//          Delta the part of a pulse along the wall, r = Delta/tan of half the angle between the normals, so speeds w up to
//          2 Delta/(1 - kappa) stop. Impacts one after the other would give w' = m Delta - kappa w, which has an attracting
//          orbit for each number m of pulses on the way up to (1 + kappa)/(1 - kappa): they would never end. e = 0 on both.
// Pinch.   Two surfaces face each other if 1 + kappa <= mu^2 (1 - kappa): a wedge that friction jams, with half its opening
//          given by tan^2 = (1 + kappa)/(1 - kappa). If they leave a particle no room where it starts, s_a + s_b < 0, it goes
//          to the middle,
//            x + m (n_a - n_b),  m = (s_b - s_a)/(2 (1 - kappa)).
//          The force between overlapping rigid bodies has no bound. If each friction cone holds the other's foot, such forces
//          balance any load (force closure, Nguyen 1988). So with any friction the particle takes the mean of the surfaces'
//          velocities, and keeps its place between them: the mean of where they carry its start to. Without friction it slides.
// Out.     A surface with a speed p leads a particle that starts the flow inside it, s0 < 0 by more than rounding, out along
//          its normal. The flow ends at s = s0 + p t if that is still inside; otherwise it ends where it would, but at
//          0 <= s <= s0 + p t. The velocity along the normal is cut to 0..p at the start and at the end. (Without the cut at
//          the start, a pulse that presses onto a round body would push along it at the end, and heat.) Friction acts on the
//          rest as at an impact with the inward velocity that was cut. In this flow the particle has no impacts on this surface
//          and is not put onto it; all else is as for any particle on that path. A particle inside two surfaces that face each
//          other leaves neither, and goes to the middle.
// Sphere.  s = side (|x-c| - R) has the sign of g = side (|x-c|^2 - R^2) / (2R), a quartic along the parabola. The first guess
//          is the root of the quadratic Taylor part of g at the path's start (exact for a straight path), or else of the
//          quadratic through g0, g0' and g1. Newton's steps follow; they keep to 0..1 and to g' < 0.
// Motion.  n, d and center of a moving surface are those at the end of the flow. Its velocity u and its angular velocity omega
//          about the point `at` are constant in the flow. At the time t before the end, its velocity at a point x is
//            V = u + omega x r,  r = x + t u - at,     and it carries x to  at + R(t omega) r  by the end.
//          R r = r + a w x r + b w x (w x r), w = t omega, a = sin|w|/|w|, b = (1 - cos|w|)/|w|^2, as series in w.w. The whole
//          pass works on the trajectory as the surface sees it, in the axes and at the place in which the surface ends: x0' the
//          start carried along, v0' = R (v0 - V), x1' = x1, v1' = v1 - V. For a surface that does not turn and a constant
//          acceleration, that is the parabola itself less t u f: a time of impact is as right as at rest. A bent path gets
//          f l + f^2 q more, so that it starts with v0' and ends at x1'; q = 0 without a turn. A turn of theta in a flow bends
//          the seen path by theta^3, for which there is no term; so turns make sub-steps (plan/substeps.cpp). Pulses act along
//          the normal of the moment, on v - V. Two surfaces that hold a particle and move in different ways hold it against
//          V* = V_a + delta / (1 - kappa^2) (n_b - kappa n_a), delta = n_b.(V_b - V_a): n_a.V* = n_a.V_a and n_b.V* = n_b.V_b.
// Source: E. Brown, integral contributions (collision pulses); the numbers e, tau from his contact viscosity exp(-k).

namespace dvdx {

// Every switch over Shape names all shapes, in all builds by -Werror=switch. docs/design.md lists the places that the compiler
// cannot check.
enum class Shape : std::uint8_t { plane, sphere, capsule, box, convex, mesh };

enum class Movement : std::uint8_t { rest, shifts, turns };

// The path of a step between two impacts: a parabola unless springs, drag or forces of time bend it (bend.hpp).
enum class PathForm : std::uint8_t { parabola, flow };

template <class T>
struct Surface {
  Shape shape = Shape::plane;
  ContactPath sweep = ContactPath::curve;
  Response response = Response::resume;
  bool finds_dips = true;       // curve: the parabola is good enough for dips that end outside (sphere, body: for all impacts)
  std::array<T, 3> n{0, 1, 0};  // plane: unit normal
  T d = 0;                      // plane: offset, m
  std::array<T, 3> center{};    // sphere, m; of a body the ball that contains it
  T radius = 0;                 // m; a plane has none
  T side = 1;                   // sphere: 1 where particles are outside, -1 inside
  T half_curvature = T(0.5);    // sphere: side / (2 radius), 1/m
  T e = 0;                      // part of the normal velocity that an impact leaves: restitution and normal viscosity together
  T tau = 1;                    // ... and of the tangential velocity, unless the particle rests: exp(-viscosity)
  T mu = 0;                     // Coulomb friction; finite, so that mu 0 = 0
  // In a network, pulses of springs stand between flows. flows_per_substep: sub-step over flow, 0 without pulses. falls_away:
  // sliding at v along a curved surface may leave a particle falls_away (v t)^2 off it after a flow.
  T flows_per_substep = 0;
  T falls_away = 0;  // 1/m
  T hold = 0;        // resting: tangential velocities up to hold times the normal one removed vanish; >= mu, >= rounding
  T push_out = 0;    // m/s, of a particle that starts inside; 0: it is put onto the surface at once
  Movement movement = Movement::rest;
  std::array<T, 3> u{};       // m/s
  std::array<T, 3> omega{};   // rad/s
  std::array<T, 3> at{};      // m: the surface turns about this point, which moves by u; at the flow's end
  std::uint32_t contact = 0;  // index of the contact in the scene
  std::uint32_t part = 0;     // index of this plane, for a contact of several
  bool is_searched = false;   // outside of a sphere, if blocks search (near.hpp)
  Solid<T> solid{};           // of shapes other than plane and sphere
};

template <class T>
constexpr bool has_pulses(const Surface<T>& surface) noexcept {
  return surface.flows_per_substep > 0;
}

template <class T>
constexpr bool pushes_out(const Surface<T>& surface) noexcept {
  return surface.push_out > 0;
}

// Whether impacts are looked for along the chord of the path.
template <class T>
constexpr bool goes_straight(const Surface<T>& surface) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return surface.sweep == ContactPath::line;
    case Shape::sphere:
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return surface.sweep == ContactPath::line || !surface.finds_dips;
}

// A bounce whose height d0^2 / (4 |c|) is less than this many epsilons of the coordinates is rest. Otherwise rounding alone
// would keep a slide on an oblique plane bouncing (18 impacts a step, ten times the time of a resting one).
inline constexpr int low_bounce = 2;

// Newton's steps to a sphere, and the most rounds in which surfaces clamp a particle in turn.
inline constexpr int newton_steps = 4;
inline constexpr int clamp_rounds = 64;

// A flat edge stops speeds along a wall of up to twice this many pulses.
inline constexpr int most_pulses = 64;

// A particle is inside a surface, not on it, if it is more than this many epsilons of the coordinates deep.
inline constexpr int least_depth = 64;

// Surfaces that open by less than twice this angle face each other even without friction.
template <class T>
inline constexpr T least_grip = T(0.0625);

// sin w / w and (1 - cos w) / w^2 by powers of w^2: to 1e-16 up to half a radian.
template <class T>
inline constexpr std::array<T, 7> turn_sine = {
    T(1), T(-1.0 / 6), T(1.0 / 120), T(-1.0 / 5040), T(1.0 / 362880), T(-1.0 / 39916800), T(1.0 / 6227020800.0)};
template <class T>
inline constexpr std::array<T, 7> turn_versine = {T(1.0 / 2),       T(-1.0 / 24),        T(1.0 / 720),          T(-1.0 / 40320),
                                                  T(1.0 / 3628800), T(-1.0 / 479001600), T(1.0 / 87178291200.0)};

}  // namespace dvdx
