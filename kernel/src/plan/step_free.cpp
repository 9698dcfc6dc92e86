// A call of step(): cut the batch into blocks, make each step's offsets, run every block through all its steps.
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <type_traits>

#include "contact/report/contact_recorder.hpp"
#include "plan/network_stepper.hpp"
#include "plan/plan_parts.hpp"
#include "plan/reported_step.hpp"
#include "plan/state_fit.hpp"
#include "plan/state_io.hpp"
#include "scene/particle_values.hpp"
#include "work/environment.hpp"
#include "work/tasks.hpp"

namespace dvdx {
namespace {

// Offsets of this many half or whole steps live on the caller's stack. If they depend on time, longer calls walk the batch
// again.
constexpr std::size_t max_offsets = 32;
// Blocks of one task. The number is fixed, so that no result depends on the number of threads.
constexpr std::size_t blocks_per_task = 4;
// A: the scalar of the computation. T: the scalar of the state. They differ if float32 is compensated.
template <class A, class T>
struct Batch {
  const CompiledScene<A>& scene;
  const FreeMotion<A>& motion;
  const Terms<A>& terms;  // the motion's, or with its surfaces moved
  const State<T>& state;
  Steps<A> steps;
  Clock start{};                           // of the first of these steps
  ContactReport::Parts* report = nullptr;  // null: no report is wanted
  std::uint64_t number = 0;                // of the first of these steps in the report
  const LoggedParticles* logged = nullptr;
};

// With a report the steps run one by one: the recorder is told which one it is.
template <class A, class T>
void run_steps(const Batch<A, T>& batch, Block<A>& block, ContactRecorder<A>* recorder) noexcept {
  const FreeMotion<A>& motion = batch.motion;
  const StepBlock<A> run = motion.kernels->at(motion.flow, motion.features);
  if (recorder == nullptr) return run(block, batch.terms, batch.steps);
  block.log = recorder;
  Clock clock = batch.start;
  for (std::size_t n = 0; n < batch.steps.count; ++n) {
    recorder->begin(batch.number + n, clock, motion.step());
    const Offsets<A>* const offsets = batch.steps.offsets + n * batch.steps.offsets_per_step;
    run(block, batch.terms, {.offsets = offsets, .offsets_per_step = 0, .count = 1});
    clock.advance(motion.step(), 1);
  }
}

// The number of particles that are copied together to be stepped: copies and originals stay in first-level cache. Blocks that
// search for the surfaces near them are as large as possible, as they search once a block.
template <class A>
std::size_t staged_together(const FreeMotion<A>& motion) noexcept {
  return motion.terms.searches ? max_block : 256;
}

// A block's columns in contiguous memory, its last register filled up with copies of the last particle.
template <class A, class T>
class StagingBlock {
 public:
  StagingBlock(const Passes& passes, const State<T>& state, std::size_t first, std::size_t n) noexcept
      : passes_(passes), state_(state), first_(first), n_(n) {
    load(passes, state.x, state.x_rest, {first, n}, places_of(x_));
    load(passes, state.v, state.v_rest, {first, n}, places_of(v_));
    for (auto* columns : {&x_, &v_}) {
      for (Memory& column : *columns) std::fill(column.data() + n, column.data() + filled(), column[n - 1]);
    }
  }

  [[nodiscard]] Block<A> block() noexcept {
    return {.x = places_of(x_), .v = places_of(v_), .first = first_, .count = filled()};
  }

  // Writes particles [from, to) of the batch back.
  void write(std::size_t from, std::size_t to) const noexcept {
    store(passes_, places(places_of(x_), from - first_), {from, to - from}, state_.x, state_.x_rest);
    store(passes_, places(places_of(v_), from - first_), {from, to - from}, state_.v, state_.v_rest);
  }

 private:
  using Memory = std::array<A, column_pitch<A>(max_block)>;

  [[nodiscard]] std::size_t filled() const noexcept { return (n_ + block_unit - 1) / block_unit * block_unit; }

