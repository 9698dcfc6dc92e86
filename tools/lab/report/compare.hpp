// The errors of a run relative to the reference, accumulated over the sample times. Positions and velocities count until the
// reference's horizon. The energy counts beyond it too if nothing gives or takes any. Divergence is checked at all times.
#pragma once

#include <cstdint>

#include "dvdx/layouts/state.hpp"
#include "report/reference.hpp"

namespace dvdx::tool::report {

// A run whose error exceeds this many amplitudes counts as diverged, even if its numbers are finite.
inline constexpr double diverged_beyond = 100;

class Comparison {
 public:
  Comparison(const Reference& reference, const SceneFile& sample) : reference_(reference), sample_(sample) {}

  // `state` is the run's state at sample time `time`, including the start (time 0).
  template <class T>
  void take(const State<T>& state, std::size_t time);
  // The same, for an energy (J) of more particles than the state has.
  template <class T>
  void take(const State<T>& state, std::size_t time, double energy);

  [[nodiscard]] Errors errors() const;
  [[nodiscard]] const std::vector<double>& energy() const noexcept { return energy_; }

 private:
  const Reference& reference_;
  const SceneFile& sample_;
  double position_squares_ = 0;
  double velocity_squares_ = 0;
  double largest_square_ = 0;
  std::size_t compared_ = 0;
  double all_squares_ = 0;  // including times beyond the horizon
  std::size_t all_compared_ = 0;
  std::vector<double> energy_;
  double drift_ = 0;
  std::size_t bad_particles_ = 0;
};

extern template void Comparison::take(const State<float>&, std::size_t);
extern template void Comparison::take(const State<double>&, std::size_t);
extern template void Comparison::take(const State<double>&, std::size_t, double);

}  // namespace dvdx::tool::report
