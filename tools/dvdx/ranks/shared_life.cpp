#include "ranks/shared_life.hpp"

#include <array>
#include <numeric>

namespace dvdx::tool {
namespace {

constexpr std::size_t columns_each = 8;

template <class T>
std::array<Column<T>, columns_each> columns_of(const LiveState<T>& live) {
  const auto& x = live.state.x;
  const auto& v = live.state.v;
  return {x[0], x[1], x[2], v[0], v[1], v[2], live.age, live.lifetime};
}

struct Head {
  std::uint64_t count = 0, born = 0, dropped = 0;
  Clock clock{};
};

std::uint64_t count_all(void* context, std::uint64_t here) noexcept {
  static_cast<Ranks*>(context)->sum(std::span(&here, 1));
  return here;
}

// Of `all` particles that are dealt out in turn.
std::size_t dealt_to(std::size_t rank, std::size_t ranks, std::size_t all) {
  return all > rank ? (all - rank + ranks - 1) / ranks : 0;
}

// Column by column, of each particle the one at place(k).
template <class T, class Place>
void take(const LiveState<T>& from, std::size_t count, std::vector<T>& to, const Place& place) {
  to.clear();
  for (const Column<T>& column : columns_of(from)) {
    for (std::size_t k = 0; k < count; ++k) to.push_back(column[place(k)]);
  }
}
template <class T, class Place>
void put(const std::vector<T>& from, const LiveState<T>& to, std::size_t count, const Place& place) {
  const T* next = from.data();
  for (const Column<T>& column : columns_of(to)) {
    for (std::size_t k = 0; k < count; ++k) column[place(k)] = *next++;
  }
}

}  // namespace

template <class T>
SharedLife<T>::SharedLife(const SceneFile& file, Layout layout, Ranks& ranks)
    : ranks_(ranks),
      memory_(file.turnover.capacity, layout),
      numbers_(file.turnover.capacity),
      carried_{
          .base = numbers_.data(), .stride = sizeof(std::int64_t), .bytes = sizeof(std::int64_t), .at_birth = AtBirth::number} {
  live().carried = {&carried_, 1};
}

template <class T>
SharedBirths SharedLife<T>::births(Ranks& ranks) noexcept {
  return {.part = static_cast<std::uint32_t>(ranks.rank()),
          .parts = static_cast<std::uint32_t>(ranks.count()),
          .context = &ranks,
          .count_all = count_all};
}

template <class T>
void SharedLife<T>::deal(LiveMemory<T>& whole) {
  LiveState<T>& mine = live();
  const LiveState<T>& all = whole.live();
  Head head{.count = all.state.count, .born = all.born, .dropped = all.dropped, .clock = all.state.clock};
  ranks_.broadcast(0, writable_bytes_in(head));
  const auto ranks = static_cast<std::size_t>(ranks_.count()), here = static_cast<std::size_t>(ranks_.rank());
  for (std::size_t rank = ranks; here == 0 && rank-- > 0;) {  // its own last: they stay in the buffer
    take(all, dealt_to(rank, ranks, head.count), buffer_, [&](std::size_t k) { return rank + k * ranks; });
    if (rank > 0) ranks_.send(static_cast<int>(rank), std::as_bytes(std::span(buffer_)));
  }
  mine.state.count = dealt_to(here, ranks, head.count);
  buffer_.resize(columns_each * mine.state.count);
  if (here > 0) ranks_.receive(0, std::as_writable_bytes(std::span(buffer_)));
  put(buffer_, mine, mine.state.count, [](std::size_t k) { return k; });
  mine.state.clock = head.clock;
  mine.born = head.born;
  mine.dropped = head.dropped;
  mine.removed = all.removed;                                            // on the others nothing
  const auto first = static_cast<std::int64_t>(head.born - head.count);  // below that of the next birth
  const auto own = numbers(mine.state.count);
  for (std::size_t k = 0; k < own.size(); ++k) own[k] = first + static_cast<std::int64_t>(here + k * ranks);
  of_all_.resize(here == 0 ? head.count : 0);
  std::iota(of_all_.begin(), of_all_.end(), first);
}

template <class T>
std::span<const std::uint32_t> SharedLife<T>::places() {
  const auto own = numbers(live().state.count);
  std::vector<std::uint64_t> sizes(static_cast<std::size_t>(ranks_.count()), 0);
  sizes[static_cast<std::size_t>(ranks_.rank())] = own.size();
  ranks_.sum(sizes);
  places_.resize(own.size());
  std::iota(places_.begin(), places_.end(), 0U);
  for (int rank = 0; rank < ranks_.count(); ++rank) {
    const bool is_own = rank == ranks_.rank();
    if (!is_own) told_.resize(sizes[static_cast<std::size_t>(rank)]);
    ranks_.broadcast(rank, std::as_writable_bytes(is_own ? own : std::span(told_)));
    if (is_own) continue;
    std::uint32_t before = 0;
    for (std::size_t k = 0; k < own.size(); ++k) {
      while (before < told_.size() && told_[before] < own[k]) ++before;
      places_[k] += before;
    }
  }
  return places_;
}

template <class T>
void SharedLife<T>::send() {
  const std::uint64_t count = places_.size();
  ranks_.send(0, bytes_in(count));
  ranks_.send(0, std::as_bytes(std::span(places_)));
  ranks_.send(0, std::as_bytes(std::span(told_)));
  ranks_.send(0, std::as_bytes(std::span(buffer_)));
}

template <class T>
void SharedLife<T>::receive(int from) {
  std::uint64_t count = 0;
  ranks_.receive(from, writable_bytes_in(count));
  places_.resize(count);
  told_.resize(count);
  buffer_.resize(columns_each * count);
  ranks_.receive(from, std::as_writable_bytes(std::span(places_)));
  ranks_.receive(from, std::as_writable_bytes(std::span(told_)));
  ranks_.receive(from, std::as_writable_bytes(std::span(buffer_)));
}

template <class T>
void SharedLife<T>::gather(LiveMemory<T>& whole) {
  std::array<std::uint64_t, 2> sums{places().size(), live().removed};
  ranks_.sum(sums);
  const auto own = numbers(live().state.count);
  told_.assign(own.begin(), own.end());
  take(live(), own.size(), buffer_, [](std::size_t k) { return k; });
  if (ranks_.rank() != 0) return send();
  LiveState<T>& all = whole.live();
  all.state.count = sums[0];
  all.removed = sums[1];
  all.state.clock = live().state.clock;
  all.born = live().born;
  all.dropped = live().dropped;
  std::vector<std::int64_t> of_all(sums[0]);
  for (int rank = 0; rank < ranks_.count(); ++rank) {
    if (rank > 0) receive(rank);
    for (std::size_t k = 0; k < places_.size(); ++k) of_all[places_[k]] = told_[k];
    put(buffer_, all, places_.size(), [this](std::size_t k) { return places_[k]; });
  }
  whole.move_ids(of_all_, of_all);
  of_all_.swap(of_all);
}

template class SharedLife<float>;
template class SharedLife<double>;

}  // namespace dvdx::tool
