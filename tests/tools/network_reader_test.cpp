// The networks and constraints of a scene: the reader's result, and its refusals.
#include <doctest/doctest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "support/close.hpp"
#include "support/paths.hpp"
#include "tools/schema.hpp"
#include "tools/scratch_folder.hpp"

namespace network_reader_test {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::Schema;
using nlohmann::json;

const ReadOptions plenty{.memory_bytes = 1000000000};

Schema scene_schema() {
  std::ifstream file(dvdx::test::schema());
  return Schema(json::parse(file));
}

json empty_scene() { return {{"format", "dvdx-scene/1"}, {"name", "cloth"}, {"step", 0.5}, {"duration", 1}}; }

json with_network(const std::string& network) {
  json scene = empty_scene();
  scene["network"] = json::parse(network);
  return scene;
}

json with_particles(std::size_t count) {
  json scene = empty_scene();
  scene["particles"] = {{"count", count}};
  return scene;
}

SceneFile read(const json& scene, const std::string& path = "cloth.json") { return parse_scene(path, scene.dump(), plenty); }

std::string message_of(const json& scene, const std::string& path = "cloth.json") {
  try {
    (void)read(scene, path);
    return "";
  } catch (const Fault& fault) {
    CHECK(fault.exit() == Exit::bad_scene);
    return fault.what();
  }
}

constexpr const char* grid = R"({"type":"grid","rows":3,"columns":5,"origin":[1,2,3],"edge_u":[2,0,0],"edge_v":[0,0,-4],
                                 "mass":30,"structural":9,"shear":3,"bend":1,"damping":0.5})";

// ---- grids -------------------------------------------------------------------------------------------------------------

TEST_CASE("a grid makes its particles row by row from its origin") {
  const auto file = read(with_network(grid));
  REQUIRE(file.particles.count == 15);
  CHECK(value_of(file.particles.position, 0) == Vec3{1, 2, 3});
  CHECK(value_of(file.particles.position, 4) == Vec3{3, 2, 3});
  CHECK(value_of(file.particles.position, 5) == Vec3{1, 2, 1});
  CHECK(value_of(file.particles.position, 11) == Vec3{1.5, 2, -1});
  CHECK(value_of(file.particles.velocity, 11) == Vec3{});
  CHECK(file.scene.mass == Scalars(2.0));
  REQUIRE(file.scene.networks.size() == 1);
  CHECK(std::get<Grid>(file.scene.networks[0]) == Grid{.rows = 3,
                                                       .columns = 5,
                                                       .first = 0,
                                                       .edge_u = {2, 0, 0},
                                                       .edge_v = {0, 0, -4},
                                                       .structural = 9,
                                                       .shear = 3,
                                                       .bend = 1,
                                                       .damping = 0.5});
  CHECK(file.scene.coupling == Coupling{.method = Method::combined});
  CHECK(file.scene.fixed.empty());
  CHECK(file.topology.lines.empty());
  REQUIRE(file.topology.faces.size() == 8);
  CHECK(file.topology.faces[5] == std::vector<std::uint32_t>{6, 7, 12, 11});
}

TEST_CASE("a grid held by its sides alone is a net, and a grid with shear, bend or air is cloth") {
  auto net = json::parse(grid);
  net.erase("shear");
  net.erase("bend");
  auto scene = empty_scene();
  scene["network"] = {json::parse(grid), net, net, net};
  scene["network"][0].erase("shear");
  scene["network"][2]["aerodynamics"] = {{"density", 1.2}};
  const auto file = read(scene);
  CHECK(file.topology.faces.size() == 32);
  CHECK(file.topology.nets == std::vector<Pair>{{15, 15}, {45, 15}});
  auto sheared = scene;
  sheared["network"][1]["shear"] = 1;
  CHECK(read(sheared).topology.nets == std::vector<Pair>{{45, 15}});
}

TEST_CASE("a grid's particles may be given a velocity, but not a mass") {
  auto scene = with_network(grid);
  scene["particles"] = json::parse(R"({"velocity":{"uniform":{"min":[0,0,0],"max":[1,1,1],"seed":1}},"count":15})");
  CHECK(value_of(read(scene).particles.velocity, 14) != Vec3{});
  CHECK(scene_schema().accepts(scene));
  scene["particles"]["count"] = 16;
  CHECK(message_of(scene) == "cloth.json: particles.count is 16: must be left out, or 15, which is how many the network makes");
  scene["particles"] = {{"mass", 1}};
  CHECK(message_of(scene) == "cloth.json: particles.mass is there, and the network gives it: must be left out");
  scene["particles"] = {{"velocity", {{"values", {{1, 2, 3}}}}}};
  CHECK(message_of(scene) == "cloth.json: particles.velocity.values has 1 entries: must have 15, one for each particle");
}

