// The context in which a form sweeps over a network's springs in a call of step().
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

// All that it refers to must outlive it. Each sweep reads `work` as it is then.
template <class T>
struct SweepStep {
  // The sheets of a stack that are swept.
  struct Sheets {
    std::size_t first = 0, end = 1;
  };

  SweepOrder order;
  const ParticleOrder& particles;
  const std::vector<std::uint32_t>& records;  // of a list in a part of a larger scene: the position of each particle's record
  const NetworkKernels<T>& kernels;
  const WorkColumns<T>& work;
  const WorkRooms<T>& rooms;
  const Exchange& exchange;
  const ParallelFor& parallel;
  const Sheets& sheets;
  bool has_from_origin = false;  // whether from_origin is of this step's origins

  void begin_step() noexcept { has_from_origin = false; }
  [[nodiscard]] bool is_symmetric() const noexcept { return order == SweepOrder::symmetric; }
};

}  // namespace dvdx
