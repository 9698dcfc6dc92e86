// Networks: the particles that they make and join, and which of these are fixed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "scene_io/mesh_welding.hpp"
#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

// A network as it is read. A grid or a mesh makes its own particles, springs make none.
struct MadeNetwork {
  std::size_t first = 0;             // index of its first particle
  std::size_t first_number = 0;      // the first number that names one of them
  std::size_t columns = 0;           // of a grid, otherwise 0
  std::optional<Network> network{};  // none if nothing is joined
  std::optional<Distance> strain_limit{};
  Topology topology{};
};

// The particles of a grid or a mesh.
struct MadeParticles {
  std::size_t count = 0;
  Vectors positions{};    // m
  double mass = 0;        // kg, of each
  Numbering numbering{};  // from 0 on
};

class NetworkReader {
 public:
  // Reads the grids and meshes of `network`, one object or a list of them. Their particles are numbered consecutively, and must
  // find room.
  NetworkReader(const Node& network, SceneFolder& folder, const Room& room, ReadTopology topology);

  [[nodiscard]] bool makes_particles() const noexcept { return !particles_.empty(); }
  [[nodiscard]] std::size_t count() const noexcept;    // of the particles it makes
  [[nodiscard]] std::size_t numbers() const noexcept;  // that name them
  // Returns the particles' own numbering if each has one number.
  [[nodiscard]] Numbering numbering() const;
  // Call these only if makes_particles(). take_positions() hands the positions over, so it may be called once.
  [[nodiscard]] Vectors take_positions();
  [[nodiscard]] Scalars masses() const;

  // Reads the rest, which may name any of a scene's particles, and hands all networks, their coupling, their fixed particles
  // and their topology over to the scene, once. A network that names no method has the scene's.
  void add_to(SceneFile& file, const Population& population);

  // Reads numbers of particles, or the words for those of the first grid.
  [[nodiscard]] std::vector<std::size_t> read_group(const Node& node, const Population& population) const;

 private:
  void make_grid(const Node& node, MadeNetwork& made);
  void make_mesh(const Node& node, MadeNetwork& made);
  void look_at(const Node& mesh, const MeshFacts& facts);
  // hull: no particle is farther out along an axis than one of these points. mass: kg, of each particle.
  void look_at_units(const Node& sheet, std::span<const Vec3> hull, double mass);
  // made.mass: of all particles together.
  void add_particles(const Node& node, MadeParticles made);

  std::vector<Node> nodes_;
  SceneFolder& folder_;
  Room room_;
  ReadTopology topology_;
  std::vector<MadeNetwork> made_;  // one for each node
  std::vector<MadeParticles> particles_;
  std::vector<MeshNetwork> meshes_;
  std::vector<Warning> warnings_;
};

// Throws Fault (bad_scene) if springs tear: `command` steps only scenes in which they do not.
void refuse_tearing(const SceneFile& file, std::string_view command);

}  // namespace dvdx::tool
