// Workspaces by C: a handle that holds one of either precision, in the memory of the plan that made it.
#include <cstddef>
#include <span>
#include <variant>

#include "c_api/contact_report.hpp"
#include "c_api/convert.hpp"
#include "c_api/drive.hpp"
#include "c_api/guard.hpp"
#include "c_api/plan.hpp"

struct dvdx_workspace {
  std::variant<dvdx::Workspace<float>, dvdx::Workspace<double>> workspace;
  dvdx::Memory memory;
};

namespace dvdx::c_api {
namespace {

// Calls change(the workspace as C++ has it).
template <class Change>
dvdx_status apply_change(dvdx_workspace* workspace, dvdx_error* error, const Change& change) {
  if (workspace == nullptr) return missing(error, "workspace");
  return guarded(error, [&] { return std::visit([&](auto& w) { return done_or(error, change(w)); }, workspace->workspace); });
}
auto changer(dvdx_workspace* workspace, dvdx_error* error) {
  return [=](const auto& change) { return apply_change(workspace, error, change); };
}

// Calls use(the plan, the workspace, the state) if all three are of one precision.
template <class W, class Use>
dvdx_status with_state(const dvdx_plan& plan, W& workspace, const dvdx_state& state, dvdx_error* error, const Use& use) {
  const auto of = [&]<class T>(const Plan<T>& p) -> dvdx_status {
    auto* const own = std::get_if<Workspace<T>>(&workspace.workspace);
    if (own == nullptr) return report(error, DVDX_WORKSPACE_DIFFERS);
    const dvdx_status status = check_columns<T>(state, state.count, error);
    return status != DVDX_DONE ? status : use(p, *own, view<T>(state));
  };
  return std::visit(of, plan.plan);
}

}  // namespace
}  // namespace dvdx::c_api

using namespace dvdx::c_api;

dvdx_status dvdx_workspace_create(const dvdx_plan* plan, dvdx_workspace** workspace, dvdx_error* error) {
  if (workspace == nullptr) return missing(error, "workspace");
  *workspace = nullptr;
  if (plan == nullptr) return missing(error, "plan");
  return guarded(error, [&] {
    std::visit([&](const auto& p) { *workspace = make_handle<dvdx_workspace>(p.workspace(), plan->memory); }, plan->plan);
    return report(error, DVDX_DONE);
  });
}

void dvdx_workspace_destroy(dvdx_workspace* workspace) { destroy_handle(workspace); }

size_t dvdx_workspace_bytes(const dvdx_workspace* workspace) {
  if (workspace == nullptr) return 0;
  return std::visit([](const auto& w) { return w.bytes(); }, workspace->workspace);
}

void dvdx_workspace_forget(dvdx_workspace* workspace) {
  if (workspace == nullptr) return;
  std::visit([](auto& w) { w.forget(); }, workspace->workspace);
}

dvdx_status dvdx_plan_step_in(const dvdx_plan* plan, dvdx_workspace* workspace, dvdx_state* state, size_t steps,
                              const dvdx_parallel* parallel, dvdx_contact_report* contacts, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (state == nullptr) return missing(error, "state");
  return with_state(*plan, *workspace, *state, error, [&](const auto& p, auto& own, auto particles) {
    const auto result = contacts != nullptr ? p.step(particles, own, contacts->report, steps, threads_of(parallel))
                                            : p.step(particles, own, steps, threads_of(parallel));
    if (result == dvdx::StepResult::done) put_clock(particles.clock, *state);
    return report(error, result, state->clock);
  });
}

dvdx_status dvdx_plan_teleport_in(const dvdx_plan* plan, dvdx_workspace* workspace, const dvdx_state* state,
                                  const double* translation, const double* rotation, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (state == nullptr) return missing(error, "state");
  if (translation == nullptr) return missing(error, "translation");
  return guarded(error, [&] {
    return with_state(*plan, *workspace, *state, error, [&](const auto& p, auto& own, auto particles) {
      return done_or(error, p.teleport(particles, own, pose_of(translation, rotation)));
    });
  });
}