TEST_CASE("a grid takes aerodynamics, and the wind takes gusts") {
  auto scene = with_network(grid);
  scene["network"]["aerodynamics"] = json::parse(R"({"density":1.3,"drag":0.9,"lift":0.4})");
  scene["wind"] = json::parse("[1,2,3]");
  CHECK(scene_schema().accepts(scene));
  CHECK(std::get<Grid>(read(scene).scene.networks[0]).aerodynamics == Aerodynamics{.density = 1.3, .drag = 0.9, .lift = 0.4});
  CHECK(read(scene).scene.wind == Wind{.mean = {1, 2, 3}});
  scene["network"]["aerodynamics"] = json::object();
  scene["wind"] = json::parse(R"({"mean":[1,0,0],"gusts":[{"amplitude":[0,1,0],"angular_frequency":2,"phase":0.5},
                                  {"amplitude":[3,0,0],"angular_frequency":4}]})");
  CHECK(scene_schema().accepts(scene));
  CHECK(std::get<Grid>(read(scene).scene.networks[0]).aerodynamics == Aerodynamics{});
  CHECK(read(scene).scene.wind == Wind{.mean = {1, 0, 0}, .gusts = {{{0, 1, 0}, 2, 0.5}, {{3, 0, 0}, 4, 0}}});
  const auto refused = [&](const char* air, const char* wind) {
    auto bad = scene;
    bad["network"]["aerodynamics"] = json::parse(air);
    bad["wind"] = json::parse(wind);
    CHECK(!scene_schema().accepts(bad));
    return message_of(bad);
  };
  CHECK(refused(R"({"density":-1})", "[0,0,0]") ==
        "cloth.json: network.aerodynamics.density is -1: must be a finite number >= 0");
  CHECK(refused(R"({"drag":2e6})", "[0,0,0]").find("network.aerodynamics.drag") != std::string::npos);
  CHECK(refused(R"({"mass":1})", "[0,0,0]").find("mass") != std::string::npos);
  CHECK(refused("{}", "[0,0]").find("wind") != std::string::npos);
  CHECK(refused("{}", R"({"gusts":[{"amplitude":[0,0,1]}]})").find("wind.gusts[0]") != std::string::npos);
  scene["network"]["rows"] = 1;
  CHECK(message_of(scene) ==
        "cloth.json: network.aerodynamics is there, and a grid of one row or one column has no triangles: must be left out");
}

TEST_CASE("a network may list springs that are broken, and a stretch at which springs tear") {
  auto scene = with_network(grid);
  CHECK(read(scene).tears_at.empty());
  scene["network"]["broken"] = json::parse("[[0,1],[6,0]]");
  CHECK(scene_schema().accepts(scene));
  CHECK(std::get<Grid>(read(scene).scene.networks[0]).broken == std::vector<Pair>{{0, 1}, {6, 0}});
  scene["network"]["tears_at"] = 1.5;
  CHECK(scene_schema().accepts(scene));
  CHECK(read(scene).tears_at == std::vector<double>{1.5});
  scene["network"] =
      json::array({scene["network"], json::parse(R"({"type":"springs","pairs":[[0,9]],"stiffness":1,"rest_length":1})")});
  CHECK(read(scene).tears_at == std::vector<double>{1.5, std::numeric_limits<double>::infinity()});
  scene["network"][0].erase("tears_at");
  CHECK(read(scene).tears_at.empty());
  for (const char* at : {"1", "-2", "\"soon\""}) {
    scene["network"][1]["tears_at"] = json::parse(at);
    CHECK(!scene_schema().accepts(scene));
    CHECK(message_of(scene) == "cloth.json: network[1].tears_at is " + std::string(at) + ": must be a finite number > 1");
  }
}

TEST_CASE("a torn spring removes the faces beside it and its own line") {
  const Topology whole{.lines = {{4, 5}, {5, 6}}, .faces = {{0, 1, 2, 3}, {1, 2, 4}, {4, 5, 6}}};
  const std::vector<Tear> tears{{.step = 1, .ends = {2, 1}}, {.step = 3, .ends = {5, 6}}, {.step = 3, .ends = {0, 2}}};
  CHECK(without(whole, {}) == whole);
  CHECK(without(whole, std::span(tears).first(1)) == Topology{.lines = whole.lines, .faces = {{4, 5, 6}}});
  CHECK(without(whole, tears) == Topology{.lines = {{4, 5}}, .faces = {}});
  const std::vector<Tear> last_side{{.step = 1, .ends = {0, 3}}};
  CHECK(without(whole, last_side) == Topology{.lines = whole.lines, .faces = {{1, 2, 4}, {4, 5, 6}}});
}

