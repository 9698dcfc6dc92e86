// The plan in words.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "forces/radial_spring.hpp"
#include "math/elementary.hpp"
#include "math/vec3.hpp"
#include "plan/plan_parts.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "stability/accuracy.hpp"

namespace dvdx {
namespace {

std::string describe(Flow flow) {
  std::string text;
  if (is_drift(flow)) {
    text = "drift: x += S v + Q, v += P - B v (no spring acts)";
  } else if (is_shear(flow)) {
    text = "shear: e += t1 v, v -= s e + kappa v, e += t2 v, which neither gives nor takes energy by rounding";
  } else {
    text = "fused: x += S v - C e, v -= A e + B v, e = x - c";
  }
  if (!is_drift(flow) && is_driven(flow)) text += "; driven: x += Q, v += P";
  if (has_anchor_each(flow)) text += "; an anchor each";
  if (is_rate(flow)) text += "; coefficients each";
  return text;
}

// Multiplications and additions of one particle-step, contracted ones counted twice.
int operations(Flow flow, std::size_t sources) noexcept {
  const int axis = is_drift(flow) ? 6 : (is_shear(flow) ? 10 : 9);
  const int driven = !is_drift(flow) && is_driven(flow) ? 2 : 0;
  return 3 * (axis + driven + static_cast<int>(4 * sources));
}

std::string_view name(Method method) {
  switch (method) {
    case Method::combined:
      return "combined";
    case Method::exact:
      return "exact";
    case Method::average_acceleration:
      return "average_acceleration";
    case Method::pulse:
      return "pulse";
    case Method::symplectic_euler:
      return "symplectic_euler";
  }
  return "";
}

std::string_view kind(const Force& force) {
  constexpr std::array names = {"constant", "polynomial", "sinusoid", "spring", "radial_spring", "drag"};
  static_assert(names.size() == std::variant_size_v<Force>, "a name for each force, in the variant's order");
  return names[force.index()];
}

// The step's matrix along one axis, [[1-C, S], [-A, 1-B]].
struct StepMatrix {
  double A = 0, B = 0, C = 0, S = 0;
};

// First b, then a.
StepMatrix operator*(const StepMatrix& a, const StepMatrix& b) {
  return {.A = a.A + b.A - a.A * b.C - a.B * b.A,
          .B = a.B + b.B + a.A * b.S - a.B * b.B,
          .C = a.C + b.C - a.C * b.C + a.S * b.A,
          .S = a.S + b.S - a.C * b.S - a.S * b.B};
}

// All radial springs act along this axis, near their rest lengths: nowhere is their sum stiffer.
StepMatrix step_matrix(const Scene& scene, const System& system, std::size_t axis, std::size_t particle, double h) {
  const AxisMotion motion = system.motion(axis, particle);
  const StepMatrix flow{.A = motion.A, .B = motion.B, .C = motion.C, .S = motion.S};
  StepMatrix step = flow;
  StepMatrix damping;
  StepMatrix kick;
  for (std::size_t k = 0; k < system.radial().size(); ++k) {
    const auto& spring = std::get<RadialSpring>(scene.forces[system.radial()[k]]);
    const double W = spring.stiffness[particle] / scene.mass[particle];
    const double g = spring.damping / scene.mass[particle];
    if (k < system.kicks()) {
      const RadialKick of_one = radial_kick(W, g, h);
      kick.A += of_one.kappa;
      damping.B = 1 - (1 - damping.B) * of_one.E;
    }
    if (k + 1 == system.kicks()) step = flow * (damping * kick * damping) * flow;
    if (k >= system.kicks()) {
      const Contribution more = radial_spring(W, g, h, system.method(system.radial()[k]));
      step.A += more.A;
      step.B += more.B;
      step.C += more.C;
      step.S -= more.D;
    }
  }
  return step;
}

double spectral_radius(const StepMatrix& k) {
  const double half_trace = 1 - (k.B + k.C) / 2;
  const double less = k.B + k.C - k.B * k.C - k.A * k.S;  // 1 - determinant, without cancellation
  const double discriminant = half_trace * half_trace - (1 - less);
  if (discriminant <= 0) return std::sqrt(std::max(0.0, 1 - less));
  return std::abs(half_trace) + std::sqrt(discriminant);
}

struct Worst {
  double radius = 0;
  std::size_t particle = 0, axis = 0;
};

// The particle and axis whose motion grows most in a step.
Worst worst(const Scene& scene, const System& system, std::size_t particles, double h) {
  Worst found;
  for (std::size_t i = 0; i < particles; ++i) {
    for (std::size_t axis = 0; axis < (system.is_isotropic() ? 1 : 3); ++axis) {
      const double radius = spectral_radius(step_matrix(scene, system, axis, i, h));
      if (radius > found.radius) found = {radius, i, axis};
    }
  }
  return found;
}

// How many steps it takes until what grows by `radius` in each has doubled: 1 / log2(radius). With radius = 2^e m,
// log2 m = y / ln 2, and y = ln m by Newton's method of third order on e^y (the kernel calls no
// transcendental function of the math library: tests/check_math_library.cmake).
double doubling_steps(double radius) {
  int exponent = 0;
  double m = std::frexp(radius, &exponent);
  if (m < 0.75) {  // so that nothing cancels where the radius is little more than one
    m *= 2;
    --exponent;
  }
  double y = 0;
  for (int round = 0; round < 5; ++round) {
    const double power = exp_negative(-y);
    y += 2 * (m - power) / (m + power);
  }
  return 1 / (exponent + y * log2_e);
}

// rounding of the coefficients' sums makes a radius of one look like 1 + 1e-16
constexpr double rounding = 1e-12;

// The largest step that does not grow, between h and a thousandth of it; 0 where there is none. At a limit growth sets in at
// once; what grows with a power of the step (several exact springs: its cube) grows at every step, however little.
double stable_step(const Scene& scene, std::span<const Vec3> start, Worst at, double h) {
  constexpr double onset = 1e-9;
  const auto growth = [&](double step) {
    const System system(scene, start, step);
    return spectral_radius(step_matrix(scene, system, at.axis, at.particle, step)) - 1;
  };
  const auto is_stable = [&](double step) { return growth(step) <= rounding; };
  double low = h / 1000;
  if (!is_stable(low)) return 0;
  double high = h;
  for (int i = 0; i < 40; ++i) (is_stable((low + high) / 2) ? low : high) = (low + high) / 2;
  const double beyond = std::abs(1.1 * low) < std::abs(h) ? 1.1 * low : h;
  return growth(beyond) > onset ? low : 0;
}

std::string describe_forces(const Scene& scene, const System& system) {
  std::string text;
  const auto list = [&](const std::vector<std::size_t>& forces) {
    std::string names;
    for (const std::size_t i : forces) {
      names += (names.empty() ? "" : ", ") + ("forces[" + std::to_string(i) + "] " + std::string(kind(scene.forces[i])));
    }
    return names;
  };
  if (!system.combined().empty()) text += "combined     as one exact system: " + list(system.combined()) + "\n";
  for (std::size_t i = 0; i < scene.forces.size(); ++i) {
    const auto& combined = system.combined();
    if (std::find(combined.begin(), combined.end(), i) != combined.end()) continue;
    const bool is_kick = std::holds_alternative<RadialSpring>(scene.forces[i]) && system.method(i) == Method::combined;
    text += "alone        forces[" + std::to_string(i) + "] " + std::string(kind(scene.forces[i])) + " by " +
            (is_kick ? "a kick at the middle of the step" : std::string(name(system.method(i)))) + "\n";
  }
  return text;
}

std::string describe_accuracy(const Scene& scene, const System& system, int impacts) {
  const Accuracy of = accuracy(scene, system);
  std::string words = "accuracy     ";
  if (of.order == Accuracy::exact) {
    words += "exact for any step\n";
  } else {
    words += "order " + std::to_string(of.order) + " in the step\n";
    for (const std::string& reason : of.reasons) words += "             " + reason + "\n";
  }
  if (scene.contacts.empty()) return words;
  words += "             as long as no particle has more than " + std::to_string(impacts) +
           " impacts in a step; what bounces ever lower comes to lie within a step of its time";
  const auto any_is = [&](const auto& is_it) { return std::any_of(scene.contacts.begin(), scene.contacts.end(), is_it); };
  if (any_is([](const Contact& contact) { return std::holds_alternative<Sphere>(contact); }))
    words += ", and what slides on a sphere is of order 1";
  if (any_is([](const Contact& contact) { return std::holds_alternative<Capsule>(contact); }))
    words += ", and what slides on a capsule is of order 1";
  if (any_is([](const Contact& contact) { return std::holds_alternative<TriangleMesh>(contact); }))
    words += ", and what slides on a mesh is of order 1";
  return words + "\n";
}

// The highest frequency of a radial spring and what the kicks of all come to: a kick of h kappa alone is stable up to 4.
std::string describe_radial(const Scene& scene, const System& system, std::size_t particles, double h) {
  double frequency = 0;
  double kicks = 0;
  for (std::size_t i = 0; i < particles; ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < system.radial().size(); ++k) {
      const auto& spring = std::get<RadialSpring>(scene.forces[system.radial()[k]]);
      const double W = spring.stiffness[i] / scene.mass[i];
      frequency = std::max(frequency, std::sqrt(W));
      if (k < system.kicks()) sum += std::abs(h) * radial_kick(W, spring.damping / scene.mass[i], h).kappa;
    }
    kicks = std::max(kicks, sum);
  }
  std::string words = "radial       highest frequency x step is " + text(frequency * std::abs(h), 3);
  if (system.kicks() != 0) words += "; the kicks along one line come to " + text(kicks, 3) + ", alone they are stable up to 4";
  return words + "\n";
}

template <class T>
std::string describe_stability(const CompiledScene<T>& compiled, const System& system) {
  const double h = compiled.options.step;
  const bool is_joined = compiled.joined() != nullptr;
  const std::string of = is_joined ? "of each particle without what joins it to others: " : "";
  if (system.is_one_system() && system.radial().empty()) return "stability    " + of + "stable at any step\n";
  const bool is_alike =
      system.is_uniform() &&
      std::all_of(system.radial().begin(), system.radial().end(),
                  [&](std::size_t i) { return std::get<RadialSpring>(compiled.scene.forces[i]).stiffness.is_uniform(); }) &&
      compiled.scene.mass.is_uniform();
  const std::size_t particles = is_alike ? 1 : *compiled.count;
  const Worst at = worst(compiled.scene, system, particles, h);
  std::string words = system.radial().empty() ? "" : describe_radial(compiled.scene, system, particles, h);
  words += "stability    " + of + "spectral radius " + text(at.radius, 12) + " at this step of " + text(h, 6) + " s";
  if (!system.radial().empty()) words += ", where all radial springs pull along one line";
  if (at.radius <= 1 + rounding) return words + ": stable\n";
  words += ": UNSTABLE, amplitude doubles every " + text(doubling_steps(at.radius), 3) + " steps";
  if (!is_alike) words += " (particle " + std::to_string(at.particle) + ")";
  words += "\n             what to do: ";
  const double limit = stable_step(compiled.scene, compiled.start, at, h);
  const std::string_view cure = system.radial().empty() ? "method combined is exact" : "another method";
  if (limit > 0) return words + "a step of at most " + text(limit, 6) + " s, or method combined\n";
  return words + "no smaller step cures it (the separate contributions add energy); " + std::string(cure) + "\n";
}

std::string_view name(Scheme scheme) {
  switch (scheme) {
    case Scheme::leapfrog:
      return "leapfrog";
    case Scheme::fourth_order:
      return "fourth_order";
    case Scheme::sequential:
      return "sequential";
    case Scheme::accumulate:
      return "accumulate";
    case Scheme::automatic:
      return "automatic";
  }
  return "";
}

template <class T>
std::string describe_form(const GridForm<T>& /*form*/) {
  return "as a grid: each spring once, no index loaded";
}
template <class T>
std::string describe_form(const GraphForm<T>& /*form*/) {
  return "as a graph: each particle sums its own";
}
template <class T>
std::string describe_form(const PairsForm<T>& /*form*/) {
  return "as a graph: each particle sums its pairs' own contributions";
}
template <class T>
std::string describe_form(const StrandsForm<T>& form) {
  return form.is_list() ? "as a list that is a sheet in sweeps, in bands of rows" : "as a grid in sweeps, in bands of rows";
}
template <class T>
std::string describe_form(const ColoursForm<T>& form) {
  std::string within = "as a graph in sweeps of " + counted(form.colours(), "colour");
  if (form.pieces() == 1) return within;
  return within + " in each of " + std::to_string(form.pieces()) + " pieces, then " + std::to_string(form.stages.size() - 2) +
         " colours between them";
}

// The sub-steps that other schemes would take for the same springs and step, and the order that the scene's steps would have.
template <class T>
std::string describe_other_schemes(const Joints<T>& joints, const NetworkLimit& limit, const Scene& scene,
                                   const System& system) {
  const auto order = [&](Scheme scheme) {
    Scene by_other = scene;
    by_other.coupling.scheme = scheme;
    return ": order " + std::to_string(accuracy(by_other, system).order) + "\n";
  };
  std::string words;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
    if (joints.coupling.scheme == scheme) continue;
    const int substeps = substeps_for(calm_limit({.scheme = scheme}), joints.step, {limit.bound, limit.damping});
    const std::int64_t pulses = scheme == Scheme::fourth_order ? 6 : 1;
    words += "             " + std::string(name(scheme)) + " would take " + counted(substeps, "sub-step") + ", " +
             std::to_string(substeps * pulses) + " pulses a step" + order(scheme);
  }
  if (joints.coupling.scheme != Scheme::sequential) {
    words += "             sequential would take any number of sub-steps, 2 sweeps each (a sweep costs about 2 pulses)" +
             order(Scheme::sequential);
  }
  return words;
}

