// A call of step() where springs join particles: copy the state into the working columns, run all steps there, copy it back.
#include "plan/network_stepper.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "constraint/constraint_step.hpp"
#include "contact/faces/face_step.hpp"
#include "meet/meet_step.hpp"
#include "plan/joined_air.hpp"
#include "plan/joined_call.hpp"
#include "plan/joined_copies.hpp"
#include "plan/joined_flow.hpp"
#include "plan/joined_followers.hpp"
#include "plan/joined_pulses.hpp"
#include "plan/joined_stages.hpp"
#include "skin/ball_step.hpp"
#include "springs/network_forms.hpp"
#include "springs/sweep/sweep_step.hpp"
#include "work/environment.hpp"
#include "work/stepping.hpp"
#include "work/tasks.hpp"

namespace dvdx {
namespace {

template <class T>
class NetworkStepper {
 public:
  NetworkStepper(const CompiledScene<T>& scene, const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace,
                 std::size_t particles, const ParallelFor& parallel, ContactReport::Parts* report) noexcept
      : call_(scene, motion, workspace, particles, parallel, report), m_(motion), network_(motion.network()), ws_(workspace) {
    if (network_.constraints) {
      constraint_terms_ = ws_.with_columns(network_.constraints->terms());
      constraints_.emplace(*network_.constraints, scene.passes->template of<T>().constraint, constraint_terms_, call_.parallel);
    }
    sheets_.end = visit_form(network_.form, [](const auto& form) { return form.sheets(); });
    if (network_.balls) {
      balls_.emplace(BallsOfScene<T>{network_.balls->lists(), ws_.balls, m_.skins(), ws_.skins, ws_.poses, m_.origin(),
                                     network_.substep()},
                     work_, scene.passes->template of<T>().ball, call_.parallel);
    }
    if (network_.meet) {
      meet_.emplace(MeetingsOfScene<T>{*network_.meet, network_.order, m_.origin(), m_.slowest_bounce(), m_.parting()},
                    ws_.meet, work_, particles, scene.options.elsewhere, scene.passes->template of<T>().meet, call_.parallel,
                    report);
    }
    if (m_.faces() != nullptr) {
      faces_.emplace(FacesOfScene{*m_.faces(), network_.order.size, m_.origin(), m_.tracks(), ws_.motions}, ws_.faces, work_,
                     call_.parallel, report);
    }
  }
  NetworkStepper(const NetworkStepper&) = delete;
  NetworkStepper& operator=(const NetworkStepper&) = delete;

  template <class Kept>
  void fetch_all(const State<Kept>& state) noexcept {
    JoinedCopies<T>(call_).fetch_all(state);
    followers_.arrive(state.clock);
    if (constraints_) constraints_->prepare(work_.x);
    if (balls_) balls_->prepare(state.clock);
    if (faces_) faces_->prepare();
    if (meet_ && !ws_.remembers(state.x[0].base, state.clock)) ws_.meet.forget();
    if (work_.a[0] != nullptr) recall(state);
    if (flow_.still().is_kept()) flow_.still().note_all();
  }

  // Leaves the workspace for the next call, which may carry on what springs and meetings do to this state.
  template <class Kept>
  void leave(const State<Kept>& state) noexcept {
    ws_.work = work_;
    if (work_.a[0] != nullptr || meet_) ws_.remember(state.x[0].base, state.clock);
  }

  template <class Kept>
  void put_back_all(const State<Kept>& state) noexcept {
    JoinedCopies<T>(call_).put_back_all(state);
  }

  // For a call of no steps: puts kinematic particles where their motions have them at this time.
  template <class Kept>
  void store_kinematic(const State<Kept>& state) noexcept {
    for (const PinnedState<T>& held : call_.held) {
      if (followers_.is_kinematic(held)) JoinedCopies<T>(call_).put_back_held(held, state);
    }
  }

  // Leaves the clock at the end of the last step.
  void run(Clock& clock, double step, std::size_t steps) noexcept {
    if (goes_by_sheets()) return run_by_sheets(clock, step, steps);
    const std::size_t stages = stages_.at_once();
    for (std::size_t n = 0; n < steps; ++n) {
      if (stages < 2) {
        this->step(clock);
      } else {
        stages_.add_step(clock, stages);
      }
      clock.advance(step, 1);
      ++call_.number;
      if (has_too_many_) return;
    }
    stages_.run();
  }
  // Whether a particle had more neighbours than there is room for. The step has then not ended.
  [[nodiscard]] bool has_too_many() const noexcept { return has_too_many_; }

 private:
  using After = typename JoinedFlow<T>::After;

