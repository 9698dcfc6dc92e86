// A scene whose particles come and go, stepped by several ranks: each makes its share of the births of each step and keeps what
// it has made. In which order all of them stand is told by numbers: how many births there were before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/live.hpp"
#include "dvdx/ranks.hpp"
#include "run/live_memory.hpp"

namespace dvdx::tool {

template <class T>
class SharedLife {
 public:
  SharedLife(const SceneFile& file, Layout layout, Ranks& ranks);
  SharedLife(const SharedLife&) = delete;
  SharedLife& operator=(const SharedLife&) = delete;

  // For the plan's options: valid as long as this.
  [[nodiscard]] static SharedBirths births(Ranks& ranks) noexcept;

  // This rank's own.
  [[nodiscard]] LiveState<T>& live() noexcept { return memory_.live(); }

  // Called by all of them. `whole` is the first rank's, and untouched on others: what it holds is dealt out, one particle to
  // each rank in turn, and brought together again in the order in which one rank would keep it.
  void deal(LiveMemory<T>& whole);
  void gather(LiveMemory<T>& whole);

  // Where this rank's particles stand among all. Called by all of them; valid until the next call.
  [[nodiscard]] std::span<const std::uint32_t> places();

 private:
  // What is in the lists of what is told, to the first rank; and from another one.
  void send();
  void receive(int from);
  [[nodiscard]] std::span<std::int64_t> numbers(std::size_t count) noexcept { return {numbers_.data(), count}; }

  Ranks& ranks_;
  LiveMemory<T> memory_;
  std::vector<std::int64_t> numbers_;  // of each own particle: those of the start or of a checkpoint before all births since
  Carried carried_;
  std::vector<std::int64_t> of_all_;  // of the first rank: of each when they were last dealt or gathered
  // What is told: numbers, places and columns of one rank's particles.
  std::vector<std::int64_t> told_;
  std::vector<std::uint32_t> places_;
  std::vector<T> buffer_;
};

extern template class SharedLife<float>;
extern template class SharedLife<double>;

}  // namespace dvdx::tool
