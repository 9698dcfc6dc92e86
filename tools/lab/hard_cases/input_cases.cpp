// Unusual steps, masses and numbers, and the independence of the way in which a batch runs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "closed_form/closed_form.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/trial.hpp"
#include "scene_io/counter_random.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// --- scenes of every pass -----------------------------------------------------------------------------------------------

struct NamedScene {
  std::string name;
  Scene scene;
};

// A value between -1 and 1.
double scattered(std::uint64_t particle, unsigned axis) { return uniform_value(-1, 1, 5, particle, axis); }

std::vector<Start> scattered_starts(std::size_t count) {
  std::vector<Start> starts(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      starts[i].x[axis] = 1.2 * scattered(i, axis);
      starts[i].v[axis] = 3 * scattered(i, 3 + axis);
    }
  }
  return starts;
}

// Particles that do not meet: springs, drag, wind and forcing, shared or individual, contacts, radial springs, every method.
std::vector<NamedScene> scenes_apart(std::size_t count) {
  std::vector<double> each(count);
  for (std::size_t i = 0; i < count; ++i) each[i] = 30 + 25 * scattered(i, 6);
  std::vector<NamedScene> list;
  const Constant gravity{.acceleration = {0, -9.81, 0}};
  const Sinusoid gust{.acceleration = {2, 0, -0.6}, .angular_frequency = 4.3};
  const Drag wind{.coefficient = 0.3, .wind = {3, 0, 1}};
  const auto add = [&](std::string name, std::vector<Force> forces) -> Scene& {
    list.push_back({std::move(name), {}});
    list.back().scene.forces = std::move(forces);
    return list.back().scene;
  };
  add("spring", {Spring{.stiffness = 30.0, .anchor = Vec3{0.1, -0.2, 0.3}}});
  add("fall in wind", {gravity, wind});
  add("damped spring and gust", {Spring{.stiffness = 30.0, .damping = 0.4, .anchor = at_start}, gust});
  add("a spring each", {Spring{.stiffness = each, .anchor = at_start}, gravity, gust});
  add("a damped spring each", {Spring{.stiffness = each, .damping = 0.3}, wind}).mass = each;
  add("average acceleration", {Spring{.stiffness = 30.0}, wind, gravity}).method = Method::average_acceleration;
  add("radial springs", {RadialSpring{.stiffness = 14.0, .damping = 0.2, .anchor = Vec3{0, 0.5, 0}, .rest_length = 0.4},
                         RadialSpring{.stiffness = each, .anchor = at_start, .rest_length = 0.2, .method = Method::exact}});
  Scene& contacts = add("contacts", {gravity, wind});
  contacts.add(Plane{.normal = {0, 1, 0}, .offset = -0.5, .restitution = 0.5, .friction = 0.3});
  contacts.add(Plane{.normal = {1, 1, 0}, .offset = -0.9, .restitution = 1, .viscosity = 0.2, .sweep = ContactPath::line});
  contacts.add(Sphere{.radius = 1.6, .side = Side::inside, .restitution = 0.7, .friction = 0.1});
  return list;
}

// Two sheets, and rods between particles of the second, in every scheme.
constexpr std::size_t sheet_side = 6;
constexpr std::size_t joined_count = 2 * sheet_side * sheet_side;

std::vector<Start> joined_starts() {
  std::vector<Start> starts;
  for (std::size_t i = 0; i < joined_count; ++i) {
    const auto column = static_cast<double>(i % sheet_side);
    const auto row = static_cast<double>(i / sheet_side % sheet_side);
    const double sheet = i < joined_count / 2 ? 0 : 1;
    starts.push_back(
        {{0.2 * column, sheet + 0.01 * scattered(i, 0), 0.2 * row}, {0.1 * scattered(i, 1), 0, 0.1 * scattered(i, 2)}});
  }
  return starts;
}

std::vector<NamedScene> scenes_joined() {
  std::vector<NamedScene> list;
  const auto add = [&](std::string name, const Coupling& coupling, bool is_list) -> Scene& {
    Scene scene;
    scene.mass = 0.01;
    scene.add(Constant{.acceleration = {0, -9.81, 0}});
    for (const std::size_t first : {std::size_t{0}, joined_count / 2}) {
      const Grid grid{.rows = sheet_side,
                      .columns = sheet_side,
                      .first = first,
                      .edge_u = {1, 0, 0},
                      .edge_v = {0, 0, 1},
                      .structural = 20,
                      .shear = 8,
                      .bend = 1,
                      .damping = 0.001};
      scene.add(is_list ? Network(springs_of(grid)) : Network(grid));
    }
    scene.coupling = coupling;
    list.push_back({std::move(name) + (is_list ? ", list" : ", grid"), std::move(scene)});
    return list.back().scene;
  };
  for (const bool is_list : {false, true}) {
    add("leapfrog", {}, is_list);
    add("fourth_order", {.scheme = Scheme::fourth_order}, is_list);
    add("sequential", {.scheme = Scheme::sequential}, is_list);
    add("accumulate exact", {.scheme = Scheme::accumulate}, is_list);
    add("accumulate combined", {.scheme = Scheme::accumulate, .method = Method::combined}, is_list);
  }
  Scene& rods = add("rods", {}, true);
  rods.networks.pop_back();
  Distance chain;
  for (std::uint32_t i = joined_count / 2; i + 1 < joined_count; ++i) {
    if ((i + 1) % sheet_side != 0) chain.pairs.push_back({i, i + 1});
  }
  rods.add(Constraint(chain));
  return list;
}

