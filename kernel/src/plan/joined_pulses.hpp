// The pulses of springs between the flows of a call of joined particles, one for each form that sums by owner.
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
      : call_(call), joints_(call.joints), work_(call.work), kernels_(call.kernels) {}

  void pulse(const GridForm<T>& form, std::size_t k) noexcept {
    const Units rows{form.terms.rows, particles_per_task / form.terms.pitch};
    if (joints_.damping_passes() == 0) return kick(kernels_.grid, form.terms, k, rows);
    call_.tell(rows, work_.a0,
               [&](std::size_t from, std::size_t to) { kernels_.grid_acceleration(form.terms, work_, from, to); });
    take_acceleration(kernels_.damp_grid, form.terms, k, rows);
  }
  void pulse(const GraphForm<T>& form, std::size_t k) noexcept {
    const Units slices{call_.size() / slice, particles_per_task / slice};
    if (joints_.damping_passes() == 0) return kick(kernels_.graph, form.terms, k, slices);
    call_.tell(slices, work_.a0,
               [&](std::size_t from, std::size_t to) { kernels_.graph_acceleration(form.terms, work_, from, to); });
    take_acceleration(kernels_.damp_graph, form.damped, k, slices);
  }

  // Brown's contributions, which the next flow adds.
  void sum_pairs(const PairsForm<T>& form) noexcept {
    call_.over({call_.size() / slice, particles_per_task / slice},
               [&](std::size_t from, std::size_t to) { kernels_.pairs(form.terms, work_, from, to); });
    call_.tell(work_.dx);
    call_.tell(work_.dv);
  }

 private:
  template <class Kick, class Terms>
  void kick(const Kick& kick, const Terms& terms, std::size_t k, const Units& units) noexcept {
    const T pulse = static_cast<T>(joints_.splitting.b[k] * joints_.substep());
    call_.tell(units, work_.v_next, [&](std::size_t from, std::size_t to) { kick(terms, work_, pulse, from, to); });
    std::swap(work_.v, work_.v_next);
  }

  // v += b h a + (b h)^2/2 a1 + beta h^3 a2, the last of them where the scheme has it.
  template <class Damp, class Terms>
  void take_acceleration(const Damp& damp, const Terms& terms, std::size_t k, const Units& units) noexcept {
    const double h = joints_.substep();
    const double t = joints_.splitting.b[k] * h;
    DampingPass<T> pass{.of = work_.a0, .y = work_.a1, .s = static_cast<T>(t), .t = static_cast<T>(t * t / 2)};
    const auto run = [&](const std::array<T*, 3>& told) {
      call_.tell(units, told, [&](std::size_t from, std::size_t to) { damp(terms, work_, pass, from, to); });
    };
    if (joints_.damping_passes() == 1) return run(work_.v);
    run(work_.a1);
    const double beta = joints_.splitting.beta[k];
    pass = {.of = work_.a1, .y = {}, .s = static_cast<T>(t * t / 2), .t = static_cast<T>(beta * h * h * h)};
    run(work_.v);
  }

  JoinedCall<T>& call_;
  const Joints<T>& joints_;
  WorkColumns<T>& work_;
  const NetworkKernels<T>& kernels_;
};

}  // namespace dvdx
