#include "scene_io/scene_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "scene_io/air_reader.hpp"
#include "scene_io/constraint_reader.hpp"
#include "scene_io/contact_reader.hpp"
#include "scene_io/coupling_reader.hpp"
#include "scene_io/described.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/json_text.hpp"
#include "scene_io/meet_reader.hpp"
#include "scene_io/motion_reader.hpp"
#include "scene_io/names.hpp"
#include "scene_io/network_reader.hpp"
#include "scene_io/overrides.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/room.hpp"
#include "scene_io/seeds.hpp"
#include "scene_io/skin_reader.hpp"
#include "scene_io/steps.hpp"
#include "scene_io/turnover_reader.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;

constexpr std::string_view format = "dvdx-scene/1";

void check_format(const Node& root) {
  if (!root.json().is_object() || !root.json().contains("format")) return;  // reported with the other keys
  const auto field = root.at("format");
  if (field.json() != std::string(format)) field.refuse('"' + std::string(format) + '"');
}

double read_duration(const Node& node, double step) {
  const double duration = node.number(Range::non_negative);
  const auto steps = steps_in(duration, step);
  if (!steps) node.refuse(steps.error());
  return duration;
}

// Reads the particles that the scene lists itself.
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
  if (const auto mass = particles.optional("mass")) file.scene.mass = read_scalars(*mass, population, Range::positive);
  if (const auto node = particles.optional("position")) file.particles.position = read_vectors(*node, population);
  if (const auto node = particles.optional("velocity")) file.particles.velocity = read_vectors(*node, population);
}

// Takes the particles that networks make. The scene may give their velocity.
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

// Reads the scene's fixed particles and joins them with those of its networks, each once and in order.
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
  file.step = fields.required("step").number(Range::positive);
  file.duration = read_duration(fields.required("duration"), file.step);
  file.scene.method = fields.choice("method", methods, Method::combined);
  SceneFolder folder(std::filesystem::path(path).parent_path());
  Population population{.count = 0, .folder = &folder};
  const auto networks = read_particles_and_networks(fields, file, population, options);
  const auto motions = read_motions(fields, file.scene);
  file.motions = motions.all();
  const DescribedReader reader{.population = &population, .motions = &motions};
  if (const auto forces = fields.optional("forces")) {
    for (const auto& force : forces->elements("a list of forces")) file.scene.add(reader.read_one_of<Force>(force, "force"));
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
  file.scene.faces = fields.choice("faces", named_choices<Faces>, Faces::automatic);
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
