// The plan in words.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "dvdx/fields.hpp"
#include "forces/radial_spring.hpp"
#include "math/elementary.hpp"
#include "math/vec3.hpp"
#include "plan/explain_joined.hpp"
#include "plan/plan_parts.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"
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

// Assumes that all radial springs act along this axis near their rest lengths, where their sum is stiffest.
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

// The number of steps after which an amplitude that grows by `radius` a step has doubled: 1 / log2(radius). With radius = 2^e
// m, log2 m = y / ln 2, and y = ln m by Newton's method of third order on e^y (the kernel calls no transcendental function of
// the math library: tests/check_math_library.cmake).
double doubling_steps(double radius) {
  int exponent = 0;
  double m = std::frexp(radius, &exponent);
  if (m < 0.75) {  // so that nothing cancels for a radius just above one
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

// The largest step without growth between h/1000 and h; 0 if there is none. Growth at a stability limit sets in at once.
// Growth with a power of the step (several exact springs: its cube) occurs at every step, however small.
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
      names += (names.empty() ? "" : ", ") +
               ("forces[" + std::to_string(i) + "] " + std::string(type_words<Force>[scene.forces[i].index()]));
    }
    return names;
  };
  if (!system.combined().empty()) text += "combined     as one exact system: " + list(system.combined()) + "\n";
  for (std::size_t i = 0; i < scene.forces.size(); ++i) {
    const auto& combined = system.combined();
    if (std::find(combined.begin(), combined.end(), i) != combined.end()) continue;
    const bool is_kick = std::holds_alternative<RadialSpring>(scene.forces[i]) && system.method(i) == Method::combined;
    text += "alone        forces[" + std::to_string(i) + "] " + std::string(type_words<Force>[scene.forces[i].index()]) +
            " by " + (is_kick ? "a kick at the middle of the step" : std::string(word(system.method(i)))) + "\n";
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

// The highest frequency of a radial spring, and the sum of all kicks. A kick of h kappa alone is stable up to 4.
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

// The size of the grids of meshes, and the cost of their cells. Flows share the grids.
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

// The slowest and the fastest speed at which surfaces push particles out.
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
  // For joined particles: the flow before the first pulse.
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
  if (joined != nullptr) words += explain_joined(compiled, system, workspace_bytes);
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
    return dvdx::explain(*in.scene, joined != nullptr ? in.workspace->bytes_for(joined->network().fixed.size()) : 0);
  };
  return std::visit(words, parts_->in);
}

template std::string Plan<float>::explain() const;
template std::string Plan<double>::explain() const;

}  // namespace dvdx
