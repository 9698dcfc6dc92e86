// The schemes that a report steps networks by, and how often a step.
#pragma once

#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "report/results.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::report {

struct Curve {
  std::string name;
  Coupling coupling{};  // sub-steps apart
};

[[nodiscard]] std::vector<Curve> curves_of(const SceneFile& file);

// Rising. Of a scheme with a limit: from the fewest that are stable at the start, those of "auto" among them.
[[nodiscard]] std::vector<int> substeps_of(const Curve& curve, const NetworkLimit& limit, Effort effort);

// What one sub-step costs beside one of leapfrog, roughly.
[[nodiscard]] double pulses_of(const Coupling& coupling) noexcept;

[[nodiscard]] Coupled described(const SceneFile& file, const Curve& curve);

}  // namespace dvdx::tool::report
