// Leapfrog in its simplest form: an array of structs and a list of springs.
#include <cmath>

#include "peers/peer.hpp"

namespace dvdx::bench {
namespace {

struct Vector {
  float x = 0, y = 0, z = 0;
};

struct Node {
  Vector x, v, force;
  float inverse_mass = 0;
};

struct Spring {
  std::uint32_t a, b;
  float stiffness, rest;
};

struct System {
  std::vector<Node> nodes;
  std::vector<Spring> springs;

  void sum_forces() {
    for (Node& node : nodes) node.force = {};
    for (const Spring& spring : springs) {
      Node& a = nodes[spring.a];
      Node& b = nodes[spring.b];
      const float x = b.x.x - a.x.x, y = b.x.y - a.x.y, z = b.x.z - a.x.z;
      const float length = std::sqrt(x * x + y * y + z * z);
      const float factor = spring.stiffness * (length - spring.rest) / length;
      a.force.x += factor * x;
      a.force.y += factor * y;
      a.force.z += factor * z;
      b.force.x -= factor * x;
      b.force.y -= factor * y;
      b.force.z -= factor * z;
    }
  }
  void kick(float h) {
    for (Node& node : nodes) {
      if (node.inverse_mass == 0) continue;
      node.v.x += h * node.force.x * node.inverse_mass;
      node.v.y += h * (node.force.y * node.inverse_mass - static_cast<float>(gravity));
      node.v.z += h * node.force.z * node.inverse_mass;
    }
  }
  void drift(float h) {
    for (Node& node : nodes) {
      node.x.x += h * node.v.x;
      node.x.y += h * node.v.y;
      node.x.z += h * node.v.z;
    }
  }
  void step_frame(int substeps) {
    const float h = static_cast<float>(frame_time / substeps);
    drift(h / 2);
    for (int i = 1; i <= substeps; ++i) {
      sum_forces();
      kick(h);
      drift(i < substeps ? h : h / 2);
    }
  }
};

System system_of(const Cloth& cloth) {
  System system;
  const std::size_t n = cloth.nodes();
  const auto at = [n](const std::vector<double>& p, std::size_t i) {
    return Vector{static_cast<float>(p[i]), static_cast<float>(p[n + i]), static_cast<float>(p[2 * n + i])};
  };
  for (std::size_t i = 0; i < n; ++i) {
    system.nodes.push_back({at(cloth.start.x, i), at(cloth.start.v, i), {}, static_cast<float>(cloth.inverse_mass[i])});
  }
  for (const Edge& edge : cloth.edges) {
    system.springs.push_back({edge.a, edge.b, static_cast<float>(cloth.stiffness), static_cast<float>(edge.rest)});
  }
  return system;
}

Motion motion_of(const System& system) {
  Motion motion;
  for (const auto axis : {&Vector::x, &Vector::y, &Vector::z}) {
    for (const Node& node : system.nodes) motion.x.push_back(static_cast<double>(node.x.*axis));
    for (const Node& node : system.nodes) motion.v.push_back(static_cast<double>(node.v.*axis));
  }
  return motion;
}

tl::expected<Outcome, std::string> run(const Cloth& cloth, int substeps, double seconds) {
  System system = system_of(cloth);
  const double taken = time_once([&] {
    for (std::size_t i = 0; i < steps_of(seconds, 1); ++i) system.step_frame(substeps);
  });
  return Outcome{motion_of(system), taken};
}

}  // namespace

Peers plain_leapfrog_peers() { return {{"leapfrog, array of structs, f32", "sub-steps", leapfrog_ladder, run}}; }

}  // namespace dvdx::bench