// --- 31: a particle that is not finite ----------------------------------------------------------------------------------

template <class T>
bool is_same(T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

// The number of particles, without the `skipped` ones, of which any number differs in any bit between the trials.
template <class T, class Skipped>
double differing(Trial<T>& a, Trial<T>& b, const Skipped& skipped) {
  int count = 0;
  for (std::size_t i = 0; i < std::min(a.count(), b.count()); ++i) {
    if (skipped(i)) continue;
    bool is_alike = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      is_alike = is_alike && is_same(a.state().x[axis][i], b.state().x[axis][i]) &&
                 is_same(a.state().v[axis][i], b.state().v[axis][i]);
    }
    count += is_alike ? 0 : 1;
  }
  return count;
}

template <class T>
bool is_finite(Trial<T>& trial, std::size_t i) {
  bool is_good = true;
  for (std::size_t axis = 0; axis < 3; ++axis)
    is_good = is_good && std::isfinite(trial.x(axis, i)) && std::isfinite(trial.v(axis, i));
  return is_good;
}

struct Bad {
  const char* name;
  double x, v;
};
constexpr std::array<Bad, 4> bads{
    {{"x NaN", not_a_number, 0}, {"v NaN", 0, not_a_number}, {"x infinite", infinite, 1}, {"v infinite", 1, -infinite}}};

template <class T>
Worst bad_particle(CaseRun& way) {
  constexpr std::size_t count = 45;
  constexpr std::size_t at = 21;
  Worst worst;
  for (const auto& [name, scene] : scenes_apart(count)) {
    const auto starts = scattered_starts(count);
    for (const Bad& bad : bads) {
      Trial<T> good(way, scene, hz60, starts);
      Trial<T> with_bad(way, scene, hz60, starts);
      with_bad.state().x[1][at] = static_cast<T>(bad.x);
      with_bad.state().v[0][at] = static_cast<T>(bad.v);
      good.step(7);
      with_bad.step(7);
      worst.see(differing(good, with_bad, [](std::size_t i) { return i == at; }), fmt::format("{}, {}", name, bad.name));
    }
  }
  return worst;
}

// A particle not joined to the bad one keeps every bit. A joined one stays finite, without its springs to the bad one.
template <class T>
Worst bad_neighbour(CaseRun& way) {
  Worst worst;
  for (const auto& [name, scene] : scenes_joined()) {
    for (const std::size_t at : {std::size_t{8}, joined_count / 2 + 8}) {
      const bool is_first = at < joined_count / 2;
      for (const Bad& bad : bads) {
        const auto starts = joined_starts();
        Trial<T> good(way, scene, hz60, starts);
        Trial<T> with_bad(way, scene, hz60, starts);
        with_bad.state().x[1][at] = static_cast<T>(bad.x);
        with_bad.state().v[0][at] = static_cast<T>(bad.v);
        good.step(7);
        with_bad.step(7);
        const auto where = fmt::format("{}, {}", name, bad.name);
        worst.see(differing(good, with_bad, [&](std::size_t i) { return (i < joined_count / 2) == is_first; }), where);
        double lost = 0;
        for (std::size_t i = 0; i < joined_count; ++i) lost += i != at && !is_finite(with_bad, i) ? 1 : 0;
        worst.see(lost, where);
      }
    }
  }
  return worst;
}

// --- 32: masses ---------------------------------------------------------------------------------------------------------

template <class T>
bool is_refused(const Scene& scene, double step, std::size_t count) {
  Soa<T> memory(count);
  return !compile<T>(scene, {.step = step}, memory.view()).has_value();
}

template <class T>
Worst bad_masses(CaseRun& /*way*/) {
  Worst worst;
  for (const double mass : {0.0, -0.0, -1.0, infinite, -infinite, not_a_number}) {
    for (const bool is_each : {false, true}) {
      Scene scene;
      scene.add(Constant{.acceleration = {0, -9.81, 0}});
      scene.mass = is_each ? Scalars(std::vector<double>{1, mass}) : Scalars(mass);
      worst.see(is_refused<T>(scene, hz60, 2) ? 0 : 1, fmt::format("mass {:g}", mass));
    }
  }
  return worst;
}

