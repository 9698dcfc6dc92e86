// Benchmarks run for figures, or only to check results.
#pragma once

namespace dvdx::bench {

// Timed: each benchmark repeats until its figure is stable. Quick: each runs once and is compared, with smaller batches where
// only a figure needs large ones.
enum class Pace { timed, quick };

}  // namespace dvdx::bench
