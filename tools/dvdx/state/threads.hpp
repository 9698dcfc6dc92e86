// The threads of a run: OpenMP's if the build has it, otherwise the calling thread alone.
#pragma once

#include <memory>

#include "dvdx/parallel.hpp"

namespace dvdx::tool {

[[nodiscard]] int most_threads();  // that this build can use here
[[nodiscard]] int all_cores();     // a run's threads if none are given

class Threads {
 public:
  explicit Threads(int count);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  [[nodiscard]] ParallelFor parallel_for() const noexcept;

 private:
  class Team;
  std::unique_ptr<Team> team_;
};

}  // namespace dvdx::tool
