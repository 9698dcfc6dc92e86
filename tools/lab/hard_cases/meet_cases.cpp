// Cloth that meets itself and other cloth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hard_cases/cases.hpp"
#include "hard_cases/trial.hpp"
#include "scene_io/counter_random.hpp"
#include "watch/crossings.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double cell = 0.01;  // m
constexpr int seeds = 3;

// Cloth with cells of 1 cm and 49 mg, as in a towel.
Scene cloth_on_floor() {
  Scene scene;
  scene.mass = 4.9e-5;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Contact{Plane{.friction = 0.5, .thickness = 0.005}});
  scene.coupling.scheme = Scheme::sequential;
  scene.add(Meet{.thickness = 0.95 * cell, .friction = 0.3, .rounds = 16, .most_neighbours = 64});
  return scene;
}
void add_sheet(Scene& scene, std::size_t first, std::size_t rows, std::size_t columns, const Vec3& down) {
  const auto along = [](const Vec3& of, std::size_t count) {
    const double length = cell * static_cast<double>(count - 1);
    return Vec3{length * of[0], length * of[1], length * of[2]};
  };
  scene.add(Network{Grid{.rows = rows,
                         .columns = columns,
                         .first = first,
                         .edge_u = along({1, 0, 0}, columns),
                         .edge_v = along(down, rows),
                         .structural = 400,
                         .shear = 100,
                         .bend = 4,
                         .damping = 0.005}});
}

double drawn(int seed, std::size_t i, std::uint32_t axis) {
  return uniform_value(-1, 1, static_cast<std::uint64_t>(seed), i, axis);
}

// Returns the largest number, over all frames, of edges that pass through triangles.
template <class T>
std::size_t crossings_of(Trial<T>& trial, const Scene& scene, int frames) {
  Crossings crossings(cloth_triangles(scene));
  std::size_t most = 0;
  for (int frame = 0; frame < frames; ++frame) {
    trial.step();
    most = std::max(most, crossings.count(trial.state()));
  }
  return most;
}

// A sheet is released upright above a floor, slightly disturbed out of its plane.
template <class T, int substeps>
Worst crumples(CaseRun& way) {
  constexpr std::size_t rows = 32, columns = 10;
  constexpr int frames = 60;
  Worst worst;
  for (int seed = 0; seed < seeds; ++seed) {
    Scene scene = cloth_on_floor();
    scene.coupling.substeps = substeps;
    add_sheet(scene, 0, rows, columns, {0, -1, 0});
    std::vector<Start> starts;
    for (std::size_t i = 0; i < rows * columns; ++i) {
      const double up = cell * static_cast<double>(rows - i / columns);
      const double lean = 0.05 * (1 + drawn(seed, 0, 3)) * up;
      starts.push_back({{cell * static_cast<double>(i % columns), 0.02 + up, lean + 0.02 * cell * drawn(seed, i, 0)}, {}});
    }
    Trial<T> trial(way, scene, hz60, starts);
    worst.see(static_cast<double>(crossings_of(trial, scene, frames)), fmt::format("start {}", seed));
  }
  return worst;
}

// A sheet falls across the border of another one that lies on the floor. The two are turned against each other.
template <class T>
Worst falls_on_another(CaseRun& way) {
  constexpr std::size_t side = 12;
  constexpr int frames = 40;
  Worst worst;
  for (int seed = 0; seed < seeds; ++seed) {
    Scene scene = cloth_on_floor();
    scene.coupling.substeps = 6;
    add_sheet(scene, 0, side, side, {0, 0, 1});
    add_sheet(scene, side * side, side, side, {0, 0, 1});
    const double turn = drawn(seed, 0, 4);
    std::vector<Start> starts;
    for (std::size_t i = 0; i < 2 * side * side; ++i) {
      const std::size_t k = i % (side * side);
      const double x = cell * (static_cast<double>(k % side) - 5.5);
      const double z = cell * (static_cast<double>(k / side) - 5.5);
      const double bump = 0.02 * cell * drawn(seed, i, 0);
      if (i == k) {
        starts.push_back({{x, 0.006 + bump, z}, {}});
      } else {
        const double c = std::cos(turn), s = std::sin(turn);
        starts.push_back({{c * x - s * z + 0.04 * drawn(seed, 0, 5), 0.06 + bump, s * x + c * z}, {0, -1, 0}});
      }
    }
    Trial<T> trial(way, scene, hz60, starts);
    worst.see(static_cast<double>(crossings_of(trial, scene, frames)), fmt::format("start {}", seed));
  }
  return worst;
}

}  // namespace

std::vector<Case> meet_cases() {
  return {
      {50,
       "cloth that folds",
       "sheets of 1 cm cells fall on a floor upright, and on each other: edges that go through triangles at any frame",
       {{float64, crumples<double, 10>, 0, "crossings", "upright, 10 sub-steps: none"},
        {float32, crumples<float, 10>, 0, "crossings", "upright, 10 sub-steps: none"},
        {float64, falls_on_another<double>, 0, "crossings", "on each other, 6 sub-steps: none"},
        {float32, falls_on_another<float>, 0, "crossings", "on each other, 6 sub-steps: none"}}},
  };
}

}  // namespace dvdx::tool::stability
