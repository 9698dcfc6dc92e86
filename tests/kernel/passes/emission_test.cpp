// The emission pass: every instruction set has the scalar twin's bits, and drawn values lie in their ranges.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include "isa/passes.hpp"

namespace emission_test {

using namespace dvdx;

EmissionTerms terms_of(EmissionShape shape, EmissionSpread spread) {
  EmissionTerms terms;
  terms.shape = shape;
  terms.spread = spread;
  terms.origin = {1, -2, 3};
  terms.most = {1.5, -2, 7};
  terms.radii = {Vec3{0.3, 0, 0.4}, Vec3{0, 0.5, 0}};
  terms.velocity = {4, 5, -6};
  terms.half_sides = {0.5, 0, 2};
  terms.radius = 1.5;
  terms.lifetime = 2;
  terms.lifetime_range = shape == EmissionShape::point ? 0 : 0.75;
  terms.interval = 0.001;
  terms.seed = 0x123456789abcdef0U;
  return terms;
}

constexpr std::array shapes = {EmissionShape::point, EmissionShape::disc, EmissionShape::box};
constexpr std::array spreads = {EmissionSpread::none, EmissionSpread::ball, EmissionSpread::box};

std::unique_ptr<Born> born_of(const Passes& passes, const EmissionTerms& terms, const Births& births) {
  auto born = std::make_unique<Born>();
  passes.emit(terms, births, *born);
  return born;
}

bool is_same(const Born::Values& a, const Born::Values& b, std::size_t count) {
  return std::memcmp(a.data(), b.data(), count * sizeof(double)) == 0;
}

double length(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

TEST_CASE("births have the same bits on every ISA at every count, beyond 2^32 of them too") {
  for (const auto shape : shapes) {
    for (const auto spread : spreads) {
      const EmissionTerms terms = terms_of(shape, spread);
      for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{8}, std::size_t{33}, born_together}) {
        const Births births{.first = 0xfffffff0U, .count = count, .lead = 12.25, .step = 0.01};
        const auto wanted = born_of(reference_separate, terms, births);
        for (const Isa isa : available_isas()) {
          CAPTURE(name(isa));
          const auto born = born_of(*find_passes(isa), terms, births);
          for (std::size_t axis = 0; axis < 3; ++axis) {
            CHECK(is_same(born->x[axis], wanted->x[axis], count));
            CHECK(is_same(born->v[axis], wanted->v[axis], count));
          }
          CHECK(is_same(born->age, wanted->age, count));
          CHECK(is_same(born->lifetime, wanted->lifetime, count));
        }
      }
    }
  }
}

TEST_CASE("a birth depends on its number and not on the call that makes it") {
  const EmissionTerms terms = terms_of(EmissionShape::disc, EmissionSpread::ball);
  const auto all = born_of(*find_passes(best_isa()), terms, {.first = 100, .count = 40, .lead = 40, .step = 1});
  const auto last = born_of(*find_passes(best_isa()), terms, {.first = 133, .count = 7, .lead = 7, .step = 1});
  for (std::size_t i = 0; i < 7; ++i) {
    CHECK(all->x[1][33 + i] == last->x[1][i]);
    CHECK(all->v[2][33 + i] == last->v[2][i]);
    CHECK(all->age[33 + i] == last->age[i]);
  }
}

TEST_CASE("newborn particles lie evenly where they should") {
  constexpr std::size_t calls = 40;
  EmissionTerms terms = terms_of(EmissionShape::disc, EmissionSpread::ball);
  terms.interval = 0;  // no particle moves from its place
  Vec3 place{}, velocity{};
  std::size_t in_half_radius = 0, in_half_ball = 0;
  for (std::size_t call = 0; call < calls; ++call) {
    const auto born =
        born_of(reference_separate, terms, {.first = call * born_together, .count = born_together, .lead = 0, .step = 1});
    for (std::size_t i = 0; i < born_together; ++i) {
      Vec3 from{}, fast{};
      for (std::size_t k = 0; k < 3; ++k) {
        from[k] = born->x[k][i] - terms.origin[k];
        fast[k] = born->v[k][i] - terms.velocity[k];
        place[k] += from[k];
        velocity[k] += fast[k];
      }
      const double r = length(from), speed = length(fast);
      CHECK(r <= 0.5 * (1 + 1e-14));
      CHECK(std::abs(0.8 * from[0] - 0.6 * from[2]) < 1e-14);  // in the disc's plane
      CHECK(speed <= 1.5 * (1 + 1e-14));
      in_half_radius += r < 0.25 ? 1 : 0;
      in_half_ball += speed < 0.75 ? 1 : 0;
      CHECK(born->lifetime[i] >= 2);
      CHECK(born->lifetime[i] < 2.75);
    }
  }
  constexpr double n = calls * born_together;  // 10240: the deviation of a share is below 0.005, that of a mean below 0.01
  CHECK(std::abs(static_cast<double>(in_half_radius) / n - 0.25) < 0.02);
  CHECK(std::abs(static_cast<double>(in_half_ball) / n - 0.125) < 0.02);
  CHECK(length(place) / n < 0.02);
  CHECK(length(velocity) / n < 0.04);
}

TEST_CASE("a newborn particle moves in a straight line for the rest of its step, from no time to a whole step") {
  const EmissionTerms terms = terms_of(EmissionShape::point, EmissionSpread::none);
  const auto born = born_of(*find_passes(best_isa()), terms, {.first = 0, .count = 8, .lead = 6.5, .step = 0.005});
  for (std::size_t i = 0; i < 8; ++i) {
    const double rest = std::min(0.005, std::max(0.0, (6.5 - static_cast<double>(i)) * 0.001));
    CHECK(born->age[i] == rest);
    CHECK(born->x[2][i] == 3 + -6 * rest);
    CHECK(born->v[2][i] == -6);
    CHECK(born->lifetime[i] == 2);
  }
}

}  // namespace emission_test