// The margin between what a sub-step comes to at most and what the scheme takes.
std::string describe_margin(const NetworkLimit& limit, double most, double takes, std::string_view where) {
  const double margin = takes / most - 1;
  if (margin >= -1e-9) return "a margin of " + text(std::round(100 * std::max(0.0, margin)), 6) + " %\n";
  return "MAY GROW" + std::string(where) + "; " + counted(limit.safe, "sub-step") +
         (limit.safe == 1 ? " is safe\n" : " are safe\n");
}

template <class T>
std::string describe_damping(const Joints<T>& joints, const NetworkLimit& limit, double h) {
  if (!joints.is_damped()) return "";
  std::string words = "damping      at most " + text(limit.damping, 6) + " 1/s along the springs in any position";
  if (const std::size_t passes = joints.damping_passes(); passes != 0) {
    words += "; a pulse takes " + std::to_string(passes) + (passes == 1 ? " pass" : " passes") + " more over what damps";
  }
  words += "\n";
  if (std::isinf(limit.damping_limit)) return words;
  return words + "             rate x sub-step is at most " + text(limit.damping * h, 3) + "; the scheme takes " +
         text(limit.damping_limit, 3) + ": " + describe_margin(limit, limit.damping * h, limit.damping_limit, "");
}

// How much softer sweeps leave the springs than they are, now.
template <class T>
std::string describe_estimate(const Joints<T>& joints, const CompiledScene<T>& compiled, const NetworkLimit& limit) {
  if (limit.scheme != Scheme::sequential) return "";
  const SweepEstimate& of = limit.estimate;
  if (of.side == 0) return "             no load hangs on what is held: the estimated error asks for no sub-steps\n";
  const auto with_share = [&](double error) { return text(error, 3) + " m or " + text(100 * error / of.side, 3) + " %"; };
  const SweptNet net = joints.swept_net(compiled.scene, compiled.start);
  const double longest = net.longest_substep(joints.coupling, joints.rates.most);
  return "             sweeps leave springs softer; of the side " + text(of.side, 3) + " m a net is estimated to hang " +
         with_share(of.rest) + " too low (its springs stretch by " + text(of.sag, 3) + " m), and to swing " +
         with_share(of.motion) + " off\n             " + counted(substeps_within(longest, joints.step), "sub-step") +
         " a step keep both within " + text(100 * most_sweep_error, 3) + " %, or are as short as leapfrog's\n" +
         (net.drapes() ? "             what lies on a surface drapes further than by leapfrog, by how much is not estimated\n"
                       : "");
}

