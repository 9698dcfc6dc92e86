// The cases whose hashes golden_test.cpp stores, one a line.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/golden_hash.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace golden_test {

using namespace dvdx;

// The number of steps for cases with many sub-steps or iterations, each of which runs the same code.
inline constexpr std::size_t few = 2;

inline const std::array<std::pair<Method, const char*>, 5> methods = {{{Method::combined, "combined"},
                                                                       {Method::exact, "exact"},
                                                                       {Method::average_acceleration, "average acceleration"},
                                                                       {Method::pulse, "pulse"},
                                                                       {Method::symplectic_euler, "symplectic Euler"}}};

template <class Shape>
Shape touched(Shape shape, Response response, ContactPath sweep) {
  shape.restitution = 0.6;
  shape.friction = 0.3;
  shape.viscosity = 0.15;
  shape.normal_viscosity = 0.05;
  shape.response = response;
  shape.sweep = sweep;
  return shape;
}

// Every shape, response and sweep separately, and two walls that a particle meets in one step.
inline Cases contact_cases() {
  Cases cases;
  const std::pair<Contact, const char*> shapes[] = {
      {Plane{.normal = {0.3, 2, -0.1}, .offset = -0.5}, "plane"},
      {Sphere{.center = {0.2, -0.4, 0}, .radius = 0.45}, "sphere"},
      {Sphere{.center = {0, 0.1, 0}, .radius = 1.7, .side = Side::inside}, "inside a sphere"},
      {Capsule{.ends = {{{-0.4, -0.4, 0.1}, {0.5, -0.5, 0}}}, .radius = {0.2, 0.3}}, "capsule"},
      {OrientedBox{.center = {0.1, -0.5, 0}, .half_extents = {0.6, 0.2, 0.5}, .rotation = {0.2, 0.3, -0.1}, .thickness = 0.05},
       "box"},
      {OrientedBox{.half_extents = {1.1, 1.2, 1.3}, .rotation = {0.2, 0.3, -0.1}, .side = Side::inside}, "inside a box"},
      {Convex{.planes = {{{0, 1, 0}, -0.3},
                         {{0, -3, 0}, 0.6},
                         {{1, 0.5, 0}, 0.5},
                         {{-1, 0.5, 0}, 0.4},
                         {{0, 0.5, 1}, 0.4},
                         {{0, 0, -1}, 0.5}}},
       "convex body"},
      {TriangleMesh{
           .vertices = {{0.7, -0.4, 0}, {-0.5, -0.4, 0.1}, {0.1, 0.1, 0}, {0.1, -0.8, 0}, {0.1, -0.4, 0.6}, {0.1, -0.4, -0.5}},
           .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
           .cell = 0.07},
       "mesh"}};
  const std::pair<Response, const char*> responses[] = {{Response::resume, "resume"}, {Response::end_on_surface, "seed"}};
  const std::pair<ContactPath, const char*> sweeps[] = {{ContactPath::curve, "curve"}, {ContactPath::line, "line"}};
  for (const auto& [shape, shape_name] : shapes) {
    for (const auto& [response, response_name] : responses) {
      for (const auto& [sweep, sweep_name] : sweeps) {
        test::NamedScene named{.name = std::string("contact: ") + shape_name + ", " + response_name + ", " + sweep_name,
                               .scene = {}};
        named.scene.add(Constant{.acceleration = {0.5, -9.81, 0}});
        const auto touch = [response = response, sweep = sweep](auto s) { return Contact(touched(s, response, sweep)); };
        named.scene.add(std::visit(touch, shape));
        cases.push_back(case_of(named));
      }
    }
  }
  test::NamedScene corner{.name = "contact: a corner of two planes and a sphere", .scene = {}};
  corner.scene.add(Constant{.acceleration = {4, -9.81, 0}});
  corner.scene.add(Spring{.stiffness = 30.0, .damping = 0.1});
  corner.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.3, .restitution = 0.9});
  corner.scene.add(Plane{.normal = {-1, 0.2, 0}, .offset = -0.4, .restitution = 0.8, .friction = 0.2});
  corner.scene.add(touched(Sphere{.center = {0, -0.3, 0}, .radius = 0.2}, Response::resume, ContactPath::curve));
  cases.push_back(case_of(corner));
  test::NamedScene pushing{.name = "contact: a ball and a box that push out", .scene = {}};
  pushing.scene.add(Constant{.acceleration = {0.5, -9.81, 0}});
  pushing.scene.add(Sphere{.center = {0.2, -0.4, 0}, .radius = 0.9, .friction = 0.3, .push_out = 0.7});
  pushing.scene.add(
      OrientedBox{.center = {-0.3, 0.3, 0}, .half_extents = {0.5, 0.4, 0.6}, .rotation = {0.2, 0.3, -0.1}, .push_out = 2});
  cases.push_back(case_of(pushing));
  return cases;
}

