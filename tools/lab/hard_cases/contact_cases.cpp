// One particle and the surfaces that it meets.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <optional>

#include "closed_form/closed_form.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double hz60 = 1.0 / 60;
constexpr double gravity = 9.81;
constexpr double infinite = std::numeric_limits<double>::infinity();

double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3& a) { return std::sqrt(product(a, a)); }
Vec3 scaled(const Vec3& a, double s) { return {s * a[0], s * a[1], s * a[2]}; }

template <class T>
Vec3 position(const Trial<T>& trial, std::size_t i = 0) {
  return {trial.x(0, i), trial.x(1, i), trial.x(2, i)};
}
template <class T>
Vec3 velocity(const Trial<T>& trial, std::size_t i = 0) {
  return {trial.v(0, i), trial.v(1, i), trial.v(2, i)};
}

Plane wall(const Vec3& normal, double offset, double restitution) {
  return {.normal = normal, .offset = offset, .restitution = restitution};
}
Plane ground(double restitution) { return wall({0, 1, 0}, 0, restitution); }

Scene scene_of(const std::vector<Plane>& planes, const Vec3& acceleration = {}) {
  Scene scene;
  if (acceleration != Vec3{}) scene.add(Constant{.acceleration = acceleration});
  for (const Plane& plane : planes) scene.add(Contact(plane));
  return scene;
}
Scene falling(const std::vector<Plane>& planes) { return scene_of(planes, {0, -gravity, 0}); }

// --- 20: rest ------------------------------------------------------------------------------------------------------------

template <class T>
Worst rest_on_axis(CaseRun& way) {
  Worst worst;
  for (const double offset : {0.0, 7.3, -0.1}) {
    for (const double restitution : {0.0, 0.5, 1.0}) {
      const double y = static_cast<double>(static_cast<T>(offset));
      Trial<T> trial(way, falling({wall({0, 1, 0}, offset, restitution)}), hz60, Start{{3, y, -2}, {}});
      trial.rest(1000000);
      const auto where = fmt::format("offset {:g} m, e = {:g}", offset, restitution);
      worst.see(length({trial.x(0) - 3, trial.x(1) - y, trial.x(2) + 2}), where);
      worst.see(length(velocity(trial)), where);
    }
  }
  return worst;
}

// A particle at rest on an oblique plane, over 1e6 steps after it has settled, each over its own bar: how far it is from
// the plane (4 eps of its distance from the origin), how fast along the normal (1e-6 m/s), how far it creeps (not at all).
template <class T>
Worst rest_on_oblique(CaseRun& way) {
  constexpr double offset = 7.3;
  Worst worst;
  for (const Vec3& direction : {Vec3{0.3, 0.8, -0.2}, Vec3{-1, 1, 1}, Vec3{0.01, 1, 0.02}}) {
    const Vec3 n = scaled(direction, 1 / length(direction));
    const Vec3 start{offset * n[0] + 2 * n[1], offset * n[1] - 2 * n[0], offset * n[2]};
    Trial<T> trial(way, scene_of({wall(n, offset, 0.5)}, scaled(n, -gravity)), hz60, Start{start, {}});
    trial.step(100);
    const Vec3 settled = position(trial);
    trial.rest(1000000);
    const Vec3 end = position(trial);
    const double creep = length({end[0] - settled[0], end[1] - settled[1], end[2] - settled[2]});
    const auto where = [&](const char* what) {
      return fmt::format("{}, normal ({:g}, {:g}, {:g})", what, direction[0], direction[1], direction[2]);
    };
    worst.see(std::abs(product(n, end) - offset) / (4 * epsilon<T> * length(end)), where("distance"));
    worst.see(std::abs(product(n, velocity(trial))) / 1e-6, where("speed"));
    worst.see(creep > 0 ? infinite : creep, where("creep"));
  }
  return worst;
}

// On inclines that friction of 0.5 holds, by a part in a thousand at the steepest: how far and how fast each particle is after
// 1e6 steps from where it was put down at rest.
template <class T>
Worst rest_on_incline(CaseRun& way) {
  constexpr double friction = 0.5;
  constexpr double offset = 7.3;
  Worst worst;
  for (const double steepness : {0.1, 0.9, 0.999}) {
    for (const auto& [restitution, turn] : {std::pair{0.0, 0.7}, {0.5, 0.0}}) {  // turned about the vertical
      const double angle = std::atan(steepness * friction);
      const Vec3 n{std::sin(angle) * std::cos(turn), std::cos(angle), std::sin(angle) * std::sin(turn)};
      Plane incline = wall(n, offset, restitution);
      incline.friction = friction;
      std::vector<Start> starts;
      for (int i = 0; i < 4; ++i) {
        const double along = 0.9 * i - 2;
        starts.push_back({{offset * n[0] + along * n[1], offset * n[1] - along * n[0], offset * n[2]}, {}});
      }
      Trial<T> trial(way, falling({incline}), hz60, starts);
      trial.step(100);
      std::vector<Vec3> settled;
      for (std::size_t i = 0; i < starts.size(); ++i) settled.push_back(position(trial, i));
      trial.rest(1000000);
      const auto where = fmt::format("{:g} of the slope that holds, e = {:g}", steepness, restitution);
      for (std::size_t i = 0; i < starts.size(); ++i) {
        const Vec3 end = position(trial, i);
        worst.see(length({end[0] - settled[i][0], end[1] - settled[i][1], end[2] - settled[i][2]}), where);
        worst.see(length(velocity(trial, i)), where);
      }
    }
  }
  return worst;
}

