// The machine that a figure was measured on.
#pragma once

#include <string>

namespace dvdx::bench {

struct Machine {
  std::string cpu, compiler, date;
  std::string
      openmp;  // how its threads are bound and wait: where other programs run, threads that are not bound may share a core
  unsigned cores = 0;
  double load = 0;  // of the last minute: what else ran
};

Machine this_machine();

}  // namespace dvdx::bench
