// A call of step() where springs join particles: copy the state into the working columns, run all steps there, copy it back.
#include "plan/step_joined.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "constraint/constraint_step.hpp"
#include "contact/faces/face_step.hpp"
#include "contact/surfaces/make_surface.hpp"
#include "meet/meet_step.hpp"
#include "plan/state_io.hpp"
#include "plan/still.hpp"
#include "plan/working_copies.hpp"
#include "scene/particle_values.hpp"
#include "skin/ball_step.hpp"
#include "springs/sweep/sweep_step.hpp"
#include "topology/halo.hpp"
#include "work/environment.hpp"
#include "work/stepping.hpp"
#include "work/tasks.hpp"
#include "work/tiles.hpp"

namespace dvdx {
namespace {

constexpr std::size_t max_flows = 8;
// The piece of a large sheet that goes through several stages at once: so much stays in the second-level cache of one core.
constexpr std::size_t bytes_in_cache = std::size_t{1} << 19;
constexpr std::size_t max_stages = 16;

// One call.
template <class T>
class JoinedStep {
 public:
  // For so many particles: all that the motion is of, unless they come and go.
  JoinedStep(const CompiledScene<T>& scene, const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace, std::size_t particles,
             const ParallelFor& parallel, ContactReport::Parts* report) noexcept
      : scene_(scene),
        m_(motion),
        joints_(motion.joints()),
        ws_(workspace),
        work_(workspace.work),
        particles_(particles),
        end_(comes_and_goes() ? filled(particles) : motion.joints().order.size),
        held_(std::span(workspace.held).first(joints_.fixed.size())),
        kernels_(scene.passes->template of<T>().network),
        air_kernels_(scene.passes->template of<T>().air),
        passes_(*scene.passes),
        exchange_(scene.options.elsewhere.exchange),
        stay_kernels_(stay_kernels<T>(scene.options.arithmetic)),
        parallel_(joints_.are_worth_threads(particles) ? parallel : ParallelFor{}),
        report_(report),
        logged_(scene.scene, joints_.order, particles, joints_.w_of, exchange_.is_own) {
    work_.w = joints_.w;
    if (joints_.constraints) {
      constraint_terms_ = ws_.with_columns(joints_.constraints->terms());
      constraints_.emplace(*joints_.constraints, scene.passes->template of<T>().constraint, constraint_terms_, parallel_);
    }
    if (const auto* strands = std::get_if<StrandsForm<T>>(&joints_.form)) sheets_.end = strands->sheets.size() - 1;
    if (joints_.balls) {
      balls_.emplace(
          BallsOfScene<T>{joints_.balls->lists(), ws_.balls, m_.skins(), ws_.skins, ws_.poses, m_.origin(), joints_.substep()},
          work_, scene.passes->template of<T>().ball, parallel_);
    }
    if (joints_.meet) {
      meet_.emplace(MeetingsOfScene<T>{*joints_.meet, joints_.order, m_.origin(), m_.slowest_bounce(), m_.parting()}, ws_.meet,
                    work_, particles, scene.options.elsewhere, scene.passes->template of<T>().meet, parallel_, report_);
    }
    if (m_.faces() != nullptr) {
      faces_.emplace(FacesOfScene{*m_.faces(), joints_.order.size, m_.origin(), m_.tracks(), ws_.motions}, ws_.faces, work_,
                     parallel_, report_);
    }
    for (std::size_t f = 0; f < m_.flows().size(); ++f) make_offsets(f, Clock{}, offsets_[f]);
  }
  JoinedStep(const JoinedStep&) = delete;
  JoinedStep& operator=(const JoinedStep&) = delete;

  template <class Kept>
  void fetch_all(const State<Kept>& state) noexcept {
    for_some_rows([&](const Rows& rows) {
      fetch(passes_, state.x, state.x_rest, rows, positions());
      fetch(passes_, state.v, state.v_rest, rows, work_.v);
      for (std::size_t axis = 0; axis < 3 && is_relative(); ++axis) clear(rows, work_.x[axis]);
    });
    if (comes_and_goes()) fill_up();
    for_each_listed_run([&](std::span<const std::uint32_t> particles, std::size_t first) {
      fetch(state.x, state.x_rest, particles, places(positions(), first));
      fetch(state.v, state.v_rest, particles, places(work_.v, first));
      for (std::size_t axis = 0; axis < 3 && is_relative(); ++axis) {
        std::fill_n(work_.x[axis] + first, particles.size(), T(0));
      }
    });
    for (std::size_t n = 0; n < joints_.fixed.size(); ++n) {
      Held<T>& held = held_[n];
      held.particle = joints_.fixed[n].particle;
      held.element = joints_.fixed[n].element;
      load(passes_, state.x, state.x_rest, {held.particle, 1}, places_of(held.x));
      load(passes_, state.v, state.v_rest, {held.particle, 1}, places_of(held.v));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (work_.a[axis] != nullptr) work_.a[axis][held.element] = T(0);  // it may have moved before it was fixed
      }
    }
    for (std::size_t k = 0; k < ws_.motions.size(); ++k) ws_.motions[k].arrive(m_.tracks()[k], state.clock);
    move_followers(state.clock);
    hold_fixed(0, size());
    if (constraints_) constraints_->prepare(work_.x);
    if (balls_) balls_->prepare(state.clock);
    if (faces_) faces_->prepare();
    if (meet_ && !ws_.remembers(state.x[0].base, state.clock)) ws_.meet.forget();
    if (work_.a[0] != nullptr) recall(state);
    if (keeps_still()) note_all_still();
  }

  // The next call may carry on what the springs do to this state.
  template <class Kept>
  void leave(const State<Kept>& state) noexcept {
    ws_.work = work_;
    if (work_.a[0] != nullptr || meet_) ws_.remember(state.x[0].base, state.clock);
  }