template <class T>
std::string describe_limit(const Joints<T>& joints) {
  if (!joints.coupling.most_substeps) return "";
  constexpr double any_step = 1e6;  // s
  const double longest = joints.step_within_limit(
      {.step = std::copysign(any_step, joints.step), .longest_step = joints.longest_step.value_or(std::abs(joints.step))});
  return "             at most " + counted(*joints.coupling.most_substeps, "sub-step") +
         " a step: set_step() cuts a step of more than " + text(std::abs(longest), 4) + " s\n";
}

std::string describe_choice(const std::optional<SchemeChoice>& choice) {
  if (!choice || choice->leapfrog_cost == 0) return "";
  return "             the cheaper of leapfrog, " + counted(choice->leapfrog, "sub-step") + ", " +
         text(choice->leapfrog_cost, 3) + " ns a step, and sequential, " + counted(choice->sequential, "sub-step") + ", " +
         text(choice->sequential_cost, 3) + " ns, by the table of costs\n";
}

template <class T>
std::string describe_network(const Joints<T>& joints, const CompiledScene<T>& compiled, const System& system,
                             std::size_t workspace_bytes) {
  if (joints.springs == 0) return "";
  const Scene& scene = compiled.scene;
  const NetworkLimit limit = joints.limit(scene, compiled.start);
  const Coupling& coupling = joints.coupling;
  const std::string form = std::visit([](const auto& of) { return describe_form(of); }, joints.form);
  std::string words = "springs      " + std::to_string(joints.springs) + ", " + form + "; " + std::to_string(joints.bytes()) +
                      " bytes, and " + std::to_string(workspace_bytes) + " of working memory a state\n";
  words += "scheme       " + std::string(name(coupling.scheme)) + ", " + counted(limit.substeps, "sub-step") + " a step";
  if (coupling.scheme == Scheme::sequential) {
    words += is_generalized_alpha(coupling) ? ", generalized alpha, rho " + text(joints.chosen.rho, 6)
                                            : ", theta " + text(theta_of(coupling), 6);
    words += coupling.sweeps == SweepOrder::symmetric ? ", forward and backward" : ", forward";
    const auto has_lines = [](const auto& of) {
      if constexpr (requires { of.lines; }) return !of.lines.empty();
      return false;
    };
    const auto redirects = [](const auto& of) {
      if constexpr (requires { of.lines.forces; }) return of.lines.forces == LineForces::redirected;
      return false;
    };
    if (std::visit(has_lines, joints.form)) words += ", whole lines of springs between them";
    if (std::visit(redirects, joints.form)) words += ", whose forces are redirected";
  }
  words += coupling.substeps ? " (asked for)\n" : " (chosen)\n";
  if (coupling.scheme == Scheme::sequential && joints.longest_step) {
    words += "             steps vary: no sub-step is longer than " + text(std::abs(joints.chosen.longest), 6) +
             " s, those of a step of " + text(*joints.longest_step, 6) + " s, for which every spring is solved\n";
  }
  words += describe_limit(joints);
  words += describe_choice(compiled.choice);
  words += "frequency    " + text(limit.frequency, 6) + " rad/s at the start, at most " + text(limit.bound, 6) +
           " in any position (the springs of particle " + std::to_string(limit.particle) + ")\n";
  const double h = std::abs(joints.step) / limit.substeps;
  if (std::isinf(limit.limit)) {
    words +=
        "             stable at any sub-step where the springs are linear; position errors grow with frequency x sub-step, "
        "here " +
        text(limit.frequency * h, 3) + "\n";
    words += describe_estimate(joints, compiled, limit);
  } else {
    words += "             frequency x sub-step is " + text(limit.frequency * h, 3) + " at the start and at most " +
             text(limit.bound * h, 3) + "; the scheme takes " + text(limit.limit, 3) + ": " +
             describe_margin(limit, limit.bound * h, limit.limit, " where the springs fold onto one line");
  }
  words += describe_damping(joints, limit, h);
  if (coupling.scheme == Scheme::accumulate && coupling.method == Method::exact) {
    words += "             exact contributions of springs that share particles gain energy at every step\n";
  }
  return words + describe_other_schemes(joints, limit, scene, system);
}