// A steeper one: it slides as the closed form does, g (sin - mu cos) t^2/2 in 10 s, over the way without friction.
template <class T>
Worst slides_down(CaseRun& way, double friction, double restitution, std::initializer_list<double> steepnesses) {
  Worst worst;
  for (const double steepness : steepnesses) {
    const double angle = std::atan(steepness * friction);
    Plane incline = wall({std::sin(angle), std::cos(angle), 0}, 0, restitution);
    incline.friction = friction;
    Trial<T> trial(way, falling({incline}), hz60, Start{});
    trial.step(600);
    const double pull = gravity * (std::sin(angle) - friction * std::cos(angle));
    const double down = std::cos(angle) * trial.x(0) - std::sin(angle) * trial.x(1);
    worst.see(std::abs(down - pull * 50) / (gravity * std::sin(angle) * 50),
              fmt::format("{:g} times as steep as holds", steepness));
  }
  return worst;
}

template <class T>
Worst sliding(CaseRun& way) {
  return slides_down<T>(way, 0.5, 0, {1.1, 2.0});
}

// --- 21, 22: bounces -----------------------------------------------------------------------------------------------------

// A ball is dropped from 1 m: bounce k comes at first (1 + 2 (e + ... + e^k)).
long double first_bounce() { return std::sqrt(2.0L / static_cast<long double>(gravity)); }

template <class T>
Worst rest_time(CaseRun& way) {
  Worst worst;
  for (const double e : {0.3, 0.5, 0.7}) {
    Trial<T> trial(way, falling({ground(e)}), hz60, Start{{0, 1, 0}, {}});
    const auto rest = static_cast<double>(first_bounce()) * (1 + 2 * e / (1 - e));
    int n = 0;
    do {
      trial.step();
      ++n;
    } while (n < 1000 && (trial.v(1) != 0 || trial.x(1) != 0));
    worst.see(std::abs(n * hz60 - 0.5 * hz60 - rest) / (0.5 * hz60), fmt::format("e = {:g}", e));
  }
  return worst;
}

template <class T>
Worst rest_energy(CaseRun& way) {
  Worst worst;
  for (const double e : {0.3, 0.5, 0.7}) {
    Trial<T> trial(way, falling({ground(e)}), hz60, Start{{0, 1, 0}, {}});
    const auto rest = static_cast<double>(first_bounce()) * (1 + 2 * e / (1 - e));
    trial.step(static_cast<std::size_t>(std::ceil(rest / hz60)) + 1);
    for (int n = 0; n < 600; ++n) {  // from the step after that in which it comes to rest on
      worst.see(std::abs(trial.v(1)) + std::abs(trial.x(1)), fmt::format("e = {:g}", e));
      trial.step();
    }
  }
  return worst;
}

// When the last impact was, as the parabola since then tells.
template <class T>
double seconds_since_impact(const Trial<T>& trial) {
  return 2 * trial.x(1) / (trial.v(1) + std::sqrt(trial.v(1) * trial.v(1) + 2 * gravity * trial.x(1)));
}

// All bounces that are more than a step apart, or the first ones: what has met the ground twice in a step tells the last time
// alone.
template <class T, ContactPath sweep, int first_ones = 1000>
Worst bounce_times(CaseRun& way) {
  Worst worst;
  for (const double hertz : {60.0, 1000.0}) {
    for (const double e : first_ones < 1000 ? std::vector{0.5} : std::vector{0.3, 0.5, 0.7}) {
      const double h = 1 / hertz;
      Plane floor = ground(e);
      floor.sweep = sweep;
      Trial<T> trial(way, falling({floor}), h, Start{{0, 1, 0}, {}});
      long double at = first_bounce();
      long double flight = 2 * first_bounce() * static_cast<long double>(e);
      int n = 0;
      for (int bounce = 1; bounce <= first_ones && flight > 1.01L * static_cast<long double>(h); ++bounce) {
        while (n * h <= static_cast<double>(at)) {
          trial.step();
          ++n;
        }
        const long double got = static_cast<long double>(n) * h - seconds_since_impact(trial);
        worst.see(static_cast<double>(std::abs(got - at)), fmt::format("{:g} Hz, e = {:g}, bounce {}", hertz, e, bounce));
        at += flight;
        flight *= static_cast<long double>(e);
      }
    }
  }
  return worst;
}

template <class T>
Worst elastic_energy(CaseRun& way) {
  Trial<T> trial(way, falling({ground(1)}), hz60, Start{{0, 1, 0}, {}});
  Worst worst;
  for (int n = 0; n < 60000; ++n) {
    trial.step();
    worst.see(std::abs(trial.x(1) + trial.v(1) * trial.v(1) / (2 * gravity) - 1));
  }
  return worst;
}

// --- 23 to 26: at the surface --------------------------------------------------------------------------------------------

template <class T>
Worst grazing(CaseRun& way) {
  Worst worst;
  for (const double y : {0.0, 1e-7}) {
    Plane floor = ground(0.5);
    floor.friction = 0.3;
    floor.viscosity = 1;
    Trial<T> trial(way, scene_of({floor}), hz60, Start{{0.1, y, 0.2}, {1.1, 0, -2.3}});
    const Vec3 before = velocity(trial);
    trial.step(1000);
    const Vec3 after = velocity(trial);
    for (std::size_t axis = 0; axis < 3; ++axis) worst.see(std::abs(after[axis] - before[axis]), fmt::format("y = {:g} m", y));
  }
  return worst;
}

template <class T>
Worst start_inside(CaseRun& way) {
  const std::vector<Start> starts{{{0, -0.1, 0}, {0, -5, 0}}, {{0, -0.1, 0}, {}}, {{0, -0.1, 0}, {0, 5, 0}}};
  Trial<T> trial(way, scene_of({ground(0.5)}), hz60, starts);
  trial.step();
  Worst worst;
  for (const auto& [i, speed] : {std::pair{0U, 2.5}, {1U, 0.0}, {2U, 5.0}}) {
    const auto where = fmt::format("v_n = {:g} m/s", starts[i].v[1]);
    worst.see(std::abs(trial.v(1, i) - speed), where);
    worst.see(-trial.x(1, i), where);
  }
  return worst;
}