  // Fixed particles' columns are not written to.
  template <class Kept>
  void put_back_all(State<Kept>& state) noexcept {
    for_some_rows([&](const Rows& rows) {
      put_back(passes_, read_only(positions()), rows, state.x, state.x_rest);
      put_back(passes_, read_only(work_.v), rows, state.v, state.v_rest);
    });
    for_each_listed_run([&](std::span<const std::uint32_t> particles, std::size_t first) {
      put_back(read_only(places(positions(), first)), particles, state.x, state.x_rest);
      put_back(read_only(places(work_.v, first)), particles, state.v, state.v_rest);
    });
    for (const Held<T>& held : held_) put_back_held(held, state);
  }

  // For a call of no steps: puts what motions carry where it is at this time.
  template <class Kept>
  void put_followers_back(State<Kept>& state) noexcept {
    for (const Held<T>& held : held_) {
      if (is_kinematic(held)) put_back_held(held, state);
    }
  }

  // Leaves the clock where the last step ends.
  void run(Clock& clock, double step, std::size_t steps) noexcept {
    if (goes_by_sheets()) return run_by_sheets(clock, step, steps);
    const std::size_t stages = stages_at_once();
    for (std::size_t n = 0; n < steps; ++n) {
      if (stages < 2) {
        this->step(clock);
      } else {
        add_stages(clock, stages);
      }
      clock.advance(step, 1);
      ++number_;
      if (has_too_many_) return;
    }
    run_stages();
  }
  // More neighbours of a particle than there is room for: the step has not ended.
  [[nodiscard]] bool has_too_many() const noexcept { return has_too_many_; }

 private:
  // One sheet of a stack in the whole's working columns, on one thread.
  JoinedStep(const JoinedStep& whole, std::size_t sheet) noexcept
      : JoinedStep(whole.scene_, whole.m_, whole.ws_, whole.particles_, ParallelFor{}, whole.report_) {
    const std::size_t each = whole.end_ / whole.sheets_.end;
    first_ = sheet * each;
    end_ = first_ + each;
    sheets_ = {sheet, sheet + 1};
    is_start_ = whole.is_start_;
    number_ = whole.number_;
  }

  // Sheets that nothing but sweeps joins, each of which is in cache where all of them are not.
  [[nodiscard]] bool goes_by_sheets() const noexcept {
    return sheets_.end - sheets_.first > 1 && !m_.closes_substeps() && !joints_.air && m_.tracks().empty();
  }
  void run_by_sheets(Clock& clock, double step, std::size_t steps) noexcept {
    for_each_task(parallel_, sheets_.end, [&](std::size_t sheet) {
      JoinedStep part(*this, sheet);
      Clock of_part = clock;
      part.run(of_part, step, steps);
    });
    for (std::size_t n = 0; n < steps; ++n) clock.advance(step, 1);
  }

  void step(Clock clock) noexcept {
    clock_ = step_end_ = clock;
    step_end_.advance(joints_.step, 1);
    set_out();
    sweeps_.begin_step();
    begin_still();
    for (int substep = 0; substep < joints_.chosen.substeps; ++substep) {
      const Clock begun = clock_;
      if (meet_) meet_->set_out();
      air_substeps_ = joints_.air ? substeps_of_air(substep, joints_.chosen.substeps) : 0;
      const auto& before = substep == 0 ? m_.first() : m_.again();
      for (std::size_t k = 0; k < before.size(); ++k) {
        std::visit([&](const auto& form) { flow_and_pulse(form, before[k], k); }, joints_.form);
        note_pulse(k);
      }
      if (m_.closes_substeps()) close_substep(begun);
      if (has_too_many_) return;
      if (moves_alone()) flow(*m_.last(), After::nothing);
    }
    if (m_.last() && !m_.closes_substeps() && !moves_alone()) flow(*m_.last(), After::nothing);
    take_what_the_sweeps_left();
    if (m_.settling()) settle();
    if (is_relative()) count_from_here();
  }

  // Particles that springs or constraints have moved into a contact since the last flow are put back onto it. Their velocity is
  // left for the next flow: whether a particle that rests on a surface stands inside is a matter of rounding, and so would be
  // what it keeps.
  void settle() noexcept {
    clock_ = step_end_;
    const std::size_t f = *m_.settling();
    const FreeMotion<T>& motion = *m_.flows()[f];
    move_surfaces(motion, clock_, clock_);
    for_each_stepped([&](std::size_t from, std::size_t end) {
      BlockColumns still;
      const std::size_t each = std::min(motion.block, max_block);
      for (std::size_t first = from; first < end; first += each) {
        const std::size_t count = std::min(each, end - first);
        Block<T> block = block_of(first, count, nullptr);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          still.columns[axis].fill(T(0));
          block.v[axis] = still.columns[axis].data();
        }
        flow_block(motion, offsets_[f], block);
        hold_fixed(first, first + count);
      }
    });
    if (constraints_) constraints_->prepare(work_.x);  // as at the beginning of a call
    if (balls_) balls_->prepare(clock_);
  }

  // No pulse stands between a sub-step's flow and the next one's.
  [[nodiscard]] bool moves_alone() const noexcept { return m_.again().empty() && !m_.closes_substeps(); }

  enum class After { nothing, pairs, sweeps };  // what joins a flow in the same walk over the particles

  template <class Kept>
  void recall(const State<Kept>& state) noexcept {
    if (ws_.remembers(state.x[0].base, state.clock)) return;
    ws_.forget();
    for (T* const a : work_.a) std::fill_n(a, size(), T(0));
    is_start_ = true;
  }

  [[nodiscard]] std::size_t size() const noexcept { return joints_.order.size; }
  [[nodiscard]] bool is_relative() const noexcept { return ws_.origin[0] != nullptr; }
  Places<T> positions() noexcept { return is_relative() ? ws_.origin : work_.x; }

  template <class Kept>
  void put_back_held(const Held<T>& held, const State<Kept>& state) noexcept {
    store(passes_, places_of(held.x), {held.particle, 1}, state.x, state.x_rest);
    store(passes_, places_of(held.v), {held.particle, 1}, state.v, state.v_rest);
  }

