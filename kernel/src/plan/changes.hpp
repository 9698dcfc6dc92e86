// Changes of a scene while a plan runs: what each refuses, and what it makes of the scene; of a compiled one:
// plan/in_place.cpp.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

// refusal() looks at what names the change's place; the values are checked with the scene that it makes.

struct GridStiffnessChange {
  std::size_t network;
  GridStiffness stiffness;
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};

struct SpringsStiffnessChange {
  std::size_t network;
  const SpringsStiffness& stiffness;
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};

struct ZeroLengthChange {
  std::size_t network;
  const Scalars& zero_length;
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};
// The zero_length that add_bending() makes of a network's own pairs; an error where it needs others.
[[nodiscard]] Expected<Scalars> zero_length_of(const Scene& scene, std::size_t network, std::span<const Triangle> triangles,
                                               std::span<const Vec3> flat, double modulus);

// The error in a network in place of networks[index]: it joins other particles. Its values are checked with the scene.
[[nodiscard]] std::optional<Error> refusal_of(const Scene& scene, std::size_t index, const Network& network);
// It, with the springs torn that are.
[[nodiscard]] Network with_broken_of(const Network& before, Network network);

struct MassChange {
  std::size_t particle;
  double mass;  // kg
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};

struct PinChange {
  std::size_t particle;
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};

struct ReleaseChange {
  std::size_t particle;
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};

struct TearChange {
  std::size_t network;
  std::span<const Pair> ends;
  [[nodiscard]] std::optional<Error> refusal(const Scene& scene, std::optional<std::size_t> count) const;
  void apply(Scene& scene, std::size_t count) const;
};

}  // namespace dvdx
