// Sums that do not depend on the order or the split of their terms.
#include "math/exact_sum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace exact_sum_test {

using dvdx::exact_limbs;
using dvdx::exact_words;
using Words = std::array<std::int64_t, exact_words>;

Words words_of(const std::vector<double>& terms) {
  Words words{};
  for (const double term : terms) {
    dvdx::for_each_word(term, [&](std::size_t word, std::int64_t number) { words[word] += number; });
  }
  return words;
}
double sum(const std::vector<double>& terms) { return dvdx::rounded(words_of(terms)); }

TEST_CASE("an exact sum of one term is the term") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> digits(-1, 1);
  std::uniform_int_distribution<int> exponent(-1070, 1020);
  for (int n = 0; n < 2000; ++n) {
    const double term = std::ldexp(digits(random), exponent(random));
    CHECK(sum({term}) == term);
  }
  for (const double term : {0.0, std::numeric_limits<double>::max(), -std::numeric_limits<double>::max(),
                            std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::min()}) {
    CHECK(sum({term}) == term);
  }
}

TEST_CASE("an exact sum loses nothing to cancellation, and is rounded once, to even") {
  const double large = 0x1p53;
  CHECK(sum({0x1p1000, 0x1p-1074, -0x1p1000}) == 0x1p-1074);
  CHECK(sum({1e300, -1, -1e300}) == -1);
  CHECK(sum({large, 1}) == large);
  CHECK(sum({large, 3}) == large + 4);
  CHECK(sum({large, 1, 0x1p-1000}) == large + 2);
  CHECK(sum({large, 1, -0x1p-1000}) == large);
  CHECK(sum({-large, -1, -0x1p-1000}) == -large - 2);
  CHECK(sum({0x1p32, -1}) == 0x1p32 - 1);
  CHECK(sum({-0x1p64, 1}) == -0x1p64);
  CHECK(sum({0x1p1023, 0x1p1023}) == std::numeric_limits<double>::infinity());
  CHECK(std::isnan(sum({1, std::numeric_limits<double>::infinity()})));
  CHECK(std::isnan(sum({std::numeric_limits<double>::quiet_NaN()})));
}

TEST_CASE("an exact sum depends neither on the order of its terms nor on how they are split, carried or not") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> digits(-1, 1);
  std::uniform_int_distribution<int> exponent(-60, 60);
  std::vector<double> terms(5000);
  for (double& term : terms) term = std::ldexp(digits(random), exponent(random));
  const double all = sum(terms);
  long double plain = 0;
  for (const double term : terms) plain += term;
  CHECK(std::abs(static_cast<double>(plain) - all) <= 1e-12 * std::abs(all));
  for (int trial = 0; trial < 4; ++trial) {
    std::shuffle(terms.begin(), terms.end(), random);
    CHECK(sum(terms) == all);
    Words a = words_of({terms.begin(), terms.begin() + 1234});
    const Words b = words_of({terms.begin() + 1234, terms.end()});
    dvdx::carry(std::span(a).first(exact_limbs));
    for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
    CHECK(dvdx::rounded(a) == all);
  }
}

// Sizes that lanes accept completely, in part and not at all, zeros, and non-finite values.
TEST_CASE("an exact sum by lanes has every digit of the sum of each term by itself") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> digits(-1, 1);
  struct Sizes {
    int low, high;
  };
  for (const Sizes& sizes : {Sizes{-3, 3}, Sizes{-60, 60}, Sizes{-1070, -1000}, Sizes{880, 1000}, Sizes{-1070, 1000}}) {
    CAPTURE(sizes.low);
    CAPTURE(sizes.high);
    std::uniform_int_distribution<int> exponent(sizes.low, sizes.high);
    dvdx::ExactLanes lanes;
    std::vector<double> all;
    Words words{};
    const auto rest = [&](double term) {
      dvdx::for_each_word(term, [&](std::size_t word, std::int64_t number) { words[word] += number; });
    };
    for (int n = 0; n < 700; ++n) {
      std::array<double, dvdx::ExactLanes::lanes> terms{};
      for (double& term : terms) {
        if (n % 7 == 3 || random() % 4 == 0) continue;
        term = std::ldexp(digits(random), exponent(random));
        all.push_back(term);
      }
      lanes.add(terms, rest);
      if (n % 100 != 99) continue;
      lanes.flush(rest);
      CHECK(dvdx::rounded(words) == sum(all));
    }
    lanes.add({1, std::numeric_limits<double>::infinity()}, rest);
    lanes.flush(rest);
    CHECK(std::isnan(dvdx::rounded(words)));
  }
}

// Enough terms of one sign to fill the lanes' sums to their limit.
TEST_CASE("an exact sum by lanes is exact however many terms it takes") {
  dvdx::ExactLanes lanes;
  Words words{};
  const auto rest = [&](double term) {
    dvdx::for_each_word(term, [&](std::size_t word, std::int64_t number) { words[word] += number; });
  };
  std::array<double, dvdx::ExactLanes::lanes> terms{};
  terms.fill(1 - 0x1p-53);
  constexpr double count = 600000;
  for (int n = 0; n < 600000; ++n) lanes.add(terms, rest);
  lanes.flush(rest);
  CHECK(dvdx::rounded(words) == count * dvdx::ExactLanes::lanes - count * dvdx::ExactLanes::lanes * 0x1p-53);
}

}  // namespace exact_sum_test
