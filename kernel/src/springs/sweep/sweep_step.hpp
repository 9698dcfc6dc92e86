// Gauss-Seidel sweeps over a network's springs, as a call of step() has a form make them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/network.hpp"
#include "dvdx/parallel.hpp"
#include "springs/network.hpp"
#include "springs/sweep/spring_lines.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// All that it refers to must outlive it; work: as it is at each sweep.
template <class T>
struct SweepStep {
  // The sheets of a stack that are swept.
  struct Sheets {
    std::size_t first = 0, end = 1;
  };

  SweepOrder order;
  const ParticleOrder& particles;
  const std::vector<std::uint32_t>& records;  // of a list in a part of a larger scene: where each particle's begins
  const NetworkKernels<T>& kernels;
  const WorkColumns<T>& work;
  const WorkRooms<T>& rooms;
  const Exchange& exchange;
  const ParallelFor& parallel;
  const Sheets& sheets;
  bool knows_origins = false;  // those of this step

  void begin_step() noexcept { knows_origins = false; }
  [[nodiscard]] bool is_symmetric() const noexcept { return order == SweepOrder::symmetric; }
};

}  // namespace dvdx