TEST_CASE("a grid of one row or one column is a rope") {
  const auto springs = [](const char* rows_and_columns) {
    auto scene = with_network(grid);
    scene["network"].merge_patch(json::parse(rows_and_columns));
    return read(scene);
  };
  const auto row = springs(R"({"rows":1,"columns":4,"edge_u":[0,3,0],"edge_v":[0,0,0]})");
  const Springs rope{.pairs = {{0, 1}, {1, 2}, {2, 3}, {0, 2}, {1, 3}},
                     .stiffness = std::vector<double>{9, 9, 9, 1, 1},
                     .rest_length = Scalars(std::vector<double>{1, 1, 1, 2, 2}),
                     .damping = 0.5};
  REQUIRE(row.scene.networks.size() == 1);
  CHECK(std::get<Springs>(row.scene.networks[0]) == rope);
  CHECK(value_of(row.particles.position, 3) == Vec3{1, 5, 3});
  CHECK(row.topology.lines == std::vector<Pair>{{0, 1}, {1, 2}, {2, 3}});
  const auto column = springs(R"({"rows":4,"columns":1,"edge_u":[0,0,0],"edge_v":[0,3,0]})");
  CHECK(std::get<Springs>(column.scene.networks[0]) == rope);
  CHECK(value_of(column.particles.position, 3) == Vec3{1, 5, 3});
  CHECK(springs(R"({"rows":1,"columns":1})").scene.networks.empty());
}

// ---- meshes ------------------------------------------------------------------------------------------------------------

TEST_CASE("a mesh's vertices are particles, joined along its edges and across them") {
  const test::ScratchFolder folder("mesh");
  folder.write("fold.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\nf 2 4 3\n");
  auto scene = with_network(R"({"type":"mesh","file":"fold.obj","mass":2,"edge":7,"bend":0.5,"damping":0.1,"fixed":[3]})");
  const auto file = read(scene, folder / "scene.json");
  CHECK(file.particles.count == 4);
  CHECK(value_of(file.particles.position, 3) == Vec3{1, 1, 1});
  CHECK(file.scene.mass == Scalars(0.5));
  REQUIRE(file.scene.networks.size() == 1);
  const auto& springs = std::get<Springs>(file.scene.networks[0]);
  CHECK(springs.pairs == std::vector<Pair>{{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}, {0, 3}});
  CHECK(springs.stiffness == Scalars(std::vector<double>{7, 7, 7, 7, 7, 0.5}));
  CHECK_FALSE(springs.rest_length.has_value());
  CHECK(springs.damping == 0.1);
  CHECK(file.scene.fixed == std::vector<std::size_t>{3});
  CHECK(file.topology.faces == std::vector<std::vector<std::uint32_t>>{{0, 1, 2}, {1, 3, 2}});

  scene["network"]["file"] = "none.obj";
  CHECK(message_of(scene, folder / "s.json")
            .ends_with("network.file is \"none.obj\": cannot be read: No such file or directory"));
  scene["network"]["file"] = "fold.stl";
  CHECK(message_of(scene, folder / "s.json").ends_with("network.file is \"fold.stl\": must be the name of an .obj file"));
  folder.write("bad.obj", "v 0 0 0\nv 1 0 0\n\nf 1 2 3\n");
  scene["network"]["file"] = "bad.obj";
  CHECK(message_of(scene, folder / "s.json")
            .ends_with("network.file is \"bad.obj\": line 4 names vertex 3: must be from 1 to 2, or count back from -1"));
}

