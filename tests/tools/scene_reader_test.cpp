#include "scene_io/scene_reader.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "dvdx/layouts/soa.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/points_file.hpp"
#include "state/start.hpp"
#include "support/paths.hpp"
#include "tools/schema.hpp"
#include "tools/scratch_folder.hpp"

namespace scene_reader_test {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::Schema;
using nlohmann::json;

// One of everything, for three particles.
constexpr const char* full_scene = R"({
  "format": "dvdx-scene/1", "name": "full", "about": "one of everything", "step": 0.25, "duration": 2, "method": "exact",
  "particles": {
    "count": 3,
    "mass": {"values": [1, 2, 3]},
    "position": {"uniform": {"min": [0, 1, 2], "max": [1, 1, 4], "seed": 5}},
    "velocity": [1, 2, 3]
  },
  "forces": [
    {"type": "constant", "acceleration": [0, -9.81, 0], "method": "pulse"},
    {"type": "polynomial", "acceleration": [[1, 0, 0], [0, 2, 0]]},
    {"type": "sinusoid", "acceleration": [1, 0, 0], "angular_frequency": 2},
    {"type": "spring", "stiffness": {"uniform": {"min": 1, "max": 2, "seed": 1}}, "anchor": "start"},
    {"type": "radial_spring", "stiffness": 4, "damping": 0.5, "anchor": {"values": [[0,0,0],[1,1,1],[2,2,2]]}, "rest_length": 1},
    {"type": "drag", "coefficient": [1, 2, 3], "wind": [4, 5, 6], "expansion": "first_order"}
  ],
  "contacts": [
    {"type": "plane", "normal": [0, 3, 4], "offset": -1, "restitution": 0.5, "friction": 0.2},
    {"type": "sphere", "center": [1, 2, 3], "radius": 9, "side": "inside", "viscosity": 0.1, "normal_viscosity": 0.3,
     "response": "seed", "sweep": "line", "motion": "lift"},
    {"type": "capsule", "ends": [[0, 1, 0], [2, 1, 0]], "radius": [0.5, 0.25], "thickness": 0.125, "push_out": 0.75},
    {"type": "capsule", "ends": [[0, 1, 0], [0, 1, 0]], "radius": 2, "friction": 0.5},
    {"type": "box", "center": [1, 0, 0], "half_extents": [4, 5, 6], "rotation": [0, 0.5, 0], "side": "inside"},
    {"type": "convex", "planes": [{"normal": [-1, 0, 0], "offset": 0}, {"normal": [0, -2, 0], "offset": 0},
                                  {"normal": [0, 0, -1], "offset": 0}, {"normal": [0, 3, 4], "offset": 1.5},
                                  {"normal": [1, 0, 0], "offset": 1}]}
  ],
  "motions": {
    "arm": {"keys": [{"time": 0}]},
    "lift": {"center": [0, 1, 0], "keys": [{"time": -1, "translation": [0, 1, 0]}, {"time": 2, "rotation": [0, 3, 0], "jump": true}]}
  },
  "kinematic": [{"particles": [1], "motion": "lift"}],
  "skins": [{"particles": [2, 0], "points": [[0, 0, 0], [1, 0, 0]], "at_most": [0.5, 0], "motion": "arm",
             "backstop": {"normals": [[0, 1, 0], [0, 0, 1]], "offset": [0.25, 0], "radius": 2}}],
  "meet": {"radius": {"values": [0.1, 0.2, 0.3]}, "restitution": 0.3, "friction": 0.5, "rounds": 6, "most_neighbours": 32,
           "apart_at_start": true, "groups": {"of": [0, 1, 1], "meet": [[0, 1], [1, 1]]}},
  "fixed": [2]
})";

const ReadOptions plenty{.memory_bytes = 1000000000};

// The reader's error, or nothing. An error must have the exit code of a bad scene.
std::string message_of(std::string_view text, const ReadOptions& options = plenty, const std::string& path = "hail.json") {
  try {
    (void)parse_scene(path, text, options);
    return "";
  } catch (const Fault& fault) {
    CHECK(fault.exit() == Exit::bad_scene);
    return fault.what();
  }
}

Schema scene_schema() {
  std::ifstream file(dvdx::test::schema());
  return Schema(json::parse(file));
}

std::vector<std::filesystem::path> shipped_scenes() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(dvdx::test::scenes())) {
    if (entry.path().extension() == ".json") paths.push_back(entry.path());
  }
  return paths;
}

// ---- what is right -----------------------------------------------------------------------------------------------------

