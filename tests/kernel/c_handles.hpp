// The functions of dvdx.h for tests: handles that free themselves, the arrays of a state, and scenes that C++ builds too.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"

namespace c_handles {

struct Handles {  // a scene, a plan, and the last error
  dvdx_scene* scene = nullptr;
  dvdx_plan* plan = nullptr;
  dvdx_error error{};

  Handles() { REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) == DVDX_DONE); }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    dvdx_plan_destroy(plan);
    dvdx_scene_destroy(scene);
  }
  [[nodiscard]] std::string field() const { return &error.field[0]; }
  [[nodiscard]] std::string message() const { return &error.message[0]; }
  dvdx_status make(const dvdx_options& options, const dvdx_state* start = nullptr) {
    return dvdx_plan_create(scene, &options, start, &plan, &error);
  }
};

inline dvdx_options options_of(double step, dvdx_precision precision = DVDX_FLOAT32) {
  dvdx_options options{};
  options.step = step;
  options.precision = precision;
  return options;
}

// Six arrays with the same start each time.
template <class T>
struct Arrays {
  std::vector<T> memory;
  std::size_t count;

  explicit Arrays(std::size_t n) : memory(6 * n), count(n) {
    for (std::size_t i = 0; i < n; ++i) {
      memory[i] = static_cast<T>(0.01 * static_cast<double>(i));
      memory[n + i] = 1;
      memory[3 * n + i] = static_cast<T>(0.5);
    }
  }
  T* column(std::size_t k) { return memory.data() + k * count; }
  dvdx_state c() {
    return dvdx_soa(sizeof(T) == 4 ? DVDX_FLOAT32 : DVDX_FLOAT64, column(0), column(1), column(2), column(3), column(4),
                    column(5), count);
  }
  dvdx::State<T> cpp() { return dvdx::soa(column(0), column(1), column(2), column(3), column(4), column(5), count); }
};

// Every force and contact, added through C and through C++.
inline void add_forces(Handles& h) {
  dvdx_constant gravity{};
  gravity.acceleration[1] = -9.81;
  dvdx_sinusoid shake{};
  shake.acceleration[0] = 1;
  shake.angular_frequency = 3;
  shake.phase = 0.5;
  const double terms[] = {0.1, 0, 0, 0, 0, 0.2};
  const dvdx_polynomial push{terms, 2, DVDX_METHOD_DEFAULT};
  const double axes[] = {10, 20, 30};
  dvdx_spring spring{};
  spring.stiffness.axes = &axes[0];
  spring.damping = 0.3;
  spring.anchor.from = DVDX_ANCHOR_AT_START;
  dvdx_radial_spring radial{};
  radial.stiffness.all = 5;
  radial.rest_length.all = 0.5;
  dvdx_drag drag{};
  drag.coefficient.all = 0.02;
  drag.wind[0] = 3;
  drag.method = DVDX_EXACT;
  dvdx_plane plane{};
  plane.normal[1] = 1;
  plane.surface.restitution = 0.4;
  dvdx_sphere sphere{};
  sphere.radius = 50;
  sphere.side = DVDX_INSIDE;
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_polynomial(h.scene, &push, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_sinusoid(h.scene, &shake, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_spring(h.scene, &spring, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_radial_spring(h.scene, &radial, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_drag(h.scene, &drag, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_plane(h.scene, &plane, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_sphere(h.scene, &sphere, &h.error) == DVDX_DONE);
  dvdx_capsule capsule{};
  capsule.ends[0][0] = 4;
  capsule.ends[1][1] = 2;
  capsule.radius[0] = 0.5;
  capsule.radius[1] = 0.25;
  capsule.surface.thickness = 0.125;
  capsule.surface.push_out = 0.75;
  dvdx_box box{};
  box.center[1] = -3;
  for (double& half : box.half_extents) half = 2;
  box.rotation[2] = 0.5;
  const double planes[] = {1, 0, 0, 9, -1, 0, 0, -8, 0, 1, 0, 1, 0, -1, 0, 0, 0, 0, 1, 1, 0, 0, -1, 0};
  dvdx_convex convex{};
  convex.planes = planes;
  convex.count = 6;
  CHECK(dvdx_scene_add_capsule(h.scene, &capsule, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_box(h.scene, &box, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_convex(h.scene, &convex, &h.error) == DVDX_DONE);
  const double corners[] = {-6, 0, 0, -5, 0, 0, -6, 1, 0, -6, 0, 1};
  const std::uint32_t triangles[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  dvdx_mesh mesh{};
  mesh.vertices = corners;
  mesh.count = 4;
  mesh.triangles = triangles;
  mesh.triangle_count = 4;
  mesh.cell = 0.125;
  mesh.surface.restitution = 0.5;
  CHECK(dvdx_scene_add_mesh(h.scene, &mesh, &h.error) == DVDX_DONE);
}

// A hanging row of springs, and constraints on some of its particles.
inline void add_joints(Handles& h) {
  const std::uint32_t pairs[] = {0, 1, 1, 2, 2, 3};
  dvdx_springs springs{};
  springs.pairs = &pairs[0];
  springs.count = 3;
  springs.stiffness.all = 100;
  springs.damping = 0.1;
  dvdx_distance rod{};
  rod.pairs = &pairs[0];
  rod.count = 1;
  const dvdx_on_point point{4, {0.04, 1, 0}};
  const dvdx_on_line line{5, {0, 1, 0}, {1, 0, 0}};
  dvdx_coupling coupling{};
  coupling.substeps = 10;
  const std::size_t fixed[] = {3};
  CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_distance(h.scene, &rod, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_on_point(h.scene, &point, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_add_on_line(h.scene, &line, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_coupling(h.scene, &coupling, &h.error) == DVDX_DONE);
  CHECK(dvdx_scene_set_fixed(h.scene, &fixed[0], 1, &h.error) == DVDX_DONE);
}

inline dvdx::Scene scene_of_joints() {
  using namespace dvdx;
  Scene scene;
  scene.add(Network(Springs{.pairs = {{0, 1}, {1, 2}, {2, 3}}, .stiffness = 100.0, .damping = 0.1}));
  scene.add(Constraint(Distance{.pairs = {{0, 1}}})).add(Constraint(OnPoint{.particle = 4, .at = {0.04, 1, 0}}));
  scene.add(Constraint(OnLine{.particle = 5, .through = {0, 1, 0}}));
  scene.coupling.substeps = 10;
  scene.fixed = {3};
  return scene;
}

}  // namespace c_handles
