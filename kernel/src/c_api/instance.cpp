// Instances by C: a handle that holds one of either precision, in the memory of the plan that made it.
#include "dvdx/instance.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "c_api/convert.hpp"
#include "c_api/drive.hpp"
#include "c_api/guard.hpp"
#include "c_api/plan.hpp"
#include "c_api/scene.hpp"
#include "plan/instances.hpp"

struct dvdx_instance {
  std::variant<dvdx::Instance<float>, dvdx::Instance<double>> instance;
  dvdx::Memory memory;
};

namespace dvdx::c_api {
namespace {

constexpr int arrivals = 2;

// Calls change(the instance as C++ has it).
template <class Change>
dvdx_status apply_change(dvdx_instance* instance, dvdx_error* error, const Change& change) {
  if (instance == nullptr) return missing(error, "instance");
  return guarded(error, [&] { return std::visit([&](auto& i) { return done_or(error, change(i)); }, instance->instance); });
}

Points points_of(const double* xyz, std::size_t count, const char* field) {
  need(xyz, count, field);
  return {reinterpret_cast<const std::array<double, 3>*>(xyz), count};
}

Arrival arrival_of(const dvdx_arrival& arrival) { return choice<Arrival>(arrival, arrivals, "arrival"); }

}  // namespace
}  // namespace dvdx::c_api

using namespace dvdx::c_api;

dvdx_status dvdx_instance_create(const dvdx_plan* plan, const dvdx_state* state, dvdx_instance** instance, dvdx_error* error) {
  if (instance == nullptr) return missing(error, "instance");
  *instance = nullptr;
  if (plan == nullptr) return missing(error, "plan");
  if (state == nullptr) return missing(error, "state");
  const auto make = [&]<class T>(const dvdx::Plan<T>& p) -> dvdx_status {
    if (const dvdx_status status = check_columns<T>(*state, state->count, error); status != DVDX_DONE) return status;
    auto made = p.instance(view<T>(*state));
    if (!made) return report(error, made.error());
    *instance = make_handle<dvdx_instance>(std::move(*made), plan->memory);
    return report(error, DVDX_DONE);
  };
  return guarded(error, [&] { return std::visit(make, plan->plan); });
}

void dvdx_instance_destroy(dvdx_instance* instance) { destroy_handle(instance); }

dvdx_status dvdx_instance_move_body(dvdx_instance* instance, size_t motion, const double* translation, const double* rotation,
                                    dvdx_arrival arrival, dvdx_error* error) {
  if (translation == nullptr) return missing(error, "translation");
  return apply_change(instance, error, [&](auto& i) {
    return i.move(dvdx::MotionId{motion}, pose_of(translation, rotation), arrival_of(arrival));
  });
}
dvdx_status dvdx_instance_move_pins(dvdx_instance* instance, size_t pins, const double* places, size_t count,
                                    dvdx_arrival arrival, dvdx_error* error) {
  return apply_change(instance, error, [&](auto& i) {
    return i.move(dvdx::PinsId{pins}, points_of(places, count, "places"), arrival_of(arrival));
  });
}
dvdx_status dvdx_instance_move_skin(dvdx_instance* instance, size_t skin, const double* points, const double* normals,
                                    size_t count, dvdx_arrival arrival, dvdx_error* error) {
  return apply_change(instance, error, [&](auto& i) {
    const auto given = normals != nullptr ? points_of(normals, count, "normals") : dvdx::Points();
    return i.move(dvdx::SkinId{skin}, points_of(points, count, "points"), given, arrival_of(arrival));
  });
}

dvdx_status dvdx_instance_set_wind(dvdx_instance* instance, const dvdx_wind* wind, dvdx_error* error) {
  if (wind == nullptr) return missing(error, "wind");
  return apply_change(instance, error, [&](auto& i) { return i.set_wind(wind_of(*wind)); });
}

dvdx_status dvdx_instance_step(dvdx_instance* instance, double step, const dvdx_parallel* parallel, dvdx_error* error) {
  return apply_change(instance, error, [&](auto& i) { return i.step(step, threads_of(parallel)); });
}

dvdx_status dvdx_instances_step(dvdx_instance* const* instances, size_t count, const double* frame_times, size_t time_count,
                                const dvdx_parallel* parallel, dvdx_error* error) {
  if (instances == nullptr && count != 0) return missing(error, "instances");
  if (frame_times == nullptr) return missing(error, "frame_times");
  if (count == 0) return report(error, DVDX_DONE);
  return guarded(error, [&] {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string at = "instances[" + std::to_string(i) + "]";
      if (instances[i] == nullptr) throw dvdx::Error{at, "a null pointer", "an instance"};
      if (instances[i]->instance.index() != instances[0]->instance.index()) {
        throw dvdx::Error{at, "of another precision", "of that of instances[0]"};
      }
    }
    const auto step = [&]<class T>(const dvdx::Instance<T>&) {
      const auto at = [](const void* context, std::size_t i) {
        return &std::get<dvdx::Instance<T>>(static_cast<dvdx_instance* const*>(context)[i]->instance);
      };
      const dvdx::InstanceList<T> list{.count = count, .at = at, .context = instances};
      return done_or(error, dvdx::step_all(list, std::span(frame_times, time_count), threads_of(parallel)));
    };
    return std::visit(step, instances[0]->instance);
  });
}

dvdx_status dvdx_instance_advance(dvdx_instance* instance, double frame_time, size_t most, size_t* steps,
                                  const dvdx_parallel* parallel, dvdx_error* error) {
  return apply_change(instance, error, [&](auto& i) -> dvdx::Expected<void> {
    const auto made = i.advance(frame_time, most, threads_of(parallel));
    if (!made) return tl::unexpected(made.error());
    if (steps != nullptr) *steps = *made;
    return {};
  });
}

dvdx_status dvdx_instance_blend(const dvdx_instance* instance, const dvdx_state* to, dvdx_error* error) {
  if (instance == nullptr) return missing(error, "instance");
  if (to == nullptr) return missing(error, "to");
  const auto blend = [&]<class T>(const dvdx::Instance<T>& i) -> dvdx_status {
    if (const dvdx_status status = check_columns<T>(*to, to->count, error); status != DVDX_DONE) return status;
    dvdx::State<T> drawn = view<T>(*to);
    return done_or(error, i.blend(drawn));
  };
  return guarded(error, [&] { return std::visit(blend, instance->instance); });
}

dvdx_status dvdx_instance_teleport(dvdx_instance* instance, const double* translation, const double* rotation,
                                   dvdx_error* error) {
  if (translation == nullptr) return missing(error, "translation");
  return apply_change(instance, error, [&](auto& i) { return i.teleport(pose_of(translation, rotation)); });
}

dvdx_status dvdx_instance_check(const dvdx_instance* instance, dvdx_state_check* check, dvdx_error* error) {
  if (instance == nullptr) return missing(error, "instance");
  if (check == nullptr) return missing(error, "check");
  put_check(std::visit([](const auto& i) { return i.check(); }, instance->instance), *check);
  return report(error, DVDX_DONE);
}

dvdx_clock dvdx_instance_clock(const dvdx_instance* instance) {
  if (instance == nullptr) return {std::numeric_limits<double>::quiet_NaN(), 0};
  const dvdx::Clock clock = std::visit([](const auto& i) { return i.state().clock; }, instance->instance);
  return {clock.seconds, clock.carry};
}

double dvdx_instance_step_size(const dvdx_instance* instance) {
  if (instance == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return std::visit([](const auto& i) { return i.step_size(); }, instance->instance);
}
