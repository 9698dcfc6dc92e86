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

#include "dvdx/bending.hpp"
#include "scene_io/air_reader.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/json_text.hpp"
#include "scene_io/mesh_file.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

std::optional<int> read_substeps(const Node& node) {
  if (node.json() == "auto") return std::nullopt;
  if (node.json().is_string()) node.refuse("\"auto\" or a whole number");
  return static_cast<int>(node.whole(1, most_substeps));
}

}  // namespace

void read_substeps(const Fields& fields, Coupling& coupling) {
  if (const auto substeps = fields.optional("substeps")) coupling.substeps = read_substeps(*substeps);
  if (const auto most = fields.optional("most_substeps")) {
    coupling.most_substeps =
        static_cast<int>(most->whole(static_cast<std::uint64_t>(coupling.substeps.value_or(1)), most_substeps));
  }
}

namespace {

enum class Kind { grid, mesh, springs };
enum class Joint { distance, point, line };

constexpr std::array<Named<Kind>, 3> kinds{{{"grid", Kind::grid}, {"mesh", Kind::mesh}, {"springs", Kind::springs}}};
constexpr std::array<Named<Joint>, 3> joints{{{"distance", Joint::distance}, {"point", Joint::point}, {"line", Joint::line}}};
constexpr std::array<std::string_view, 2> grid_groups{"corners_top", "edge_top"};
constexpr std::uint64_t most_rows = 1 << 20;
constexpr Range above_one{.min = 1, .least = Range::Least::excluded, .text = "a finite number > 1"};

// ---- keys --------------------------------------------------------------------------------------------------------------

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

double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

Vec3 direction_of(const Node& node) {
  const auto direction = node.vector();
  if (direction == Vec3{}) node.refuse("a vector that is not zero");
  return direction;
}

std::vector<Pair> read_pairs(const Node& node, const Population& population) {
  std::vector<Pair> pairs;
  for (const auto& element : node.elements("a list of pairs [i, j]")) {
    const auto ids = element.elements("a pair [i, j]");
    if (ids.size() != 2) element.refuse("a pair [i, j]");
    const Pair pair{static_cast<std::uint32_t>(read_particle(ids[0], population)),
                    static_cast<std::uint32_t>(read_particle(ids[1], population))};
    if (pair[0] == pair[1]) ids[1].refuse("another particle than the pair's first");
    pairs.push_back(pair);
  }
  return pairs;
}

// One for each pair, or none where they are those of the start.
std::optional<Scalars> read_lengths(const Node& node, const Population& pairs, const Range& range) {
  if (node.json() == "start") return std::nullopt;
  if (node.json().is_string()) node.refuse("\"start\", a number or an object with one of values, uniform, file");
  return read_scalars(node, pairs, range);
}

Population population_of(const std::vector<Pair>& pairs, const Population& population) {
  return {.count = pairs.size(), .folder = population.folder, .of = "pair"};
}

void add_lines(const std::vector<Pair>& pairs, SceneFile& file) {
  for (const Pair& pair : pairs) file.topology.lines.push_back(file.numbering.numbers_of(pair));
}

// ---- grids -------------------------------------------------------------------------------------------------------------

struct GridKeys {
  Grid grid;
  Vec3 origin{};
  double mass = 0;
};

// One row needs no second edge.
Vec3 edge_of(const Node& node, std::size_t points) { return points > 1 ? direction_of(node) : node.vector(); }

GridKeys read_grid(const Fields& fields) {
  GridKeys keys;
  auto& grid = keys.grid;
  grid.rows = fields.required("rows").whole(1, most_rows);
  grid.columns = fields.required("columns").whole(1, most_rows);
  keys.origin = fields.required("origin").vector();
  grid.edge_u = edge_of(fields.required("edge_u"), grid.columns);
  grid.edge_v = edge_of(fields.required("edge_v"), grid.rows);
  keys.mass = fields.required("mass").number(positive);
  grid.structural = fields.number("structural", not_negative, 0);
  grid.shear = fields.number("shear", not_negative, 0);
  grid.bend = fields.number("bend", not_negative, 0);
  grid.damping = fields.number("damping", not_negative, 0);
  grid.aerodynamics = read_aerodynamics(fields);
  if (grid.aerodynamics && (grid.rows == 1 || grid.columns == 1)) {
    fields.required("aerodynamics").fail("is there, and a grid of one row or one column has no triangles: must be left out");
  }
  return keys;
}

SheetVectors positions_of(const GridKeys& keys) {
  const auto& grid = keys.grid;
  return {.rows = grid.rows, .columns = grid.columns, .origin = keys.origin, .edge_u = grid.edge_u, .edge_v = grid.edge_v};
}

// No particle is farther out along an axis than one of them.
std::array<std::size_t, 4> corners_of(const Grid& grid) {
  const std::size_t last_row = (grid.rows - 1) * grid.columns;
  return {0, grid.columns - 1, last_row, last_row + grid.columns - 1};
}

// A grid of one row or one column, as the list of its springs.
Springs rope_of(const Grid& grid) {
  const std::size_t points = grid.rows * grid.columns;
  const double piece = length(grid.rows == 1 ? grid.edge_u : grid.edge_v) / static_cast<double>(points - 1);
  Springs rope{.pairs = {}, .damping = grid.damping};
  std::vector<double> stiffness;
  std::vector<double> rest_length;
  const auto join = [&](std::size_t every, double k) {
    for (std::size_t i = 0; k > 0 && i + every < points; ++i) {
      rope.pairs.push_back({static_cast<std::uint32_t>(grid.first + i), static_cast<std::uint32_t>(grid.first + i + every)});
      stiffness.push_back(k);
      rest_length.push_back(static_cast<double>(every) * piece);
    }
  };
  join(1, grid.structural);
  join(2, grid.bend);
  rope.stiffness = std::move(stiffness);
  rope.rest_length = Scalars(std::move(rest_length));
  return rope;
}

// The sides of its cells, none longer than 1 + limit times what it is in the flat sheet.
Distance limit_of(const Grid& grid, double limit) {
  Distance distance{.pairs = {}, .length = {}, .bound = Bound::at_most};
  std::vector<double> lengths;
  const auto at = [&](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(grid.first + r * grid.columns + c); };
  const auto join = [&](std::size_t down, std::size_t right, double side) {
    for (std::size_t r = 0; r + down < grid.rows; ++r) {
      for (std::size_t c = 0; c + right < grid.columns; ++c) {
        distance.pairs.push_back({at(r, c), at(r + down, c + right)});
        lengths.push_back((1 + limit) * side);
      }
    }
  };
  if (grid.columns > 1) join(0, 1, length(grid.edge_u) / static_cast<double>(grid.columns - 1));
  if (grid.rows > 1) join(1, 0, length(grid.edge_v) / static_cast<double>(grid.rows - 1));
  distance.length = Scalars(std::move(lengths));
  return distance;
}

bool is_rope(const Grid& grid) { return grid.rows == 1 || grid.columns == 1; }

Topology topology_of(const Grid& grid, std::size_t first) {
  Topology topology;
  const auto at = [&](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(first + r * grid.columns + c); };
  if (is_rope(grid)) {
    for (std::size_t i = 1; i < grid.rows * grid.columns; ++i) topology.lines.push_back({at(0, i - 1), at(0, i)});
    return topology;
  }
  if (is_net(grid)) {
    topology.nets.push_back({at(0, 0), static_cast<std::uint32_t>(grid.rows * grid.columns)});
  }
  topology.faces.reserve((grid.rows - 1) * (grid.columns - 1));
  for (std::size_t r = 1; r < grid.rows; ++r) {
    for (std::size_t c = 1; c < grid.columns; ++c) {
      topology.faces.push_back({at(r - 1, c - 1), at(r - 1, c), at(r, c), at(r, c - 1)});
    }
  }
  return topology;
}

// ---- meshes ------------------------------------------------------------------------------------------------------------

constexpr std::array<Named<Unreferenced>, 2> treatments_of_unreferenced{
    {{"leave_out", Unreferenced::left_out}, {"keep", Unreferenced::kept}}};

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

// The sides and, of four-sided faces, the diagonals with one stiffness; the bends with another.
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

// The sides of its faces.
Distance limit_of(const MeshFile& mesh, std::size_t first, double limit) {
  Distance distance{.pairs = {}, .length = {}, .bound = Bound::at_most};
  std::vector<double> lengths;
  for (const auto& [i, j] : edges_of(mesh)) {
    const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[j];
    distance.pairs.push_back({static_cast<std::uint32_t>(first + i), static_cast<std::uint32_t>(first + j)});
    lengths.push_back((1 + limit) * length({b[0] - a[0], b[1] - a[1], b[2] - a[2]}));
  }
  distance.length = Scalars(std::move(lengths));
  return distance;
}

// The mesh is flat where its faces are in one plane; else it flattens.
void bend_by_angles(const Fields& fields, const MeshFile& mesh, std::size_t first, Springs& springs) {
  const double modulus = fields.number("bending", not_negative, 0);
  if (modulus == 0) return;
  const auto node = fields.required("bending");
  const Scheme scheme = fields.choice("scheme", schemes, Scheme::leapfrog);
  if (scheme != Scheme::leapfrog && scheme != Scheme::fourth_order && scheme != Scheme::automatic) {
    node.fail("is " + shown(node.json()) + " in the scheme " + std::string(name_in(schemes, scheme)) +
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

// ---- springs -----------------------------------------------------------------------------------------------------------

Springs read_springs(const Fields& fields, const Population& population) {
  auto pairs = read_pairs(fields.required("pairs"), population);
  const auto of_pairs = population_of(pairs, population);
  return {.pairs = std::move(pairs),
          .stiffness = read_scalars(fields.required("stiffness"), of_pairs, not_negative),
          .rest_length = read_lengths(fields.required("rest_length"), of_pairs, not_negative),
          .damping = fields.number("damping", not_negative, 0)};
}

// ---- what is torn ------------------------------------------------------------------------------------------------------

void add_torn(const Fields& fields, const Population& population, Network network, SceneFile& file) {
  if (const auto broken = fields.optional("broken")) {
    std::visit([&](auto& of) { of.broken = read_pairs(*broken, population); }, network);
  }
  file.scene.add(std::move(network));
  file.tears_at.resize(file.scene.networks.size(), std::numeric_limits<double>::infinity());
  if (const auto tears_at = fields.optional("tears_at")) file.tears_at.back() = tears_at->number(above_one);
}

// ---- what is fixed -----------------------------------------------------------------------------------------------------

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

// ---- how they are stepped ----------------------------------------------------------------------------------------------

// A key that another scheme alone reads says nothing of this one.
void refuse_keys_of(Scheme scheme, std::initializer_list<const char*> keys, const Coupling& own, const Fields& fields) {
  if (own.scheme == scheme) return;
  for (const char* key : keys) {
    if (const auto field = fields.optional(key)) {
      field->fail(
          fmt::format("goes with scheme {}, and this one is {}", name_in(schemes, scheme), name_in(schemes, own.scheme)));
    }
  }
}

Coupling read_coupling(const Fields& fields, Method method) {
  Coupling coupling;
  coupling.scheme = fields.choice("scheme", schemes, Scheme::leapfrog);
  read_substeps(fields, coupling);
  if (const auto theta = fields.optional("theta")) coupling.theta = theta->number(half_to_one);
  coupling.sweeps = fields.choice("sweep", sweep_orders, SweepOrder::symmetric);
  coupling.lines = fields.choice("lines", line_choices, dvdx::Lines::rows);
  coupling.method = fields.choice("method", methods, method);
  coupling.axis = fields.choice("axis", pair_axes, PairAxis::midpoint);
  refuse_keys_of(Scheme::sequential, {"theta", "sweep", "lines"}, coupling, fields);
  refuse_keys_of(Scheme::accumulate, {"method", "axis"}, coupling, fields);
  return coupling;
}

template <class Number>
std::string words_of(const std::optional<Number>& number, const char* none) {
  return number ? fmt::format("{}", *number) : none;
}

// All networks of a scene are stepped together.
void check_alike(const Node& node, const Coupling& first, const Coupling& own) {
  const auto check = [&](const char* key, const std::string& wanted, const std::string& is) {
    if (wanted == is) return;
    const std::string path = node.path() + "." + key;
    const bool given = node.json().contains(key);
    const Node at(given ? node.json()[key] : node.json(), path, node.file());
    at.fail("is " + is + (given ? "" : " where left out") + " and " + wanted +
            " in the first network: must be alike in all, for they are stepped together");
  };
  check("scheme", std::string(name_in(schemes, first.scheme)), std::string(name_in(schemes, own.scheme)));
  check("substeps", words_of(first.substeps, "auto"), words_of(own.substeps, "auto"));
  check("most_substeps", words_of(first.most_substeps, "none"), words_of(own.most_substeps, "none"));
  check("theta", words_of(first.theta, "none"), words_of(own.theta, "none"));
  check("sweep", std::string(name_in(sweep_orders, first.sweeps)), std::string(name_in(sweep_orders, own.sweeps)));
  check("lines", std::string(name_in(line_choices, first.lines)), std::string(name_in(line_choices, own.lines)));
  check("method", std::string(name_in(methods, first.method)), std::string(name_in(methods, own.method)));
  check("axis", std::string(name_in(pair_axes, first.axis)), std::string(name_in(pair_axes, own.axis)));
}

// ---- constraints -------------------------------------------------------------------------------------------------------

Distance read_distance(const Node& node, const Population& population) {
  const Fields fields(node, "a distance constraint", {"type", "pairs", "length", "bound"});
  auto pairs = read_pairs(fields.required("pairs"), population);
  const auto of_pairs = population_of(pairs, population);
  return {.pairs = std::move(pairs),
          .length = read_lengths(fields.required("length"), of_pairs, positive),
          .bound = fields.choice("bound", bounds, Bound::equal)};
}

std::uint32_t particle_in(const Fields& fields, const Population& population) {
  return static_cast<std::uint32_t>(read_particle(fields.required("particle"), population));
}

OnPoint read_point(const Node& node, const Population& population) {
  const Fields fields(node, "a point constraint", {"type", "particle", "at"});
  return {.particle = particle_in(fields, population), .at = fields.required("at").vector()};
}

OnLine read_line(const Node& node, const Population& population) {
  const Fields fields(node, "a line constraint", {"type", "particle", "through", "direction"});
  return {.particle = particle_in(fields, population),
          .through = fields.required("through").vector(),
          .direction = direction_of(fields.required("direction"))};
}

Constraint read_constraint(const Node& node, const Population& population) {
  if (!node.json().is_object()) node.refuse("an object");
  if (!node.json().contains("type")) node.fail("has no type: must be a distance, a point or a line");
  switch (node.at("type").choice(joints)) {
    case Joint::distance:
      return read_distance(node, population);
    case Joint::point:
      return read_point(node, population);
    case Joint::line:
      return read_line(node, population);
  }
  node.refuse("a constraint");
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

MeshFile mesh_of(const Node& node, SceneFolder& folder) {
  if (!node.text().ends_with(".obj")) node.refuse("the name of an .obj file");
  try {
    return read_mesh(folder.find(node));
  } catch (const FileFault& fault) {
    node.fail("is " + shown(node.json()) + ": " + fault.what());
  }
}

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
  if (const auto limit = fields.optional("strain_limit")) made.strain_limit = limit_of(grid, limit->number(not_negative));
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

// Cloth in millimetres, or in grams, moves as nothing does that is seen, and no number of it is wrong.
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
  const double mass = fields.required("mass").number(positive);
  const double edge = fields.number("edge", not_negative, 0);
  const double bend = fields.number("bend", not_negative, 0);
  const auto source = mesh_of(fields.required("file"), folder_);
  auto [mesh, numbering, facts] = welded(fields, source);
  look_at(node, facts);
  check_room(node, made.first_number + source.vertices.size(), room_);
  auto springs = springs_of(mesh, made.first, edge, bend);
  springs.damping = fields.number("damping", not_negative, 0);
  bend_by_angles(fields, mesh, made.first, springs);
  springs.aerodynamics = read_aerodynamics(fields);
  springs.triangles = triangles_of(mesh.faces, made.first);
  if (springs.aerodynamics && springs.triangles.empty()) {
    fields.required("aerodynamics").fail("is there, and the mesh has no faces: must be left out");
  }
  if (!springs.pairs.empty() || springs.aerodynamics) made.network = std::move(springs);
  if (const auto limit = fields.optional("strain_limit")) {
    made.strain_limit = limit_of(mesh, made.first, limit->number(not_negative));
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

void read_constraints(const Node& constraints, SceneFile& file, const Population& population, ReadTopology topology) {
  for (const auto& node : constraints.elements("a list of constraints")) {
    auto constraint = read_constraint(node, population);
    const auto* const distance = std::get_if<Distance>(&constraint);
    if (distance != nullptr && topology == ReadTopology::yes) add_lines(distance->pairs, file);
    file.scene.add(std::move(constraint));
  }
}

}  // namespace dvdx::tool
