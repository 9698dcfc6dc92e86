// A call of LifecyclePlan::step: in batches of steps, live particles are stepped and compacted, and births are appended.
#include <algorithm>
#include <span>

#include "contact/report/contact_recorder.hpp"
#include "contact/surfaces/make_surface.hpp"
#include "dvdx/layouts/convert.hpp"
#include "lifecycle/any_order.hpp"
#include "lifecycle/compiled_lifecycle.hpp"
#include "lifecycle/live_births.hpp"
#include "lifecycle/live_chunks.hpp"
#include "lifecycle/live_columns.hpp"
#include "lifecycle/live_segments.hpp"
#include "meet/meet.hpp"
#include "plan/reported_step.hpp"
#include "scene/checker.hpp"
#include "scene/particle_values.hpp"
#include "work/environment.hpp"
#include "work/stepping.hpp"
#include "work/tasks.hpp"

namespace dvdx {

namespace {

// The first number of burst births. Births by time never reach it.
constexpr std::uint64_t first_of_bursts = std::uint64_t{1} << 63U;

template <class T>
class LifecycleStep {
 public:
  LifecycleStep(const CompiledLifecycle<T>& compiled, LifecycleWorkspace<T>& workspace, LiveState<T>& live,
                const ParallelFor& parallel, ContactReport::Parts* report) noexcept
      : p_(compiled),
        ws_(workspace),
        live_(live),
        parallel_(parallel),
        report_(report),
        chunks_(compiled, workspace, live, report),
        living_(compiled.turnover.capacity),
        moves_(moves_anything(compiled)),
        moves_surfaces_(moves_contacts(compiled)),
        meets_(meets(compiled)) {}

  // Steps batch by batch.
  StepResult step(std::size_t steps) noexcept {
    // Four cases go one step at a time. Holes: which particle fills which depends on the births of the steps before. Reports:
    // a particle is known by its place when its step begins. Motions: everything on one has one pose a step. Meetings: who
    // meets whom depends on who lives.
    const bool goes_singly = fills_holes(p_.turnover.removal) || report_ != nullptr || moves_ || meets_;
    const std::size_t most = goes_singly ? 1 : batch_steps;
    for (std::size_t left = steps; left != 0;) {
      const std::size_t now = batch_of(std::min(left, most));
      begin_driven_paths();
      if (const StepResult result = meet(); result != StepResult::done) return result;
      step_batch(now);
      if (report_ != nullptr) report_->steps += now;
      left -= now;
    }
    return StepResult::done;
  }

  void burst(std::size_t emitter, std::uint64_t births) noexcept {
    EmissionTerms at_once = p_.emitters[emitter];
    at_once.interval = 0;
    LiveFollowers<T>& followers = ws_.followers;
    for (std::size_t k = 0; k < p_.tracks.size(); ++k)
      followers.poses[k] = followers.motions[k].at(p_.tracks[k], live_.state.clock);
    count_for(births);
    append(at_once, carrier_of(p_, followers, emitter), first_of_bursts + live_.born, births, 0);
  }

  void remove() noexcept {
    const ParticleGroup all{.first = 0, .count = live_.state.count, .steps = 0, .clock = live_.state.clock};
    compact_all({&all, 1});
  }

 private:
  // Consecutive births of one emitter within one step, and where they stand.
  struct Run {
    const EmissionTerms* emitter = nullptr;
    const MovedPose* carrier = nullptr;
    Births births{};
    std::size_t at = 0;
    std::size_t pieces = 0;    // of born_together
    std::uint64_t number = 0;  // births of all parts before
  };

  // ---- how many steps at once ---------------------------------------------------------------------------------------------

  [[nodiscard]] std::uint64_t born_until(std::size_t step) const noexcept {
    std::uint64_t born = 0;
    for (std::size_t e = 0; e < p_.emitters.size(); ++e) born += ws_.births[step][e].whole - ws_.births[0][e].whole;
    return born;
  }

