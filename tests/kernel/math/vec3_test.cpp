// Lengths and directions: correct at every scale, with bits that no math library can change.
#include "math/vec3.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>

namespace vec3_test {

using namespace dvdx;

constexpr std::array<Vec3, 5> vectors = {{{3, 4, 0}, {1, 1, 1}, {0.1, -0.7, 0.3}, {-2, 1e-9, 5}, {0, 0, -1}}};

TEST_CASE("A length has the same bits at every scale that holds it") {
  for (const Vec3& a : vectors) {
    for (const int n : {-900, -431, -429, -1, 1, 509, 512, 900}) {
      CAPTURE(n);
      CHECK(length(scaled(a, std::ldexp(1.0, n))) == std::ldexp(length(a), n));
    }
  }
  CHECK(length({3, 4, 0}) == 5);
  CHECK(length({0, 0, 0}) == 0);
  CHECK(length({0, 0, std::numeric_limits<double>::denorm_min()}) == std::numeric_limits<double>::denorm_min());
  CHECK(length({std::numeric_limits<double>::max(), 0, 0}) == std::numeric_limits<double>::max());
}

TEST_CASE("A direction has the length one, whatever it was made of") {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  for (const Vec3& a : vectors) {
    const Vec3 n = unit(a);
    for (const int power : {-900, -600, 600, 1000}) CHECK(unit(scaled(a, std::ldexp(1.0, power))) == n);
    CHECK(std::abs(dot(n, n) - 1) <= 4 * eps);
    CHECK(length(cross(n, a)) <= 4 * eps * length(a));
    CHECK(dot(n, a) > 0);
  }
}

TEST_CASE("Two directions across a third are across each other") {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  for (const Vec3& a : vectors) {
    const auto [n1, n2] = across(a);
    CHECK(std::abs(dot(n1, n2)) <= 2 * eps);
    CHECK(std::abs(dot(n1, unit(a))) <= 2 * eps);
    CHECK(std::abs(dot(n2, unit(a))) <= 2 * eps);
    CHECK(std::abs(length(n1) - 1) <= 2 * eps);
    CHECK(std::abs(length(n2) - 1) <= 4 * eps);
  }
  const auto [n1, n2] = across({0, 7, 0});
  CHECK(std::abs(n1[2]) == 1);
  CHECK(std::abs(n2[0]) == 1);
}

}  // namespace vec3_test