inline std::vector<double> numbers(double low, double high, std::uint64_t stream) {
  std::vector<double> list(count);
  for (std::size_t i = 0; i < count; ++i) list[i] = low + (high - low) * test::uniform(stream, i);
  return list;
}

// Every method, with a shared and an individual stiffness, rest length and anchor.
inline Cases radial_cases() {
  Cases cases;
  for (const auto& [method, name] : methods) {
    test::NamedScene named{.name = std::string("radial springs: ") + name, .scene = {}};
    named.scene.method = method;
    named.scene.mass = numbers(0.5, 2, 40);
    named.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    named.scene.add(RadialSpring{.stiffness = 14.0, .damping = 0.2, .anchor = Vec3{0, 0.5, 0}, .rest_length = 0.4});
    named.scene.add(RadialSpring{.stiffness = numbers(4, 40, 41), .anchor = at_start, .rest_length = numbers(0, 0.5, 42)});
    cases.push_back(case_of(named));
  }
  return cases;
}

// A pair's contribution by every method, along both axes, of damped springs.
inline Cases accumulate_cases() {
  Cases cases;
  const std::pair<PairAxis, const char*> axes[] = {{PairAxis::midpoint, "midpoint"}, {PairAxis::start, "start"}};
  for (const auto& [method, name] : methods) {
    for (const auto& [axis, axis_name] : axes) {
      if (method == Method::combined && axis == PairAxis::start) continue;  // its pulse always acts at the middle
      test::Joined sheet = test::sheet(7, 18, 50, 0.001);
      sheet.scene.coupling = {.scheme = Scheme::accumulate, .substeps = 20, .method = method, .axis = axis};
      sheet.name = std::string("accumulate: ") + name + ", " + axis_name;
      cases.push_back(case_of(sheet));
    }
  }
  return cases;
}

// Springs summed by each particle, with and without damping: a grid that bends, the list of its springs, and the list with a
// rope beside it, where only one of the two networks is damped. The sub-steps are given, as in golden_of_networks().
inline Cases pulse_cases() {
  Cases cases;
  for (const auto& [coupling, scheme] : {std::pair{Coupling{.scheme = Scheme::leapfrog, .substeps = 10}, "leapfrog"},
                                         std::pair{Coupling{.scheme = Scheme::fourth_order, .substeps = 6}, "fourth order"}}) {
    const auto add = [&, coupling = coupling, scheme = scheme](test::Joined joined, const std::string& name) {
      joined.scene.coupling = coupling;
      joined.name = std::string("springs: ") + scheme + ", " + name;
      cases.push_back(case_of(joined, few));
    };
    for (const double damping : {0.0, 0.001}) {
      const std::string how = damping == 0 ? "" : ", damped";
      test::Joined sheet = test::sheet(9, 20, 50, damping);
      std::get<Grid>(sheet.scene.networks[0]).bend = 5;
      std::vector<double> masses;
      for (std::size_t i = 0; i < sheet.x.size(); ++i) masses.push_back(0.001 * (1.5 + test::scatter(i, 6)));
      sheet.scene.mass = Scalars(masses);
      add(sheet, "a grid" + how);
      add(test::as_list(sheet), "a list" + how);
      sheet.scene.add(Network(Springs{.pairs = {{0, 45}, {45, 101}, {101, 179}}, .stiffness = 20.0, .damping = 0.001}));
      add(sheet, (damping == 0 ? "a grid, and a rope that is damped" : "a grid and a rope, both damped"));
    }
  }
  return cases;
}