  // All rows, a task's at once; none of an order that lists its particles. In an order that is no sheet's each span is a row.
  template <class Use>
  void for_some_rows(const Use& use) const noexcept {
    const ParticleOrder& order = joints_.order;
    if (comes_and_goes()) return for_each_run(use);
    if (order.is_listed()) return;
    const std::span<const ParticleSpan> spans = order.spans;
    const std::size_t rows = order.pitch != 0 ? order.size / (order.phases * order.pitch) : spans.size();
    if (rows == 0) return;
    const std::size_t each = spans.size() / rows;
    const std::size_t tasks = tasks_of_copies(rows);
    for_each_task(parallel_, tasks, [&](std::size_t task) {
      const std::size_t first = rows * task / tasks;
      use({spans.subspan(first * each, (rows * (task + 1) / tasks - first) * each), each});
    });
  }

  // Whether particles come and go; then they stand as they are numbered.
  [[nodiscard]] bool comes_and_goes() const noexcept { return scene_.particles == Particles::come_and_meet; }
  template <class Use>
  void for_each_run(const Use& use) const noexcept {
    const std::span<const ParticleSpan> spans = joints_.order.spans;
    for_each_task(parallel_, tasks_of(particles_, spans[0].count), [&](std::size_t task) {
      ParticleSpan run = spans[task];
      run.count = std::min(run.count, particles_ - run.element);
      use({std::span(&run, 1), 1});
    });
  }
  // Flows take whole registers: to the last particle's end there are more of it.
  void fill_up() noexcept {
    for (auto* const columns : {&work_.x, &work_.v}) {
      for (T* const column : *columns) {
        std::fill(column + particles_, column + end_, particles_ != 0 ? column[particles_ - 1] : T(0));
      }
    }
  }

  // The elements that are stepped, a task's at once.
  template <class Use>
  void for_each_stepped(const Use& use) const noexcept {
    for_each_task(parallel_, tasks_of(end_ - first_, particles_per_task), [&](std::size_t task) {
      const std::size_t from = first_ + task * particles_per_task;
      use(from, std::min(end_, from + particles_per_task));
    });
  }

  // Where particles stand in an order that is not the caller's: those of each span, and its first element.
  template <class Use>
  void for_each_listed_run(const Use& use) const noexcept {
    const ParticleOrder& order = joints_.order;
    if (!order.is_listed()) return;
    const std::size_t runs = order.spans.size();
    const std::size_t tasks = tasks_of_copies(runs);
    for_each_task(parallel_, tasks, [&](std::size_t task) {
      for (std::size_t n = runs * task / tasks; n < runs * (task + 1) / tasks; ++n) {
        use(order.listed(order.spans[n]), order.spans[n].element);
      }
    });
  }

  [[nodiscard]] std::size_t tasks_of_copies(std::size_t pieces) const noexcept {
    return parallel_.run != nullptr ? std::min<std::size_t>(pieces, 64) : 1;
  }

  [[nodiscard]] bool is_kinematic(const Held<T>& held) const noexcept {
    return joints_.fixed[static_cast<std::size_t>(&held - held_.data())].motion.has_value();
  }
  // A fixed one may be anywhere, at infinity too.
  [[nodiscard]] T way_in_step(const Held<T>& held, std::size_t axis) const noexcept {
    return is_kinematic(held) ? held.x[axis] - ws_.origin[axis][held.element] : T(0);
  }

