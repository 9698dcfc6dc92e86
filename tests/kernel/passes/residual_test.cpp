// The residual pass: float64 numbers as two columns of float32, and back.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dvdx/layouts/convert.hpp"
#include "isa/passes.hpp"
#include "support/batch.hpp"

namespace residual_test {

using namespace dvdx;

constexpr float guard = -77;  // beyond the range that a call may write

struct Split {
  std::vector<float> value, residual;
};

Split split(const ResidualKernels& kernels, const std::vector<double>& numbers, std::size_t count) {
  Split out{std::vector<float>(count + 1, guard), std::vector<float>(count + 1, guard)};
  kernels.split(numbers.data(), count, out.value.data(), out.residual.data());
  CHECK(out.value.back() == guard);
  CHECK(out.residual.back() == guard);
  return out;
}

// Numbers of every size, including some that float32 cannot hold.
std::vector<double> many_numbers() {
  std::vector<double> numbers;
  for (int k = 0; k < 100; ++k)
    numbers.push_back(std::ldexp(1.0 + 0.137 * k / 13, k % 2 == 0 ? k : -k) * (k % 3 == 0 ? -1 : 1));
  numbers[5] = 1e300;
  numbers[17] = std::numeric_limits<double>::quiet_NaN();
  numbers[36] = -std::numeric_limits<double>::infinity();
  numbers[40] = std::numeric_limits<float>::max();
  numbers[41] = std::numeric_limits<float>::denorm_min();
  numbers[42] = -0.0;
  return numbers;
}

TEST_CASE("residual: every instruction set splits and sums as the scalar twin does, at every count") {
  const std::vector<double> numbers = many_numbers();
  const ResidualKernels& twin = find_passes(Isa::reference)->residual;
  for (const Isa isa : available_isas()) {
    const ResidualKernels& kernels = find_passes(isa)->residual;
    for (std::size_t count = 0; count <= numbers.size(); ++count) {
      CAPTURE(name(isa));
      CAPTURE(count);
      const Split mine = split(kernels, numbers, count);
      const Split wanted = split(twin, numbers, count);
      REQUIRE(test::difference(mine.value, wanted.value).empty());
      REQUIRE(test::difference(mine.residual, wanted.residual).empty());
      std::vector<double> sum(count + 1, guard), wanted_sum(count + 1, guard);
      kernels.sum(mine.value.data(), mine.residual.data(), count, sum.data());
      twin.sum(wanted.value.data(), wanted.residual.data(), count, wanted_sum.data());
      REQUIRE(test::difference(sum, wanted_sum).empty());
      REQUIRE(sum.back() == guard);
    }
  }
}

TEST_CASE("residual: value and residual are the nearest float32, and hold a number to 48 bits") {
  const std::vector<double> numbers = many_numbers();
  for (const Isa isa : available_isas()) {
    const ResidualKernels& kernels = find_passes(isa)->residual;
    const Split parts = split(kernels, numbers, numbers.size());
    std::vector<double> sum(numbers.size());
    kernels.sum(parts.value.data(), parts.residual.data(), numbers.size(), sum.data());
    for (std::size_t k = 43; k < numbers.size(); ++k) {
      CAPTURE(k);
      CHECK(parts.value[k] == static_cast<float>(numbers[k]));
      CHECK(static_cast<double>(parts.residual[k]) ==
            static_cast<double>(static_cast<float>(numbers[k] - double{parts.value[k]})));
      CHECK(std::abs(sum[k] - numbers[k]) <= std::abs(numbers[k]) * 0x1p-48);
    }
  }
}

TEST_CASE("residual: every instruction set leaves no rest beside a number beyond float32") {
  std::vector<double> numbers(37, 1.0 + 0x1p-30);
  numbers[5] = 1e300;
  numbers[36] = -std::numeric_limits<double>::infinity();
  for (const Isa isa : available_isas()) {
    const Split parts = split(find_passes(isa)->residual, numbers, numbers.size());
    CHECK(parts.residual[4] == 0x1p-30F);
    CHECK(parts.residual[5] == 0);
    CHECK(parts.residual[36] == 0);
  }
}

}  // namespace residual_test