// A grid and a list in gusts, with a torn side and one held particle, by every way in which air acts.
inline Cases air_cases() {
  Cases cases;
  for (const auto& [coupling, scheme] :
       {std::pair{Coupling{.scheme = Scheme::leapfrog, .substeps = 10}, "leapfrog"},
        std::pair{Coupling{.scheme = Scheme::fourth_order, .substeps = 6}, "fourth order"},
        std::pair{Coupling{.scheme = Scheme::sequential, .substeps = 4, .theta = 0.55}, "sequential"},
        std::pair{Coupling{.scheme = Scheme::sequential, .substeps = 4}, "generalized alpha"},
        std::pair{Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::exact}, "accumulate"}}) {
    for (const double damping : {0.0, 0.001}) {
      test::Joined sheet = test::sheet(9, 20, 50, damping);
      sheet.scene.coupling = coupling;
      Grid& grid = std::get<Grid>(sheet.scene.networks[0]);
      grid.aerodynamics = Aerodynamics{.density = 1.5, .drag = 0.9, .lift = 0.6};
      grid.broken = {{45, 46}};
      sheet.scene.wind = {.mean = {4, 1, -2}, .gusts = {{{0, 1, 2}, 6, 0.4}}};
      const std::string how = damping == 0 ? "" : ", damped";
      const std::string name = std::string("air: ") + scheme;
      sheet.name = name + ", a grid" + how;
      cases.push_back(case_of(sheet, few));
      test::Joined list = test::as_list(sheet);
      list.name = name + ", a list" + how;
      cases.push_back(case_of(list, few));
    }
  }
  return cases;
}

// A sheet on a skin that moves and turns, outside the balls behind it, tethered; and a list of its springs.
inline Cases skin_cases() {
  Cases cases;
  for (const auto& [coupling, scheme] :
       {std::pair{Coupling{.scheme = Scheme::leapfrog, .substeps = 6}, "leapfrog"},
        std::pair{Coupling{.scheme = Scheme::fourth_order, .substeps = 6}, "fourth order"},
        std::pair{Coupling{.scheme = Scheme::sequential, .substeps = 4}, "generalized alpha"},
        std::pair{Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::exact}, "accumulate"}}) {
    test::Joined sheet = test::sheet(9, 20, 50, 0.001);
    sheet.scene.coupling = coupling;
    Skin skin{.particles = {}, .at_most = 0.0, .motion = 0};
    std::vector<double> at_most, offset;
    for (std::size_t i = 0; i < sheet.x.size(); i += 1 + i % 3) {
      skin.particles.push_back(i);
      at_most.push_back(0.02 * (1 + test::scatter(i, 7)));
      offset.push_back(0.01 * (1 + test::scatter(i, 8)));
    }
    skin.at_most = at_most;
    skin.backstop = Backstop{.normals = {{0.2, 2, 0.4}}, .offset = offset, .radius = 0.1};
    sheet.scene.add(std::move(skin));
    sheet.scene.add(Tethers{.network = 0, .stretch = 1.0});
    sheet.scene.add(Motion{.center = {0.5, 0, 0.5},
                           .keys = {{.time = 0}, {.time = 0.1, .translation = {0.1, 0.05, 0}, .rotation = {0, 0.3, 0.2}}}});
    sheet.name = std::string("skin and tethers: ") + scheme + ", a grid";
    cases.push_back(case_of(sheet));
    test::Joined list = test::as_list(sheet);
    list.name = std::string("skin and tethers: ") + scheme + ", a list";
    cases.push_back(case_of(list));
  }
  return cases;
}

