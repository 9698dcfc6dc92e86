// The particles that springs join to each particle.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

// Neighbours of each particle, ascending.
class Neighbours {
 public:
  Neighbours(std::span<const JoinedPair> springs, std::size_t count) : first_(count + 1, 0), all_(2 * springs.size()) {
    for (const JoinedPair& s : springs) {
      ++first_[s.a + 1];
      ++first_[s.b + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const JoinedPair& s : springs) {
      all_[next[s.a]++] = s.b;
      all_[next[s.b]++] = s.a;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto begin = all_.begin() + static_cast<std::ptrdiff_t>(first_[i]);
      const auto end = all_.begin() + static_cast<std::ptrdiff_t>(first_[i + 1]);
      if (!std::is_sorted(begin, end)) std::sort(begin, end);
    }
  }
  [[nodiscard]] std::size_t count(std::uint32_t i) const noexcept { return first_[i + 1] - first_[i]; }
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t i) const noexcept {
    return std::span(all_).subspan(first_[i], count(i));
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> all_;
};

}  // namespace dvdx
