// Plans by C: a handle that holds a plan of either precision, in the caller's memory.
#include "c_api/plan.hpp"

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "c_api/contact_report.hpp"
#include "c_api/convert.hpp"
#include "c_api/drive.hpp"
#include "c_api/guard.hpp"
#include "c_api/scene.hpp"
#include "dvdx/build_info.hpp"
#include "dvdx/layouts/state_hash.hpp"

namespace dvdx::c_api {
namespace {

template <class T>
dvdx_status create(const Scene& scene, const Options& options, const dvdx_state* start, dvdx_plan** plan, dvdx_error* error) {
  if (start != nullptr) {
    if (const dvdx_status status = check_columns<T>(*start, start->count, error); status != DVDX_DONE) return status;
  }
  auto made = start == nullptr ? compile<T>(scene, options) : compile<T>(scene, options, view<T>(*start));
  if (!made) return report(error, made.error());
  *plan = make_handle<dvdx_plan>(std::move(*made), options.memory);
  return report(error, DVDX_DONE);
}

// contacts: receives what contacts do, or null.
template <class T>
dvdx_status step(const Plan<T>& plan, dvdx_state& state, std::size_t steps, const dvdx_parallel* parallel,
                 ContactReport* contacts, dvdx_error* error) noexcept {
  if (const dvdx_status status = check_columns<T>(state, state.count, error); status != DVDX_DONE) return status;
  State<T> particles = view<T>(state);
  const StepResult result = contacts != nullptr ? plan.step(particles, *contacts, steps, threads_of(parallel))
                                                : plan.step(particles, steps, threads_of(parallel));
  if (result == StepResult::done) put_clock(particles.clock, state);
  return report(error, result, state.clock);
}

template <class T>
dvdx_status seek(const Plan<T>& plan, dvdx_state& state, std::uint64_t steps, dvdx_error* error) {
  if (const dvdx_status status = check_columns<T>(state, state.count, error); status != DVDX_DONE) return status;
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
    if (precision_of(*options) == DVDX_FLOAT32) {
      return create<float>(scene->scene, chosen, start, plan, error);
    }
    return create<double>(scene->scene, chosen, start, plan, error);
  });
}

dvdx_status dvdx_plan_clone(const dvdx_plan* plan, dvdx_plan** clone, dvdx_error* error) {
  if (clone == nullptr) return missing(error, "clone");
  *clone = nullptr;
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] {
    std::visit([&](const auto& p) { *clone = make_handle<dvdx_plan>(p.clone(), plan->memory); }, plan->plan);
    return report(error, DVDX_DONE);
  });
}

void dvdx_plan_destroy(dvdx_plan* plan) { destroy_handle(plan); }

dvdx_status dvdx_plan_scene(const dvdx_plan* plan, dvdx_scene** scene, dvdx_error* error) {
  if (scene == nullptr) return missing(error, "scene");
  *scene = nullptr;
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] {
    *scene = new dvdx_scene{std::visit([](const auto& p) { return p.scene(); }, plan->plan)};
    return report(error, DVDX_DONE);
  });
}

dvdx_status dvdx_plan_step(const dvdx_plan* plan, dvdx_state* state, size_t steps, const dvdx_parallel* parallel,
                           dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  return std::visit([&](const auto& p) { return step(p, *state, steps, parallel, nullptr, error); }, plan->plan);
}

dvdx_status dvdx_plan_step_and_report(const dvdx_plan* plan, dvdx_state* state, size_t steps, const dvdx_parallel* parallel,
                                      dvdx_contact_report* contacts, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  if (contacts == nullptr) return missing(error, "report");
  return std::visit([&](const auto& p) { return step(p, *state, steps, parallel, &contacts->report, error); }, plan->plan);
}

dvdx_status dvdx_plan_seek(const dvdx_plan* plan, dvdx_state* state, uint64_t steps, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  return guarded(error, [&] { return std::visit([&](const auto& p) { return seek(p, *state, steps, error); }, plan->plan); });
}

namespace {

// Calls change(the plan as C++ has it).
template <class Change>
dvdx_status apply_change(dvdx_plan* plan, dvdx_error* error, const Change& change) {
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] { return std::visit([&](auto& p) { return done_or(error, change(p)); }, plan->plan); });
}
auto changer(dvdx_plan* plan, dvdx_error* error) {
  return [=](const auto& change) { return apply_change(plan, error, change); };
}

// Replaces the plan's force or contact number `index` by number `from` of a scene's `list`.
template <class List>
dvdx_status replaced(dvdx_plan* plan, std::size_t index, const List& list, std::size_t from, const char* kind,
                     dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) {
    if (from >= list.size()) {
      throw dvdx::Error{"from", std::to_string(from), "below the scene's " + std::to_string(list.size()) + " " + kind};
    }
    if constexpr (std::is_same_v<typename List::value_type, dvdx::Force>) {
      return p.set_force(index, list[from]);
    } else {
      return p.set_contact(index, list[from]);
    }
  });
}

}  // namespace