// Grains of two sizes that fall into a corner, and a sheet that folds.
inline Cases meet_cases() {
  test::Joined grains;
  grains.name = "meet: grains";
  std::vector<double> radius;
  for (std::size_t i = 0; i < 40; ++i) {
    const auto place = [&](std::size_t k, std::size_t axis) {
      return 0.02 * (static_cast<double>(k) + 1 + 0.1 * test::scatter(i, axis));
    };
    grains.x.push_back({place(i % 4, 0), place(i / 16, 1), place(i / 4 % 4, 2)});
    grains.v.push_back({0.5 * test::scatter(i, 3), -1, 0.5 * test::scatter(i, 4)});
    radius.push_back(i % 3 == 0 ? 0.012 : 0.009);
  }
  grains.scene.add(Constant{.acceleration = {-2, -9.75, 0}});
  grains.scene.add(Plane{.normal = {0, 1, 0}, .friction = 0.5});
  grains.scene.add(Plane{.normal = {1, 0, 0}, .restitution = 0.5});
  grains.scene.fixed = {7};
  grains.scene.add(Meet{.radius = radius, .restitution = 0.5, .friction = 0.25, .rounds = 4});
  test::Joined sheet = test::sheet(9, 12, 50, 0.001);
  sheet.name = "meet: a sheet";
  sheet.scene.coupling.scheme = Scheme::sequential;
  sheet.scene.add(Meet{.thickness = 0.02, .friction = 0.5, .rounds = 4, .most_neighbours = 64});
  for (std::size_t i = 0; i < sheet.v.size(); ++i) sheet.v[i][0] = sheet.x[i][0] > 0.25 ? -4 : 4;
  return {case_of(grains), case_of(sheet)};
}

// A sheet that falls on a sphere while a plane stops it from sinking.
inline Cases sheet_contact_cases() {
  Cases cases;
  const auto add = [&](Scheme scheme, double theta, const char* name) {
    test::Joined sheet = test::sheet(7, 18, 50, 0.001);
    sheet.scene.coupling = {.scheme = scheme, .substeps = 8, .theta = theta};
    sheet.scene.add(touched(Sphere{.center = {0.5, -0.15, 0.5}, .radius = 0.14}, Response::resume, ContactPath::curve));
    sheet.scene.add(touched(Plane{.normal = {0, 1, 0}, .offset = -0.02}, Response::end_on_surface, ContactPath::line));
    sheet.name = std::string("a sheet in contact: ") + name;
    cases.push_back(case_of(sheet));
  };
  add(Scheme::leapfrog, 0.55, "leapfrog");
  add(Scheme::fourth_order, 0.55, "fourth order");
  add(Scheme::sequential, 0.55, "sequential");
  add(Scheme::sequential, 1, "sequential, theta 1");
  return cases;
}

// A moving chain of particles two centimetres apart, the first one fixed.
inline test::Joined chain(std::string name) {
  test::Joined joined;
  joined.name = "constraints: " + std::move(name);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({0.02 * static_cast<double>(i), 0.004 * test::scatter(i, 1), 0.004 * test::scatter(i, 2)});
    joined.v.push_back({0.3 * test::scatter(i, 3), 0.3 * test::scatter(i, 4), 0.3 * test::scatter(i, 5)});
  }
  joined.scene.mass = numbers(0.5, 2, 50);
  joined.scene.fixed = {0};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

