#include "watch/start_inside.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "watch/ways_out.hpp"

namespace dvdx::tool {
namespace {

// Whether any particle is in the box around the mesh. If none is, sampling its distances, which takes long, is not needed.
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

// Returns only the surfaces in which particles may start and that put them out within a step.
template <class T>
Scene surfaces_of(const Scene& scene, const State<T>& state) {
  Scene surfaces;
  surfaces.motions = scene.motions;
  surfaces.origin = scene.origin;
  for (const Contact& contact : scene.contacts) {
    if (std::visit([](const auto& of) { return of.push_out.has_value(); }, contact)) continue;
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
  PushOutProbe ways(surfaces, state.count);
  const std::vector<bool> are_free = free_ones(scene, state.count);
  StartInside inside{.limit = least_depth(state)};
  for (std::size_t first = 0; first < state.count; first += PushOutProbe::at_once) {
    const auto out = ways.of(state, first);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Vec3& way = out[i];
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
