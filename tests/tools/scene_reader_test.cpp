// Correct scenes are read exactly.
#include "scene_io/scene_reader.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "dvdx/layouts/soa.hpp"
#include "scene_io/fault.hpp"
#include "state/start.hpp"
#include "support/paths.hpp"
#include "tools/scene_texts.hpp"

namespace scene_texts::scene_reader_test {

std::vector<std::filesystem::path> shipped_scenes() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(dvdx::test::scenes())) {
    if (entry.path().extension() == ".json") paths.push_back(entry.path());
  }
  return paths;
}

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

TEST_CASE("a scene's push_out is that of contacts without their own, and is refused without contacts") {
  json scene = json::parse(full_scene);
  scene["push_out"] = 0.25;
  const auto file = parse_scene("hail.json", scene.dump(), plenty);
  CHECK(std::get<Plane>(file.scene.contacts[0]).push_out == 0.25);
  CHECK(std::get<Capsule>(file.scene.contacts[2]).push_out == 0.75);
  scene.erase("contacts");
  CHECK_THROWS_WITH_AS((void)parse_scene("hail.json", scene.dump(), plenty),
                       "hail.json: push_out is 0.25: must be left out of a scene without contacts", Fault);
}

TEST_CASE("a sphere without a side is hit from outside, and a surface without a response resumes the motion") {
  const auto file =
      parse_scene("least.json", R"({"format":"dvdx-scene/1","name":"","step":1,"duration":0,"particles":{"count":2},
      "contacts":[{"type":"sphere","center":[0,0,0],"radius":1}]})",
                  plenty);
  const auto& sphere = std::get<Sphere>(file.scene.contacts[0]);
  CHECK(sphere.side == Side::outside);
  CHECK(sphere.response == Response::resume);
  CHECK(sphere.sweep == ContactPath::curve);
}

TEST_CASE("fixed particles start at rest, all others as the scene says, in every precision") {
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

TEST_CASE("--set of the entry just behind a list's end is refused") {
  const std::string last = "contacts[" + std::to_string(json::parse(full_scene)["contacts"].size()) + "]";
  const ReadOptions options{.overrides = {last + "={}"}, .memory_bytes = plenty.memory_bytes};
  CHECK(message_of(full_scene, options) == "hail.json: " + last + " (from --set) is not in the scene");
}

TEST_CASE("a start beyond float32 is refused in float32 and accepted in float64") {
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

}  // namespace scene_texts::scene_reader_test
