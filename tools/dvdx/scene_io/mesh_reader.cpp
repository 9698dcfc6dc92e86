#include "scene_io/mesh_reader.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/bending.hpp"
#include "scene_io/air_reader.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/json_text.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

constexpr std::array<Named<Unreferenced>, 2> treatments_of_unreferenced{
    {{"leave_out", Unreferenced::left_out}, {"keep", Unreferenced::kept}}};

}  // namespace

MeshFile mesh_of(const Node& node, SceneFolder& folder) {
  if (!node.text().ends_with(".obj")) node.refuse("the name of an .obj file");
  try {
    return read_mesh(folder.find(node));
  } catch (const FileFault& fault) {
    node.fail("is " + shown(node.json()) + ": " + fault.what());
  }
}

WeldedMesh welded(const Fields& fields, const MeshFile& file) {
  const auto given = fields.optional("weld");
  std::optional<double> weld = 0;
  if (given && given->json().is_null()) {
    weld.reset();
  } else if (given) {
    weld = given->number({.min = 0, .text = "a finite number >= 0, or null"});
  }
  return tool::welded(file, weld, fields.choice("unreferenced", treatments_of_unreferenced, Unreferenced::left_out));
}

Springs springs_of(const MeshFile& mesh, std::size_t first, double edge, double bend) {
  Springs springs;
  std::vector<double> stiffness;
  const auto add = [&](const std::vector<Pair>& pairs, double k) {
    if (k == 0) return;
    for (const auto& [i, j] : pairs) {
      springs.pairs.push_back({static_cast<std::uint32_t>(first + i), static_cast<std::uint32_t>(first + j)});
    }
    stiffness.resize(springs.pairs.size(), k);
  };
  add(edges_of(mesh), edge);
  add(diagonals_of(mesh), edge);
  add(bends_of(mesh), bend);
  springs.stiffness = std::move(stiffness);
  return springs;
}

void bend_by_angles(const Fields& fields, const MeshFile& mesh, std::size_t first, Springs& springs) {
  const double modulus = fields.number("bending", Range::non_negative, 0);
  if (modulus == 0) return;
  const auto node = fields.required("bending");
  const Scheme scheme = fields.choice("scheme", schemes, Scheme::leapfrog);
  if (scheme != Scheme::leapfrog && scheme != Scheme::fourth_order && scheme != Scheme::automatic) {
    node.fail("is " + shown(node.json()) + " in the scheme " + std::string(word(scheme)) +
              ": must be left out of another scheme than leapfrog and fourth_order");
  }
  for (const char* key : {"broken", "tears_at"}) {
    if (fields.optional(key))
      node.fail("is " + shown(node.json()) + ": must be left out of a network that tears (" + key + ")");
  }
  std::vector<Vec3> places(first);
  places.insert(places.end(), mesh.vertices.begin(), mesh.vertices.end());
  const std::size_t before = springs.pairs.size();
  add_bending(springs, triangles_of(mesh.faces, first), places, modulus);
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    if (!std::isfinite(springs.zero_length[s]))
      node.fail("is " + shown(node.json()) + ": must be left out where faces have no area");
  }
  if (before == 0 && springs.pairs.empty())
    node.fail("is " + shown(node.json()) + ": must be left out where no two faces share an edge");
}

Distance limit_of(const MeshFile& mesh, std::size_t first, double limit) {
  Distance distance{.pairs = {}, .length = {}, .bound = Bound::at_most};
  std::vector<double> lengths;
  for (const auto& [i, j] : edges_of(mesh)) {
    const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[j];
    distance.pairs.push_back({static_cast<std::uint32_t>(first + i), static_cast<std::uint32_t>(first + j)});
    lengths.push_back((1 + limit) * std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]));
  }
  distance.length = Scalars(std::move(lengths));
  return distance;
}

Topology topology_of(const MeshFile& mesh, std::size_t first) {
  Topology topology{.lines = mesh.lines, .faces = mesh.faces};
  for (auto& [i, j] : topology.lines) {
    i += static_cast<std::uint32_t>(first);
    j += static_cast<std::uint32_t>(first);
  }
  for (auto& face : topology.faces) {
    for (auto& vertex : face) vertex += static_cast<std::uint32_t>(first);
  }
  return topology;
}

}  // namespace dvdx::tool
