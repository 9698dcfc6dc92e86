// Plans for particles that come and go by C.
#include "dvdx/live.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "c_api/contact_report.hpp"
#include "c_api/convert.hpp"
#include "c_api/drive.hpp"
#include "c_api/guard.hpp"
#include "c_api/plan.hpp"
#include "c_api/scene.hpp"
#include "scene/text.hpp"

struct dvdx_live_plan {
  std::variant<dvdx::LifecyclePlan<float>, dvdx::LifecyclePlan<double>> plan;
  dvdx::Memory memory;
};
struct dvdx_live_workspace {
  std::variant<dvdx::LiveWorkspace<float>, dvdx::LiveWorkspace<double>> workspace;
  dvdx::Memory memory;
};

namespace dvdx::c_api {
namespace {

constexpr int shapes = 3, treatments = 2, survivor_orders = 2;
constexpr double never = std::numeric_limits<double>::infinity();

std::variant<Vec3, Disc, Box> shape_of(const dvdx_emitter& from, const std::string& at) {
  switch (choice<dvdx_emit>(from.shape, shapes, at + ".shape")) {
    case DVDX_EMIT_POINT:
      return vec3(from.at);
    case DVDX_EMIT_DISC:
      return Disc{.center = vec3(from.at), .normal = vec3(from.normal), .radius = from.radius};
    case DVDX_EMIT_BOX:
      return Box{.min = vec3(from.at), .max = vec3(from.most)};
  }
  return Vec3{};
}

Emitter emitter_of(const dvdx_emitter& from, const std::string& at) {
  if (!(from.duration >= 0)) throw Error{at + ".duration", text(from.duration), "a number >= 0"};
  Emitter to{.shape = shape_of(from, at), .rate = from.rate, .start = from.start};
  if (from.duration != 0) to.end = from.start + from.duration;
  to.velocity = vec3(from.velocity);
  to.spread = from.spread;
  if (from.spread_box != nullptr) to.spread = Vec3{from.spread_box[0], from.spread_box[1], from.spread_box[2]};
  const bool is_mortal = from.least_lifetime != 0 || from.most_lifetime != 0;
  to.least_lifetime = is_mortal ? from.least_lifetime : never;
  to.most_lifetime = is_mortal ? from.most_lifetime : never;
  to.seed = from.seed;
  if (from.follows != 0) to.motion = from.follows - 1;
  return to;
}

Lifecycle turnover_of(const dvdx_turnover& from) {
  need(from.emitters, from.emitter_count, "emitters");
  need(from.boundaries, from.boundary_count, "removal.boundaries");
  Lifecycle to;
  for (std::size_t i = 0; i < from.emitter_count; ++i) {
    to.emitters.push_back(emitter_of(from.emitters[i], "emitters[" + std::to_string(i) + "]"));
  }
  for (std::size_t i = 0; i < from.boundary_count; ++i) {
    to.removal.boundaries.push_back({.normal = vec3(from.boundaries[i].normal), .offset = from.boundaries[i].offset});
  }
  if (const double* box = from.inside; box != nullptr) {
    to.removal.outside = Box{.min = {box[0], box[1], box[2]}, .max = {box[3], box[4], box[5]}};
  }
  to.removal.not_finite = choice<NotFinite>(from.not_finite, treatments, "removal.not_finite");
  to.removal.order = choice<SurvivorOrder>(from.order, survivor_orders, "removal.order");
  to.capacity = from.capacity;
  return to;
}

template <class T>
dvdx_status create(const Scene& scene, const Lifecycle& turnover, const Options& options, dvdx_live_plan** plan,
                   dvdx_error* error) {
  auto made = compile<T>(scene, turnover, options);
  if (!made) return report(error, made.error());
  *plan = make_handle<dvdx_live_plan>(std::move(*made), options.memory);
  return report(error, DVDX_DONE);
}

// The most columns of the caller's in one call. Their list is made for each call, on the stack.
constexpr std::size_t most_carried = 32;

dvdx_status check_carried(const dvdx_live& live, dvdx_error* error) noexcept {
  if (live.carried_count > most_carried) {
    std::array<char, 24> digits{};
    const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), live.carried_count).ptr;
    return report(error, DVDX_INVALID, "carried_count", std::string_view(digits.data(), end), "at most 32");
  }
  if (live.carried_count == 0) return DVDX_DONE;
  if (live.carried == nullptr) return missing(error, "carried");
  const auto is_nowhere = [](const dvdx_carried& c) { return c.base == nullptr && c.bytes != 0; };
  if (std::any_of(live.carried, live.carried + live.carried_count, is_nowhere)) return missing(error, "carried");
  return DVDX_DONE;
}

