// Mesh vertices as particles: vertices in one place become one particle, and unused vertices are left out.
#include "scene_io/mesh_welding.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string>

#include "dvdx/layouts/soa.hpp"
#include "output/writer.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace mesh_welding_test {

using namespace dvdx;
using namespace dvdx::tool;
using nlohmann::json;
using test::ScratchFolder;

using Numbers = std::vector<std::uint32_t>;
using Faces = std::vector<Numbers>;
constexpr auto nobody = Numbering::nobody;

WeldedMesh made(const std::string& text, std::optional<double> weld = 0, Unreferenced treatment = Unreferenced::left_out) {
  return welded(parse_mesh(text), weld, treatment);
}

// Two triangles that share a side whose vertices occur twice.
const std::string seam = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\nf 4 5 6\n";

// Two objects in one file that share two of its vertices, and one vertex without a face.
const std::string loose = "o a\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 7 7 7\nf 1 2 3 4\ng b\nv 2 0 0\nv 2 0 1\nf 2 6 7 3\n";

// ---- a mesh alone ------------------------------------------------------------------------------------------------------

TEST_CASE("vertices at one place are one particle, numbered by the first") {
  const auto whole = made(seam);
  CHECK(whole.numbering.particles == Numbers{0, 1, 2, 1, 3, 2});
  CHECK(whole.numbering.numbers == Numbers{0, 1, 2, 4});
  CHECK(whole.mesh.vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}});
  CHECK(whole.mesh.faces == Faces{{0, 1, 2}, {1, 3, 2}});
  CHECK(bends_of(whole.mesh) == std::vector<Pair>{{0, 3}});
  CHECK(whole.facts.vertices == 6);
  CHECK(whole.facts.particles == 4);
  CHECK(whole.facts.pieces == 1);
  CHECK(whole.facts.near == 0);

  const auto apart = made(seam, std::nullopt);
  CHECK(apart.numbering.particles == Numbers{0, 1, 2, 3, 4, 5});
  CHECK(apart.mesh.faces == Faces{{0, 1, 2}, {3, 4, 5}});
  CHECK(apart.facts.pieces == 2);
  CHECK(apart.facts.near == 4);
  CHECK(apart.facts.apart == 0);
}

TEST_CASE("a seam whose vertices are a little apart is welded by a distance at least as large") {
  const std::string open = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1.000001 0 0\nv 1 0 1\nv 0 -1e-6 1\nf 1 2 3\nf 4 5 6\n";
  for (const double weld : {0.0, 0.9e-6}) {
    const auto two = made(open, weld);
    CHECK(two.facts.particles == 6);
    CHECK(two.facts.pieces == 2);
    CHECK(two.facts.near == 4);
    CHECK(two.facts.apart == doctest::Approx(1e-6).epsilon(1e-6));
  }
  for (const double weld : {1e-6, 1e-5}) {  // the former by the numbers in the file, despite their rounding
    const auto one = made(open, weld);
    CHECK(one.numbering.particles == Numbers{0, 1, 2, 1, 3, 2});
    CHECK(one.mesh.vertices[1] == Vec3{1, 0, 0});  // at the first one's place
    CHECK(one.facts.pieces == 1);
    CHECK(one.facts.near == 0);
  }
}

TEST_CASE("vertices in a chain of distances up to the weld are one particle") {
  const std::string chain = "v 0 0 0\nv 0 2e-5 0\nv 1 0 0\nv 0 1e-5 0\nv 0 0 1\nf 1 3 5\nf 2 3 5\nf 4 3 5\n";
  CHECK(made(chain, 0.9e-5).facts.particles == 5);
  const auto one = made(chain, 1.1e-5);
  CHECK(one.numbering.particles == Numbers{0, 0, 1, 0, 2});
  CHECK(one.mesh.faces == Faces{{0, 1, 2}});  // three vertices that became one
}

