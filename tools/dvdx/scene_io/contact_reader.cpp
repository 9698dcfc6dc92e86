#include "scene_io/contact_reader.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "scene_io/mesh_reader.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

std::vector<std::string_view> contact_keys(std::initializer_list<std::string_view> own) {
  std::vector<std::string_view> keys{"type"};
  keys.insert(keys.end(), own);
  keys.insert(keys.end(), {"restitution", "friction", "viscosity", "normal_viscosity", "response", "sweep", "thickness",
                           "push_out", "motion"});
  return keys;
}

template <class C>
C with_surface(C contact, const Fields& fields, const MotionNames& motions) {
  contact.restitution = fields.number("restitution", zero_to_one, 0);
  contact.friction = fields.number("friction", not_negative, 0);
  contact.viscosity = fields.number("viscosity", not_negative, 0);
  contact.normal_viscosity = fields.number("normal_viscosity", not_negative, 0);
  contact.response = fields.choice("response", responses, Response::resume);
  contact.sweep = fields.choice("sweep", sweeps, ContactPath::curve);
  contact.thickness = fields.number("thickness", not_negative, 0);
  if (const auto speed = fields.optional("push_out")) contact.push_out = speed->number(positive);
  if (const auto motion = fields.optional("motion")) contact.motion = motions.index_of(*motion);
  return contact;
}

Vec3 unit_vector(const Node& node) {
  const auto normal = node.vector();
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  if (!(length > 0) || !std::isfinite(length)) node.refuse("a vector of finite length > 0");
  return {normal[0] / length, normal[1] / length, normal[2] / length};
}

Contact read_plane(const Node& node, const MotionNames& motions) {
  const Fields fields(node, "a plane", contact_keys({"normal", "offset"}));
  Plane plane;
  plane.normal = unit_vector(fields.required("normal"));
  plane.offset = fields.required("offset").number();
  return with_surface(plane, fields, motions);
}

Contact read_sphere(const Node& node, const MotionNames& motions) {
  const Fields fields(node, "a sphere", contact_keys({"center", "radius", "side"}));
  Sphere sphere;
  sphere.center = fields.required("center").vector();
  sphere.radius = fields.required("radius").number(positive);
  sphere.side = fields.choice("side", body_sides, Side::outside);
  return with_surface(sphere, fields, motions);
}

// For a body that has no inside for particles.
void require_outside(const Fields& fields) {
  static constexpr std::array<std::string_view, 1> outside{"outside"};
  if (const auto side = fields.optional("side")) (void)side->choice(std::span<const std::string_view>(outside));
}

Contact read_capsule(const Node& node, const MotionNames& motions) {
  const Fields fields(node, "a capsule", contact_keys({"ends", "radius", "side"}));
  require_outside(fields);
  Capsule capsule;
  const Node ends = fields.required("ends");
  const auto points = ends.elements("two points");
  if (points.size() != 2) ends.refuse("two points");
  const Node radius = fields.required("radius");
  const bool is_each = radius.json().is_array();
  if (is_each && radius.json().size() != 2) radius.refuse("a number, or one for each end");
  for (std::size_t k = 0; k < 2; ++k) {
    capsule.ends[k] = points[k].vector();
    capsule.radius[k] = (is_each ? radius.at(k) : radius).number(positive);
  }
  return with_surface(capsule, fields, motions);
}

Contact read_box(const Node& node, const MotionNames& motions) {
  const Fields fields(node, "a box", contact_keys({"center", "half_extents", "rotation", "side"}));
  OrientedBox box;
  box.center = fields.required("center").vector();
  box.half_extents = fields.required("half_extents").vector(positive);
  box.rotation = fields.vector("rotation", {});
  box.side = fields.choice("side", body_sides, Side::outside);
  return with_surface(box, fields, motions);
}

Contact read_convex(const Node& node, const MotionNames& motions) {
  const Fields fields(node, "a convex body", contact_keys({"planes", "side"}));
  require_outside(fields);
  Convex convex;
  const Node planes = fields.required("planes");
  const auto list = planes.elements("a list of 4 to 64 planes");
  if (list.size() < 4 || list.size() > 64) planes.fail(fmt::format("has {} planes: must have 4 to 64", list.size()));
  for (const Node& each : list) {
    const Fields plane(each, "a plane of a convex body", {"normal", "offset"});
    convex.planes.push_back({.normal = unit_vector(plane.required("normal")), .offset = plane.required("offset").number()});
  }
  return with_surface(std::move(convex), fields, motions);
}

// Polygons as fans of triangles from their first corner.
Contact read_body_of_mesh(const Node& node, const MotionNames& motions, SceneFolder& folder) {
  const Fields fields(node, "a mesh", contact_keys({"file", "cell", "side"}));
  require_outside(fields);
  const MeshFile file = mesh_of(fields.required("file"), folder);
  TriangleMesh mesh;
  mesh.vertices = file.vertices;
  for (const auto& face : file.faces) {
    for (std::size_t k = 2; k < face.size(); ++k) mesh.triangles.push_back({face[0], face[k - 1], face[k]});
  }
  mesh.cell = fields.number("cell", positive, 0);
  return with_surface(std::move(mesh), fields, motions);
}

}  // namespace

Contact read_contact(const Node& node, const MotionNames& motions, SceneFolder& folder) {
  switch (node.type_for("contact").choice(contact_types)) {
    case ContactType::plane:
      return read_plane(node, motions);
    case ContactType::sphere:
      return read_sphere(node, motions);
    case ContactType::capsule:
      return read_capsule(node, motions);
    case ContactType::box:
      return read_box(node, motions);
    case ContactType::convex:
      return read_convex(node, motions);
    case ContactType::mesh:
      return read_body_of_mesh(node, motions, folder);
  }
  node.refuse("a contact");
}

void read_push_out(const Node& node, Scene& scene) {
  const double speed = node.number(positive);
  if (scene.contacts.empty()) node.refuse("left out of a scene without contacts");
  for (Contact& contact : scene.contacts) {
    std::visit([speed](auto& surface) { surface.push_out = surface.push_out.value_or(speed); }, contact);
  }
}

}  // namespace dvdx::tool