template <class T>
Worst start_on_plane(CaseRun& way) {
  Trial<T> trial(way, scene_of({ground(0.5)}), hz60, std::vector<Start>{{{}, {0, 3, 0}}, {{}, {0, -3, 0}}});
  trial.step();
  Worst worst;
  worst.see(std::abs(trial.x(1, 0) / 0.05 - 1) / epsilon<T>, "v_n = 3 m/s");
  worst.see(std::abs(trial.x(1, 1) / 0.025 - 1) / epsilon<T>, "v_n = -3 m/s");
  return worst;
}

// Position over |v| h and speed over itself, in eps.
template <class T>
Worst corners(CaseRun& way) {
  Worst worst;
  for (const std::size_t walls : {2U, 3U}) {
    std::vector<Plane> planes{wall({1, 0, 0}, 0, 1), wall({0, 1, 0}, 0, 1), wall({0, 0, 1}, 0, 1)};
    planes.resize(walls);
    const double near = 0.5 * hz60;
    const bool is_three = walls == 3;
    Trial<T> trial(way, scene_of(planes), hz60, Start{{near, near, is_three ? near : 1}, {-1, -1, is_three ? -1.0 : 0.0}});
    const double speed = length(velocity(trial));
    const double start = trial.x(0);
    trial.step();
    const auto where = fmt::format("{} planes", walls);
    for (std::size_t axis = 0; axis < walls; ++axis) {
      worst.see(std::abs(trial.x(axis) - (hz60 - start)) / (epsilon<T> * speed * hz60), where);
    }
    worst.see(std::abs(length(velocity(trial)) / speed - 1) / epsilon<T>, where);
  }
  return worst;
}

// --- 27 to 29: many impacts in a step, fast particles --------------------------------------------------------------------

// 16 particles in a wedge of 20 degrees, closed by a wall.
struct Wedge {
  double deepest = 0;  // m, in eps
  double change = 0;   // of kinetic energy in one step, gained or lost
};

template <class T>
Wedge in_wedge(CaseRun& way) {
  const double angle = 20 * std::numbers::pi / 180;
  const std::vector<Vec3> normals{{0, 1, 0}, {std::sin(angle), -std::cos(angle), 0}, {-1, 0, 0}};
  const std::vector<double> offsets{0, 0, -2};
  std::vector<Plane> planes;
  for (std::size_t k = 0; k < 3; ++k) planes.push_back(wall(normals[k], offsets[k], 1));
  std::vector<Start> starts;
  for (int i = 0; i < 16; ++i) starts.push_back({{1.2, 0.2, 0}, {3 * std::cos(0.37 * i), 3 * std::sin(0.37 * i), 0}});
  Trial<T> trial(way, scene_of(planes), hz60, starts);
  Worst deepest;
  Worst change;
  for (int n = 0; n < 5000; ++n) {
    std::vector<double> before;
    for (std::size_t i = 0; i < 16; ++i) before.push_back(product(velocity(trial, i), velocity(trial, i)));
    trial.step();
    for (std::size_t i = 0; i < 16; ++i) {
      change.see(std::abs(product(velocity(trial, i), velocity(trial, i)) / before[i] - 1));
      for (std::size_t k = 0; k < 3; ++k) {
        // the plane as the particle's precision holds it
        const Vec3 held{static_cast<T>(normals[k][0]), static_cast<T>(normals[k][1]), static_cast<T>(normals[k][2])};
        deepest.see((offsets[k] - product(held, position(trial, i))) / epsilon<T>);
      }
    }
  }
  return {deepest.value, change.value};
}

template <class T, double Wedge::*what>
Worst wedge(CaseRun& way) {
  Worst worst;
  worst.see(in_wedge<T>(way).*what);
  return worst;
}

// A step between two walls 1/16 m apart that a particle crosses `bounces` times.
template <class T>
struct Channel {
  static constexpr double width = 0.0625;
  Channel(CaseRun& way, int bounces)
      : trial(way, scene_of({ground(1), wall({0, -1, 0}, -width, 1)}), hz60, Start{{}, {0.7, (bounces + 0.3) * width * 60, 0}}),
        speed(length(velocity(trial))) {
    trial.step();
  }
  Trial<T> trial;
  double speed;
};

template <class T>
Worst folded_path(CaseRun& way) {
  Worst worst;
  for (const int bounces : {2, 17, 30}) {
    const Channel<T> channel(way, bounces);
    const double exact = (bounces % 2 == 0 ? 0.3 : 0.7) * Channel<T>::width;
    worst.see(std::abs(channel.trial.x(1) - exact), fmt::format("{} bounces", bounces));
  }
  return worst;
}

// Beyond as many impacts as a step resolves.
template <class T>
Worst contained(CaseRun& way) {
  Worst worst;
  for (const int bounces : {33, 167, 4000}) {
    const Channel<T> channel(way, bounces);
    const double y = channel.trial.x(1);
    const auto where = fmt::format("{} bounces", bounces);
    worst.see(std::max(-y, y - Channel<T>::width), where);
    worst.see(length(velocity(channel.trial)) / channel.speed - (1 + 4 * epsilon<T>), where);
  }
  return worst;
}

template <class T>
Worst tunnelling(CaseRun& way) {
  Worst worst;
  for (const double speed : {1e3, 1e5, 1e7}) {
    for (const ContactPath sweep : {ContactPath::curve, ContactPath::line}) {
      Plane floor = ground(1);
      floor.sweep = sweep;
      Trial<T> trial(way, scene_of({floor}), hz60, Start{{0, 10, 0}, {0, -speed, 0}});
      trial.step();
      const double exact = speed / 60 - 10;
      worst.see(std::abs(trial.x(1) - exact) / (epsilon<T> * std::abs(exact)), fmt::format("{:g} m/s", speed));
    }
  }
  return worst;
}