TEST_CASE("a mesh may bend by angles, in the schemes and where it is not torn") {
  const test::ScratchFolder folder("bending");
  folder.write("fold.obj", "v 0 0 0\nv 1 0 0\nv 0.5 1 0\nv 0.5 -1 0\nf 1 2 3\nf 2 1 4\n");
  auto scene = with_network(R"({"type":"mesh","file":"fold.obj","mass":4,"edge":7,"bending":0.02})");
  const auto springs_in = [&] { return std::get<Springs>(read(scene, folder / "s.json").scene.networks[0]); };
  const Springs springs = springs_in();
  REQUIRE(springs.pairs.size() == 6);
  CHECK(springs.stiffness[4] == 7);
  CHECK(springs.stiffness[5] == 0);
  CHECK((springs.pairs[5] == Pair{2, 3}));
  // Each cotangent is 1/2, both areas are 1/2: w = x0 + x1 - x2 - x3.
  CHECK(test::is_close(springs.zero_length[5], -0.02, 1e-12));
  scene["network"]["edge"] = 0;
  CHECK(springs_in().pairs.size() == 6);
  scene["network"]["scheme"] = "sequential";
  CHECK(message_of(scene, folder / "s.json")
            .ends_with("network.bending is 0.02 in the scheme sequential: must be left out of another scheme than leapfrog and "
                       "fourth_order"));
  scene["network"]["scheme"] = "fourth_order";
  scene["network"]["tears_at"] = 2;
  CHECK(message_of(scene, folder / "s.json")
            .ends_with("network.bending is 0.02: must be left out of a network that tears (tears_at)"));
  scene["network"].erase("tears_at");
  scene["network"]["bending"] = -1;
  CHECK(message_of(scene, folder / "s.json").ends_with("network.bending is -1: must be a finite number >= 0"));
  scene["network"]["bending"] = 0.02;
  folder.write("fold.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\nf 2 1 4\n");
  CHECK(message_of(scene, folder / "s.json").ends_with("network.bending is 0.02: must be left out where faces have no area"));
  folder.write("fold.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nf 1 2 3\n");
  CHECK(message_of(scene, folder / "s.json")
            .ends_with("network.bending is 0.02: must be left out where no two faces share an edge"));
}

TEST_CASE("a strain limit bounds the sides of a grid's cells and of a mesh's faces") {
  auto scene = with_network(grid);
  scene["network"]["strain_limit"] = 0.25;
  const auto sheet = read(scene);
  REQUIRE(sheet.scene.constraints.size() == 1);
  const auto& sides = std::get<Distance>(sheet.scene.constraints[0]);
  CHECK(sides.bound == Bound::at_most);
  REQUIRE(sides.pairs.size() == 3 * 4 + 2 * 5);
  CHECK((sides.pairs[0] == Pair{0, 1}));
  CHECK((*sides.length)[0] == 0.625);
  CHECK((sides.pairs[12] == Pair{0, 5}));
  CHECK((*sides.length)[12] == 2.5);
  const test::ScratchFolder folder("strain");
  folder.write("fold.obj", "v 0 0 0\nv 2 0 0\nv 1 1 0\nv 1 -1 0\nf 1 2 3\nf 2 1 4\n");
  scene = with_network(R"({"type":"mesh","file":"fold.obj","mass":4,"strain_limit":0})");
  const auto mesh = read(scene, folder / "s.json");
  REQUIRE(mesh.scene.constraints.size() == 1);
  CHECK(std::get<Distance>(mesh.scene.constraints[0]).pairs.size() == 5);
  CHECK((*std::get<Distance>(mesh.scene.constraints[0]).length)[0] == 2);
  scene["network"]["strain_limit"] = -0.1;
  CHECK(message_of(scene, folder / "s.json").ends_with("network.strain_limit is -0.1: must be a finite number >= 0"));
}

TEST_CASE("a contact's mesh is its file's triangles, faces of more sides cut into fans") {
  const test::ScratchFolder folder("body");
  folder.write("wedge.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nf 1 2 3 4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n");
  json scene = with_particles(1);
  scene["contacts"] = json::parse(R"([{"type": "mesh", "file": "wedge.obj", "cell": 0.125, "restitution": 0.5, "friction": 0.25,
    "viscosity": 0.1, "normal_viscosity": 0.2, "response": "seed", "sweep": "line", "thickness": 0.01, "motion": "arm"}])");
  scene["motions"] = json::parse(R"({"arm": {"keys": [{"time": 0}]}})");
  CHECK(scene_schema().accepts(scene));
  const auto file = read(scene, folder / "scene.json");
  const TriangleMesh wanted{.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}, {0, 1, 0}},
                            .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}},
                            .cell = 0.125,
                            .restitution = 0.5,
                            .friction = 0.25,
                            .viscosity = 0.1,
                            .normal_viscosity = 0.2,
                            .response = Response::end_on_surface,
                            .sweep = ContactPath::line,
                            .thickness = 0.01,
                            .motion = 0};
  REQUIRE(file.scene.contacts.size() == 1);
  CHECK(std::get<TriangleMesh>(file.scene.contacts[0]) == wanted);
  const auto refusal = [&](const char* key, const json& value) {
    json bad = scene;
    bad["contacts"][0][key] = value;
    return message_of(bad, folder / "s.json");
  };
  CHECK(refusal("file", "wedge.stl").ends_with("contacts[0].file is \"wedge.stl\": must be the name of an .obj file"));
  CHECK(refusal("file", "none.obj").ends_with("contacts[0].file is \"none.obj\": cannot be read: No such file or directory"));
  CHECK(refusal("cell", 0).ends_with("contacts[0].cell is 0: must be a finite number > 0"));
  CHECK(refusal("side", "inside").find("contacts[0].side") != std::string::npos);
}

