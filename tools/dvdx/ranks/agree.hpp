// Faults and values on which several ranks agree.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "dvdx/ranks.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {

// A fault that all ranks have learned of. Rank 0 has the message; those of the others are empty.
class SharedFault final : public Fault {
 public:
  using Fault::Fault;
};

// The fault of this rank, if it has one.
struct Trouble {
  Exit exit;
  std::string message;
};

// Throws SharedFault on all ranks if any has trouble: that of the lowest such rank. All ranks must call it.
void share_trouble(Ranks& ranks, const std::optional<Trouble>& mine);

// Returns the fault, bad allocation or other exception that ends `work`, or none.
template <class Work>
[[nodiscard]] std::optional<Trouble> trouble_of(const Work& work) {
  try {
    work();
  } catch (const Fault& fault) {
    return Trouble{fault.exit(), fault.what()};
  } catch (const std::bad_alloc&) {
    return Trouble{Exit::input_output, "there is not enough memory"};
  } catch (const std::exception& error) {
    return Trouble{Exit::input_output, error.what()};
  }
  return std::nullopt;
}

// Returns when all ranks have called it. A launcher ends every rank as soon as one has failed, which must not be before the
// first rank has printed why.
void wait_for_all(Ranks& ranks);

// Runs `work` on each rank, which must not wait for another rank in it. Then all ranks continue, or all throw.
template <class Work>
auto together(Ranks& ranks, const Work& work) {
  if (ranks.count() == 1) return work();
  using Result = decltype(work());
  if constexpr (std::is_void_v<Result>) {
    share_trouble(ranks, trouble_of(work));
  } else {
    std::optional<Result> result;
    share_trouble(ranks, trouble_of([&] { result.emplace(work()); }));
    return std::move(*result);
  }
}

// The same; null means one process without ranks.
template <class Work>
auto together(Ranks* ranks, const Work& work) {
  return ranks == nullptr ? work() : together(*ranks, work);
}

// Passes a value from rank to rank: each makes its own from that of the rank before it. All ranks get the last one's.
template <class Value, class Work>
[[nodiscard]] Value in_turn(Ranks& ranks, Value value, const Work& work) {
  static_assert(std::is_trivially_copyable_v<Value>);
  if (ranks.rank() > 0) ranks.receive(ranks.rank() - 1, writable_bytes_in(value));
  value = work(value);
  if (ranks.rank() + 1 < ranks.count()) ranks.send(ranks.rank() + 1, bytes_in(value));
  ranks.broadcast(ranks.count() - 1, writable_bytes_in(value));
  return value;
}

// The same; null means one process without ranks.
template <class Value, class Work>
[[nodiscard]] Value in_turn(Ranks* ranks, Value value, const Work& work) {
  return ranks == nullptr ? work(value) : in_turn(*ranks, value, work);
}

}  // namespace dvdx::tool
