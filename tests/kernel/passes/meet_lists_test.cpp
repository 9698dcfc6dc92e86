// Lists of pairs within reach, held against all pairs.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "passes/meet/lists.hpp"
#include "support/scenes.hpp"

namespace meet_lists_test {

using namespace dvdx;
using Pairs = std::vector<std::array<std::size_t, 2>>;

constexpr auto one_thread = [](std::size_t tasks, const auto& body) {
  for (std::size_t task = 0; task < tasks; ++task) body(task);
};

template <class T>
struct Cloud {
  std::vector<Point<T>> x;
  std::vector<T> a;
};

template <class T>
Cloud<T> cloud(std::size_t count, double side, const std::array<double, 3>& at = {}, double a = 0.5) {
  Cloud<T> made;
  for (std::size_t i = 0; i < count; ++i) {
    Point<T> x;
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis] = static_cast<T>(at[axis] + side * test::uniform(axis, i));
    made.x.push_back(x);
    made.a.push_back(static_cast<T>(a));
  }
  return made;
}

template <class T>
Pairs all_pairs(const Cloud<T>& of, T reach) {
  Pairs found;
  for (std::size_t i = 0; i < of.x.size(); ++i) {
    for (std::size_t j = i + 1; j < of.x.size(); ++j) {
      const T most = of.a[i] + of.a[j] + reach;
      const Point<T> apart = minus(of.x[i], of.x[j]);
      if (of.a[i] >= 0 && of.a[j] >= 0 && inner(apart, apart) < most * most) found.push_back({i, j});
    }
  }
  return found;
}

template <class T>
Pairs listed(const Cloud<T>& of, T reach, T ordinary) {
  PairLists<T> lists(of.x.size(), of.x.size() * of.x.size());
  const auto all = [](std::uint32_t, std::uint32_t) { return true; };
  REQUIRE(lists.build(of.x.data(), of.a.data(), ordinary, reach, all, one_thread) == PairLists<T>::Found::all);
  Pairs found;
  for (std::size_t i = 0; i < of.x.size(); ++i) {
    for (const std::uint32_t* j = lists.begin(i); j != lists.end(i); ++j) found.push_back({i, *j});
  }
  return found;
}

TEST_CASE_TEMPLATE("lists hold every pair within reach once, by number", T, float, double) {
  for (const std::size_t count : {0U, 1U, 2U, 3U, 40U, 300U}) {
    for (const double side : {0.5, 3.0, 12.0, 400.0}) {
      const Cloud<T> of = cloud<T>(count, side);
      CHECK(listed(of, T(0.125), T(0.5)) == all_pairs(of, T(0.125)));
    }
  }
}

TEST_CASE_TEMPLATE("lists do not depend on where the particles are", T, float, double) {
  const std::array<double, 3> places[] = {{-7, 100, -1e4}, {1e6, -1e6, 0}, {-1e9, 3, 1e9}};
  for (const auto& at : places) {
    const Cloud<T> of = cloud<T>(200, 6, at);
    CHECK(listed(of, T(0.25), T(0.5)) == all_pairs(of, T(0.25)));
  }
}

TEST_CASE_TEMPLATE("flat and long clouds are listed", T, float, double) {
  Cloud<T> of = cloud<T>(300, 20);
  for (std::size_t i = 0; i < of.x.size(); ++i) {
    of.x[i][1] = 0;
    if (i % 2 == 0) of.x[i][2] = T(0.25);
  }
  CHECK(listed(of, T(0.5), T(0.5)) == all_pairs(of, T(0.5)));
}

TEST_CASE_TEMPLATE("sizes may differ by more than the cells are made for", T, float, double) {
  Cloud<T> of = cloud<T>(200, 12, {}, 0.25);
  for (std::size_t i = 0; i < of.x.size(); i += 9) of.a[i] = static_cast<T>(0.25 + 0.5 * static_cast<double>(i % 5));
  of.a[17] = T(40);
  CHECK(listed(of, T(0.125), T(0.25)) == all_pairs(of, T(0.125)));
  CHECK(listed(of, T(0.125), T(0.75)) == all_pairs(of, T(0.125)));
}

TEST_CASE_TEMPLATE("particles in one place are a pair, those that are nowhere in none", T, float, double) {
  Cloud<T> of = cloud<T>(120, 4);
  of.x[7] = of.x[3];
  of.x[90] = of.x[3];
  of.a[11] = T(-1);
  Cloud<T> sound = of;
  const T infinity = std::numeric_limits<T>::infinity();
  const T nan = std::numeric_limits<T>::quiet_NaN();
  of.x[20] = {nan, T(1), T(1)};
  of.x[50] = {T(1), infinity, T(1)};
  of.x[60] = {T(1), T(1), -std::numeric_limits<T>::max()};
  for (const std::size_t i : {20U, 50U, 60U}) sound.a[i] = T(-1);
  CHECK(listed(of, T(0.125), T(0.5)) == all_pairs(sound, T(0.125)));
}

TEST_CASE("lists that are longer than their room are told") {
  const Cloud<double> of = cloud<double>(60, 2);
  const auto all = [](std::uint32_t, std::uint32_t) { return true; };
  const std::size_t pairs = all_pairs(of, 0.0).size();
  PairLists<double> enough(of.x.size(), pairs);
  PairLists<double> too_small(of.x.size(), pairs - 1);
  CHECK(enough.build(of.x.data(), of.a.data(), 0.5, 0, all, one_thread) == PairLists<double>::Found::all);
  CHECK(too_small.build(of.x.data(), of.a.data(), 0.5, 0, all, one_thread) == PairLists<double>::Found::too_many);
}

TEST_CASE("pairs that are not accepted are not listed") {
  const Cloud<double> of = cloud<double>(60, 2);
  PairLists<double> lists(of.x.size(), 60 * 60);
  const auto odd = [](std::uint32_t i, std::uint32_t j) { return (i + j) % 2 == 1; };
  REQUIRE(lists.build(of.x.data(), of.a.data(), 0.5, 0, odd, one_thread) == PairLists<double>::Found::all);
  std::size_t count = 0;
  for (const auto& [i, j] : all_pairs(of, 0.0)) count += (i + j) % 2;
  std::size_t found = 0;
  for (std::size_t i = 0; i < of.x.size(); ++i) {
    for (const std::uint32_t* j = lists.begin(i); j != lists.end(i); ++j, ++found) CHECK((i + *j) % 2 == 1);
  }
  CHECK(found == count);
}

}  // namespace meet_lists_test
