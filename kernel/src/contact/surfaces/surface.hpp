// Surfaces as the contact pass reads them, and where its formulas come from.
#pragma once

#include <array>
#include <cstdint>

#include "contact/surfaces/shape.hpp"
#include "dvdx/method.hpp"

// A step without its contacts runs from (x0, v0) to (x1, v1) in the time t. With f in 0..1 the fraction of it that has passed:
//
// Path.    curve:  x(f) = x0 + f (u + f a),  u = t v0,  a = x1 - x0 - u        (exact where the acceleration is constant;
//                  bend.hpp has the path and the response where springs, drag or forces of time bend it)
//          line:   x(f) = x0 + f (x1 - x0)
// Impact.  The first f at which the distance s from the surface goes from + to -. For a plane s(f) = s0 + d0 f + c f^2 with
//          d0 = n.u, c = s1 - s0 - d0, and the root is taken in the form in which nothing cancels:
//            d0 < 0:   f = 2 s0 / (-d0 + sqrt(d0^2 - 4 c s0))
//            d0 >= 0:  f = (d0 + sqrt(d0^2 - 4 c s0)) / (-2 c)            (it first moves away, then returns: c < 0)
//          A path that ends outside has dipped below if d0 < 0, d0^2 > 4 c s0 and -d0 < 2 c. Between x0 and x1 the parabola
//          stays in the triangle x0, x0 + u/2, x1; so nothing happens where the last two are outside, and that is the test that
//          every particle pays for. (If x0 alone is inside, the particle is on its way out.)
// Pulse.   Brown's contribution of an impact: a velocity pulse at f, which by dx = Int Int a acts on the position for the
//          remaining step. With v_f = v0 + f (v1 - v0), v_n = n.v_f <= 0:
//            v_n' = -e v_n,   v_t' = tau v_t less Coulomb's min(mu (1 + e) |v_n|, |tau v_t|),   dv = v' - v_f
//            resume:  dx = (1-f) t dv      seed:  dx = -n n.(x1 - x(f))
//          `seed` is the second pulse of Brown's text, in the direction of the first: it ends the step on the surface (on its
//          tangent plane at x(f)) and leaves the way along it. The same surface is not looked for again in this step.
//          tau = exp(-viscosity) belongs to an impact. A particle that lay or slid on the surface before the step is held up by
//          it at every step, with v_n no more than what the forces of a step give: it keeps v_t, else viscosity would brake
//          by the number of steps. It did so if it starts within rounding of the surface, and is neither thrown off it higher
//          than rounding (v_n^2 |t| <= 2 |n.(v1 - v0)| low) nor comes faster than by |n.(v1 - v0)|.
//          In a network pulses of springs press what rests onto the surface, at any speed, or lift it. A particle that the
//          other forces press more than springs lift is back within a sub-step s, so it lay there too if it starts no higher
//          than these forces, n.(v1 - v0)/t = b, make it fall in s, b s^2 / 2, and comes no faster than by b s.
//          The sweeps of generalized alpha also move positions, by x_b (b - a) of springs/sweep/sweep_scheme.cpp, before the
//          flow. Contacts see the way from where the flow before ended, as the flow's own, so that what rests starts on the
//          surface. And what has just hit a surface may be held by it, however deep inside a poor root of the path has left it.
//          Energy with `resume`, e = tau = 1, mu = 0 and constant acceleration a_n: x1 and v1 become x1 + (1-f) t dv and
//          v1 + dv with dv = -2 v_n n, so E' - E = 2 v_n (v_n - n.v1 + (1-f) t a_n) = 0 for any f, as v is linear in time.
//          `resume` goes on with the remaining step as a new path, on which every surface is looked for again; the one just
//          left stands at s0 = 0 exactly.
// Settling. The bounces after an impact with e < 1 are over at 2 e |v_n| / (b (1-e)), b the acceleration onto the
//          surface; where that is within the step, the impact is the last: e = 0, and with tau < 1 no tangential velocity is
//          left.
// Rest.    A surface may hold a particle that stands on it (4 eps of the coordinates) if that leaves it no higher than rounding
//          (below) or comes no faster than forces, and what holds it already, bring it to rest there, and settles, within the
//          step: one wall may push it onto another that the forces lead away from. Among those under which
//          the particle would end, the deepest takes it back along its normal; if another still has it inside, both do, with
//          the multiples (kappa = n_a.n_b)
//            l_a = (kappa s_b - s_a)/(1 - kappa^2),  l_b = (kappa s_a - s_b)/(1 - kappa^2),   neither of them negative;
//          a third leaves two of them or no motion at all. The same multiples for the velocities are the pulses of the normal
//          forces, and Coulomb's friction takes at most sum mu l off the velocity along the surfaces, evenly through the step.
//          Impacts on other surfaces are looked for on the path that is held; after one, what holds is found again.
//          A particle whose velocity does not move it by half an ulp in the step stays where the path began: rounding alone
//          must not make a resting particle creep.
// Clamp.   A particle that is inside after all impacts is put onto the surface, and its v_n < 0 is removed as by a plastic
//          impact, with Coulomb's friction of the velocity removed. Several surfaces: in turn, until all agree within rounding.
// Edge.    In a network, whose pulses begin a flow, an impact on a second surface at the same time takes both, by the multiples
//          above for v. One after a slide along the first does so too where what it takes of the normal velocity is no more
//          than 2 r min(1, 64 (1 - kappa)), r what the impact on the first one took in this flow: with a pulse's part Delta
//          along the wall r = Delta/tan of half the angle between the normals, and speeds w up to 2 Delta/(1 - kappa) stop. By
//          impacts one after the other w' = m Delta - kappa w, which has an attracting orbit for each number m of pulses on
//          the way up to (1 + kappa)/(1 - kappa): they never end. e = 0 on both.
// Pinch.   Facing surfaces, 1 + kappa <= mu^2 (1 - kappa) (a wedge of half its opening, tan^2 = (1 + kappa)/(1 - kappa), which
//          friction jams), that leave a particle no room where it starts: s_a + s_b < 0 there. It goes to the middle,
//            x + m (n_a - n_b),  m = (s_b - s_a)/(2 (1 - kappa)).
//          The force between rigid bodies that overlap has no bound, and no load turns the sum of two forces out of cones
//          that each hold the other's foot (force closure, Nguyen 1988): with any friction it goes by the mean of their
//          velocities, to where the mean of what they carry its start along to leaves it. Without friction it slides.
// Out.     A surface with a speed p leads a particle that starts the flow inside it, s0 < 0 by more than rounding, out along
//          its normal: the flow ends at s = s0 + p t, or where that is outside as it would, but at 0 <= s <= s0 + p t. The
//          velocity along the normal becomes the part of it that lies in 0..p, at the start (else a pulse that presses onto a
//          round body would push along it at the end, and heat) and at the end; friction
//          takes from the rest what it would from an impact by the part that leads in. Neither impacts on this surface are
//          looked for in the flow, nor is the particle put onto it; all else is as for any particle on that path. A particle
//          inside two surfaces that face each other leaves none, and goes to the middle.
// Sphere.  s = side (|x-c| - R). Its sign is that of g = side (|x-c|^2 - R^2) / (2R), a quartic along the parabola.
//          First guess: the quadratic Taylor part of g at the path's start (exact for a straight path), else the quadratic
//          through g0, g0' and g1; then Newton's steps that keep to 0..1 and to g' < 0.
// Motion.  A surface that moves has its pose at the end of the flow in n, d and center, a velocity u and an angular velocity
//          omega about the point `at`, all constant in the flow. A point x at the time t before the end has
//            V = u + omega x r,  r = x + t u - at,     and it comes to  at + R(t omega) r  where the surface takes it along.
//          R r = r + a w x r + b w x (w x r), w = t omega, a = sin|w|/|w|, b = (1 - cos|w|)/|w|^2, as series in w.w.
//          So the whole pass works on the trajectory as the surface sees it, in the axes and at the place that the surface
//          ends with: x0' the start taken along, v0' = R (v0 - V), x1' = x1, v1' = v1 - V. For a surface that does not turn,
//          and constant acceleration, that is the parabola itself less t u f: a time of impact is as right as at rest. A bent
//          path gets f l + f^2 q more, so that it starts with v0' and ends at x1'; q = 0 without a turn. A turn of theta in
//          a flow bends the seen path by theta^3 where no term says so, which is why turns make sub-steps (plan/substeps.cpp).
//          Pulses act along the normal of the moment, on v - V. Two surfaces that hold a particle and move in different ways
//          hold it against V* = V_a + delta / (1 - kappa^2) (n_b - kappa n_a), delta = n_b.(V_b - V_a): n_a.V* = n_a.V_a and
//          n_b.V* = n_b.V_b.
// Source: E. Brown, integral contributions (collision pulses); the numbers e, tau from his contact viscosity exp(-k).

