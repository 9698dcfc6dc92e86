// One particle and surfaces: bounces, and the times of impacts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "closed_form/closed_form.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/trial.hpp"
#include "hard_cases/walls.hpp"

namespace dvdx::tool::stability {
namespace {

// --- 21, 22: bounces -----------------------------------------------------------------------------------------------------

// A ball drops from 1 m: bounce k comes at first (1 + 2 (e + ... + e^k)).
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
    for (int n = 0; n < 600; ++n) {  // starts one step after it comes to rest
      worst.see(std::abs(trial.v(1)) + std::abs(trial.x(1)), fmt::format("e = {:g}", e));
      trial.step();
    }
  }
  return worst;
}

// Returns the time since the last impact, found by following the present parabola backwards.
template <class T>
double seconds_since_impact(const Trial<T>& trial) {
  return 2 * trial.x(1) / (trial.v(1) + std::sqrt(trial.v(1) * trial.v(1) + 2 * gravity * trial.x(1)));
}

// Checks all bounces that are more than a step apart, or the first ones only. After two impacts in one step, only the last
// one's time can be recovered.
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

// --- 30, 42: the result of an impact -------------------------------------------------------------------------------------

template <class T>
Vec3 left_of(CaseRun& way, double restitution, double viscosity, double friction) {
  Plane floor = ground(restitution);
  floor.viscosity = viscosity;
  floor.friction = friction;
  Trial<T> trial(way, scene_of({floor}), hz60, Start{{0, 0.01, 0}, {3, -1, 4}});
  trial.step();
  return velocity(trial);
}

// v_n' = -e v_n; v_t' = tau v_t less Coulomb's mu (1 + e) |v_n|, bounded below by 0.
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

// Results that must be exactly 0.
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
  // Returns the fraction of the step at which the flight crosses the wall, if it ends below the wall and crosses it only once.
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

// Returns |f - exact|, with f from the effect of an elastic impact's pulse on the step. With r = (1 - f) h, dx = dv sin(omega
// r)/omega under a spring and dx = dv (1 - exp(-g r))/g in air. The final velocity differs by dv cos(omega r) and dv exp(-g r).
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

// Per step: the angle of a spring, the decay by drag, and the angle of a force sinusoidal in time.
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

// A floor, and a spring that pulls to the floor's height.
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

// Impacts of 0.5 to 5 m/s at many times within a step, compared with the exact bounce. The error is that of the energy relative
// to the kinetic energy at the impact, or that of the velocity relative to the impact's.
enum class Judged { energy, velocity };

template <class T, Judged judged>
double impact_under(CaseRun& way, const Acting& acting, const Contact& floor) {
  double worst = 0;
  for (int i = 0; i < 100; ++i) {
    const double part = std::fmod(0.5 + 0.618033988749895 * i, 1);
    const double speed = 0.5 + 4.5 * std::fmod(0.25 + 0.7548776662466927 * i, 1);
    const auto equation = equation_of(acting, part * hz60);
    const AxisState before = solve(equation, {0, -speed}, -part * hz60);
    if (!(before.x > 0)) continue;  // the path before the impact lies below the floor
    Trial<T> trial(way, scene_under(acting, floor), hz60,
                   Start{{0, static_cast<double>(before.x), 0}, {0, static_cast<double>(before.v), 0}});
    trial.step();
    const AxisState after = solve(equation, {0, speed}, (1 - part) * hz60);
    if (!(after.x > 0)) continue;  // it falls back within the step
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
// The sphere is so large that it is flat where the particle falls, but rounding is that of a sphere.
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
// The velocity error after an impact under a force of time, relative to the error that the study of the method found for a
// quintic path.
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

// A thousand bounces on a floor under gravity and a spring of 0.03 or 0.1 rad a step.
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

// A spring bends the path back within the step. The path dips below the floor by a hundredth of a millimetre to a centimetre,
// and the step does not end in the dip. The error is that of the energy after the step relative to the energy before.
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
      // two or more reflections: the energy is kept, and the end lies above the end of the undisturbed dip
      const auto energy = [&](double at, double speed) { return speed * speed + omega * omega * (at - 0.2) * (at - 0.2); };
      worst.see(std::abs(energy(trial.x(1), trial.v(1)) / energy(y, v) - 1), where);
      worst.see(trial.x(1) < 0 || trial.x(1) == y ? infinite : 0, where);
    }
  }
  return worst;
}

}  // namespace

std::vector<Case> bounce_cases() {
  return {
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
  };
}

}  // namespace dvdx::tool::stability