// Compares the groups with those by every pair's distance, whichever cells the vertices are in.
TEST_CASE("welding forms the same groups as a comparison of every pair's distance") {
  std::string text;
  std::vector<Vec3> places;
  std::uint32_t word = 1;
  const auto drawn = [&] { return static_cast<double>((word = word * 1664525U + 1013904223U) >> 16U) / 65536 - 0.5; };
  for (int n = 0; n < 150; ++n) {
    places.push_back({drawn(), drawn(), 0.25 * drawn()});
    text += "v " + std::to_string(places.back()[0]) + " " + std::to_string(places.back()[1]) + " " +
            std::to_string(places.back()[2]) + "\n";
  }
  const MeshFile file = parse_mesh(text);
  for (const double weld : {0.03, 0.06, 0.1}) {
    Numbers group(file.vertices.size());
    std::iota(group.begin(), group.end(), 0U);
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (std::size_t i = 0; i < group.size(); ++i) {
        for (std::size_t j = 0; j < group.size(); ++j) {
          const auto &a = file.vertices[i], &b = file.vertices[j];
          if (group[i] >= group[j] || std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) > weld) continue;
          group[j] = group[i];
          is_changed = true;
        }
      }
    }
    const auto one = welded(file, weld, Unreferenced::kept);
    CHECK(one.facts.particles < 150);
    CHECK(one.facts.particles > 1);
    for (std::size_t i = 0; i < group.size(); ++i) CHECK(one.numbering.numbers[one.numbering.particles[i]] == group[i]);
  }
}

TEST_CASE("vertices that no face uses are left out wherever they stand in the file, or kept") {
  const auto without = made(loose);
  CHECK(without.numbering.particles == Numbers{0, 1, 2, 3, nobody, 4, 5});
  CHECK(without.numbering.still == std::vector<Vec3>{{7, 7, 7}});
  CHECK(without.mesh.faces == Faces{{0, 1, 2, 3}, {1, 4, 5, 2}});
  CHECK(without.facts.unreferenced == 1);
  CHECK(without.facts.left_out == 1);
  CHECK(without.facts.pieces == 1);

  const auto with = made(loose, 0, Unreferenced::kept);
  CHECK(with.numbering.particles == Numbers{0, 1, 2, 3, 4, 5, 6});
  CHECK(with.facts.unreferenced == 1);
  CHECK(with.facts.left_out == 0);

  const auto around = made("v 8 8 8\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 6 6 6\nf 3 4 5\n");
  CHECK(around.numbering.particles == Numbers{nobody, nobody, 0, 1, 2, nobody});
  CHECK(around.numbering.still == std::vector<Vec3>{{8, 8, 8}, {9, 9, 9}, {6, 6, 6}});

  // An unused vertex at a face's corner becomes that corner. A vertex used by a line only is used.
  CHECK(made("v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n").numbering.particles == Numbers{0, 1, 2, 1});
  CHECK(made("v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2\n").numbering.particles == Numbers{0, 1, nobody});
  // Nothing joins the vertices: a file of points.
  const auto points = made("v 0 0 0\nv 1 0 0\nv 0 0 1\n");
  CHECK(points.numbering.particles == Numbers{0, 1, 2});
  CHECK(points.facts.pieces == 0);
}

TEST_CASE("faces lose the corners that fall together, and become lines where two are left") {
  // The pole of a ball occurs twice in a face of four corners.
  const auto pole = made("v 0 1 0\nv 0 1 0\nv 1 0 0\nv 0 0 1\nf 1 2 3 4\nf 3 2 4\n");
  CHECK(pole.mesh.faces == Faces{{0, 1, 2}});
  CHECK(diagonals_of(pole.mesh).empty());
  const auto sliver = made("v 0 0 0\nv 1 0 0\nv 1 1e-9 0\nv 5 0 0\nf 1 2 3\nl 2 3\n", 1e-8);
  CHECK(sliver.mesh.faces.empty());
  CHECK(sliver.mesh.lines == std::vector<Pair>{{0, 1}});
  CHECK(sliver.facts.particles == 2);
  // A square with a hole, cut open from corner to corner: its border, the hole's border, and the cut.
  const auto keyhole = made(
      "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 0 0 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 0\nf 1 2 3 4 5 6 7 8 9 10\n");
  CHECK(keyhole.mesh.faces == Faces{{0, 1, 2, 3}, {4, 5, 6, 7}});
  CHECK(keyhole.mesh.lines == std::vector<Pair>{{0, 4}});
  // Both sides of one cloth become one face.
  CHECK(made("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 4 5 6\n").mesh.faces == Faces{{0, 1, 2}});
}

