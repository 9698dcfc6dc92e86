// The emission pass, scalar: written by hand beside emission.inl.hpp, the same letters in the same order of operations.
#pragma once

#include <cmath>

#include "dvdx/counter_random.hpp"
#include "forces/elementary.hpp"
#include "passes/emission/emission.hpp"

namespace dvdx::reference {

inline Vec3 birth_place(const EmissionTerms& terms, std::uint64_t birth) noexcept {
  Vec3 x = terms.origin;
  if (terms.shape == EmissionShape::disc) {
    const double r = std::sqrt(unit_value(terms.seed, birth, 0));
    const SinCos turn = sincos(two_pi * unit_value(terms.seed, birth, 1));
    const double a = r * turn.cos, b = r * turn.sin;
    for (std::size_t k = 0; k < 3; ++k) x[k] = x[k] + (a * terms.radii[0][k] + b * terms.radii[1][k]);
  }
  if (terms.shape == EmissionShape::box) {
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = x[k] + (terms.most[k] - x[k]) * unit_value(terms.seed, birth, static_cast<std::uint32_t>(k));
      if (x[k] > terms.most[k]) x[k] = terms.most[k];
    }
  }
  return x;
}

inline Vec3 birth_velocity(const EmissionTerms& terms, std::uint64_t birth) noexcept {
  Vec3 v = terms.velocity;
  if (terms.spread == EmissionSpread::ball) {
    const double c = 2.0 * unit_value(terms.seed, birth, 3) - 1.0;
    const SinCos turn = sincos(two_pi * unit_value(terms.seed, birth, 4));
    double u = unit_value(terms.seed, birth, 5);  // the largest of three is spread like a distance within a ball
    for (const std::uint32_t axis : {6U, 7U}) {
      const double other = unit_value(terms.seed, birth, axis);
      u = other > u ? other : u;
    }
    const double r = terms.radius * u;
    const double s = r * std::sqrt(1.0 - c * c);
    v = {v[0] + s * turn.cos, v[1] + s * turn.sin, v[2] + r * c};
  }
  if (terms.spread == EmissionSpread::box) {
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] = v[k] + terms.half_sides[k] * (2.0 * unit_value(terms.seed, birth, static_cast<std::uint32_t>(3 + k)) - 1.0);
    }
  }
  return v;
}

inline void emit(const EmissionTerms& terms, const Births& births, Born& born) noexcept {
  for (std::size_t i = 0; i < births.count; ++i) {
    const std::uint64_t birth = births.first + i;
    const Vec3 x = birth_place(terms, birth), v = birth_velocity(terms, birth);
    double rest = (births.lead - static_cast<double>(i)) * terms.interval;
    rest = rest < 0.0 ? 0.0 : rest;
    rest = rest > births.step ? births.step : rest;
    for (std::size_t k = 0; k < 3; ++k) {
      born.x[k][i] = x[k] + v[k] * rest;
      born.v[k][i] = v[k];
    }
    born.age[i] = rest;
    born.lifetime[i] = terms.lifetime;
    if (terms.lifetime_range > 0) born.lifetime[i] += terms.lifetime_range * unit_value(terms.seed, birth, 8);
  }
}

}  // namespace dvdx::reference
