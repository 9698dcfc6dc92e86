#include "ranks/range_exchange.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace dvdx::tool {
namespace {

// Calls use(other) for every rank, this one included. In each round ranks pair up and exchange only within their pair, so no
// rank waits for one that waits for it.
template <class Use>
void meet_all(const Ranks& ranks, const Use& use) {
  const int count = ranks.count();
  for (int round = 0; round < count; ++round) use((round - ranks.rank() + count) % count);
}

void swap(Ranks& ranks, int other, std::span<const std::byte> sent, std::span<std::byte> received) {
  if (other == ranks.rank()) {
    if (!sent.empty()) std::memcpy(received.data(), sent.data(), sent.size());
  } else if (ranks.rank() < other) {
    ranks.send(other, sent);
    ranks.receive(other, received);
  } else {
    ranks.receive(other, received);
    ranks.send(other, sent);
  }
}

std::size_t rank_with(std::size_t number, std::size_t all, std::size_t ranks) {
  const std::size_t each = all / ranks, longer = all % ranks;  // the first ranks' ranges have one more
  const std::size_t of_longer = longer * (each + 1);
  return number < of_longer ? number / (each + 1) : longer + (number - of_longer) / each;
}

// Returns how many of the ascending numbers are less than `limit`.
std::size_t below(std::span<const std::int64_t> numbers, std::int64_t limit) {
  return static_cast<std::size_t>(std::lower_bound(numbers.begin(), numbers.end(), limit) - numbers.begin());
}

// Returns the number at which each rank's range begins if all ranks' numbers, each held by one rank, are cut into ranges. Found
// by bisection: each rank counts its own numbers below the middle.
std::vector<std::int64_t> starts_of_ranges(Ranks& ranks, std::span<const std::int64_t> numbers, std::size_t all) {
  const auto count = static_cast<std::size_t>(ranks.count());
  if (all == 0) return std::vector<std::int64_t>(count);
  constexpr double none = -std::numeric_limits<double>::infinity();
  std::array<double, 2> ends{none, none};  // exact: below 2^53
  if (!numbers.empty()) ends = {static_cast<double>(numbers.back()), -static_cast<double>(numbers.front())};
  ranks.highest(ends);
  std::vector<std::int64_t> low(count, -static_cast<std::int64_t>(ends[1]));
  std::vector<std::int64_t> high(count, static_cast<std::int64_t>(ends[0]) + 1);
  std::vector<std::uint64_t> before(count);
  while (low != high) {
    for (std::size_t rank = 0; rank < count; ++rank) before[rank] = below(numbers, std::midpoint(low[rank], high[rank]));
    ranks.sum(before);
    for (std::size_t rank = 0; rank < count; ++rank) {
      const std::int64_t middle = std::midpoint(low[rank], high[rank]);
      if (before[rank] >= RankShare{.rank = rank, .ranks = count}.of(all).first) {
        high[rank] = middle;
      } else {
        low[rank] = middle + 1;
      }
    }
  }
  return low;
}

// Returns the index of each list's numbers among those of all lists. Each list is ascending.
std::vector<std::vector<std::uint32_t>> places_among_all(const std::vector<std::vector<std::int64_t>>& lists) {
  using Next = std::pair<std::int64_t, std::size_t>;  // a number, and its list
  std::priority_queue<Next, std::vector<Next>, std::greater<>> next;
  std::vector<std::vector<std::uint32_t>> places(lists.size());
  for (std::size_t n = 0; n < lists.size(); ++n) {
    places[n].reserve(lists[n].size());
    if (!lists[n].empty()) next.emplace(lists[n].front(), n);
  }
  for (std::uint32_t place = 0; !next.empty(); ++place) {
    const std::size_t n = next.top().second;
    next.pop();
    places[n].push_back(place);
    if (places[n].size() < lists[n].size()) next.emplace(lists[n][places[n].size()], n);
  }
  return places;
}

// Returns columns by their axes.
template <class T>
std::vector<const std::array<Column<T>, 3>*> vectors_of(const State<T>& state) {
  if (!state.has_rests()) return {&state.x, &state.v};
  return {&state.x, &state.v, &state.x_rest, &state.v_rest};
}

}  // namespace

RangeExchange::RangeExchange(Ranks& ranks, std::size_t all)
    : ranks_(&ranks), all_(all), asked_(static_cast<std::size_t>(ranks.count())), given_(asked_.size()) {}

