// Greedy colouring: items of one colour share no particle, and may be worked on side by side.
#pragma once

#include <cstddef>
#include <vector>

namespace dvdx {

// Takes items one after the other. Each gets the first colour that none of its particles has, and that it may take.
class Colouring {
 public:
  explicit Colouring(std::size_t particles) : taken_(particles) {}

  // Fixed particles may be left out of the list, and then take no colour. may_take(colour) may refuse one.
  template <class Particles, class MayTake>
  std::size_t add(const Particles& particles, const MayTake& may_take) {
    std::size_t colour = 0;
    while (is_taken(particles, colour) || !may_take(colour)) ++colour;
    for (const auto i : particles) {
      if (taken_[i].size() <= colour) taken_[i].resize(colour + 1, false);
      taken_[i][colour] = true;
    }
    return colour;
  }
  template <class Particles>
  std::size_t add(const Particles& particles) {
    return add(particles, [](std::size_t) { return true; });
  }

 private:
  template <class Particles>
  [[nodiscard]] bool is_taken(const Particles& particles, std::size_t colour) const {
    for (const auto i : particles) {
      if (colour < taken_[i].size() && taken_[i][colour]) return true;
    }
    return false;
  }

  std::vector<std::vector<bool>> taken_;  // of each particle, by colour
};

}  // namespace dvdx