  // Steps one sheet of a stack in the working columns of `whole`, on one thread.
  NetworkStepper(const NetworkStepper& whole, std::size_t sheet) noexcept
      : NetworkStepper(whole.call_.scene, whole.m_, whole.ws_, whole.call_.particles, ParallelFor{}, whole.call_.report) {
    const std::size_t each = whole.call_.end / whole.sheets_.end;
    call_.first = sheet * each;
    call_.end = call_.first + each;
    sheets_ = {sheet, sheet + 1};
    is_start_ = whole.is_start_;
    call_.number = whole.call_.number;
  }

  // Whether independent sheets are stepped one by one: one fits in cache, together they do not.
  [[nodiscard]] bool goes_by_sheets() const noexcept {
    return sheets_.end - sheets_.first > 1 && !m_.closes_substeps() && !network_.air && m_.tracks().empty();
  }
  void run_by_sheets(Clock& clock, double step, std::size_t steps) noexcept {
    for_each_task(call_.parallel, sheets_.end, [&](std::size_t sheet) {
      NetworkStepper part(*this, sheet);
      Clock of_part = clock;
      part.run(of_part, step, steps);
    });
    for (std::size_t n = 0; n < steps; ++n) clock.advance(step, 1);
  }

  template <class Kept>
  void recall(const State<Kept>& state) noexcept {
    if (ws_.remembers(state.x[0].base, state.clock)) return;
    ws_.forget();
    for (T* const a : work_.a) std::fill_n(a, call_.size(), T(0));
    is_start_ = true;
  }

  // ---- a step ------------------------------------------------------------------------------------------------------------

  void step(const Clock& clock) noexcept {
    call_.begin_step(clock);
    begin_driven_paths();
    sweeps_.begin_step();
    flow_.still().begin();
    for (int substep = 0; substep < network_.chosen.substeps; ++substep) {
      const Clock begun = call_.clock;
      if (meet_) meet_->begin_driven_paths();
      air_.begin_substep(substep);
      const auto& before = substep == 0 ? m_.first() : m_.again();
      for (std::size_t k = 0; k < before.size(); ++k) {
        visit_form(network_.form, [&](const auto& form) { act(form, before[k], k); });
        flow_.still().note_pulse(k);
      }
      if (m_.closes_substeps()) close_substep(begun);
      if (has_too_many_) return;
      if (moves_alone()) flow_.run(*m_.last());
    }
    if (m_.last() && !m_.closes_substeps() && !moves_alone()) flow_.run(*m_.last());
    flow_.apply_pending_shift();
    if (m_.settling()) settle();
    if (call_.is_relative()) followers_.rebase_origin();
  }

  // Starts everything driven on this step's path.
  void begin_driven_paths() noexcept {
    followers_.begin_driven_paths();
    if (balls_) balls_->begin_driven_paths(call_.clock, network_.step);
    if (faces_) faces_->begin_driven_paths(call_.clock);
  }

  // Whether no pulse stands between the flows of two sub-steps.
  [[nodiscard]] bool moves_alone() const noexcept { return m_.again().empty() && !m_.closes_substeps(); }

  void settle() noexcept {
    call_.clock = call_.step_end;
    flow_.settle(*m_.settling());
    if (constraints_) constraints_->prepare(work_.x);  // as at the beginning of a call
    if (balls_) balls_->prepare(call_.clock);
  }

  // Constraints, balls and faces close each sub-step, which therefore ends with a flow of its own.
  void close_substep(const Clock& begun) noexcept {
    if (m_.last()) flow_.run(*m_.last());
    flow_.apply_pending_shift();
    if (meet_ && !keep_apart()) return;
    if (constraints_) constraints_->solve(work_.x, work_.v);
    if (balls_) balls_->keep(call_.end_of_flow());
    if (!faces_ || !faces_->meet(begun, call_.end_of_flow(), network_.substep())) return;
    if (constraints_) constraints_->prepare(work_.x);
    if (balls_) balls_->prepare(call_.end_of_flow());
  }

  // Keeps meeting particles apart. Returns false if one has more neighbours than there is room for.
  [[nodiscard]] bool keep_apart() noexcept {
    if (network_.substep() == 0) return true;
    const Terms<T>& terms = !ws_.surfaces.empty() ? followers_.moved_terms() : m_.flows()[0]->terms;
    has_too_many_ =
        meet_->meet(terms.surfaces, terms.surface_count, static_cast<T>(network_.substep())) == MeetStep<T>::Found::too_many;
    return !has_too_many_;
  }

  // ---- a flow, then the action of springs --------------------------------------------------------------------------------

  template <class Form>
  void act(const Form& form, std::size_t f, std::size_t k) noexcept {
    if constexpr (Form::act == SpringsAct::in_sweeps) flow_and_sweep(form, f);
    if constexpr (Form::act == SpringsAct::in_pair_sums) flow_by_pairs(form, f);
    if constexpr (Form::act == SpringsAct::in_pulses) flow_and_pulse(form, f, k);
  }