  const Passes& passes_;
  const State<T>& state_;
  std::size_t first_, n_;
  alignas(64) std::array<Memory, 3> x_, v_;  // left uninitialised: only what is fetched is read
};

template <class T>
bool may_step_in_place(const State<T>& state, std::size_t first, std::size_t n) noexcept {
  const std::size_t end = first + (n + block_unit - 1) / block_unit * block_unit;
  const auto is_fit = [&](const Column<T>& column) { return column.is_contiguous() && column.capacity >= end; };
  return std::all_of(state.x.begin(), state.x.end(), is_fit) && std::all_of(state.v.begin(), state.v.end(), is_fit);
}

template <class A, class T>
bool step_in_place(const Batch<A, T>& batch, std::size_t first, std::size_t n, ContactRecorder<A>* recorder) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    if (!may_step_in_place(batch.state, first, n)) return false;
    Block<T> block{.x = {}, .v = {}, .first = first, .count = (n + block_unit - 1) / block_unit * block_unit};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = batch.state.x[axis].base + first;
      block.v[axis] = batch.state.v[axis].base + first;
    }
    run_steps(batch, block, recorder);
    return true;
  }
  return false;
}

// The six columns as tiles, if their tiles are alike.
template <class T>
std::optional<Tiles<T>> tiles_from(const State<T>& state, std::size_t first) noexcept {
  const Column<T>& one = state.x[0];
  if (one.is_contiguous() || one.run == 1 || first % one.run != 0) return std::nullopt;
  Tiles<T> tiles{.width = one.run, .stride = one.stride / static_cast<std::ptrdiff_t>(sizeof(T))};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const auto* column : {&state.x[axis], &state.v[axis]}) {
      if (column->run != one.run || column->stride != one.stride) return std::nullopt;
    }
    tiles.x[axis] = state.x[axis].at(first);
    tiles.v[axis] = state.v[axis].at(first);
  }
  return tiles;
}

// Steps structs and tiles as they lie if nothing but the flow acts. Returns how many of the particles it stepped.
template <class A, class T>
std::size_t step_as_they_lie(const Batch<A, T>& batch, std::size_t first, std::size_t n) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    const FreeMotion<A>& motion = batch.motion;
    const State<T>& state = batch.state;
    if (motion.features != StepFeatures::none) return 0;
    const LayoutKernels<T>& kernels = motion.kernels->layout;
    if (const StepStructs<T> step = kernels.structs.at(motion.flow);
        step != nullptr && threes_of(state.x) && threes_of(state.v)) {
      return step({threes_at(state.x, {first, n}), threes_at(state.v, {first, n})}, n, batch.terms, batch.steps);
    }
    if (const StepTiles<T> step = kernels.tiles.at(motion.flow); step != nullptr) {
      if (const auto tiles = tiles_from(state, first)) return step(*tiles, n, batch.terms, batch.steps);
    }
  }
  return 0;
}

template <class A, class T>
void step_staged(const Batch<A, T>& batch, std::size_t first, std::size_t n, ContactRecorder<A>* recorder) noexcept {
  StagingBlock<A, T> stage(*batch.scene.passes, batch.state, first, n);
  Block<A> block = stage.block();
  run_steps(batch, block, recorder);
  const auto& fixed = batch.scene.scene.fixed;
  std::size_t from = first;
  for (auto next = std::lower_bound(fixed.begin(), fixed.end(), first); next != fixed.end() && *next < first + n; ++next) {
    stage.write(from, *next);
    from = *next + 1;
  }
  stage.write(from, first + n);
}

template <class A, class T>
void step_one_block(const Batch<A, T>& batch, std::size_t first, std::size_t n, ContactRecorder<A>* recorder) noexcept {
  const auto& fixed = batch.scene.scene.fixed;
  const auto next_fixed = std::lower_bound(fixed.begin(), fixed.end(), first);
  const bool has_fixed = next_fixed != fixed.end() && *next_fixed < first + n;

  if (!has_fixed && step_in_place(batch, first, n, recorder)) return;
  const std::size_t together = staged_together(batch.motion);
  for (std::size_t done = has_fixed ? 0 : step_as_they_lie(batch, first, n); done < n; done += together) {
    step_staged(batch, first + done, std::min(together, n - done), recorder);
  }
}

template <class A, class T>
void run(const Batch<A, T>& batch, const ParallelFor& parallel) noexcept {
  const std::size_t block = batch.motion.block;
  const std::size_t per_task = blocks_per_task * block;
  const bool is_worth_threads = batch.state.count * batch.steps.count >= steps_worth_threads;
  for_each_task(is_worth_threads ? parallel : ParallelFor{}, tasks_of(batch.state.count, per_task), [&](std::size_t task) {
    const std::size_t end = std::min(batch.state.count, (task + 1) * per_task);
    const auto step = [&](ContactRecorder<A>* recorder) {
      for (std::size_t first = task * per_task; first < end; first += block) {
        step_one_block(batch, first, std::min(block, end - first), recorder);
      }
    };
    if (batch.report == nullptr) return step(nullptr);
    ContactRecorder<A> recorder(*batch.report, *batch.logged, batch.scene.options.arithmetic);
    step(&recorder);
  });
}