TEST_CASE("pieces that lie a cloth's distance apart are no seam") {
  const auto layers = made("v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 0.01 0\nv 1 0.01 0\nv 0 0.01 1\nf 1 2 3\nf 4 5 6\n");
  CHECK(layers.facts.pieces == 2);
  CHECK(layers.facts.near == 0);
  const auto lines = made("v 0 0 0\nv 1 0 0\nv 5 0 0\nv 6 0 0\nl 1 2\nl 3 4\n");
  CHECK(lines.facts.pieces == 2);
  CHECK(lines.facts.polygons == 0);
  CHECK(made("v 0 0 0\nv 1 0 0\nv 1.5 0 0.8\nv 0.5 0 1.4\nv -0.5 0 0.8\nf 1 2 3 4 5\n").facts.polygons == 1);
}

// ---- in a scene --------------------------------------------------------------------------------------------------------

json scene_of(const std::string& file) {
  return {{"format", "dvdx-scene/1"},
          {"name", "cloth"},
          {"step", 0.01},
          {"duration", 0.1},
          {"network", {{"type", "mesh"}, {"file", file}, {"mass", 4}, {"edge", 100}}},
          {"forces", {{{"type", "constant"}, {"acceleration", {0, -9.81, 0}}}}}};
}

SceneFile read(const ScratchFolder& folder, const json& scene) { return parse_scene(folder / "scene.json", scene.dump()); }

std::string refusal_of(const ScratchFolder& folder, const json& scene) {
  try {
    (void)read(folder, scene);
    return "";
  } catch (const Fault& fault) {
    CHECK(fault.exit() == Exit::bad_scene);
    const std::string message = fault.what();
    return message.substr(message.find(".json: ") + 7);
  }
}

std::vector<std::string> codes_of(const SceneFile& file) {
  std::vector<std::string> codes;
  for (const Warning& warning : file.warnings) codes.push_back(warning.code);
  return codes;
}

using Codes = std::vector<std::string>;

TEST_CASE("a scene names particles by the file's vertices, also where vertices are welded or left out") {
  const ScratchFolder folder("named");
  folder.write("seam.obj", seam);
  folder.write("loose.obj", loose);
  auto scene = scene_of("seam.obj");
  scene["network"]["fixed"] = {3};
  scene["fixed"] = {1, 5};
  scene["particles"]["count"] = 6;
  scene["particles"]["velocity"]["values"] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}};
  scene["motions"]["hand"]["keys"] = {{{"time", 0}}};
  scene["kinematic"] = {{{"particles", {4, 0}}, {"motion", "hand"}}};
  scene["constraints"] = {{{"type", "distance"}, {"pairs", {{3, 4}}}, {"length", "start"}}};
  const auto file = read(folder, scene);
  CHECK(file.particles.count == 4);
  CHECK(file.scene.mass == Scalars(1.0));
  CHECK(file.scene.fixed == std::vector<std::size_t>{1, 2});
  CHECK(file.scene.kinematic[0].particles == std::vector<std::size_t>{3, 0});
  for (const auto& [particle, speed] : {std::pair(1, 1.0), std::pair(2, 2.0), std::pair(3, 4.0)})
    CHECK(value_of(file.particles.velocity, static_cast<std::size_t>(particle))[0] == speed);
  CHECK(std::get<Distance>(file.scene.constraints[0]).pairs == std::vector<Pair>{{1, 3}});
  CHECK(file.topology.faces == Faces{{0, 1, 2}, {3, 4, 5}});
  CHECK(file.topology.lines == std::vector<Pair>{{1, 4}});
  CHECK(codes_of(file).empty());

  scene["kinematic"].push_back({{"particles", {1}}, {"motion", "hand"}});
  CHECK(refusal_of(folder, scene) == "kinematic[1].particles has particle 1, which is in fixed already: may be in one of them");
  scene.erase("kinematic");
  scene["constraints"][0]["pairs"] = {{1, 3}};
  CHECK(refusal_of(folder, scene) == "constraints[0].pairs[0][1] is 3: must be another particle than the pair's first");
  scene["particles"]["count"] = 4;
  CHECK(refusal_of(folder, scene) ==
        "particles.count is 4: must be left out, or 6, which is how many the network makes, each vertex of a mesh counted");
}