  // The number of steps, at most `most`, that leave room for all their births even if nothing dies: which births find no room
  // must not depend on how steps are batched. One step is always possible, as its births come after its deaths.
  [[nodiscard]] std::size_t batch_of(std::size_t most) noexcept {
    ws_.clocks[0] = live_.state.clock;
    for (std::size_t n = 0; n <= most; ++n) {
      if (n != 0) {
        ws_.clocks[n] = ws_.clocks[n - 1];
        ws_.clocks[n].advance(p_.plan.step_size(), 1);
      }
      for (std::size_t e = 0; e < p_.emitters.size(); ++e) {
        ws_.births[n][e] = births_until(p_.turnover.emitters[e], ws_.clocks[n]);
      }
    }
    count_for(born_until(most));
    while (most > 1 && born_until(most) > room()) most /= 2;
    return most;
  }

  // Counts all live particles, unless so many births are known to find room.
  void count_for(std::uint64_t births) noexcept {
    if (births <= room()) return;
    const std::uint64_t here = live_.state.count;
    living_ = p_.shared.parts == 1 ? here : p_.shared.count_all(p_.shared.context, here);
  }
  [[nodiscard]] std::uint64_t room() const noexcept { return p_.turnover.capacity - living_; }

  // Steps all particles if they meet: together, not chunk by chunk.
  [[nodiscard]] StepResult meet() noexcept {
    if (!meets_) return StepResult::done;
    State<T> state = live_.state;
    return ReportedStep<T>::meet(p_.plan, ws_.meeting ? &*ws_.meeting : nullptr, state, parallel_, report_);
  }

  void step_batch(std::size_t steps) noexcept {
    if (fills_holes(p_.turnover.removal) && born_until(1) <= p_.turnover.capacity - live_.state.count) {
      step_in_any_order(born_until(1));
      live_.state.clock = ws_.clocks[1];
      return;
    }
    const ParticleGroup all{
        .first = 0, .count = live_.state.count, .steps = steps, .clock = ws_.clocks[0], .is_stepped = meets_};
    compact_all({&all, 1});
    emit(steps);
    live_.state.clock = ws_.clocks[steps];
  }

  // ---- what follows a motion ----------------------------------------------------------------------------------------------

  // Before a step: finds all poses at its end, and moves surfaces there.
  void begin_driven_paths() noexcept {
    LiveFollowers<T>& followers = ws_.followers;
    followers.moved = nullptr;
    const auto& [start, end] = std::pair(ws_.clocks[0], ws_.clocks[1]);
    for (std::size_t k = 0; k < p_.tracks.size() && moves_; ++k) {
      DrivenMotion& motion = followers.motions[k];
      motion.arrive(p_.tracks[k], start);
      motion.begin(p_.tracks[k], start, p_.plan.step_size());
      followers.poses[k] = motion.at_end_of(p_.tracks[k], start, end);
    }
    if (moves_surfaces_) move_surfaces();
  }

  void move_surfaces() noexcept {
    LiveFollowers<T>& followers = ws_.followers;
    const Terms<T>& resting = ReportedStep<T>::motion_of(p_.plan).terms;
    followers.terms = resting;
    followers.terms.surfaces = followers.surfaces.data();
    followers.moved = &followers.terms;
    for (std::size_t j = 0; j < resting.surface_count; ++j) {
      Surface<T>& surface = followers.surfaces[j];
      surface = resting.surfaces[j];
      const Contact& contact = p_.plan.scene().contacts[surface.contact];
      const auto& of = motion_of(contact);
      if (!of) continue;
      const MovedPose& pose = followers.poses[*of];
      move_surface(surface, contact, pose, Vec3{});
      if (report_ != nullptr) report_->centers[surface.contact] = {pose.place(pose.center), pose.velocity};
      if (surface.movement != Movement::rest) followers.terms.moves = true;
    }
  }

  // ---- births -------------------------------------------------------------------------------------------------------------

