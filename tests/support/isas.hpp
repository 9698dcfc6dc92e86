// For tests that compare instruction sets.
#pragma once

#include <doctest/doctest.h>

#include "dvdx/isa.hpp"

namespace dvdx::test {

// Returns true if there is an instruction set to compare with the reference. Every x86-64 and every AArch64 machine has one,
// and the test fails if it is missing there. On another machine the test reports that it compares nothing.
inline bool has_several_isas(Arithmetic arithmetic = Arithmetic::separate) {
  const bool has = available_isas(arithmetic).size() > 1;
#if defined(__x86_64__) || defined(__aarch64__)
  if (arithmetic == Arithmetic::separate)
    CHECK_MESSAGE(has, "the instruction set that this architecture always has is missing");
#endif
  if (!has) MESSAGE(name(arithmetic) << " arithmetic: the reference is the only instruction set here, nothing is compared");
  return has;
}

}  // namespace dvdx::test
