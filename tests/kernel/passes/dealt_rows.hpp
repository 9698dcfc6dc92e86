// Rows of a table of answers, dealt out to the instruction sets and arithmetics of this machine.
#pragma once

#include <cstddef>

#include "dvdx/isa.hpp"
#include "kernel/passes/joined_run.hpp"

namespace dvdx::test {

// Each row is one run's in float32 and another's, in the other arithmetic, in float64. All instruction sets have the same bits,
// which other tests compare, so that no run needs every row.
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
  // Rows that follow each other after as many as there are runs, as those of one time do, are other runs'.
  [[nodiscard]] bool has(std::size_t row) const noexcept {
    return (row + row / runs_ + row / (runs_ * runs_)) % runs_ == mine_ % runs_;
  }

 private:
  std::size_t runs_ = 0, mine_ = 0;
};

}  // namespace dvdx::test
