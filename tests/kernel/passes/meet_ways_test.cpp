// The displacements of particles that meet: the twins' bits, and sums by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "isa/passes.hpp"
#include "support/isas.hpp"
#include "support/scenes.hpp"

namespace meet_ways_test {

using namespace dvdx;

// Particles in another order than their columns. Some have no radius, some no mass, and some were never listed.
template <class T>
struct Moved {
  std::vector<std::uint32_t> elements;
  std::array<std::vector<T>, 3> x, v;
  std::vector<T> w;
  std::vector<MetStart<T>> start;
  std::vector<MetListed<T>> listed;
  std::vector<MetEnd<T>> end;
  std::vector<MetVelocity<T>> velocity;

  explicit Moved(std::size_t count) : w(count), start(count), listed(count), end(count), velocity(count) {
    const auto number = [](std::uint64_t stream, std::size_t k) { return static_cast<T>(2 * test::uniform(stream, k) - 1); };
    for (std::size_t i = 0; i < count; ++i) {
      elements.push_back(static_cast<std::uint32_t>(count - 1 - i));
      start[i] = {{number(0, i), number(1, i), number(2, i)}, i % 5 == 3 ? T(-1) : T(1)};
      listed[i] = {{number(3, i), number(4, i), number(5, i)}, number(6, i) + T(6)};
      w[i] = i % 4 == 2 ? T(0) : T(1) + number(7, i);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < count; ++i) {
        x[axis].push_back(w[i] > 0 ? number(8 + axis, i) : start[count - 1 - i].x[axis]);
        v[axis].push_back(number(11 + axis, i));
      }
    }
  }
  Moved(const Moved&) = delete;
  Moved& operator=(const Moved&) = delete;

  [[nodiscard]] WaySums take(const MeetKernels<T>& kernels) noexcept {
    const WayTerms<T> terms{.elements = elements.data(),
                            .x = {x[0].data(), x[1].data(), x[2].data()},
                            .v = {v[0].data(), v[1].data(), v[2].data()},
                            .w = w.data(),
                            .start = start.data(),
                            .listed = listed.data(),
                            .end = end.data(),
                            .velocity = velocity.data()};
    return kernels.take_ways(terms, 0, w.size());
  }
  [[nodiscard]] ListAge find_strays(const MeetKernels<T>& kernels, T allowed) noexcept {
    const StrayTerms<T> terms{.start = start.data(),
                              .listed = listed.data(),
                              .end = end.data(),
                              .way = {T(0.25), T(-0.5), T(0.125)},
                              .gone = {T(0.5), T(0.25), T(-0.25)},
                              .allowed = allowed};
    return kernels.find_strays(terms, 0, w.size());
  }
};

template <class Record>
bool are_equal(const std::vector<Record>& a, const std::vector<Record>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Record)) == 0;
}

TEST_CASE_TEMPLATE("ways have the bits of the scalar ones on every instruction set, of any number of particles", T, float,
                   double) {
  for (const std::size_t count : {1U, 3U, 15U, 16U, 17U, 35U, 64U, 101U}) {
    Moved<T> expected(count);
    if (count > 20) {
      expected.x[1][4] = std::numeric_limits<T>::infinity();
      expected.x[2][8] = std::numeric_limits<T>::max();  // its square overflows
    }
    const auto& scalar = find_passes(Isa::reference)->template of<T>().meet;
    const WaySums sums = expected.take(scalar);
    const ListAge age = expected.find_strays(scalar, T(2));
    for (const Isa isa : available_isas(Arithmetic::separate)) {
      const auto& wide = find_passes(isa)->template of<T>().meet;
      Moved<T> got(count);
      got.x = expected.x;
      const WaySums same = got.take(wide);
      CHECK(same.way == sums.way);
      CHECK(same.gone == sums.gone);
      CHECK(same.ways == sums.ways);
      CHECK(same.gones == sums.gones);
      CHECK(same.has_movers == sums.has_movers);
      CHECK(got.find_strays(wide, T(2)) == age);
      CHECK(are_equal(got.velocity, expected.velocity));
      if (count <= 20) CHECK(are_equal(got.end, expected.end));  // NaN has many bit patterns
    }
  }
  test::has_several_isas();
}

// 20 particles move by (1, 2, 3), and one without a radius stays.
TEST_CASE("ways are summed over particles that meet and are finite, and lists are old once one has strayed too far") {
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    const auto& kernels = find_passes(isa)->f64.meet;
    Moved<double> of(21);
    for (std::size_t i = 0; i < 21; ++i) {
      of.start[i] = {{double(i), 0, 0}, i == 20 ? -1.0 : 1.0};
      of.listed[i] = {of.start[i].x, 0.5};
      of.w[i] = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        of.x[axis][20 - i] = of.start[i].x[axis] + (i == 20 ? 0.0 : double(axis + 1));
      }
    }
    WaySums sums = of.take(kernels);
    CHECK(sums.way == std::array{20.0, 40.0, 60.0});
    CHECK(sums.gone == sums.way);
    CHECK(sums.ways == 20);
    CHECK_FALSE(sums.has_movers);
    CHECK(of.end[7].x == Point<double>{8, 2, 3});
    CHECK(of.velocity[7].v == Point<double>{of.v[0][13], of.v[1][13], of.v[2][13]});
    const StrayTerms<double> terms{.start = of.start.data(),
                                   .listed = of.listed.data(),
                                   .end = of.end.data(),
                                   .way = {1, 2, 3},
                                   .gone = {1, 2, 3},
                                   .allowed = 1};
    CHECK(kernels.find_strays(terms, 0, 21) == ListAge::fresh);
    CHECK(of.end[7].strays == 0);
    // A particle may stray by 1 + 0.5, of which 2 x 0.5 are reserved for the sub-step in which it strays.
    of.end[19].x[1] += 0.5;
    CHECK(kernels.find_strays(terms, 0, 21) == ListAge::fresh);
    CHECK(of.end[19].strays == 0.5);
    of.end[19].x[1] += 0.01;
    CHECK(kernels.find_strays(terms, 0, 21) == ListAge::stale);
    CHECK(kernels.find_strays(terms, 0, 19) == ListAge::fresh);
    of.w[20 - 3] = 0;
    CHECK(of.take(kernels).has_movers);
    of.x[2][20 - 3] = std::numeric_limits<double>::quiet_NaN();
    sums = of.take(kernels);
    CHECK(sums.ways == 19);
    CHECK(kernels.find_strays(terms, 0, 4) == ListAge::stale);
    CHECK(kernels.find_strays(terms, 4, 19) == ListAge::fresh);
  }
}

}  // namespace meet_ways_test