TEST_CASE("a scene with one of everything is read as it stands") {
  const auto file = parse_scene("full.json", full_scene, plenty);
  CHECK(file.name == "full");
  CHECK(file.about == "one of everything");
  CHECK(file.step == 0.25);
  CHECK(file.duration == 2);
  CHECK(file.particles.count == 3);
  Scene scene;
  scene.method = Method::exact;
  scene.mass = std::vector<double>{1, 2, 3};
  scene.add(Constant{.acceleration = {0, -9.81, 0}, .method = Method::pulse});
  scene.add(Polynomial{.acceleration = {{1, 0, 0}, {0, 2, 0}}});
  scene.add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 2});
  const auto& stiffness = std::get<Spring>(file.scene.forces[3]).stiffness;
  scene.add(Spring{.stiffness = stiffness, .anchor = at_start});
  scene.add(RadialSpring{
      .stiffness = 4.0, .damping = 0.5, .anchor = std::vector<Vec3>{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, .rest_length = 1.0});
  scene.add(Drag{.coefficient = PerAxis(1, 2, 3), .wind = {4, 5, 6}, .expansion = Expansion::first_order});
  scene.add(Plane{.normal = {0, 0.6, 0.8}, .offset = -1, .restitution = 0.5, .friction = 0.2});
  scene.add(Sphere{.center = {1, 2, 3},
                   .radius = 9,
                   .side = Side::inside,
                   .viscosity = 0.1,
                   .normal_viscosity = 0.3,
                   .response = Response::end_on_surface,
                   .sweep = ContactPath::line,
                   .motion = 1});
  scene.add(Capsule{.ends = {{{0, 1, 0}, {2, 1, 0}}}, .radius = {0.5, 0.25}, .thickness = 0.125, .push_out = 0.75});
  scene.add(Capsule{.ends = {{{0, 1, 0}, {0, 1, 0}}}, .radius = {2, 2}, .friction = 0.5});
  scene.add(OrientedBox{.center = {1, 0, 0}, .half_extents = {4, 5, 6}, .rotation = {0, 0.5, 0}, .side = Side::inside});
  scene.add(Convex{.planes = {{{-1, 0, 0}, 0}, {{0, -1, 0}, 0}, {{0, 0, -1}, 0}, {{0, 0.6, 0.8}, 1.5}, {{1, 0, 0}, 1}}});
  scene.add(Motion{.center = {}, .keys = {{.time = 0}}});
  scene.add(
      Motion{.center = {0, 1, 0},
             .keys = {{.time = -1, .translation = {0, 1, 0}}, {.time = 2, .rotation = {0, 3, 0}, .arrival = Arrival::jump}}});
  scene.add(Kinematic{.particles = {1}, .motion = 1});
  scene.add(Skin{.particles = {2, 0},
                 .points = {{0, 0, 0}, {1, 0, 0}},
                 .at_most = std::vector<double>{0.5, 0},
                 .backstop = Backstop{.normals = {{0, 1, 0}, {0, 0, 1}}, .offset = std::vector<double>{0.25, 0}, .radius = 2.0},
                 .motion = 0});
  scene.add(Meet{.radius = std::vector<double>{0.1, 0.2, 0.3},
                 .restitution = 0.3,
                 .friction = 0.5,
                 .rounds = 6,
                 .most_neighbours = 32,
                 .near_at_start = NearAtStart::pass,
                 .groups = MeetGroups{.of = {0, 1, 1}, .meet = {{0, 1}, {1, 1}}}});
  scene.fixed = {2};
  CHECK(file.scene == scene);
  REQUIRE(stiffness.scalars().each().size() == 3);
  for (const double k : stiffness.scalars().each()) CHECK((k >= 1 && k < 2));
}

TEST_CASE("keys that may be left out have the contract's defaults") {
  const auto file = parse_scene(
      "least.json", R"({"format":"dvdx-scene/1","name":"","step":1,"duration":0,"particles":{"count":2.0}})", plenty);
  CHECK(file.scene == Scene{});
  CHECK(value_of(file.particles.position, 1) == Vec3{});
  CHECK(value_of(file.particles.velocity, 1) == Vec3{});
}

TEST_CASE("a lattice is filled along x first, then z, then y, and drawn from around its points") {
  json scene = json::parse(full_scene);
  json& lattice = scene["particles"]["position"];
  lattice = {{"lattice", {{"min", {1, 2, 3}}, {"max", {1.5, 9, 3.2}}, {"spacing", 0.25}}}};
  scene["particles"]["count"] = 5;
  for (const char* key : {"meet", "skins", "kinematic", "fixed", "forces"}) scene.erase(key);
  scene["particles"]["mass"] = 1;
  const auto even = parse_scene("hail.json", scene.dump(), plenty);
  CHECK(value_of(even.particles.position, 0) == Vec3{1, 2, 3});
  CHECK(value_of(even.particles.position, 2) == Vec3{1.5, 2, 3});
  CHECK(value_of(even.particles.position, 4) == Vec3{1.25, 2.25, 3});
  lattice["lattice"]["max"][2] = 3.25;
  lattice["lattice"].update(json{{"jitter", 0.125}, {"seed", 1}});
  const auto drawn = parse_scene("hail.json", scene.dump(), plenty);
  const Vec3 point{1.25, 2, 3.25};
  for (std::size_t axis = 0; axis < 3; ++axis)
    CHECK(std::abs(value_of(drawn.particles.position, 4)[axis] - point[axis]) <= 0.125);
  CHECK(value_of(drawn.particles.position, 4) != point);
  const auto other = parse_scene("hail.json", scene.dump(), {.seed = 5, .memory_bytes = plenty.memory_bytes});
  CHECK(value_of(other.particles.position, 4) != value_of(drawn.particles.position, 4));
}

TEST_CASE("a scene's push_out is that of contacts that have none of their own, and stands with contacts alone") {
  json scene = json::parse(full_scene);
  scene["push_out"] = 0.25;
  const auto file = parse_scene("hail.json", scene.dump(), plenty);
  CHECK(std::get<Plane>(file.scene.contacts[0]).push_out == 0.25);
  CHECK(std::get<Capsule>(file.scene.contacts[2]).push_out == 0.75);
  scene.erase("contacts");
  CHECK_THROWS_WITH_AS((void)parse_scene("hail.json", scene.dump(), plenty),
                       "hail.json: push_out is 0.25: must be left out of a scene without contacts", Fault);
}

TEST_CASE("a sphere without a side is hit from outside, and surfaces without a response send on") {
  const auto file =
      parse_scene("least.json", R"({"format":"dvdx-scene/1","name":"","step":1,"duration":0,"particles":{"count":2},
      "contacts":[{"type":"sphere","center":[0,0,0],"radius":1}]})",
                  plenty);
  const auto& sphere = std::get<Sphere>(file.scene.contacts[0]);
  CHECK(sphere.side == Side::outside);
  CHECK(sphere.response == Response::resume);
  CHECK(sphere.sweep == ContactPath::curve);
}

TEST_CASE("fixed particles start at rest, the others as they are told, in every precision") {
  const auto file = parse_scene("full.json", full_scene, plenty);
  Soa<float> narrow(3);
  Soa<double> wide(3);
  auto narrow_state = narrow.view();
  auto wide_state = wide.view();
  place_at_start(file, narrow_state);
  place_at_start(file, wide_state);
  CHECK(wide_state.v[2][1] == 3);
  for (const auto& column : wide_state.v) CHECK(column[2] == 0);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(narrow_state.x[axis][i] == static_cast<float>(wide_state.x[axis][i]));
  }
}

