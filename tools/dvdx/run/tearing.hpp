// Springs of a run that tear: what `tears_at` of the scene's networks asks for, at each step's end.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <variant>
#include <vector>

#include "checkpoint/byte_stream.hpp"
#include "dvdx/plan.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

template <class T>
class Tearing {
 public:
  explicit Tearing(const SceneFile& file) : tears_at_(file.tears_at) {}

  [[nodiscard]] bool is_possible() const noexcept { return !tears_at_.empty(); }
  // What has torn so far, in the order of the steps.
  [[nodiscard]] const std::vector<Tear>& tears() const noexcept { return tears_; }

  void look(Plan<T>& plan, const State<T>& state, std::uint64_t step) {
    for (std::size_t n = 0; n < tears_at_.size(); ++n) {
      if (!std::isfinite(tears_at_[n])) continue;
      const auto torn = plan.tear(n, tears_at_[n], state);
      if (!torn) throw std::logic_error(torn.error().message());
      const auto& broken = broken_of(plan.scene().networks[n]);
      for (std::size_t k = broken.size() - *torn; k < broken.size(); ++k) tears_.push_back({step, n, broken[k]});
    }
  }

  void save(Sink& sink) const {
    if (!is_possible()) return;
    std::vector<std::uint64_t> numbers;
    for (const auto& [step, network, ends] : tears_) numbers.insert(numbers.end(), {step, network, ends[0], ends[1]});
    sink.put(std::span<const std::uint64_t>(numbers));
  }
  void load(Source& source, Plan<T>& plan) {
    if (!is_possible()) return;
    std::vector<std::uint64_t> numbers;
    source.get(numbers);
    if (numbers.size() % 4 != 0) source.fail();
    for (std::size_t k = 0; k < numbers.size(); k += 4) {
      const Pair ends{static_cast<std::uint32_t>(numbers[k + 2]), static_cast<std::uint32_t>(numbers[k + 3])};
      tears_.push_back({numbers[k], numbers[k + 1], ends});
    }
    for (std::size_t n = 0; n < tears_at_.size(); ++n) {
      std::vector<Pair> torn;
      for (const Tear& tear : tears_) {
        if (tear.network == n) torn.push_back(tear.ends);
      }
      if (!torn.empty() && !plan.break_springs(n, torn)) source.fail();
    }
  }

 private:
  static const std::vector<Pair>& broken_of(const Network& network) {
    return std::visit([](const auto& of) -> const std::vector<Pair>& { return of.broken; }, network);
  }

  const std::vector<double>& tears_at_;
  std::vector<Tear> tears_;
};

}  // namespace dvdx::tool
