// A scene whose particles come and go, run in every way that there is.
#pragma once

#include "verify/verify_matrix.hpp"

namespace dvdx::tool {

// Besides instruction sets, layouts, threads and blocks: steps one by one and many in a call. Big scenes run for fewer steps.
[[nodiscard]] Verdict verify_live(const SceneFile& file, std::uint64_t steps, Precision precision,
                                  std::optional<Arithmetic> only);

}  // namespace dvdx::tool