TEST_CASE("every shipped scene is read, and the schema accepts it") {
  const auto schema = scene_schema();
  const auto scenes = shipped_scenes();
  CHECK(scenes.size() >= 13);
  for (const auto& path : scenes) {
    CAPTURE(path);
    CHECK_NOTHROW((void)read_scene(path.string()));
    std::ifstream file(path);
    CHECK(schema.accepts(json::parse(file)));
  }
}

TEST_CASE("--set replaces a value before the scene is checked") {
  const auto with = [](std::vector<std::string> overrides) {
    return ReadOptions{.overrides = std::move(overrides), .memory_bytes = plenty.memory_bytes};
  };
  const auto file = parse_scene("full.json", full_scene,
                                with({"forces[4].stiffness=7.5", "contacts[0].response=seed", "particles.velocity=[7,8,9]",
                                      "forces[1].acceleration[1][1]=-1", "name=\"a = b\"", "meet.friction=0.25"}));
  CHECK(std::get<RadialSpring>(file.scene.forces[4]).stiffness == Scalars(7.5));
  CHECK(std::get<Plane>(file.scene.contacts[0]).response == Response::end_on_surface);
  CHECK(value_of(file.particles.velocity, 0) == Vec3{7, 8, 9});
  CHECK(std::get<Polynomial>(file.scene.forces[1]).acceleration[1][1] == -1);
  CHECK(file.name == "a = b");
  CHECK(file.scene.meet->friction == 0.25);
  CHECK(message_of(full_scene, with({"forces[4].stiffness=-3"})) ==
        "hail.json: forces[4].stiffness is -3: must be a finite number >= 0");
  CHECK(message_of(full_scene, with({"forces[9].stiffness=3"})) == "hail.json: forces[9] (from --set) is not in the scene");
  CHECK(message_of(full_scene, with({"particles.weight.min=3"})) ==
        "hail.json: particles.weight (from --set) is not in the scene");
  for (const char* misused : {"forces[0].stiffness", "=3", "forces[x]=3", "forces[0]stiffness=3", ".a=1", "a..b=1", "[0]=1",
                              "particles.velocity=[1,2"}) {
    CAPTURE(std::string(misused));
    try {
      (void)parse_scene("full.json", full_scene, with({misused}));
      FAIL("accepted");
    } catch (const Fault& fault) {
      CHECK(fault.exit() == Exit::usage);
    }
  }
}

// ---- what is wrong: values ---------------------------------------------------------------------------------------------

enum class BySchema { refused, accepted };  // what a schema can say about it

struct BadValue {
  const char* where;    // a JSON pointer into the full scene
  const char* value;    // put there; null: the key is taken away
  const char* message;  // after "hail.json: "
  BySchema schema = BySchema::refused;
};

