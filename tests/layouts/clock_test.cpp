// The clock holds what a double cannot.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "dvdx/layouts/state.hpp"
#include "support/close.hpp"

using dvdx::test::is_close;

TEST_CASE("a clock of a million small steps is right far below a nanosecond") {
  dvdx::Clock clock;
  for (int i = 0; i < 1000000; ++i) clock.advance(0.1, 1);
  // 0.1 is 0.1000000000000000055511151231257827...
  CHECK(clock.seconds == 100000.0);
  CHECK(is_close(clock.carry, 5.5511151231257827e-12, 1e-12));
}

TEST_CASE("a clock that runs back stands where it started") {
  dvdx::Clock clock;
  for (int i = 0; i < 1000; ++i) clock.advance(1.0 / 60, 7);
  clock.advance(-1.0 / 60, 7000);
  CHECK(std::abs(clock.seconds + clock.carry) < 1e-25);  // of 117 s there and back
}

TEST_CASE("a clock is finite where both of its parts are") {
  using Limits = std::numeric_limits<double>;
  CHECK(dvdx::Clock{Limits::max(), -1}.is_finite());
  for (const double wrong : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
    CHECK_FALSE(dvdx::Clock{wrong, 0}.is_finite());
    CHECK_FALSE(dvdx::Clock{1, wrong}.is_finite());
  }
}