// A sheet swung by one row, above a moving sphere and a tilting plane; and the same with free particles.
inline Cases motion_cases() {
  const auto add_world = [](Scene& scene) {
    scene.add(
        Motion{.center = {0.5, 0, 0}, .keys = {{}, {.time = 0.3, .translation = {0.1, 0, 0.2}, .rotation = {0, 0.5, 0.2}}}});
    scene.add(Motion{.keys = {{.time = 0.05}, {.time = 0.35, .translation = {0.5, 0.1, 0}}}});
    Sphere sphere = touched(Sphere{.center = {0.2, -0.15, 0.5}, .radius = 0.14}, Response::resume, ContactPath::curve);
    sphere.motion = 1;
    scene.add(sphere);
    Plane plane = touched(Plane{.normal = {0, 1, 0}, .offset = -0.05}, Response::resume, ContactPath::curve);
    plane.motion = 0;
    scene.add(plane);
  };
  Cases cases;
  const Coupling couplings[] = {{.scheme = Scheme::leapfrog, .substeps = 6},
                                {.scheme = Scheme::fourth_order, .substeps = 6},
                                {.scheme = Scheme::sequential, .substeps = 3, .theta = 0.55},
                                {.scheme = Scheme::sequential, .substeps = 3}};
  const char* names[] = {"leapfrog", "fourth order", "sequential", "generalized alpha"};
  for (std::size_t k = 0; k < std::size(couplings); ++k) {
    test::Joined sheet = test::sheet(7, 18, 50, 0.001);
    sheet.scene.coupling = couplings[k];
    sheet.scene.fixed.clear();
    add_world(sheet.scene);
    sheet.scene.add(Kinematic{.particles = {0, 1, 2, 3, 16, 17}, .motion = 0});
    sheet.name = std::string("motions: ") + names[k];
    cases.push_back(case_of(sheet));
  }
  test::Joined loose = chain("rods");
  loose.scene.fixed.clear();
  loose.scene.add(Drag{.coefficient = 0.2});
  add_world(loose.scene);
  loose.name = "motions: particles that nothing joins";
  cases.push_back(case_of(loose));
  return cases;
}

inline std::vector<Pair> neighbours() {
  std::vector<Pair> pairs;
  for (std::uint32_t i = 0; i + 1 < count; ++i) pairs.push_back({i, i + 1});
  return pairs;
}

inline Cases constraint_cases() {
  Cases cases;
  const std::pair<Bound, const char*> bounds[] = {
      {Bound::equal, "rods"}, {Bound::at_most, "ropes"}, {Bound::at_least, "at least"}};
  for (const auto& [bound, name] : bounds) {
    test::Joined joined = chain(name);
    joined.scene.add(Distance{.pairs = neighbours(), .length = 0.02, .bound = bound});
    cases.push_back(case_of(joined));
  }
  test::Joined held = chain("points and lines");
  held.scene.add(OnPoint{.particle = 9, .at = {0.2, 0.05, 0}});
  held.scene.add(OnLine{.particle = 30, .through = {0.6, 0, 0.01}, .direction = {1, 2, -0.5}});
  held.scene.add(Distance{.pairs = neighbours()});
  cases.push_back(case_of(held, few));

  test::Joined wall = chain("rods that fall on a plane, in the wind");
  wall.scene.add(Drag{.coefficient = 0.3, .wind = {3, 0, 1}});
  wall.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.05, .restitution = 0.3, .friction = 0.4});
  wall.scene.add(Distance{.pairs = neighbours(), .length = 0.02});
  cases.push_back(case_of(wall));

  for (const auto& [scheme, name] : {std::pair{Scheme::leapfrog, "leapfrog"}, std::pair{Scheme::sequential, "sequential"}}) {
    test::Joined sheet = test::sheet(6, 11, 50, 0.001);
    sheet.scene.coupling = {.scheme = scheme, .substeps = 8, .theta = 0.55};
    sheet.scene.add(Distance{.pairs = {{1, 2}, {2, 3}, {12, 23}, {40, 41}}, .bound = Bound::at_most});
    sheet.name = std::string("constraints: in a sheet, ") + name;
    cases.push_back(case_of(sheet));
  }
  return cases;
}

