// Distributes the rows of a table of results over the instruction sets and arithmetics of this machine.
#pragma once

#include <cstddef>

#include "dvdx/isa.hpp"
#include "kernel/passes/joined_run.hpp"

namespace dvdx::test {

// Each row runs once in float32, and once in float64 with the other arithmetic. Other tests check that all instruction sets
// have the same bits, so no run needs every row.
template <class T>
class DealtRows {
 public:
  explicit DealtRows(const Run& run) {
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      for (const Isa isa : available_isas(arithmetic)) {
        if (isa == run.isa && arithmetic == run.arithmetic) mine_ = runs_;
        ++runs_;
      }
    }
    if (sizeof(T) == 8) mine_ += runs_ / 2;
  }
  // Rows at a distance of runs_, such as those of one time, belong to different runs.
  [[nodiscard]] bool has(std::size_t row) const noexcept {
    return (row + row / runs_ + row / (runs_ * runs_)) % runs_ == mine_ % runs_;
  }

 private:
  std::size_t runs_ = 0, mine_ = 0;
};

}  // namespace dvdx::test
