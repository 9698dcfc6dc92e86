// Plans by C: a handle that holds a plan of either precision, in the caller's memory.
#include <array>
#include <bit>
#include <cstdint>
#include <new>
#include <string>
#include <utility>
#include <variant>

#include "c_api/guard.hpp"
#include "c_api/scene.hpp"
#include "dvdx/build_info.hpp"
#include "dvdx/layouts/state_hash.hpp"

struct dvdx_plan {
  std::variant<dvdx::Plan<float>, dvdx::Plan<double>> plan;
  dvdx::Memory memory;
};

namespace dvdx::c_api {
namespace {

constexpr int precisions = 2, isas = 6, arithmetics = 2, roundings = 2;

template <class T>
constexpr dvdx_precision precision_of = sizeof(T) == sizeof(float) ? DVDX_FLOAT32 : DVDX_FLOAT64;

template <class T>
Column<T> column(const dvdx_column& from) noexcept {
  const std::size_t run = from.run == 0 ? Column<T>::contiguous : from.run;
  return {.base = static_cast<T*>(from.base), .stride = from.stride, .run = run, .capacity = from.capacity};
}

template <class T>
State<T> view(const dvdx_state& from) noexcept {
  State<T> to{
      .x = {}, .v = {}, .count = from.count, .clock = {from.clock.seconds, from.clock.carry}, .x_rest = {}, .v_rest = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to.x[axis] = column<T>(from.x[axis]);
    to.v[axis] = column<T>(from.v[axis]);
    to.x_rest[axis] = column<T>(from.x_rest[axis]);
    to.v_rest[axis] = column<T>(from.v_rest[axis]);
  }
  return to;
}

void put_clock(const Clock& clock, dvdx_state& state) noexcept { state.clock = {clock.seconds, clock.carry}; }

// What no column may be, before anything reads it: a pointer to nothing, or numbers at odd places.
template <class T>
dvdx_status check_columns(const dvdx_state& state, dvdx_error* error) noexcept {
  constexpr std::array names = {"x[0]", "x[1]", "x[2]", "v[0]", "v[1]", "v[2]"};
  if (state.precision != precision_of<T>) return report(error, DVDX_PRECISION_DIFFERS);
  if (state.count == 0) return DVDX_DONE;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const dvdx_column& c = k < 3 ? state.x[k] : state.v[k - 3];
    const auto fail = [&](const char* value, const char* valid) { return report(error, DVDX_INVALID, names[k], value, valid); };
    if (c.base == nullptr) return fail("a null pointer", "memory of the caller's");
    if (reinterpret_cast<std::uintptr_t>(c.base) % alignof(T) != 0) return fail("not aligned", "aligned as its type");
    if (c.run == 0) continue;
    if (!std::has_single_bit(c.run)) return fail("no power of two long", "0, or elements side by side, a power of two");
    if (c.stride % static_cast<std::ptrdiff_t>(alignof(T)) != 0) return fail("of an odd stride", "aligned in each run");
  }
  return DVDX_DONE;
}

dvdx_status status_of(StepResult result) noexcept {
  switch (result) {
    case StepResult::done:
      return DVDX_DONE;
    case StepResult::count_differs:
      return DVDX_COUNT_DIFFERS;
    case StepResult::capacity_too_small:
      return DVDX_CAPACITY_TOO_SMALL;
    case StepResult::in_use:
      return DVDX_IN_USE;
  }
  return DVDX_FAILED;
}

Options options_of(const dvdx_options& from) {
  Options to;
  to.step = from.step;
  const auto isa = choice<dvdx_isa>(from.isa, isas, "isa");
  if (isa != DVDX_ISA_BEST) to.isa = static_cast<Isa>(static_cast<int>(isa) - 1);
  to.arithmetic = choice<Arithmetic>(from.arithmetic, arithmetics, "arithmetic");
  to.block = from.block;
  to.rounding = choice<Rounding>(from.rounding, roundings, "rounding");
  if (from.impacts != 0) to.impacts = from.impacts;
  to.memory = {.allocate = from.allocator.allocate, .release = from.allocator.release, .context = from.allocator.context};
  return to;
}

void destroy(dvdx_plan* plan) noexcept {
  const Memory memory = plan->memory;
  plan->~dvdx_plan();
  release(memory, plan, sizeof(dvdx_plan), alignof(dvdx_plan));
}

template <class T>
dvdx_status create(const Scene& scene, const Options& options, const dvdx_state* start, dvdx_plan** plan, dvdx_error* error) {
  if (start != nullptr) {
    if (const dvdx_status status = check_columns<T>(*start, error); status != DVDX_DONE) return status;
  }
  auto made = start == nullptr ? compile<T>(scene, options) : compile<T>(scene, options, view<T>(*start));
  if (!made) return report(error, made.error());
  void* const place = allocate(options.memory, sizeof(dvdx_plan), alignof(dvdx_plan));
  *plan = new (place) dvdx_plan{std::move(*made), options.memory};
  return report(error, DVDX_DONE);
}

template <class T>
dvdx_status step(const Plan<T>& plan, dvdx_state& state, std::size_t steps, const dvdx_parallel* parallel,
                 dvdx_error* error) noexcept {
  if (const dvdx_status status = check_columns<T>(state, error); status != DVDX_DONE) return status;
  State<T> particles = view<T>(state);
  const ParallelFor threads = parallel == nullptr ? ParallelFor{} : ParallelFor{parallel->run, parallel->context};
  const StepResult result = plan.step(particles, steps, threads);
  if (result == StepResult::done) put_clock(particles.clock, state);
  return report(error, status_of(result));
}

template <class T>
dvdx_status seek(const Plan<T>& plan, dvdx_state& state, std::uint64_t steps, dvdx_error* error) {
  if (const dvdx_status status = check_columns<T>(state, error); status != DVDX_DONE) return status;
  State<T> particles = view<T>(state);
  const auto result = plan.seek(particles, steps);
  if (result) put_clock(particles.clock, state);
  return done_or(error, result);
}

}  // namespace
}  // namespace dvdx::c_api

