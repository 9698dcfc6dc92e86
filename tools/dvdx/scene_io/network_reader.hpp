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

// The particles that a network makes: a grid or a mesh its own, springs none.
struct MadeNetwork {
  std::size_t first = 0;             // of its particles
  std::size_t first_number = 0;      // that names one of them
  std::size_t columns = 0;           // of a grid, else 0
  std::optional<Network> network{};  // none where nothing is joined
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
  // Reads the grids and meshes of `network`, one object or a list of them. Their particles are numbered on from one another,
  // and must find room.
  NetworkReader(const Node& network, SceneFolder& folder, const Room& room, ReadTopology topology);

  [[nodiscard]] bool makes_particles() const noexcept { return !particles_.empty(); }
  [[nodiscard]] std::size_t count() const noexcept;    // of the particles it makes
  [[nodiscard]] std::size_t numbers() const noexcept;  // that name them
  // Its own where each particle has one number.
  [[nodiscard]] Numbering numbering() const;
  // Only where makes_particles(). take_positions() may be called once: it hands them over.
  [[nodiscard]] Vectors take_positions();
  [[nodiscard]] Scalars masses() const;

  // Reads what remains, which may name any of a scene's particles, and hands all networks, their coupling, their fixed
  // particles and their topology over to the scene, once. A network's method is the scene's where it names none.
  void add_to(SceneFile& file, const Population& population);

  // Numbers of particles, or the words for those of the first grid.
  [[nodiscard]] std::vector<std::size_t> read_group(const Node& node, const Population& population) const;

 private:
  void make_grid(const Node& node, MadeNetwork& made);
  void make_mesh(const Node& node, MadeNetwork& made);
  void look_at(const Node& mesh, const MeshFacts& facts);
  // hull: no particle is farther out along an axis than one of them. mass: kg, of each particle.
  void look_at_units(const Node& sheet, std::span<const Vec3> hull, double mass);
  // made.mass: of all of them.
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

// Throws Fault (bad_scene) where springs tear: `command` steps scenes in which they do not.
void refuse_tearing(const SceneFile& file, std::string_view command);

}  // namespace dvdx::tool
