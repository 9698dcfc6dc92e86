// Changes of a scene while a plan runs: their refusals and edits. Edits of a compiled scene: plan/in_place.cpp.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

// refusal() checks the place of a change, and a mass. Other values are checked with the scene that the change makes.

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
// The zero_length that add_bending() makes of a network's own pairs; an error if it needs other pairs.
[[nodiscard]] Expected<Scalars> zero_length_of(const Scene& scene, std::size_t network, std::span<const Triangle> triangles,
                                               std::span<const Vec3> flat, double modulus);

// An error unless `network` has the kind, particles and rest lengths of networks[index]. Values are checked with the scene.
[[nodiscard]] std::optional<Error> refusal_of(const Scene& scene, std::size_t index, const Network& network);
// `network` with the torn springs of `before`.
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
