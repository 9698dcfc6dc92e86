// Births: their times, places and numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dvdx/live.hpp"
#include "kernel/living.hpp"
#include "lifecycle/compiled_lifecycle.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace living::births_test {

using test::is_close;

TEST_CASE("without order, births and then the last particles fill the holes; births that may lack room come last") {
  struct Case {
    std::size_t capacity;
    std::array<std::uint32_t, 7> wanted;  // a birth has no number
  };
  for (const auto& [capacity, wanted] : {Case{10, {1, 0, 9, 4, 5, 6, 7}}, Case{9, {1, 7, 9, 4, 5, 6, 0}}}) {
    const auto plan =
        make<double>({}, {.emitters = {{.rate = 64}}, .removal = {.order = SurvivorOrder::any}, .capacity = capacity});
    Living<double> living(Layout::soa, capacity);
    living.fill(9);
    for (const std::size_t i : {1U, 2U, 7U}) living.live.age[i] = std::numeric_limits<double>::infinity();
    step_all(plan, living.live, 1);
    REQUIRE(living.live.state.count == 7);
    for (std::size_t i = 0; i < wanted.size(); ++i) CHECK(living.id(i) == wanted[i]);
    CHECK(living.live.removed == 3);
    CHECK(living.live.born == 1);
  }
}

TEST_CASE("births are exact over long times, whatever the decimals of rate and step") {
  struct Case {
    double rate, step;
    std::uint64_t steps, births;
  };
  for (const auto& [rate, step, steps, births] :
       {Case{60, 1.0 / 60, 1'000'000, 1'000'000}, Case{0.1, 0.001, 30'000'000, 3'000}, Case{1.0 / 3, 0.1, 3'000'000, 100'000},
        Case{1e6, 0.01, 777, 7'770'000}, Case{0, 0.01, 1000, 0}, Case{7, 1.0 / 60, 3600, 420}}) {
    Clock clock;
    clock.advance(step, static_cast<double>(steps));
    CHECK(births_until({.rate = rate}, clock).whole == births);
    Clock before;
    before.advance(step, static_cast<double>(steps) - 1);
    CHECK((rate == 0 || births_until({.rate = rate}, before).whole < births));
  }
}

TEST_CASE("an emitter works from its start to its end") {
  const Emitter emitter{.rate = 10, .start = 1, .end = 2.55};
  const auto by = [&](double seconds) { return births_until(emitter, {.seconds = seconds, .carry = 0}).whole; };
  CHECK(by(0) == 0);
  CHECK(by(1) == 0);
  CHECK(by(1.1) == 1);
  CHECK(by(2.5) == 15);
  CHECK(by(1e9) == 15);
  const Emitter burst{.rate = 160'000, .start = 1.2, .end = 1.25};  // the difference is not the one that the decimals suggest
  CHECK(births_until(burst, {.seconds = 2, .carry = 0}).whole == 8000);
}

// Times and rates are accurate to a relative 2^-50: sums of that size are correct only to their last bit.
TEST_CASE("a birth counts at a time that is early by less than one part in 2^50, and not at an earlier one") {
  const Emitter emitter{.rate = 1};
  const auto by = [&](double seconds) { return births_until(emitter, {.seconds = seconds, .carry = 0}).whole; };
  for (const double number : {1.0, 2.0, 1024.0}) {  // (1 - 2^-50) (1 + 2^-50) = 1 - 2^-100 is below 1
    const double early = number * (1 - 0x1p-50);
    CHECK(by(early) == static_cast<std::uint64_t>(number) - 1);
    CHECK(by(std::nextafter(early, 2 * number)) == static_cast<std::uint64_t>(number));
  }
}

TEST_CASE("a birth lies in its disc, and has a lifetime between the least and the most") {
  Emitter emitter = jet(64000, 5);
  emitter.shape = Disc{.center = {1, 2, 3}, .normal = {0, 1, 0}, .radius = 0.05};
  emitter.velocity = {};
  emitter.spread = 0.0;
  emitter.least_lifetime = 2;
  emitter.most_lifetime = 2.5;
  const auto plan = make<double>({}, {.emitters = {emitter}, .removal = {}, .capacity = 1000});
  Living<double> living(Layout::soa, 1000);
  step_all(plan, living.live, 1);
  REQUIRE(living.live.state.count == 1000);
  double most_x = 0, most_z = 0, shortest = 9, longest = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    const double dx = living.live.state.x[0][i] - 1, dz = living.live.state.x[2][i] - 3;
    CHECK(living.live.state.x[1][i] == 2);
    CHECK(dx * dx + dz * dz <= 0.0025 * (1 + 1e-12));
    most_x = std::max(most_x, std::abs(dx));
    most_z = std::max(most_z, std::abs(dz));
    shortest = std::min(shortest, living.live.lifetime[i]);
    longest = std::max(longest, living.live.lifetime[i]);
  }
  CHECK(most_x > 0.045);
  CHECK(most_z > 0.045);
  CHECK(shortest >= 2);
  CHECK(shortest < 2.05);
  CHECK(longest > 2.45);
  CHECK(longest <= 2.5);
}

TEST_CASE("a full state drops births and counts them") {
  const auto plan = make<float>({}, {.emitters = {{.rate = 640, .seed = 3}}, .removal = {}, .capacity = 25});
  Living<float> living(Layout::soa, 25);
  step_all(plan, living.live, 10);
  CHECK(living.live.state.count == 25);
  CHECK(living.live.born == 25);
  CHECK(living.live.dropped == 75);
}

TEST_CASE("births within a step stand as far apart as the time between them") {
  const auto plan = make<double>({}, {.emitters = {{.rate = 256, .velocity = {2, 0, 0}}}, .removal = {}, .capacity = 100});
  Living<double> living(Layout::soa, 100);
  step_all(plan, living.live, 5);
  REQUIRE(living.live.state.count == 20);
  for (std::size_t i = 0; i < 20; ++i) {
    const double age = (19 - static_cast<double>(i)) / 256;
    CHECK(is_close(living.live.age[i], age, 1e-12));
    CHECK(is_close(living.live.state.x[0][i], 2 * age, 1e-12));
  }
}

}  // namespace living::births_test
