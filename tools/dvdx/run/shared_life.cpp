#include "run/shared_life.hpp"

#include <algorithm>

namespace dvdx::tool {
namespace {

std::uint64_t count_all(void* context, std::uint64_t here) noexcept {
  static_cast<Ranks*>(context)->sum(std::span(&here, 1));
  return here;
}

// Returns the indices of the particles that this rank gets if `all` are dealt out in turn.
std::vector<std::uint32_t> dealt_to(const Ranks& ranks, std::size_t all) {
  std::vector<std::uint32_t> places;
  for (auto place = static_cast<std::size_t>(ranks.rank()); place < all; place += static_cast<std::size_t>(ranks.count())) {
    places.push_back(static_cast<std::uint32_t>(place));
  }
  return places;
}

}  // namespace

template <class T>
SharedLife<T>::SharedLife(const SceneFile& file, Layout layout, Ranks& ranks)
    : ranks_(ranks),
      room_(file.turnover.capacity),
      columns_(room_, layout),
      numbers_(untouched_array<std::int64_t>(room_)),
      carried_{
          {{.base = numbers_.get(), .stride = sizeof(std::int64_t), .bytes = sizeof(std::int64_t), .at_birth = AtBirth::number},
           {}}} {
  live().carried = std::span(carried_).first(1);
}

template <class T>
SharedBirths SharedLife<T>::births(Ranks& ranks) noexcept {
  return {.part = static_cast<std::uint32_t>(ranks.rank()),
          .parts = static_cast<std::uint32_t>(ranks.count()),
          .context = &ranks,
          .count_all = count_all};
}

template <class T>
void SharedLife<T>::carry_ids() {
  ids_ = untouched_array<std::uint32_t>(room_);
  const auto own = ids();
  std::fill(own.begin(), own.end(), 0U);
  carried_[1] = {.base = ids_->get(), .stride = sizeof(std::uint32_t), .bytes = sizeof(std::uint32_t)};
  live().carried = carried_;
}

template <class T>
void SharedLife<T>::deal(LiveMemory<T>& range) {
  LiveState<T>& mine = live();
  const LiveState<T>& from = range.live();
  const std::size_t all = range.all();
  const auto places = dealt_to(ranks_, all);
  RangeExchange exchange(ranks_, all, places);
  mine.state.count = places.size();
  const auto in = columns_of(from), out = columns_of(mine);
  for (std::size_t k = 0; k < in.size(); ++k) exchange.from_ranges(in[k], out[k]);
  if (ids_) exchange.from_ranges(range.ids(), ids());
  mine.state.clock = from.state.clock;
  mine.born = from.born;
  mine.dropped = from.dropped;
  mine.removed = ranks_.rank() == 0 ? from.removed : 0;                                      // of all ranks
  const auto first = static_cast<std::int64_t>(from.born) - static_cast<std::int64_t>(all);  // all below the next birth's
  std::transform(places.begin(), places.end(), numbers().begin(),
                 [first](std::uint32_t place) { return first + static_cast<std::int64_t>(place); });
}

template <class T>
void SharedLife<T>::to_range(LiveMemory<T>& range) {
  exchange_.emplace(RangeExchange::in_order(ranks_, numbers()));
  LiveState<T>& to = range.live();
  range.set_counts(share_of(ranks_).of(exchange_->all()).count, exchange_->all());
  const auto in = columns_of(live()), out = columns_of(to);
  for (std::size_t k = 0; k < in.size(); ++k) exchange_->to_ranges(in[k], out[k]);
  if (ids_) exchange_->to_ranges(ids(), range.ids());
  to.state.clock = live().state.clock;
  to.born = live().born;
  to.dropped = live().dropped;
  to.removed = live().removed;
  ranks_.sum(std::span(&to.removed, 1));
  if (!ids_) exchange_.reset();
}

template <class T>
void SharedLife<T>::take_ids(LiveMemory<T>& range) {
  exchange_->from_ranges(range.ids(), ids());
}

template <class T>
std::span<const std::int64_t> SharedLife<T>::kept_numbers() {
  const auto own = numbers();
  kept_numbers_.assign(own.begin(), own.end());
  return kept_numbers_;
}

template class SharedLife<float>;
template class SharedLife<double>;

}  // namespace dvdx::tool
