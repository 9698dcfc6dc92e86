// The floating-point environment of a step.
#pragma once

#include <cstdint>

namespace dvdx {

// For its lifetime: round to nearest, no traps, denormal results and operands flushed to zero. A decaying scene walks into
// denormals, which cost tens of times a normal operation; flushed, a value below 1.2e-38 (float) or 2.2e-308 (double) is 0.
// The caller's modes and exception flags come back as they were.
class StepEnvironment {
 public:
  StepEnvironment() noexcept;
  ~StepEnvironment();
  StepEnvironment(const StepEnvironment&) = delete;
  StepEnvironment& operator=(const StepEnvironment&) = delete;

 private:
  std::uint64_t saved_ = 0;
  [[maybe_unused]] std::uint64_t saved_flags_ = 0;  // if they have a register of their own
};

}  // namespace dvdx
