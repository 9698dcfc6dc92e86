#include "scene_io/network_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <string>

#include "scene_io/air_reader.hpp"
#include "scene_io/coupling_reader.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/grid_reader.hpp"
#include "scene_io/json_text.hpp"
#include "scene_io/mesh_reader.hpp"
#include "scene_io/names.hpp"
#include "scene_io/pair_reader.hpp"

namespace dvdx::tool {
namespace {

enum class Kind { grid, mesh, springs };

constexpr std::array<Named<Kind>, 3> kinds{{{"grid", Kind::grid}, {"mesh", Kind::mesh}, {"springs", Kind::springs}}};
constexpr std::array<std::string_view, 2> grid_groups{"corners_top", "edge_top"};
constexpr Range above_one{.min = 1, .least = Range::Least::excluded, .text = "a finite number > 1"};

Kind kind_of(const Node& network) {
  if (!network.json().is_object()) network.refuse("an object, or a list of objects");
  if (!network.json().contains("type")) network.fail("has no type: must be a grid, a mesh or springs");
  return network.at("type").choice(kinds);
}

Fields fields_of(const Node& network) {
  const auto kind = kind_of(network);
  std::vector<std::string_view> keys{"type",  "damping", "fixed", "scheme", "substeps", "most_substeps", "method",
                                     "theta", "sweep",   "lines", "axis",   "broken",   "tears_at"};
  const auto add = [&](std::initializer_list<std::string_view> more) { keys.insert(keys.end(), more); };
  if (kind == Kind::grid)
    add({"rows", "columns", "origin", "edge_u", "edge_v", "mass", "structural", "shear", "bend", "aerodynamics"});
  if (kind == Kind::mesh) add({"file", "mass", "edge", "bend", "bending", "aerodynamics", "weld", "unreferenced"});
  if (kind != Kind::springs) add({"strain_limit"});
  if (kind == Kind::springs) add({"pairs", "stiffness", "rest_length"});
  return {network, "a network of type " + std::string(name_in(kinds, kind)), std::move(keys)};
}

Springs read_springs(const Fields& fields, const Population& population) {
  auto pairs = read_pairs(fields.required("pairs"), population);
  const auto of_pairs = population_of(pairs, population);
  return {.pairs = std::move(pairs),
          .stiffness = read_scalars(fields.required("stiffness"), of_pairs, Range::non_negative),
          .rest_length = read_lengths(fields.required("rest_length"), of_pairs, Range::non_negative),
          .damping = fields.number("damping", Range::non_negative, 0)};
}

void add_torn(const Fields& fields, const Population& population, Network network, SceneFile& file) {
  if (const auto broken = fields.optional("broken")) {
    std::visit([&](auto& of) { of.broken = read_pairs(*broken, population); }, network);
  }
  file.scene.add(std::move(network));
  file.tears_at.resize(file.scene.networks.size(), std::numeric_limits<double>::infinity());
  if (const auto tears_at = fields.optional("tears_at")) file.tears_at.back() = tears_at->number(above_one);
}

void fix_group(const Node& group, const MadeNetwork& made, std::vector<std::size_t>& fixed) {
  if (made.columns == 0) group.refuse("a particle id");
  const bool is_edge = group.choice(std::span<const std::string_view>(grid_groups)) == 1;
  const auto last = made.columns - 1;
  for (std::size_t c = 0; c <= last; ++c) {
    if (is_edge || c == 0 || c == last) fixed.push_back(made.first_number + c);
  }
}

void read_fixed(const Node& node, const MadeNetwork& made, const Population& population, std::vector<std::size_t>& fixed) {
  if (node.json().is_string()) return fix_group(node, made, fixed);
  for (const auto& element : node.elements("a list of particle ids")) {
    if (element.json().is_string()) {
      fix_group(element, made, fixed);
    } else {
      fixed.push_back(element.whole(0, population.count - 1));
    }
  }
}

void check_room(const Node& node, std::uint64_t count, const Room& room) {
  constexpr std::uint64_t numbered = std::numeric_limits<std::uint32_t>::max();
  if (count > numbered) node.fail(fmt::format("brings the scene to {} particles: must be at most {}", count, numbered));
  if (count > room.most()) node.fail(fmt::format("brings the scene to {} particles: must be {}", count, room.limit()));
}

void check_finite(const Node& node, const Vec3& position) {
  const bool is_finite = std::isfinite(position[0]) && std::isfinite(position[1]) && std::isfinite(position[2]);
  if (!is_finite) node.fail("puts particles beyond double precision: must have finite positions");
}

template <class List>
void append(List more, List& list) {
  if (list.empty()) return list.swap(more);
  list.insert(list.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

NetworkReader::NetworkReader(const Node& network, SceneFolder& folder, const Room& room, ReadTopology topology)
    : nodes_(network.json().is_array() ? network.elements("") : std::vector<Node>{network}),
      folder_(folder),
      room_(room),
      topology_(topology) {
  for (const auto& node : nodes_) {
    auto& made = made_.emplace_back();
    made.first = count();
    made.first_number = numbers();
    const auto kind = kind_of(node);
    if (kind == Kind::grid) make_grid(node, made);
    if (kind == Kind::mesh) make_mesh(node, made);
  }
}

std::size_t NetworkReader::count() const noexcept {
  return std::accumulate(particles_.begin(), particles_.end(), std::size_t{0},
                         [](std::size_t sum, const MadeParticles& made) { return sum + made.count; });
}

namespace {

std::size_t numbers_of(const MadeParticles& made) {
  return made.numbering.is_own() ? made.count : made.numbering.particles.size();
}

}  // namespace

std::size_t NetworkReader::numbers() const noexcept {
  return std::accumulate(particles_.begin(), particles_.end(), std::size_t{0},
                         [](std::size_t sum, const MadeParticles& made) { return sum + numbers_of(made); });
}

Numbering NetworkReader::numbering() const {
  Numbering all;
  if (std::ranges::all_of(particles_, [](const MadeParticles& made) { return made.numbering.is_own(); })) return all;
  for (const MadeParticles& made : particles_) {
    const auto first = static_cast<std::uint32_t>(all.numbers.size());
    const auto first_number = static_cast<std::uint32_t>(all.particles.size());
    const bool is_own = made.numbering.is_own();
    for (std::size_t n = 0; n < numbers_of(made); ++n) {
      const auto particle = is_own ? static_cast<std::uint32_t>(n) : made.numbering.particles[n];
      all.particles.push_back(particle == Numbering::nobody ? particle : first + particle);
    }
    for (std::size_t i = 0; i < made.count; ++i) {
      all.numbers.push_back(first_number + static_cast<std::uint32_t>(made.numbering.number_of(i)));
    }
    all.still.insert(all.still.end(), made.numbering.still.begin(), made.numbering.still.end());
  }
  return all;
}

Vectors NetworkReader::take_positions() {
  if (particles_.size() == 1) return std::move(particles_.front().positions);
  std::vector<Vec3> all;
  all.reserve(count());
  for (const MadeParticles& made : particles_) {
    for (std::size_t i = 0; i < made.count; ++i) all.push_back(value_of(made.positions, i));
  }
  return all;
}

Scalars NetworkReader::masses() const {
  const auto is_like_first = [&](const MadeParticles& made) { return made.mass == particles_.front().mass; };
  if (std::all_of(particles_.begin(), particles_.end(), is_like_first)) return particles_.front().mass;
  std::vector<double> each;
  each.reserve(count());
  for (const MadeParticles& made : particles_) each.insert(each.end(), made.count, made.mass);
  return each;
}

void NetworkReader::add_particles(const Node& node, MadeParticles made) {
  made.mass /= static_cast<double>(made.count);
  if (!(made.mass > 0)) node.at("mass").fail("leaves each particle a mass of zero: must be larger");
  particles_.push_back(std::move(made));
}

void NetworkReader::make_grid(const Node& node, MadeNetwork& made) {
  const auto fields = fields_of(node);
  auto keys = read_grid(fields);
  auto& grid = keys.grid;
  grid.first = made.first;
  made.columns = grid.columns;
  check_room(node, made.first + grid.rows * grid.columns, room_);
  MadeParticles particles{.count = grid.rows * grid.columns, .positions = positions_of(keys), .mass = keys.mass};
  std::array<Vec3, 4> hull;
  std::ranges::transform(corners_of(grid), hull.begin(), [&](std::size_t i) { return value_of(particles.positions, i); });
  for (const Vec3& corner : hull) check_finite(node, corner);
  add_particles(node, std::move(particles));
  if (!is_rope(grid)) look_at_units(node, hull, particles_.back().mass);
  if (!is_rope(grid)) {
    made.network = grid;
  } else if (auto rope = rope_of(grid); !rope.pairs.empty()) {
    made.network = std::move(rope);
  }
  if (const auto limit = fields.optional("strain_limit"))
    made.strain_limit = limit_of(grid, limit->number(Range::non_negative));
  if (topology_ == ReadTopology::yes) made.topology = topology_of(grid, made.first_number);
}

void NetworkReader::look_at(const Node& mesh, const MeshFacts& facts) {
  const auto file = mesh.at("file");
  meshes_.push_back({.file = file.text(), .facts = facts});
  const auto warn = [&](const char* code, std::size_t value, std::size_t limit, const std::string& what, std::string cure) {
    warnings_.push_back({.code = code,
                         .text = fmt::format("{} is {}: {}", file.path(), shown(file.json()), what),
                         .value = static_cast<double>(value),
                         .limit = static_cast<double>(limit),
                         .cure = std::move(cure)});
  };
  if (facts.pieces == 0) {
    warn("no_faces", facts.vertices, 0,
         fmt::format("it has no face and no line, so that its {} vertices are loose", facts.vertices),
         "Write the file with faces (f)");
  } else if (facts.unreferenced != 0 && !mesh.json().contains("unreferenced")) {
    warn("unreferenced_vertices", facts.unreferenced, 0,
         fmt::format("{} of its {} vertices are in no face and no line, and are left out", facts.unreferenced, facts.vertices),
         "\"unreferenced\": \"keep\" in the network makes them free particles, \"leave_out\" says that it is meant");
  }
  if (facts.near != 0) {
    warn("pieces", facts.pieces, 1,
         fmt::format("its {} pieces fall apart where {} particles stand within {:.2g} m of another piece's", facts.pieces,
                     facts.near, facts.apart),
         fmt::format("\"weld\": {} in the network makes them one",
                     facts.apart > 0 ? fmt::format("{:.1e}", 1.06 * facts.apart) : "0"));
  }
}

// Warns of cloth in millimetres or in grams: it moves unlike any real cloth, although none of its numbers is invalid.
void NetworkReader::look_at_units(const Node& sheet, std::span<const Vec3> hull, double mass) {
  constexpr double widest = 100;     // m
  constexpr double lightest = 1e-6;  // kg
  double width = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = hull.front()[axis];
    double high = low;
    for (const Vec3& x : hull) {
      low = std::min(low, x[axis]);
      high = std::max(high, x[axis]);
    }
    width = std::max(width, high - low);
  }
  const auto warn = [&](const std::string& what, double value, double limit, const char* cure) {
    warnings_.push_back({.code = "units",
                         .text = fmt::format("{} {}", sheet.path().empty() ? "network" : sheet.path(), what),
                         .value = value,
                         .limit = limit,
                         .cure = cure});
  };
  if (width > widest) {
    warn(fmt::format("is {:.4g} m wide", width), width, widest,
         "Give lengths in m: 0.001 for each mm of the program that wrote it");
  }
  if (mass < lightest) {
    warn(fmt::format("has particles of {:.3g} kg each", mass), mass, lightest,
         "Give the mass of all particles together, in kg: 0.001 for each g");
  }
}

void NetworkReader::make_mesh(const Node& node, MadeNetwork& made) {
  const auto fields = fields_of(node);
  const double mass = fields.required("mass").number(Range::positive);
  const double edge = fields.number("edge", Range::non_negative, 0);
  const double bend = fields.number("bend", Range::non_negative, 0);
  const auto source = mesh_of(fields.required("file"), folder_);
  auto [mesh, numbering, facts] = welded(fields, source);
  look_at(node, facts);
  check_room(node, made.first_number + source.vertices.size(), room_);
  auto springs = springs_of(mesh, made.first, edge, bend);
  springs.damping = fields.number("damping", Range::non_negative, 0);
  bend_by_angles(fields, mesh, made.first, springs);
  springs.aerodynamics = read_aerodynamics(fields);
  springs.triangles = triangles_of(mesh.faces, made.first);
  if (springs.aerodynamics && springs.triangles.empty()) {
    fields.required("aerodynamics").fail("is there, and the mesh has no faces: must be left out");
  }
  if (!springs.pairs.empty() || springs.aerodynamics) made.network = std::move(springs);
  if (const auto limit = fields.optional("strain_limit")) {
    made.strain_limit = limit_of(mesh, made.first, limit->number(Range::non_negative));
  }
  if (topology_ == ReadTopology::yes) made.topology = topology_of(source, made.first_number);
  const std::size_t count = mesh.vertices.size();
  look_at_units(node, mesh.vertices, mass / static_cast<double>(count));
  if (count == source.vertices.size()) numbering = {};
  add_particles(node, {.count = count, .positions = std::move(mesh.vertices), .mass = mass, .numbering = std::move(numbering)});
}

void NetworkReader::add_to(SceneFile& file, const Population& population) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const auto& node = nodes_[n];
    auto& made = made_[n];
    const auto kind = kind_of(node);
    const auto fields = fields_of(node);
    const auto coupling = read_coupling(fields, file.scene.method);
    if (n == 0) file.scene.coupling = coupling;
    check_alike(node, file.scene.coupling, coupling);
    if (made.network) add_torn(fields, population, std::move(*made.network), file);
    if (made.strain_limit && !made.strain_limit->pairs.empty()) file.scene.add(std::move(*made.strain_limit));
    append(std::move(made.topology.lines), file.topology.lines);
    append(std::move(made.topology.faces), file.topology.faces);
    append(std::move(made.topology.nets), file.topology.nets);
    if (kind == Kind::springs) {
      auto springs = read_springs(fields, population);
      if (topology_ == ReadTopology::yes) add_lines(springs.pairs, file);
      if (!springs.pairs.empty()) add_torn(fields, population, Network(std::move(springs)), file);
    }
    if (const auto fixed = fields.optional("fixed")) {
      std::vector<std::size_t> numbers;
      read_fixed(*fixed, made, population, numbers);
      append(particles_of(numbers, population), file.scene.fixed);
    }
  }
  append(std::move(meshes_), file.meshes);
  append(std::move(warnings_), file.warnings);
  if (std::none_of(file.tears_at.begin(), file.tears_at.end(), [](double at) { return std::isfinite(at); }))
    file.tears_at.clear();
}

std::vector<std::size_t> NetworkReader::read_group(const Node& node, const Population& population) const {
  const auto grid = std::find_if(made_.begin(), made_.end(), [](const MadeNetwork& made) { return made.columns != 0; });
  std::vector<std::size_t> ids;
  read_fixed(node, grid != made_.end() ? *grid : MadeNetwork{}, population, ids);
  return ids;
}

void refuse_tearing(const SceneFile& file, std::string_view command) {
  if (file.tears_at.empty()) return;
  throw Fault(Exit::bad_scene,
              fmt::format("{}: network.tears_at: dvdx {} tears no springs: must be left out", file.path, command));
}

}  // namespace dvdx::tool