TEST_CASE("a welded particle has the drawn and listed values of its first vertex") {
  const ScratchFolder folder("values");
  folder.write("seam.obj", seam);
  auto scene = scene_of("seam.obj");
  const json drawn = {{"uniform", {{"min", {0, 0, 0}}, {"max", {1, 1, 1}}, {"seed", 7}}}};
  scene["particles"]["velocity"] = drawn;
  scene["forces"] = {{{"type", "spring"}, {"stiffness", {{"values", {1, 2, 3, 4, 5, 6}}}}, {"anchor", drawn}}};
  const auto one = read(folder, scene);
  scene["network"]["weld"] = nullptr;
  const auto each = read(folder, scene);
  CHECK(each.particles.count == 6);
  const Numbers first{0, 1, 2, 4};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(value_of(one.particles.velocity, i) == value_of(each.particles.velocity, first[i]));
    const auto& anchors = std::get<std::vector<Vec3>>(std::get<Spring>(one.scene.forces[0]).anchor);
    CHECK(anchors[i] == std::get<std::vector<Vec3>>(std::get<Spring>(each.scene.forces[0]).anchor)[first[i]]);
  }
  CHECK(std::get<Spring>(one.scene.forces[0]).stiffness.scalars() == Scalars(std::vector<double>{1, 2, 3, 5}));
}

TEST_CASE("a skin's lists have an entry for each vertex that it names") {
  const ScratchFolder folder("skin");
  folder.write("seam.obj", seam);
  auto scene = scene_of("seam.obj");
  scene["skins"] = {{{"particles", "all"}, {"at_most", {0, 1, 2, 3, 4, 5}}}};
  const auto all = read(folder, scene);
  CHECK(all.scene.skins[0].particles == std::vector<std::size_t>{0, 1, 2, 3});
  CHECK(all.scene.skins[0].at_most == Scalars(std::vector<double>{0, 1, 2, 4}));
  scene["skins"][0] = {{"particles", {5, 3, 2}}, {"points", {{5, 0, 0}, {3, 0, 0}, {2, 0, 0}}}};
  const auto some = read(folder, scene);
  CHECK(some.scene.skins[0].particles == std::vector<std::size_t>{2, 1});
  CHECK(some.scene.skins[0].points == std::vector<Vec3>{{5, 0, 0}, {3, 0, 0}});
  scene["skins"][0]["at_most"] = {1, 2};
  CHECK(refusal_of(folder, scene) == "skins[0].at_most has 2 entries: must have one for each of the skin's 3 particles");
}