constexpr BadValue bad_values[] = {
    {"/format", "\"dvdx-scene/2\"", "format is \"dvdx-scene/2\": must be \"dvdx-scene/1\""},
    {"/format", nullptr, "format is missing: a scene needs it"},
    {"/name", nullptr, "name is missing: a scene needs it"},
    {"/name", "7", "name is 7: must be a string"},
    {"/about", "[]", "about is []: must be a string"},
    {"/step", nullptr, "step is missing: a scene needs it"},
    {"/step", "0", "step is 0: must be a finite number > 0"},
    {"/step", "-0.25", "step is -0.25: must be a finite number > 0"},
    {"/step", "\"0.25\"", "step is \"0.25\": must be a finite number > 0"},
    {"/duration", "-2", "duration is -2: must be a finite number >= 0"},
    {"/duration", "2.1", "duration is 2.1: must be a whole number of steps of 0.25 s, and is 8.4 of them", BySchema::accepted},
    {"/duration", "1e300", "duration is 1e+300: must be at most 2^53 steps of 0.25 s, and is 4e+300 of them",
     BySchema::accepted},
    {"/method", "\"verlet\"",
     "method is \"verlet\": must be \"combined\", \"exact\", \"average_acceleration\", \"pulse\" or \"symplectic_euler\""},
    {"/gravity", "9.81",
     "gravity is not a key of a scene: Known are format, name, about, step, duration, method, particles, forces, contacts, "
     "network, constraints, constraint_iterations, substeps, most_substeps, fixed, motions, kinematic, origin, emitters, "
     "capacity, removal, "
     "wind, skins, tethers, faces, push_out, meet"},
    {"/faces", "true", "faces is true: must be \"auto\" or \"never\""},
    {"/faces", "\"always\"", "faces is \"always\": must be \"auto\" or \"never\""},
    {"/particles", nullptr, "particles is missing: a scene needs it"},
    {"/particles", "3", "particles is 3: must be an object with the keys count, mass, position, velocity"},
    {"/particles/count", nullptr, "particles.count is missing: particles needs it"},
    {"/particles/count", "0", "particles.count is 0: must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "-5", "particles.count is -5: must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "2.5", "particles.count is 2.5: must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "\"3\"", "particles.count is \"3\": must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "1000000000000",
     "particles.count is 1000000000000: must be at most 281848: a particle of this scene takes 3548 bytes, and 1.0 GB of "
     "memory "
     "are available",
     BySchema::accepted},
    {"/particles/count", "4", "particles.mass.values has 3 entries: must have 4, one for each particle", BySchema::accepted},
    {"/particles/mas", "1",
     "particles.mas is not a key of particles: did you mean mass? Known are count, mass, position, velocity"},
    {"/particles/mass", "0", "particles.mass is 0: must be a finite number > 0"},
    {"/particles/mass", "-1", "particles.mass is -1: must be a finite number > 0"},
    {"/particles/mass", "\"heavy\"",
     "particles.mass is \"heavy\": must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/particles/mass", "[1,2,3]",
     "particles.mass is [1,2,3]: must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/particles/mass", "{}",
     "particles.mass is {}: must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/particles/mass/values/1", "0", "particles.mass.values[1] is 0: must be a finite number > 0"},
    {"/particles/mass/values/1", "null", "particles.mass.values[1] is null: must be a finite number > 0"},
    {"/particles/mass/uniform", "{}",
     "particles.mass is {\"uniform\":{},\"values\":[1,2,3]}: must be a finite number > 0 or an object with one of values, "
     "uniform, "
     "file"},
    {"/particles/mass", R"({"uniform":{"min":3,"max":2,"seed":1}})",
     "particles.mass.uniform.min is 3: must be at most max, which is 2", BySchema::accepted},
    {"/particles/mass", R"({"uniform":{"min":0,"max":2,"seed":1}})",
     "particles.mass.uniform.min is 0: must be a finite number > 0"},
    {"/particles/mass", R"({"uniform":{"min":1,"max":2}})",
     "particles.mass.uniform.seed is missing: a uniform distribution needs it"},
    {"/particles/mass", R"({"uniform":{"min":1,"max":2,"seed":1.5}})",
     "particles.mass.uniform.seed is 1.5: must be a whole number from 0 to 18446744073709551615"},
    {"/particles/position/uniform/min/2", "5", "particles.position.uniform.min[2] is 5: must be at most max[2], which is 4",
     BySchema::accepted},
    {"/particles/position/uniform/max", "7", "particles.position.uniform.max is 7: must be a list of 3 numbers"},
    {"/particles/position/uniform", R"({"min":[-1e308,0,0],"max":[1e308,0,0],"seed":1})",
     "particles.position.uniform.max[0] is 1e+308: must be so close to min that max - min is finite", BySchema::accepted},
    {"/particles/position/uniform/sed", "1",
     "particles.position.uniform.sed is not a key of a uniform distribution: did you mean seed? Known are min, max, seed"},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[1,0,0],"spacing":1}})",
     "particles.position.lattice has room for 2 particles: must have room for 3", BySchema::accepted},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[9,9,9],"spacing":0}})",
     "particles.position.lattice.spacing is 0: must be a finite number > 0"},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[9,9,9],"spacing":1,"jitter":0.1}})",
     "particles.position.lattice.seed is missing: a lattice needs it", BySchema::accepted},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[9,-1,9],"spacing":1}})",
     "particles.position.lattice.min[1] is 0: must be at most max[1], which is -1", BySchema::accepted},
    {"/particles/mass", R"({"lattice":{"min":[0,0,0],"max":[9,9,9],"spacing":1}})",
     "particles.mass.lattice is not a key of a value for each particle: Known are values, uniform, file"},
    {"/particles/position", "\"start\"",
     "particles.position is \"start\": must be [x, y, z] or an object with one of values, uniform, file, lattice"},
    {"/particles/velocity", "[1,2]", "particles.velocity is [1,2]: must be a list of 3 numbers"},
    {"/particles/velocity/1", "true", "particles.velocity[1] is true: must be a finite number"},
    {"/particles/velocity", R"({"values":[[1,2,3]]})",
     "particles.velocity.values has 1 entries: must have 3, one for each particle", BySchema::accepted},
    {"/particles/velocity", R"({"values":[[1,2,3],[1,2],[1,2,3]]})",
     "particles.velocity.values[1] is [1,2]: must be a list of 3 numbers"},
    {"/forces", "{}", "forces is {}: must be a list of forces"},
    {"/forces/0", "[]", "forces[0] is []: must be an object"},
    {"/forces/0/type", nullptr, "forces[0].type is missing: a force needs it"},
    {"/forces/0/type", "\"gravity\"",
     "forces[0].type is \"gravity\": must be \"constant\", \"polynomial\", \"sinusoid\", \"spring\", \"radial_spring\" or "
     "\"drag\""},
    {"/forces/0/acceleration", nullptr, "forces[0].acceleration is missing: a constant force needs it"},
    {"/forces/0/method", "\"best\"",
     "forces[0].method is \"best\": must be \"combined\", \"exact\", \"average_acceleration\", \"pulse\" or "
     "\"symplectic_euler\""},
    {"/forces/1/acceleration", "[]", "forces[1].acceleration has 0 terms: must have 1 to 8"},
    {"/forces/1/acceleration", "[[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,1]]",
     "forces[1].acceleration has 9 terms: must have 1 to 8"},
    {"/forces/1/acceleration", "[0,1,0]", "forces[1].acceleration[0] is 0: must be a list of 3 numbers"},
    {"/forces/2/angular_frequency", nullptr, "forces[2].angular_frequency is missing: a sinusoid force needs it"},
    {"/forces/3/stiffness", "-3", "forces[3].stiffness is -3: must be a finite number >= 0"},
    {"/forces/3/stiffness", "[1,-1,1]", "forces[3].stiffness[1] is -1: must be a finite number >= 0"},
    {"/forces/3/stiffness", nullptr, "forces[3].stiffness is missing: a spring needs it"},
    {"/forces/3/stifness", "1",
     "forces[3].stifness is not a key of a spring: did you mean stiffness? Known are type, method, stiffness, damping, anchor"},
    {"/forces/3/damping", "-0.1", "forces[3].damping is -0.1: must be a finite number >= 0"},
    {"/forces/3/anchor", "\"home\"",
     "forces[3].anchor is \"home\": must be \"start\", [x, y, z] or an object with one of values, uniform, file, lattice"},
    {"/forces/3/anchor", nullptr, "forces[3].anchor is missing: a spring needs it"},
    {"/forces/4/rest_length", "-1", "forces[4].rest_length is -1: must be a finite number >= 0"},
    {"/forces/4/stiffness", "[1,1,1]",
     "forces[4].stiffness is [1,1,1]: must be a finite number >= 0 or an object with one of values, uniform, file"},
    {"/forces/5/coefficient", "-2", "forces[5].coefficient is -2: must be a finite number >= 0"},
    {"/forces/5/wind", "3", "forces[5].wind is 3: must be a list of 3 numbers"},
    {"/forces/5/expansion", "\"second_order\"",
     "forces[5].expansion is \"second_order\": must be \"exact\" or \"first_order\""},
    {"/contacts", "7", "contacts is 7: must be a list of contacts"},
    {"/contacts/0/type", "\"cube\"",
     "contacts[0].type is \"cube\": must be \"plane\", \"sphere\", \"capsule\", \"box\", \"convex\" or \"mesh\""},
    {"/contacts/0/normal", "[0,0,0]", "contacts[0].normal is [0,0,0]: must be a vector of finite length > 0",
     BySchema::accepted},
    {"/contacts/0/offset", nullptr, "contacts[0].offset is missing: a plane needs it"},
    {"/contacts/0/restitution", "1.5", "contacts[0].restitution is 1.5: must be a number from 0 to 1"},
    {"/contacts/0/restitution", "-0.5", "contacts[0].restitution is -0.5: must be a number from 0 to 1"},
    {"/contacts/0/friction", "-1", "contacts[0].friction is -1: must be a finite number >= 0"},
    {"/contacts/0/viscosity", "-1", "contacts[0].viscosity is -1: must be a finite number >= 0"},
    {"/contacts/1/normal_viscosity", "-1", "contacts[1].normal_viscosity is -1: must be a finite number >= 0"},
    {"/contacts/1/radius", "0", "contacts[1].radius is 0: must be a finite number > 0"},
    {"/contacts/1/side", "\"left\"", "contacts[1].side is \"left\": must be \"outside\" or \"inside\""},
    {"/contacts/1/response", "\"bounce\"", "contacts[1].response is \"bounce\": must be \"resume\" or \"seed\""},
    {"/contacts/1/sweep", "\"arc\"", "contacts[1].sweep is \"arc\": must be \"curve\" or \"line\""},
    {"/contacts/1/motion", "\"lilt\"", "contacts[1].motion is \"lilt\": must be \"arm\" or \"lift\"", BySchema::accepted},
    {"/contacts/0/thickness", "-1", "contacts[0].thickness is -1: must be a finite number >= 0"},
    {"/contacts/0/push_out", "0", "contacts[0].push_out is 0: must be a finite number > 0"},
    {"/push_out", "-1", "push_out is -1: must be a finite number > 0"},
    {"/contacts/2/ends", "[[0,0,0]]", "contacts[2].ends is [[0,0,0]]: must be two points"},
    {"/contacts/2/ends", "[[0,0,0],[1,2]]", "contacts[2].ends[1] is [1,2]: must be a list of 3 numbers"},
    {"/contacts/2/radius", "[1,2,3]", "contacts[2].radius is [1,2,3]: must be a number, or one for each end"},
    {"/contacts/2/radius", "[1,0]", "contacts[2].radius[1] is 0: must be a finite number > 0"},
    {"/contacts/3/radius", "-2", "contacts[3].radius is -2: must be a finite number > 0"},
    {"/contacts/4/half_extents", "[1,0,1]", "contacts[4].half_extents[1] is 0: must be a finite number > 0"},
    {"/contacts/4/rotation", "1", "contacts[4].rotation is 1: must be a list of 3 numbers"},
    {"/contacts/4/side", "\"left\"", "contacts[4].side is \"left\": must be \"outside\" or \"inside\""},
    {"/contacts/5/planes", "[]", "contacts[5].planes has 0 planes: must have 4 to 64"},
    {"/contacts/5/planes", "7", "contacts[5].planes is 7: must be a list of 4 to 64 planes"},
    {"/contacts/5/planes/1/normal", "[0,0,0]", "contacts[5].planes[1].normal is [0,0,0]: must be a vector of finite length > 0",
     BySchema::accepted},
    {"/contacts/5/planes/1/offset", nullptr, "contacts[5].planes[1].offset is missing: a plane of a convex body needs it"},
    {"/motions", "[]", "motions is []: must be an object of named motions"},
    {"/motions/arm/keys", "[]", "motions.arm.keys is []: must be a list of at least one key"},
    {"/motions/arm/keys", nullptr, "motions.arm.keys is missing: a motion needs it"},
    {"/motions/arm/kesy", "1", "motions.arm.kesy is not a key of a motion: did you mean keys? Known are center, keys"},
    {"/motions/arm/keys/0/time", nullptr, "motions.arm.keys[0].time is missing: a key of a motion needs it"},
    {"/motions/lift/keys/1/time", "-1", "motions.lift.keys[1].time is -1: must be a time after that of the key before, -1 s",
     BySchema::accepted},
    {"/motions/lift/keys/1/jump", "1", "motions.lift.keys[1].jump is 1: must be true or false"},
    {"/motions/lift/keys/1/rotation", "[0,3]", "motions.lift.keys[1].rotation is [0,3]: must be a list of 3 numbers"},
    {"/motions/lift/keys/0/translation/1", "null", "motions.lift.keys[0].translation[1] is null: must be a finite number"},
    {"/kinematic", "{}", "kinematic is {}: must be a list of objects with particles and motion"},
    {"/kinematic/0/motion", "\"hand\"", "kinematic[0].motion is \"hand\": must be \"arm\" or \"lift\"", BySchema::accepted},
    {"/kinematic/0/motion", nullptr, "kinematic[0].motion is missing: a group of kinematic particles needs it"},
    {"/kinematic/0/particles", "[3]", "kinematic[0].particles[0] is 3: must be a whole number from 0 to 2", BySchema::accepted},
    {"/kinematic/0/particles", "[2]", "kinematic[0].particles has particle 2, which is in fixed already: may be in one of them",
     BySchema::accepted},
    {"/kinematic/0/particles", "[1,1]", "kinematic[0].particles[1] is 1 a second time: an id may occur once",
     BySchema::accepted},
    {"/kinematic/0/particles", "\"top\"", "kinematic[0].particles is \"top\": must be a list of particle ids"},
    {"/kinematic/1", R"({"particles":[0,1],"motion":"arm"})",
     "kinematic[1].particles has particle 1, which is in kinematic[0].particles already: may be in one of them",
     BySchema::accepted},
    {"/skins", "{}", "skins is {}: must be a list of skins"},
    {"/skins/0/particles", nullptr, "skins[0].particles is missing: a skin needs it"},
    {"/skins/0/particles", "[2,3]", "skins[0].particles[1] is 3: must be a whole number from 0 to 2", BySchema::accepted},
    {"/skins/0/points", "[[0,0,0]]", "skins[0].points has 1 entries: must have one for each of the skin's 2 particles",
     BySchema::accepted},
    {"/skins/0/at_most", "-1", "skins[0].at_most is -1: must be a finite number >= 0"},
    {"/skins/0/at_most", "[1]", "skins[0].at_most has 1 entries: must have one for each of the skin's 2 particles",
     BySchema::accepted},
    {"/skins/0/motion", "\"hand\"", "skins[0].motion is \"hand\": must be \"arm\" or \"lift\"", BySchema::accepted},
    {"/skins/0/backstop/radius", nullptr, "skins[0].backstop.radius is missing: a back-stop needs it"},
    {"/skins/0/backstop/radius", "0", "skins[0].backstop.radius is 0: must be a finite number > 0"},
    {"/skins/0/backstop/normals", "[0,0,0]", "skins[0].backstop.normals is [0,0,0]: must be a vector of length > 0",
     BySchema::accepted},
    {"/skins/0/backstop/normal", "1",
     "skins[0].backstop.normal is not a key of a back-stop: did you mean normals? Known are normals, offset, radius"},
    {"/skins/1", R"({"particles":[0]})",
     "skins[1].particles has particle 0, which is in skins[0].particles already: may be in one of them", BySchema::accepted},
    {"/tethers", "[{}]", "tethers is [{}]: must be left out of a scene without networks", BySchema::accepted},
    {"/meet", "true",
     "meet is true: must be an object with the keys radius, thickness, part_of_cells, restitution, friction, rounds, "
     "most_neighbours, "
     "apart_at_start, groups"},
    {"/meet", "{}", "meet has none of radius, thickness and part_of_cells: must have one of them"},
    {"/meet/radius", "0", "meet.radius is 0: must be a finite number > 0"},
    {"/meet/radius/values/1", "-1", "meet.radius.values[1] is -1: must be a finite number > 0"},
    {"/meet/radius", "[0.1,0.2,0.3]",
     "meet.radius is [0.1,0.2,0.3]: must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/meet/thickness", "0.1", "meet.thickness is 0.1: must be left out beside radius: particles meet as balls or as cloth"},
    {"/meet/part_of_cells", "0.5",
     "meet.part_of_cells is 0.5: must be left out beside radius: particles meet as balls or as cloth"},
    {"/meet", R"({"thickness":0.1,"part_of_cells":0.5})",
     "meet.part_of_cells is 0.5: must be left out beside thickness: cloth has one thickness, or one of each cell"},
    {"/meet", R"({"part_of_cells":0})", "meet.part_of_cells is 0: must be a finite number > 0"},
    {"/meet", R"({"part_of_cells":1})", "meet.part_of_cells is 1: must be a number > 0 and < 1"},
    {"/meet", R"({"part_of_cells":0.5})",
     "meet.part_of_cells is 0.5: must be left out of a scene without networks: balls have a radius", BySchema::accepted},
    {"/meet", R"({"thickness":0})", "meet.thickness is 0: must be a finite number > 0"},
    {"/meet", R"({"thickness":0.1})",
     "meet.thickness is 0.1: must be left out of a scene without networks: balls have a radius", BySchema::accepted},
    {"/meet/restitution", "1.5", "meet.restitution is 1.5: must be a number from 0 to 1"},
    {"/meet/friction", "-0.5", "meet.friction is -0.5: must be a finite number >= 0"},
    {"/meet/rounds", "0", "meet.rounds is 0: must be a whole number from 1 to 64"},
    {"/meet/rounds", "65", "meet.rounds is 65: must be a whole number from 1 to 64"},
    {"/meet/most_neighbours", "256", "meet.most_neighbours is 256: must be a whole number from 1 to 255"},
    {"/meet/most_neighbors", "24",
     "meet.most_neighbors is not a key of meet: did you mean most_neighbours? Known are radius, thickness, part_of_cells, "
     "restitution, friction, rounds, most_neighbours, apart_at_start, groups"},
    {"/meet/apart_at_start", "1", "meet.apart_at_start is 1: must be true or false"},
    {"/meet/groups/of", nullptr, "meet.groups.of is missing: groups needs it"},
    {"/meet/groups/of", "[0,1]", "meet.groups.of has 2 entries: must have 3, one for each particle", BySchema::accepted},
    {"/meet/groups/of/1", "65536", "meet.groups.of[1] is 65536: must be a whole number from 0 to 1023"},
    {"/meet/groups/meet/0", "[0]", "meet.groups.meet[0] is [0]: must be two groups"},
    {"/meet/groups/meet/0/1", "-1", "meet.groups.meet[0][1] is -1: must be a whole number from 0 to 1023"},
    {"/fixed", "2", "fixed is 2: must be a list of particle ids"},
    {"/fixed", "[3]", "fixed[0] is 3: must be a whole number from 0 to 2", BySchema::accepted},
    {"/fixed", "[-1]", "fixed[0] is -1: must be a whole number from 0 to 2"},
    {"/fixed", "[0,1,0]", "fixed[2] is 0 a second time: an id may occur once"},
};