using namespace dvdx::c_api;

dvdx_status dvdx_plan_create(const dvdx_scene* scene, const dvdx_options* options, const dvdx_state* start, dvdx_plan** plan,
                             dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  *plan = nullptr;
  if (scene == nullptr) return missing(error, "scene");
  if (options == nullptr) return missing(error, "options");
  return guarded(error, [&] {
    const dvdx::Options chosen = options_of(*options);
    if (choice<dvdx_precision>(options->precision, precisions, "precision") == DVDX_FLOAT32) {
      return create<float>(scene->scene, chosen, start, plan, error);
    }
    return create<double>(scene->scene, chosen, start, plan, error);
  });
}

void dvdx_plan_destroy(dvdx_plan* plan) {
  if (plan != nullptr) destroy(plan);
}

dvdx_status dvdx_plan_step(const dvdx_plan* plan, dvdx_state* state, size_t steps, const dvdx_parallel* parallel,
                           dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  return std::visit([&](const auto& p) { return step(p, *state, steps, parallel, error); }, plan->plan);
}

dvdx_status dvdx_plan_seek(const dvdx_plan* plan, dvdx_state* state, uint64_t steps, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  return guarded(error, [&] { return std::visit([&](const auto& p) { return seek(p, *state, steps, error); }, plan->plan); });
}

dvdx_status dvdx_plan_set_step(dvdx_plan* plan, double h, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] { return std::visit([&](auto& p) { return done_or(error, p.set_step(h)); }, plan->plan); });
}

dvdx_status dvdx_plan_replace(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (scene == nullptr) return missing(error, "scene");
  return guarded(error, [&] {
    const auto& forces = scene->scene.forces;
    if (from >= forces.size()) {
      throw dvdx::Error{"from", std::to_string(from), "below the scene's " + std::to_string(forces.size()) + " forces"};
    }
    return std::visit([&](auto& p) { return done_or(error, p.replace(index, forces[from])); }, plan->plan);
  });
}

double dvdx_plan_step_size(const dvdx_plan* plan) {
  return std::visit([](const auto& p) { return p.step_size(); }, plan->plan);
}

dvdx_isa dvdx_plan_isa(const dvdx_plan* plan) {
  return std::visit([](const auto& p) { return static_cast<dvdx_isa>(static_cast<int>(p.isa()) + 1); }, plan->plan);
}

dvdx_precision dvdx_plan_precision(const dvdx_plan* plan) { return plan->plan.index() == 0 ? DVDX_FLOAT32 : DVDX_FLOAT64; }

int dvdx_plan_network_limit(const dvdx_plan* plan, dvdx_network_limit* limit) {
  const auto found = std::visit([](const auto& p) { return p.network_limit(); }, plan->plan);
  if (!found) return 0;
  *limit = {.substeps = found->substeps,
            .frequency = found->frequency,
            .bound = found->bound,
            .limit = found->limit,
            .fewest = found->fewest,
            .safe = found->safe,
            .particle = found->particle};
  return 1;
}

size_t dvdx_plan_explain(const dvdx_plan* plan, char* text, size_t capacity) {
  std::size_t length = copy_text("", text, capacity);
  (void)guarded(nullptr, [&] {
    length = copy_text(std::visit([](const auto& p) { return p.explain(); }, plan->plan), text, capacity);
    return DVDX_DONE;
  });
  return length;
}

size_t dvdx_build_info(char* text, size_t capacity) {
  std::size_t length = copy_text("", text, capacity);
  (void)guarded(nullptr, [&] {
    length = copy_text(dvdx::build_info().text(), text, capacity);
    return DVDX_DONE;
  });
  return length;
}

const char* dvdx_version(void) { return DVDX_VERSION; }
int dvdx_abi_version(void) { return DVDX_ABI_VERSION; }

dvdx_state dvdx_soa(dvdx_precision precision, void* x, void* y, void* z, void* vx, void* vy, void* vz, size_t count) {
  const auto all = [count](void* base) { return dvdx_column{base, 0, 0, count}; };
  return {precision, {all(x), all(y), all(z)}, {all(vx), all(vy), all(vz)}, count, {0, 0}, {}, {}};
}

dvdx_state dvdx_aos(dvdx_precision precision, void* first_position, void* first_velocity, size_t struct_bytes, size_t count) {
  const std::size_t size = precision == DVDX_FLOAT64 ? sizeof(double) : sizeof(float);
  const auto field = [&](void* first, std::size_t axis) {
    void* const base = first == nullptr ? nullptr : static_cast<char*>(first) + axis * size;
    return dvdx_column{base, static_cast<std::ptrdiff_t>(struct_bytes), 1, count};
  };
  dvdx_state state = {precision, {}, {}, count, {0, 0}, {}, {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x[axis] = field(first_position, axis);
    state.v[axis] = field(first_velocity, axis);
  }
  return state;
}

uint64_t dvdx_state_hash(const dvdx_state* state) {
  return state->precision == DVDX_FLOAT64 ? dvdx::state_hash(view<double>(*state)) : dvdx::state_hash(view<float>(*state));
}