TEST_CASE("networks after a mesh number on from its vertices") {
  const ScratchFolder folder("list");
  folder.write("loose.obj", loose);
  folder.write("seam.obj", seam);
  auto scene = scene_of("loose.obj");
  const json mesh = scene["network"];
  json second = mesh;
  second["file"] = "seam.obj";
  const json grid = json::parse(R"({"type": "grid", "rows": 2, "columns": 2, "origin": [0, 0, 0], "edge_u": [1, 0, 0],
    "edge_v": [0, 1, 0], "mass": 4, "structural": 1, "fixed": ["corners_top", 9]})");
  const json springs = json::parse(R"({"type": "springs", "pairs": [[8, 14]], "stiffness": 1, "rest_length": 1})");
  scene["network"] = {mesh, grid, second, springs};
  const auto file = read(folder, scene);
  CHECK(file.particles.count == 6 + 4 + 4);
  CHECK(file.numbering.particles == Numbers{0, 1, 2, 3, nobody, 4, 5, 6, 7, 8, 9, 10, 11, 12, 11, 13, 12});
  CHECK(file.numbering.numbers == Numbers{0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15});
  CHECK(file.scene.fixed == std::vector<std::size_t>{6, 7, 8});  // the grid's first three
  CHECK(std::get<Springs>(file.scene.networks[3]).pairs == std::vector<Pair>{{7, 11}});
  CHECK(file.topology.faces == Faces{{0, 1, 2, 3}, {1, 5, 6, 2}, {7, 8, 10, 9}, {11, 12, 13}, {14, 15, 16}});
  CHECK(file.topology.lines == std::vector<Pair>{{8, 12}});  // the first index of each end
}

TEST_CASE("a vertex that is left out may be named as fixed, but not in a constraint") {
  const ScratchFolder folder("left-out");
  folder.write("loose.obj", loose);
  auto scene = scene_of("loose.obj");
  scene["network"]["fixed"] = {3, 4};
  auto file = read(folder, scene);
  CHECK(file.scene.fixed == std::vector<std::size_t>{3});
  CHECK(file.scene.mass == Scalars(4.0 / 6));
  CHECK(codes_of(file) == Codes{"unreferenced_vertices"});
  scene["constraints"] = {{{"type", "point"}, {"particle", 4}, {"at", {0, 0, 0}}}};
  CHECK(refusal_of(folder, scene) ==
        "constraints[0].particle is 4, a vertex that no face uses and that is left out: must be "
        "another, or its mesh must have \"unreferenced\": \"keep\"");
  scene["network"]["unreferenced"] = "keep";
  file = read(folder, scene);
  CHECK(file.particles.count == 7);
  CHECK(codes_of(file).empty());
  scene["network"]["unreferenced"] = "leave_out";
  scene.erase("constraints");
  CHECK(codes_of(read(folder, scene)).empty());  // an explicit choice
  scene["network"]["unreferenced"] = "drop";
  CHECK(refusal_of(folder, scene) == "network.unreferenced is \"drop\": must be \"leave_out\" or \"keep\"");
  scene["network"].erase("unreferenced");
  for (const json& weld : {json(-1), json("no")}) {
    scene["network"]["weld"] = weld;
    CHECK(refusal_of(folder, scene) == "network.weld is " + weld.dump() + ": must be a finite number >= 0, or null");
  }
}

// Files in the style of several programs. Each joins its particles to one piece of cloth.
TEST_CASE("unusual .obj files are read as one piece of cloth") {
  const ScratchFolder folder("odd");
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n";
  const auto facts = [&](const std::string& text) {
    folder.write("odd.obj", text);
    const auto file = read(folder, scene_of("odd.obj"));
    CHECK(file.meshes.at(0).facts.pieces == 1);
    const auto& springs = std::get<Springs>(file.scene.networks.at(0));
    return std::array{file.particles.count, springs.pairs.size(), file.warnings.size()};
  };
  using Facts = std::array<std::size_t, 3>;
  CHECK(facts("\xEF\xBB\xBF" + square + "f 1 2 3 4\n") == Facts{4, 6, 0});
  CHECK(facts(square + "f 1 2 \\\n 3 4\n") == Facts{4, 6, 0});
  CHECK(facts(square + "fo 1 2 3 4\n") == Facts{4, 6, 0});
  CHECK(facts("V 0 0 0\nv 1 0 0\nv 1 0 1\nF 1 2 3\n") == Facts{3, 3, 0});
  CHECK(facts("v 0 0 0\nv 1 0 0\nv 1.5 0 0.8\nv 0.5 0 1.4\nv -0.5 0 0.8\nf 1 2 3 4 5\n") == Facts{5, 7, 0});
  CHECK(facts(seam) == Facts{4, 5, 0});
  CHECK(facts(loose) == Facts{6, 11, 1});
}

