// Scenes by C: each struct becomes the value of the same name. compile() checks the values.
#include "c_api/scene.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "c_api/guard.hpp"
#include "dvdx/bending.hpp"
#include "forces/polynomial.hpp"
#include "scene/text.hpp"

namespace dvdx::c_api {

Scalars scalars(const dvdx_scalars& from, const std::string& field) {
  if (from.each == nullptr) return from.all;
  need(from.each, from.count, field);
  return std::vector<double>(from.each, from.each + from.count);
}

Wind wind_of(const dvdx_wind& from) {
  need(from.gusts, from.count, "wind.gusts");
  Wind wind{.mean = vec3(from.mean)};
  for (std::size_t k = 0; k < from.count; ++k) {
    const double* gust = from.gusts + 5 * k;
    wind.gusts.push_back({.amplitude = {gust[0], gust[1], gust[2]}, .angular_frequency = gust[3], .phase = gust[4]});
  }
  return wind;
}

namespace {

constexpr int methods = 6, anchorings = 3, nears = 3;

std::vector<Vec3> vectors(const double* xyz, std::size_t count, const std::string& field) {
  need(xyz, count, field);
  std::vector<Vec3> list(count);
  for (std::size_t i = 0; i < count; ++i) list[i] = {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
  return list;
}

std::vector<Pair> pairs(const std::uint32_t* ends, std::size_t count, const std::string& field) {
  need(ends, count, field);
  std::vector<Pair> list(count);
  for (std::size_t k = 0; k < count; ++k) list[k] = {ends[2 * k], ends[2 * k + 1]};
  return list;
}

using c_api::scalars;
std::optional<Scalars> scalars(const dvdx_scalars* from, const std::string& field) {
  return from == nullptr ? std::nullopt : std::optional(scalars(*from, field));
}

PerAxis per_axis(const dvdx_per_axis& from, const std::string& field) {
  if (from.axes != nullptr) return {from.axes[0], from.axes[1], from.axes[2]};
  return scalars(dvdx_scalars{from.all, from.each, from.count}, field);
}

Anchor anchor(const dvdx_anchor& from, const std::string& field) {
  switch (choice<dvdx_anchoring>(from.from, anchorings, field + ".from")) {
    case DVDX_ANCHOR_EACH:
      return vectors(from.each, from.count, field + ".each");
    case DVDX_ANCHOR_AT_START:
      return at_start;
    case DVDX_ANCHOR_AT:
      break;
  }
  return vec3(from.at);
}

// Nothing for the default.
std::optional<Method> method(const dvdx_method& from, const std::string& field) {
  const auto chosen = choice<dvdx_method>(from, methods, field);
  if (chosen == DVDX_METHOD_DEFAULT) return std::nullopt;
  return static_cast<Method>(static_cast<int>(chosen) - 1);
}

template <class Surface>
Surface with(Surface to, const dvdx_surface& from, const std::string& at) {
  to.restitution = from.restitution;
  to.friction = from.friction;
  to.viscosity = from.viscosity;
  to.normal_viscosity = from.normal_viscosity;
  to.response = choice<Response>(from.response, at + ".surface.response");
  to.sweep = choice<ContactPath>(from.sweep, at + ".surface.sweep");
  to.thickness = from.thickness;
  if (from.push_out != 0) to.push_out = from.push_out;
  return to;
}

Force value(const dvdx_constant& from, const std::string& at) {
  return Constant{.acceleration = vec3(from.acceleration), .method = method(from.method, at + ".method")};
}
Force value(const dvdx_polynomial& from, const std::string& at) {
  if (from.terms < 1 || from.terms > static_cast<std::size_t>(polynomial_terms)) {
    throw Error{at + ".terms", std::to_string(from.terms), "a whole number from 1 to " + std::to_string(polynomial_terms)};
  }
  return Polynomial{.acceleration = vectors(from.acceleration, from.terms, at + ".acceleration"),
                    .method = method(from.method, at + ".method")};
}
Force value(const dvdx_sinusoid& from, const std::string& at) {
  return Sinusoid{.acceleration = vec3(from.acceleration),
                  .angular_frequency = from.angular_frequency,
                  .phase = from.phase,
                  .method = method(from.method, at + ".method")};
}
Force value(const dvdx_spring& from, const std::string& at) {
  return Spring{.stiffness = per_axis(from.stiffness, at + ".stiffness"),
                .damping = from.damping,
                .anchor = anchor(from.anchor, at + ".anchor"),
                .method = method(from.method, at + ".method")};
}
Force value(const dvdx_radial_spring& from, const std::string& at) {
  return RadialSpring{.stiffness = scalars(from.stiffness, at + ".stiffness"),
                      .damping = from.damping,
                      .anchor = anchor(from.anchor, at + ".anchor"),
                      .rest_length = scalars(from.rest_length, at + ".rest_length"),
                      .method = method(from.method, at + ".method")};
}
Force value(const dvdx_drag& from, const std::string& at) {
  return Drag{.coefficient = per_axis(from.coefficient, at + ".coefficient"),
              .wind = vec3(from.wind),
              .expansion = choice<Expansion>(from.expansion, at + ".expansion"),
              .method = method(from.method, at + ".method")};
}

Contact value(const dvdx_plane& from, const std::string& at) {
  return with(Plane{.normal = vec3(from.normal), .offset = from.offset}, from.surface, at);
}
Contact value(const dvdx_sphere& from, const std::string& at) {
  return with(Sphere{.center = vec3(from.center), .radius = from.radius, .side = choice<Side>(from.side, at + ".side")},
              from.surface, at);
}
Contact value(const dvdx_capsule& from, const std::string& at) {
  return with(Capsule{.ends = {vec3(from.ends[0]), vec3(from.ends[1])}, .radius = {from.radius[0], from.radius[1]}},
              from.surface, at);
}
Contact value(const dvdx_box& from, const std::string& at) {
  return with(OrientedBox{.center = vec3(from.center),
                          .half_extents = vec3(from.half_extents),
                          .rotation = vec3(from.rotation),
                          .side = choice<Side>(from.side, at + ".side")},
              from.surface, at);
}
Contact value(const dvdx_convex& from, const std::string& at) {
  need(from.planes, from.count, at + ".planes");
  Convex convex;
  for (std::size_t k = 0; k < from.count; ++k) {
    const double* plane = from.planes + 4 * k;
    convex.planes.push_back({.normal = {plane[0], plane[1], plane[2]}, .offset = plane[3]});
  }
  return with(std::move(convex), from.surface, at);
}
Contact value(const dvdx_mesh& from, const std::string& at) {
  need(from.triangles, from.triangle_count, at + ".triangles");
  TriangleMesh mesh;
  mesh.vertices = vectors(from.vertices, from.count, at + ".vertices");
  for (std::size_t k = 0; k < from.triangle_count; ++k) {
    const std::uint32_t* corners = from.triangles + 3 * k;
    mesh.triangles.push_back({corners[0], corners[1], corners[2]});
  }
  mesh.cell = from.cell;
  return with(std::move(mesh), from.surface, at);
}

Motion value(const dvdx_motion& from, const std::string& at) {
  need(from.keys, from.count, at + ".keys");
  Motion motion{.center = vec3(from.center), .keys = {}};
  for (std::size_t k = 0; k < from.count; ++k) {
    const double* key = from.keys + 7 * k;
    motion.keys.push_back({.time = key[0], .translation = {key[1], key[2], key[3]}, .rotation = {key[4], key[5], key[6]}});
  }
  return motion;
}
Kinematic value(const dvdx_kinematic& from, const std::string& at) {
  need(from.particles, from.count, at + ".particles");
  Kinematic followers{.particles = {}, .motion = from.motion};
  if (from.count != 0) followers.particles.assign(from.particles, from.particles + from.count);
  return followers;
}

Skin value(const dvdx_skin& from, const std::string& at) {
  need(from.particles, from.count, at + ".particles");
  Skin skin;
  if (from.count != 0) skin.particles.assign(from.particles, from.particles + from.count);
  if (from.points != nullptr) skin.points = vectors(from.points, from.count, at + ".points");
  if (auto at_most = scalars(from.at_most, at + ".at_most")) skin.at_most = std::move(*at_most);
  return skin;
}
Tethers value(const dvdx_tethers& from, const std::string& /*at*/) {
  return {.network = from.network, .stretch = from.stretch};
}

// The element of a list of the scene, or of one of its motions. field: the name of the field with its number.
template <class Element>
Element& element_of(std::vector<Element>& list, std::size_t index, const char* field, const std::string& whose,
                    const char* name) {
  if (index < list.size()) return list[index];
  throw Error{field, std::to_string(index), "below the " + whose + "'s " + std::to_string(list.size()) + " " + name};
}

void set_backstop(Scene& to, const dvdx_backstop& from) {
  element_of(to.skins, from.skin, "backstop.skin", "scene", "skins").backstop =
      Backstop{.normals = vectors(from.normals, from.count, "backstop.normals"),
               .offset = scalars(from.offset, "backstop.offset"),
               .radius = scalars(from.radius, "backstop.radius")};
}

Meet meet_of(const dvdx_meet& from) {
  Meet meet;
  meet.radius = scalars(from.radius, "meet.radius");
  if (from.thickness != 0) meet.thickness = from.thickness;
  if (from.part_of_cells != 0) meet.part_of_cells = from.part_of_cells;
  meet.restitution = from.restitution;
  meet.friction = from.friction;
  if (from.rounds != 0) meet.rounds = from.rounds;
  if (from.most_neighbours != 0) meet.most_neighbours = from.most_neighbours;
  meet.near_at_start = choice<NearAtStart>(from.near_at_start, nears, "meet.near_at_start");
  return meet;
}
void set_meet_groups(Scene& to, const dvdx_meet_groups& from) {
  if (!to.meet) throw Error{"groups", std::to_string(from.count) + " particles", "set after what meets"};
  need(from.of, from.count, "groups.of");
  need(from.meet, from.pair_count, "groups.meet");
  MeetGroups groups;
  if (from.count != 0) groups.of.assign(from.of, from.of + from.count);
  for (std::size_t k = 0; k < from.pair_count; ++k) groups.meet.push_back({from.meet[2 * k], from.meet[2 * k + 1]});
  to.meet->groups = std::move(groups);
}

Network value(const dvdx_grid& from, const std::string& /*at*/) {
  return Grid{.rows = from.rows,
              .columns = from.columns,
              .first = from.first,
              .edge_u = vec3(from.edge_u),
              .edge_v = vec3(from.edge_v),
              .structural = from.structural,
              .shear = from.shear,
              .bend = from.bend,
              .damping = from.damping};
}
Network value(const dvdx_springs& from, const std::string& at) {
  return Springs{.pairs = pairs(from.pairs, from.count, at + ".pairs"),
                 .stiffness = scalars(from.stiffness, at + ".stiffness"),
                 .rest_length = scalars(from.rest_length, at + ".rest_length"),
                 .damping = from.damping};
}

Constraint value(const dvdx_distance& from, const std::string& at) {
  return Distance{.pairs = pairs(from.pairs, from.count, at + ".pairs"),
                  .length = scalars(from.length, at + ".length"),
                  .bound = choice<Bound>(from.bound, at + ".bound")};
}
Constraint value(const dvdx_on_point& from, const std::string& /*at*/) {
  return OnPoint{.particle = from.particle, .at = vec3(from.at)};
}
Constraint value(const dvdx_on_line& from, const std::string& /*at*/) {
  return OnLine{.particle = from.particle, .through = vec3(from.through), .direction = vec3(from.direction)};
}

Coupling value(const dvdx_coupling& from) {
  Coupling to;
  to.scheme = choice<Scheme>(from.scheme, "coupling.scheme");
  if (from.substeps != 0) to.substeps = from.substeps;
  if (from.theta != 0) to.theta = from.theta;
  to.sweeps = choice<SweepOrder>(from.sweeps, "coupling.sweeps");
  to.lines = choice<Lines>(from.lines, "coupling.lines");
  to.method = method(from.method, "coupling.method").value_or(to.method);
  to.axis = choice<PairAxis>(from.axis, "coupling.axis");
  if (from.iterations != 0) to.iterations = from.iterations;
  if (from.longest_substep != 0) to.longest_substep = from.longest_substep;
  if (from.most_substeps != 0) to.most_substeps = from.most_substeps;
  return to;
}

// A grid's triangles are those of its cells.
void take_triangles(Grid& /*grid*/, const dvdx_aerodynamics& from) {
  if (from.count == 0) return;
  throw Error{"aerodynamics.triangles", std::to_string(from.count), "none of a grid, whose cells are cut"};
}
void take_triangles(Springs& springs, const dvdx_aerodynamics& from) {
  need(from.triangles, from.count, "aerodynamics.triangles");
  springs.triangles.clear();
  for (std::size_t t = 0; t < from.count; ++t) {
    const std::uint32_t* corners = from.triangles + 3 * t;
    springs.triangles.push_back({corners[0], corners[1], corners[2]});
  }
}

void add_bending(Scene& to, const dvdx_bending& from) {
  auto* const springs = std::get_if<Springs>(&element_of(to.networks, from.network, "bending.network", "scene", "networks"));
  if (springs == nullptr) throw Error{"bending.network", std::to_string(from.network), "a network of springs"};
  const BentSheet sheet = bent_sheet_of(from);
  dvdx::add_bending(*springs, sheet.triangles, sheet.flat, from.modulus);
}

void set_aerodynamics(Scene& to, const dvdx_aerodynamics& from) {
  const auto take = [&](auto& network) {
    take_triangles(network, from);
    network.aerodynamics = Aerodynamics{.density = from.density, .drag = from.drag, .lift = from.lift};
  };
  std::visit(take, element_of(to.networks, from.network, "aerodynamics.network", "scene", "networks"));
}

// Calls change(scene, *what) after a check of both pointers.
template <class What, class Change>
dvdx_status apply_change(dvdx_scene* scene, const What* what, const char* name, dvdx_error* error,
                         const Change& change) noexcept {
  if (scene == nullptr) return missing(error, "scene");
  if (what == nullptr) return missing(error, name);
  return guarded(error, [&] {
    change(scene->scene, *what);
    return report(error, DVDX_DONE);
  });
}

// Adds a value to one of a scene's lists. name: the list's, which stands in front of its fields in messages.
template <class What, class List>
dvdx_status added(dvdx_scene* scene, const What* what, List Scene::*list, const char* name, dvdx_error* error) noexcept {
  return apply_change(scene, what, name, error, [&](Scene& to, const What& from) {
    const std::string at = std::string(name) + "[" + std::to_string((to.*list).size()) + "]";
    (to.*list).push_back(value(from, at));
  });
}

}  // namespace

BentSheet bent_sheet_of(const dvdx_bending& from) {
  if (!(from.modulus >= 0)) throw Error{"bending.modulus", text(from.modulus), "a number >= 0"};
  need(from.triangles, from.triangle_count, "bending.triangles");
  BentSheet sheet{.triangles = {}, .flat = vectors(from.flat, from.count, "bending.flat")};
  for (std::size_t t = 0; t < from.triangle_count; ++t) {
    const std::uint32_t* corners = from.triangles + 3 * t;
    sheet.triangles.push_back({corners[0], corners[1], corners[2]});
    for (const std::uint32_t corner : sheet.triangles.back()) {
      if (corner < from.count) continue;
      throw Error{"bending.triangles[" + std::to_string(t) + "]", std::to_string(corner),
                  "particles below " + std::to_string(from.count) + ", as many as flat has"};
    }
  }
  return sheet;
}

}  // namespace dvdx::c_api

using namespace dvdx::c_api;
using dvdx::Scene;

dvdx_status dvdx_scene_create(int abi_version, dvdx_scene** scene, dvdx_error* error) {
  if (scene == nullptr) return missing(error, "scene");
  *scene = nullptr;
  if (abi_version != DVDX_ABI_VERSION) return report(error, DVDX_ABI_DIFFERS);
  return guarded(error, [&] {
    *scene = new dvdx_scene;
    return report(error, DVDX_DONE);
  });
}

void dvdx_scene_destroy(dvdx_scene* scene) { delete scene; }

dvdx_status dvdx_scene_set_method(dvdx_scene* scene, dvdx_method method, dvdx_error* error) {
  return apply_change(scene, &method, "method", error, [](Scene& to, const dvdx_method& from) {
    to.method = dvdx::c_api::method(from, "method").value_or(dvdx::Method::combined);
  });
}
dvdx_status dvdx_scene_set_mass(dvdx_scene* scene, const dvdx_scalars* mass, dvdx_error* error) {
  return apply_change(scene, mass, "mass", error, [](Scene& to, const dvdx_scalars& from) { to.mass = scalars(from, "mass"); });
}
dvdx_status dvdx_scene_set_coupling(dvdx_scene* scene, const dvdx_coupling* coupling, dvdx_error* error) {
  return apply_change(scene, coupling, "coupling", error,
                      [](Scene& to, const dvdx_coupling& from) { to.coupling = value(from); });
}
dvdx_status dvdx_scene_set_fixed(dvdx_scene* scene, const size_t* particles, size_t count, dvdx_error* error) {
  return apply_change(scene, &count, "fixed", error, [&](Scene& to, std::size_t) {
    need(particles, count, "fixed");
    to.fixed = count == 0 ? std::vector<std::size_t>{} : std::vector<std::size_t>(particles, particles + count);
  });
}

dvdx_status dvdx_scene_set_origin(dvdx_scene* scene, const double* origin, size_t count, dvdx_error* error) {
  return apply_change(scene, origin, "origin", error, [&](Scene& to, const double&) {
    if (count == 0) throw dvdx::Error{"origin", "0 points", "1 point for all, or one for each particle"};
    auto points = vectors(origin, count, "origin");
    to.origin = count == 1 ? dvdx::Origin(points[0]) : dvdx::Origin(std::move(points));
  });
}

dvdx_status dvdx_scene_add_constant(dvdx_scene* scene, const dvdx_constant* force, dvdx_error* error) {
  return added(scene, force, &Scene::forces, "forces", error);
}
dvdx_status dvdx_scene_add_polynomial(dvdx_scene* scene, const dvdx_polynomial* force, dvdx_error* error) {
  return added(scene, force, &Scene::forces, "forces", error);
}
dvdx_status dvdx_scene_add_sinusoid(dvdx_scene* scene, const dvdx_sinusoid* force, dvdx_error* error) {
  return added(scene, force, &Scene::forces, "forces", error);
}
dvdx_status dvdx_scene_add_spring(dvdx_scene* scene, const dvdx_spring* force, dvdx_error* error) {
  return added(scene, force, &Scene::forces, "forces", error);
}
dvdx_status dvdx_scene_add_radial_spring(dvdx_scene* scene, const dvdx_radial_spring* force, dvdx_error* error) {
  return added(scene, force, &Scene::forces, "forces", error);
}
dvdx_status dvdx_scene_add_drag(dvdx_scene* scene, const dvdx_drag* force, dvdx_error* error) {
  return added(scene, force, &Scene::forces, "forces", error);
}

dvdx_status dvdx_scene_add_plane(dvdx_scene* scene, const dvdx_plane* contact, dvdx_error* error) {
  return added(scene, contact, &Scene::contacts, "contacts", error);
}
dvdx_status dvdx_scene_add_sphere(dvdx_scene* scene, const dvdx_sphere* contact, dvdx_error* error) {
  return added(scene, contact, &Scene::contacts, "contacts", error);
}

dvdx_status dvdx_scene_add_capsule(dvdx_scene* scene, const dvdx_capsule* contact, dvdx_error* error) {
  return added(scene, contact, &Scene::contacts, "contacts", error);
}
dvdx_status dvdx_scene_add_box(dvdx_scene* scene, const dvdx_box* contact, dvdx_error* error) {
  return added(scene, contact, &Scene::contacts, "contacts", error);
}
dvdx_status dvdx_scene_add_convex(dvdx_scene* scene, const dvdx_convex* contact, dvdx_error* error) {
  return added(scene, contact, &Scene::contacts, "contacts", error);
}

dvdx_status dvdx_scene_add_mesh(dvdx_scene* scene, const dvdx_mesh* contact, dvdx_error* error) {
  return added(scene, contact, &Scene::contacts, "contacts", error);
}

dvdx_status dvdx_scene_add_motion(dvdx_scene* scene, const dvdx_motion* motion, dvdx_error* error) {
  return added(scene, motion, &Scene::motions, "motions", error);
}
dvdx_status dvdx_scene_add_kinematic(dvdx_scene* scene, const dvdx_kinematic* followers, dvdx_error* error) {
  return added(scene, followers, &Scene::kinematic, "kinematic", error);
}
dvdx_status dvdx_scene_add_skin(dvdx_scene* scene, const dvdx_skin* skin, dvdx_error* error) {
  return added(scene, skin, &Scene::skins, "skins", error);
}
dvdx_status dvdx_scene_set_backstop(dvdx_scene* scene, const dvdx_backstop* backstop, dvdx_error* error) {
  return apply_change(scene, backstop, "backstop", error, set_backstop);
}
dvdx_status dvdx_scene_set_jump(dvdx_scene* scene, size_t motion, size_t key, dvdx_error* error) {
  return apply_change(scene, &motion, "motion", error, [&](Scene& to, std::size_t) {
    std::vector<dvdx::MotionKey>& keys = element_of(to.motions, motion, "motion", "scene", "motions").keys;
    element_of(keys, key, "key", "motion", "keys").arrival = dvdx::Arrival::jump;
  });
}
dvdx_status dvdx_scene_set_skin_motion(dvdx_scene* scene, size_t skin, size_t motion, dvdx_error* error) {
  return apply_change(scene, &skin, "skin", error,
                      [&](Scene& to, std::size_t) { element_of(to.skins, skin, "skin", "scene", "skins").motion = motion; });
}
dvdx_status dvdx_scene_add_tethers(dvdx_scene* scene, const dvdx_tethers* tethers, dvdx_error* error) {
  return added(scene, tethers, &Scene::tethers, "tethers", error);
}
dvdx_status dvdx_scene_set_meet(dvdx_scene* scene, const dvdx_meet* meet, dvdx_error* error) {
  return apply_change(scene, meet, "meet", error, [](Scene& to, const dvdx_meet& from) { to.meet = meet_of(from); });
}
dvdx_status dvdx_scene_set_meet_groups(dvdx_scene* scene, const dvdx_meet_groups* groups, dvdx_error* error) {
  return apply_change(scene, groups, "groups", error, set_meet_groups);
}
dvdx_status dvdx_scene_set_contact_motion(dvdx_scene* scene, size_t contact, size_t motion, dvdx_error* error) {
  return apply_change(scene, &contact, "contact", error, [&](Scene& to, std::size_t) {
    std::visit([&](auto& c) { c.motion = motion; }, element_of(to.contacts, contact, "contact", "scene", "contacts"));
  });
}

dvdx_status dvdx_scene_add_grid(dvdx_scene* scene, const dvdx_grid* network, dvdx_error* error) {
  return added(scene, network, &Scene::networks, "networks", error);
}
dvdx_status dvdx_scene_add_springs(dvdx_scene* scene, const dvdx_springs* network, dvdx_error* error) {
  return added(scene, network, &Scene::networks, "networks", error);
}

dvdx_status dvdx_scene_set_aerodynamics(dvdx_scene* scene, const dvdx_aerodynamics* air, dvdx_error* error) {
  return apply_change(scene, air, "air", error, set_aerodynamics);
}
dvdx_status dvdx_scene_add_bending(dvdx_scene* scene, const dvdx_bending* bending, dvdx_error* error) {
  return apply_change(scene, bending, "bending", error, add_bending);
}
dvdx_status dvdx_scene_set_wind(dvdx_scene* scene, const dvdx_wind* wind, dvdx_error* error) {
  return apply_change(scene, wind, "wind", error, [](Scene& to, const dvdx_wind& from) { to.wind = wind_of(from); });
}

dvdx_status dvdx_scene_set_faces(dvdx_scene* scene, dvdx_faces faces, dvdx_error* error) {
  return apply_change(scene, &faces, "faces", error,
                      [](dvdx::Scene& to, const dvdx_faces& from) { to.faces = choice<dvdx::Faces>(from, "faces"); });
}

dvdx_status dvdx_scene_add_distance(dvdx_scene* scene, const dvdx_distance* constraint, dvdx_error* error) {
  return added(scene, constraint, &Scene::constraints, "constraints", error);
}
dvdx_status dvdx_scene_add_on_point(dvdx_scene* scene, const dvdx_on_point* constraint, dvdx_error* error) {
  return added(scene, constraint, &Scene::constraints, "constraints", error);
}
dvdx_status dvdx_scene_add_on_line(dvdx_scene* scene, const dvdx_on_line* constraint, dvdx_error* error) {
  return added(scene, constraint, &Scene::constraints, "constraints", error);
}
