#include "scene_io/scene_reader.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "scene_io/air_reader.hpp"
#include "scene_io/constraint_reader.hpp"
#include "scene_io/coupling_reader.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/json_text.hpp"
#include "scene_io/meet_reader.hpp"
#include "scene_io/mesh_reader.hpp"
#include "scene_io/motion_reader.hpp"
#include "scene_io/names.hpp"
#include "scene_io/network_reader.hpp"
#include "scene_io/overrides.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/seeds.hpp"
#include "scene_io/skin_reader.hpp"
#include "scene_io/steps.hpp"
#include "scene_io/turnover_reader.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;

constexpr std::string_view format = "dvdx-scene/1";
constexpr std::size_t most_terms = 8;  // of a polynomial
constexpr std::uint64_t most_particles = std::uint64_t{1} << 53U;

// ---- forces ------------------------------------------------------------------------------------------------------------

std::optional<Method> own_method(const Fields& fields) {
  const auto field = fields.optional("method");
  return field ? std::optional(field->choice(methods)) : std::nullopt;
}

PerAxis per_axis(const Node& node, const Population& population) {
  if (node.json().is_array()) return PerAxis(node.vector(not_negative));
  return read_scalars(node, population, not_negative);
}

Anchor anchor_of(const Node& node, const Population& population) {
  if (node.json().is_string()) {
    if (node.json() != "start") node.refuse("\"start\", [x, y, z] or an object with one of values, uniform, file, lattice");
    return at_start;
  }
  auto vectors = read_vectors(node, population);
  if (const auto* all = std::get_if<Vec3>(&vectors)) return *all;
  if (auto* each = std::get_if<std::vector<Vec3>>(&vectors)) return std::move(*each);
  return each_of(vectors, population.run().count);
}

Force read_constant(const Node& node) {
  const Fields fields(node, "a constant force", {"type", "method", "acceleration"});
  return Constant{.acceleration = fields.required("acceleration").vector(), .method = own_method(fields)};
}

Force read_polynomial(const Node& node) {
  const Fields fields(node, "a polynomial force", {"type", "method", "acceleration"});
  const auto field = fields.required("acceleration");
  const auto terms = field.elements("a list of 1 to 8 terms [x, y, z]");
  if (terms.empty() || terms.size() > most_terms) {
    field.fail("has " + std::to_string(terms.size()) + " terms: must have 1 to " + std::to_string(most_terms));
  }
  Polynomial force{.acceleration = {}, .method = own_method(fields)};
  for (const auto& term : terms) force.acceleration.push_back(term.vector());
  return force;
}

Force read_sinusoid(const Node& node) {
  const Fields fields(node, "a sinusoid force", {"type", "method", "acceleration", "angular_frequency", "phase"});
  return Sinusoid{.acceleration = fields.required("acceleration").vector(),
                  .angular_frequency = fields.required("angular_frequency").number(),
                  .phase = fields.number("phase", any_number, 0),
                  .method = own_method(fields)};
}

Force read_spring(const Node& node, const Population& population) {
  const Fields fields(node, "a spring", {"type", "method", "stiffness", "damping", "anchor"});
  return Spring{.stiffness = per_axis(fields.required("stiffness"), population),
                .damping = fields.number("damping", not_negative, 0),
                .anchor = anchor_of(fields.required("anchor"), population),
                .method = own_method(fields)};
}

Force read_radial_spring(const Node& node, const Population& population) {
  const Fields fields(node, "a radial spring", {"type", "method", "stiffness", "damping", "anchor", "rest_length"});
  return RadialSpring{.stiffness = read_scalars(fields.required("stiffness"), population, not_negative),
                      .damping = fields.number("damping", not_negative, 0),
                      .anchor = anchor_of(fields.required("anchor"), population),
                      .rest_length = read_scalars(fields.required("rest_length"), population, not_negative),
                      .method = own_method(fields)};
}

Force read_drag(const Node& node, const Population& population) {
  const Fields fields(node, "a drag", {"type", "method", "coefficient", "wind", "expansion"});
  return Drag{.coefficient = per_axis(fields.required("coefficient"), population),
              .wind = fields.vector("wind", {}),
              .expansion = fields.choice("expansion", expansions, Expansion::exact),
              .method = own_method(fields)};
}