TEST_CASE("a spring that tears takes the faces on both sides of a welded seam") {
  const ScratchFolder folder("torn");
  const auto whole = made(seam);
  const Topology topology{.lines = {}, .faces = {{0, 1, 2}, {3, 4, 5}}};
  std::vector<Tear> tears;
  const auto writer = make_writer<float>({.target = folder / "a.ply",
                                          .particles = 4,
                                          .states = 2,
                                          .topology = &topology,
                                          .tears = &tears,
                                          .numbering = &whole.numbering});
  Soa<float> memory(4);
  State<float> state = memory.view();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 4; ++i) state.x[axis][i] = state.v[axis][i] = 0;
  }
  writer->write({.step = 0, .time = 0}, state);
  tears.push_back({.step = 1, .network = 0, .ends = {1, 2}});
  writer->write({.step = 1, .time = 1}, state);
  writer->finish();
  CHECK(folder.read("a-000000.ply").find("element face 2\n") != std::string::npos);
  CHECK(folder.read("a-000001.ply").find("element face") == std::string::npos);
}

// ---- the command -------------------------------------------------------------------------------------------------------

json done(const ScratchFolder& folder, const std::string& arguments) {
  CAPTURE(arguments);
  const auto result = test::run(folder, arguments);
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  return json::parse(result.out);
}

// The same cloth, once as exporters write it and once without double vertices: bits and forms are equal.
void write_both(const ScratchFolder& folder) {
  folder.write("seam.obj",
               "v 9 9 9\n" + std::string("v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 2 3 4\nf 5 6 7\n"));
  folder.write("whole.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 2 3\nf 2 4 3\n");
  auto scene = scene_of("seam.obj");
  scene["network"]["fixed"] = {1};
  folder.write("seam.json", scene.dump());
  scene["network"]["file"] = "whole.obj";
  scene["network"]["fixed"] = {0};
  folder.write("whole.json", scene.dump());
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    lines.push_back(text.substr(at, end - at));
  return lines;
}

// The part of a row from x, y, z on.
std::string behind_particle(const std::string& row) {
  std::size_t at = 0;
  for (int comma = 0; comma < 3; ++comma) at = row.find(',', at) + 1;
  return row.substr(at);
}

TEST_CASE("output files have the mesh's vertices in file order, and welded ones at their particle's place") {
  const ScratchFolder folder("written");
  write_both(folder);
  const json one = done(folder, "run seam.json --json --every 5 --out seam.csv");
  const json other = done(folder, "run whole.json --json --every 5 --out whole.csv");
  CHECK(one["state_hash"] == other["state_hash"]);
  CHECK(one["particles"] == 4);
  CHECK(one["meshes"] == json::parse(R"([{"file": "seam.obj", "vertices": 7, "particles": 4, "pieces": 1, "unreferenced": 1,
    "left_out": 1, "polygons": 0}])"));
  CHECK(one["warnings"].size() == 1);
  CHECK(other["warnings"].empty());

  const auto rows = lines_of(folder.read("seam.csv"));
  const auto own = lines_of(folder.read("whole.csv"));
  REQUIRE(rows.size() == 1 + 3 * 7);
  REQUIRE(own.size() == 1 + 3 * 4);
  const std::array<std::size_t, 7> particles{99, 0, 1, 2, 1, 3, 2};
  for (std::size_t state = 0; state < 3; ++state) {
    CHECK(behind_particle(rows[1 + 7 * state]) == "9,9,9,0,0,0");
    for (std::size_t n = 1; n < 7; ++n)
      CHECK(behind_particle(rows[1 + 7 * state + n]) == behind_particle(own[1 + 4 * state + particles[n]]));
  }
  // The first state of a cache has the file's faces.
  done(folder, "run seam.json --json --every 5 --out cache.pc2");
  const auto cached = lines_of(folder.read("cache.obj"));
  const auto mesh = lines_of(folder.read("seam.obj"));
  REQUIRE(cached.size() > mesh.size());
  CHECK(std::equal(mesh.begin(), mesh.end(), cached.begin() + 1));  // behind the line that names the writer
  CHECK(folder.read("cache.pc2").size() == 32 + 3 * 7 * 12);
  done(folder, "run seam.json --json --out a.ply");
  CHECK(folder.read("a-000000.ply").find("element vertex 7\n") != std::string::npos);
  CHECK(folder.read("a-000000.ply").find("element face 2\n") != std::string::npos);
  done(folder, "run seam.json --json --every 0 --out a.npz");
  CHECK(folder.read("a.npz").find("'shape': (1, 7, 3)") != std::string::npos);
}