dvdx_status dvdx_plan_set_step(dvdx_plan* plan, double h, dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) { return p.set_step(h); });
}

dvdx_status dvdx_plan_set_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                               dvdx_error* error) {
  return drive_pose(changer(plan, error), motion, translation, rotation, dvdx::Arrival::moving);
}
dvdx_status dvdx_plan_set_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count, dvdx_error* error) {
  return drive_places(changer(plan, error), kinematic, places, count, dvdx::Arrival::moving);
}
dvdx_status dvdx_plan_set_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals, size_t count,
                               dvdx_error* error) {
  return drive_skin(changer(plan, error), skin, points, normals, count, dvdx::Arrival::moving);
}
dvdx_status dvdx_plan_jump_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                                dvdx_error* error) {
  return drive_pose(changer(plan, error), motion, translation, rotation, dvdx::Arrival::jump);
}
dvdx_status dvdx_plan_jump_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count, dvdx_error* error) {
  return drive_places(changer(plan, error), kinematic, places, count, dvdx::Arrival::jump);
}
dvdx_status dvdx_plan_jump_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals, size_t count,
                                dvdx_error* error) {
  return drive_skin(changer(plan, error), skin, points, normals, count, dvdx::Arrival::jump);
}

void dvdx_plan_forget(dvdx_plan* plan) {
  if (plan == nullptr) return;
  std::visit([](auto& p) { p.forget(); }, plan->plan);
}

namespace {

// Calls use(the plan, the state) if the state has columns as the plan needs them.
template <class P, class Use>
dvdx_status with_state(P& plan, const dvdx_state& state, dvdx_error* error, const Use& use) {
  const auto of = [&]<class T>(const dvdx::Plan<T>& /*plan*/) -> dvdx_status {
    const dvdx_status status = check_columns<T>(state, state.count, error);
    return status != DVDX_DONE ? status : use(std::get<dvdx::Plan<T>>(plan.plan), view<T>(state));
  };
  return guarded(error, [&] { return std::visit(of, plan.plan); });
}

}  // namespace

dvdx_status dvdx_plan_teleport(dvdx_plan* plan, const dvdx_state* state, const double* translation, const double* rotation,
                               dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  if (translation == nullptr) return missing(error, "translation");
  return with_state(*plan, *state, error, [&](auto& p, auto particles) {
    return done_or(error, p.teleport(particles, pose_of(translation, rotation)));
  });
}

dvdx_status dvdx_plan_check(const dvdx_plan* plan, const dvdx_state* state, dvdx_state_check* check, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  if (check == nullptr) return missing(error, "check");
  return with_state(*plan, *state, error, [&](const auto& p, const auto& particles) {
    const dvdx::StateCheck found = p.check(particles);
    if (found.result != dvdx::StepResult::done) return report(error, found.result, state->clock);
    put_check(found, *check);
    return report(error, DVDX_DONE);
  });
}

dvdx_status dvdx_plan_carried(const dvdx_plan* plan, const dvdx_state* state, double* numbers, size_t capacity, size_t* count,
                              dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  if (count == nullptr) return missing(error, "count");
  if (numbers == nullptr && capacity != 0) return missing(error, "numbers");
  return with_state(*plan, *state, error, [&](const auto& p, const auto& particles) {
    return put_numbers(p.carried(particles), numbers, capacity, *count, error);
  });
}

dvdx_status dvdx_plan_restore(dvdx_plan* plan, const double* numbers, size_t count, const dvdx_state* state,
                              dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  return with_state(*plan, *state, error, [&](auto& p, const auto& particles) {
    need(numbers, count, "numbers");
    return done_or(error, p.restore(std::span(numbers, count), particles));
  });
}

dvdx_status dvdx_plan_replace(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (scene == nullptr) return missing(error, "scene");
  return replaced(plan, index, scene->scene.forces, from, "forces", error);
}

dvdx_status dvdx_plan_replace_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (scene == nullptr) return missing(error, "scene");
  return replaced(plan, index, scene->scene.contacts, from, "contacts", error);
}

dvdx_status dvdx_plan_set_force(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from, dvdx_error* error) {
  return dvdx_plan_replace(plan, index, scene, from, error);
}
dvdx_status dvdx_plan_set_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from, dvdx_error* error) {
  return dvdx_plan_replace_contact(plan, index, scene, from, error);
}

dvdx_status dvdx_plan_set_wind(dvdx_plan* plan, const dvdx_wind* wind, dvdx_error* error) {
  if (wind == nullptr) return missing(error, "wind");
  return apply_change(plan, error, [&](auto& p) { return p.set_wind(wind_of(*wind)); });
}

