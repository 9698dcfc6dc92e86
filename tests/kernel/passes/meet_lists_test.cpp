// Lists of pairs within reach, compared with all pairs.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "isa/passes.hpp"
#include "meet/lists.hpp"
#include "support/isas.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"
#include "work/tasks.hpp"

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
std::vector<MetListed<T>> places_of(const Cloud<T>& of) {
  std::vector<MetListed<T>> listed;
  for (const Point<T>& x : of.x) listed.push_back({x, T(0)});
  return listed;
}

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
Pairs pairs_of(const PairLists<T>& lists, std::size_t particles) {
  Pairs found;
  for (std::size_t i = 0; i < particles; ++i) {
    for (const std::uint32_t* j = lists.begin(i); j != lists.end(i); ++j) found.push_back({i, *j});
  }
  return found;
}

template <class T>
const NearKernels<T>& near_of(Isa isa) {
  return find_passes(isa)->template of<T>().meet.near;
}

// The list by every instruction set, checked to be the same.
template <class T>
Pairs listed(const Cloud<T>& of, T reach, T ordinary) {
  std::optional<Pairs> found;
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    PairLists<T> lists(of.x.size(), of.x.size() * of.x.size());
    const auto done = lists.build(places_of(of).data(), of.a.data(), ordinary, reach, AllPairs(), near_of<T>(isa), one_thread);
    REQUIRE(done == PairLists<T>::Found::all);
    const Pairs pairs = pairs_of(lists, of.x.size());
    if (!found) found = pairs;
    CHECK(*found == pairs);
  }
  test::has_several_isas();
  return *found;
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
  // The last places are near the cells 2^31 and -2^31.
  const std::array<double, 3> places[] = {{-7, 100, -1e4}, {1e6, -1e6, 0},     {-1e9, 3, 1e9},
                                          {3e9, -2e12, 0}, {2684622992, 0, 0}, {-2684622998, 0, 0}};
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

TEST_CASE_TEMPLATE("particles in one place are listed as a pair, and those that are not finite are in no pair", T, float,
                   double) {
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
  const Pairs expected = all_pairs(of, 0.0);
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    PairLists<double> enough(of.x.size(), expected.size());
    PairLists<double> too_small(of.x.size(), expected.size() - 1);
    const auto build = [&](PairLists<double>& lists) {
      return lists.build(places_of(of).data(), of.a.data(), 0.5, 0, AllPairs(), near_of<double>(isa), one_thread);
    };
    CHECK(build(enough) == PairLists<double>::Found::all);
    CHECK(pairs_of(enough, of.x.size()) == expected);
    CHECK(build(too_small) == PairLists<double>::Found::too_many);
  }
}

// Particles in one place, so that a few of them have more candidates than capacity.
TEST_CASE("pairs that are not accepted are not listed, nor need room") {
  const Cloud<float> of = cloud<float>(600, 0.1);
  for (const std::uint32_t part : {2U, 40U, 1000U}) {
    const auto few = [&](std::uint32_t i, std::uint32_t j) { return (i + j) % part == 1; };
    Pairs expected;
    for (std::size_t i = 0; i < of.x.size(); ++i) {
      for (std::size_t j = i + 1; j < of.x.size(); ++j) {
        if ((i + j) % part == 1) expected.push_back({i, j});
      }
    }
    for (const Isa isa : available_isas(Arithmetic::separate)) {
      PairLists<float> lists(of.x.size(), expected.size());
      const auto build = [&](PairLists<float>& of_pairs) {
        return of_pairs.build(places_of(of).data(), of.a.data(), 0.5F, 0.0F, few, near_of<float>(isa), one_thread);
      };
      REQUIRE(build(lists) == PairLists<float>::Found::all);
      CHECK(pairs_of(lists, of.x.size()) == expected);
      PairLists<float> too_small(of.x.size(), expected.size() - 1);
      CHECK(build(too_small) == PairLists<float>::Found::too_many);
    }
  }
}

TEST_CASE_TEMPLATE("places of a list name their owners, also where some particles look farther", T, float, double) {
  Cloud<T> of = cloud<T>(400, 6);
  for (const std::size_t i : {5U, 77U, 399U}) of.a[i] = T(2);
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    PairLists<T> lists(of.x.size(), 64 * of.x.size());
    const auto done = lists.build(places_of(of).data(), of.a.data(), T(0.5), T(0.25), AllPairs(), near_of<T>(isa), one_thread);
    REQUIRE(done == PairLists<T>::Found::all);
    Pairs pairs;
    for (std::size_t place = 0; place < lists.first(of.x.size()); ++place) {
      pairs.push_back({lists.owners()[place], lists.partners()[place]});
    }
    CHECK(pairs == all_pairs(of, T(0.25)));
  }
}

// Some particles have no place, and some have a long reach.
template <class T>
Cloud<T> ragged_cloud(std::size_t count, double side) {
  Cloud<T> of = cloud<T>(count, side);
  for (std::size_t i = 5; i < count; i += 31) of.a[i] = T(-1);
  for (std::size_t i = 7; i < count; i += 211) of.a[i] = T(1.5);
  for (std::size_t i = 9; i < count; i += 97) of.x[i][i % 3] = T(3e6);
  return of;
}

TEST_CASE_TEMPLATE("lists are the same on any number of threads, and in any order of tasks" * doctest::test_suite("threads"), T,
                   float, double) {
  const auto backwards = [](std::size_t tasks, const auto& body) {
    for (std::size_t task = tasks; task-- > 0;) body(task);
  };
  // Sizes near those of tasks. All use the same memory, also for fewer particles after more.
  constexpr std::size_t most = 6151;
  PairLists<T> lists(most, 40 * most);
  for (const std::size_t count : {2047U, 2048U, 2049U, 4099U, 6151U, 515U, 3U}) {
    const Cloud<T> of = ragged_cloud<T>(count, 1 + std::cbrt(static_cast<double>(count)));
    const NearKernels<T>& near = near_of<T>(best_isa(Arithmetic::separate));
    const auto listed_by = [&](const auto& run) {
      lists.set_count(count);
      const auto done = lists.build(places_of(of).data(), of.a.data(), T(0.5), T(0.25), AllPairs(), near, run);
      REQUIRE(done == PairLists<T>::Found::all);
      return pairs_of(lists, count);
    };
    const Pairs expected = listed_by(one_thread);
    CAPTURE(count);
    if (count < 3000) CHECK(expected == all_pairs(of, T(0.25)));
    CHECK(listed_by(backwards) == expected);
    for (const std::size_t number : {1U, 2U, 3U, 8U}) {
      test::Threads threads(number);
      const ParallelFor parallel = threads.parallel_for();
      const auto run = [&](std::size_t tasks, const auto& body) { for_each_task(parallel, tasks, body); };
      CHECK(listed_by(run) == expected);
    }
  }
}

}  // namespace meet_lists_test