// Checks that ages and lifetimes have memory of their own.
template <class T>
dvdx_status check_ages(const dvdx_live& live, std::size_t capacity, dvdx_error* error) noexcept {
  if (live.age.base == nullptr || capacity == 0) return DVDX_DONE;
  const auto& [x, v] = std::pair(&live.state.x[0], &live.state.v[0]);
  const std::array<NamedColumn, 8> columns = {{{&x[0], "x[0]"},
                                               {&x[1], "x[1]"},
                                               {&x[2], "x[2]"},
                                               {&v[0], "v[0]"},
                                               {&v[1], "v[1]"},
                                               {&v[2], "v[2]"},
                                               {&live.age, "age"},
                                               {&live.lifetime, "lifetime"}}};
  return check_apart<T>({columns.data(), live.lifetime.base == nullptr ? 7U : 8U}, capacity, error);
}

template <class T>
dvdx_status check_live(const dvdx_live& live, std::size_t capacity, dvdx_error* error) noexcept {
  if (const dvdx_status status = check_columns<T>(live.state, capacity, error); status != DVDX_DONE) return status;
  if (live.age.base != nullptr) {
    if (const dvdx_status status = check_column<T>(live.age, "age", error); status != DVDX_DONE) return status;
  }
  if (live.lifetime.base != nullptr) {
    if (const dvdx_status status = check_column<T>(live.lifetime, "lifetime", error); status != DVDX_DONE) return status;
    if (live.age.base == nullptr) return report(error, DVDX_INVALID, "age", "a null pointer", "there where lifetime is");
  }
  if (const dvdx_status status = check_ages<T>(live, capacity, error); status != DVDX_DONE) return status;
  return check_carried(live, error);
}

// Calls work(the plan, the particles as C++ has them), and writes the results back.
template <class T, class Work>
dvdx_status stepped(const LifecyclePlan<T>& plan, dvdx_live& live, dvdx_error* error, const Work& work) noexcept {
  if (const dvdx_status status = check_live<T>(live, plan.turnover().capacity, error); status != DVDX_DONE) return status;
  std::array<Carried, most_carried> carried{};
  for (std::size_t i = 0; i < live.carried_count; ++i) {
    carried[i] = {live.carried[i].base, live.carried[i].stride, live.carried[i].bytes};
  }
  LiveState<T> particles{.state = view<T>(live.state),
                         .age = column<T>(live.age),
                         .lifetime = column<T>(live.lifetime),
                         .carried = {carried.data(), live.carried_count},
                         .born = live.born,
                         .removed = live.removed,
                         .dropped = live.dropped};
  const StepResult result = work(plan, particles);
  // If a step did not end, the steps of the call before it did.
  if (result == StepResult::done || result == StepResult::too_many_neighbours) {
    put_clock(particles.state.clock, live.state);
    live.state.count = particles.state.count;
    live.born = particles.born;
    live.removed = particles.removed;
    live.dropped = particles.dropped;
  }
  return report(error, result, live.state.clock);
}

}  // namespace
}  // namespace dvdx::c_api

using namespace dvdx::c_api;

