#include "ranks/meetings_exchange.hpp"

#include <chrono>
#include <span>
#include <utility>

namespace dvdx::tool {

MeetingsExchange::MeetingsExchange(Ranks& ranks, const Scene& whole, std::vector<Vec3> start, const Part& part)
    : ranks_(ranks), whole_(whole), part_(part), start_(std::move(start)), first_{0} {
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(ranks.count()));
  counts[static_cast<std::size_t>(ranks.rank())] = part.own;
  ranks.sum(counts);
  for (const std::uint64_t count : counts) first_.push_back(first_.back() + count);
  sent_.resize(first_.back());
  std::size_t next = first_[static_cast<std::size_t>(ranks.rank())];
  for (std::size_t k = 0; k < part.particles.size(); ++k) {
    if (part.is_own[k] != 0) sent_[next++] = part.particles[k];
  }
  for (int rank = 0; rank < ranks.count(); ++rank) {
    const auto r = static_cast<std::size_t>(rank);
    if (counts[r] == 0) continue;
    ranks.broadcast(rank, std::as_writable_bytes(std::span(sent_).subspan(first_[r], counts[r])));
  }
}

SharedMeetings MeetingsExchange::shared() noexcept {
  return {.whole = &whole_,
          .start = start_,
          .numbers = part_.particles,
          .told = sent_,
          .first = first_[static_cast<std::size_t>(ranks_.rank())],
          .context = this,
          .tell = send};
}

// A rank without particles neither sends nor receives.
void MeetingsExchange::send(void* context, std::byte* records, std::size_t each) noexcept {
  auto& self = *static_cast<MeetingsExchange*>(context);
  const auto of = [&](int rank) {
    const auto r = static_cast<std::size_t>(rank);
    return std::span(records + self.first_[r] * each, (self.first_[r + 1] - self.first_[r]) * each);
  };
  const std::span<std::byte> own = of(self.ranks_.rank());
  const auto over_others = [&](const auto& use) {
    for (int rank = 0; rank < self.ranks_.count(); ++rank) {
      if (rank != self.ranks_.rank() && !of(rank).empty()) use(rank);
    }
  };
  over_others([&](int rank) { self.ranks_.start_receive(rank, of(rank)); });
  over_others([&](int rank) { self.ranks_.start_send(rank, own); });
  const auto before = std::chrono::steady_clock::now();
  self.ranks_.finish();
  self.waited_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

}  // namespace dvdx::tool
