// A scene whose particles come and go, stepped by several ranks: each makes its share of the births of each step and keeps what
// it has made. In which order all of them stand is told by numbers: how many births there were before.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/live.hpp"
#include "dvdx/ranks.hpp"
#include "ranks/range_exchange.hpp"
#include "state/live_memory.hpp"

namespace dvdx::tool {

// A rank has room for all particles, as those of the others may all die; what none has stood in takes no memory.
template <class T>
class SharedLife {
 public:
  SharedLife(const SceneFile& file, Layout layout, Ranks& ranks);
  SharedLife(const SharedLife&) = delete;
  SharedLife& operator=(const SharedLife&) = delete;

  // For the plan's options: valid as long as this.
  [[nodiscard]] static SharedBirths births(Ranks& ranks) noexcept;

  // This rank's own.
  [[nodiscard]] LiveState<T>& live() noexcept { return columns_.live(); }

  // Each particle's id moves along with it from now on.
  void carry_ids();

  // Called by all: what the ranges hold is dealt out, one particle to each rank in turn; and what the ranks hold is cut into
  // ranges in the order in which one rank would keep it.
  void deal(LiveMemory<T>& range);
  void to_range(LiveMemory<T>& range);
  // Called by all: the ids that what is in the ranges has been given since.
  void take_ids(LiveMemory<T>& range);

  // For each particle that this rank has now, the number of births before its own: kept until the next call.
  [[nodiscard]] std::span<const std::int64_t> kept_numbers();

 private:
  [[nodiscard]] std::span<std::int64_t> numbers() noexcept { return {numbers_.get(), live().state.count}; }
  [[nodiscard]] std::span<std::uint32_t> ids() noexcept { return {ids_->get(), live().state.count}; }

  Ranks& ranks_;
  std::size_t room_;
  LiveColumns<T> columns_;
  AlignedArray<std::int64_t> numbers_;  // of each own particle: those of the start or of a checkpoint before all births since
  std::optional<AlignedArray<std::uint32_t>> ids_;
  std::array<Carried, 2> carried_;
  std::optional<RangeExchange> exchange_;  // with which the ranges were made, where ids go back
  std::vector<std::int64_t> kept_numbers_;
};

extern template class SharedLife<float>;
extern template class SharedLife<double>;

}  // namespace dvdx::tool
