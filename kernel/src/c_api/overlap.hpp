// Whether columns of the caller's share memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "dvdx/dvdx.h"

namespace dvdx::c_api {

// A column's bytes: runs of `bytes` each, `stride` apart in ascending order. The column's last run may be shorter. It lies
// highest (`last`), or lowest if the column's stride is negative (`first`).
struct Runs {
  std::uintptr_t low = 0;     // of the lowest run
  std::uintptr_t stride = 0;  // from a run to the next higher
  std::size_t count = 0;
  std::size_t bytes = 0;
  std::size_t first = 0, last = 0;  // of the lowest and of the highest run

  [[nodiscard]] std::uintptr_t begin(std::size_t i) const noexcept { return low + i * stride; }
  [[nodiscard]] std::uintptr_t end(std::size_t i) const noexcept {
    if (i + 1 == count) return begin(i) + last;
    return begin(i) + (i == 0 ? first : bytes);
  }
};

// The runs of the first n elements, n > 0.
[[nodiscard]] Runs runs_of(const dvdx_column& column, std::size_t n, std::size_t size) noexcept;
[[nodiscard]] bool overlaps_itself(const Runs& a) noexcept;
// Exact. Takes a few operations if the columns lie apart or have the same stride, otherwise one pass over their runs.
[[nodiscard]] bool overlap(const Runs& a, const Runs& b) noexcept;

}  // namespace dvdx::c_api