// Sequential without theta, in all forms of its sweeps: with and without damping, coarse and fine sub-steps, contacts and
// constraints.
inline Cases generalized_alpha_cases() {
  Cases cases;
  const auto add = [&](test::Joined sheet, int substeps, const std::string& what) {
    sheet.scene.coupling = {.scheme = Scheme::sequential, .substeps = substeps};
    test::Joined list = test::as_list(sheet);
    test::Joined across = test::with_spring_across(list);
    sheet.name = "generalized alpha: grid, " + what;
    list.name = "generalized alpha: list, " + what;
    across.name = "generalized alpha: list with a spring across, " + what;
    test::Joined in_lines = across;
    in_lines.scene.coupling.lines = Lines::whole;
    in_lines.name = across.name + ", in lines";
    for (const test::Joined& joined : {sheet, list, across, in_lines}) {
      cases.push_back(substeps == 12 ? case_of(joined, few) : case_of(joined));
    }
  };
  add(test::sheet(9, 20, 50), 1, "coarse");
  add(test::sheet(9, 20, 50), 12, "fine");
  add(test::sheet(9, 20, 50, 0.001), 3, "damped");
  test::Joined touching = test::sheet(7, 18, 50, 0.001);
  touching.scene.add(touched(Sphere{.center = {0.5, -0.15, 0.5}, .radius = 0.14}, Response::resume, ContactPath::curve));
  add(touching, 3, "in contact");
  test::Joined held = test::sheet(6, 11, 50);
  held.scene.add(Distance{.pairs = {{1, 2}, {2, 3}, {12, 23}, {40, 41}}, .bound = Bound::at_most});
  add(held, 2, "constrained");
  return cases;
}

// ---- compensated states ------------------------------------------------------------------------------------------------

template <class Place>
std::uint64_t compensated_hash(const Scene& scene, double step, std::size_t particles, std::size_t steps, Isa isa,
                               const Place& place) {
  test::Batch<float> values(test::Layout::soa, particles);
  test::Batch<float> rests(test::Layout::soa, particles);
  for (const auto* columns : {&rests.view().x, &rests.view().v}) {
    for (const Column<float>& column : *columns) {
      for (std::size_t i = 0; i < particles; ++i) column[i] = 0;
    }
  }
  place(values.view());
  State<float> state = compensated(values.view(), rests.view());
  const auto plan = compile<float>(scene, {.step = step, .isa = isa, .rounding = Rounding::compensated}, state);
  REQUIRE(plan.has_value());
  for (std::size_t n = 0; n < steps; ++n) REQUIRE(plan->step(state) == StepResult::done);  // each call splits and joins
  return hash(hash(hash_start, test::values_of(values.view())), test::values_of(rests.view()));
}

// Every flow without extras, with contacts, with radial springs and with both.
inline Cases compensated_cases() {
  Cases cases;
  for (const auto& [features, name] :
       {std::pair{StepFeatures::none, "every flow"}, std::pair{StepFeatures::contact, "contacts"},
        std::pair{StepFeatures::radial, "radial springs"}, std::pair{StepFeatures::radial_contact, "both"}}) {
    const auto run = [features = features](Isa isa, Arithmetic) {
      const auto place = [](State<float>& state) { test::place(state); };
      std::uint64_t sum = hash_start;
      for (const test::NamedScene& scene : test::affine_scenes(count)) {
        sum = hash(sum, std::vector{compensated_hash(test::with(scene, features).scene, scene.step, count, 10, isa, place)});
      }
      return sum;
    };
    cases.push_back({std::string("compensated: ") + name, run, false});
  }
  for (test::Joined joined : {test::sheet(5, 12, 50, 0.001), chain("rods")}) {
    if (joined.scene.networks.empty()) joined.scene.add(Distance{.pairs = neighbours(), .length = 0.02});
    joined.scene.coupling.substeps = 8;
    const auto run = [joined](Isa isa, Arithmetic) {
      const auto place = [&joined](State<float>& state) { test::place(joined, state); };
      return compensated_hash(joined.scene, joined.step, joined.x.size(), 5, isa, place);
    };
    cases.push_back({"compensated: " + joined.name, run, false});
  }
  return cases;
}

// ---- particles that come and go ----------------------------------------------------------------------------------------

template <class T>
Column<T> column_of(std::vector<T>& values) {
  return {.base = values.data(), .stride = sizeof(T), .capacity = values.size()};
}

