#include "scene_io/contact_reader.hpp"

#include <cstddef>
#include <variant>

#include "scene_io/described.hpp"
#include "scene_io/mesh_reader.hpp"

namespace dvdx::tool {
namespace {

// Reads polygons as fans of triangles from their first corner.
void read_surface(const Fields& fields, SceneFolder& folder, TriangleMesh& mesh) {
  const MeshFile file = mesh_of(fields.required("file"), folder);
  mesh.vertices = file.vertices;
  for (const auto& face : file.faces) {
    for (std::size_t k = 2; k < face.size(); ++k) mesh.triangles.push_back({face[0], face[k - 1], face[k]});
  }
  mesh.cell = fields.number("cell", Range::positive, 0);
}

}  // namespace

Contact read_contact(const Node& node, const MotionNames& motions, SceneFolder& folder) {
  auto contact = DescribedReader{.motions = &motions}.read_one_of<Contact>(node, "contact");
  if (auto* mesh = std::get_if<TriangleMesh>(&contact)) read_surface(fields_of<TriangleMesh>(node), folder, *mesh);
  return contact;
}

void read_push_out(const Node& node, Scene& scene) {
  const double speed = node.number(Range::positive);
  if (scene.contacts.empty()) node.refuse("left out of a scene without contacts");
  for (Contact& contact : scene.contacts) {
    std::visit([speed](auto& surface) { surface.push_out = surface.push_out.value_or(speed); }, contact);
  }
}

}  // namespace dvdx::tool
