// Brown's claims about two springs (docs/math.md), measured where they hold and where they do not.
#pragma once

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// Empty but for one particle let go at rest on two equal undamped springs.
[[nodiscard]] std::vector<Claim> measure_claims(const SceneFile& file, const std::vector<LongRun>& long_runs,
                                                const Setup& setup);

}  // namespace dvdx::tool::report