// Fixed particles keep their bits in every pass. Springs and rods between two fixed particles do nothing.
template <class T>
Worst pinned(CaseRun& way) {
  Worst worst;
  const auto see = [&](const NamedScene& named, const std::vector<Start>& starts, std::vector<std::size_t> fixed) {
    Scene scene = named.scene;
    scene.fixed = std::move(fixed);
    Trial<T> before(way, scene, hz60, starts);
    Trial<T> after(way, scene, hz60, starts);
    after.step(50);
    worst.see(
        differing(before, after, [&](std::size_t i) { return std::count(scene.fixed.begin(), scene.fixed.end(), i) == 0; }),
        named.name);
    for (std::size_t i = 0; i < starts.size(); ++i) worst.see(is_finite(after, i) ? 0 : 1, named.name);
  };
  for (const NamedScene& named : scenes_apart(45)) see(named, scattered_starts(45), {0, 7, 21, 22, 44});
  for (const NamedScene& named : scenes_joined())
    see(named, joined_starts(), {0, 1, 2, 7, 8, joined_count - 2, joined_count - 1});
  return worst;
}

// --- 33, 34, 35: steps --------------------------------------------------------------------------------------------------

// Steps of zero length.
template <class T>
Worst no_time(CaseRun& way) {
  Worst worst;
  const auto see = [&](const NamedScene& named, const std::vector<Start>& starts) {
    Trial<T> before(way, named.scene, hz60, starts);
    Trial<T> after(way, named.scene, 0, starts);
    after.step(3);
    worst.see(differing(before, after, [](std::size_t) { return false; }), named.name);
    before.set_step(0);
    before.step(2);
    worst.see(differing(before, after, [](std::size_t) { return false; }), named.name + ", by set_step");
  };
  auto starts = scattered_starts(20);
  starts[3] = {{-0.0, 1e-40, -0.9}, {0.0, -0.0, 1e-310}};  // inside a plane, signed zeros, denormals
  for (const NamedScene& named : scenes_apart(20)) see(named, starts);
  for (const NamedScene& named : scenes_joined()) see(named, joined_starts());
  return worst;
}

// 100 steps forward and 100 back. The errors, in metres and in metres a second over omega, are relative to the damping's
// amplification.
template <class T>
double there_and_back(CaseRun& way, const Scene& scene, double omega, double amplified) {
  const auto starts = scattered_starts(17);
  Trial<T> trial(way, scene, hz60, starts);
  const Trial<T> start(way, scene, hz60, starts);
  trial.step(100);
  trial.set_step(-hz60);
  trial.step(100);
  Worst worst;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      worst.see(std::abs(trial.x(axis, i) - start.x(axis, i)) / amplified);
      worst.see(std::abs(trial.v(axis, i) - start.v(axis, i)) / omega / amplified);
    }
  }
  return worst.value;
}

template <class T>
Worst reversed(CaseRun& way) {
  Worst worst;
  for (const double omega : {2.0, 12.0, 100.0}) {
    Scene spring;
    spring.add(Spring{.stiffness = omega * omega, .anchor = Vec3{0.1, 0.2, -0.3}});
    worst.see(there_and_back<T>(way, spring, omega, 1), fmt::format("spring, omega = {:g}", omega));
    spring.add(Constant{.acceleration = {0, -9.81, 0}});
    spring.add(Sinusoid{.acceleration = {2, 0, -0.6}, .angular_frequency = 4.3});
    worst.see(there_and_back<T>(way, spring, omega, 1), fmt::format("spring, gravity and gust, omega = {:g}", omega));
    for (const double g : {0.5, 3.0}) {
      Scene damped = spring;
      damped.add(Drag{.coefficient = g});
      worst.see(there_and_back<T>(way, damped, omega, std::exp(g / 2 * 100 * hz60)),
                fmt::format("with drag {:g}/s, omega = {:g}", g, omega));
    }
  }
  return worst;
}