TEST_CASE("a run of a welded mesh goes on from a checkpoint, and not with another weld") {
  const ScratchFolder folder("resumed");
  write_both(folder);
  const json whole = done(folder, "run seam.json --json --every 3 --out whole.ply");
  done(folder, "run seam.json --json --every 3 --out half.ply --checkpoint at --checkpoint-every 5");
  const json rest = done(folder, "run seam.json --json --every 3 --out half.ply --resume at");
  CHECK(rest["state_hash"] == whole["state_hash"]);
  for (const char* frame : {"-000000.ply", "-000002.ply", "-000004.ply"})
    CHECK(folder.read(std::string("half") + frame) == folder.read(std::string("whole") + frame));
  CHECK(test::run(folder, "run seam.json --resume at --set network.weld=0.5").exit == 3);
  CHECK(test::run(folder, "verify seam.json").exit == 0);
}

TEST_CASE("a run names the most stretched spring and the particles that hit by the file's vertices") {
  const ScratchFolder folder("named-seen");
  write_both(folder);
  auto scene = json::parse(folder.read("seam.json"));
  scene["contacts"] = {{{"type", "plane"}, {"normal", {0, 1, 0}}, {"offset", -0.02}}};
  folder.write("seam.json", scene.dump());
  const json seen = done(folder, "run seam.json --json --events hits.csv");
  for (const json& end : seen["stretch"]["springs"]) CHECK(std::set<int>{1, 2, 3, 5}.contains(end.get<int>()));
  const auto hits = lines_of(folder.read("hits.csv"));
  std::set<int> particles;
  for (std::size_t n = 1; n < hits.size(); ++n) {
    const auto time = hits[n].find(',');
    particles.insert(std::stoi(hits[n].substr(hits[n].find(',', time + 1) + 1)));
  }
  CHECK(particles == std::set<int>{2, 3, 5});
  const auto explained = test::run(folder, "explain seam.json");
  CHECK(explained.out.find("mesh         seam.obj: 7 vertices as 4 particles in 1 piece; 1 vertex in no face, left out\n") !=
        std::string::npos);
}

TEST_CASE("the cure that run names for a seam that is a little open closes it") {
  const ScratchFolder folder("cured");
  folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1.000003 0 0\nv 1 0 1\nv 0 -1e-6 1\nf 1 2 3\nf 4 5 6\n");
  folder.write("scene.json", scene_of("open.obj").dump());
  const auto warned = [&](const std::string& more) { return done(folder, "run scene.json --json" + more)["warnings"]; };
  const json warnings = warned("");
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0]["code"] == "pieces");
  CHECK(warnings[0]["text"] ==
        "network.file is \"open.obj\": its 2 pieces fall apart where 4 particles stand within 3e-06 m of another piece's");
  CHECK(warnings[0]["cure"] == "\"weld\": 3.2e-06 in the network makes them one");
  CHECK(warned(" --set network.weld=3.2e-6").empty());
}

}  // namespace mesh_welding_test
