#include "dvdx/plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "compile/free_motion.hpp"
#include "compile/joined_motion.hpp"
#include "compile/range.hpp"
#include "compile/validate.hpp"
#include "execute/environment.hpp"
#include "text.hpp"

namespace dvdx {
namespace {

std::string list(const std::vector<Isa>& isas) {
  std::string text;
  for (const Isa isa : isas) text += (text.empty() ? "" : ", ") + std::string(name(isa));
  return text;
}

bool is_at_start(const Force& force) {
  const auto is_start = [](const auto& f) {
    if constexpr (requires { f.anchor; }) return std::holds_alternative<AtStart>(f.anchor);
    return false;
  };
  return std::visit(is_start, force);
}

bool has_values_each(const Scene& scene) {
  const auto each = [](const auto& f) {
    bool is_each = false;
    if constexpr (requires { f.anchor; }) is_each = is_each || !std::holds_alternative<Vec3>(f.anchor);
    if constexpr (requires { f.stiffness; }) is_each = is_each || !f.stiffness.is_uniform();
    if constexpr (requires { f.coefficient; }) is_each = is_each || !f.coefficient.is_uniform();
    if constexpr (requires { f.rest_length; }) is_each = is_each || !f.rest_length.is_uniform();
    return is_each;
  };
  return !scene.mass.is_uniform() || scene.origin.is_each() ||
         std::any_of(scene.forces.begin(), scene.forces.end(), [&](const Force& f) { return std::visit(each, f); });
}

template <class T>
bool is_finite(const T* column, std::size_t count) {
  return column == nullptr || std::all_of(column, column + count, [](T k) { return std::isfinite(k); });
}

template <class T>
bool has_finite_columns(const Program<T>& program) {
  const auto& rates = program.terms.rates;
  const std::size_t count = program.count.value_or(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const auto* columns : {&rates.A, &rates.B, &rates.C, &rates.S, &rates.sign, &rates.t1, &rates.s, &rates.t2}) {
      if (!is_finite((*columns)[axis], count)) return false;
    }
    for (std::size_t k = 0; k < rates.sources; ++k) {
      if (!is_finite(rates.gain_v[k][axis], count) || !is_finite(rates.gain_x[k][axis], count)) return false;
    }
  }
  return true;
}

// Coefficients that overflow would step to nonsense, silently.
template <class T>
std::optional<Error> check_coefficients(const Program<T>& program) {
  const auto is_fit = [](const FusedAxis<T>& k) {
    return std::isfinite(k.A) && std::isfinite(k.B) && std::isfinite(k.C) && std::isfinite(k.S);
  };
  const auto& fused = program.terms.fused;
  const bool has_anchor = is_finite(program.terms.anchor.data(), program.terms.anchor.size());
  if (has_anchor && std::all_of(fused.begin(), fused.end(), is_fit) && has_finite_columns(program)) return std::nullopt;
  return Error{"step", text(program.options.step), "a step at which this method's coefficients stay finite"};
}

std::optional<Error> check_sources(const System& system) {
  const auto& sources = system.sources();
  const auto apart = std::count_if(sources.begin(), sources.end(), [](const Source& s) { return !s.is_alike(); });
  if (system.is_uniform() || static_cast<std::size_t>(apart) <= max_sources) return std::nullopt;
  return Error{"forces", std::to_string(apart) + " accelerations that act differently on each particle",
               "at most " + std::to_string(max_sources) + " (a sinusoid counts two, a polynomial one a term, a wind one)"};
}

// Radial springs without a rest length pull alike in every direction: they are linear, and exact as such. (Their damping is
// not: it brakes along the line alone.)
Scene with_linear_springs(Scene scene) {
  for (Force& force : scene.forces) {
    const auto* radial = std::get_if<RadialSpring>(&force);
    if (radial == nullptr || radial->damping != 0 || radial->rest_length != Scalars(0.0)) continue;
    force = Spring{.stiffness = radial->stiffness, .damping = 0, .anchor = radial->anchor, .method = radial->method};
  }
  return scene;
}

// The program of a scene that has been checked, but for what joins its particles.
template <class T>
Expected<std::unique_ptr<Program<T>>> build_alone(Scene given, const Options& options, Isa isa,
                                                  std::optional<std::size_t> count, std::vector<Vec3> start) {
  Scene scene = with_linear_springs(std::move(given));
  if (auto error = check_sources(System(scene, start, options.step))) return tl::unexpected(*error);
  if (auto error = check_range<T>(scene, options, count, start)) return tl::unexpected(*error);
  auto program = std::make_unique<Program<T>>(std::move(scene), options, isa, count, std::move(start));
  if (auto error = check_coefficients(*program)) return tl::unexpected(*error);
  return program;
}

template <class T>
std::optional<Error> add_network(Program<T>& program) {
  if (!joins_particles(program.scene)) return std::nullopt;
  program.network = std::make_unique<NetworkProgram<T>>(program.scene, program.options, program.isa, program.start);
  return program.network->refusal(program.options.unstable);
}

template <class T>
Expected<std::unique_ptr<Program<T>>> build(Scene scene, const Options& options, Isa isa, std::optional<std::size_t> count,
                                            std::vector<Vec3> start) {
  auto program = build_alone<T>(std::move(scene), options, isa, count, std::move(start));
  if (!program) return program;
  if (auto error = add_network(**program)) return tl::unexpected(*error);
  return program;
}

template <class T>
std::optional<Error> check_rounding(const Options& options, const State<T>* state) {
  if (options.rounding == Rounding::plain) return std::nullopt;
  if (std::is_same_v<T, double>) return Error{"rounding", "compensated", "plain for float64 states"};
  if (state == nullptr || state->has_rests()) return std::nullopt;
  return Error{"state.x_rest", "absent", "columns for what float32 cannot hold, where rounding is compensated"};
}

template <class T>
std::vector<Vec3> positions(const State<T>& state, Rounding rounding) {
  std::vector<Vec3> start(state.count);
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      start[i][axis] = static_cast<double>(state.x[axis][i]);
      if (rounding == Rounding::compensated) start[i][axis] += static_cast<double>(state.x_rest[axis][i]);
    }
  }
  return start;
}

