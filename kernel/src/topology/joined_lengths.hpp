// Lengths of a scene's springs and distance constraints, and its torn springs: what checks of a state need besides the scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "dvdx/scene.hpp"

namespace dvdx {

// Changes of a plan keep these lengths.
class JoinedLengths {
 public:
  // The scene must have been checked. start: the particles' positions.
  JoinedLengths(const Scene& scene, std::span<const Vec3> start);

  // Returns, in m, the shortest rest length or constrained distance above 0; infinity if there is none.
  [[nodiscard]] double shortest() const noexcept { return shortest_; }
  // Returns, in m, the length of pair n: the scene's, or the distance at the start if the scene leaves it open.
  [[nodiscard]] double of(const Springs& springs, std::size_t network, std::size_t n) const noexcept {
    return springs.rest_length ? (*springs.rest_length)[n] : networks_[network][n];
  }
  [[nodiscard]] double of(const Distance& distance, std::size_t constraint, std::size_t n) const noexcept {
    return distance.length ? (*distance.length)[n] : constraints_[constraint][n];
  }

 private:
  void meet(double length) noexcept {
    if (length > 0 && length < shortest_) shortest_ = length;
  }

  std::vector<std::vector<double>> networks_, constraints_;  // of each, or none if the scene has the lengths
  double shortest_ = std::numeric_limits<double>::infinity();
};

[[nodiscard]] Pair ascending(const Pair& ends) noexcept;

// The springs of one network that are torn.
class TornSprings {
 public:
  // particles: their number.
  TornSprings(std::span<const Pair> torn, std::size_t particles);
  // Takes memory for `more` springs, so that adding them cannot fail.
  void reserve(std::size_t more, std::size_t particles);
  void add(std::span<const Pair> torn) noexcept;

  [[nodiscard]] bool empty() const noexcept { return ends_.empty(); }
  [[nodiscard]] bool hold(std::size_t a, std::size_t b) const noexcept { return !empty() && find(a, b); }
  // Whether a torn spring leads from a particle in [first, end) to one of a higher number.
  [[nodiscard]] bool lead_from(std::size_t first, std::size_t end) const noexcept { return !empty() && find_from(first, end); }

 private:
  [[nodiscard]] bool find(std::size_t a, std::size_t b) const noexcept;
  [[nodiscard]] bool find_from(std::size_t first, std::size_t end) const noexcept;

  std::vector<Pair> ends_;                // each ascending, and so is the list
  std::vector<std::uint8_t> has_any_at_;  // of each particle; empty if nothing is torn
};

}  // namespace dvdx
