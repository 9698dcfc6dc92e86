#include "ranks/range_exchange.hpp"

#include <array>
#include <cstring>

namespace dvdx::tool {
namespace {

// Calls use(other) for every rank, its own among them, so that in each round two meet: whoever comes first to a round waits for
// nobody who waits for it.
template <class Use>
void meet_all(const Ranks& ranks, const Use& use) {
  const int count = ranks.count();
  for (int round = 0; round < count; ++round) use((round - ranks.rank() + count) % count);
}

void swap(Ranks& ranks, int other, std::span<const std::byte> told, std::span<std::byte> heard) {
  if (other == ranks.rank()) {
    if (!told.empty()) std::memcpy(heard.data(), told.data(), told.size());
  } else if (ranks.rank() < other) {
    ranks.send(other, told);
    ranks.receive(other, heard);
  } else {
    ranks.receive(other, heard);
    ranks.send(other, told);
  }
}

std::size_t rank_with(std::size_t number, std::size_t all, std::size_t ranks) {
  const std::size_t each = all / ranks, longer = all % ranks;  // the first ranks' ranges have one more
  const std::size_t of_longer = longer * (each + 1);
  return number < of_longer ? number / (each + 1) : longer + (number - of_longer) / each;
}

// x, y, z of each.
template <class T>
std::vector<const std::array<Column<T>, 3>*> vectors_of(const State<T>& state) {
  if (!state.has_rests()) return {&state.x, &state.v};
  return {&state.x, &state.v, &state.x_rest, &state.v_rest};
}

}  // namespace

RangeExchange::RangeExchange(Ranks& ranks, std::size_t all, std::span<const std::uint32_t> numbers,
                             std::span<const std::uint32_t> places)
    : ranks_(&ranks), asked_(static_cast<std::size_t>(ranks.count())), given_(asked_.size()) {
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
    const std::uint64_t told = list.size();
    std::uint64_t heard = 0;
    swap(ranks, other, bytes_in(told), writable_bytes_in(heard));
    given.resize(heard);
    swap(ranks, other, std::as_bytes(std::span(list)), std::as_writable_bytes(std::span(given)));
  });
}

template <class T>
void RangeExchange::tell(const Column<T>& from, const Lists& told, const Column<T>& to, const Lists& heard) {
  std::vector<T> sent, received;
  meet_all(*ranks_, [&](int other) {
    const auto& out = told[static_cast<std::size_t>(other)];
    const auto& in = heard[static_cast<std::size_t>(other)];
    sent.resize(out.size());
    received.resize(in.size());
    for (std::size_t k = 0; k < out.size(); ++k) sent[k] = from[out[k]];
    swap(*ranks_, other, std::as_bytes(std::span(sent)), std::as_writable_bytes(std::span(received)));
    for (std::size_t k = 0; k < in.size(); ++k) to[in[k]] = received[k];
  });
}

template <class T>
void RangeExchange::from_ranges(const Column<T>& range, const Column<T>& mine) {
  tell(range, given_, mine, asked_);
}

template <class T>
void RangeExchange::to_ranges(const Column<T>& mine, const Column<T>& range) {
  tell(mine, asked_, range, given_);
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
template void RangeExchange::to_ranges(const Column<double>&, const Column<double>&);
template void RangeExchange::from_ranges(const State<float>&, State<float>&);
template void RangeExchange::from_ranges(const State<double>&, State<double>&);
template void RangeExchange::to_ranges(const State<float>&, State<float>&);
template void RangeExchange::to_ranges(const State<double>&, State<double>&);

}  // namespace dvdx::tool