// A plan for states of T that is worked out in A.
template <class A, class T>
Expected<Plan<T>> make_in(const Scene& scene, const Options& options, const State<T>* state) {
  const auto count = state != nullptr ? std::optional(state->count) : std::nullopt;
  const Isa isa = options.isa.value_or(best_isa(options.arithmetic));
  if (find_kernels<A>(isa, options.arithmetic) == nullptr) {
    return tl::unexpected(Error{"isa", std::string(name(isa)),
                                "one of " + list(available_isas(options.arithmetic)) + " (with " +
                                    std::string(name(options.arithmetic)) + " arithmetic on this machine)"});
  }
  std::vector<Vec3> start;
  if (stands_at_start(scene) || joins_particles(scene)) start = positions(*state, options.rounding);
  const bool is_counted = has_values_each(scene) || joins_particles(scene);
  auto program = build<A>(scene, options, isa, is_counted ? count : std::nullopt, std::move(start));
  if (!program) return tl::unexpected(program.error());
  return Plan<T>(std::move(*program));
}

template <class T>
Expected<Plan<T>> make(const Scene& scene, const Options& options, const State<T>* state) {
  const StepEnvironment environment;  // coefficients do not depend on the caller's rounding mode either
  if (auto error = check(options)) return tl::unexpected(*error);
  if (auto error = check_rounding(options, state)) return tl::unexpected(*error);
  if (auto error = check(scene, state != nullptr ? std::optional(state->count) : std::nullopt)) return tl::unexpected(*error);
  if (options.rounding == Rounding::compensated) return make_in<double>(scene, options, state);
  return make_in<T>(scene, options, state);
}

template <class A>
Expected<void> change_step(std::unique_ptr<Program<A>>& program, double h) {
  Options options = program->options;
  options.step = h;
  if (auto error = check(options)) return tl::unexpected(*error);
  if (program->network) {  // another number of sub-steps, perhaps, and other flows between them
    auto changed = build<A>(program->scene, options, program->isa, program->count, program->start);
    if (!changed) return tl::unexpected(changed.error());
    program = std::move(*changed);
    return {};
  }
  if (auto error = check_range<A>(program->scene, options, program->count, program->start)) return tl::unexpected(*error);
  const double before = std::exchange(program->options.step, h);
  program->make_coefficients();
  const auto error = check_coefficients(*program);
  if (!error) return {};
  program->options.step = before;
  program->make_coefficients();
  return tl::unexpected(*error);
}