json full_with(const BadValue& bad) {
  json scene = json::parse(full_scene);
  const json::json_pointer where(bad.where);
  if (bad.value != nullptr) {
    scene[where] = json::parse(bad.value);
  } else {
    scene[where.parent_pointer()].erase(where.back());
  }
  return scene;
}

TEST_CASE("every bad value is refused with its path, its value and what is valid") {
  CHECK(std::size(bad_values) >= 40);
  for (const auto& bad : bad_values) {
    CAPTURE(std::string(bad.where));
    CHECK(message_of(full_with(bad).dump()) == std::string("hail.json: ") + bad.message);
  }
}

TEST_CASE("the schema refuses what a schema can") {
  const auto schema = scene_schema();
  CHECK(schema.accepts(json::parse(full_scene)));
  for (const auto& bad : bad_values) {
    CAPTURE(std::string(bad.where));
    CAPTURE(std::string(bad.message));
    CHECK(schema.accepts(full_with(bad)) == (bad.schema == BySchema::accepted));
  }
}

// ---- what is wrong: text -----------------------------------------------------------------------------------------------

struct BadText {
  const char* text;
  const char* message;  // after "hail.json: "
};

constexpr BadText bad_texts[] = {
    {"", "the file is empty: must be a JSON object of the format dvdx-scene/1"},
    {" \r\n\t", "the file is empty: must be a JSON object of the format dvdx-scene/1"},
    {"\xEF\xBB\xBF{}", "the file starts with a byte order mark: must be UTF-8 without one"},
    {"\xFF\xFE{", "the file starts with a byte order mark: must be UTF-8 without one"},
    {"[1, 2]",
     "the scene is [1,2]: must be an object with the keys format, name, about, step, duration, method, particles, forces, "
     "contacts, network, constraints, constraint_iterations, substeps, most_substeps, fixed, motions, kinematic, origin, "
     "emitters, capacity, "
     "removal, wind, skins, tethers, faces, push_out, meet"},
    {"{\"name\": \"a\", \"name\": \"b\"}", "name is there twice: a key may occur once in an object"},
    {"{\"forces\": [{}, {\"type\": 1, \"type\": 1}]}", "forces[1].type is there twice: a key may occur once in an object"},
    {"{\"forces\": [{\"stiffness\": 1e999}]}", "forces[0].stiffness is 1e999: must be a finite number"},
    {"{\"forces\": [{\"stiffness\":\n [1, 2, -1e999]}]}", "forces[0].stiffness[2] is -1e999: must be a finite number"},
    {"{\"forces\": [\n  {\"type\": \"spring\"",
     "line 2, column 19, in forces[0].type: the file ends here, before the JSON does: is it cut off?"},
    {"{\"name\": \"abc", "line 1, column 13, in name: the file ends here, before the JSON does: is it cut off?"},
};

