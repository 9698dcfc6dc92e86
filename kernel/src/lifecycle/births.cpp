// The number of births of an emitter until some time.
#include <algorithm>
#include <cmath>

#include "lifecycle/compiled_lifecycle.hpp"

namespace dvdx {

// rate (time - start), in twice double precision. The slack keeps a birth at the very end of a step in that step, although
// times and rate may not be what their decimals say: each is rounded by at most 2^-53 of itself.
BirthCount births_until(const Emitter& emitter, const Clock& clock) noexcept {
  constexpr double rounding = 0x1p-50;
  constexpr double most = 0x1p62;
  const TwoDouble since = TwoDouble(clock.seconds, clock.carry) - TwoDouble(emitter.start);
  const TwoDouble number = since * emitter.rate;
  const TwoDouble all = (TwoDouble(emitter.end) - TwoDouble(emitter.start)) * emitter.rate;
  const bool is_over = std::isfinite(emitter.end) && (all - number).high < 0;
  const double until = is_over ? emitter.end : clock.seconds;
  const double slack = rounding * emitter.rate * (std::abs(until) + std::abs(emitter.start));
  const TwoDouble counted = (is_over ? all : number) + TwoDouble(slack);
  if (!(counted.high >= 1)) return {0, number};
  const double floor = std::floor(std::min(counted.high, most));
  const double rest = (counted.high - floor) + counted.low;  // the lower part may reach below the whole number
  return {static_cast<std::uint64_t>(floor) - (rest < 0 ? 1 : 0), number};
}

}  // namespace dvdx
