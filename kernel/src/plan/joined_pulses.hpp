// The pulses of springs between the flows of a call of joined particles, for any form of springs/sum/.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "plan/joined_call.hpp"

namespace dvdx {

template <class T>
class JoinedPulses {
 public:
  explicit JoinedPulses(JoinedCall<T>& call) noexcept
      : call_(call), network_(call.network), work_(call.work), kernels_(call.kernels) {}

  template <class Form>
  void pulse(const Form& form, std::size_t k) noexcept {
    const Units units = call_.units_of(form.unit());
    if (network_.damping_passes() == 0) return kick(form, k, units);
    call_.send(units, work_.a0, [&](std::size_t from, std::size_t to) { form.accelerate(kernels_, work_, from, to); });
    take_acceleration(form, k, units);
  }

  // Brown's contributions, which the next flow adds.
  template <class Form>
  void sum_pairs(const Form& form) noexcept {
    call_.over(call_.units_of(form.unit()), [&](std::size_t from, std::size_t to) { form.sum(kernels_, work_, from, to); });
    call_.send(work_.dx);
    call_.send(work_.dv);
  }

 private:
  template <class Form>
  void kick(const Form& form, std::size_t k, const Units& units) noexcept {
    const T pulse = static_cast<T>(network_.splitting.b[k] * network_.substep());
    call_.send(units, work_.v_next, [&](std::size_t from, std::size_t to) { form.kick(kernels_, work_, pulse, from, to); });
    std::swap(work_.v, work_.v_next);
  }

  // v += b h a + (b h)^2/2 a1 + beta h^3 a2, the last term only if the scheme has it.
  template <class Form>
  void take_acceleration(const Form& form, std::size_t k, const Units& units) noexcept {
    const double h = network_.substep();
    const double t = network_.splitting.b[k] * h;
    DampingPass<T> pass{.of = work_.a0, .y = work_.a1, .s = static_cast<T>(t), .t = static_cast<T>(t * t / 2)};
    const auto run = [&](const std::array<T*, 3>& sent) {
      call_.send(units, sent, [&](std::size_t from, std::size_t to) { form.damp(kernels_, work_, pass, from, to); });
    };
    if (network_.damping_passes() == 1) return run(work_.v);
    run(work_.a1);
    const double beta = network_.splitting.beta[k];
    pass = {.of = work_.a1, .y = {}, .s = static_cast<T>(t * t / 2), .t = static_cast<T>(beta * h * h * h)};
    run(work_.v);
  }

  JoinedCall<T>& call_;
  const CompiledNetwork<T>& network_;
  WorkColumns<T>& work_;
  const NetworkKernels<T>& kernels_;
};

}  // namespace dvdx