TEST_CASE("text that is no scene is refused with its place") {
  for (const auto& bad : bad_texts) {
    CAPTURE(std::string(bad.text));
    CHECK(message_of(bad.text) == std::string("hail.json: ") + bad.message);
  }
  // The parser's own words follow: only ours are held.
  CHECK(message_of("{\"step\": NaN}").starts_with("hail.json: line 1, column 10, in step: not JSON: "));
  CHECK(message_of("{\"step\": 1,}").starts_with("hail.json: line 1, column 12, in step: not JSON: "));
  CHECK(message_of("{} {}").starts_with("hail.json: line 1, column 4: not JSON: "));
  CHECK(message_of("{\"name\": \"\xC3(\"}").starts_with("hail.json: line 1, column 12, in name: not JSON: "));
  CHECK(message_of(std::string(100000, '[')).ends_with("is nested more than 32 deep: no scene is"));
}

// ---- what is wrong: files ----------------------------------------------------------------------------------------------

struct BadFile {
  const char* key;   // of the particles
  const char* name;  // of the file
  std::string_view bytes;
  const char* message;  // after the file's name
};

constexpr std::string_view ply_start = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
constexpr char npy_header[] =
    "\x93NUMPY\x01\x00\x46\x00{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }          \n";

const BadFile bad_files[] = {
    {"position", "p.csv", "x,y,z\n1,2,3\n4,5,6\n", "holds 2 points: must hold 3, one for each particle"},
    {"position", "p.csv", "1,2,3\n4,5,6\n7,8\n", "line 3 has 2 numbers: must have 3"},
    {"position", "p.csv", "1,2\n", "line 1 has 2 numbers: must have 3"},
    {"position", "p.csv", "1,2,3\n4,nan,6\n7,8,9\n", "line 2 holds nan: must be a finite number"},
    {"position", "p.csv", "1,2,3\n4,1e999,6\n7,8,9\n", "line 2 holds 1e999: must be a finite number"},
    {"position", "p.csv", "1,2,3\n4,five,6\n7,8,9\n", "line 2 holds five: must be a finite number"},
    {"position", "p.csv", "a,b,z\n1,2,3\n", "line 1 names no column x: must name x, y and z"},
    {"position", "p.csv", "x,y,z,x\n1,2,3,4\n", "line 1 names two columns x: must name one"},
    {"position", "p.csv", "", "holds 0 points: must hold 3, one for each particle"},
    {"position", "p.xyz", "1 2 3\n", "must end in .csv, .ply or .npy"},
    {"position", "p.ply", "", "is not a PLY file"},
    {"position", "p.ply", ply_start, "ends inside its header: is it cut off?"},
    {"position", "p.ply", "ply\nformat binary_big_endian 1.0\nend_header\n",
     "must be of format ascii 1.0 or binary_little_endian 1.0"},
    {"position", "p.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nend_header\n",
     "a vertex must have the properties x, y and z"},
    {"position", "p.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n4 5 "
     "6\n",
     "holds 2 of the 3 vertices that its header promises: is it cut off?"},
    {"position", "p.ply",
     "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
     "end_header\n0123456789ab0123456789",
     "holds 1 of the 3 vertices that its header promises: is it cut off?"},
    {"position", "p.npy", "PK", "is not a NumPy array file"},
    {"position", "p.npy", std::string_view(npy_header, 30), "ends inside its header: is it cut off?"},
    {"position", "p.npy", std::string_view(npy_header, sizeof npy_header - 1),
     "holds 0 of the 3 rows that its header promises: is it cut off?"},
    {"mass", "m.npy", std::string_view(npy_header, sizeof npy_header - 1), "has the shape (3, 3): must be (n,)"},
    {"mass", "m.csv", "1\n2\n", "holds 2 numbers: must hold 3, one for each particle"},
    {"mass", "m.csv", "mass\n1\n-2\n3\n", "number 1 is -2.0: must be a finite number > 0"},
    {"mass", "m.csv", "1,2\n", "line 1 has 2 numbers: must have 1"},
    {"mass", "m.ply", "ply\n", "must end in .csv or .npy"},
};

