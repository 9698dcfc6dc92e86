// The machine on which a figure was measured.
#pragma once

#include <string>

namespace dvdx::bench {

struct Machine {
  std::string cpu, compiler, date;
  std::string openmp;  // how its threads are bound and wait: beside other programs, unbound threads may share a core
  unsigned cores = 0;
  double load = 0;  // of the last minute: other programs
};

Machine this_machine();

}  // namespace dvdx::bench