TEST_CASE("the diagonals of a mesh's four-sided faces have the stiffness of the sides") {
  const test::ScratchFolder folder("quad");
  folder.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const auto file =
      read(with_network(R"({"type":"mesh","file":"quad.obj","mass":2,"edge":7,"bend":0.5})"), folder / "scene.json");
  const auto& springs = std::get<Springs>(file.scene.networks[0]);
  CHECK(springs.pairs == std::vector<Pair>{{0, 1}, {0, 3}, {1, 2}, {2, 3}, {0, 2}, {1, 3}});
  CHECK(springs.stiffness == Scalars(std::vector<double>(6, 7)));
}

// ---- several -----------------------------------------------------------------------------------------------------------

TEST_CASE("several networks number on from one another, and springs may join any of their particles") {
  const test::ScratchFolder folder("several");
  folder.write("edge.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
  auto scene = empty_scene();
  scene["network"] = {json::parse(grid), json::parse(R"({"type":"mesh","file":"edge.obj","mass":2,"edge":7})"),
                      json::parse(grid),
                      json::parse(R"({"type":"springs","pairs":[[14,15],[31,16]],"stiffness":4,"rest_length":"start"})")};
  scene["network"][2]["fixed"] = {"edge_top", 0};
  scene["network"][0]["fixed"] = "corners_top";
  scene["fixed"] = {31, 4};
  const auto file = read(scene, folder / "scene.json");
  CHECK(file.particles.count == 32);
  CHECK(std::get<Springs>(file.scene.networks[1]).pairs == std::vector<Pair>{{15, 16}});
  CHECK(std::get<Grid>(file.scene.networks[2]).first == 17);
  CHECK(std::get<Springs>(file.scene.networks[3]).pairs == std::vector<Pair>{{14, 15}, {31, 16}});
  CHECK(file.scene.mass[14] == 2);
  CHECK(file.scene.mass[15] == 1);
  CHECK(file.scene.fixed == std::vector<std::size_t>{0, 4, 17, 18, 19, 20, 21, 31});
  CHECK(file.topology.lines == std::vector<Pair>{{15, 16}, {14, 15}, {31, 16}});
  CHECK(file.topology.faces.size() == 16);
  CHECK(scene_schema().accepts(scene));
}

TEST_CASE("springs join the particles that the scene lists") {
  auto scene = with_particles(3);
  scene["network"] = json::parse(R"({"type":"springs","pairs":[[0,1],[2,1]],"stiffness":{"values":[1,2]},"damping":0.25,
      "rest_length":{"uniform":{"min":1,"max":2,"seed":1}},"scheme":"accumulate","method":"pulse","axis":"start","substeps":4})");
  const auto file = read(scene);
  const auto& springs = std::get<Springs>(file.scene.networks.at(0));
  CHECK(springs.pairs == std::vector<Pair>{{0, 1}, {2, 1}});
  CHECK(springs.stiffness == Scalars(std::vector<double>{1, 2}));
  REQUIRE(springs.rest_length.has_value());
  CHECK(springs.rest_length->each().size() == 2);
  CHECK(springs.damping == 0.25);
  CHECK(file.scene.coupling ==
        Coupling{.scheme = Scheme::accumulate, .substeps = 4, .method = Method::pulse, .axis = PairAxis::start});
  CHECK(scene_schema().accepts(scene));
}

TEST_CASE("a network without a method takes the scene's, and sub-steps may be auto") {
  auto scene = with_network(grid);
  scene["method"] = "exact";
  scene["network"]["substeps"] = "auto";
  CHECK(read(scene).scene.coupling.method == Method::exact);
  CHECK_FALSE(read(scene).scene.coupling.substeps.has_value());
}

TEST_CASE("a network or constraints may limit the sub-steps, and the limit is at least the number asked for") {
  auto scene = with_network(grid);
  CHECK_FALSE(read(scene).scene.coupling.most_substeps.has_value());
  scene["network"]["most_substeps"] = 16;
  CHECK(read(scene).scene.coupling.most_substeps == 16);
  CHECK(scene_schema().accepts(scene));
  scene["network"]["substeps"] = 17;
  CHECK(message_of(scene) == "cloth.json: network.most_substeps is 16: must be a whole number from 17 to 1000000");
  auto rods = with_particles(2);
  rods["constraints"] = json::parse(R"([{"type":"distance","pairs":[[0,1]],"length":1}])");
  rods["most_substeps"] = 4;
  CHECK(read(rods).scene.coupling.most_substeps == 4);
  CHECK(scene_schema().accepts(rods));
  rods.erase("constraints");
  CHECK(message_of(rods) == "cloth.json: most_substeps is 4: must be left out of a scene without constraints and without meet");
}