  template <class Form>
  void flow_and_pulse(const Form& form, std::size_t f, std::size_t k) noexcept {
    flow_.run(f);
    const double air = air_.part_of(k);
    if (air != 0) air_.keep_velocity();
    pulses_.pulse(form, k);
    if (air != 0) air_.blow_in_the_middle(air);
  }
  // Brown's contributions cover the whole sub-step, from its start.
  template <class Form>
  void flow_by_pairs(const Form& form, std::size_t f) noexcept {
    if (air_.blows()) air_.blow_on_velocity(0.5);
    pulses_.sum_pairs(form);
    flow_.run(f, After::pairs);
    if (air_.blows()) air_.blow_on_velocity(0.5);
  }

  template <class Form>
  void flow_and_sweep(const Form& form, std::size_t f) noexcept {
    if (form.alpha) return flow_and_sweep(form, *form.alpha, f);
    flow_.run(f);
    if (air_.blows()) air_.keep_velocity();
    form.sweep(sweeps_, ws_.with_columns(form.terms));
    flow_.leave({.shift = &form.shift});
    if (air_.blows()) blow_after_sweeps();
  }
  template <class Form>
  void flow_and_sweep(const Form& form, const Alpha<T>& alpha, std::size_t f) noexcept {
    const bool is_start = std::exchange(is_start_, false);
    const AlphaTerms<T>& terms = is_start ? alpha.start : alpha.on;
    flow_.run(f, After::nothing, &terms);
    if (air_.blows()) air_.keep_velocity();
    std::swap(work_.v, work_.v_next);  // one column if nothing damps
    form.sweep(sweeps_, ws_.with_columns(is_start ? alpha.sweeps_of_start : form.terms));
    std::swap(work_.v, work_.v_next);
    flow_.leave({.alpha = &terms});
    if (air_.blows()) blow_after_sweeps();
  }
  void blow_after_sweeps() noexcept {
    flow_.apply_pending_shift();
    air_.blow_in_the_middle(1);
  }

  JoinedCall<T> call_;
  const JoinedMotion<T>& m_;
  const CompiledNetwork<T>& network_;
  JoinedWorkspace<T>& ws_;
  WorkColumns<T>& work_ = call_.work;
  JoinedFollowers<T> followers_{call_};
  JoinedFlow<T> flow_{call_, followers_};
  JoinedPulses<T> pulses_{call_};
  JoinedAir<T> air_{call_};
  JoinedStages<T> stages_{call_, followers_, flow_};
  typename SweepStep<T>::Sheets sheets_{};
  SweepStep<T> sweeps_{.order = network_.coupling.sweeps,
                       .particles = network_.order,
                       .records = network_.halo.records,
                       .kernels = call_.kernels,
                       .work = work_,
                       .rooms = ws_.line_rooms,
                       .exchange = call_.exchange,
                       .parallel = call_.parallel,
                       .sheets = sheets_};
  ConstraintTerms<T> constraint_terms_{};
  std::optional<ConstraintStep<T>> constraints_;
  std::optional<BallStep<T>> balls_;
  std::optional<MeetStep<T>> meet_;
  std::optional<FaceStep<T>> faces_;
  bool has_too_many_ = false;
  bool is_start_ = false;  // the next sub-step has no acceleration to start from
};

}  // namespace

template <class T, class Kept>
StepResult step_joined(const CompiledScene<T>& scene, const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace,
                       State<Kept>& state, std::size_t steps, const ParallelFor& parallel,
                       ContactReport::Parts* report) noexcept {
  const Stepping stepping(workspace.is_stepping);
  if (!stepping) return StepResult::in_use;
  if (steps == 0 && motion.network().fixed.empty()) return StepResult::done;
  NetworkStepper<T> call(scene, motion, workspace, state.count, parallel, report);
  call.fetch_all(state);
  if (steps == 0) {
    call.store_kinematic(state);
    return StepResult::done;
  }
  Clock clock = state.clock;
  call.run(clock, scene.options.step, steps);
  if (call.has_too_many()) {
    workspace.forget();
    return StepResult::too_many_neighbours;
  }
  state.clock = clock;
  call.put_back_all(state);
  call.leave(state);
  return StepResult::done;
}

template StepResult step_joined(const CompiledScene<float>&, const JoinedMotion<float>&, JoinedWorkspace<float>&, State<float>&,
                                std::size_t, const ParallelFor&, ContactReport::Parts*) noexcept;
template StepResult step_joined(const CompiledScene<double>&, const JoinedMotion<double>&, JoinedWorkspace<double>&,
                                State<double>&, std::size_t, const ParallelFor&, ContactReport::Parts*) noexcept;
template StepResult step_joined(const CompiledScene<double>&, const JoinedMotion<double>&, JoinedWorkspace<double>&,
                                State<float>&, std::size_t, const ParallelFor&, ContactReport::Parts*) noexcept;

}  // namespace dvdx