// --- 30, 42: what an impact leaves ---------------------------------------------------------------------------------------

template <class T>
Vec3 left_of(CaseRun& way, double restitution, double viscosity, double friction) {
  Plane floor = ground(restitution);
  floor.viscosity = viscosity;
  floor.friction = friction;
  Trial<T> trial(way, scene_of({floor}), hz60, Start{{0, 0.01, 0}, {3, -1, 4}});
  trial.step();
  return velocity(trial);
}

// v_n' = -e v_n; v_t' = tau v_t less Coulomb's mu (1 + e) |v_n|, but not below 0.
template <class T>
Worst impact_laws(CaseRun& way) {
  Worst worst;
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double tau : {1.0, 0.25, 0.0}) {
      for (const double mu : {0.0, 0.3, 2.0, 1e30, infinite}) {
        const Vec3 got = left_of<T>(way, e, tau > 0 ? -std::log(tau) : infinite, mu);
        const double slid = tau > 0 ? std::max(0.0, 5 * tau - mu * (1 + e)) / 5 : 0;
        const auto where = fmt::format("e = {:g}, tau = {:g}, mu = {:g}", e, tau, mu);
        for (const auto& [axis, exact] : {std::pair{0U, 3 * slid}, {1U, e}, {2U, 4 * slid}}) {
          worst.see(std::abs(got[axis] - exact) / (5 * epsilon<T>), where);
        }
      }
    }
  }
  return worst;
}

// Figures that must be 0 are.
template <class T>
Worst impact_zeros(CaseRun& way) {
  Worst worst;
  for (const double e : {0.0, 1.0}) {
    const Vec3 sticky = left_of<T>(way, e, infinite, 0);
    const Vec3 rough = left_of<T>(way, e, 0, infinite);
    for (const Vec3& v : {sticky, rough})
      worst.see(std::abs(v[0]) + std::abs(v[2]), fmt::format("tau = 0 or mu infinite, e = {:g}", e));
  }
  worst.see(std::abs(left_of<T>(way, 0, 0, 0)[1]), "e = 0");
  return worst;
}

template <class T>
Worst sticks_in_corner(CaseRun& way) {
  Worst worst;
  for (const bool is_viscous : {false, true}) {
    std::vector<Plane> planes{ground(0), wall({1, 0, 0}, 0, 0)};
    for (Plane& plane : planes) (is_viscous ? plane.viscosity : plane.friction) = infinite;
    Trial<T> trial(way, scene_of(planes, {-2, -gravity, 1}), hz60, Start{{}, {-1, -2, 3}});
    const auto where = is_viscous ? "infinite viscosity" : "infinite friction";
    trial.step(2);
    worst.see(length(velocity(trial)), where);
    const Vec3 held = position(trial);
    trial.step(100000);
    worst.see(length(velocity(trial)), where);
    const Vec3 end = position(trial);
    worst.see(length({end[0] - held[0], end[1] - held[1], end[2] - held[2]}), where);
  }
  return worst;
}

// --- 39: the time of impact ----------------------------------------------------------------------------------------------

struct Flight {
  double W = 0, g = 0, a = 0;  // about the origin
  double wall = 0;             // m: the plane y >= wall
  double y = 0, v = 0;

  [[nodiscard]] AxisState motion(long double t) const {
    return solve({.W = W, .g = g, .polynomial = {a}, .sines = {}}, {y, v}, t);
  }
  [[nodiscard]] long double height(long double t) const { return motion(t).x - wall; }
  // The fraction of the step at which it passes the wall, where it ends below and does not meet the wall twice.
  [[nodiscard]] std::optional<double> impact() const {
    if (height(hz60) >= 0) return std::nullopt;
    long double above = 0;
    long double below = hz60;
    for (int i = 0; i < 60; ++i) {
      const long double middle = (above + below) / 2;
      (height(middle) >= 0 ? above : below) = middle;
    }
    const long double speed = std::abs(motion(above).v);
    const long double back = std::abs(W * y) + std::abs(a) + g * speed;  // m/s^2, towards the wall
    if (back * (hz60 - above) > speed) return std::nullopt;
    return static_cast<double>(above / hz60);
  }
};

// |f - exact|, f from what the pulse of an elastic impact did to the step: with r = (1 - f) h, dx = dv sin(omega r)/omega under
// a spring and dx = dv (1 - exp(-g r))/g in air, where v has changed by dv cos(omega r) and dv exp(-g r).
double impact_error(CaseRun& way, const Flight& flight, double exact) {
  Scene scene;
  if (flight.W != 0) scene.add(Spring{.stiffness = flight.W});
  if (flight.g != 0) scene.add(Drag{.coefficient = flight.g});
  if (flight.a != 0) scene.add(Constant{.acceleration = {0, flight.a, 0}});
  Trial<double> free(way, scene, hz60, Start{{0, flight.y, 0}, {0, flight.v, 0}});
  scene.add(Contact(wall({0, 1, 0}, flight.wall, 1)));
  Trial<double> hit(way, scene, hz60, Start{{0, flight.y, 0}, {0, flight.v, 0}});
  free.step();
  hit.step();
  const double ratio = (hit.x(1) - free.x(1)) / (hit.v(1) - free.v(1));
  const double omega = std::sqrt(flight.W);
  const double rest = flight.W != 0   ? std::atan(omega * ratio) / omega
                      : flight.g != 0 ? std::log1p(flight.g * ratio) / flight.g
                                      : ratio;
  return std::abs(1 - rest / hz60 - exact);
}

template <class Use>
void for_each_flight(double W, double g, double a, const Use& use) {
  for (const double speed : {0.3, 1.0, 4.0, 9.0}) {
    for (const double part : {0.1, 0.35, 0.6, 0.9}) {
      for (const double y : {0.2, 1.0}) {
        use(Flight{.W = W, .g = g, .a = a, .wall = y - part * speed * hz60, .y = y, .v = -speed});
      }
    }
  }
}