// The hash of the live particles at the end, with ages, lifetimes and a carried column, and of the numbers of births, removals
// and dropped particles.
template <class T>
std::uint64_t live_hash(std::uint64_t sum, const Lifecycle& turnover, Isa isa) {
  constexpr double step = 1.0 / 64;
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Drag{.coefficient = 0.002, .wind = {1, 0, 0}});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4, .friction = 0.1});
  const auto plan = compile<T>(scene, turnover, {.step = step, .isa = isa});
  REQUIRE(plan.has_value());

  test::Batch<T> batch(test::Layout::soa, turnover.capacity);
  std::vector<T> age(turnover.capacity), lifetime(turnover.capacity);
  std::vector<std::uint32_t> ids(turnover.capacity);
  const Carried carried{ids.data(), sizeof(std::uint32_t), sizeof(std::uint32_t)};
  LiveState<T> live{.state = batch.view(), .age = column_of(age), .lifetime = column_of(lifetime), .carried = {&carried, 1}};
  live.state.count = 40;
  test::place(live.state);
  for (std::size_t i = 0; i < live.state.count; ++i) {
    lifetime[i] = i % 3 == 0 ? std::numeric_limits<T>::infinity() : static_cast<T>(0.05 + test::uniform(9, i));
    ids[i] = static_cast<std::uint32_t>(i + 1);
  }
  const bool goes = turnover.removal.not_finite == NotFinite::removed;  // otherwise a NaN, whose sign is the machine's
  if (goes) live.state.x[1][7] = std::numeric_limits<T>::infinity();
  REQUIRE(plan->step(live, 60) == StepResult::done);

  const std::size_t alive = live.state.count;
  REQUIRE(alive > 0);
  age.resize(alive);
  lifetime.resize(alive);
  ids.resize(alive);
  sum = hash(hash(hash(sum, test::values_of(live.state)), age), lifetime);
  return hash(hash(sum, ids), std::vector<std::uint64_t>{alive, live.born, live.removed, live.dropped});
}

inline Cases live_cases() {
  const Emitter jet{.rate = 400, .velocity = {0, 3, 0}, .spread = 0.5, .least_lifetime = 0.1, .most_lifetime = 0.4, .seed = 1};
  Emitter disc = jet;
  disc.shape = Disc{.center = {0, 0.1, 0}, .normal = {0.2, 1, 0.4}, .radius = 0.05};
  Emitter box = jet;
  box.shape = Box{.min = {-1, 0, -1}, .max = {-0.5, 1, -1}};
  box.spread = Vec3{0.1, 0.5, 0};
  box.start = 0.08;
  box.end = 0.6;
  box.seed = 0x1234567890;
  Emitter mortal = jet;
  mortal.rate = 3000;
  const Removal all{.boundaries = {{.normal = {1, 0, 0}, .offset = -0.7}, {.normal = {-2, 1, 0}, .offset = -2}},
                    .outside = Box{.min = {-9, -9, -9}, .max = {9, 1.2, 9}},
                    .not_finite = NotFinite::removed};
  Removal without_order = all;
  without_order.order = SurvivorOrder::any;
  const std::pair<const char*, Lifecycle> turnovers[] = {
      {"births at a point", {.emitters = {jet}, .capacity = 900}},
      {"births on a disc", {.emitters = {disc}, .capacity = 900}},
      {"births in a box", {.emitters = {box}, .capacity = 900}},
      {"births beyond the capacity", {.emitters = {mortal, disc}, .capacity = 200}},
      {"removal", {.emitters = {}, .removal = all, .capacity = 40}},
      {"births and removal", {.emitters = {disc, box}, .removal = all, .capacity = 900}},
      {"births and removal without order", {.emitters = {disc, box}, .removal = without_order, .capacity = 900}}};
  Cases cases;
  for (const auto& [name, turnover] : turnovers) {
    const auto run = [turnover = turnover](Isa isa, Arithmetic) {
      return live_hash<double>(live_hash<float>(hash_start, turnover, isa), turnover, isa);
    };
    cases.push_back({std::string("lifecycle: ") + name, run, false});
  }
  return cases;
}

inline Cases all_cases() {
  Cases all;
  for (const Cases& cases : {contact_cases(), radial_cases(), accumulate_cases(), pulse_cases(), air_cases(), skin_cases(),
                             meet_cases(), sheet_contact_cases(), motion_cases(), constraint_cases(), generalized_alpha_cases(),
                             compensated_cases(), live_cases()}) {
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

}  // namespace golden_test
