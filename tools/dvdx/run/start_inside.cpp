#include "run/start_inside.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>
#include <vector>

#include "dvdx/drawing.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t at_once = 4096;  // particles
constexpr double instant = 1e-9;       // s: in which nothing comes anywhere but by being put out

std::vector<bool> free_ones(const Scene& scene, std::size_t count) {
  std::vector<bool> are_free(count, true);
  for (const std::size_t i : scene.fixed) are_free[i] = false;
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) are_free[i] = false;
  }
  return are_free;
}

template <class T>
double extent_of(const State<T>& state) {
  const Bounds box = bounds(state);
  return std::max({box.most[0] - box.least[0], box.most[1] - box.least[1], box.most[2] - box.least[2]});
}

// Whether any particle is in the box about the mesh, whose distances take long to sample.
template <class T>
bool is_any_near(const TriangleMesh& mesh, const State<T>& state, const Vec3& origin) {
  Vec3 low = mesh.vertices.front();
  Vec3 high = low;
  for (const Vec3& vertex : mesh.vertices) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], vertex[axis] - mesh.thickness);
      high[axis] = std::max(high[axis], vertex[axis] + mesh.thickness);
    }
  }
  for (std::size_t i = 0; i < state.count; ++i) {
    bool is_within = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = static_cast<double>(state.x[axis][i]) + origin[axis];
      is_within = is_within && x >= low[axis] && x <= high[axis];
    }
    if (is_within) return true;
  }
  return false;
}

// The surfaces alone that particles may start in.
template <class T>
Scene surfaces_of(const Scene& scene, const State<T>& state) {
  Scene surfaces;
  surfaces.motions = scene.motions;
  surfaces.origin = scene.origin;
  for (const Contact& contact : scene.contacts) {
    const auto* const mesh = std::get_if<TriangleMesh>(&contact);
    if (mesh == nullptr || mesh->motion || is_any_near(*mesh, state, scene.origin.at(0))) surfaces.contacts.push_back(contact);
  }
  return surfaces;
}

}  // namespace

template <class T>
std::optional<StartInside> start_inside(const SceneFile& file, const State<T>& state) {
  const Scene& scene = file.scene;
  if (scene.contacts.empty() || (scene.networks.empty() && scene.constraints.empty())) return std::nullopt;
  const Scene surfaces = surfaces_of(scene, state);
  if (surfaces.contacts.empty()) return std::nullopt;
  Soa<double> memory(std::min(at_once, state.count));
  State<double> some = memory.view();
  auto plan = compile<double>(surfaces, {.step = instant}, some);
  if (!plan) throw std::logic_error(plan.error().message());
  const std::vector<bool> are_free = free_ones(scene, state.count);
  StartInside inside{.limit = std::max(1e-4 * extent_of(state), 1e-6)};
  for (std::size_t first = 0; first < state.count; first += some.count) {
    const auto particle = [&](std::size_t i) { return std::min(first + i, state.count - 1); };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < some.count; ++i) {
        some.x[axis][i] = static_cast<double>(state.x[axis][particle(i)]);
        some.v[axis][i] = 0;
      }
    }
    some.clock = state.clock;
    if (plan->step(some, 1) != StepResult::done) throw std::logic_error("the plan is for another state");
    for (std::size_t i = 0; first + i < state.count && i < some.count; ++i) {
      Vec3 way;
      for (std::size_t axis = 0; axis < 3; ++axis) way[axis] = some.x[axis][i] - static_cast<double>(state.x[axis][first + i]);
      const double depth = std::hypot(way[0], way[1], way[2]);
      if (!are_free[first + i] || !(depth > inside.limit)) continue;
      ++inside.particles;
      if (depth > inside.depth) inside = {inside.particles, first + i, way, depth, inside.limit};
    }
  }
  return inside.particles != 0 ? std::optional(inside) : std::nullopt;
}

template std::optional<StartInside> start_inside(const SceneFile&, const State<float>&);
template std::optional<StartInside> start_inside(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