Worst parabola_impacts(CaseRun& way) {
  Worst worst;
  for_each_flight(0, 0, -gravity, [&](const Flight& flight) {
    const auto exact = flight.impact();
    if (exact) worst.see(impact_error(way, flight, *exact), fmt::format("{:g} m/s, f = {:.3g}", -flight.v, *exact));
  });
  return worst;
}

Worst curved_impacts(CaseRun& way) {
  Worst worst;
  for (const double strength : {0.01, 0.03, 0.1, 0.3}) {
    const auto see = [&](const char* what) {
      return [&worst, &way, strength, what](const Flight& flight) {
        const auto exact = flight.impact();
        if (exact) worst.see(impact_error(way, flight, *exact), fmt::format("{} = {:g}, {:g} m/s", what, strength, -flight.v));
      };
    };
    if (strength <= 0.1) for_each_flight(0, strength / hz60, -gravity, see("gamma h"));
    for_each_flight(strength * strength / (hz60 * hz60), 0, 0, see("omega h"));
  }
  return worst;
}

// --- 46: bounces under forces --------------------------------------------------------------------------------------------

// In units of a step: the angle of a spring, what drag takes, the angle of a force that is a sine of time.
struct Acting {
  double z = 0, q = 0, theta = 0;
};

std::string name_of(const Acting& acting) {
  return fmt::format("z = {:g}, q = {:g}", acting.z, acting.q) +
         (acting.theta > 0 ? fmt::format(", Omega h = {:g}", acting.theta) : "");
}

constexpr double shake = 4;  // m/s^2

AxisEquation equation_of(const Acting& acting, long double from) {
  const long double omega = acting.z / hz60;
  const long double Omega = acting.theta / hz60;
  AxisEquation equation{.W = omega * omega, .g = acting.q / hz60, .polynomial = {-gravity}, .sines = {}};
  if (acting.theta > 0) equation.sines = {{.amplitude = shake, .angular_frequency = Omega, .phase = Omega * from}};
  return equation;
}

// Above the floor, to whose height a spring pulls.
Scene scene_under(const Acting& acting, const Contact& floor, Method method = Method::combined) {
  const double omega = acting.z / hz60;
  Scene scene;
  scene.method = method;
  if (acting.z != 0) scene.add(Spring{.stiffness = omega * omega});
  if (acting.q != 0) scene.add(Drag{.coefficient = acting.q / hz60});
  if (acting.theta != 0) scene.add(Sinusoid{.acceleration = {0, shake, 0}, .angular_frequency = acting.theta / hz60});
  scene.add(Constant{.acceleration = {0, -gravity, 0}});
  scene.add(floor);
  return scene;
}

// Impacts of 0.5 to 5 m/s at many times of a step, against the exact bounce: the energy over the kinetic one at the impact, or
// the velocity over that of the impact.
enum class Judged { energy, velocity };

template <class T, Judged judged>
double impact_under(CaseRun& way, const Acting& acting, const Contact& floor) {
  double worst = 0;
  for (int i = 0; i < 100; ++i) {
    const double part = std::fmod(0.5 + 0.618033988749895 * i, 1);
    const double speed = 0.5 + 4.5 * std::fmod(0.25 + 0.7548776662466927 * i, 1);
    const auto equation = equation_of(acting, part * hz60);
    const AxisState before = solve(equation, {0, -speed}, -part * hz60);
    if (!(before.x > 0)) continue;  // it comes from below
    Trial<T> trial(way, scene_under(acting, floor), hz60,
                   Start{{0, static_cast<double>(before.x), 0}, {0, static_cast<double>(before.v), 0}});
    trial.step();
    const AxisState after = solve(equation, {0, speed}, (1 - part) * hz60);
    if (!(after.x > 0)) continue;  // it comes back within the step
    if (judged == Judged::velocity) {
      worst = std::max(worst, std::abs(trial.v(1) - static_cast<double>(after.v)) / speed);
    } else {
      const auto energy = [&](long double y, long double v) { return v * v / 2 + gravity * y + equation.W * y * y / 2; };
      const auto gain = energy(trial.x(1), trial.v(1)) - energy(after.x, after.v);
      worst = std::max(worst, std::abs(static_cast<double>(gain)) / (speed * speed / 2));
    }
  }
  return worst;
}

const Contact& elastic_floor() {
  static const Contact floor = ground(1);
  return floor;
}
// So large that it is flat where the particle falls, and rounds as a sphere does.
const Contact& elastic_ball() {
  static const Contact ball = Sphere{.center = {0, -8, 0}, .radius = 8, .restitution = 1};
  return ball;
}

template <class T>
Worst bounces_under_springs(CaseRun& way) {
  Worst worst;
  for (const double z : {0.03, 0.1, 0.3, 1.0, 2.0}) {
    worst.see(impact_under<T, Judged::energy>(way, {.z = z}, elastic_floor()), name_of({.z = z}));
    worst.see(impact_under<T, Judged::energy>(way, {.z = z}, elastic_ball()), name_of({.z = z}) + ", sphere");
  }
  return worst;
}
template <class T>
Worst bounces_in_air(CaseRun& way) {
  Worst worst;
  for (const Acting& acting : {Acting{.q = 0.03}, {.q = 0.1}, {.q = 0.3}, {.q = 1}, {.z = 1, .q = 1}, {.q = 3}}) {
    worst.see(impact_under<T, Judged::energy>(way, acting, elastic_floor()), name_of(acting));
    worst.see(impact_under<T, Judged::energy>(way, acting, elastic_ball()), name_of(acting) + ", sphere");
  }
  return worst;
}
// The velocity after an impact under a force of time, over what the study of the method found for a quintic path.
template <class T>
Worst bounces_when_shaken(CaseRun& way) {
  Worst worst;
  for (const auto& [acting, bar] : {std::pair{Acting{.z = 0.1, .q = 0.1, .theta = 0.1}, 7e-9},
                                    {{.z = 0.3, .q = 0.1, .theta = 0.5}, 1e-6},
                                    {{.z = 0.3, .q = 0.3, .theta = 1}, 1e-5},
                                    {{.z = 1, .q = 0.3, .theta = 1}, 9e-5}}) {
    worst.see(impact_under<T, Judged::velocity>(way, acting, elastic_floor()) / bar, name_of(acting));
  }
  return worst;
}

