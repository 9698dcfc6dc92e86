#include "scene_reader.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "fault.hpp"
#include "file_text.hpp"
#include "json_text.hpp"
#include "names.hpp"
#include "network_syntax.hpp"
#include "overrides.hpp"
#include "particle_values.hpp"
#include "steps.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;

constexpr std::string_view format = "dvdx-scene/1";
constexpr std::size_t most_terms = 8;  // of a polynomial
constexpr std::uint64_t most_particles = std::uint64_t{1} << 53U;

// ---- forces ------------------------------------------------------------------------------------------------------------

enum class ForceType { constant, polynomial, sinusoid, spring, radial_spring, drag };
constexpr std::array<Named<ForceType>, 6> force_types{{{"constant", ForceType::constant},
                                                       {"polynomial", ForceType::polynomial},
                                                       {"sinusoid", ForceType::sinusoid},
                                                       {"spring", ForceType::spring},
                                                       {"radial_spring", ForceType::radial_spring},
                                                       {"drag", ForceType::drag}}};

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
    if (node.json() != "start") node.refuse("\"start\", [x, y, z] or an object with one of values, uniform, file");
    return at_start;
  }
  auto vectors = read_vectors(node, population);
  if (const auto* all = std::get_if<Vec3>(&vectors)) return *all;
  if (auto* each = std::get_if<std::vector<Vec3>>(&vectors)) return std::move(*each);
  return each_of(vectors, population.count.value_or(0));
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

enum class ContactType { plane, sphere };
constexpr std::array<Named<ContactType>, 2> contact_types{{{"plane", ContactType::plane}, {"sphere", ContactType::sphere}}};

std::vector<std::string_view> contact_keys(std::initializer_list<std::string_view> own) {
  std::vector<std::string_view> keys{"type"};
  keys.insert(keys.end(), own);
  keys.insert(keys.end(), {"restitution", "friction", "viscosity", "normal_viscosity", "response", "sweep"});
  return keys;
}

template <class C>
C with_surface(C contact, const Fields& fields) {
  contact.restitution = fields.number("restitution", zero_to_one, 0);
  contact.friction = fields.number("friction", not_negative, 0);
  contact.viscosity = fields.number("viscosity", not_negative, 0);
  contact.normal_viscosity = fields.number("normal_viscosity", not_negative, 0);
  contact.response = fields.choice("response", responses, Response::resume);
  contact.sweep = fields.choice("sweep", sweeps, Sweep::curve);
  return contact;
}

Vec3 unit_vector(const Node& node) {
  const auto normal = node.vector();
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  if (!(length > 0) || !std::isfinite(length)) node.refuse("a vector of finite length > 0");
  return {normal[0] / length, normal[1] / length, normal[2] / length};
}

Contact read_plane(const Node& node) {
  const Fields fields(node, "a plane", contact_keys({"normal", "offset"}));
  Plane plane;
  plane.normal = unit_vector(fields.required("normal"));
  plane.offset = fields.required("offset").number();
  return with_surface(plane, fields);
}

Contact read_sphere(const Node& node) {
  const Fields fields(node, "a sphere", contact_keys({"center", "radius", "side"}));
  Sphere sphere;
  sphere.center = fields.required("center").vector();
  sphere.radius = fields.required("radius").number(positive);
  sphere.side = fields.choice("side", sides, Side::outside);
  return with_surface(sphere, fields);
}

Contact read_contact(const Node& node) {
  return type_of(node, contact_types, "contact") == ContactType::plane ? read_plane(node) : read_sphere(node);
}

// ---- particles ---------------------------------------------------------------------------------------------------------

// What a particle takes at least: its state, and what the scene gives for it alone.
std::uint64_t bytes_each(const json& scene, std::size_t scalar_bytes) {
  std::uint64_t bytes = 6 * scalar_bytes;
  const auto is_each = [](const json& object, const char* key) { return object.contains(key) && object[key].is_object(); };
  const auto is_held = [&](const char* key) {
    return is_each(scene["particles"], key) && !scene["particles"][key].contains("uniform");
  };
  if (is_each(scene["particles"], "mass")) bytes += sizeof(double);
  for (const char* key : {"position", "velocity"}) bytes += is_held(key) ? sizeof(Vec3) : 0;
  if (!scene.contains("forces") || !scene["forces"].is_array()) return bytes;
  for (const auto& force : scene["forces"]) {
    if (!force.is_object()) continue;
    for (const char* key : {"stiffness", "coefficient", "rest_length"}) bytes += is_each(force, key) ? sizeof(double) : 0;
    if (is_each(force, "anchor")) bytes += sizeof(Vec3);
    if (force.contains("anchor") && force["anchor"] == "start") bytes += 3 * scalar_bytes;
  }
  return bytes;
}

