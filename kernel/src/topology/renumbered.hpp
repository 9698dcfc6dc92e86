// The particles of a part, by their numbers in the whole.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include "dvdx/partition.hpp"

namespace dvdx {

// Maps numbers of the whole to numbers of the part, or to none.
class Renumbered {
 public:
  explicit Renumbered(const Part& part) : part_(part), in_order_(part.particles.size()) {
    std::iota(in_order_.begin(), in_order_.end(), 0U);
    std::sort(in_order_.begin(), in_order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return part.particles[a] < part.particles[b]; });
  }
  [[nodiscard]] std::optional<std::uint32_t> operator()(std::size_t number) const {
    const auto found = std::lower_bound(in_order_.begin(), in_order_.end(), number,
                                        [&](std::uint32_t a, std::size_t n) { return part_.particles[a] < n; });
    if (found == in_order_.end() || part_.particles[*found] != number) return std::nullopt;
    return *found;
  }
  [[nodiscard]] bool is_own(std::uint32_t particle) const { return part_.is_own[particle] != 0; }

 private:
  const Part& part_;
  std::vector<std::uint32_t> in_order_;
};

}  // namespace dvdx
