// The emission pass, scalar: written by hand beside emission.inl.hpp, the same letters in the same order of operations.
#pragma once

#include <array>
#include <cmath>

#include "dvdx/counter_random.hpp"
#include "lifecycle/pass/emission.hpp"
#include "math/elementary.hpp"

namespace dvdx::reference {

// Four numbers in [0, 1) of a birth, multiples of 2^-32. The counter's last word keeps them apart from a scene's own draws.
inline std::array<double, 4> draw(std::uint64_t seed, std::uint64_t birth, std::uint32_t group) noexcept {
  const auto words = philox4x32({static_cast<std::uint32_t>(birth), static_cast<std::uint32_t>(birth >> 32U), group, 1},
                                {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)});
  std::array<double, 4> numbers{};
  for (std::size_t k = 0; k < 4; ++k) numbers[k] = static_cast<double>(words[k]) * 0x1p-32;
  return numbers;
}

inline Vec3 birth_place(const EmissionTerms& terms, const std::array<double, 4>& u) noexcept {
  Vec3 x = terms.origin;
  if (terms.shape == EmissionShape::disc) {
    const double r = std::sqrt(u[0]);
    const SinCos turn = sincos(two_pi * u[1]);
    const double a = r * turn.cos, b = r * turn.sin;
    for (std::size_t k = 0; k < 3; ++k) x[k] = x[k] + (a * terms.radii[0][k] + b * terms.radii[1][k]);
  }
  if (terms.shape == EmissionShape::box) {
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = x[k] + (terms.most[k] - x[k]) * u[k];
      if (x[k] > terms.most[k]) x[k] = terms.most[k];
    }
  }
  return x;
}

inline Vec3 birth_velocity(const EmissionTerms& terms, std::uint64_t birth) noexcept {
  Vec3 v = terms.velocity;
  if (terms.spread == EmissionSpread::none) return v;
  const std::array<double, 4> u = draw(terms.seed, birth, 1);
  if (terms.spread == EmissionSpread::ball) {
    const double c = 2.0 * u[0] - 1.0;
    const SinCos turn = sincos(two_pi * u[1]);
    double most = u[2];  // the largest of three is spread like a distance within a ball
    for (const double other : {u[3], draw(terms.seed, birth, 2)[0]}) most = other > most ? other : most;
    const double r = terms.radius * most;
    const double s = r * std::sqrt(1.0 - c * c);
    v = {v[0] + s * turn.cos, v[1] + s * turn.sin, v[2] + r * c};
  }
  if (terms.spread == EmissionSpread::box) {
    for (std::size_t k = 0; k < 3; ++k) v[k] = v[k] + terms.half_sides[k] * (2.0 * u[k] - 1.0);
  }
  return v;
}

inline void emit(const EmissionTerms& terms, const Births& births, Born& born) noexcept {
  for (std::size_t i = 0; i < births.count; ++i) {
    const std::uint64_t birth = births.first + i;
    const std::array<double, 4> u = draw(terms.seed, birth, 0);
    const Vec3 x = birth_place(terms, u), v = birth_velocity(terms, birth);
    double rest = (births.lead - static_cast<double>(i)) * terms.interval;
    rest = rest < 0.0 ? 0.0 : rest;
    rest = rest > births.step ? births.step : rest;
    for (std::size_t k = 0; k < 3; ++k) {
      born.x[k][i] = x[k] + v[k] * rest;
      born.v[k][i] = v[k];
    }
    born.age[i] = rest;
    born.lifetime[i] = terms.lifetime_range > 0 ? terms.lifetime + terms.lifetime_range * u[3] : terms.lifetime;
  }
}

}  // namespace dvdx::reference
