// The contents of a scene file: the library's scene, and how the particles start.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "dvdx/scene.hpp"
#include "dvdx/turnover.hpp"
#include "scene_io/chunked.hpp"
#include "scene_io/mesh_welding.hpp"
#include "scene_io/numbering.hpp"
#include "scene_io/topology.hpp"

namespace dvdx::tool {

using Vec3f = std::array<float, 3>;

struct UniformVectors {
  Vec3 min{};
  Vec3 max{};
  std::uint64_t seed = 0;
  std::size_t first = 0;  // number of the particle that is drawn as the first of these
  bool operator==(const UniformVectors&) const = default;
};

// Even steps along the edges of a sheet, row after row.
struct SheetVectors {
  std::size_t rows = 1, columns = 1;
  Vec3 origin{}, edge_u{}, edge_v{};
  bool operator==(const SheetVectors&) const = default;
};

// One for all, one each, one each as a file holds it, drawn for each, or computed for each.
using Vectors = std::variant<Vec3, std::vector<Vec3>, Chunked<Vec3>, Chunked<Vec3f>, UniformVectors, SheetVectors>;

[[nodiscard]] Vec3 value_of(const Vectors& vectors, std::size_t particle);

struct Particles {
  std::size_t count = 0;
  // If several ranks hold a scene's particles, this one has those from `first` on, and the others have `elsewhere` of them.
  std::size_t first = 0;
  std::size_t elsewhere = 0;
  Vectors position = Vec3{};  // m
  Vectors velocity = Vec3{};  // m/s

  [[nodiscard]] std::size_t total() const noexcept { return count + elsewhere; }
};

// A scene that runs, but is seldom meant so.
struct Warning {
  std::string code;  // "unreferenced_vertices": the same in every version
  std::string text;  // the thing that is wrong, with its place
  double value = 0;  // that was found
  double limit = 0;  // that would be acceptable
  std::string cure;
};

// A mesh that a scene has as a network.
struct MeshNetwork {
  std::string file;  // as the scene names it
  MeshFacts facts;
};

struct SceneFile {
  std::string path;                              // as the user named it
  std::vector<std::filesystem::path> sources{};  // all files that the scene was read from, its own among them
  std::string name;
  std::string about;
  double step = 0;      // s
  double duration = 0;  // s
  Particles particles;
  Scene scene;  // masses, forces, contacts, networks, constraints, fixed and kinematic particles, motions, skins, meet
  std::vector<std::string> motions{};  // their names
  Topology topology{};                 // of the networks and constraints, by the numbers of the scene
  Numbering numbering{};               // by which the file and its output name particles
  std::vector<MeshNetwork> meshes{};
  // For each network, empty if none tears: springs that are longer than this times their rest length at a step's end tear.
  // Infinite for networks that do not tear. The library's plans do not tear by themselves.
  std::vector<double> tears_at{};
  bool is_origin_free = true;  // the file leaves the origin to the command that runs the scene
  Lifecycle turnover{};        // capacity 0: no particle comes or goes
  std::vector<Warning> warnings{};
};

// Whether particles come and go: such a scene needs a plan of its own (dvdx/live.hpp).
[[nodiscard]] inline bool is_live(const SceneFile& file) noexcept { return file.turnover.capacity != 0; }

// Whether a grid is a net, not cloth: its sides alone hold it together, and air goes through.
[[nodiscard]] inline bool is_net(const Grid& grid) noexcept { return grid.shear == 0 && grid.bend == 0 && !grid.aerodynamics; }

// Whether motions carry particles or contacts.
[[nodiscard]] inline bool has_followers(const Scene& scene) noexcept {
  const auto is_moved = [](const Contact& contact) {
    return std::visit([](const auto& c) { return c.motion.has_value(); }, contact);
  };
  const auto is_carried = [](const Skin& skin) { return skin.motion.has_value(); };
  if (std::any_of(scene.skins.begin(), scene.skins.end(), is_carried)) return true;
  return !scene.kinematic.empty() || std::any_of(scene.contacts.begin(), scene.contacts.end(), is_moved);
}

// Whether particles depend on one another: networks or constraints join them, motions carry some, skins hold them, or they
// meet. Ranks cannot split such a scene by ranges.
[[nodiscard]] inline bool is_joined(const Scene& scene) noexcept {
  return !scene.networks.empty() || !scene.constraints.empty() || !scene.kinematic.empty() || !scene.skins.empty() ||
         scene.meet.has_value();
}

}  // namespace dvdx::tool
