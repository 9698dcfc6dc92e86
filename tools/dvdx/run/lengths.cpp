#include "run/lengths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "run/stored_springs.hpp"

namespace dvdx::tool {
namespace {

template <class T>
double square_between(const State<T>& state, std::size_t i, std::size_t j) {
  double square = 0;
  for (const auto& x : state.x) {
    const double d = static_cast<double>(x[j]) - static_cast<double>(x[i]);
    square += d * d;
  }
  return square;
}

// m: a few units in the last place of the largest coordinate.
template <class T>
double off_by_rounding(const State<T>& state) {
  constexpr double units = 16;
  double largest = 0;
  for (const auto& x : state.x) {
    for (std::size_t i = 0; i < state.count; ++i) largest = std::max(largest, std::abs(static_cast<double>(x[i])));
  }
  return units * static_cast<double>(std::numeric_limits<T>::epsilon()) * largest;
}

template <class T>
void look_at(const SceneFile& file, const Network& network, const State<T>& state, double off, Lengths& found) {
  const std::vector<Pair> torn = torn_springs(network);
  double stiffness = 0;
  const auto look = [&](std::size_t count, const auto& spring_at) {
    for (std::size_t n = 0; n < count; ++n) {
      const StoredSpring s = spring_at(n);
      if (is_torn(torn, s.i, s.j)) continue;
      const double r2 = square_between(state, s.i, s.j);
      const double r = std::sqrt(r2);
      stiffness += s.stiffness;
      found.elastic += 0.5 * (s.stiffness * (r - s.rest_length) * (r - s.rest_length) + s.zero_length * r2);
      if (s.stiffness > 0 && s.rest_length > 0 && r > found.stretch * s.rest_length) {
        found.stretch = r / s.rest_length;
        found.spring = ascending(s.i, s.j);
      }
    }
  };
  std::visit([&](const auto& of) { for_each_kind<T>(file, of, look); }, network);
  found.rounding += 0.5 * stiffness * off * off;
}

double off_by(Bound bound, double part) {
  switch (bound) {
    case Bound::equal:
      return std::abs(part - 1);
    case Bound::at_most:
      return std::max(part - 1, 0.0);
    case Bound::at_least:
      return std::max(1 - part, 0.0);
  }
  return 0;
}

template <class T>
void look_at(const SceneFile& file, std::size_t constraint, const State<T>& state, Lengths& found) {
  const auto* const distance = std::get_if<Distance>(&file.scene.constraints[constraint]);
  if (distance == nullptr) return;
  for (std::size_t n = 0; n < distance->pairs.size(); ++n) {
    const auto [i, j] = distance->pairs[n];
    const double length =
        distance->length ? (*distance->length)[n] : length_between(start_of<T>(file, i), start_of<T>(file, j));
    const double off = off_by(distance->bound, std::sqrt(square_between(state, i, j)) / length);
    if (off > found.off) {
      found.off = off;
      found.rod = ascending(i, j);
      found.constraint = constraint;
    }
  }
}

}  // namespace

template <class T>
Lengths lengths_of(const SceneFile& file, std::span<const Network> networks, const State<T>& state) {
  Lengths found;
  const double off = networks.empty() ? 0 : off_by_rounding(state);
  for (const Network& network : networks) look_at(file, network, state, off, found);
  for (std::size_t k = 0; k < file.scene.constraints.size(); ++k) look_at(file, k, state, found);
  return found;
}

template Lengths lengths_of(const SceneFile&, std::span<const Network>, const State<float>&);
template Lengths lengths_of(const SceneFile&, std::span<const Network>, const State<double>&);

}  // namespace dvdx::tool