template <class T>
std::string describe_air(const Joints<T>& joints, const CompiledScene<T>& compiled) {
  if (!joints.air) return "";
  const Air<T>& air = *joints.air;
  std::string words = "air          " + std::to_string(air.count()) + " triangles, " +
                      (air.is_grid() ? "each once by rows" : "a list, each with its particles anywhere");
  words += "; a pulse of it in two stages for up to five sub-steps";
  words += "; " + std::to_string(air.bytes()) + " bytes\n";
  const std::size_t gusts = compiled.scene.wind.gusts.size();
  words += "             the wind has " + (gusts == 0 ? std::string("no gusts") : std::to_string(gusts) + " gusts");
  words += "; stable at any sub-step, and asks for no more sub-steps\n";
  return words;
}

template <class T>
std::string describe_constraints(const Joints<T>& joints, const Scene& scene) {
  const auto& constraints = joints.constraints;
  if (!constraints) return "";
  const std::size_t colours = constraints->colours().size() + (constraints->lone_chains().to != 0 ? 1 : 0);
  std::string words = "constraints  " + std::to_string(constraints->count()) + " in " + counted(colours, "colour");
  if (constraints->chains() != 0) words += ", " + std::to_string(constraints->chains()) + " chains solved whole";
  words += "; " + counted(constraints->sweeps(), "sweep") + " over them in each of " +
           counted(joints.chosen.substeps, "sub-step") + "; " + std::to_string(constraints->bytes()) + " bytes\n";
  if (constraints->sweeps() > 1) {
    words +=
        "             those that share particles are solved one after the other: more sub-steps bring them nearer than more "
        "sweeps\n";
  }
  if (const double frequency = joints.rods_frequency(); frequency != 0) {
    words += "             rods that meet and ropes that cross ask for " +
             counted(substeps_of_rods(frequency, joints.step), "sub-step") + " a step, under all that may hang on them\n";
  }
  if (constraints->lone_chains().to == 0) return words;
  const double frequency = std::sqrt(length(constant_acceleration(scene)) * constraints->hanging_rate());
  const double angle = frequency * std::abs(joints.substep());
  int parts = 1;
  while (parts < most_parts<double> && angle * angle > most_transverse<double> * parts * parts) parts *= 2;
  words +=
      "             a chain that shares no particle takes sub-steps of its own where its tension asks for them: hanging "
      "still, " +
      text(frequency, 3) + " rad/s across it, " + std::to_string(parts) + " of each sub-step; 1 to 1024 as it moves\n";
  return words;
}