// A call's report, and the number of the state's first particle in it.
struct Reported {
  ContactReport::Parts* report = nullptr;  // null: none
  std::size_t first = 0;
};

// Makes offsets that depend on time for some steps at a time, and others once. terms: the motion's, or with its surfaces
// moved.
template <class A, class T>
void step_free(const CompiledScene<A>& scene, const FreeMotion<A>& motion, const Terms<A>& terms, State<T>& state,
               std::size_t steps, const ParallelFor& parallel, const Reported& reported) noexcept {
  const std::size_t per_step = motion.offsets_per_step();
  const bool is_timed = motion.system.depends_on_time();
  const double h = motion.step();
  const LoggedParticles logged(scene.scene, reported.first, state.count);
  std::uint64_t number = reported.report != nullptr ? reported.report->steps + 1 : 0;
  std::array<Offsets<A>, max_offsets> offsets;
  for (std::size_t left = steps; left != 0;) {
    const std::size_t now = is_timed ? std::min(left, max_offsets / per_step) : left;
    const std::size_t made = is_timed ? now * per_step : per_step;
    Clock clock = state.clock;
    for (std::size_t k = 0; k < made; ++k) {
      motion.offsets_at(clock, offsets[k]);
      clock.advance(h / static_cast<double>(per_step), 1);
    }
    const Steps<A> run_of{.offsets = offsets.data(), .offsets_per_step = is_timed ? per_step : 0, .count = now};
    run(Batch<A, T>{scene, motion, terms, state, run_of, state.clock, reported.report, number, &logged}, parallel);
    state.clock.advance(h, static_cast<double>(now));
    number += now;
    left -= now;
  }
}

// workspace: null if nothing joins particles.
template <class A, class T>
StepResult step_by(const CompiledScene<A>& scene, JoinedWorkspace<A>* workspace, State<T>& state, std::size_t steps,
                   const ParallelFor& parallel, const Reported& reported = {}) noexcept {
  if constexpr (sizeof(A) < sizeof(T)) {
    return StepResult::done;  // no plan for float64 states computes in float32
  } else {
    if (const StepResult result = fit_of(scene, state); result != StepResult::done) return result;
    const JoinedMotion<A>* joined = scene.joined();
    if (joined != nullptr && (workspace == nullptr || !workspace->fits(joined->shape()))) return StepResult::workspace_differs;
    if (reported.report != nullptr && reported.report->centers.size() != scene.scene.contacts.size()) {
      return StepResult::report_differs;
    }
    if (scene.options.step == 0) return StepResult::done;
    const StepEnvironment environment;  // the offsets are made here, whatever the caller's rounding mode
    if (joined != nullptr) return step_joined(scene, *joined, *workspace, state, steps, parallel, reported.report);
    if (scene.particles == Particles::come_and_go && is_any_carried(scene.scene.contacts)) {
      return StepResult::workspace_differs;  // LifecyclePlan alone moves these surfaces
    }
    step_free(scene, *scene.free(), scene.free()->terms, state, steps, parallel, reported);
    return StepResult::done;
  }
}

// The same with a report, from its beginning to its end.
template <class A, class T>
StepResult report_by(const CompiledScene<A>& scene, JoinedWorkspace<A>* workspace, State<T>& state, ContactReport& report,
                     std::size_t steps, const ParallelFor& parallel) noexcept {
  if (report.parts() == nullptr) return StepResult::report_differs;
  ContactReport::Parts& parts = *report.parts();
  if (parts.centers.size() == scene.scene.contacts.size()) begin_report(parts, scene.scene);
  const StepResult result = step_by(scene, workspace, state, steps, parallel, {.report = &parts});
  if (result == StepResult::done) end_report(parts, steps);
  return result;
}

// The working memory of a caller's workspace, if it is of the plan's kind.
template <class In, class Given>
const auto* own_workspace(const In& /*in*/, const Given& given) noexcept {
  return std::get_if<std::decay_t<decltype(std::declval<In>().workspace)>>(&given);
}

}  // namespace

template <class T>
StepResult Plan<T>::step(State<T>& state, std::size_t steps, const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  const auto step = [&](const auto& in) noexcept { return step_by(*in.scene, in.workspace.get(), state, steps, parallel); };
  return std::visit(step, parts_->in);
}