RangeExchange::RangeExchange(Ranks& ranks, std::size_t all, std::span<const std::uint32_t> numbers,
                             std::span<const std::uint32_t> places)
    : RangeExchange(ranks, all) {
  Lists wanted(asked_.size());  // places in others' ranges
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const std::size_t rank = rank_with(numbers[k], all, wanted.size());
    const std::size_t first = RankShare{.rank = rank, .ranks = wanted.size()}.of(all).first;
    wanted[rank].push_back(static_cast<std::uint32_t>(numbers[k] - first));
    asked_[rank].push_back(places.empty() ? static_cast<std::uint32_t>(k) : places[k]);
  }
  meet_all(ranks, [&](int other) {
    const auto& list = wanted[static_cast<std::size_t>(other)];
    auto& given = given_[static_cast<std::size_t>(other)];
    const std::uint64_t sent = list.size();
    std::uint64_t received = 0;
    swap(ranks, other, bytes_in(sent), writable_bytes_in(received));
    given.resize(received);
    swap(ranks, other, std::as_bytes(std::span(list)), std::as_writable_bytes(std::span(given)));
  });
}

RangeExchange RangeExchange::in_order(Ranks& ranks, std::span<const std::int64_t> numbers) {
  std::uint64_t all = numbers.size();
  ranks.sum(std::span(&all, 1));
  RangeExchange exchange(ranks, all);
  const auto starts = starts_of_ranges(ranks, numbers, all);
  std::vector<std::vector<std::int64_t>> received(starts.size());
  meet_all(ranks, [&](int other) {
    const auto rank = static_cast<std::size_t>(other);
    const std::size_t first = below(numbers, starts[rank]);
    const std::size_t end = rank + 1 < starts.size() ? below(numbers, starts[rank + 1]) : numbers.size();
    const std::uint64_t sent = end - first;
    std::uint64_t coming = 0;
    swap(ranks, other, bytes_in(sent), writable_bytes_in(coming));
    received[rank].resize(coming);
    swap(ranks, other, std::as_bytes(numbers.subspan(first, sent)), std::as_writable_bytes(std::span(received[rank])));
    exchange.asked_[rank].resize(sent);
    std::iota(exchange.asked_[rank].begin(), exchange.asked_[rank].end(), static_cast<std::uint32_t>(first));
  });
  exchange.given_ = places_among_all(received);
  return exchange;
}

template <class Number, class From, class To>
void RangeExchange::exchange(const From& from, const Lists& outgoing, const To& to, const Lists& incoming) {
  std::vector<Number> sent, received;
  meet_all(*ranks_, [&](int other) {
    const auto& out = outgoing[static_cast<std::size_t>(other)];
    const auto& in = incoming[static_cast<std::size_t>(other)];
    sent.resize(out.size());
    received.resize(in.size());
    for (std::size_t k = 0; k < out.size(); ++k) sent[k] = from[out[k]];
    swap(*ranks_, other, std::as_bytes(std::span(sent)), std::as_writable_bytes(std::span(received)));
    for (std::size_t k = 0; k < in.size(); ++k) to[in[k]] = received[k];
  });
}

template <class T>
void RangeExchange::from_ranges(const Column<T>& range, const Column<T>& mine) {
  exchange<T>(range, given_, mine, asked_);
}

template <class T>
void RangeExchange::to_ranges(const Column<T>& mine, const Column<T>& range) {
  exchange<T>(mine, asked_, range, given_);
}

void RangeExchange::from_ranges(std::span<const std::uint32_t> range, std::span<std::uint32_t> mine) {
  exchange<std::uint32_t>(range, given_, mine, asked_);
}

void RangeExchange::to_ranges(std::span<const std::uint32_t> mine, std::span<std::uint32_t> range) {
  exchange<std::uint32_t>(mine, asked_, range, given_);
}

template <class T>
void RangeExchange::from_ranges(const State<T>& range, State<T>& mine) {
  mine.clock = range.clock;
  const auto from = vectors_of(range), to = vectors_of(mine);
  for (std::size_t n = 0; n < 3 * from.size(); ++n) from_ranges((*from[n / 3])[n % 3], (*to[n / 3])[n % 3]);
}

template <class T>
void RangeExchange::to_ranges(const State<T>& mine, State<T>& range) {
  range.clock = mine.clock;
  const auto from = vectors_of(mine), to = vectors_of(range);
  for (std::size_t n = 0; n < 3 * from.size(); ++n) to_ranges((*from[n / 3])[n % 3], (*to[n / 3])[n % 3]);
}

template void RangeExchange::from_ranges(const Column<float>&, const Column<float>&);
template void RangeExchange::from_ranges(const Column<double>&, const Column<double>&);
template void RangeExchange::to_ranges(const Column<float>&, const Column<float>&);
template void RangeExchange::to_ranges(const Column<double>&, const Column<double>&);
template void RangeExchange::from_ranges(const State<float>&, State<float>&);
template void RangeExchange::from_ranges(const State<double>&, State<double>&);
template void RangeExchange::to_ranges(const State<float>&, State<float>&);
template void RangeExchange::to_ranges(const State<double>&, State<double>&);

}  // namespace dvdx::tool
