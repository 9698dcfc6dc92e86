// Several stages over a long line of chunks while these are in cache: split tiling.
#pragma once

#include <cstddef>

#include "work/tasks.hpp"

namespace dvdx {

// Calls body(stage, from, to) so that each chunk passes through the stages 0, 1, ... in turn. Stage j of chunk c comes after
// stage j - 1 of c - 1, c and c + 1, and before stage j + 1 of any of them. A stage may therefore read its neighbours as the
// stage before left them, unless it and the stage after both write what a neighbour reads. First each block goes through all
// stages, at each stage one chunk less on each side. Then the gaps between blocks are filled, which widen by as much:
//   stage 2        ^^    gaps    ^^
//   stage 1   ....^^^^  ......  ^^^^....
//   stage 0   ..........|..........|....
//                    blocks
//
// The tasks of either half touch nothing in common, so that all stages together take two barriers (Grosser et al. 2013).
// 1 <= stages <= per_block / 2.
template <class Body>
void for_each_tile(const ParallelFor& parallel, std::size_t chunks, std::size_t per_block, std::size_t stages,
                   const Body& body) noexcept {
  const std::size_t blocks = chunks < per_block ? 1 : chunks / per_block;
  const auto begin_of = [&](std::size_t block) { return chunks * block / blocks; };
  for_each_task(parallel, blocks, [&](std::size_t block) {
    for (std::size_t j = 0; j < stages; ++j) {
      body(j, begin_of(block) + (block == 0 ? 0 : j), begin_of(block + 1) - (block + 1 == blocks ? 0 : j));
    }
  });
  for_each_task(parallel, blocks - 1, [&](std::size_t gap) {
    for (std::size_t j = 1; j < stages; ++j) body(j, begin_of(gap + 1) - j, begin_of(gap + 1) + j);
  });
}

}  // namespace dvdx
