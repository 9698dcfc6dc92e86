// Visits every instruction set and arithmetic of this machine.
#pragma once

#include <string>

#include "dvdx/isa.hpp"
#include "kernel/passes/joined_run.hpp"

namespace dvdx::test {

// use(run, words): "avx2 contracted".
template <class Use>
void for_each_run(const Use& use) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      use(Run{.isa = isa, .arithmetic = arithmetic}, std::string(name(isa)) + ' ' + std::string(name(arithmetic)));
    }
  }
}

}  // namespace dvdx::test