namespace dvdx {

// Switches that depend on it name every shape, in all builds by -Werror=switch; docs/design.md lists what the compiler cannot
// see.
enum class Shape : std::uint8_t { plane, sphere, capsule, box, convex, mesh };

enum class Movement : std::uint8_t { rest, shifts, turns };

// The path of a step between two impacts: a parabola where no spring and no drag acts (bend.hpp).
enum class PathForm : std::uint8_t { parabola, flow };

template <class T>
struct Surface {
  Shape shape = Shape::plane;
  ContactPath sweep = ContactPath::curve;
  Response response = Response::resume;
  bool finds_dips = true;  // curve: the parabola is good enough to believe a dip that ends outside (and, of spheres, itself)
  std::array<T, 3> n{0, 1, 0};  // plane: unit normal
  T d = 0;                      // plane: offset, m
  std::array<T, 3> center{};    // sphere, m; of a body the ball that holds it
  T radius = 0;                 // m; a plane has none
  T side = 1;                   // sphere: 1 where particles are outside, -1 inside
  T half_curvature = T(0.5);    // sphere: side / (2 radius), 1/m
  T e = 0;                      // what an impact leaves of the normal velocity, restitution and normal viscosity together
  T tau = 1;                    // ... and of the tangential velocity, unless it is resting: exp(-viscosity)
  T mu = 0;                     // Coulomb friction; finite, so that mu 0 = 0
  // In a network, whose springs' pulses stand between flows: how many of this flow a sub-step is long; 0 without pulses. And
  // what goes at v along a curved surface may be so many (v t)^2 off it after a flow.
  T flows_per_substep = 0;
  T falls_away = 0;  // 1/m
  T hold = 0;        // resting: tangential velocities below hold times the normal one removed vanish: >= mu, >= rounding
  T push_out = 0;    // m/s: of what starts inside; 0: that is put onto the surface at once
  Movement movement = Movement::rest;
  std::array<T, 3> u{};       // m/s
  std::array<T, 3> omega{};   // rad/s
  std::array<T, 3> at{};      // m: turns about this point, which goes by u, where it is at the flow's end
  std::uint32_t contact = 0;  // of the scene: that which this is
  std::uint32_t part = 0;     // ... of which this is one of several planes
  bool is_searched = false;   // a sphere's outside where blocks search (near.hpp)
  Solid<T> solid{};           // of the other shapes
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

// A bounce that rises by less than this many epsilons of the coordinates, d0^2 / (4 |c|), is resting: rounding alone would keep
// a particle that slides on an oblique plane bouncing (18 impacts in a step, and ten times the time of a resting one).
inline constexpr int low_bounce = 2;

// Newton's steps to a sphere, and rounds in which surfaces that disagree push a particle.
inline constexpr int newton_steps = 4;
inline constexpr int clamp_rounds = 64;

// In a flat edge: what goes along a wall by more pulses than these is not stopped in it.
inline constexpr int most_pulses = 64;

// A particle is inside a surface, not on it, where it is so many epsilons of the coordinates deep.
inline constexpr int least_depth = 64;

// Surfaces that open by less than twice this angle face each other without friction, too.
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
