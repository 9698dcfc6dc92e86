// Tears springs of a run at each step's end, as `tears_at` of the scene's networks says.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "files/byte_stream.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

class Tearing {
 public:
  explicit Tearing(const SceneFile& file) : tears_at_(file.tears_at) {}

  [[nodiscard]] bool is_possible() const noexcept { return !tears_at_.empty(); }
  // The springs that have torn so far, in the order of the steps.
  [[nodiscard]] const std::vector<Tear>& tears() const noexcept { return tears_; }

  // Returns true if a spring has torn. `springs` finds and breaks: a plan of all particles, or the parts of several ranks.
  template <class Found>
  bool look(Found& springs, std::uint64_t step) {
    const std::size_t before = tears_.size();
    for (std::size_t n = 0; n < tears_at_.size(); ++n) {
      if (!std::isfinite(tears_at_[n])) continue;
      const std::vector<Pair> torn = springs.too_long(n, tears_at_[n]);
      if (torn.empty()) continue;
      springs.break_springs(n, torn);
      for (const Pair& ends : torn) tears_.push_back({step, n, ends});
    }
    return tears_.size() != before;
  }

  // Returns the networks with the torn springs marked as broken.
  [[nodiscard]] std::vector<Network> torn(std::vector<Network> networks) const {
    for (const Tear& tear : tears_) {
      std::visit([&](auto& of) { of.broken.push_back(tear.ends); }, networks[tear.network]);
    }
    return networks;
  }

  void save(Sink& sink) const {
    if (!is_possible()) return;
    std::vector<std::uint64_t> numbers;
    for (const auto& [step, network, ends] : tears_) numbers.insert(numbers.end(), {step, network, ends[0], ends[1]});
    sink.put(std::span<const std::uint64_t>(numbers));
  }
  void load(Source& source) {
    if (!is_possible()) return;
    std::vector<std::uint64_t> numbers;
    source.get(numbers);
    if (numbers.size() % 4 != 0) source.fail();
    for (std::size_t k = 0; k < numbers.size(); k += 4) {
      const Pair ends{static_cast<std::uint32_t>(numbers[k + 2]), static_cast<std::uint32_t>(numbers[k + 3])};
      tears_.push_back({numbers[k], numbers[k + 1], ends});
    }
  }
  // Breaks the springs that were loaded. Returns whether there are any.
  template <class Found>
  bool break_again(Found& springs) const {
    for (std::size_t n = 0; n < tears_at_.size(); ++n) {
      std::vector<Pair> torn;
      for (const Tear& tear : tears_) {
        if (tear.network == n) torn.push_back(tear.ends);
      }
      if (!torn.empty()) springs.break_springs(n, torn);
    }
    return !tears_.empty();
  }

 private:
  const std::vector<double>& tears_at_;
  std::vector<Tear> tears_;
};

}  // namespace dvdx::tool