template <class T>
std::string describe_balls(const Joints<T>& joints, const CompiledScene<T>& compiled) {
  if (!joints.balls) return "";
  std::size_t near = 0, outside = 0, tethered = 0;
  for (const BallList<T>& list : joints.balls->lists()) {
    (list.is_backstop() ? outside : (list.skin ? near : tethered)) += list.count;
  }
  std::string words;
  if (near + outside != 0) {
    words += "skins        " + std::to_string(compiled.scene.skins.size()) + ": " + std::to_string(near) +
             " particles stay within at_most of their points, " + std::to_string(outside) + " out of the balls behind\n";
  }
  if (tethered != 0) {
    words += "tethers      " + std::to_string(tethered) + " particles, each to what it hangs on along whole springs\n";
  }
  return words + "             looked at once at the end of each of " + std::to_string(joints.chosen.substeps) +
         " sub-steps, which then ends with a flow of its own; " + std::to_string(joints.balls->bytes()) +
         " bytes; of second order where a particle stays on its limit, of first where it reaches it\n";
}

template <class T>
std::string describe_meetings(const Joints<T>& joints, const CompiledScene<T>& compiled, std::size_t workspace_bytes) {
  if (!joints.meet) return "";
  const MeetRules<T>& rules = *joints.meet;
  const Meet& meet = rules.meet();
  std::string words = "meetings     ";
  if (compiled.scene.meet->radius) {
    const double least{rules.least_radius()};
    const double most{rules.most_radius()};
    words += std::to_string(rules.particles()) + " balls of " + text(least, 3) + " m" +
             (least == most ? "" : " to " + text(most, 3) + " m") + ", which surfaces keep off by their radius";
  } else if (meet.thickness) {
    words += "particles of networks stay " + text(*meet.thickness, 3) + " m apart";
  } else {
    words += "particles of networks stay " + text(2 * double{rules.least_radius()}, 3) + " to " +
             text(2 * double{rules.most_radius()}, 3) + " m apart, " + text(*meet.part_of_cells, 3) +
             " of the widest cell of each, and a pair by its larger one";
  }
  words += "; restitution " + text(meet.restitution, 3) + ", friction " + text(meet.friction, 3) + "; " +
           counted(meet.rounds, "round") + " in each of " + counted(joints.chosen.substeps, "sub-step") + ", " +
           std::to_string(meet.most_neighbours) + " neighbours at most; a state is stepped in " +
           std::to_string(workspace_bytes) + " bytes\n";
  const double g = length(constant_acceleration(compiled.scene));
  const double h = std::abs(joints.substep());
  if (g != 0) {
    words += "             approaches up to " + text(4 * g * h, 3) + " m/s do not bounce; a layer of a pile sinks by " +
             text(g * h * h / double{rules.least_radius()}, 2) + " radii in a sub-step before rounds lift it\n";
  }
  if (rules.stretch_limit() > 0) {
    words += "             nothing passes while no spring is longer than " + text(rules.stretch_limit(), 3) +
             " of its length at rest, sqrt(2) t / s of the widest cell; neighbours that are nearer at the start do not meet\n";
  }
  if (rules.passing_layers() != 0) {
    words += "             " + std::to_string(rules.passing_layers()) +
             " pairs of layers start nearer than they want to be, and never meet: apart_at_start\n";
  }
  return words;
}