dvdx_status dvdx_live_plan_create(const dvdx_scene* scene, const dvdx_turnover* turnover, const dvdx_options* options,
                                  dvdx_live_plan** plan, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  *plan = nullptr;
  if (scene == nullptr) return missing(error, "scene");
  if (turnover == nullptr) return missing(error, "turnover");
  if (options == nullptr) return missing(error, "options");
  return guarded(error, [&] {
    const dvdx::Options chosen = options_of(*options);
    const dvdx::Lifecycle values = turnover_of(*turnover);
    if (precision_of(*options) == DVDX_FLOAT32) return create<float>(scene->scene, values, chosen, plan, error);
    return create<double>(scene->scene, values, chosen, plan, error);
  });
}

void dvdx_live_plan_destroy(dvdx_live_plan* plan) { destroy_handle(plan); }

dvdx_status dvdx_live_plan_step(const dvdx_live_plan* plan, dvdx_live* live, size_t steps, const dvdx_parallel* parallel,
                                dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  const auto step = [&](const auto& p, auto& particles) { return p.step(particles, steps, threads_of(parallel)); };
  return std::visit([&](const auto& p) { return stepped(p, *live, error, step); }, plan->plan);
}

dvdx_status dvdx_live_plan_step_and_report(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                           const dvdx_parallel* parallel, dvdx_contact_report* contacts, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  if (contacts == nullptr) return missing(error, "report");
  const auto step = [&](const auto& p, auto& particles) {
    return p.step(particles, contacts->report, steps, threads_of(parallel));
  };
  return std::visit([&](const auto& p) { return stepped(p, *live, error, step); }, plan->plan);
}

dvdx_status dvdx_live_plan_remove(const dvdx_live_plan* plan, dvdx_live* live, const dvdx_parallel* parallel,
                                  dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  const auto remove = [&](const auto& p, auto& particles) { return p.remove(particles, threads_of(parallel)); };
  return std::visit([&](const auto& p) { return stepped(p, *live, error, remove); }, plan->plan);
}

dvdx_status dvdx_live_plan_teleport(const dvdx_live_plan* plan, const dvdx_live* live, const double* translation,
                                    const double* rotation, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  if (translation == nullptr) return missing(error, "translation");
  const auto carry = [&]<class T>(const dvdx::LifecyclePlan<T>& p) {
    const dvdx_status status = check_columns<T>(live->state, live->state.count, error);
    if (status != DVDX_DONE) return status;
    dvdx::LiveState<T> particles{.state = view<T>(live->state)};
    return done_or(error, p.teleport(particles, pose_of(translation, rotation)));
  };
  return guarded(error, [&] { return std::visit(carry, plan->plan); });
}

dvdx_status dvdx_live_plan_check(const dvdx_live_plan* plan, const dvdx_live* live, dvdx_state_check* check,
                                 dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  if (check == nullptr) return missing(error, "check");
  const auto look = [&]<class T>(const dvdx::LifecyclePlan<T>& p) {
    const dvdx_status status = check_columns<T>(live->state, live->state.count, error);
    if (status != DVDX_DONE) return status;
    const dvdx::StateCheck found = p.check(dvdx::LiveState<T>{.state = view<T>(live->state)});
    if (found.result != dvdx::StepResult::done) return report(error, found.result, live->state.clock);
    put_check(found, *check);
    return report(error, DVDX_DONE);
  };
  return std::visit(look, plan->plan);
}

double dvdx_live_plan_step_size(const dvdx_live_plan* plan) {
  if (plan == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return std::visit([](const auto& p) { return p.step_size(); }, plan->plan);
}

dvdx_status dvdx_live_plan_clone(const dvdx_live_plan* plan, dvdx_live_plan** clone, dvdx_error* error) {
  if (clone == nullptr) return missing(error, "clone");
  *clone = nullptr;
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] {
    std::visit([&](const auto& p) { *clone = make_handle<dvdx_live_plan>(p.clone(), plan->memory); }, plan->plan);
    return report(error, DVDX_DONE);
  });
}

namespace {

// Calls change(the plan as C++ has it).
template <class Change>
dvdx_status apply_change(dvdx_live_plan* plan, dvdx_error* error, const Change& change) {
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] { return std::visit([&](auto& p) { return done_or(error, change(p)); }, plan->plan); });
}

