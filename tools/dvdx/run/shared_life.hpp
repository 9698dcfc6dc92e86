// A scene whose particles come and go, stepped by several ranks: each rank makes its share of the births of each step and keeps
// the particles that it made. The order of all particles follows their numbers: the number of births before each.
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

// Each rank has room for all particles, because those of the others may all die. Unused room takes no memory.
template <class T>
class SharedLife {
 public:
  SharedLife(const SceneFile& file, Layout layout, Ranks& ranks);
  SharedLife(const SharedLife&) = delete;
  SharedLife& operator=(const SharedLife&) = delete;

  // For the plan's options. `ranks` must outlive the plan.
  [[nodiscard]] static SharedBirths births(Ranks& ranks) noexcept;

  // This rank's own particles.
  [[nodiscard]] LiveState<T>& live() noexcept { return columns_.live(); }

  // Each particle's id moves along with it from now on.
  void carry_ids();

  // deal() deals the particles in the ranges out to the ranks, one to each in turn. to_range() cuts the particles of all ranks
  // into ranges, in the order in which one rank would keep them. All ranks must call them.
  void deal(LiveMemory<T>& range);
  void to_range(LiveMemory<T>& range);
  // Takes back the ids given to the particles in the ranges since to_range(). All ranks must call it.
  void take_ids(LiveMemory<T>& range);

  // Returns the number of births before each particle that this rank has now. Valid until the next call.
  [[nodiscard]] std::span<const std::int64_t> kept_numbers();

 private:
  [[nodiscard]] std::span<std::int64_t> numbers() noexcept { return {numbers_.get(), live().state.count}; }
  [[nodiscard]] std::span<std::uint32_t> ids() noexcept { return {ids_->get(), live().state.count}; }

  Ranks& ranks_;
  std::size_t room_;
  LiveColumns<T> columns_;
  AlignedArray<std::int64_t> numbers_;  // of each own particle; those of the start or of a checkpoint precede later births
  std::optional<AlignedArray<std::uint32_t>> ids_;
  std::array<Carried, 2> carried_;
  std::optional<RangeExchange> exchange_;  // the one that made the ranges, kept if ids go back
  std::vector<std::int64_t> kept_numbers_;
};

extern template class SharedLife<float>;
extern template class SharedLife<double>;

}  // namespace dvdx::tool
