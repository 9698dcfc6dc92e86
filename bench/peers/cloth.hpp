// The hanging cloth that every library simulates, and its reference.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvdx/values.hpp"

namespace dvdx::bench {

inline constexpr double gravity = 9.81;         // m/s^2, along -y
inline constexpr double cloth_side = 2;         // m
inline constexpr double cloth_mass = 1;         // kg, shared evenly by the nodes
inline constexpr double frame_time = 1.0 / 60;  // s

struct Edge {
  std::uint32_t a, b;
  double rest;  // m
};

// Positions and velocities: all x, then all y, then all z.
struct Motion {
  std::vector<double> x, v;
};

// size by size nodes; node (row, column) has the index row * size + column. All edges, including diagonals, are springs of one
// stiffness.
struct Cloth {
  char scene = 'H';  // H: flat, two corners of the first row fixed; C: 30 degrees from the vertical, the first row fixed
  std::size_t size = 32;
  double stiffness = 1e4;   // N/m
  Vec3 edge_u{}, edge_v{};  // m, along the whole sheet
  std::vector<Edge> edges;
  std::vector<std::size_t> fixed;
  std::vector<double> inverse_mass;  // 1/kg, 0 for fixed nodes
  Motion start;
  double frequency = 0;  // rad/s, the highest frequency of the springs at the start

  [[nodiscard]] std::size_t nodes() const { return size * size; }
  [[nodiscard]] double node_mass() const { return cloth_mass / static_cast<double>(nodes()); }
  [[nodiscard]] double spacing() const { return cloth_side / static_cast<double>(size - 1); }
  // Leapfrog's sub-steps a frame at its stability limit.
  [[nodiscard]] double limit() const { return frequency * frame_time / 2; }
};

[[nodiscard]] Cloth make_cloth(char scene, std::size_t size, double stiffness);

struct Deviation {
  double position = 0;  // root mean square over the nodes, relative to the side
  double energy = 0;    // relative to m g side, signed
};

// The motion after `seconds`, by a fourth-order splitting in double precision. Its step is halved until the positions settle.
struct Reference {
  Motion motion;
  double energy = 0;  // J
  double change = 0;  // by the last halving, relative to the side: 15 times the remaining error
  int substeps = 0;   // a frame
};

[[nodiscard]] Reference reference_of(const Cloth& cloth, double seconds, double tolerance);
[[nodiscard]] double energy_of(const Cloth& cloth, const Motion& motion);
[[nodiscard]] Deviation deviation_of(const Cloth& cloth, const Motion& motion, const Reference& reference);

}  // namespace dvdx::bench
