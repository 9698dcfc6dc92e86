#include "ranks/agree.hpp"

#include <algorithm>
#include <span>

namespace dvdx::tool {

void wait_for_all(Ranks& ranks) {
  double nothing = 0;
  ranks.highest(std::span(&nothing, 1));
}

void share_trouble(Ranks& ranks, const std::optional<Trouble>& mine) {
  // The lowest rank in trouble has the highest count - rank.
  double first = mine ? ranks.count() - ranks.rank() : 0;
  ranks.highest(std::span(&first, 1));
  if (first == 0) return;
  const int from = ranks.count() - static_cast<int>(first);
  struct Head {
    Exit exit = Exit::done;
    std::uint64_t size = 0;
  };
  std::string message = mine ? mine->message : std::string();
  Head head;
  if (ranks.rank() == from) head = {mine->exit, message.size()};
  ranks.broadcast(from, writable_bytes_in(head));
  message.resize(head.size);
  ranks.broadcast(from, std::as_writable_bytes(std::span(message)));
  throw SharedFault(head.exit, ranks.rank() == 0 ? message : std::string());
}

}  // namespace dvdx::tool
