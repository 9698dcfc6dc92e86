// One particle and surfaces: rest, corners, friction.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "hard_cases/cases.hpp"
#include "hard_cases/trial.hpp"
#include "hard_cases/walls.hpp"

namespace dvdx::tool::stability {
namespace {

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

// A particle at rest on an oblique plane, over 1e6 steps after settling. Each figure is relative to its own bar: the distance
// from the plane (4 eps of the distance from the origin), the normal speed (1e-6 m/s), and creep (none allowed).
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

// Inclines that friction of 0.5 holds, the steepest by a margin of one in a thousand. Measures how far and how fast each
// particle is after 1e6 steps from where it was put down at rest.
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

// A steeper incline: the particle slides by the closed form, g (sin - mu cos) t^2/2 in 10 s, relative to the distance without
// friction.
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

// The error of position relative to |v| h and that of the speed relative to itself, in eps.
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
  double change = 0;   // kinetic energy gained or lost in one step
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
        // the plane in the particle's precision
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

// One step between two walls 1/16 m apart, in which a particle crosses the gap `bounces` times.
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

// More impacts than a step resolves.
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

// --- 47: pressed into a corner -------------------------------------------------------------------------------------------

// Stones blown into the corner of three planes for an hour. Measures how far and how fast each one moves after its first
// minute, and how deep it lies inside, relative to 4 eps of its distance from the origin.
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

// A particle pressed onto two walls meets the floor at 3 m/s. Its bounce is compared with the closed form.
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

// An hour on an incline that is less steep by one in ten thousand than the limit of friction.
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

// A frictionless puck thrown obliquely at the floor keeps its tangential motion, bounces and rest included: in eps of the way.
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

// A million steps of many scenes that must leave exactly nothing.
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
