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
#include "c_api/guard.hpp"
#include "c_api/plan.hpp"
#include "c_api/scene.hpp"
#include "text.hpp"

struct dvdx_live_plan {
  std::variant<dvdx::LivePlan<float>, dvdx::LivePlan<double>> plan;
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
  return to;
}

Turnover turnover_of(const dvdx_turnover& from) {
  need(from.emitters, from.emitter_count, "emitters");
  need(from.boundaries, from.boundary_count, "removal.boundaries");
  Turnover to;
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
dvdx_status create(const Scene& scene, const Turnover& turnover, const Options& options, dvdx_live_plan** plan,
                   dvdx_error* error) {
  auto made = compile<T>(scene, turnover, options);
  if (!made) return report(error, made.error());
  *plan = make_handle<dvdx_live_plan>(std::move(*made), options.memory);
  return report(error, DVDX_DONE);
}

// Columns of the caller's that one call may carry: their list is made anew for each, on the stack.
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

// That ages and lifetimes have memory of their own.
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

// work(the plan, the particles as C++ has them), and what came of them.
template <class T, class Work>
dvdx_status stepped(const LivePlan<T>& plan, dvdx_live& live, dvdx_error* error, const Work& work) noexcept {
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
  if (result == StepResult::done) {
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
    const dvdx::Turnover values = turnover_of(*turnover);
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
  const auto carry = [&]<class T>(const dvdx::LivePlan<T>& p) {
    const dvdx_status status = check_columns<T>(live->state, live->state.count, error);
    if (status != DVDX_DONE) return status;
    dvdx::LiveState<T> particles{.state = view<T>(live->state)};
    return done_or(error, p.teleport(particles, pose_of(translation, rotation)));
  };
  return guarded(error, [&] { return std::visit(carry, plan->plan); });
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

// change(the plan as C++ has it)
template <class Change>
dvdx_status changed_life(dvdx_live_plan* plan, dvdx_error* error, const Change& change) {
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] { return std::visit([&](auto& p) { return done_or(error, change(p)); }, plan->plan); });
}

template <class List>
const auto& one_of(const List& list, std::size_t from, const char* kind) {
  if (from < list.size()) return list[from];
  throw dvdx::Error{"from", std::to_string(from), "below the scene's " + std::to_string(list.size()) + " " + kind};
}

}  // namespace

dvdx_status dvdx_live_plan_set_step(dvdx_live_plan* plan, double step, dvdx_error* error) {
  return changed_life(plan, error, [&](auto& p) { return p.set_step(step); });
}
dvdx_status dvdx_live_plan_set_force(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                     dvdx_error* error) {
  if (scene == nullptr) return missing(error, "scene");
  return changed_life(plan, error, [&](auto& p) { return p.set_force(index, one_of(scene->scene.forces, from, "forces")); });
}
dvdx_status dvdx_live_plan_set_contact(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                       dvdx_error* error) {
  if (scene == nullptr) return missing(error, "scene");
  return changed_life(plan, error,
                      [&](auto& p) { return p.set_contact(index, one_of(scene->scene.contacts, from, "contacts")); });
}
dvdx_status dvdx_live_plan_set_emitter(dvdx_live_plan* plan, size_t index, const dvdx_emitter* emitter, dvdx_error* error) {
  if (emitter == nullptr) return missing(error, "emitter");
  return changed_life(plan, error, [&](auto& p) {
    return p.set_emitter(index, emitter_of(*emitter, "emitters[" + std::to_string(index) + "]"));
  });
}
dvdx_status dvdx_live_plan_burst(const dvdx_live_plan* plan, dvdx_live* live, size_t index, size_t births, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (live == nullptr) return missing(error, "live");
  return guarded(error, [&] {
    const std::size_t emitters = std::visit([](const auto& p) { return p.turnover().emitters.size(); }, plan->plan);
    if (index >= emitters) throw dvdx::Error{"index", std::to_string(index), "below " + std::to_string(emitters)};
    dvdx::Expected<void> done;
    const auto burst = [&](const auto& p, auto& particles) {
      done = p.burst(particles, index, births);
      return dvdx::StepResult::done;
    };
    const dvdx_status status = std::visit([&](const auto& p) { return stepped(p, *live, error, burst); }, plan->plan);
    return status != DVDX_DONE ? status : done_or(error, done);
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
