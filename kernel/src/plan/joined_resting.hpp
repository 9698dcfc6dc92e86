// Particles that stand still on a contact and stay, in a call of step() of joined particles: contact/pass/stay.hpp.
#pragma once

#include <cstddef>
#include <utility>

#include "plan/joined_call.hpp"
#include "plan/resting.hpp"

namespace dvdx {

template <class T>
class JoinedResting {
 public:
  explicit JoinedResting(JoinedCall<T>& call) noexcept
      : call_(call), ws_(call.ws), kernels_(stay_kernels<T>(call.scene.options.arithmetic)) {}

  [[nodiscard]] bool is_kept() const noexcept { return !ws_.still.empty(); }

  void note_all() noexcept {
    const WorkColumns<T>& work = call_.work;
    call_.for_each_stepped([&](std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) {
        const bool stands = work.w[i] > 0 && work.v[0][i] == 0 && work.v[1][i] == 0 && work.v[2][i] == 0;
        ws_.still[i] = stands ? RestState::stands : RestState::moves;
      }
    });
  }
  // A step begins: no pulse yet.
  void begin() noexcept {
    pulse_part_ = 0;
    waited_ = 0;
  }
  void note_pulse(std::size_t k) noexcept {
    if (is_kept()) pulse_part_ = call_.network.splitting.b[k];
  }
  // The impulse in the next flow: particles that stand still wait for the first pulse.
  [[nodiscard]] SubstepImpulse<T> impulse_in(const FreeMotion<T>& motion) noexcept {
    if (!is_kept() || motion.step() == 0) return {};
    const double waited = std::exchange(waited_, pulse_part_ == 0 ? motion.step() : 0);
    return {.t = static_cast<T>(motion.step()),
            .pulses = pulse_part_ == 0 ? T(0) : static_cast<T>(1 / pulse_part_),
            .flows = static_cast<T>(call_.network.substep() / motion.step()),
            .owed = static_cast<T>(waited / motion.step())};
  }
  // terms: include the contacts that hold the particles.
  [[nodiscard]] RestingBlock<T> in(const Terms<T>& terms, const Block<T>& block) const noexcept {
    const RestingColumns<T> all{
        .how = ws_.still, .on = ws_.still_on, .movers = ws_.movers, .w = call_.work.w, .kernels = &kernels_};
    return RestingBlock<T>(all, terms, block);
  }

 private:
  JoinedCall<T>& call_;
  JoinedWorkspace<T>& ws_;
  const StayKernels<T> kernels_;
  double pulse_part_ = 0;  // part of a sub-step that the last pulse covers; 0: none yet in this step
  double waited_ = 0;      // s: time that still particles have waited for a pulse
};

}  // namespace dvdx