  void emit(std::size_t steps) noexcept {
    count_for(born_until(steps));
    std::array<ParticleGroup, batch_steps> groups{};
    const std::size_t before = live_.state.count;
    for (std::size_t n = 0; n < steps; ++n) {
      groups[n] = {.first = live_.state.count, .count = 0, .steps = steps - 1 - n, .clock = ws_.clocks[n + 1], .is_new = true};
      for (std::size_t e = 0; e < p_.emitters.size(); ++e) emit_run(e, n);
      groups[n].count = live_.state.count - groups[n].first;
    }
    if (live_.state.count != before) compact_all({groups.data(), steps});
  }

  void emit_run(std::size_t emitter, std::size_t step) noexcept {
    const std::uint64_t first = ws_.births[step][emitter].whole;
    const BirthCount& end = ws_.births[step + 1][emitter];
    append(p_.emitters[emitter], carrier_of(p_, ws_.followers, emitter), first, end.whole - first,
           (end.number - TwoDouble(static_cast<double>(first) + 1)).value());
  }

  // Appends births from number `first` on. lead: the age of the first one, in intervals.
  void append(const EmissionTerms& emitter, const MovedPose* carrier, std::uint64_t first, std::uint64_t wanted,
              double lead) noexcept {
    const std::uint64_t all = std::min(wanted, room());
    const std::uint64_t number = live_.born;
    living_ += all;
    live_.born += all;
    live_.dropped += wanted - all;
    const BirthRange here = share_of(first, all);
    if (here.count == 0) return;
    const auto count = static_cast<std::size_t>(here.count);
    run_ = {.emitter = &emitter,
            .carrier = carrier,
            .births = {.first = first + here.first,
                       .count = count,
                       .lead = lead - static_cast<double>(here.first),
                       .step = p_.plan.step_size()},
            .at = live_.state.count,
            .pieces = (count + born_together - 1) / born_together,
            .number = number + here.first};
    live_.state.count += count;
    const bool is_worth_threads = parallel_.run != nullptr && count >= steps_worth_threads / batch_steps;
    for_each_task(is_worth_threads ? parallel_ : ParallelFor{}, run_.pieces, [this](std::size_t piece) { emit_piece(piece); });
  }

  // This part's share of `all` births from number `first` on. The shares are as equal as possible, and the parts that have one
  // more rotate with the number.
  [[nodiscard]] BirthRange share_of(std::uint64_t first, std::uint64_t all) const noexcept {
    const std::uint64_t parts = p_.shared.parts;
    const std::uint64_t each = all / parts, more = all % parts;
    const std::uint64_t turn = (p_.shared.part + parts - first % parts) % parts;
    return {.first = turn * each + std::min(turn, more), .count = each + (turn < more ? 1 : 0)};
  }

  void emit_piece(std::size_t piece) const noexcept {
    const std::size_t from = piece * born_together;
    Births births = run_.births;
    births.first += from;
    births.count = std::min(born_together, births.count - from);
    births.lead -= static_cast<double>(from);
    BornBlock<T> block;
    make_births(p_.passes, *run_.emitter, run_.carrier, births, block);
    put_births(block, live_, run_.number + from, [at = run_.at + from](std::size_t k) { return at + k; });
  }

  // ---- steps and removal --------------------------------------------------------------------------------------------------

  // Steps the groups, which lie one behind the other up to the last live particle, and compacts the survivors.
  void compact_all(std::span<const ParticleGroup> groups) noexcept {
    const std::size_t first = groups.front().first;
    const std::size_t before = live_.state.count;
    std::size_t work = 0;
    for (const ParticleGroup& group : groups) work += group.count * std::max<std::size_t>(group.steps, 1);
    if (fills_holes(p_.turnover.removal)) {
      live_.state.count = fill_holes(groups.front());
    } else if (meets_) {
      live_.state.count = compact_in_order(groups, first);
      if (first == 0 && live_.state.count != before) renumber(before);
    } else {
      live_.state.count = threads_for(work).run != nullptr ? compact_in_parallel(groups) : compact_in_order(groups, first);
    }
    live_.removed += before - live_.state.count;
  }

