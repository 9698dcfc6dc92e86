// Brown's claims about two springs (docs/math.md), measured both where they hold and where they fail.
#pragma once

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// Empty unless the scene is one particle released at rest on two equal undamped springs.
[[nodiscard]] std::vector<Claim> measure_claims(const SceneFile& file, const std::vector<LongRun>& long_runs,
                                                const Setup& setup);

}  // namespace dvdx::tool::report