// The type of a force or a contact, on which its other keys hang.
template <class E, std::size_t N>
E type_of(const Node& node, const std::array<Named<E>, N>& table, std::string_view what) {
  if (!node.json().is_object()) node.refuse("an object");
  if (!node.json().contains("type")) {
    throw Fault(Exit::bad_scene, node.file() + ": " + node.path() + ".type is missing: a " + std::string(what) + " needs it");
  }
  return node.at("type").choice(table);
}

Force read_force(const Node& node, const Population& population) {
  switch (type_of(node, force_types, "force")) {
    case ForceType::constant:
      return read_constant(node);
    case ForceType::polynomial:
      return read_polynomial(node);
    case ForceType::sinusoid:
      return read_sinusoid(node);
    case ForceType::spring:
      return read_spring(node, population);
    case ForceType::radial_spring:
      return read_radial_spring(node, population);
    case ForceType::drag:
      return read_drag(node, population);
  }
  node.refuse("a force");
}

// ---- contacts ----------------------------------------------------------------------------------------------------------

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

// For contacts that have no such speed of their own.
void read_push_out(const Node& node, Scene& scene) {
  const double speed = node.number(positive);
  if (scene.contacts.empty()) node.refuse("left out of a scene without contacts");
  for (Contact& contact : scene.contacts) {
    std::visit([speed](auto& surface) { surface.push_out = surface.push_out.value_or(speed); }, contact);
  }
}