template <class A>
Expected<void> change_force(std::unique_ptr<Program<A>>& program, std::size_t index, const Force& force) {
  if (index >= program->scene.forces.size()) {
    return tl::unexpected(Error{"forces[" + std::to_string(index) + "]", "no force",
                                "an index below " + std::to_string(program->scene.forces.size())});
  }
  Scene scene = program->scene;
  scene.forces[index] = force;
  if (auto error = check(scene, program->count)) return tl::unexpected(*error);
  if (is_at_start(force) && program->start.empty()) {
    return tl::unexpected(
        Error{"forces[" + std::to_string(index) + "].anchor", "at_start", "given, or at the start from the first"});
  }
  auto changed = build_alone<A>(std::move(scene), program->options, program->isa, program->count, program->start);
  if (!changed) return tl::unexpected(changed.error());
  Program<A>& after = **changed;
  // A gust each frame must not look for the springs' frequency again.
  const bool keeps_springs =
      program->network && program->network->replace_forces(after.scene, after.options, after.isa, after.start);
  if (keeps_springs) {
    after.network = std::move(program->network);
  } else if (auto error = add_network(after)) {
    return tl::unexpected(*error);
  }
  program = std::move(*changed);
  return {};
}

}  // namespace

bool joins_particles(const Scene& scene) { return !scene.networks.empty() || !scene.constraints.empty(); }

bool stands_at_start(const Scene& scene) { return std::any_of(scene.forces.begin(), scene.forces.end(), is_at_start); }

template <class T>
Plan<T>::Plan(AnyProgram program) noexcept : program_(std::move(program)) {}
template <class T>
Plan<T>::Plan(Plan&&) noexcept = default;
template <class T>
Plan<T>& Plan<T>::operator=(Plan&&) noexcept = default;
template <class T>
Plan<T>::~Plan() = default;

template <class T>
Expected<void> Plan<T>::set_step(double h) {
  const StepEnvironment environment;
  return std::visit([h](auto& program) { return change_step(program, h); }, program_);
}

template <class T>
Expected<void> Plan<T>::replace(std::size_t index, const Force& force) {
  const StepEnvironment environment;
  return std::visit([&](auto& program) { return change_force(program, index, force); }, program_);
}

template <class T>
const Scene& Plan<T>::scene() const noexcept {
  return std::visit([](const auto& program) -> const Scene& { return program->scene; }, program_);
}
template <class T>
double Plan<T>::step_size() const noexcept {
  return std::visit([](const auto& program) { return program->options.step; }, program_);
}
template <class T>
Isa Plan<T>::isa() const noexcept {
  return std::visit([](const auto& program) { return program->isa; }, program_);
}
template <class T>
Arithmetic Plan<T>::arithmetic() const noexcept {
  return std::visit([](const auto& program) { return program->options.arithmetic; }, program_);
}
template <class T>
Rounding Plan<T>::rounding() const noexcept {
  return std::visit([](const auto& program) { return program->options.rounding; }, program_);
}
template <class T>
std::size_t Plan<T>::block() const noexcept {
  return std::visit([](const auto& program) { return program->block; }, program_);
}

template <class T>
std::optional<NetworkLimit> Plan<T>::network_limit() const {
  const auto limit = [](const auto& program) -> std::optional<NetworkLimit> {
    if (!program->network) return std::nullopt;
    return program->network->limit();
  };
  return std::visit(limit, program_);
}

template <class T>
Expected<Plan<T>> compile(const Scene& scene, const Options& options) {
  return make<T>(scene, options, nullptr);
}
template <class T>
Expected<Plan<T>> compile(const Scene& scene, const Options& options, const State<T>& start) {
  return make<T>(scene, options, &start);
}

template class Plan<float>;
template class Plan<double>;
template Expected<Plan<float>> compile<float>(const Scene&, const Options&);
template Expected<Plan<double>> compile<double>(const Scene&, const Options&);
template Expected<Plan<float>> compile<float>(const Scene&, const Options&, const State<float>&);
template Expected<Plan<double>> compile<double>(const Scene&, const Options&, const State<double>&);

}  // namespace dvdx
