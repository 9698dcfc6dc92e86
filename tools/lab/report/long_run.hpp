// Energy of undamped springs over a hundred thousand steps, beside what the determinant of a step says.
#pragma once

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// Empty but for scenes of undamped springs at one common anchor, alike in all axes and without contacts.
[[nodiscard]] std::vector<LongRun> measure_long_runs(const SceneFile& file, const Setup& setup);

// Such a scene as the analysis takes it: the rates k/m of its springs (of particle 0) and their anchor.
struct PureSprings {
  std::vector<double> rates;  // 1/s^2
  Vec3 anchor{};
  [[nodiscard]] double angular_frequency() const;  // of all together
};
[[nodiscard]] std::optional<PureSprings> pure_springs_of(const SceneFile& file);

}  // namespace dvdx::tool::report
