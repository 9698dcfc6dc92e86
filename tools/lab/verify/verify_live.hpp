// Runs a scene whose particles come and go in every possible way.
#pragma once

#include "verify/verify_matrix.hpp"

namespace dvdx::tool {

// Covers instruction sets, layouts, threads, blocks, and one or many steps in a call. Big scenes run for fewer steps.
[[nodiscard]] Verdict verify_live(const SceneFile& file, std::uint64_t steps, Precision precision,
                                  std::optional<Arithmetic> only);

}  // namespace dvdx::tool