// Which contacts are narrower than which networks' cells, and what that takes.
template <class T>
std::string describe_faces(const JoinedMotion<T>& joined) {
  const FaceContacts* const faces = joined.faces();
  if (faces == nullptr) return "";
  std::string words;
  for (const FaceNetwork& network : faces->networks()) {
    std::size_t first = 0, end = 0;
    if (network.end_patch != network.first_patch) {
      first = faces->patches()[network.first_patch].first;
      end = faces->patches()[network.end_patch - 1].end;
    }
    for (const ThinBody& body : faces->bodies()) {
      if (!network.is_wider_than(body)) continue;
      words += (words.empty() ? "faces        " : "             ") + ("contacts[" + std::to_string(body.contact) + "] is ");
      words += body.width > 0 ? text(body.width, 3) + " m wide" : std::string("pointed");
      words += " where networks[" + std::to_string(network.network) + "] has sides of up to " + text(network.side, 3) +
               " m: its " + std::to_string(end - first) + " triangles meet it; more than " +
               text(0.5 * most_face_parts * body.shape.radius, 3) + " m in a sub-step may pass\n";
    }
  }
  return words + "             looked at once at the end of each of " + std::to_string(joined.joints().chosen.substeps) +
         " sub-steps, which then ends with a flow of its own; " + std::to_string(faces->bytes()) + " bytes; of first order\n";
}