template <class T>
StepResult Plan<T>::step(State<T>& state, Workspace<T>& workspace, std::size_t steps,
                         const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  if (workspace.parts_ == nullptr) return StepResult::workspace_differs;
  const auto step = [&](const auto& in) noexcept {
    const auto* given = own_workspace(in, workspace.parts_->in);
    if (given == nullptr) return StepResult::workspace_differs;
    if (*given != nullptr && (*given)->known < in.drives) return StepResult::driven_elsewhere;
    return step_by(*in.scene, given->get(), state, steps, parallel);
  };
  return std::visit(step, parts_->in);
}

template <class T>
StepResult Plan<T>::step(State<T>& state, ContactReport& contacts, std::size_t steps,
                         const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  const auto step = [&](const auto& in) noexcept {
    return report_by(*in.scene, in.workspace.get(), state, contacts, steps, parallel);
  };
  return std::visit(step, parts_->in);
}

template <class T>
StepResult Plan<T>::step(State<T>& state, Workspace<T>& workspace, ContactReport& contacts, std::size_t steps,
                         const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  if (workspace.parts_ == nullptr) return StepResult::workspace_differs;
  const auto step = [&](const auto& in) noexcept {
    const auto* given = own_workspace(in, workspace.parts_->in);
    if (given == nullptr) return StepResult::workspace_differs;
    if (*given != nullptr && (*given)->known < in.drives) return StepResult::driven_elsewhere;
    return report_by(*in.scene, given->get(), state, contacts, steps, parallel);
  };
  return std::visit(step, parts_->in);
}

template <class T>
void ReportedStep<T>::run(const Plan<T>& plan, const Terms<T>* moved, State<T>& state, std::size_t steps,
                          ContactReport::Parts* report, std::size_t first) noexcept {
  const PlanIn<T>& in = std::get<PlanIn<T>>(plan.parts_->in);
  const FreeMotion<T>& motion = *in.scene->free();
  step_free(*in.scene, motion, moved != nullptr ? *moved : motion.terms, state, steps, {}, {.report = report, .first = first});
}

template <class T>
StepResult ReportedStep<T>::meet(const Plan<T>& plan, Workspace<T>* given, State<T>& state, const ParallelFor& parallel,
                                 ContactReport::Parts* report) noexcept {
  const PlanIn<T>& in = std::get<PlanIn<T>>(plan.parts_->in);
  const auto* const own = given != nullptr ? own_workspace(in, given->parts_->in) : &in.workspace;
  const JoinedMotion<T>& motion = *in.scene->joined();
  if (own == nullptr || *own == nullptr || !(*own)->fits(motion.shape())) return StepResult::workspace_differs;
  return step_joined(*in.scene, motion, **own, state, 1, parallel, report);
}

template <class T>
void ReportedStep<T>::renumber(const Plan<T>& plan, Workspace<T>* given, std::span<const std::uint32_t> after,
                               std::size_t count) noexcept {
  const PlanIn<T>& in = std::get<PlanIn<T>>(plan.parts_->in);
  const auto* const own = given != nullptr ? own_workspace(in, given->parts_->in) : &in.workspace;
  if (own != nullptr && *own != nullptr) (*own)->meet.renumber(after, count);
}

template <class T>
const std::vector<DrivenMotion>& ReportedStep<T>::motions_of_meeting(const Plan<T>& plan) noexcept {
  return std::get<PlanIn<T>>(plan.parts_->in).workspace->motions;
}

template <class T>
const FreeMotion<T>& ReportedStep<T>::motion_of(const Plan<T>& plan) noexcept {
  return *std::get<PlanIn<T>>(plan.parts_->in).scene->free();
}

template struct ReportedStep<float>;
template struct ReportedStep<double>;
template StepResult Plan<float>::step(State<float>&, ContactReport&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<double>::step(State<double>&, ContactReport&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<float>::step(State<float>&, Workspace<float>&, ContactReport&, std::size_t,
                                      const ParallelFor&) const noexcept;
template StepResult Plan<double>::step(State<double>&, Workspace<double>&, ContactReport&, std::size_t,
                                       const ParallelFor&) const noexcept;
template StepResult Plan<float>::step(State<float>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<double>::step(State<double>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<float>::step(State<float>&, Workspace<float>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<double>::step(State<double>&, Workspace<double>&, std::size_t, const ParallelFor&) const noexcept;

}  // namespace dvdx