dvdx_status dvdx_plan_meetings(const dvdx_plan* plan, const dvdx_workspace* workspace, dvdx_meetings* meetings,
                               dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (meetings == nullptr) return missing(error, "meetings");
  const auto of = [&]<class T>(const dvdx::Plan<T>& p) {
    const auto* const own = workspace == nullptr ? nullptr : std::get_if<dvdx::Workspace<T>>(&workspace->workspace);
    if (workspace != nullptr && own == nullptr) return report(error, DVDX_WORKSPACE_DIFFERS);
    const dvdx::Meetings found = own == nullptr ? p.meetings() : p.meetings(*own);
    *meetings = {.listed = found.listed,
                 .touching = found.touching,
                 .most = found.most,
                 .rebuilt = found.rebuilt,
                 .substeps = found.substeps,
                 .overlap_mean = found.overlap_mean,
                 .overlap_most = found.overlap_most,
                 .stretch_limit = found.stretch_limit,
                 .passing_layers = found.passing_layers};
    return report(error, DVDX_DONE);
  };
  return std::visit(of, plan->plan);
}

dvdx_status dvdx_plan_carried_in(const dvdx_plan* plan, const dvdx_workspace* workspace, const dvdx_state* state,
                                 double* numbers, size_t capacity, size_t* count, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (state == nullptr) return missing(error, "state");
  if (count == nullptr) return missing(error, "count");
  if (numbers == nullptr && capacity != 0) return missing(error, "numbers");
  return guarded(error, [&] {
    return with_state(*plan, *workspace, *state, error, [&](const auto& p, const auto& own, const auto& particles) {
      return put_numbers(p.carried(particles, own), numbers, capacity, *count, error);
    });
  });
}

dvdx_status dvdx_plan_restore_in(const dvdx_plan* plan, dvdx_workspace* workspace, const double* numbers, size_t count,
                                 const dvdx_state* state, dvdx_error* error) {
  if (plan == nullptr) return missing(error, "plan");
  if (workspace == nullptr) return missing(error, "workspace");
  if (state == nullptr) return missing(error, "state");
  return guarded(error, [&] {
    need(numbers, count, "numbers");
    return with_state(*plan, *workspace, *state, error, [&](const auto& p, auto& own, const auto& particles) {
      return done_or(error, p.restore(std::span(numbers, count), particles, own));
    });
  });
}

dvdx_status dvdx_workspace_set_pose(dvdx_workspace* workspace, size_t motion, const double* translation, const double* rotation,
                                    dvdx_error* error) {
  return drive_pose(changer(workspace, error), motion, translation, rotation, dvdx::Arrival::moving);
}
dvdx_status dvdx_workspace_set_places(dvdx_workspace* workspace, size_t kinematic, const double* places, size_t count,
                                      dvdx_error* error) {
  return drive_places(changer(workspace, error), kinematic, places, count, dvdx::Arrival::moving);
}
dvdx_status dvdx_workspace_set_skin(dvdx_workspace* workspace, size_t skin, const double* points, const double* normals,
                                    size_t count, dvdx_error* error) {
  return drive_skin(changer(workspace, error), skin, points, normals, count, dvdx::Arrival::moving);
}
dvdx_status dvdx_workspace_jump_pose(dvdx_workspace* workspace, size_t motion, const double* translation,
                                     const double* rotation, dvdx_error* error) {
  return drive_pose(changer(workspace, error), motion, translation, rotation, dvdx::Arrival::jump);
}
dvdx_status dvdx_workspace_jump_places(dvdx_workspace* workspace, size_t kinematic, const double* places, size_t count,
                                       dvdx_error* error) {
  return drive_places(changer(workspace, error), kinematic, places, count, dvdx::Arrival::jump);
}
dvdx_status dvdx_workspace_jump_skin(dvdx_workspace* workspace, size_t skin, const double* points, const double* normals,
                                     size_t count, dvdx_error* error) {
  return drive_skin(changer(workspace, error), skin, points, normals, count, dvdx::Arrival::jump);
}