std::size_t read_count(const Node& node, const json& scene, const ReadOptions& options) {
  const auto count = node.whole(1, most_particles);
  const auto each = bytes_each(scene, options.scalar_bytes);
  const auto most = options.memory_bytes / each;
  if (count > most) {
    node.refuse(fmt::format("at most {}: a particle of this scene takes {} bytes, and {:.1f} GB of memory are available", most,
                            each, static_cast<double>(options.memory_bytes) * 1e-9));
  }
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

struct ReadParticles {
  Particles particles;
  Scalars mass = 1.0;
  Population population;
};

ReadParticles read_particles(const Fields& fields, const SceneFile& file, const ReadOptions& options) {
  ReadParticles read;
  read.population.folder = std::filesystem::path(file.path).parent_path();
  const auto network = fields.optional("network");
  const auto made = network ? particles_of_networks(*network) : NetworkParticles{};
  if (made.made) read.population.count = made.count;
  if (made.made && !fields.optional("particles")) return read;
  const Fields particles(fields.required("particles"), "particles", {"count", "mass", "position", "velocity"});
  if (!made.made) {
    read.particles.count = read_count(particles.required("count"), fields.node().json(), options);
    read.population.count = read.particles.count;
  } else if (const auto count = particles.optional("count")) {
    read.population.count = count->whole(1, most_particles);
  }
  if (const auto mass = particles.optional("mass")) read.mass = read_scalars(*mass, read.population, positive);
  if (const auto node = particles.optional("position")) read.particles.position = read_vectors(*node, read.population);
  if (const auto node = particles.optional("velocity")) read.particles.velocity = read_vectors(*node, read.population);
  return read;
}

// Both are checked like everything else, so that a scene is right before the version that runs it is here.
void refuse_what_is_not_built(const Fields& fields, const Population& population) {
  const auto network = fields.optional("network");
  const auto constraints = fields.optional("constraints");
  if (network) check_networks(*network, population);
  if (constraints) check_constraints(*constraints, population);
  if (network)
    network->fail("is there, and this version of dvdx does not run networks yet: it runs particles without neighbours");
  if (constraints && !constraints->json().empty()) {
    constraints->fail("is there, and this version of dvdx does not run constraints yet");
  }
}

SceneFile scene_of(const std::string& path, const json& root, const ReadOptions& options) {
  const Node node(root, "", path);
  check_format(node);
  const Fields fields(node, "a scene",
                      {"format", "name", "about", "step", "duration", "method", "particles", "forces", "contacts", "network",
                       "constraints", "fixed"});
  SceneFile file;
  file.path = path;
  (void)fields.required("format");
  file.name = fields.required("name").text();
  if (const auto about = fields.optional("about")) file.about = about->text();
  file.step = fields.required("step").number(positive);
  file.duration = read_duration(fields.required("duration"), file.step);
  file.scene.method = fields.choice("method", methods, Method::combined);
  auto [particles, mass, population] = read_particles(fields, file, options);
  file.particles = std::move(particles);
  file.scene.mass = std::move(mass);
  if (const auto forces = fields.optional("forces")) {
    for (const auto& force : forces->elements("a list of forces")) file.scene.add(read_force(force, population));
  }
  if (const auto contacts = fields.optional("contacts")) {
    for (const auto& contact : contacts->elements("a list of contacts")) file.scene.add(read_contact(contact));
  }
  if (const auto fixed = fields.optional("fixed")) file.scene.fixed = read_ids(*fixed, population);
  refuse_what_is_not_built(fields, population);
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

// What Linux says is free without swapping; elsewhere all there is.
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

SceneFile parse_scene(const std::string& path, std::string_view text, const ReadOptions& options) {
  check_encoding(path, text);
  json root = parse_json(path, text);
  for (const auto& assignment : options.overrides) apply_override(root, path, assignment);
  return scene_of(path, root, options);
}

SceneFile read_scene(const std::string& path, const ReadOptions& options) {
  const auto text = read_file(path);
  if (!text) throw Fault(Exit::input_output, path + ": " + text.error());
  return parse_scene(path, *text, options);
}

}  // namespace dvdx::tool
