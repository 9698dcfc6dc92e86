// A halo of joined particles, sent and received between the pulses of a step (dvdx/elsewhere.hpp). By MPI: adapters/mpi.cpp.
#pragma once

#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/ranks.hpp"

namespace dvdx::tool {

class HaloExchange {
 public:
  HaloExchange(Ranks& ranks, const Part& part);
  HaloExchange(const HaloExchange&) = delete;
  HaloExchange& operator=(const HaloExchange&) = delete;

  // Valid as long as this object.
  [[nodiscard]] Exchange exchange() noexcept {
    return {.context = this,
            .start = start,
            .finish = finish,
            .is_told = part_.is_told.data(),
            .is_own = part_.is_own.data(),
            .pulses_per_telling = part_.pulses_per_telling};
  }
  // Returns the time in s spent waiting for others.
  [[nodiscard]] double waited_seconds() const noexcept { return waited_seconds_; }

 private:
  static void start(void* context, const HaloColumns& columns) noexcept;
  static void finish(void* context, const HaloColumns& columns) noexcept;
  template <class A>
  void send(const HaloColumns& columns) noexcept;
  template <class A>
  void receive(const HaloColumns& columns) noexcept;

  struct Buffers {
    std::vector<double> sent, received;  // room for three numbers a particle in either precision
  };
  Ranks& ranks_;
  const Part& part_;
  std::vector<Buffers> buffers_;
  double waited_seconds_ = 0;
};

}  // namespace dvdx::tool
