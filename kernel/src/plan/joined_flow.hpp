// The flows of a call of joined particles: each particle moves by itself between the pulses of what joins them. The same walk
// over the particles applies what the pulses have left.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "plan/joined_call.hpp"
#include "plan/joined_followers.hpp"
#include "plan/joined_resting.hpp"

namespace dvdx {

template <class T>
class JoinedFlow {
 public:
  static constexpr std::size_t max_flows = 8;
  using FlowOffsets = std::array<Offsets<T>, 2>;
  // The work that joins a flow in the same walk over the particles.
  enum class After { nothing, pairs };
  // Shifts that the sweeps made, applied in the next flow's walk over the particles.
  struct PendingShift {
    const ShiftTerms<T>* shift = nullptr;
    const AlphaTerms<T>* alpha = nullptr;  // or by generalized alpha
  };

  JoinedFlow(JoinedCall<T>& call, JoinedFollowers<T>& followers) noexcept
      : call_(call),
        m_(call.motion),
        ws_(call.ws),
        work_(call.work),
        kernels_(call.kernels),
        followers_(followers),
        still_(call),
        logged_(call.scene.scene, call.network.order, call.particles, call.network.w_of, call.exchange.is_own) {
    for (std::size_t f = 0; f < m_.flows().size(); ++f) make_offsets(f, Clock{}, offsets_[f]);
  }

  [[nodiscard]] JoinedResting<T>& still() noexcept { return still_; }

  void make_offsets(std::size_t f, Clock clock, FlowOffsets& offsets) noexcept {
    const FreeMotion<T>& flow = *m_.flows()[f];
    const std::size_t parts = flow.offsets_per_step();
    for (std::size_t part = 0; part < parts; ++part) {
      flow.offsets_at(clock, offsets[part]);
      clock.advance(flow.step() / static_cast<double>(parts), 1);
    }
  }

  // begin: the terms by which sweeps by generalized alpha begin after the flow, or null.
  void run(std::size_t f, After after = After::nothing, const AlphaTerms<T>* begin = nullptr) noexcept {
    const FreeMotion<T>& motion = *m_.flows()[f];
    const Clock start = go_on(f);
    const PendingShift pending = std::exchange(pending_, PendingShift{});
    const bool keeps_starts = motion.terms.surface_count != 0 && pending.alpha != nullptr;
    const SubstepImpulse<T> impulse = still_.impulse_in(motion);
    const bool has_columns = keeps_starts || still_.is_kept();
    const std::size_t each = has_columns ? std::min(motion.block, max_block) : motion.block;
    call_.for_each_stepped([&](std::size_t from, std::size_t end) {
      with_log(motion, start, call_.number, [&](ContactLog<T>* log) {
        BlockColumns starts;
        for (std::size_t first = from; first < end; first += each) {
          const std::size_t count = std::min(each, end - first);
          Block<T> block = block_of(first, count, log);
          if (keeps_starts) keep_starts(block, starts);
          flow_block(motion, offsets_[f], impulse, block, [&] {
            if (pending.shift != nullptr && motion.features == StepFeatures::none) {
              take_in_flow(*pending.shift, block);
            } else {
              take(pending, first, first + count);
            }
          });
          if (after == After::pairs) kernels_.add_pairs(work_, first, first + count);  // a scene of pair sums has no contacts
          followers_.hold_fixed(first, first + count);
          if (begin != nullptr) kernels_.begin_sweeps(*begin, work_, first, first + count);
        }
      });
    });
  }

  // Puts particles that springs or constraints have moved into a contact since the last flow back onto it, by the flow f of no
  // time. Leaves their velocity to the next flow: otherwise rounding, which decides whether a particle at rest on a surface
  // stands inside, would decide its velocity too.
  void settle(std::size_t f) noexcept {
    const FreeMotion<T>& motion = *m_.flows()[f];
    followers_.move_surfaces(motion, call_.clock, call_.clock);
    call_.for_each_stepped([&](std::size_t from, std::size_t end) {
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
        followers_.hold_fixed(first, first + count);
      }
    });
  }

