// The numbers by which a scene file and its output name particles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx::tool {

// Each vertex of a mesh has a number, also if several are one particle or if it is left out.
struct Numbering {
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> particles{};  // of each number; nobody: it is left out. Empty: numbers are the particles' own
  std::vector<std::uint32_t> numbers{};    // the first of each particle
  std::vector<Vec3> still{};               // m: positions of the numbers that are left out, in order

  [[nodiscard]] bool is_own() const noexcept { return particles.empty(); }
  [[nodiscard]] std::size_t number_of(std::size_t particle) const noexcept { return is_own() ? particle : numbers[particle]; }
  [[nodiscard]] Pair numbers_of(const Pair& ends) const noexcept {
    return {static_cast<std::uint32_t>(number_of(ends[0])), static_cast<std::uint32_t>(number_of(ends[1]))};
  }
};

// Returns a point for every number, by the points of the particles.
[[nodiscard]] inline std::vector<Vec3> by_number(const std::vector<Vec3>& of_particles, const Numbering& numbering) {
  if (numbering.is_own()) return of_particles;
  std::vector<Vec3> points;
  points.reserve(numbering.particles.size());
  auto still = numbering.still.begin();
  for (const auto particle : numbering.particles)
    points.push_back(particle == Numbering::nobody ? *still++ : of_particles[particle]);
  return points;
}

}  // namespace dvdx::tool