template <class List>
const auto& one_of(const List& list, std::size_t from, const char* kind) {
  if (from < list.size()) return list[from];
  throw dvdx::Error{"from", std::to_string(from), "below the scene's " + std::to_string(list.size()) + " " + kind};
}

}  // namespace

dvdx_status dvdx_live_plan_set_pose(dvdx_live_plan* plan, size_t motion, const double* translation, const double* rotation,
                                    dvdx_error* error) {
  const auto apply = [&](const auto& change) { return apply_change(plan, error, change); };
  return drive_pose(apply, motion, translation, rotation, dvdx::Arrival::moving);
}
dvdx_status dvdx_live_plan_jump_pose(dvdx_live_plan* plan, size_t motion, const double* translation, const double* rotation,
                                     dvdx_error* error) {
  const auto apply = [&](const auto& change) { return apply_change(plan, error, change); };
  return drive_pose(apply, motion, translation, rotation, dvdx::Arrival::jump);
}
dvdx_status dvdx_live_plan_set_wind(dvdx_live_plan* plan, const dvdx_wind* wind, dvdx_error* error) {
  if (wind == nullptr) return missing(error, "wind");
  return apply_change(plan, error, [&](auto& p) { return p.set_wind(wind_of(*wind)); });
}
dvdx_status dvdx_live_plan_set_step(dvdx_live_plan* plan, double step, dvdx_error* error) {
  return apply_change(plan, error, [&](auto& p) { return p.set_step(step); });
}
dvdx_status dvdx_live_plan_set_force(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                     dvdx_error* error) {
  if (scene == nullptr) return missing(error, "scene");
  return apply_change(plan, error, [&](auto& p) { return p.set_force(index, one_of(scene->scene.forces, from, "forces")); });
}
dvdx_status dvdx_live_plan_set_contact(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                       dvdx_error* error) {
  if (scene == nullptr) return missing(error, "scene");
  return apply_change(plan, error,
                      [&](auto& p) { return p.set_contact(index, one_of(scene->scene.contacts, from, "contacts")); });
}
dvdx_status dvdx_live_plan_set_emitter(dvdx_live_plan* plan, size_t index, const dvdx_emitter* emitter, dvdx_error* error) {
  if (emitter == nullptr) return missing(error, "emitter");
  return apply_change(plan, error, [&](auto& p) {
    return p.set_emitter(index, emitter_of(*emitter, "emitters[" + std::to_string(index) + "]"));
  });
}

namespace {

// Calls burst(the plan, the particles), which returns an error as C++ has it.
template <class T, class Burst>
dvdx_status burst_by(const dvdx::LifecyclePlan<T>& plan, dvdx_live& live, size_t index, dvdx_error* error, const Burst& burst) {
  return guarded(error, [&] {
    const std::size_t emitters = plan.turnover().emitters.size();
    if (index >= emitters) throw dvdx::Error{"index", std::to_string(index), "below " + std::to_string(emitters)};
    dvdx::Expected<void> done;
    const dvdx_status status = stepped(plan, live, error, [&](const auto& p, auto& particles) {
      done = burst(p, particles);
      return dvdx::StepResult::done;
    });
    return status != DVDX_DONE ? status : done_or(error, done);
  });
}

// Calls use(the plan, the workspace) if both are of one precision.
template <class Use>
dvdx_status with_workspace(const dvdx_live_plan& plan, dvdx_live_workspace& workspace, dvdx_error* error, const Use& use) {
  const auto of = [&]<class T>(const dvdx::LifecyclePlan<T>& p) -> dvdx_status {
    auto* const own = std::get_if<dvdx::LiveWorkspace<T>>(&workspace.workspace);
    return own != nullptr ? use(p, *own) : report(error, DVDX_WORKSPACE_DIFFERS);
  };
  return std::visit(of, plan.plan);
}

dvdx_status drive_workspace(dvdx_live_workspace* workspace, size_t motion, const double* translation, const double* rotation,
                            dvdx::Arrival arrival, dvdx_error* error) {
  if (workspace == nullptr) return missing(error, "workspace");
  const auto apply = [&](const auto& change) {
    return guarded(error, [&] { return std::visit([&](auto& w) { return done_or(error, change(w)); }, workspace->workspace); });
  };
  return drive_pose(apply, motion, translation, rotation, arrival);
}

}  // namespace