std::string scene_with_file(const std::string& key, const std::string& name) {
  json scene = json::parse(full_scene);
  scene["particles"][key] = {{"file", name}};
  return scene.dump();
}

TEST_CASE("every bad file that a scene refers to is refused by name") {
  const test::ScratchFolder folder("bad-files");
  for (const auto& bad : bad_files) {
    CAPTURE(std::string(bad.message));
    folder.write(bad.name, bad.bytes);
    const std::string path = folder / "scene.json";
    const std::string expected = path + ": particles." + bad.key + ".file is \"" + bad.name + "\": " + bad.message;
    CHECK(message_of(scene_with_file(bad.key, bad.name), plenty, path) == expected);
  }
  CHECK(message_of(scene_with_file("position", "none.csv"), plenty, folder / "s.json")
            .ends_with("particles.position.file is \"none.csv\": cannot be read: No such file or directory"));
  CHECK(message_of(scene_with_file("position", "."), plenty, folder / "s.json")
            .ends_with("particles.position.file is \".\": must end in .csv, .ply or .npy"));
}

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

TEST_CASE("points come out of every kind of file as they went in") {
  const test::ScratchFolder folder("points");
  folder.write("bare.csv", "1,2,3\n\n# a remark\n4, 5 ,6\r\n+7,8e0,9");
  folder.write("named.csv", "step,z,y,x\n0,3,2,1\n0,6,5,4\n0,9,8,7\n");
  const std::string header =
      " 1.0\ncomment made by hand\nelement vertex 3\nproperty float x\nproperty uchar red\n"
      "property double y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  folder.write("ascii.ply", "ply\nformat ascii" + header + "1 255 2 3\n4 0 5 6\n7 0 8 9\n");
  std::string rows;
  for (float i : {1.0F, 4.0F, 7.0F}) rows += bytes_of({i}) + '\xFF' + bytes_of({i + 1.0}) + bytes_of({i + 2});
  folder.write("binary.ply", "ply\nformat binary_little_endian" + header + rows);
  folder.write("wide.npy", std::string(npy_header, sizeof npy_header - 1) + bytes_of({1., 2., 3., 4., 5., 6., 7., 8., 9.}));
  std::string second = std::string("\x93NUMPY\x02\x00\x44\x00\x00\x00", 12) +
                       "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 3), }        \n";
  folder.write("second.npy", second + bytes_of({1.F, 2.F, 3.F, 4.F, 5.F, 6.F, 7.F, 8.F, 9.F}));
  for (const char* name : {"bare.csv", "named.csv", "ascii.ply", "binary.ply", "wide.npy", "second.npy"}) {
    CAPTURE(std::string(name));
    const auto file = parse_scene(folder / "scene.json", scene_with_file("position", name), plenty);
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = 1 + 3 * static_cast<double>(i);
      CHECK(value_of(file.particles.position, i) == Vec3{x, x + 1, x + 2});
    }
  }
}