  void leave(const PendingShift& pending) noexcept { pending_ = pending; }
  // Theta 1 ends a step with the springs, not with a flow.
  void apply_pending_shift() noexcept {
    const PendingShift pending = std::exchange(pending_, PendingShift{});
    if (pending.shift == nullptr && pending.alpha == nullptr) return;
    call_.for_each_stepped([&](std::size_t from, std::size_t end) { take(pending, from, end); });
  }

  // ---- block by block ----------------------------------------------------------------------------------------------------

  // Calls use(log), with null if no report is wanted. A recorder takes 26 KB, which even an empty std::optional of one clears.
  template <class Use>
  void with_log(const FreeMotion<T>& motion, const Clock& start, std::uint64_t number, const Use& use) noexcept {
    if (call_.report == nullptr || (motion.terms.surface_count == 0 && !still_.is_kept())) return use(nullptr);
    ContactRecorder<T> recorder(*call_.report, logged_, call_.scene.options.arithmetic);
    recorder.begin(call_.report->steps + number, start, motion.step());
    use(&recorder);
  }
  Block<T> block_of(std::size_t first, std::size_t count, ContactLog<T>* log) noexcept {
    Block<T> block{.first = first, .count = count, .log = log};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = work_.x[axis] + first;
      block.v[axis] = work_.v[axis] + first;
    }
    return block;
  }
  // take(): applies what pulses have left, after the places of still particles have been kept.
  template <class Take>
  void flow_block(const FreeMotion<T>& motion, const FlowOffsets& offsets, const SubstepImpulse<T>& impulse, Block<T>& block,
                  const Take& take) noexcept {
    if (!still_.is_kept()) {
      take();
      return flow_block(motion, offsets, block);
    }
    RestingBlock<T> still = still_.in(terms_of_contacts(motion), block);
    if (impulse.pulses == 0) still.find_carried(impulse.t);
    still.keep();
    take();
    still.judge(motion, offsets.data(), impulse);
    flow_block(motion, offsets, block);
    still.end();
  }

 private:
  struct alignas(64) BlockColumns {
    using Column = std::array<T, column_pitch<T>(max_block)>;
    std::array<Column, 3> columns;  // left uninitialised
  };

  // Moves the clock, and everything that follows a motion, to the end of a flow. Returns the flow's start.
  Clock go_on(std::size_t f) noexcept {
    const FreeMotion<T>& motion = *m_.flows()[f];
    if (motion.system.depends_on_time()) make_offsets(f, call_.clock, offsets_[f]);
    const Clock start = call_.clock;
    call_.clock.advance(motion.step(), 1);
    followers_.move(call_.end_of_flow());
    followers_.move_surfaces(motion, start, call_.end_of_flow());
    if (still_.is_kept() && motion.terms.surface_count == 0 && !ws_.surfaces.empty()) {
      followers_.move_surfaces(*m_.flows()[m_.first()[0]], start, call_.end_of_flow());
    }
    return start;
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
    motion.kernels->at(motion.flow, motion.features)(block, moves ? followers_.moved_terms() : motion.terms, once);
  }

  // Backward flows have no contacts of their own: they use those of the first flow.
  [[nodiscard]] const Terms<T>& terms_of_contacts(const FreeMotion<T>& motion) const noexcept {
    if (!ws_.surfaces.empty()) return followers_.moved_terms();
    return motion.terms.surface_count != 0 ? motion.terms : m_.flows()[m_.first()[0]]->terms;
  }

  void take_in_flow(const ShiftTerms<T>& shift, Block<T>& block) const noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) block.shift[axis] = work_.shift[axis] + block.first;
    block.to_x = shift.to_x;
    block.to_v = shift.to_v;
  }
  void take(const PendingShift& pending, std::size_t from, std::size_t to) noexcept {
    if (pending.shift != nullptr) kernels_.take_shift(work_, pending.shift->to_x, pending.shift->to_v, from, to);
    if (pending.alpha != nullptr) kernels_.end_sweeps(*pending.alpha, work_, from, to);
  }

  JoinedCall<T>& call_;
  const JoinedMotion<T>& m_;
  JoinedWorkspace<T>& ws_;
  WorkColumns<T>& work_;
  const NetworkKernels<T>& kernels_;
  JoinedFollowers<T>& followers_;
  JoinedResting<T> still_;
  LoggedParticles logged_;
  PendingShift pending_{};
  std::array<FlowOffsets, max_flows> offsets_;
};

}  // namespace dvdx