TEST_CASE("networks of one scene with different stepping keys are refused") {
  auto scene = empty_scene();
  const auto second = [&](const char* key, const json& value) {
    scene["network"] = {json::parse(grid), json::parse(grid)};
    scene["network"][1][key] = value;
    return message_of(scene);
  };
  const std::string tail = " in the first network: must be alike in all, for they are stepped together";
  CHECK(second("scheme", "sequential") == "cloth.json: network[1].scheme is sequential and leapfrog" + tail);
  CHECK(second("substeps", 3) == "cloth.json: network[1].substeps is 3 and auto" + tail);
  CHECK(second("most_substeps", 3) == "cloth.json: network[1].most_substeps is 3 and none" + tail);
  CHECK(second("bend", 0.5).empty());
  const auto of_scheme = [&](const char* scheme, const char* key, const json& value) {
    scene["network"] = {json::parse(grid), json::parse(grid)};
    for (json& network : scene["network"]) network["scheme"] = scheme;
    scene["network"][1][key] = value;
    return message_of(scene);
  };
  CHECK(of_scheme("sequential", "theta", 0.6) == "cloth.json: network[1].theta is 0.6 and none" + tail);
  CHECK(of_scheme("sequential", "sweep", "forward") == "cloth.json: network[1].sweep is forward and symmetric" + tail);
  CHECK(of_scheme("accumulate", "method", "pulse") == "cloth.json: network[1].method is pulse and combined" + tail);
  CHECK(of_scheme("accumulate", "axis", "start") == "cloth.json: network[1].axis is start and midpoint" + tail);
  scene["network"] = {json::parse(grid), json::parse(grid)};
  scene["network"][0]["scheme"] = "sequential";
  CHECK(message_of(scene) == "cloth.json: network[1].scheme is leapfrog where left out and sequential" + tail);
}

TEST_CASE("a key that only another scheme reads is refused") {
  const auto message = [](const char* scheme, const char* key, const json& value) {
    auto scene = with_network(grid);
    scene["network"]["scheme"] = scheme;
    scene["network"][key] = value;
    return message_of(scene);
  };
  const std::string of_sweeps = " goes with scheme sequential, and this one is ";
  CHECK(message("leapfrog", "theta", 0.6) == "cloth.json: network.theta" + of_sweeps + "leapfrog");
  CHECK(message("accumulate", "theta", 0.6) == "cloth.json: network.theta" + of_sweeps + "accumulate");
  CHECK(message("fourth_order", "sweep", "symmetric") == "cloth.json: network.sweep" + of_sweeps + "fourth_order");
  CHECK(message("sequential", "method", "pulse") ==
        "cloth.json: network.method goes with scheme accumulate, and this one is sequential");
  CHECK(message("leapfrog", "axis", "midpoint") ==
        "cloth.json: network.axis goes with scheme accumulate, and this one is leapfrog");
  CHECK(message("sequential", "theta", 0.6).empty());
  CHECK(message("sequential", "sweep", "forward").empty());
  CHECK(message("accumulate", "method", "pulse").empty());
  CHECK(message("accumulate", "axis", "start").empty());
}

// ---- refusals ----------------------------------------------------------------------------------------------------------

enum class BySchema { refused, accepted };  // whether a schema can detect it

struct BadValue {
  const char* where;    // a JSON pointer
  const char* value;    // inserted there; null: the key is removed
  const char* message;  // after "cloth.json: "
  BySchema schema = BySchema::refused;
};

void check_all(const json& good, std::initializer_list<BadValue> all) {
  const auto schema = scene_schema();
  CHECK(message_of(good).empty());
  CHECK(schema.accepts(good));
  for (const auto& bad : all) {
    CAPTURE(std::string(bad.message));
    json scene = good;
    const json::json_pointer where(bad.where);
    if (bad.value != nullptr) {
      scene[where] = json::parse(bad.value);
    } else {
      scene[where.parent_pointer()].erase(where.back());
    }
    CHECK(message_of(scene) == std::string("cloth.json: ") + bad.message);
    CHECK(schema.accepts(scene) == (bad.schema == BySchema::accepted));
  }
}