Contact read_contact(const Node& node, const MotionNames& motions, SceneFolder& folder) {
  switch (type_of(node, contact_types, "contact")) {
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

// ---- particles ---------------------------------------------------------------------------------------------------------

// The bytes that a particle takes to meet others: of each that its list has room for a pair, and working columns of its own.
std::uint64_t bytes_to_meet(const json& meet, std::size_t scalar_bytes) {
  const bool has_most = meet.is_object() && meet.contains("most_neighbours") && meet["most_neighbours"].is_number_unsigned();
  const auto most =
      has_most ? meet["most_neighbours"].get<std::uint64_t>() : static_cast<std::uint64_t>(Meet{}.most_neighbours);
  return (24 * std::min<std::uint64_t>(most, 255) + 100) * scalar_bytes;
}

// The bytes that a particle takes at least: its state, and what the scene gives for it alone.
std::uint64_t bytes_each(const json& scene, std::size_t scalar_bytes) {
  std::uint64_t bytes = 6 * scalar_bytes;
  const json& particles = scene.contains("particles") ? scene["particles"] : scene;  // which has no such keys
  const auto is_each = [](const json& object, const char* key) { return object.contains(key) && object[key].is_object(); };
  const auto is_held = [&](const char* key) { return is_each(particles, key) && !particles[key].contains("uniform"); };
  if (is_each(particles, "mass")) bytes += sizeof(double);
  if (scene.contains("meet")) bytes += bytes_to_meet(scene["meet"], scalar_bytes);
  for (const char* key : {"position", "velocity"}) bytes += is_held(key) ? sizeof(Vec3) : 0;
  if (!scene.contains("forces") || !scene["forces"].is_array()) return bytes;
  for (const auto& force : scene["forces"]) {
    if (!force.is_object()) continue;
    for (const auto& [key, value] : force.items()) {  // an object is a value that differs from particle to particle
      if (value.is_object()) bytes += key == "anchor" ? sizeof(Vec3) : sizeof(double);
      if (value == "start") bytes += 3 * scalar_bytes;
    }
  }
  return bytes;
}

Room room_for(const json& scene, const ReadOptions& options) {
  return {.bytes_each = bytes_each(scene, options.scalar_bytes), .bytes = options.memory_bytes};
}

// Where particles come and go, each also has an age and a lifetime, and the plan works in another quarter of all that. Each of
// several ranks has a share of those that live, its range of them all to show, and what it tells the others. Those that meet
// have working columns, and a place each.
Room room_for_live(const json& scene, const ReadOptions& options) {
  if (scene.contains("meet")) {
    const std::uint64_t each = 18 * options.scalar_bytes + sizeof(Vec3) + bytes_to_meet(scene["meet"], options.scalar_bytes);
    return {.bytes_each = each, .bytes = options.memory_bytes};
  }
  if (options.share.ranks == 1) return {.bytes_each = 10 * options.scalar_bytes, .bytes = options.memory_bytes};
  constexpr std::uint64_t told = 4 * sizeof(std::uint64_t);  // numbers, ids and places
  return {.bytes_each = 18 * options.scalar_bytes + told, .bytes = options.share.ranks * options.memory_bytes};
}

// The network of a scene that has one alone, which is stepped as a sheet; or null. Constraints, ropes and `accumulate` have lists.
const json* sheet_in(const json& scene, const ReadOptions& options) {
  const json* network = &scene["network"];
  if (network->is_array() && network->size() == 1) network = &(*network)[0];
  if (!network->is_object() || network->value("type", json()) != "grid") return nullptr;
  const bool is_rope = network->value("rows", json()) == 1 || network->value("columns", json()) == 1;
  const bool accumulates = (options.scheme.empty() ? network->value("scheme", json()) : json(options.scheme)) == "accumulate";
  return is_rope || network->contains("strain_limit") || accumulates ? nullptr : network;
}

// Whether each of several ranks holds its own rows of a sheet alone. Lines and faces are whole on each, and so are values that
// differ from particle to particle; and the first rank makes a plan of the whole where air, skins, torn springs or few sub-steps
// ask for one.
bool is_held_by_rows(const json& scene, const json& sheet, const ReadOptions& options) {
  const bool has_plan = sheet.contains("aerodynamics") || sheet.contains("broken") || sheet.contains("tears_at") ||
                        sheet.value("substeps", json("auto")) != "auto" || !options.substeps.empty() || scene.contains("skins");
  return options.topology == ReadTopology::no && !has_plan &&
         bytes_each(scene, options.scalar_bytes) == 6 * options.scalar_bytes;
}

// The bytes that a network's particle takes in addition. In a sheet: its plan's columns, counted for `sequential`, which has
// most, and a face. In other networks: its own position, mass and face, the forces on it, and its springs, about six each.
Room room_for_networks(const json& scene, const ReadOptions& options) {
  constexpr std::uint64_t springs = 6 * (sizeof(Pair) + 2 * sizeof(double));
  constexpr std::uint64_t columns = 48;
  const std::uint64_t face = options.topology == ReadTopology::yes ? 64 : 0;
  auto room = room_for(scene, options);
  if (const json* const sheet = sheet_in(scene, options)) {
    room.bytes_each += columns * options.scalar_bytes + face;
    if (is_held_by_rows(scene, *sheet, options)) room.bytes *= options.share.ranks;
  } else {
    room.bytes_each += sizeof(Vec3) + sizeof(double) + face + 3 * options.scalar_bytes + springs;
  }
  return room;
}

// Whether each particle moves by itself, so that a rank may hold some of them without the others.
bool can_split_by_ranges(const json& scene) {
  return !scene.contains("network") && !scene.contains("constraints") && !scene.contains("kinematic") &&
         !scene.contains("skins") && !scene.contains("meet");
}

std::size_t read_count(const Node& node, const json& scene, const ReadOptions& options) {
  const auto count = node.whole(1, most_particles);
  const auto room = room_for(scene, options);
  const std::size_t most_here = can_split_by_ranges(scene) ? options.share.of(count).count : count;
  if (most_here > room.most()) node.refuse(room.limit());
  return count;
}

// ---- the scene ---------------------------------------------------------------------------------------------------------

void check_format(const Node& root) {
  if (!root.json().is_object() || !root.json().contains("format")) return;  // said with the other keys
  const auto field = root.at("format");
  if (field.json() != std::string(format)) field.refuse('"' + std::string(format) + '"');
}

double read_duration(const Node& node, double step) {
  const double duration = node.number(not_negative);
  const auto steps = steps_in(duration, step);
  if (!steps) node.refuse(steps.error());
  return duration;
}

// The particles that the scene lists itself.
void read_own_particles(const Fields& fields, SceneFile& file, Population& population, const ReadOptions& options) {
  const bool may_be_none = fields.optional("emitters").has_value();
  if (may_be_none && !fields.optional("particles")) return;
  const Fields particles(fields.required("particles"), "particles", {"count", "mass", "position", "velocity"});
  const auto count = may_be_none ? particles.optional("count") : particles.required("count");
  population.count = count ? read_count(*count, fields.node().json(), options) : 0;
  if (options.share.ranks > 1 && can_split_by_ranges(fields.node().json())) {
    population.kept = options.share.of(population.count);
  }
  const auto [first, here] = population.run();
  file.particles = {.count = here, .first = first, .elsewhere = population.count - here};
  if (const auto mass = particles.optional("mass")) file.scene.mass = read_scalars(*mass, population, positive);
  if (const auto node = particles.optional("position")) file.particles.position = read_vectors(*node, population);
  if (const auto node = particles.optional("velocity")) file.particles.velocity = read_vectors(*node, population);
}

// Those that its networks make, of which the scene may give the velocity.
void take_made_particles(const Fields& fields, NetworkReader& networks, SceneFile& file, Population& population) {
  population.count = networks.numbers();
  file.numbering = networks.numbering();
  if (!file.numbering.is_own()) population.numbering = &file.numbering;
  file.particles.count = networks.count();
  file.particles.position = networks.take_positions();
  file.scene.mass = networks.masses();
  const auto node = fields.optional("particles");
  if (!node) return;
  const Fields particles(*node, "particles", {"count", "mass", "position", "velocity"});
  if (const auto count = particles.optional("count"); count && count->whole(1, most_particles) != population.count) {
    count->refuse(fmt::format("left out, or {}, which is how many the network makes{}", population.count,
                              file.numbering.is_own() ? "" : ", each vertex of a mesh counted"));
  }
  for (const char* key : {"mass", "position"}) {
    if (const auto given = particles.optional(key)) given->fail("is there, and the network gives it: must be left out");
  }
  if (const auto velocity = particles.optional("velocity")) file.particles.velocity = read_vectors(*velocity, population);
}

std::optional<NetworkReader> read_particles_and_networks(const Fields& fields, SceneFile& file, Population& population,
                                                         const ReadOptions& options) {
  std::optional<NetworkReader> networks;
  if (const auto node = fields.optional("network")) {
    networks.emplace(*node, *population.folder, room_for_networks(fields.node().json(), options), options.topology);
  }
  if (networks && networks->makes_particles()) {
    take_made_particles(fields, *networks, file, population);
  } else {
    read_own_particles(fields, file, population, options);
  }
  if (networks) networks->add_to(file, population);
  return networks;
}

// Those of the scene and those of its networks, each once and in order.
void read_fixed(const Fields& fields, SceneFile& file, const Population& population) {
  auto& fixed = file.scene.fixed;
  if (const auto node = fields.optional("fixed")) {
    const auto [first, count] = population.run();
    for (const std::size_t id : particles_of(read_ids(*node, population), population)) {
      if (id >= first && id - first < count) fixed.push_back(id - first);
    }
  }
  std::sort(fixed.begin(), fixed.end());
  fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
}

void read_origin(const Node& node, SceneFile& file) {
  if (node.json() == "auto") return;
  if (node.json().is_string()) node.refuse("\"auto\" or [x, y, z]");
  file.scene.origin = node.vector();
  file.is_origin_free = false;
}

constexpr std::uint64_t most_iterations = 1000;

SceneFile scene_of(const std::string& path, const json& root, const ReadOptions& options) {
  const Node node(root, "", path);
  check_format(node);
  const Fields fields(node, "a scene",
                      {"format",    "name",          "about",    "step",    "duration",    "method",
                       "particles", "forces",        "contacts", "network", "constraints", "constraint_iterations",
                       "substeps",  "most_substeps", "fixed",    "motions", "kinematic",   "origin",
                       "emitters",  "capacity",      "removal",  "wind",    "skins",       "tethers",
                       "faces",     "push_out",      "meet"});
  SceneFile file;
  file.path = path;
  (void)fields.required("format");
  file.name = fields.required("name").text();
  if (const auto about = fields.optional("about")) file.about = about->text();
  file.step = fields.required("step").number(positive);
  file.duration = read_duration(fields.required("duration"), file.step);
  file.scene.method = fields.choice("method", methods, Method::combined);
  SceneFolder folder(std::filesystem::path(path).parent_path());
  Population population{.count = 0, .folder = &folder};
  const auto networks = read_particles_and_networks(fields, file, population, options);
  const auto motions = read_motions(fields, file.scene);
  file.motions = motions.all();
  if (const auto forces = fields.optional("forces")) {
    for (const auto& force : forces->elements("a list of forces")) file.scene.add(read_force(force, population));
  }
  if (const auto contacts = fields.optional("contacts")) {
    for (const auto& contact : contacts->elements("a list of contacts")) file.scene.add(read_contact(contact, motions, folder));
  }
  if (const auto speed = fields.optional("push_out")) read_push_out(*speed, file.scene);
  if (const auto constraints = fields.optional("constraints"))
    read_constraints(*constraints, file, population, options.topology);
  if (const auto iterations = fields.optional("constraint_iterations")) {
    file.scene.coupling.iterations = static_cast<int>(iterations->whole(1, most_iterations));
  }
  for (const char* const key : {"substeps", "most_substeps"}) {
    const auto substeps = fields.optional(key);
    if (!substeps) continue;
    if (!file.scene.networks.empty()) substeps->refuse("left out of a scene with networks, which have their own");
    if (file.scene.constraints.empty() && !fields.optional("meet")) {
      substeps->refuse("left out of a scene without constraints and without meet");
    }
  }
  read_substeps(fields, file.scene.coupling);
  read_fixed(fields, file, population);
  read_kinematic(fields, file, population, motions, networks);
  read_skins(fields, file.scene, population, motions, networks);
  read_tethers(fields, file.scene);
  read_meet(fields, file, population);
  file.scene.faces = fields.choice("faces", face_choices, Faces::automatic);
  if (const auto wind = fields.optional("wind")) file.scene.wind = read_wind(*wind);
  if (const auto origin = fields.optional("origin")) read_origin(*origin, file);
  read_turnover(fields, file, motions, room_for_live(root, options));
  file.sources = folder.named();
  file.sources.emplace_back(path);
  return file;
}

void check_encoding(const std::string& path, std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw Fault(Exit::bad_scene, path + ": the file is empty: must be a JSON object of the format " + std::string(format));
  }
  for (const std::string_view mark : {"\xEF\xBB\xBF", "\xFF\xFE", "\xFE\xFF"}) {
    if (text.starts_with(mark)) {
      throw Fault(Exit::bad_scene, path + ": the file starts with a byte order mark: must be UTF-8 without one");
    }
  }
}

// The memory that Linux says is free without swapping; elsewhere all there is.
std::uint64_t linux_available_memory() {
  std::ifstream meminfo("/proc/meminfo");
  std::string key;
  std::uint64_t kilobytes = 0;
  std::string unit;
  while (meminfo >> key >> kilobytes >> unit) {
    if (key == "MemAvailable:") return kilobytes * 1024;
  }
  return 0;
}

}  // namespace

std::uint64_t available_memory() {
  if (const auto bytes = linux_available_memory(); bytes > 0) return bytes;
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

namespace {

json json_in(const std::string& path, std::string_view text, const ReadOptions& options) {
  check_encoding(path, text);
  json root = parse_json(path, text);
  for (const auto& assignment : options.overrides) apply_override(root, path, assignment);
  if (options.seed) reseed(root, *options.seed);
  return root;
}

}  // namespace

SceneFile parse_scene(const std::string& path, std::string_view text, const ReadOptions& options) {
  return scene_of(path, json_in(path, text, options), options);
}

json read_json(const std::string& path, const ReadOptions& options) {
  const auto text = read_file(path, scene_limit);
  if (!text) throw Fault(Exit::input_output, path + ": " + text.error());
  return json_in(path, *text, options);
}

SceneFile read_scene(const std::string& path, const ReadOptions& options) {
  return scene_of(path, read_json(path, options), options);
}

}  // namespace dvdx::tool
