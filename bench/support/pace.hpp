// Runs of the benchmarks are for figures, or for a look at results.
#pragma once

namespace dvdx::bench {

// Timed: each is repeated until its figure holds. Quick: each runs once and is compared, and batches that only a figure needs
// as large are smaller.
enum class Pace { timed, quick };

}  // namespace dvdx::bench