dvdx_status dvdx_plan_set_grid_stiffness(dvdx_plan* plan, size_t index, double structural, double shear, double bend,
                                         double damping, dvdx_error* error) {
  const dvdx::GridStiffness stiffness{.structural = structural, .shear = shear, .bend = bend, .damping = damping};
  return apply_change(plan, error, [&](auto& p) { return p.set_stiffness(index, stiffness); });
}

dvdx_status dvdx_plan_set_springs_stiffness(dvdx_plan* plan, size_t index, const dvdx_scalars* stiffness, double damping,
                                            dvdx_error* error) {
  if (stiffness == nullptr) return missing(error, "stiffness");
  return apply_change(plan, error, [&](auto& p) {
    return p.set_stiffness(index, dvdx::SpringsStiffness{.stiffness = scalars(*stiffness, "stiffness"), .damping = damping});
  });
}

dvdx_status dvdx_plan_set_bending(dvdx_plan* plan, const dvdx_bending* bending, dvdx_error* error) {
  if (bending == nullptr) return missing(error, "bending");
  return apply_change(plan, error, [&](auto& p) {
    const BentSheet sheet = bent_sheet_of(*bending);
    return p.set_bending(bending->network, sheet.triangles, sheet.flat, bending->modulus);
  });
}

dvdx_status dvdx_plan_set_mass(dvdx_plan* plan, size_t particle, double mass, dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) { return p.set_mass(particle, mass); });
}

dvdx_status dvdx_plan_fix(dvdx_plan* plan, size_t particle, dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) { return p.fix(particle); });
}

dvdx_status dvdx_plan_release(dvdx_plan* plan, size_t particle, dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) { return p.release(particle); });
}

dvdx_status dvdx_plan_break_spring(dvdx_plan* plan, size_t index, uint32_t a, uint32_t b, dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) { return p.break_spring(index, {a, b}); });
}

dvdx_status dvdx_plan_tear(dvdx_plan* plan, size_t index, double stretch, const dvdx_state* state, size_t* torn,
                           dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  return with_state(*plan, *state, error, [&](auto& p, const auto& particles) {
    const auto count = p.tear(index, stretch, particles);
    if (!count) return report(error, count.error());
    if (torn != nullptr) *torn = *count;
    return report(error, DVDX_DONE);
  });
}

double dvdx_plan_step_size(const dvdx_plan* plan) {
  if (plan == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return std::visit([](const auto& p) { return p.step_size(); }, plan->plan);
}

dvdx_isa dvdx_plan_isa(const dvdx_plan* plan) {
  if (plan == nullptr) return DVDX_ISA_BEST;
  return std::visit([](const auto& p) { return static_cast<dvdx_isa>(static_cast<int>(p.isa()) + 1); }, plan->plan);
}

dvdx_precision dvdx_plan_precision(const dvdx_plan* plan) {
  return plan == nullptr || plan->plan.index() == 0 ? DVDX_FLOAT32 : DVDX_FLOAT64;
}

int dvdx_plan_network_limit(const dvdx_plan* plan, dvdx_network_limit* limit) {
  if (plan == nullptr || limit == nullptr) return 0;
  const auto found = std::visit([](const auto& p) { return p.network_limit(); }, plan->plan);
  if (!found) return 0;
  const auto longest = std::visit([](const auto& p) { return p.scene().coupling.longest_substep; }, plan->plan);
  *limit = {.substeps = found->substeps,
            .frequency = found->frequency,
            .bound = found->bound,
            .limit = found->limit,
            .fewest = found->fewest,
            .safe = found->safe,
            .particle = found->particle,
            .damping = found->damping,
            .damping_limit = found->damping_limit,
            .scheme = static_cast<dvdx_scheme>(found->scheme),
            .side = found->estimate.side,
            .rest_error = found->estimate.rest,
            .motion_error = found->estimate.motion,
            .longest_substep = longest.value_or(0)};
  return 1;
}

size_t dvdx_plan_explain(const dvdx_plan* plan, char* text, size_t capacity) {
  std::size_t length = copy_text("", text, capacity);
  if (plan == nullptr) return length;
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
  const std::size_t size = number_of(precision) == DVDX_FLOAT64 ? sizeof(double) : sizeof(float);
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
  if (state == nullptr) return 0;
  const bool is_float64 = number_of(state->precision) == DVDX_FLOAT64;
  const dvdx_status status =
      is_float64 ? check_columns<double>(*state, state->count, nullptr) : check_columns<float>(*state, state->count, nullptr);
  if (status != DVDX_DONE) return 0;
  return is_float64 ? dvdx::state_hash(view<double>(*state)) : dvdx::state_hash(view<float>(*state));
}