  // No threads if waking them costs more than it saves.
  [[nodiscard]] ParallelFor threads_for(std::size_t work) const noexcept {
    return work >= steps_worth_threads ? parallel_ : ParallelFor{};
  }

  std::size_t compact_in_order(std::span<const ParticleGroup> groups, std::size_t to) noexcept {
    for (const ParticleGroup& group : groups) {
      chunks_.for_each(group, [&](const ParticleGroup& chunk) {
        Removed removed{};
        const auto stepped = chunks_.step_chunk(chunk, 0, removed);
        if (meets_) note_numbers(chunk, removed, to);
        chunks_.move_survivors(stepped, chunk, removed, to);
        to += stepped.kept;
      });
    }
    return to;
  }

  std::size_t compact_in_parallel(std::span<const ParticleGroup> groups) noexcept {
    return LiveSegments<T>(p_, ws_, live_, chunks_, parallel_).compact(groups);
  }

  // Notes the numbers of a chunk's particles after the removal. The survivors have `to` and on.
  void note_numbers(const ParticleGroup& chunk, const Removed& removed, std::size_t to) const noexcept {
    for (std::size_t i = 0; i < chunk.count; ++i) {
      const bool stays = !is_removed(removed.data(), i);
      ws_.after[chunk.first + i] = stays ? static_cast<std::uint32_t>(to) : no_partner;
      to += stays ? 1U : 0U;
    }
  }
  // Renumbers the pulses of pairs with their particles.
  void renumber(std::size_t before) noexcept {
    ReportedStep<T>::renumber(p_.plan, ws_.meeting ? &*ws_.meeting : nullptr, std::span(ws_.after).first(before),
                              live_.state.count);
  }

  // ---- in any order -------------------------------------------------------------------------------------------------------

  // Makes one step in which all births are sure of room: they take the places of removed particles.
  void step_in_any_order(std::uint64_t births) noexcept {
    const std::uint64_t before = live_.state.count + births;
    const ParticleGroup all{.first = 0, .count = live_.state.count, .steps = 1, .clock = ws_.clocks[0]};
    AnyOrder<T> step(p_, ws_, live_, chunks_, births, live_.born);
    const auto ends = step.step(all, threads_for(all.count + births));
    living_ += births;
    live_.born += births;
    live_.state.count =
        fill_holes({.first = ends.of_seen, .count = ends.of_all - ends.of_seen, .clock = ws_.clocks[1], .is_new = true});
    live_.removed += before - live_.state.count;
  }

  // Steps a group that reaches to the last live particle, and fills the holes. Returns the new end.
  std::size_t fill_holes(const ParticleGroup& group) noexcept {
    if (group.count == 0) return group.first;
    AnyOrder<T> step(p_, ws_, live_, chunks_, 0, live_.born);
    return step.step(group, threads_for(group.count)).of_all;
  }

