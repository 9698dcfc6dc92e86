#include "scene_io/counter_random.hpp"

#include <doctest/doctest.h>

#include <limits>

#include "support/close.hpp"

using dvdx::philox4x32;
using dvdx::unit_value;
using dvdx::test::is_close;
using dvdx::tool::uniform_value;

namespace counter_random_test {

using Words = std::array<std::uint32_t, 4>;

// The reference values published by the generator's authors.
static_assert(philox4x32({0, 0, 0, 0}, {0, 0}) == Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
static_assert(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}) ==
              Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
static_assert(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
              Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});

TEST_CASE("seeded values are those of docs/scene.md") {
  CHECK(unit_value(0, 0, 0) == 0x1.c2d38b1acc4fdp-1);
  CHECK(unit_value(1, 0, 0) == 0x1.ca141d79c7dp-1);
  CHECK(unit_value(1, 0, 1) == 0x1.0a0992d81c1c6p-2);
  CHECK(unit_value(1, 0, 2) == 0x1.19db8ba7ce68p-1);
  CHECK(unit_value(1, 1, 0) == 0x1.bf8b997d58102p-1);
  CHECK(unit_value(1, 999999, 2) == 0x1.a282c215d9098p-1);
  CHECK(unit_value(18446744073709551615U, 4294967296, 1) == 0x1.fd749a2a511c8p-3);
}

TEST_CASE("seeded values stay in their range and fill it") {
  double sum = 0;
  constexpr std::uint64_t count = 100000;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double value = uniform_value(-2, 6, 7, i, 1);
    REQUIRE(value >= -2);
    REQUIRE(value < 6);
    sum += value;
  }
  CHECK(is_close(sum / count, 2, 0.02));
  CHECK(uniform_value(3, 3, 1, 5, 0) == 3);
}

TEST_CASE("a drawn value stays below max where rounding would reach it") {
  const double max = 1 + std::numeric_limits<double>::epsilon();  // the only other value in [1, max) is 1
  for (std::uint64_t i = 0; i < 100; ++i) CHECK(uniform_value(1, max, 1, i, 0) == 1);
}

}  // namespace counter_random_test
