// Removals: at birth, of non-finite particles, and of those that the caller marked.
#include <doctest/doctest.h>

#include <limits>

#include "dvdx/live.hpp"
#include "kernel/living.hpp"
#include "support/batch.hpp"
#include "work/tasks.hpp"

namespace living::removal_test {

// The particles move 2 m a step towards the box: one step after its birth, each would be inside.
TEST_CASE("a particle born outside goes at its birth, in a call of many steps as in calls of one") {
  for (const SurvivorOrder order : orders) {
    const Lifecycle turnover{.emitters = {{.shape = Vec3{2, 0, 0}, .rate = 64, .velocity = {-128, 0, 0}}},
                             .removal = {.outside = Box{.min = {-1, -1, -1}, .max = {1, 1, 1}}, .order = order},
                             .capacity = 20};
    const auto plan = make<double>({}, turnover);
    for (const std::size_t each : {1U, 10U}) {
      Living<double> living(Layout::soa, 20);
      for (std::size_t done = 0; done < 10; done += each) step_all(plan, living.live, each);
      CHECK(living.live.born == 10);
      CHECK(living.live.removed == 10);
      CHECK(living.live.state.count == 0);
    }
  }
}

TEST_CASE("particles that are not finite stay unless they are to be removed, and others are as they were") {
  for (const auto treatment : {NotFinite::kept, NotFinite::removed}) {
    const auto plan = make<float>({}, {.emitters = {}, .removal = {.not_finite = treatment}, .capacity = 50});
    Living<float> living(Layout::soa, 50);
    living.fill(50);
    for (std::size_t i = 0; i < 50; ++i) living.live.lifetime[i] = std::numeric_limits<float>::infinity();
    living.live.state.x[2][7] = std::numeric_limits<float>::quiet_NaN();
    living.live.state.v[0][31] = std::numeric_limits<float>::infinity();
    living.live.age[40] = std::numeric_limits<float>::quiet_NaN();
    step_all(plan, living.live, 1);
    CHECK(living.live.state.count == (treatment == NotFinite::kept ? 50 : 48));
    CHECK(living.id(6) == 7);
    CHECK(living.id(treatment == NotFinite::kept ? 49 : 47) == 50);
  }
}

TEST_CASE("remove() takes away the particles that the caller marked, and steps nothing") {
  const auto plan = make<float>(fountain(), {.emitters = {jet(100, 1)}, .removal = {}, .capacity = 40});
  Living<float> living(Layout::aos, 40);
  living.fill(40);
  living.live.age[0] = living.live.age[39] = std::numeric_limits<float>::infinity();
  const float x = living.live.state.x[1][1];
  REQUIRE(plan.remove(living.live) == StepResult::done);
  CHECK(living.live.state.count == 38);
  CHECK(living.live.removed == 2);
  CHECK(living.id(0) == 2);
  CHECK(living.live.state.x[1][0] == x);
  CHECK(living.live.state.clock.seconds == 0);
}

TEST_CASE("one removal moves every later particle up by one, to the far end, on any number of threads" *
          doctest::test_suite("threads")) {
  constexpr std::size_t capacity = steps_worth_threads + 1000;
  const auto plan = make<float>({}, {.emitters = {}, .removal = {}, .capacity = capacity});
  for (const std::size_t threads : {std::size_t{1}, std::size_t{3}}) {
    Living<float> living(Layout::soa, capacity);
    living.fill(capacity);
    for (std::size_t i = 0; i < capacity; ++i) living.live.lifetime[i] = std::numeric_limits<float>::infinity();
    living.live.lifetime[2] = 0;
    step_all(plan, living.live, 1, threads);
    REQUIRE(living.live.state.count == capacity - 1);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < capacity - 1; ++i) {
      const std::size_t was = i < 2 ? i : i + 1;
      const bool is_right = living.id(i) == was + 1 && living.mark(i)[1] == static_cast<char>(was / 7) &&
                            living.live.state.x[1][i] == start<float>(was, 1);
      wrong += is_right ? 0U : 1U;
    }
    CHECK(wrong == 0);
  }
}

}  // namespace living::removal_test