  const CompiledLifecycle<T>& p_;
  LifecycleWorkspace<T>& ws_;
  LiveState<T>& live_;
  ParallelFor parallel_;
  ContactReport::Parts* report_;  // null: no report is wanted
  LiveChunks<T> chunks_;
  std::uint64_t living_;         // at most, over all parts
  bool moves_, moves_surfaces_;  // whether anything, and whether contacts follow a motion
  bool meets_;
  Run run_{};
};

template <class T>
StepResult check_live(const CompiledLifecycle<T>& compiled, const LiveState<T>& live) noexcept {
  const std::size_t capacity = compiled.turnover.capacity;
  const auto is_small = [capacity](const Column<T>& column) { return column.capacity < capacity || column.base == nullptr; };
  bool is_any_small = live.state.count > capacity;
  for (const auto* columns : {&live.state.x, &live.state.v}) {
    is_any_small = is_any_small || std::any_of(columns->begin(), columns->end(), is_small);
  }
  for (const auto* column : {&live.age, &live.lifetime}) {
    is_any_small = is_any_small || (column->base != nullptr && is_small(*column));
  }
  const auto is_nowhere = [](const Carried& column) { return column.base == nullptr && column.bytes != 0; };
  is_any_small = is_any_small || (live.lifetime.base != nullptr && live.age.base == nullptr) ||
                 std::any_of(live.carried.begin(), live.carried.end(), is_nowhere);
  if (is_any_small) return StepResult::capacity_too_small;
  return live.state.clock.is_finite() ? StepResult::done : StepResult::time_not_finite;
}

template <class T, class Work>
StepResult run(const CompiledLifecycle<T>& compiled, LifecycleWorkspace<T>& workspace, LiveState<T>& live,
               const ParallelFor& parallel, ContactReport::Parts* report, const Work& work) noexcept {
  if (const StepResult result = check_live(compiled, live); result != StepResult::done) return result;
  const Stepping stepping(workspace.is_stepping);
  if (!stepping) return StepResult::in_use;
  const StepEnvironment environment;
  LifecycleStep<T> now(compiled, workspace, live, parallel, report);
  return work(now);
}

// The same with a report, from its beginning to its end.
template <class T, class Work>
StepResult run_reported(const CompiledLifecycle<T>& compiled, LifecycleWorkspace<T>& workspace, LiveState<T>& live,
                        ContactReport& contacts, const ParallelFor& parallel, const Work& work) noexcept {
  if (contacts.parts() == nullptr) return StepResult::report_differs;
  ContactReport::Parts& report = *contacts.parts();
  const Scene& scene = compiled.plan.scene();
  if (report.centers.size() != scene.contacts.size()) return StepResult::report_differs;
  begin_report(report, scene);
  const StepResult result = run(compiled, workspace, live, parallel, &report, work);
  if (result == StepResult::done) end_report(report, 0);  // its steps have been counted
  return result;
}

template <class T>
auto steps_of(std::size_t steps) noexcept {
  return [steps](LifecycleStep<T>& now) { return now.step(steps); };
}

template <class T>
auto removal() noexcept {
  return [](LifecycleStep<T>& now) {
    now.remove();
    return StepResult::done;
  };
}

template <class T>
Expected<void> burst_in(const CompiledLifecycle<T>& compiled, LifecycleWorkspace<T>& workspace, LiveState<T>& live,
                        std::size_t index, std::size_t births) {
  const std::size_t emitters = compiled.emitters.size();
  if (index >= emitters) return tl::unexpected(no_such("emitters", index, emitters));
  const auto work = [index, births](LifecycleStep<T>& now) {
    now.burst(index, births);
    return StepResult::done;
  };
  if (run(compiled, workspace, live, {}, nullptr, work) == StepResult::done) return {};
  return tl::unexpected(
      Error{"live", "not fit for it", "a state that step() would take, of a plan that no other thread steps"});
}

}  // namespace

template <class T>
Expected<void> LifecyclePlan<T>::burst(LiveState<T>& live, std::size_t index, std::size_t births) const {
  if (parts_ == nullptr) return tl::unexpected(moved_from("plan"));
  return burst_in(parts_->compiled, parts_->workspace, live, index, births);
}
template <class T>
Expected<void> LifecyclePlan<T>::burst(LiveState<T>& live, LiveWorkspace<T>& workspace, std::size_t index,
                                       std::size_t births) const {
  if (parts_ == nullptr) return tl::unexpected(moved_from("plan"));
  if (workspace.parts_ == nullptr) return tl::unexpected(moved_from("workspace"));
  if (fit_of(workspace) != StepResult::done) return tl::unexpected(Error{"workspace", "of another scene", "made by this plan"});
  return burst_in(parts_->compiled, workspace.parts_->workspace, live, index, births);
}

template <class T>
StepResult LifecyclePlan<T>::fit_of(const LiveWorkspace<T>& workspace) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  if (workspace.parts_ == nullptr) return StepResult::workspace_differs;
  const LifecycleWorkspace<T>& own = workspace.parts_->workspace;
  if (own.shape != parts_->workspace.shape) return StepResult::workspace_differs;
  return own.known < parts_->drives ? StepResult::driven_elsewhere : StepResult::done;
}