dvdx_status dvdx_live_plan_burst(const dvdx_live_plan* plan, dvdx_live* live, size_t index, size_t births, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  const auto burst = [&](const auto& p, auto& particles) { return p.burst(particles, index, births); };
  return std::visit([&](const auto& p) { return burst_by(p, *live, index, error, burst); }, plan->plan);
}

dvdx_status dvdx_live_workspace_create(const dvdx_live_plan* plan, dvdx_live_workspace** workspace, dvdx_error* error) {
  if (workspace == nullptr) return missing(error, "workspace");
  *workspace = nullptr;
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] {
    const auto make = [&](const auto& p) { *workspace = make_handle<dvdx_live_workspace>(p.workspace(), plan->memory); };
    std::visit(make, plan->plan);
    return report(error, DVDX_DONE);
  });
}
void dvdx_live_workspace_destroy(dvdx_live_workspace* workspace) { destroy_handle(workspace); }
size_t dvdx_live_workspace_bytes(const dvdx_live_workspace* workspace) {
  if (workspace == nullptr) return 0;
  return std::visit([](const auto& w) { return w.bytes(); }, workspace->workspace);
}
dvdx_status dvdx_live_workspace_set_pose(dvdx_live_workspace* workspace, size_t motion, const double* translation,
                                         const double* rotation, dvdx_error* error) {
  return drive_workspace(workspace, motion, translation, rotation, dvdx::Arrival::moving, error);
}
dvdx_status dvdx_live_workspace_jump_pose(dvdx_live_workspace* workspace, size_t motion, const double* translation,
                                          const double* rotation, dvdx_error* error) {
  return drive_workspace(workspace, motion, translation, rotation, dvdx::Arrival::jump, error);
}
dvdx_status dvdx_live_plan_step_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, dvdx_live* live, size_t steps,
                                   const dvdx_parallel* parallel, dvdx_contact_report* contacts, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (live == nullptr) return missing(error, "live");
  return with_workspace(*plan, *workspace, error, [&](const auto& p, auto& own) {
    return stepped(p, *live, error, [&](const auto& by, auto& particles) {
      return contacts != nullptr ? by.step(particles, own, contacts->report, steps, threads_of(parallel))
                                 : by.step(particles, own, steps, threads_of(parallel));
    });
  });
}
dvdx_status dvdx_live_plan_burst_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, dvdx_live* live, size_t index,
                                    size_t births, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (live == nullptr) return missing(error, "live");
  return with_workspace(*plan, *workspace, error, [&](const auto& p, auto& own) {
    return burst_by(p, *live, index, error,
                    [&](const auto& by, auto& particles) { return by.burst(particles, own, index, births); });
  });
}
dvdx_status dvdx_live_plan_teleport_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, const dvdx_live* live,
                                       const double* translation, const double* rotation, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (live == nullptr) return missing(error, "live");
  if (translation == nullptr) return missing(error, "translation");
  return guarded(error, [&] {
    return with_workspace(*plan, *workspace, error, [&]<class T>(const dvdx::LifecyclePlan<T>& p, dvdx::LiveWorkspace<T>& own) {
      const dvdx_status status = check_columns<T>(live->state, live->state.count, error);
      if (status != DVDX_DONE) return status;
      dvdx::LiveState<T> particles{.state = view<T>(live->state)};
      return done_or(error, p.teleport(particles, own, pose_of(translation, rotation)));
    });
  });
}

size_t dvdx_live_plan_explain(const dvdx_live_plan* plan, char* text, size_t capacity) {
  std::size_t length = copy_text("", text, capacity);
  if (plan == nullptr) return length;
  (void)guarded(nullptr, [&] {
    const auto words = [](const auto& p) { return p.plan().explain() + p.explain(); };
    length = copy_text(std::visit(words, plan->plan), text, capacity);
    return DVDX_DONE;
  });
  return length;
}
