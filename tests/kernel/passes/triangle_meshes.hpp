// Test setups of bodies made of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/falling_cloud.hpp"
#include "math/vec3.hpp"

namespace triangle_meshes {

using namespace dvdx;
using test::cloud;
using test::gravity;
using test::Joined;
using test::touched;

inline TriangleMesh box_of_triangles(const Vec3& center, const Vec3& half) {
  TriangleMesh mesh;
  for (std::size_t n = 0; n < 8; ++n) {
    mesh.vertices.push_back({center[0] + ((n & 1) != 0 ? half[0] : -half[0]), center[1] + ((n & 2) != 0 ? half[1] : -half[1]),
                             center[2] + ((n & 4) != 0 ? half[2] : -half[2])});
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// 20 * 4^levels triangles with their corners on the sphere.
inline TriangleMesh ball_of_triangles(const Vec3& center, double radius, int levels) {
  constexpr double t = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) {
        Vec3 v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = (mesh.vertices[a][k] + mesh.vertices[b][k]) / 2;
        mesh.vertices.push_back(v);
      }
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  for (Vec3& v : mesh.vertices) {
    const double scale = radius / length(v);
    for (std::size_t k = 0; k < 3; ++k) v[k] = center[k] + scale * v[k];
  }
  return mesh;
}

// A box without one quarter along z, which leaves a concave edge.
inline TriangleMesh angle_of_triangles() {
  TriangleMesh mesh;
  const std::vector<std::array<double, 2>> outline = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {-0.5, 0.5}) {
    for (const auto& [x, y] : outline) mesh.vertices.push_back({x, y, z});
  }
  for (std::uint32_t k = 0; k < 6; ++k) {
    const std::uint32_t next = (k + 1) % 6;
    mesh.triangles.push_back({k, next, next + 6});
    mesh.triangles.push_back({k, next + 6, k + 6});
  }
  for (const auto& [a, b, c] : std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({a + 6, b + 6, c + 6});
    mesh.triangles.push_back({a, c, b});
  }
  return mesh;
}

}  // namespace triangle_meshes