template <class T>
StepResult LifecyclePlan<T>::step(LiveState<T>& live, std::size_t steps, const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  return run(parts_->compiled, parts_->workspace, live, parallel, nullptr, steps_of<T>(steps));
}
template <class T>
StepResult LifecyclePlan<T>::step(LiveState<T>& live, ContactReport& contacts, std::size_t steps,
                                  const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  return run_reported(parts_->compiled, parts_->workspace, live, contacts, parallel, steps_of<T>(steps));
}
template <class T>
StepResult LifecyclePlan<T>::step(LiveState<T>& live, LiveWorkspace<T>& workspace, std::size_t steps,
                                  const ParallelFor& parallel) const noexcept {
  if (const StepResult fit = fit_of(workspace); fit != StepResult::done) return fit;
  return run(parts_->compiled, workspace.parts_->workspace, live, parallel, nullptr, steps_of<T>(steps));
}
template <class T>
StepResult LifecyclePlan<T>::step(LiveState<T>& live, LiveWorkspace<T>& workspace, ContactReport& contacts, std::size_t steps,
                                  const ParallelFor& parallel) const noexcept {
  if (const StepResult fit = fit_of(workspace); fit != StepResult::done) return fit;
  return run_reported(parts_->compiled, workspace.parts_->workspace, live, contacts, parallel, steps_of<T>(steps));
}

template <class T>
StepResult LifecyclePlan<T>::remove(LiveState<T>& live, const ParallelFor& parallel) const noexcept {
  if (parts_ == nullptr) return StepResult::moved_from;
  return run(parts_->compiled, parts_->workspace, live, parallel, nullptr, removal<T>());
}
template <class T>
StepResult LifecyclePlan<T>::remove(LiveState<T>& live, LiveWorkspace<T>& workspace,
                                    const ParallelFor& parallel) const noexcept {
  if (const StepResult fit = fit_of(workspace); fit != StepResult::done) return fit;
  return run(parts_->compiled, workspace.parts_->workspace, live, parallel, nullptr, removal<T>());
}

template StepResult LifecyclePlan<float>::fit_of(const LiveWorkspace<float>&) const noexcept;
template StepResult LifecyclePlan<double>::fit_of(const LiveWorkspace<double>&) const noexcept;
template StepResult LifecyclePlan<float>::step(LiveState<float>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<double>::step(LiveState<double>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<float>::step(LiveState<float>&, ContactReport&, std::size_t,
                                               const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<double>::step(LiveState<double>&, ContactReport&, std::size_t,
                                                const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<float>::step(LiveState<float>&, LiveWorkspace<float>&, std::size_t,
                                               const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<double>::step(LiveState<double>&, LiveWorkspace<double>&, std::size_t,
                                                const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<float>::step(LiveState<float>&, LiveWorkspace<float>&, ContactReport&, std::size_t,
                                               const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<double>::step(LiveState<double>&, LiveWorkspace<double>&, ContactReport&, std::size_t,
                                                const ParallelFor&) const noexcept;
template Expected<void> LifecyclePlan<float>::burst(LiveState<float>&, std::size_t, std::size_t) const;
template Expected<void> LifecyclePlan<double>::burst(LiveState<double>&, std::size_t, std::size_t) const;
template Expected<void> LifecyclePlan<float>::burst(LiveState<float>&, LiveWorkspace<float>&, std::size_t, std::size_t) const;
template Expected<void> LifecyclePlan<double>::burst(LiveState<double>&, LiveWorkspace<double>&, std::size_t,
                                                     std::size_t) const;
template StepResult LifecyclePlan<float>::remove(LiveState<float>&, const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<double>::remove(LiveState<double>&, const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<float>::remove(LiveState<float>&, LiveWorkspace<float>&, const ParallelFor&) const noexcept;
template StepResult LifecyclePlan<double>::remove(LiveState<double>&, LiveWorkspace<double>&,
                                                  const ParallelFor&) const noexcept;

}  // namespace dvdx