// A thousand bounces on a floor under a spring of 0.1 rad a step and gravity.
template <class T>
Worst thousand_bounces(CaseRun& way) {
  Worst worst;
  for (const double z : {0.03, 0.1}) {
    Trial<T> trial(way, scene_under({.z = z}, elastic_floor()), hz60, Start{{0, 0.5, 0}, {}});
    const double W = (z / hz60) * (z / hz60);
    const auto energy = [&] { return trial.v(1) * trial.v(1) / 2 + gravity * trial.x(1) + W * trial.x(1) * trial.x(1) / 2; };
    const double start = energy();
    double before = trial.v(1);
    for (int bounces = 0; bounces < 1000;) {
      trial.step();
      bounces += before < 0 && trial.v(1) > 0 ? 1 : 0;
      before = trial.v(1);
      worst.see(std::abs(energy() / start - 1), name_of({.z = z}));
    }
  }
  return worst;
}

// A spring that bends the path back within the step: a dip of a hundredth of a millimetre to a centimetre, which a step does
// not end in. The energy after it, over before.
template <class T>
Worst dips(CaseRun& way) {
  Worst worst;
  for (const double z : {0.3, 0.8, 1.5}) {
    const double omega = z / hz60;
    for (const double depth : {1e-5, 1e-3, 1e-2}) {
      // y = 0.2 - (0.2 + depth) cos(omega (t - h/2)): lowest at the middle of the step
      const double reach = 0.2 + depth;
      const double y = 0.2 - reach * std::cos(z / 2);
      if (!(y > 0)) continue;
      Scene scene;
      scene.add(Spring{.stiffness = omega * omega, .anchor = Vec3{0, 0.2, 0}});
      scene.add(Contact(ground(1)));
      const double v = -reach * omega * std::sin(z / 2);
      Trial<T> trial(way, scene, hz60, Start{{0, y, 0}, {0, v, 0}});
      trial.step();
      const auto where = fmt::format("z = {:g}, {:g} m deep", z, depth);
      // reflected twice or more: no more than as much energy, and higher than where the dip would have ended
      const auto energy = [&](double at, double speed) { return speed * speed + omega * omega * (at - 0.2) * (at - 0.2); };
      worst.see(std::abs(energy(trial.x(1), trial.v(1)) / energy(y, v) - 1), where);
      worst.see(trial.x(1) < 0 || trial.x(1) == y ? infinite : 0, where);
    }
  }
  return worst;
}

// --- 47: pressed into a corner -------------------------------------------------------------------------------------------

// Stones blown into the corner of three planes for an hour: how far and how fast each one moves after its first minute, and how
// deep it lies inside, over 4 eps of its distance from the origin.
template <class T>
Worst pressed_into_corner(CaseRun& way) {
  Worst worst;
  const std::vector<std::vector<Vec3>> corners = {
      {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}},               // square
      {{0.2, 1, 0.1}, {-1, 0.3, 0.2}, {-0.1, 0.2, 1}},  // oblique
      {{0, 1, 0}, {-1, 0.5, 0}, {-0.4, 0.3, 1}},        // blunt
      {{0, 1, 0}, {-1, -0.4, 0}, {0.1, -0.3, 1}},       // acute
  };
  int number = 0;
  for (const auto& normals : corners) {
    ++number;
    std::vector<Plane> planes;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 n = scaled(normals[k], 1 / length(normals[k]));
      planes.push_back(wall(n, product(n, {3, 1, -2}), k == 0 ? 0.4 : 0.3));
      planes.back().friction = k == 0 ? 0.3 : 0.2;
    }
    Scene scene = falling(planes);
    scene.add(Drag{.coefficient = 0.9, .wind = {12, 0, -9}});
    std::vector<Start> starts;
    for (int i = 0; i < 16; ++i) {
      starts.push_back({{3 - 0.3 - 0.1 * (i % 4), 1.5 + 0.2 * i, -2 + 0.3 + 0.05 * i}, {0.1 * i, -3, -0.05 * i}});
    }
    Trial<T> trial(way, scene, hz60, starts);
    trial.step(3600);
    std::vector<Vec3> settled;
    for (std::size_t i = 0; i < starts.size(); ++i) settled.push_back(position(trial, i));
    trial.rest(59 * 3600);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const auto where = fmt::format("corner {}, stone {}", number, i);
      const Vec3 end = position(trial, i);
      const double moved = length({end[0] - settled[i][0], end[1] - settled[i][1], end[2] - settled[i][2]});
      worst.see(moved + length(velocity(trial, i)) > 0 ? infinite : 0, where);
      for (const Plane& plane : planes) {
        const Vec3 held{static_cast<T>(plane.normal[0]), static_cast<T>(plane.normal[1]), static_cast<T>(plane.normal[2])};
        worst.see((static_cast<T>(plane.offset) - product(held, end)) / (4 * epsilon<T> * length(end)), where);
      }
    }
  }
  return worst;
}