std::string_view name(Rounding how, bool is_float32) {
  if (how == Rounding::compensated) return "float32 compensated (worked out in float64)";
  return is_float32 ? "float32" : "float64";
}

std::string describe_origin(const Origin& origin) {
  if (origin.is_world()) return "";
  if (origin.is_each()) return "origin       one for each particle\n";
  const Vec3& o = origin.at(0);
  return "origin       [" + text(o[0], 6) + ", " + text(o[1], 6) + ", " + text(o[2], 6) + "] m\n";
}

std::string describe_motions(const Scene& scene, Particles kind) {
  if (!has_followers(scene)) return "";
  std::size_t particles = 0;
  for (const Kinematic& followers : scene.kinematic) particles += followers.particles.size();
  const auto contacts = std::count_if(scene.contacts.begin(), scene.contacts.end(),
                                      [](const Contact& contact) { return motion_of(contact).has_value(); });
  std::string words = "motions      " + std::to_string(scene.motions.size()) + ", followed by " + std::to_string(particles) +
                      " particles and " + std::to_string(contacts) + " contacts; places, poses and velocities are made in each";
  words += kind == Particles::of_state ? " flow of each sub-step, in working columns\n" : " step\n";
  if (contacts != 0) words += "             moving surfaces are tested in their own frame, a register of particles at a time\n";
  return words;
}

// The size of the grids of meshes, and the cost of their cells. Flows share them.
template <class T>
std::string describe_meshes(const CompiledScene<T>& compiled) {
  std::string words;
  for (std::size_t i = 0; i < compiled.shapes.size(); ++i) {
    if (compiled.shapes[i] == nullptr || compiled.shapes[i]->values.empty()) continue;
    const Solid<T>& solid = compiled.shapes[i]->solid;
    const double cell{solid.cell};
    words += (words.empty() ? "meshes       " : "             ") + ("contacts[" + std::to_string(i) + "]: ");
    for (std::size_t k = 0; k < 3; ++k) words += (k == 0 ? "" : " x ") + std::to_string(solid.nodes[k]);
    words += " nodes, " + std::to_string(compiled.shapes[i]->values.size() * sizeof(T)) + " bytes, cells of " + text(cell, 3) +
             " m: edges are rounded by up to " + text(cell / 2, 3) +
             " m, corners by twice that; a face that curves with the radius R is up to " + text(cell * cell / 4, 3) +
             " m^2/R off, its normal " + text(cell, 3) + " m/R\n";
  }
  return words;
}

