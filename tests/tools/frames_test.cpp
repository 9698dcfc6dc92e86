// The selection of a run's steps that are written.
#include "output/frames.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace frames_test {

using dvdx::tool::Frames;
using dvdx::tool::frames_a_second;
using Steps = std::vector<std::uint64_t>;

// The steps written when asked as a run asks: step by step, from the start to the end.
Steps written(const Frames& frames, std::uint64_t steps) {
  Steps all;
  if (!frames.is_last_alone() && steps > 0) all.push_back(0);
  for (std::uint64_t done = 0; done < steps;) {
    done = frames.next(done, steps);
    if (done < steps) all.push_back(done);
  }
  all.push_back(steps);
  return all;
}

TEST_CASE("a state every N steps: step 0, each N-th and the last") {
  CHECK(written({.apart = 4}, 10) == Steps{0, 4, 8, 10});
  CHECK(written({.apart = 5}, 10) == Steps{0, 5, 10});
  CHECK(written({.apart = 100}, 10) == Steps{0, 10});
  CHECK(written({.apart = 1.8446744073709552e19}, 10) == Steps{0, 10});
  CHECK(written({.apart = 1}, 3) == Steps{0, 1, 2, 3});
  CHECK(written({}, 10) == Steps{10});
  CHECK(written({.apart = 4}, 0) == Steps{0});
}

TEST_CASE("states per second are taken at the nearest steps, at most one a step") {
  CHECK(written(frames_a_second(30, 1.0 / 60), 6) == Steps{0, 2, 4, 6});
  CHECK(written(frames_a_second(30, 0.016666666666666666), 7) == Steps{0, 2, 4, 6, 7});
  CHECK(written(frames_a_second(30, 0.01), 10) == Steps{0, 3, 7, 10});
  CHECK(written(frames_a_second(24, -0.01), 10) == Steps{0, 4, 8, 10});
  CHECK(written(frames_a_second(1000, 0.01), 3) == Steps{0, 1, 2, 3});
  // A billion steps of 1 us: every frame is within half a step of its time, and none is lost.
  const Frames frames = frames_a_second(30, 1e-6);
  CHECK(frames.states(1'000'000'000) == 30'001);
  CHECK(frames.next(999'966'667, 1'000'000'000) == 1'000'000'000);
  CHECK(frames.next(33'333, 1'000'000'000) == 66'667);
}

// 1/60 s to ten digits: a run that goes on with `--every 2` finds the states of one that began with `--fps 30`.
TEST_CASE("a step rounded to ten digits keeps states a whole number of steps apart, one rounded to four does not") {
  CHECK(frames_a_second(30, 0.01666666667).apart == 2);
  CHECK(frames_a_second(30, 0.01667).apart == doctest::Approx(1 / 0.5001).epsilon(1e-12));
}

TEST_CASE("the number of states written is the predicted one") {
  for (const double apart : {0.0, 1.0, 1.25, 1.5, 2.0, 2.6666, 3.3333333333, 7.0, 9.5, 10.0}) {
    for (std::uint64_t steps = 0; steps < 41; ++steps) {
      CAPTURE(apart);
      CAPTURE(steps);
      const Frames frames{.apart = apart};
      const Steps all = written(frames, steps);
      CHECK(frames.states(steps) == all.size());
      for (std::size_t k = 0; apart > 0 && k + 1 < all.size(); ++k) {
        CHECK(std::abs(static_cast<double>(all[k]) - static_cast<double>(k) * apart) <= 0.5);
      }
    }
  }
}

}  // namespace frames_test
