// The layout of a list's springs while they are swept: in ranges, by colour. First come the springs within each piece of the
// particles, then those that lead from piece to piece, in colours of their own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "springs/sweep/sweep_form.hpp"

namespace dvdx {

struct ColourLayout {
  std::vector<std::uint32_t> a, b, ranges;  // RangeTerms point to these
  std::vector<RecordLayout> layout;         // likewise
  std::vector<std::uint32_t> spring_at;     // of each lane, or no_spring
  std::vector<std::size_t> tasks;           // first range of each task, and one more; the first are the pieces
  std::vector<std::size_t> stages;          // first task of each stage, and one more: the tasks of a stage share no particle
  std::size_t records = 0;                  // of particles, those of lanes without a spring included

  [[nodiscard]] std::size_t springs() const noexcept { return spring_at.size(); }  // columns of lambda
  [[nodiscard]] std::size_t pieces() const noexcept { return stages[1]; }
  [[nodiscard]] std::size_t colours() const noexcept {  // of the piece with the most
    std::size_t most = 0;
    for (std::size_t piece = 0; piece < pieces(); ++piece) most = std::max(most, tasks[piece + 1] - tasks[piece]);
    return most;
  }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return bytes_of(a) + bytes_of(b) + bytes_of(ranges) + bytes_of(layout) + bytes_of(spring_at) + bytes_of(tasks) +
           bytes_of(stages);
  }
};
ColourLayout colour_layout(const NetworkInput& in);

}  // namespace dvdx
