// .obj files, and the pairs made from their faces and lines.
#include <algorithm>
#include <cmath>

#include "fuzz/targets.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/mesh_file.hpp"
#include "scene_io/mesh_welding.hpp"

namespace dvdx::fuzz {
namespace {

// Each pair once, the smaller index first, sorted, all of them vertices.
void expect_pairs(const std::vector<Pair>& pairs, std::size_t vertices) {
  for (const Pair& pair : pairs) expect(pair[0] < pair[1] && pair[1] < vertices, "pairs join two different vertices, in order");
  expect(std::is_sorted(pairs.begin(), pairs.end()), "pairs are sorted");
  expect(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end(), "no pair is there twice");
}

}  // namespace

void obj_reader(std::string_view bytes) {
  try {
    const tool::MeshFile mesh = tool::parse_mesh(bytes);
    const std::size_t vertices = mesh.vertices.size();
    expect(vertices > 0, "a mesh has vertices");
    for (const Vec3& vertex : mesh.vertices) {
      for (const double value : vertex) expect(std::isfinite(value), "vertices are finite");
    }
    for (const auto& face : mesh.faces) {
      expect(face.size() >= 3, "a face has three vertices or more");
      for (const auto vertex : face) expect(vertex < vertices, "faces name vertices that are there");
    }
    const tool::WeldedMesh one = tool::welded(mesh, 1e-3, tool::Unreferenced::left_out);
    expect(one.numbering.particles.size() == vertices, "each vertex is a particle's or nobody's");
    expect(one.mesh.vertices.size() == one.numbering.numbers.size(), "each particle has a first vertex");
    for (auto face : one.mesh.faces) {
      expect(face.size() >= 3, "a welded face has three corners or more");
      std::sort(face.begin(), face.end());
      expect(std::adjacent_find(face.begin(), face.end()) == face.end(), "a welded face comes by no particle twice");
      expect(face.back() < one.mesh.vertices.size(), "welded faces name particles that are there");
    }
    expect_pairs(tool::edges_of(one.mesh), one.mesh.vertices.size());
    expect_pairs(tool::edges_of(mesh), vertices);
    expect_pairs(tool::diagonals_of(mesh), vertices);
    expect_pairs(tool::bends_of(mesh), vertices);
  } catch (const tool::FileFault&) {
  }
}

}  // namespace dvdx::fuzz
