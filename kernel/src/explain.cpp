// The plan in words.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "compile/free_motion.hpp"
#include "compile/joined_motion.hpp"
#include "math/elementary.hpp"

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
  return names[force.index()];
}

template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), pattern, values...);
  return line.data();
}

// Spectral radius of the step's matrix [[1-C, S], [-A, 1-B]].
double spectral_radius(const AxisMotion& k) {
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
Worst worst(const System& system, std::size_t particles) {
  Worst found;
  for (std::size_t i = 0; i < particles; ++i) {
    for (std::size_t axis = 0; axis < (system.is_isotropic() ? 1 : 3); ++axis) {
      const double radius = spectral_radius(system.motion(axis, i));
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

// The largest step that does not grow, between h and a thousandth of it; 0 where even that one does.
double stable_step(const Scene& scene, std::span<const Vec3> start, Worst at, double h) {
  const auto is_stable = [&](double step) {
    return spectral_radius(System(scene, start, step).motion(at.axis, at.particle)) <= 1 + rounding;
  };
  double low = h / 1000;
  if (!is_stable(low)) return 0;
  double high = h;
  for (int i = 0; i < 40; ++i) (is_stable((low + high) / 2) ? low : high) = (low + high) / 2;
  return low;
}

template <class T>
std::string describe_forces(const Program<T>& program) {
  std::string text;
  const auto list = [&](const std::vector<std::size_t>& forces) {
    std::string names;
    for (const std::size_t i : forces) {
      names +=
          (names.empty() ? "" : ", ") + ("forces[" + std::to_string(i) + "] " + std::string(kind(program.scene.forces[i])));
    }
    return names;
  };
  const System& system = program.system;
  if (!system.combined().empty()) text += "combined     as one exact system: " + list(system.combined()) + "\n";
  for (std::size_t i = 0; i < program.scene.forces.size(); ++i) {
    const auto& combined = system.combined();
    if (std::find(combined.begin(), combined.end(), i) != combined.end()) continue;
    const bool is_kick = std::holds_alternative<RadialSpring>(program.scene.forces[i]) && system.method(i) == Method::combined;
    text += "alone        forces[" + std::to_string(i) + "] " + std::string(kind(program.scene.forces[i])) + " by " +
            (is_kick ? "a kick at the middle of the step" : std::string(name(system.method(i)))) + "\n";
  }
  return text;
}

template <class T>
std::string describe_stability(const Program<T>& program) {
  const System& system = program.system;
  const double h = program.options.step;
  if (system.is_one_system()) return "stability    exact for any step\n";
  const Worst at = worst(system, system.is_uniform() ? 1 : *program.count);
  std::string text = format("stability    spectral radius %.12g at this step of %g s", at.radius, h);
  if (at.radius <= 1 + rounding) return text + ": stable\n";
  text += format(": UNSTABLE, amplitude doubles every %.3g steps", doubling_steps(at.radius));
  if (!system.is_uniform()) text += format(" (particle %zu)", at.particle);
  const double limit = stable_step(program.scene, program.start, at, h);
  text +=
      limit > 0
          ? format("\n             what to do: a step of at most %.6g s, or method combined\n", limit)
          : "\n             what to do: no smaller step cures it (the separate contributions add energy); method combined is "
            "exact\n";
  return text;
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
  }
  return "";
}

template <class T>
std::string describe_form(const NetworkProgram<T>& network) {
  using Form = typename NetworkProgram<T>::Form;
  switch (network.form()) {
    case Form::grid:
      return "as a grid: each spring once, no index loaded";
    case Form::graph:
      return "as a graph: each particle sums its own";
    case Form::pairs:
      return "as a graph: each particle sums its pairs' own contributions";
    case Form::strands:
      return "as a grid in sweeps, in bands of rows";
    case Form::colours:
      return "as a graph in sweeps of " + std::to_string(network.colours()) + " colours";
  }
  return "";
}

// What the other schemes would take for the same springs and step.
template <class T>
std::string describe_other_schemes(const NetworkProgram<T>& network) {
  std::string text;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
    if (network.coupling().scheme == scheme) continue;
    const int substeps = network.safe_substeps({.scheme = scheme});
    const std::int64_t pulses = scheme == Scheme::fourth_order ? 6 : 1;
    text += format("             %s would take %d sub-steps, %lld pulses a step\n", std::string(name(scheme)).c_str(), substeps,
                   static_cast<long long>(substeps * pulses));
  }
  if (network.coupling().scheme != Scheme::sequential) {
    text += "             sequential would take any number of sub-steps, 2 sweeps each (a sweep costs about 2 pulses)\n";
  }
  return text;
}

template <class T>
std::string describe_network(const NetworkProgram<T>& network) {
  if (network.springs() == 0) return "";
  const NetworkLimit& limit = network.limit();
  const Coupling& coupling = network.coupling();
  std::string text = format("springs      %zu, %s; %zu bytes of working memory\n", network.springs(),
                            describe_form(network).c_str(), network.bytes());
  text += format("scheme       %s, %d sub-steps a step", std::string(name(coupling.scheme)).c_str(), limit.substeps);
  if (coupling.scheme == Scheme::sequential) {
    text += format(", theta %g, %s", coupling.theta, coupling.sweeps == Sweeps::symmetric ? "forward and backward" : "forward");
  }
  text += coupling.substeps ? " (asked for)\n" : " (chosen)\n";
  text += format("frequency    %.6g rad/s at the start, at most %.6g in any position (the springs of particle %u)\n",
                 limit.frequency, limit.bound, limit.particle);
  const double h = std::abs(network.step_size()) / limit.substeps;
  if (std::isinf(limit.limit)) {
    text +=
        "             stable at any sub-step where the springs are linear; position errors grow with frequency x sub-step, ";
    text += format("here %.3g\n", limit.frequency * h);
  } else {
    const double margin = limit.limit / (limit.bound * h) - 1;
    text += format("             frequency x sub-step is %.3g at the start and at most %.3g; the scheme takes %.3g: ",
                   limit.frequency * h, limit.bound * h, limit.limit);
    text += margin >= -1e-9 ? format("a margin of %.0f %%\n", 100 * std::max(0.0, margin))
                            : format("MAY GROW where the springs fold onto one line; %d sub-steps are safe\n", limit.safe);
  }
  if (coupling.scheme == Scheme::accumulate && coupling.method == Method::exact) {
    text += "             exact contributions of springs that share particles gain energy at every step\n";
  }
  return text + describe_other_schemes(network);
}

template <class T>
std::string describe_constraints(const NetworkProgram<T>& network) {
  const ConstraintProgram<T>* constraints = network.constraints();
  if (constraints == nullptr) return "";
  const NetworkLimit& limit = network.limit();
  std::string text = format("constraints  %zu in %zu colours", constraints->constraints(), constraints->colours());
  if (constraints->chains() != 0) text += format(", %zu chains solved whole", constraints->chains());
  text += format("; %d sweeps over them in each of %d sub-steps; %zu bytes\n", constraints->sweeps(), limit.substeps,
                 constraints->bytes());
  if (constraints->sweeps() > 1) {
    text +=
        "             those that share particles are solved one after the other: more sub-steps bring them nearer than more "
        "sweeps\n";
  }
  return text;
}

std::string_view name(Rounding how, bool is_float32) {
  if (how == Rounding::compensated) return "float32 compensated (worked out in float64)";
  return is_float32 ? "float32" : "float64";
}

std::string describe_origin(const Origin& origin) {
  if (origin.is_world()) return "";
  if (origin.is_each()) return "origin       one for each particle\n";
  const Vec3& o = origin.at(0);
  return format("origin       [%g, %g, %g] m\n", o[0], o[1], o[2]);
}

template <class T>
std::string explain(const Program<T>& program) {
  const System& system = program.system;
  const bool has_radial = !system.radial().empty();
  std::string text =
      format("step         %g s, %s, %s arithmetic, %s", program.options.step,
             std::string(name(program.options.rounding, sizeof(T) == 4)).c_str(),
             std::string(dvdx::name(program.options.arithmetic)).c_str(), std::string(dvdx::name(program.isa)).c_str());
  text += format(", %zu lanes, blocks of %zu particles\n", program.kernels->lanes, program.block);
  text += describe_forces(program);
  text += describe_origin(program.scene.origin);
  text += "passes       affine";
  if (!system.is_uniform()) text += ", rate (made once, kept while nothing changes)";
  if (has_radial) text += ", radial (" + std::to_string(system.radial().size()) + " springs)";
  if (!program.scene.contacts.empty()) {
    text += ", contact (" + std::to_string(program.scene.contacts.size()) + " surfaces, up to " +
            std::to_string(program.options.impacts) + " impacts a particle and step)";
  }
  text += "\nflow         " + describe(program.flow) + "\n";
  const int count = operations(program.flow, program.terms.rates.sources) * (system.kicks() != 0 ? 2 : 1);
  text += format("cost         %zu bytes of state, %zu of columns, and %d operations a particle-step", 12 * sizeof(T),
                 program.column_bytes(), count);
  text += has_radial || !program.scene.contacts.empty() ? " before contacts and radial springs\n" : "\n";
  text += describe_stability(program);
  if (program.network) text += describe_network(*program.network) + describe_constraints(*program.network);
  const bool is_seekable = !program.network && program.scene.contacts.empty() && !has_radial && program.scene.fixed.empty();
  text += std::string("seek         ") + (is_seekable ? "yes: any number of steps by matrix power\n" : "no: not affine\n");
  return text;
}

}  // namespace

template <class T>
std::string Plan<T>::explain() const {
  return std::visit([](const auto& program) { return dvdx::explain(*program); }, program_);
}

template std::string Plan<float>::explain() const;
template std::string Plan<double>::explain() const;

}  // namespace dvdx