// ---- input and output --------------------------------------------------------------------------------------------------

TEST_CASE("a file that holds more than it should is refused as one that holds less") {
  CHECK_THROWS_AS((void)parse_points("1,2,3\n4,5,6,7\n", PointsFormat::csv), FileFault);
  const std::string header(npy_header, sizeof npy_header - 1);
  CHECK(parse_points(header + std::string(72, '\0'), PointsFormat::npy).size() == 3);
  CHECK_THROWS_AS((void)parse_points(header + std::string(80, '\0'), PointsFormat::npy), FileFault);
}

TEST_CASE("--set of what would stand one behind a list's end is refused") {
  const std::string last = "contacts[" + std::to_string(json::parse(full_scene)["contacts"].size()) + "]";
  const ReadOptions options{.overrides = {last + "={}"}, .memory_bytes = plenty.memory_bytes};
  CHECK(message_of(full_scene, options) == "hail.json: " + last + " (from --set) is not in the scene");
}

TEST_CASE("a scene file that cannot be read is a matter of input, not of the scene") {
  const test::ScratchFolder folder("no-scene");
  for (const std::string& path : {folder / "none.json", folder.path().string()}) {
    CAPTURE(path);
    try {
      (void)read_scene(path);
      FAIL("read");
    } catch (const Fault& fault) {
      CHECK(fault.exit() == Exit::input_output);
      CHECK(std::string(fault.what()).starts_with(path + ": cannot be read: "));
    }
  }
}

TEST_CASE("a start beyond float32 is refused there and accepted in float64") {
  json scene = json::parse(full_scene);
  scene["particles"]["velocity"] = {1e300, 0, 0};
  const auto file = parse_scene("hail.json", scene.dump(), plenty);
  Soa<float> narrow(3);
  Soa<double> wide(3);
  auto narrow_state = narrow.view();
  auto wide_state = wide.view();
  CHECK_NOTHROW(place_at_start(file, wide_state));
  CHECK_THROWS_WITH_AS(place_at_start(file, narrow_state),
                       "hail.json: particles.velocity is 1e+300 for particle 0: must be at most 3.4e+38 in float32", Fault);
}

}  // namespace scene_reader_test
