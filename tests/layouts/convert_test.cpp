// From layout to layout and back.
#include "dvdx/layouts/convert.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <utility>
#include <vector>

#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace convert_test {

using namespace dvdx;
using test::Batch;

TEST_CASE_TEMPLATE("gather and scatter move any range of a column in every layout", T, float, double) {
  constexpr std::size_t count = 53;
  for (const test::Layout layout : test::layouts) {
    for (const auto& [first, n] : {std::pair<std::size_t, std::size_t>{0, 53}, {0, 0}, {52, 1}, {3, 19}, {8, 16}, {15, 34}}) {
      Batch<T> batch(layout, count);
      test::place(batch.view());
      const Column<T>& column = batch.view().v[1];
      std::vector<T> values(n);
      gather(column, first, n, values.data());
      for (std::size_t k = 0; k < n; ++k) CHECK(values[k] == column[first + k]);

      const std::vector<T> before = test::values_of(batch.view());
      for (T& value : values) value = -value;
      scatter(values.data(), first, n, column);
      std::vector<T> wanted = before;
      for (std::size_t k = 0; k < n; ++k) wanted[6 * (first + k) + 4] = -wanted[6 * (first + k) + 4];
      CHECK_MESSAGE(test::difference(wanted, test::values_of(batch.view())).empty(), test::name(layout));
      CHECK(batch.is_clean());
    }
  }
}

TEST_CASE("gather and scatter follow a column that runs backwards") {
  std::vector<double> values = {1, 2, 3, 4, 5};
  const Column<double> column{&values[4], -static_cast<std::ptrdiff_t>(sizeof(double)), 1, 5};
  std::vector<float> out(3);
  gather(column, 1, 3, out.data());
  CHECK(out == std::vector<float>{4, 3, 2});
  scatter(std::vector<float>{9, 8, 7}.data(), 1, 3, column);
  CHECK(values == std::vector<double>{1, 7, 8, 9, 5});
}

TEST_CASE("copy keeps particles, clock and bits from every layout to every layout") {
  constexpr std::size_t count = 37;
  for (const test::Layout from : test::layouts) {
    Batch<float> source(from, count);
    test::place(source.view());
    source.view().clock.advance(0.1, 3);
    for (const test::Layout to : test::layouts) {
      Batch<float> target(to, count);
      copy(source.view(), target.view());
      CHECK(test::difference(test::values_of(source.view()), test::values_of(target.view())).empty());
      CHECK(target.view().clock.seconds == source.view().clock.seconds);
      CHECK(target.view().clock.carry == source.view().clock.carry);
      CHECK(target.is_clean());
    }
  }
}

TEST_CASE("copy rounds doubles to the nearest float, and floats come back as they were") {
  Soa<double> wide(3);
  wide.view().x[0][1] = 0.1;
  wide.view().v[2][2] = 1e300;
  Soa<float> narrow(3);
  State<float> view = narrow.view();
  copy(wide.view(), view);
  CHECK(view.x[0][1] == 0.1F);
  CHECK(view.v[2][2] == std::numeric_limits<float>::infinity());
  State<double> back = wide.view();
  copy(view, back);
  CHECK(back.x[0][1] == static_cast<double>(0.1F));
}

}  // namespace convert_test
