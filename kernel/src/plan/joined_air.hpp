// Air in a call of joined particles, in the middle of a pulse or in halves at both ends of a sub-step: air/air.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "plan/joined_call.hpp"

namespace dvdx {

template <class T>
class JoinedAir {
 public:
  explicit JoinedAir(JoinedCall<T>& call) noexcept
      : call_(call), network_(call.network), ws_(call.ws), work_(call.work), kernels_(call.passes.template of<T>().air) {}

  void begin_substep(int substep) noexcept { substeps_ = network_.air ? substeps_of(substep, network_.chosen.substeps) : 0; }
  [[nodiscard]] bool blows() const noexcept { return substeps_ != 0; }
  // The part of the air's pulse that goes with pulse k: all of it, or, of six pulses, half each with the third and the fourth.
  [[nodiscard]] double part_of(std::size_t k) const noexcept {
    if (substeps_ == 0) return 0;
    const std::size_t pulses = network_.splitting.b.size();
    if (pulses == 1) return 1;
    return k + 1 == pulses / 2 || k == pulses / 2 ? 0.5 : 0;
  }

  void keep_velocity() noexcept {
    call_.over(elements(), [&](std::size_t from, std::size_t to) {
      for (std::size_t axis = 0; axis < 3; ++axis) std::copy_n(work_.v[axis] + from, to - from, ws_.air_v[axis] + from);
    });
  }
  void blow_on_velocity(double part) noexcept {
    keep_velocity();
    blow(part);
  }
  // Blows at the mean of the kept velocity and the present one, which the springs' pulse has changed since.
  void blow_in_the_middle(double part) noexcept {
    const WorkColumns<T> work = columns();
    call_.over(elements(), [&](std::size_t from, std::size_t to) { kernels_.middle(work, from, to); });
    blow(part);
  }

 private:
  // The number of sub-steps that one pulse of air in this one covers; 0 if it has none. Air is far slower than springs that
  // ask for sub-steps. Groups of five therefore share one pulse, in the middle one; the rest is cut into groups of 3 and 1.
  [[nodiscard]] static int substeps_of(int substep, int substeps) noexcept {
    for (const int together : {5, 3, 1}) {
      const int groups = substeps / together;
      if (substep < groups * together) return substep % together == together / 2 ? together : 0;
      substep -= groups * together;
      substeps -= groups * together;
    }
    return 0;
  }

  [[nodiscard]] Units elements() const noexcept { return {call_.size() / slice, particles_per_task / slice, slice}; }
  [[nodiscard]] WorkColumns<T> columns() const noexcept {
    WorkColumns<T> work = work_;
    work.v_next = ws_.air_v;
    return work;
  }

  // Applies that part of the air's pulse, evaluated at the velocities air_v.
  void blow(double part) noexcept {
    const Vec3 wind = call_.motion.wind_at(call_.end_of_flow());
    const double t = part * substeps_ * network_.substep();
    const std::array<T*, 3> g = blow(AirStage::first, wind, t);
    call_.send(g);
    blow(AirStage::second, wind, t);
    call_.send(work_.v);
  }
  // Returns the columns that the first stage leaves to the second.
  std::array<T*, 3> blow(AirStage stage, const Vec3& wind, double t) noexcept {
    return network_.air->is_grid() ? blow_rows(stage, wind, t) : blow_list(stage, wind, t);
  }
  std::array<T*, 3> blow_rows(AirStage stage, const Vec3& wind, double t) noexcept {
    const GridAirTerms<T> grid = ws_.with_columns(network_.air->grid());
    const AirPulse<T> pulse = air_pulse<T>(network_.air->networks()[0].aerodynamics, wind, t);
    const WorkColumns<T> work = columns();
    call_.over({grid.rows, particles_per_task / grid.pitch},
               [&](std::size_t from, std::size_t to) { kernels_.grid(grid, pulse, work, stage, from, to); });
    return grid.g;
  }
  std::array<T*, 3> blow_list(AirStage stage, const Vec3& wind, double t) noexcept {
    const TriangleTerms<T> list = ws_.with_columns(network_.air->triangles());
    const WorkColumns<T> work = columns();
    for (const AirNetwork& of : network_.air->networks()) {
      const AirPulse<T> pulse = air_pulse<T>(of.aerodynamics, wind, t);
      call_.over({(of.end - of.first) / slice, particles_per_task / slice, slice}, [&](std::size_t from, std::size_t to) {
        kernels_.triangles(list, pulse, work, stage, of.first + from, of.first + to);
      });
    }
    call_.over({call_.size() / slice, particles_per_task / slice},
               [&](std::size_t from, std::size_t to) { kernels_.gather(list, work, stage, from, to); });
    return list.g;
  }

  JoinedCall<T>& call_;
  const CompiledNetwork<T>& network_;
  JoinedWorkspace<T>& ws_;
  WorkColumns<T>& work_;
  const AirKernels<T>& kernels_;
  int substeps_ = 0;  // that this sub-step's air covers
};

}  // namespace dvdx