// At which speeds surfaces push out what is inside: the slowest and the fastest.
std::string describe_push_out(const Scene& scene, double step) {
  std::vector<double> speeds;
  for (const Contact& contact : scene.contacts) {
    const auto& speed = push_out_of(contact);
    if (speed) speeds.push_back(*speed);
  }
  if (speeds.empty()) return {};
  const auto [least, most] = std::minmax_element(speeds.begin(), speeds.end());
  const bool are_alike = *least == *most;
  return "push_out     " + std::to_string(speeds.size()) + " of " + std::to_string(scene.contacts.size()) + " surfaces, by " +
         text(*least, 3) + (are_alike ? "" : " to " + text(*most, 3)) + " m/s: " + text(*least * step, 3) +
         (are_alike ? "" : " to " + text(*most * step, 3)) + " m a step; blocks look for those near them\n";
}

template <class T>
std::string explain(const CompiledScene<T>& compiled, std::size_t workspace_bytes) {
  const Scene& scene = compiled.scene;
  const JoinedMotion<T>* joined = compiled.joined();
  // Joined particles take the flow before the first pulse.
  const FreeMotion<T>& motion = joined != nullptr ? *joined->flows()[0] : *compiled.free();
  const System system(scene, compiled.start, compiled.options.step);
  const bool has_radial = !system.radial().empty();
  std::string words = "step         " + text(compiled.options.step, 6) + " s, ";
  words.append(name(compiled.options.rounding, sizeof(T) == 4)).append(", ").append(dvdx::name(compiled.options.arithmetic));
  words.append(" arithmetic, ").append(dvdx::name(compiled.isa));
  words += ", " + std::to_string(motion.kernels->lanes) + " lanes, blocks of " + std::to_string(motion.block) + " particles\n";
  words += describe_forces(scene, system);
  words += describe_origin(scene.origin);
  words += "passes       affine";
  if (!system.is_uniform()) words += ", rate (made once, kept while nothing changes)";
  if (has_radial) words += ", radial (" + std::to_string(system.radial().size()) + " springs)";
  if (!scene.contacts.empty()) {
    words += ", contact (" + std::to_string(scene.contacts.size()) + " surfaces, up to " +
             std::to_string(compiled.options.impacts) + " impacts a particle and step";
    words += motion.terms.searches ? "; a block looks for those near it)" : ")";
  }
  words += "\n" + describe_meshes(compiled) + describe_push_out(scene, compiled.options.step) + "flow         " +
           describe(motion.flow) + "\n";
  const int count = operations(motion.flow, motion.terms.rates.sources) * (system.kicks() != 0 ? 2 : 1);
  words += "cost         " + std::to_string(12 * sizeof(T)) + " bytes of state, " + std::to_string(motion.column_bytes()) +
           " of columns, and " + std::to_string(count) + " operations a particle-step";
  words += has_radial || !scene.contacts.empty() ? " before contacts and radial springs\n" : "\n";
  words += describe_accuracy(scene, system, compiled.options.impacts);
  words += describe_stability(compiled, system);
  words += describe_motions(scene, compiled.particles);
  if (joined != nullptr) {
    words += describe_network(joined->joints(), compiled, system, workspace_bytes) + describe_air(joined->joints(), compiled) +
             describe_constraints(joined->joints(), compiled.scene) + describe_balls(joined->joints(), compiled) +
             describe_meetings(joined->joints(), compiled, workspace_bytes) + describe_faces(*joined);
  }
  const bool is_seekable = joined == nullptr && scene.contacts.empty() && !has_radial && scene.fixed.empty();
  words += std::string("seek         ") + (is_seekable ? "yes: any number of steps by matrix power\n" : "no: not affine\n");
  return words;
}

}  // namespace

template <class T>
std::string Plan<T>::explain() const {
  if (parts_ == nullptr) return "moved from\n";
  const auto words = [](const auto& in) {
    const auto* const joined = in.scene->joined();
    return dvdx::explain(*in.scene, joined != nullptr ? in.workspace->bytes_for(joined->joints().fixed.size()) : 0);
  };
  return std::visit(words, parts_->in);
}

template std::string Plan<float>::explain() const;
template std::string Plan<double>::explain() const;

}  // namespace dvdx
