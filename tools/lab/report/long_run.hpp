// The energy of undamped springs over a hundred thousand steps, compared with the prediction of the step's determinant.
#pragma once

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// Empty unless the scene consists of undamped springs at one common anchor, alike in all axes and without contacts.
[[nodiscard]] std::vector<LongRun> measure_long_runs(const SceneFile& file, const Setup& setup);

// The same scene as the analysis takes it: the rates k/m of its springs (for particle 0) and their anchor.
struct PureSprings {
  std::vector<double> rates;  // 1/s^2
  Vec3 anchor{};
  [[nodiscard]] double angular_frequency() const;  // rad/s, of all springs together
};
[[nodiscard]] std::optional<PureSprings> pure_springs_of(const SceneFile& file);

}  // namespace dvdx::tool::report