  void hold_fixed(std::size_t from, std::size_t to) noexcept {
    auto held = std::lower_bound(held_.begin(), held_.end(), from,
                                 [](const Held<T>& h, std::size_t element) { return h.element < element; });
    for (; held != held_.end() && held->element < to; ++held) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work_.x[axis][held->element] = is_relative() ? way_in_step(*held, axis) : held->x[axis];
        work_.v[axis][held->element] = is_kinematic(*held) ? held->v[axis] : T(0);
      }
    }
  }

  // ---- what follows a motion ----------------------------------------------------------------------------------------------

  // The step's last flow ends where the clock will stand, to the last bit: a call of many steps must go on as many calls do.
  [[nodiscard]] Clock end_of_flow() const noexcept {
    const double apart = (clock_.seconds - step_end_.seconds) + (clock_.carry - step_end_.carry);
    return std::abs(apart) < 1e-6 * std::abs(joints_.substep()) ? step_end_ : clock_;
  }

  // Starts the driven motions, groups and skins on this step's path.
  void set_out() noexcept {
    for (std::size_t k = 0; k < ws_.motions.size(); ++k) ws_.motions[k].begin(m_.tracks()[k], clock_, joints_.step);
    for (const FixedParticle& of : joints_.fixed) {
      if (!of.motion || !ws_.groups[of.group].has_way()) continue;
      ws_.groups[of.group].begin(of.index, ws_.poses[*of.motion].place(of.place), joints_.step);
    }
    for (DrivenPlaces& group : ws_.groups) {
      if (group.has_way()) group.begin(clock_, joints_.step);
    }
    if (balls_) balls_->set_out(clock_, joints_.step);
    if (faces_) faces_->set_out(clock_);
  }

  // Kinematic particles go to where their motions have them at this time.
  void move_followers(const Clock& at) noexcept {
    if (m_.tracks().empty()) return;
    for (std::size_t k = 0; k < m_.tracks().size(); ++k) ws_.poses[k] = ws_.motions[k].at(m_.tracks()[k], at);
    const Vec3& origin = m_.origin();
    for (std::size_t n = 0; n < joints_.fixed.size(); ++n) {
      const FixedParticle& of = joints_.fixed[n];
      if (!of.motion) continue;
      Held<T>& held = held_[n];
      const MovedPose& pose = ws_.poses[*of.motion];
      const DrivenPlaces& driven = ws_.groups[of.group];
      const Vec3 x = driven.is_driven() ? driven.place(of.index, at) : pose.place(of.place);
      const Vec3 u = driven.is_driven() ? driven.velocity(of.index) : pose.velocity_of(of.place);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        held.x[axis] = static_cast<T>(x[axis] - origin[axis]);
        held.v[axis] = static_cast<T>(u[axis]);
      }
    }
  }

  // Constraints, balls and faces close each sub-step, which therefore ends with a flow of its own.
  void close_substep(const Clock& begun) noexcept {
    if (m_.last()) flow(*m_.last(), After::nothing);
    take_what_the_sweeps_left();
    if (meet_ && !keep_apart()) return;
    if (constraints_) constraints_->solve(work_.x, work_.v);
    if (balls_) balls_->keep(end_of_flow());
    if (!faces_ || !faces_->meet(begun, end_of_flow(), joints_.substep())) return;
    if (constraints_) constraints_->prepare(work_.x);
    if (balls_) balls_->prepare(end_of_flow());
  }

  // Particles that meet: false where there is too little room for them.
  [[nodiscard]] bool keep_apart() noexcept {
    if (joints_.substep() == 0) return true;
    const Terms<T>& terms = !ws_.surfaces.empty() ? moved_terms_ : m_.flows()[0]->terms;
    has_too_many_ =
        meet_->meet(terms.surfaces, terms.surface_count, static_cast<T>(joints_.substep())) == MeetStep<T>::Found::too_many;
    return !has_too_many_;
  }

  // Those of the flow from `start` to `end`.
  void move_surfaces(const FreeMotion<T>& motion, const Clock& start, const Clock& end) noexcept {
    if (ws_.surfaces.empty()) return;
    moved_terms_ = motion.terms;
    if (motion.terms.surface_count == 0) return;
    moved_terms_.surfaces = ws_.surfaces.data();
    std::fill(ws_.movers.begin(), ws_.movers.end(), no_surface);
    for (std::size_t j = 0; j < ws_.surfaces.size(); ++j) {
      Surface<T>& surface = ws_.surfaces[j];
      surface = motion.terms.surfaces[j];
      const Contact& contact = m_.contacts()[surface.contact];
      const auto& of = motion_of(contact);
      if (!of) continue;
      const MovedPose pose = ws_.motions[*of].at_end_of(m_.tracks()[*of], start, end);
      move_surface(surface, contact, pose, m_.origin());
      if (report_ != nullptr) report_->centers[surface.contact] = {pose.place(pose.center), pose.velocity};
      if (surface.movement == Movement::rest) continue;
      moved_terms_.moves = true;
      ws_.movers[*of] = static_cast<std::uint32_t>(j);
    }
  }

  // ---- flows --------------------------------------------------------------------------------------------------------------

  using FlowOffsets = std::array<Offsets<T>, 2>;

  void make_offsets(std::size_t f, Clock clock, FlowOffsets& offsets) noexcept {
    const FreeMotion<T>& flow = *m_.flows()[f];
    const std::size_t parts = flow.offsets_per_step();
    for (std::size_t part = 0; part < parts; ++part) {
      flow.offsets_at(clock, offsets[part]);
      clock.advance(flow.step() / static_cast<double>(parts), 1);
    }
  }

  void flow(std::size_t f, After after) noexcept {
    const FreeMotion<T>& motion = *m_.flows()[f];
    if (motion.system.depends_on_time()) make_offsets(f, clock_, offsets_[f]);
    const Clock start = clock_;
    clock_.advance(motion.step(), 1);
    move_followers(end_of_flow());
    move_surfaces(motion, start, end_of_flow());
    if (keeps_still() && motion.terms.surface_count == 0 && !ws_.surfaces.empty()) {
      move_surfaces(*m_.flows()[m_.first()[0]], start, end_of_flow());
    }
    const Left left = std::exchange(left_, Left{});
    const AlphaTerms<T>* const begin = after == After::sweeps ? alpha_ : nullptr;
    const bool keeps_starts = motion.terms.surface_count != 0 && left.alpha != nullptr;
    const SubstepImpulse<T> impulse = impulse_in(motion);
    const bool has_columns = keeps_starts || keeps_still() || (after == After::pairs && motion.terms.surface_count != 0);
    const std::size_t each = has_columns ? std::min(motion.block, max_block) : motion.block;
    for_each_stepped([&](std::size_t from, std::size_t end) {
      with_log(motion, start, number_, [&](ContactLog<T>* log) {
        BlockColumns starts;
        for (std::size_t first = from; first < end; first += each) {
          const std::size_t count = std::min(each, end - first);
          Block<T> block = block_of(first, count, log);
          if (keeps_starts) keep_starts(block, starts);
          flow_block(motion, offsets_[f], impulse, block, [&] {
            if (left.shift != nullptr && motion.extra == Extras::none) {
              take_in_flow(*left.shift, block);
            } else {
              take(left, first, first + count);
            }
          });
          if (after == After::pairs) add_pairs(motion, offsets_[f], block);
          hold_fixed(first, first + count);
          if (begin != nullptr) kernels_.begin_sweeps(*begin, work_, first, first + count);
        }
      });
    });
  }

  // Calls use(log), null where nobody asks: a recorder is 26 KB, which even an empty std::optional of one clears.
  template <class Use>
  void with_log(const FreeMotion<T>& motion, const Clock& start, std::uint64_t number, const Use& use) noexcept {
    if (report_ == nullptr || (motion.terms.surface_count == 0 && !keeps_still())) return use(nullptr);
    ContactRecorder<T> recorder(*report_, logged_, scene_.options.arithmetic);
    recorder.begin(report_->steps + number, start, motion.step());
    use(&recorder);
  }

  struct alignas(64) BlockColumns {
    using Column = std::array<T, column_pitch<T>(max_block)>;
    std::array<Column, 3> columns;  // left as they are
  };

  Block<T> block_of(std::size_t first, std::size_t count, ContactLog<T>* log) noexcept {
    Block<T> block{.first = first, .count = count, .log = log};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = work_.x[axis] + first;
      block.v[axis] = work_.v[axis] + first;
    }
    return block;
  }
  void keep_starts(Block<T>& block, BlockColumns& starts) const noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T* const kept = starts.columns[axis].data();
      std::copy_n(block.x[axis], block.count, kept);
      block.from[axis] = kept;
    }
  }

  void flow_block(const FreeMotion<T>& motion, const FlowOffsets& offsets, const Block<T>& block) noexcept {
    const Steps<T> once{.offsets = offsets.data(), .offsets_per_step = 0, .count = 1};
    const bool moves = !ws_.surfaces.empty() && motion.terms.surface_count != 0;
    motion.kernels->at(motion.flow, motion.extra)(block, moves ? moved_terms_ : motion.terms, once);
  }

  // ---- what stands still on a contact and stays: contact/pass/stay.hpp --------------------------------------------------

  [[nodiscard]] bool keeps_still() const noexcept { return !ws_.still.empty(); }

  void note_all_still() noexcept {
    for_each_stepped([&](std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) {
        const bool stands = work_.w[i] > 0 && work_.v[0][i] == 0 && work_.v[1][i] == 0 && work_.v[2][i] == 0;
        ws_.still[i] = stands ? StandsHow::stands : StandsHow::moves;
      }
    });
  }
  void note_pulse(std::size_t k) noexcept {
    if (keeps_still()) pulse_part_ = joints_.splitting.b[k];
  }
  // No pulse yet.
  void begin_still() noexcept {
    pulse_part_ = 0;
    waited_ = 0;
  }
  // The impulse in the next flow: particles that stand still wait for the first pulse.
  [[nodiscard]] SubstepImpulse<T> impulse_in(const FreeMotion<T>& motion) noexcept {
    if (!keeps_still() || motion.step() == 0) return {};
    const double waited = std::exchange(waited_, pulse_part_ == 0 ? motion.step() : 0);
    return {.t = static_cast<T>(motion.step()),
            .pulses = pulse_part_ == 0 ? T(0) : static_cast<T>(1 / pulse_part_),
            .flows = static_cast<T>(joints_.substep() / motion.step()),
            .owed = static_cast<T>(waited / motion.step())};
  }
  [[nodiscard]] StillColumns<T> particles_at_rest() const noexcept {
    return {.how = ws_.still, .on = ws_.still_on, .movers = ws_.movers, .w = work_.w, .kernels = &stay_kernels_};
  }
  // Flows that go back have no contacts of their own.
  [[nodiscard]] const Terms<T>& terms_of_contacts(const FreeMotion<T>& motion) const noexcept {
    if (!ws_.surfaces.empty()) return moved_terms_;
    return motion.terms.surface_count != 0 ? motion.terms : m_.flows()[m_.first()[0]]->terms;
  }

  template <class Take>
  void flow_block(const FreeMotion<T>& motion, const FlowOffsets& offsets, const SubstepImpulse<T>& impulse, Block<T>& block,
                  const Take& take) noexcept {
    if (!keeps_still()) {
      take();
      return flow_block(motion, offsets, block);
    }
    const Terms<T>& terms = terms_of_contacts(motion);
    StillBlock<T> still(particles_at_rest(), terms, block);
    if (impulse.pulses == 0) still.find_carried(impulse.t);
    still.keep();
    take();
    still.judge(motion, offsets.data(), impulse);
    flow_block(motion, offsets, block);
    still.end();
  }

  void add_pairs(const FreeMotion<T>& motion, const FlowOffsets& offsets, const Block<T>& block) noexcept {
    if (motion.terms.surface_count != 0) {
      const std::array<T*, 3> dx{work_.dx[0] + block.first, work_.dx[1] + block.first, work_.dx[2] + block.first};
      const std::array<T*, 3> dv{work_.dv[0] + block.first, work_.dv[1] + block.first, work_.dv[2] + block.first};
      StillBlock<T>(particles_at_rest(), terms_of_contacts(motion), block).leave_out(dx, dv, motion, offsets.data());
    }
    kernels_.add_pairs(work_, block.first, block.first + block.count);
  }

  // Shifts that the sweeps made, applied in the next flow's walk over the particles.
  struct Left {
    const ShiftTerms<T>* shift = nullptr;
    const AlphaTerms<T>* alpha = nullptr;  // or by generalized alpha
  };

  void take_in_flow(const ShiftTerms<T>& shift, Block<T>& block) const noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) block.shift[axis] = work_.shift[axis] + block.first;
    block.to_x = shift.to_x;
    block.to_v = shift.to_v;
  }
  void take(const Left& left, std::size_t from, std::size_t to) noexcept {
    if (left.shift != nullptr) kernels_.take_shift(work_, left.shift->to_x, left.shift->to_v, from, to);
    if (left.alpha != nullptr) kernels_.end_sweeps(*left.alpha, work_, from, to);
  }

  // Theta 1 ends a step with the springs, not with a flow.
  void take_what_the_sweeps_left() noexcept {
    const Left left = std::exchange(left_, Left{});
    if (left.shift == nullptr && left.alpha == nullptr) return;
    for_each_stepped([&](std::size_t from, std::size_t end) { take(left, from, end); });
  }

  void count_from_here() noexcept {
    for_each_stepped([&](std::size_t from, std::size_t end) { kernels_.move_origin(ws_.origin, work_.x, from, end); });
    for (const Held<T>& held : held_) {
      for (std::size_t axis = 0; axis < 3 && is_kinematic(held); ++axis) ws_.origin[axis][held.element] = held.x[axis];
    }
  }

  // ---- a large grid: several flows and pulses while its rows are in cache -------------------------------------------------

  enum class Kind { flow, pulse };
  struct Stage {
    Kind kind = Kind::flow;
    const FreeMotion<T>* motion = nullptr;
    FlowOffsets offsets;
    Clock start{};
    std::uint64_t number = 0;  // of the step
    T pulse{};
    SubstepImpulse<T> impulse{};
  };

  // A pulse reads the rows up to so far away.
  [[nodiscard]] static std::size_t reach(const GridTerms<T>& grid) noexcept { return grid.along.right2.is_there() ? 2 : 1; }
  [[nodiscard]] static std::size_t rows_in_cache(const GridTerms<T>& grid) noexcept {
    constexpr std::size_t columns = 7;  // x, v and w
    return bytes_in_cache / (columns * sizeof(T) * grid.pitch);
  }

  // 0 where the sheet is in cache anyway, where a pulse reads the neighbours' velocities, which the stage before has changed
  // (damping, air), where constraints stand between the pulses, and where each stage has its own poses of motions.
  [[nodiscard]] std::size_t stages_at_once() const noexcept {
    const auto* form = std::get_if<GridForm<T>>(&joints_.form);
    if (form == nullptr || joints_.damping_passes() != 0 || joints_.air || m_.closes_substeps() || !m_.tracks().empty())
      return 0;
    if (exchange_.start != nullptr && exchange_.pulses_per_telling == 1) return 0;
    const std::size_t rows = rows_in_cache(form->terms);
    const std::size_t most = std::min(max_stages, rows / reach(form->terms) / 2);
    if (exchange_.start != nullptr) return std::max<std::size_t>(2, most);
    return form->terms.rows <= 2 * rows ? 0 : most;
  }

  // The stages of one step, run whenever so many have come together.
  void add_stages(Clock clock, std::size_t at_once) noexcept {
    clock_ = clock;
    begin_still();
    const auto add = [&](const auto& fill) {
      fill(stages_[stage_count_++]);
      if (stage_count_ == at_once) run_stages();
    };
    const auto add_flow = [&](std::size_t f) {
      add([&](Stage& stage) {
        stage.kind = Kind::flow;
        stage.motion = m_.flows()[f].get();
        make_offsets(f, clock_, stage.offsets);
        stage.start = clock_;
        stage.number = number_;
        stage.impulse = impulse_in(*stage.motion);
        clock_.advance(stage.motion->step(), 1);
      });
    };
    for (int substep = 0; substep < joints_.chosen.substeps; ++substep) {
      const auto& before = substep == 0 ? m_.first() : m_.again();
      for (std::size_t k = 0; k < before.size(); ++k) {
        add_flow(before[k]);
        add([&](Stage& stage) {
          stage.kind = Kind::pulse;
          stage.pulse = pulse_length(k);
        });
        note_pulse(k);
        if (exchange_.start != nullptr) tell_in_turn();
      }
    }
    if (m_.last()) add_flow(*m_.last());
  }

  // Each pulse invalidates as many outer halo rows as it reaches.
  void tell_in_turn() noexcept {
    if (++ws_.pulses_since_telling < exchange_.pulses_per_telling) return;
    ws_.pulses_since_telling = 0;
    run_stages();
    exchange(work_.x);
    exchange(work_.v);
  }

  void run_stages() noexcept {
    const std::size_t stages = std::exchange(stage_count_, 0);
    if (stages == 0) return;
    const GridTerms<T>& grid = std::get<GridForm<T>>(joints_.form).terms;
    const std::size_t chunk = reach(grid);  // rows
    const std::size_t chunks = grid.rows / chunk;
    const std::size_t per_block = std::max(rows_in_cache(grid) / chunk, 2 * stages);
    for_each_tile(parallel_, chunks, per_block, stages, [&](std::size_t j, std::size_t from, std::size_t to) {
      run_stage(stages_[j], grid, from * chunk, to == chunks ? grid.rows : to * chunk);
    });
  }

  void run_stage(const Stage& stage, const GridTerms<T>& grid, std::size_t from, std::size_t to) noexcept {
    if (stage.kind == Kind::pulse) return kernels_.grid(grid, work_, stage.pulse, from, to);
    with_log(*stage.motion, stage.start, stage.number, [&](ContactLog<T>* log) {
      const std::size_t end = to * grid.pitch;
      const std::size_t each = keeps_still() ? std::min(stage.motion->block, max_block) : stage.motion->block;
      for (std::size_t first = from * grid.pitch; first < end; first += each) {
        const std::size_t count = std::min(each, end - first);
        Block<T> block = block_of(first, count, log);
        flow_block(*stage.motion, stage.offsets, stage.impulse, block, [] {});
        hold_fixed(first, first + count);
      }
    });
  }

  // ---- pulses, one for each form ------------------------------------------------------------------------------------------

  struct Units {  // rows, slices, or particles and triangles by slices
    std::size_t count, per_task, size = 1;
  };

  template <class Form>
  void flow_and_pulse(const Form& form, std::size_t f, std::size_t k) noexcept {
    flow(f, After::nothing);
    const double air = part_of_air(k);
    if (air != 0) keep_velocity();
    pulse(form, k);
    if (air != 0) blow_in_the_middle(air);
  }
  // Brown's contributions are of the whole sub-step, from where it starts.
  void flow_and_pulse(const PairsForm<T>& form, std::size_t f, std::size_t /*k*/) noexcept {
    constexpr std::size_t per_task = particles_per_task / slice;
    const std::size_t slices = size() / slice;
    if (air_substeps_ != 0) blow_on_velocity(0.5);
    for_each_task(parallel_, tasks_of(slices, per_task), [&](std::size_t task) {
      kernels_.pairs(form.terms, work_, task * per_task, std::min(slices, (task + 1) * per_task));
    });
    exchange(work_.dx);
    exchange(work_.dv);
    flow(f, After::pairs);
    if (air_substeps_ != 0) blow_on_velocity(0.5);
  }

  void flow_and_pulse(const StrandsForm<T>& form, std::size_t f, std::size_t /*k*/) noexcept { flow_and_sweep(form, f); }
  void flow_and_pulse(const ColoursForm<T>& form, std::size_t f, std::size_t /*k*/) noexcept { flow_and_sweep(form, f); }

  template <class Form>
  void flow_and_sweep(const Form& form, std::size_t f) noexcept {
    if (form.alpha) return flow_and_sweep(form, *form.alpha, f);
    flow(f, After::nothing);
    if (air_substeps_ != 0) keep_velocity();
    sweeps_.sweep(form, ws_.with_columns(form.terms), sheets_);
    left_ = {.shift = &form.shift};
    if (air_substeps_ != 0) blow_after_sweeps();
  }
  template <class Form>
  void flow_and_sweep(const Form& form, const Alpha<T>& alpha, std::size_t f) noexcept {
    const bool is_start = std::exchange(is_start_, false);
    alpha_ = is_start ? &alpha.start : &alpha.on;
    flow(f, After::sweeps);
    if (air_substeps_ != 0) keep_velocity();
    std::swap(work_.v, work_.v_next);  // the same where nothing damps
    sweeps_.sweep(form, ws_.with_columns(is_start ? alpha.sweeps_of_start : form.terms), sheets_);
    std::swap(work_.v, work_.v_next);
    left_ = {.alpha = alpha_};
    if (air_substeps_ != 0) blow_after_sweeps();
  }

  void pulse(const GridForm<T>& form, std::size_t k) noexcept {
    const Units rows{form.terms.rows, particles_per_task / form.terms.pitch};
    if (joints_.damping_passes() == 0) return kick(kernels_.grid, form.terms, k, rows);
    tell(rows, work_.a0, [&](std::size_t from, std::size_t to) { kernels_.grid_acceleration(form.terms, work_, from, to); });
    take_acceleration(kernels_.damp_grid, form.terms, k, rows);
  }
  void pulse(const GraphForm<T>& form, std::size_t k) noexcept {
    const Units slices{size() / slice, particles_per_task / slice};
    if (joints_.damping_passes() == 0) return kick(kernels_.graph, form.terms, k, slices);
    tell(slices, work_.a0, [&](std::size_t from, std::size_t to) { kernels_.graph_acceleration(form.terms, work_, from, to); });
    take_acceleration(kernels_.damp_graph, form.damped, k, slices);
  }

  // ---- air, in the middle of a pulse or in halves at both ends of a sub-step: air/air.hpp ----------------------

  // Air is far slower than the springs that ask for sub-steps. Up to five of these have one pulse of it together, in the middle
  // one: 5, 5, ..., and of what is left 3 and 1. 0: none in this one.
  [[nodiscard]] static int substeps_of_air(int substep, int substeps) noexcept {
    for (const int together : {5, 3, 1}) {
      const int groups = substeps / together;
      if (substep < groups * together) return substep % together == together / 2 ? together : 0;
      substep -= groups * together;
      substeps -= groups * together;
    }
    return 0;
  }

  // The part of that air that goes with the pulse k: all, or of six pulses the third and the fourth have half of it each.
  [[nodiscard]] double part_of_air(std::size_t k) const noexcept {
    if (air_substeps_ == 0) return 0;
    const std::size_t pulses = joints_.splitting.b.size();
    if (pulses == 1) return 1;
    return k + 1 == pulses / 2 || k == pulses / 2 ? 0.5 : 0;
  }

  [[nodiscard]] Units elements() const noexcept { return {size() / slice, particles_per_task / slice, slice}; }

  void keep_velocity() noexcept {
    over(elements(), [&](std::size_t from, std::size_t to) {
      for (std::size_t axis = 0; axis < 3; ++axis) std::copy_n(work_.v[axis] + from, to - from, ws_.air_v[axis] + from);
    });
  }
  void blow_on_velocity(double part) noexcept {
    keep_velocity();
    blow(part);
  }
  // Since the velocity was kept the pulse has changed it.
  void blow_in_the_middle(double part) noexcept {
    const WorkColumns<T> work = columns_in_air();
    over(elements(), [&](std::size_t from, std::size_t to) { air_kernels_.middle(work, from, to); });
    blow(part);
  }
  void blow_after_sweeps() noexcept {
    take_what_the_sweeps_left();
    blow_in_the_middle(1);
  }
  [[nodiscard]] WorkColumns<T> columns_in_air() const noexcept {
    WorkColumns<T> work = work_;
    work.v_next = ws_.air_v;
    return work;
  }

  // Applies that part of the air's pulse, evaluated at the velocities air_v.
  void blow(double part) noexcept {
    const Vec3 wind = m_.wind_at(end_of_flow());
    const double t = part * air_substeps_ * joints_.substep();
    const std::array<T*, 3> g = blow(AirStage::first, wind, t);
    exchange(g);
    blow(AirStage::second, wind, t);
    exchange(work_.v);
  }
  // The columns that the first stage leaves to the second.
  std::array<T*, 3> blow(AirStage stage, const Vec3& wind, double t) noexcept {
    return joints_.air->is_grid() ? blow_rows(stage, wind, t) : blow_list(stage, wind, t);
  }
  std::array<T*, 3> blow_rows(AirStage stage, const Vec3& wind, double t) noexcept {
    const GridAirTerms<T> grid = ws_.with_columns(joints_.air->grid());
    const AirPulse<T> pulse = air_pulse<T>(joints_.air->networks()[0].aerodynamics, wind, t);
    const WorkColumns<T> work = columns_in_air();
    over({grid.rows, particles_per_task / grid.pitch},
         [&](std::size_t from, std::size_t to) { air_kernels_.grid(grid, pulse, work, stage, from, to); });
    return grid.g;
  }
  std::array<T*, 3> blow_list(AirStage stage, const Vec3& wind, double t) noexcept {
    const TriangleTerms<T> list = ws_.with_columns(joints_.air->triangles());
    const WorkColumns<T> work = columns_in_air();
    for (const AirNetwork& of : joints_.air->networks()) {
      const AirPulse<T> pulse = air_pulse<T>(of.aerodynamics, wind, t);
      over({(of.end - of.first) / slice, particles_per_task / slice, slice}, [&](std::size_t from, std::size_t to) {
        air_kernels_.triangles(list, pulse, work, stage, of.first + from, of.first + to);
      });
    }
    over({size() / slice, particles_per_task / slice},
         [&](std::size_t from, std::size_t to) { air_kernels_.gather(list, work, stage, from, to); });
    return list.g;
  }

  [[nodiscard]] T pulse_length(std::size_t k) const noexcept {
    return static_cast<T>(joints_.splitting.b[k] * joints_.substep());
  }

  template <class Pass>
  void over(const Units& units, const Pass& pass) noexcept {
    const std::size_t per_task = std::max<std::size_t>(1, units.per_task);
    for_each_task(parallel_, tasks_of(units.count, per_task), [&](std::size_t task) {
      const std::size_t from = task * per_task;
      pass(from * units.size, std::min(units.count, from + per_task) * units.size);
    });
  }

  template <class Kick, class Terms>
  void kick(const Kick& kick, const Terms& terms, std::size_t k, const Units& units) noexcept {
    const T pulse = pulse_length(k);
    tell(units, work_.v_next, [&](std::size_t from, std::size_t to) { kick(terms, work_, pulse, from, to); });
    std::swap(work_.v, work_.v_next);
  }

  // ---- a part of a larger scene: a halo's particles lack the springs that lead elsewhere ------------------------------

  [[nodiscard]] HaloColumns halo(const std::array<T*, 3>& columns) const noexcept {
    return halo_of(columns, joints_.order.of.data());
  }
  void exchange(const std::array<T*, 3>& columns) noexcept { dvdx::tell(exchange_, halo(columns)); }
  // A pass that fills these columns. Units that other parts hold come first: they are sent while the rest is computed.
  template <class Pass>
  void tell(const Units& units, const std::array<T*, 3>& columns, const Pass& pass) noexcept {
    if (exchange_.start == nullptr) return over(units, pass);
    over(joints_.telling.told, pass);
    exchange_.start(exchange_.context, halo(columns));
    over(joints_.telling.inside, pass);
    exchange_.finish(exchange_.context, halo(columns));
  }
  template <class Pass>
  void over(const std::vector<UnitRange>& ranges, const Pass& pass) noexcept {
    const std::size_t tasks = std::min<std::size_t>(ranges.size(), 64);
    for_each_task(parallel_, tasks, [&](std::size_t task) {
      for (std::size_t n = ranges.size() * task / tasks; n < ranges.size() * (task + 1) / tasks; ++n) {
        pass(ranges[n].from, ranges[n].to);
      }
    });
  }

  // v += b h a + (b h)^2/2 a1 + beta h^3 a2, the last of them where the scheme has it.
  template <class Damp, class Terms>
  void take_acceleration(const Damp& damp, const Terms& terms, std::size_t k, const Units& units) noexcept {
    const double h = joints_.substep();
    const double t = joints_.splitting.b[k] * h;
    DampingPass<T> pass{.of = work_.a0, .y = work_.a1, .s = static_cast<T>(t), .t = static_cast<T>(t * t / 2)};
    const auto run = [&](const std::array<T*, 3>& told) {
      tell(units, told, [&](std::size_t from, std::size_t to) { damp(terms, work_, pass, from, to); });
    };
    if (joints_.damping_passes() == 1) return run(work_.v);
    run(work_.a1);
    const double beta = joints_.splitting.beta[k];
    pass = {.of = work_.a1, .y = {}, .s = static_cast<T>(t * t / 2), .t = static_cast<T>(beta * h * h * h)};
    run(work_.v);
  }

  const CompiledScene<T>& scene_;
  const JoinedMotion<T>& m_;
  const Joints<T>& joints_;
  JoinedWorkspace<T>& ws_;
  WorkColumns<T> work_;
  std::size_t particles_;
  std::size_t first_ = 0, end_;  // the elements that are stepped
  typename SweepStep<T>::Sheets sheets_{};
  std::span<Held<T>> held_;
  const NetworkKernels<T>& kernels_;
  const AirKernels<T>& air_kernels_;
  const Passes& passes_;
  Exchange exchange_;
  const StayKernels<T> stay_kernels_;
  ParallelFor parallel_;
  SweepStep<T> sweeps_{
      {joints_.coupling.sweeps, joints_.order, joints_.telling.records}, kernels_, work_, ws_.line_rooms, exchange_, parallel_};
  ConstraintTerms<T> constraint_terms_{};
  std::optional<ConstraintStep<T>> constraints_;
  std::optional<BallStep<T>> balls_;
  std::optional<MeetStep<T>> meet_;
  bool has_too_many_ = false;
  std::optional<FaceStep<T>> faces_;
  Clock clock_, step_end_;
  Terms<T> moved_terms_;  // of the flow, where surfaces move
  Left left_{};
  const AlphaTerms<T>* alpha_ = nullptr;  // of this sub-step
  double pulse_part_ = 0;                 // of a sub-step that the last pulse was of; 0: none yet in this step
  double waited_ = 0;                     // s: that what stands still has waited for it
  bool is_start_ = false;                 // the next sub-step has no acceleration to start from
  int air_substeps_ = 0;                  // that this sub-step's air is of
  std::array<FlowOffsets, max_flows> offsets_;
  std::array<Stage, max_stages> stages_;
  std::size_t stage_count_ = 0;
  ContactReport::Parts* report_;  // null: nobody asks
  LoggedParticles logged_;
  std::uint64_t number_ = 1;  // of the step within the call
};

}  // namespace

template <class T, class Kept>
StepResult step_joined(const CompiledScene<T>& scene, const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace,
                       State<Kept>& state, std::size_t steps, const ParallelFor& parallel,
                       ContactReport::Parts* report) noexcept {
  const Stepping stepping(workspace.is_stepping);
  if (!stepping) return StepResult::in_use;
  if (steps == 0 && motion.joints().fixed.empty()) return StepResult::done;
  JoinedStep<T> call(scene, motion, workspace, state.count, parallel, report);
  call.fetch_all(state);
  if (steps == 0) {
    call.put_followers_back(state);
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
