// The error and the time of the library's runs.
#pragma once

#include <memory>
#include <optional>

#include "report/compare.hpp"

namespace dvdx::tool::report {

struct Measured {
  Errors errors;
  std::vector<double> energy;  // J, at every sample time
};

// Errors of one run on the sample's particles by `scene`, which is the sample's scene with another method or scheme. Its step
// is the grid's coarsest divided by `parts`. Throws Fault (bad_scene) if the scene cannot run so.
template <class T>
[[nodiscard]] Measured measure_errors(const SceneFile& sample, const Scene& scene, const Grid& grid, std::uint64_t parts,
                                      const Reference& reference, const Setup& setup);

// Times runs on all particles of a scene. A short run is timed as a whole. A long one is timed in pieces from several moments,
// because the cost of a step may change during the run (nothing hits the ground at first).
template <class T>
class Timer {
 public:
  Timer(const SceneFile& file, const Grid& grid, const Setup& setup, Effort effort);
  // The moments are taken from a run of `moments`, which is the scene with another method or scheme.
  Timer(const SceneFile& file, Scene moments, const Grid& grid, const Setup& setup, Effort effort);
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  ~Timer();

  [[nodiscard]] Timing time(Method method, int halving);
  [[nodiscard]] Timing time(const Plan<T>& plan, std::uint64_t steps);

 private:
  using Buffer = StateMemory<T>;

  void make_moments();
  [[nodiscard]] Timing time_whole(const Plan<T>& plan, std::uint64_t steps);
  [[nodiscard]] Timing time_pieces(const Plan<T>& plan, double seconds_per_step, std::uint64_t steps);
  void run(const Plan<T>& plan, std::uint64_t steps);

  const SceneFile& file_;
  std::optional<Scene> moments_scene_;
  const Grid& grid_;
  const Setup& setup_;
  Effort effort_;
  Buffer start_;
  Buffer work_;
  std::vector<std::unique_ptr<Buffer>> moments_;  // made at first use
  std::vector<Clock> clocks_;
};

extern template Measured measure_errors<float>(const SceneFile&, const Scene&, const Grid&, std::uint64_t, const Reference&,
                                               const Setup&);
extern template Measured measure_errors<double>(const SceneFile&, const Scene&, const Grid&, std::uint64_t, const Reference&,
                                                const Setup&);
extern template class Timer<float>;
extern template class Timer<double>;

}  // namespace dvdx::tool::report