template <class T>
Worst changing_step(CaseRun& way) {
  Worst worst;
  for (const double omega : {10.0, 70.0}) {
    Scene scene;
    scene.add(Spring{.stiffness = omega * omega});
    Trial<T> trial(way, scene, hz60, Start{{1, 0.6, 0}, {0, -0.8 * omega, omega}});
    const std::array<AxisState, 3> start{{{trial.x(0), trial.v(0)}, {trial.x(1), trial.v(1)}, {trial.x(2), trial.v(2)}}};
    long double t = 0;
    for (std::uint64_t n = 0; n < 10000; ++n) {
      const double h = uniform_value(1.0 / 240, 1.0 / 30, 7, n, 0);
      trial.set_step(h);
      trial.step();
      t += h;
    }
    const long double z = omega * t;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const long double x = start[axis].x * std::cos(z) + start[axis].v / omega * std::sin(z);
      const long double v = start[axis].v * std::cos(z) - start[axis].x * omega * std::sin(z);
      worst.see(static_cast<double>(std::abs(trial.x(axis) - x)), fmt::format("omega = {:g}", omega));
      worst.see(static_cast<double>(std::abs(trial.v(axis) - v)) / omega, fmt::format("omega = {:g}", omega));
    }
  }
  return worst;
}

// --- 40, 41 -------------------------------------------------------------------------------------------------------------

// Compares each particle of a batch of 1 to 33 with the same particle in a batch of 64.
template <class T>
Worst remainders(CaseRun& way) {
  Worst worst;
  const auto all = scenes_apart(64);
  for (std::size_t s = 0; s < all.size(); ++s) {
    Trial<T> whole(way, all[s].scene, hz60, scattered_starts(64));
    whole.step(5);
    for (std::size_t count = 1; count <= 33; ++count) {
      const NamedScene part = scenes_apart(count)[s];
      Trial<T> trial(way, part.scene, hz60, scattered_starts(count));
      trial.step(5);
      worst.see(differing(trial, whole, [](std::size_t) { return false; }), fmt::format("{}, {} particles", part.name, count));
    }
  }
  return worst;
}

template <class T>
Worst negative_stiffness(CaseRun& /*way*/) {
  Worst worst;
  for (const double w : {-1e-6, -0.5, -2.0}) {
    const double k = w / (hz60 * hz60);
    std::vector<Scene> scenes(5);
    scenes[0].add(Spring{.stiffness = k});
    scenes[1].add(Spring{.stiffness = {1, k, 1}});
    scenes[2].add(RadialSpring{.stiffness = k, .rest_length = 1.0});
    scenes[3].add(Network(Springs{.pairs = {{0, 1}}, .stiffness = k}));
    scenes[4].add(Network(Grid{.rows = 2, .columns = 2, .edge_u = {1, 0, 0}, .edge_v = {0, 1, 0}, .structural = k}));
    for (std::size_t s = 0; s < scenes.size(); ++s) {
      worst.see(is_refused<T>(scenes[s], hz60, 4) ? 0 : 1, fmt::format("w = {:g}, scene {}", w, s + 1));
    }
  }
  return worst;
}

}  // namespace

std::vector<Case> input_cases() {
  return {
      {31,
       "a particle that is not finite",
       "NaN or infinity in x or v, in every pass and scheme",
       {{float64, bad_particle<double>, 0, "particles", "all others bit by bit as without it"},
        {float32, bad_particle<float>, 0, "particles", "all others bit by bit as without it"},
        {float64, bad_neighbour<double>, 0, "particles", "neighbours finite, all not joined with it as without it"},
        {float32, bad_neighbour<float>, 0, "particles", "neighbours finite, all not joined with it as without it"}}},
      {32,
       "zero and infinite mass",
       "masses of 0, below 0, infinite and NaN; fixed particles in every pass, two of them joined",
       {{float64, bad_masses<double>, 0, "accepted", "refused with an error"},
        {float32, bad_masses<float>, 0, "accepted", "refused with an error"},
        {float64, pinned<double>, 0, "particles", "fixed ones unmoved by a bit, all finite"},
        {float32, pinned<float>, 0, "particles", "fixed ones unmoved by a bit, all finite"}}},
      {33, "a step of no time", "h = 0, by compile and by set_step, in every pass and scheme",
       both<no_time<double>, no_time<float>>(0, 0, "particles", "no bit changes")},
      {34, "backwards in time", "100 steps forth and 100 of -h; drag amplifies by exp(gamma t/2)",
       both<reversed<double>, reversed<float>>(1e-11, 2e-5, "m exp(gamma t/2)", "back at the start")},
      {35, "a step that changes", "h between 1/240 and 1/30 s anew for each of 1e4 steps",
       both<changing_step<double>, changing_step<float>>(1e-10, 1e-4, "A", "exact rotation by the sum of the steps")},
      {40, "remainders", "1 to 33 particles in registers of 1 to 16",
       both<remainders<double>, remainders<float>>(0, 0, "particles", "each as among 64, bit by bit")},
      {41, "negative stiffness", "w = W h^2 from -1e-6 to -2",
       both<negative_stiffness<double>, negative_stiffness<float>>(0, 0, "accepted", "refused with an error, never NaN")},
  };
}

}  // namespace dvdx::tool::stability