// Pressed onto two walls it meets the floor at 3 m/s: what is left of its bounce, against the closed form.
template <class T>
Worst bounce_in_groove(CaseRun& way) {
  Worst worst;
  for (const double e : {0.3, 0.9}) {
    Scene scene = falling({ground(e), wall({-1, 0, 0}, 0, 0.3), wall({0, 0, 1}, 0, 0.3)});
    scene.add(Constant{.acceleration = {4, 0, -3}});
    Trial<T> trial(way, scene, hz60, Start{{0, 0.02, 0}, {0, -3, 0}});
    trial.step();
    const double impact = std::sqrt(9 + 2 * gravity * 0.02);
    const double when = (impact - 3) / gravity;
    worst.see(std::abs(trial.v(1) - (e * impact - gravity * (hz60 - when))), fmt::format("e = {:g}", e));
    worst.see(std::abs(trial.x(0)) + std::abs(trial.x(2)), fmt::format("e = {:g}", e));
  }
  return worst;
}

// --- 48: the angle of friction; an oblique puck --------------------------------------------------------------------------

// Put down an hour ago on an incline a part in ten thousand less steep than friction holds.
template <class T>
Worst held_for_an_hour(CaseRun& way) {
  constexpr double friction = 0.4;
  Worst worst;
  for (const Response response : {Response::resume, Response::end_on_surface}) {
    for (const double turn : {0.0, 0.7}) {
      const double angle = std::atan(0.9999 * friction);
      const Vec3 n{std::sin(angle) * std::cos(turn), std::cos(angle), std::sin(angle) * std::sin(turn)};
      Plane incline = wall(n, 2.1, 0.3);
      incline.friction = friction;
      incline.response = response;
      Trial<T> trial(way, falling({incline}), hz60, Start{scaled(n, 2.1), {}});
      trial.step(100);
      const Vec3 settled = position(trial);
      trial.rest(216000);
      const Vec3 end = position(trial);
      const auto where = fmt::format("{}, turned by {:g}", response == Response::resume ? "resume" : "seed", turn);
      worst.see(length({end[0] - settled[0], end[1] - settled[1], end[2] - settled[2]}) + length(velocity(trial)), where);
    }
  }
  return worst;
}

template <class T>
Worst slides_just_above(CaseRun& way) {
  return slides_down<T>(way, 0.4, 0.3, {1.01, 1.1});
}

// A frictionless puck thrown obliquely at the floor keeps its way along it, bounces and rest included: in eps of that way.
template <class T>
Worst oblique_puck(CaseRun& way) {
  Worst worst;
  for (const Response response : {Response::resume, Response::end_on_surface}) {
    for (const double e : {0.0, 0.4, 1.0}) {
      Plane floor = ground(e);
      floor.response = response;
      Trial<T> trial(way, falling({floor}), hz60, Start{{0, 0.3, 0}, {2, -1, 0.5}});
      trial.step(240);
      const auto where = fmt::format("{}, e = {:g}", response == Response::resume ? "resume" : "seed", e);
      worst.see(std::abs(trial.v(0) - 2) + std::abs(trial.v(2) - 0.5), where);
      worst.see(std::abs(trial.x(0) / 8 - 1) / (240 * epsilon<T>) > 1 ? infinite : 0, where);
    }
  }
  return worst;
}

// A million steps of many scenes that must leave nothing at all.
Bar on_best(std::string_view precision, Check check, std::string_view expected) {
  return {.precision = precision,
          .check = check,
          .limit = 0,
          .unit = "m, m/s",
          .expected = expected,
          .known_miss = {},
          .runs_on = RunsOn::best_isa};
}

}  // namespace

