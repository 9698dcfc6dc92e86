// Facts that several ranks find out together.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "dvdx/ranks.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {

// A fault that all ranks have learned of: rank 0 has the message, for the others there is nothing to say.
class SharedFault final : public Fault {
 public:
  using Fault::Fault;
};

// The fault of this rank, if it has one.
struct Trouble {
  Exit exit;
  std::string message;
};

// Throws SharedFault on all ranks where one of them, or more, has trouble: the lowest one's. To be called by all.
void share_trouble(Ranks& ranks, const std::optional<Trouble>& mine);

// The fault, bad allocation or other exception that `work` ends by.
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

// Until all have come here: a launcher ends every rank as soon as one has failed, which must not be before the first has said
// why.
void wait_for_all(Ranks& ranks);

// Each rank does its part of `work`, in which it waits for no other one; then all go on, or none.
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

// The same where there may be no ranks at all.
template <class Work>
auto together(Ranks* ranks, const Work& work) {
  return ranks == nullptr ? work() : together(*ranks, work);
}

// From rank to rank: each makes of what the one before has left what it leaves to the next. All of them get the last one's.
template <class Value, class Work>
[[nodiscard]] Value in_turn(Ranks& ranks, Value value, const Work& work) {
  static_assert(std::is_trivially_copyable_v<Value>);
  if (ranks.rank() > 0) ranks.receive(ranks.rank() - 1, writable_bytes_in(value));
  value = work(value);
  if (ranks.rank() + 1 < ranks.count()) ranks.send(ranks.rank() + 1, bytes_in(value));
  ranks.broadcast(ranks.count() - 1, writable_bytes_in(value));
  return value;
}

// The same where there may be no ranks at all.
template <class Value, class Work>
[[nodiscard]] Value in_turn(Ranks* ranks, Value value, const Work& work) {
  return ranks == nullptr ? work(value) : in_turn(*ranks, value, work);
}

}  // namespace dvdx::tool
