// Particles that come and go: the same bits for every instruction set, layout, thread count and batching.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "dvdx/live.hpp"
#include "kernel/living.hpp"
#include "support/batch.hpp"
#include "work/tasks.hpp"

namespace living::bits_test {

// All numbers after 24 steps, in calls of `call` steps.
template <class T>
std::string after(Isa isa, Layout layout, std::size_t capacity, std::size_t call, SurvivorOrder order, double rate) {
  Living<T> living(layout, capacity);
  living.fill(capacity * 2 / 3);
  if (capacity > 20) living.live.state.v[1][17] = std::numeric_limits<T>::quiet_NaN();
  const auto plan = make<T>(fountain(), everything(capacity, rate, order), isa);
  for (std::size_t done = 0; done < 24; done += call) step_all(plan, living.live, std::min(call, 24 - done));
  CHECK(living.is_clean());
  return living.bytes();
}

TEST_CASE_TEMPLATE("same bits on every ISA, in every layout and in every batch of steps", T, float, double) {
  for (const SurvivorOrder order : orders) {
    for (const std::size_t capacity : {std::size_t{1}, std::size_t{40}, std::size_t{333}}) {
      const double rate = 4.0 * static_cast<double>(capacity);
      const std::string wanted = after<T>(Isa::reference, Layout::soa, capacity, 1, order, rate);
      constexpr std::array<std::size_t, 3> calls = {1, 5, 24};
      std::size_t turn = capacity;  // each ISA and each layout meets every call
      for (const Isa isa : available_isas()) {
        for (const Layout layout : test::layouts) {
          const std::size_t call = calls[turn++ % calls.size()];
          CAPTURE(name(isa));
          CAPTURE(test::name(layout));
          CAPTURE(call);
          CHECK(after<T>(isa, layout, capacity, call, order, rate) == wanted);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("same bits on any number of threads" * doctest::test_suite("threads"), T, float, double) {
  // Threads pay off from these counts on: in calls of 4, and without order at each step.
  constexpr std::size_t in_fours = steps_worth_threads / 4 + 700, each = steps_worth_threads + 700;
  const auto check = [](const Lifecycle& turnover, std::size_t count, std::size_t steps) {
    const auto bytes = [&](Layout layout, std::size_t call, std::size_t threads) {
      Living<T> living(layout, turnover.capacity);
      living.fill(count);
      const auto plan = make<T>(fountain(), turnover, best_isa());
      for (std::size_t done = 0; done < steps; done += call) step_all(plan, living.live, call, threads);
      CHECK(living.live.removed > 500);
      CHECK(living.live.born > 10000);
      return living.bytes();
    };
    const std::string wanted = bytes(Layout::soa, 1, 1);
    CHECK(bytes(Layout::soa, steps, 3) == wanted);
    CHECK(bytes(Layout::aosoa16, 4, 2) == wanted);
    CHECK(bytes(Layout::aos, 4, 5) == wanted);
  };
  const Lifecycle ordered = everything(in_fours * 2 + 3, 120'000);
  check({.emitters = ordered.emitters, .removal = {}, .capacity = ordered.capacity}, in_fours, 8);
  check(ordered, in_fours, 8);
  Lifecycle unordered = everything(each + 20'003, 160'000, SurvivorOrder::any);
  unordered.emitters[1].start = 0;
  check(unordered, each, 4);
}

TEST_CASE("three of four particles removed at once exceed the spill, and two threads give the bits of one") {
  constexpr std::size_t capacity = steps_worth_threads + 4;
  const auto bytes = [&](std::size_t threads) {
    Living<float> living(Layout::soa, capacity);
    living.fill(capacity);
    for (std::size_t i = 0; i < capacity; ++i) living.live.lifetime[i] = i % 4 == 3 ? 1.0F : 0.001F;
    const auto plan = make<float>(fountain(), {.emitters = {}, .removal = {}, .capacity = capacity});
    step_all(plan, living.live, 1, threads);
    CHECK(living.live.state.count == capacity / 4);
    CHECK(living.id(5) == 4 * 5 + 4);
    CHECK(living.mark(5) == std::array{char{23}, char{3}, 'x'});
    return living.bytes();
  };
  CHECK(bytes(2) == bytes(1));
}

}  // namespace living::bits_test