std::vector<Case> contact_cases() {
  return {
      {20,
       "rest on a plane",
       "1e6 steps of gravity into the plane; oblique, 7.3 m from the origin: rounding pushes in and along",
       {on_best(float64, rest_on_axis<double>, "axis-aligned: y = offset and v = 0 exactly"),
        on_best(float32, rest_on_axis<float>, "axis-aligned: y = offset and v = 0 exactly"),
        {float64, rest_on_oblique<double>, 1, "bars", "oblique: within 4 eps |x|, 1e-6 m/s, no creep"},
        {float32, rest_on_oblique<float>, 1, "bars", "oblique: within 4 eps |x|, 1e-6 m/s, no creep"},
        on_best(float64, rest_on_incline<double>, "an incline that friction holds: no creep, v = 0 exactly"),
        on_best(float32, rest_on_incline<float>, "an incline that friction holds: no creep, v = 0 exactly"),
        {float64, sliding<double>, 1e-10, "of g sin t^2/2", "a steeper one: slides with sin - mu cos"},
        {float32, sliding<float>, 1e-4, "of g sin t^2/2", "a steeper one: slides with sin - mu cos"}}},
      {21,
       "settling",
       "a ball of restitution 0.5 bounces infinitely often in 1.354571 s",
       {{float64, rest_time<double>, 1, "half steps", "rest within the step of t_rest"},
        {float32, rest_time<float>, 1, "half steps", "rest within the step of t_rest"},
        {float64, rest_energy<double>, 0, "m, m/s", "y = 0 and v = 0 exactly"},
        {float32, rest_energy<float>, 0, "m, m/s", "y = 0 and v = 0 exactly"},
        {float64, bounce_times<double, ContactPath::curve>, 1e-12, "s", "times of all bounces a step apart, curve"},
        {float64, bounce_times<double, ContactPath::line, 3>, 1e-3, "s", "times of 3 bounces, line (0.34 mm off)"},
        {.precision = float64,
         .check = bounce_times<double, ContactPath::line>,
         .limit = 1e-3,
         .unit = "s",
         .expected = "times of all bounces a step apart, line",
         .known_miss = KnownMiss{3.3e-3, "the parabola is g h^2/8 off the line, which slow impacts take long to cover"}}}},
      {22, "elastic bounces", "1 m, 1000 s at 60 Hz: each bounce falls anywhere in a step",
       both<elastic_energy<double>, elastic_energy<float>>(1e-10, 1e-3, "E0", "energy constant")},
      {23, "grazing", "v_n = 0 at the surface and 1e-7 m above it, with friction",
       both<grazing<double>, grazing<float>>(0, 0, "m/s", "no impact: v as it was")},
      {24, "start inside", "0.1 m deep with v_n = -5, 0 and 5 m/s, e = 0.5",
       both<start_inside<double>, start_inside<float>>(0, 0, "m, m/s", "at the plane, v_n = 2.5, 0 and 5")},
      {25, "start on the plane", "v_n = 3 leaves, v_n = -3 bounces at once",
       both<start_on_plane<double>, start_on_plane<float>>(4, 4, "eps", "y = 0.05 and 0.025 m")},
      {26, "corners", "2 and 3 planes hit at the same moment",
       both<corners<double>, corners<float>>(4, 4, "eps |v| h, eps |v|", "reflected in all, speed kept")},
      {27,
       "wedge of 20 degrees",
       "elastic, 16 particles, 5000 steps: several impacts in a step",
       {{float64, wedge<double, &Wedge::deepest>, 4, "eps m", "inside"},
        {float32, wedge<float, &Wedge::deepest>, 4, "eps m", "inside"},
        {float64, wedge<double, &Wedge::change>, 1e-14, "E a step", "energy kept"},
        {float32, wedge<float, &Wedge::change>, 2e-6, "E a step", "energy kept"}}},
      {28,
       "channel",
       "2 to 4000 bounces between two walls in one step, 32 of which are resolved",
       {{float64, folded_path<double>, 1e-6, "m", "to 30: the folded path"},
        {float32, folded_path<float>, 1e-6, "m", "to 30: the folded path"},
        {float64, contained<double>, 1e-6, "m", "beyond: contained, no faster"},
        {float32, contained<float>, 1e-6, "m", "beyond: contained, no faster"}}},
      {29, "tunnelling", "1e3 to 1e7 m/s at a plane 10 m away",
       both<tunnelling<double>, tunnelling<float>>(4, 4, "eps y", "reflected")},
      {30,
       "restitution, viscosity, friction",
       "e = 0, 0.5, 1; tau = 1, 0.25, 0; mu = 0 to infinite",
       {{float64, impact_laws<double>, 4, "eps |v|", "the laws of impact"},
        {float32, impact_laws<float>, 4, "eps |v|", "the laws of impact"},
        {float64, impact_zeros<double>, 0, "m/s", "tau = 0: v_t = 0 exactly; e = 0: v_n = 0"},
        {float32, impact_zeros<float>, 0, "m/s", "tau = 0: v_t = 0 exactly; e = 0: v_n = 0"}}},
      {39,
       "time of impact",
       "in a step of drag (to q = 0.1) and of a spring (to z = 0.3)",
       {{float64, parabola_impacts, 1e-12, "of the step", "free fall"},
        {float64, curved_impacts, 1e-10, "of the step", "drag and springs"}}},
      {42, "infinite friction in a corner", "gravity into and along both planes, e = 0",
       both<sticks_in_corner<double>, sticks_in_corner<float>>(0, 0, "m, m/s", "v = 0 exactly within 2 steps, and stays")},
      {46,
       "bounces under forces",
       "restitution 1, springs of z = 0.03 to 2 and drag of q = 0.03 to 3 a step, planes and a sphere",
       {{float64, bounces_under_springs<double>, 1e-12, "E", "springs: the exact bounce's energy"},
        {float32, bounces_under_springs<float>, 1e-5, "E", "springs: the exact bounce's energy"},
        {float64, bounces_in_air<double>, 1e-12, "E", "drag: the exact bounce's energy"},
        {.precision = float32,
         .check = bounces_in_air<float>,
         .limit = 1e-5,
         .unit = "E",
         .expected = "drag: the exact bounce's energy",
         .known_miss =
             KnownMiss{1e-4, "at q = 3 float32 makes e^-3 of the velocity as 1 - q P1; float64 meets its own bar there"}},
        {float64, bounces_when_shaken<double>, 1, "bars", "a force of time: as good as a quintic path"},
        {float64, thousand_bounces<double>, 1e-9, "E0", "1000 bounces under a spring: energy constant"},
        {float32, thousand_bounces<float>, 1e-2, "E0", "1000 bounces under a spring: energy constant"},
        {float64, dips<double>, 1e-10, "E0", "a dip that ends outside is found"}}},
      {47,
       "pressed into a corner",
       "wind and gravity press 16 stones into four corners of three planes, friction 0.3 and 0.2, restitution 0.4 and 0.3",
       {{float64, pressed_into_corner<double>, 1, "bars", "an hour: at rest exactly, inside"},
        {float32, pressed_into_corner<float>, 1, "bars", "an hour: at rest exactly, inside"},
        {float64, bounce_in_groove<double>, 1e-12, "m, m/s", "pressed onto two walls: keeps its bounce on the third"},
        {float32, bounce_in_groove<float>, 1e-5, "m, m/s", "pressed onto two walls: keeps its bounce on the third"}}},
      {48,
       "angle of friction, oblique puck",
       "an incline just below and just above it; a frictionless puck that bounces and rests, by both responses",
       {{float64, held_for_an_hour<double>, 0, "m, m/s", "just below: held for an hour to the last bit"},
        {float32, held_for_an_hour<float>, 0, "m, m/s", "just below: held for an hour to the last bit"},
        {float64, slides_just_above<double>, 1e-10, "of g sin t^2/2", "just above: slides with sin - mu cos"},
        {float32, slides_just_above<float>, 1e-4, "of g sin t^2/2", "just above: slides with sin - mu cos"},
        {float64, oblique_puck<double>, 0, "m/s", "tangential velocity kept to the last bit"},
        {float32, oblique_puck<float>, 0, "m/s", "tangential velocity kept to the last bit"}}},
  };
}

}  // namespace dvdx::tool::stability