TEST_CASE("a sheet's memory is that which a rank holds: its own rows, and faces only for pictures") {
  auto scene = with_network(grid);
  scene["network"]["rows"] = 1000000;  // with five particles
  const auto refused = [&](ReadTopology topology, std::size_t ranks) {
    const ReadOptions options{.memory_bytes = 1000000000, .share = {.rank = 0, .ranks = ranks}, .topology = topology};
    try {
      const auto file = parse_scene("scene.json", scene.dump(), options);
      CHECK(file.topology.faces.empty());
      CHECK(std::holds_alternative<SheetVectors>(file.particles.position));
      return std::string("taken");
    } catch (const Fault& fault) {
      return std::string(fault.what());
    }
  };
  CHECK(
      refused(ReadTopology::no, 1) ==
      "scene.json: network brings the scene to 5000000 particles: must be at most 4629629: a particle of this scene takes 216 "
      "bytes, and 1.0 GB of memory are available");
  CHECK(refused(ReadTopology::no, 2) == "taken");
  CHECK(refused(ReadTopology::yes, 2).find("280 bytes, and 1.0 GB") != std::string::npos);
  // The first rank makes a plan of the whole, or each rank holds a value for every particle.
  const auto whole = scene;
  for (const char* patch : {R"({"network": {"aerodynamics": {"density": 1.2}}})", R"({"network": {"substeps": 4}})",
                            R"({"network": {"tears_at": 2}})"}) {
    CAPTURE(patch);
    scene = whole;
    scene.merge_patch(json::parse(patch));
    CHECK(refused(ReadTopology::no, 2).find("216 bytes, and 1.0 GB") != std::string::npos);
  }
  scene = whole;
  scene["network"]["scheme"] = "accumulate";  // a list of springs
  CHECK(refused(ReadTopology::no, 2).find("212 bytes, and 1.0 GB") != std::string::npos);
  scene = whole;
  scene["network"]["rows"] = 1 << 20;
  scene["network"]["columns"] = 1 << 20;
  CHECK(refused(ReadTopology::no, 1 << 20) ==
        "scene.json: network brings the scene to 1099511627776 particles: must be at most 4294967295");
}

TEST_CASE("a wrong value in a grid is refused with its path, its value and what is valid") {
  check_all(
      with_network(grid),
      {{"/network", "7", "network is 7: must be an object, or a list of objects"},
       {"/network/type", nullptr, "network has no type: must be a grid, a mesh or springs"},
       {"/network/type", "\"rope\"", "network.type is \"rope\": must be \"grid\", \"mesh\" or \"springs\""},
       {"/network/rows", nullptr, "network.rows is missing: a network of type grid needs it"},
       {"/network/rows", "0", "network.rows is 0: must be a whole number from 1 to 1048576"},
       {"/network/rows", "1000000",
        "network brings the scene to 5000000 particles: must be at most 3571428: a particle of this scene takes 280 bytes, and "
        "1.0 GB of memory are available",
        BySchema::accepted},
       {"/network/mass", "0", "network.mass is 0: must be a finite number > 0"},
       {"/network/mass", "1e-323", "network.mass leaves each particle a mass of zero: must be larger", BySchema::accepted},
       {"/network/edge_u", "[0,0,0]", "network.edge_u is [0,0,0]: must be a vector that is not zero", BySchema::accepted},
       {"/network/structural", "-1", "network.structural is -1: must be a finite number >= 0"},
       {"/network/shear", "-1", "network.shear is -1: must be a finite number >= 0"},
       {"/network/bend", "-1", "network.bend is -1: must be a finite number >= 0"},
       {"/network/damping", "-1", "network.damping is -1: must be a finite number >= 0"},
       {"/network/edge", "1",
        "network.edge is not a key of a network of type grid: did you mean edge_u? Known are type, damping, fixed, scheme, "
        "substeps, most_substeps, method, theta, sweep, lines, axis, broken, tears_at, rows, columns, origin, edge_u, edge_v, "
        "mass, "
        "structural, "
        "shear, bend, "
        "aerodynamics, strain_limit"},
       {"/network/scheme", "\"euler\"",
        "network.scheme is \"euler\": must be \"leapfrog\", \"fourth_order\", \"sequential\", \"accumulate\" or \"auto\""},
       {"/network/substeps", "0", "network.substeps is 0: must be a whole number from 1 to 1000000"},
       {"/network/substeps", "\"some\"", "network.substeps is \"some\": must be \"auto\" or a whole number"},
       {"/network/most_substeps", "0", "network.most_substeps is 0: must be a whole number from 1 to 1000000"},
       {"/network/theta", "0.4", "network.theta is 0.4: must be a number from 0.5 to 1"},
       {"/network/sweep", "\"backward\"", "network.sweep is \"backward\": must be \"symmetric\" or \"forward\""},
       {"/network/axis", "\"end\"", "network.axis is \"end\": must be \"midpoint\" or \"start\""},
       {"/network/fixed", "[15]", "network.fixed[0] is 15: must be a whole number from 0 to 14", BySchema::accepted},
       {"/network/fixed", "7", "network.fixed is 7: must be a list of particle ids"},
       {"/network/fixed", "\"edge_left\"", "network.fixed is \"edge_left\": must be \"corners_top\" or \"edge_top\""},
       {"/constraints", "[{\"type\":\"point\",\"particle\":15,\"at\":[0,0,0]}]",
        "constraints[0].particle is 15: must be a whole number from 0 to 14", BySchema::accepted}});
}

TEST_CASE("a wrong value in springs is refused with its path, its value and what is valid") {
  auto scene = with_particles(3);
  scene["network"] = json::parse(R"({"type":"springs","pairs":[[0,1],[1,2]],"stiffness":{"values":[1,2]},"rest_length":1})");
  check_all(scene,
            {{"/network/pairs", "3", "network.pairs is 3: must be a list of pairs [i, j]"},
             {"/network/pairs/1", "[1]", "network.pairs[1] is [1]: must be a pair [i, j]"},
             {"/network/pairs/1", "[1,3]", "network.pairs[1][1] is 3: must be a whole number from 0 to 2", BySchema::accepted},
             {"/network/pairs/1", "[1,1]", "network.pairs[1][1] is 1: must be another particle than the pair's first"},
             {"/network/stiffness", "{\"values\":[1]}",
              "network.stiffness.values has 1 entries: must have 2, one for each pair", BySchema::accepted},
             {"/network/stiffness", "-1", "network.stiffness is -1: must be a finite number >= 0"},
             {"/network/rest_length", "-1", "network.rest_length is -1: must be a finite number >= 0"},
             {"/network/rest_length", "\"end\"",
              "network.rest_length is \"end\": must be \"start\", a number or an object with one of values, uniform, file"},
             {"/network/fixed", "[\"edge_top\"]", "network.fixed[0] is \"edge_top\": must be a particle id"},
             {"/particles", nullptr, "particles is missing: a scene needs it", BySchema::accepted}});
}

// ---- constraints -------------------------------------------------------------------------------------------------------

TEST_CASE("constraints are read as they stand") {
  auto scene = with_particles(3);
  scene["constraints"] = json::parse(R"([{"type":"distance","pairs":[[0,1]],"length":"start"},
                                         {"type":"distance","pairs":[[0,1],[1,2]],"length":{"values":[1,2]},"bound":"at_most"},
                                         {"type":"point","particle":0,"at":[1,2,3]},
                                         {"type":"line","particle":1,"through":[0,0,0],"direction":[0,0,2]}])");
  const auto file = read(scene);
  REQUIRE(file.scene.constraints.size() == 4);
  CHECK(std::get<Distance>(file.scene.constraints[0]) == Distance{.pairs = {{0, 1}}});
  CHECK(std::get<Distance>(file.scene.constraints[1]) ==
        Distance{.pairs = {{0, 1}, {1, 2}}, .length = Scalars(std::vector<double>{1, 2}), .bound = Bound::at_most});
  CHECK(std::get<OnPoint>(file.scene.constraints[2]) == OnPoint{.particle = 0, .at = {1, 2, 3}});
  CHECK(std::get<OnLine>(file.scene.constraints[3]) == OnLine{.particle = 1, .through = {}, .direction = {0, 0, 2}});
  CHECK(file.topology.lines == std::vector<Pair>{{0, 1}, {0, 1}, {1, 2}});
  check_all(
      scene,
      {{"/constraints/0/length", "0", "constraints[0].length is 0: must be a finite number > 0"},
       {"/constraints/0/bound", "\"less\"", "constraints[0].bound is \"less\": must be \"equal\", \"at_most\" or \"at_least\""},
       {"/constraints/0/type", "\"weld\"", "constraints[0].type is \"weld\": must be \"distance\", \"point\" or \"line\""},
       {"/constraints/2/particle", "3", "constraints[2].particle is 3: must be a whole number from 0 to 2", BySchema::accepted},
       {"/constraints/3/direction", "[0,0,0]", "constraints[3].direction is [0,0,0]: must be a vector that is not zero",
        BySchema::accepted}});
}

}  // namespace network_reader_test
