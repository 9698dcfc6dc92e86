// Scenes whose particles come and go: accepted input and refusals.
#include "scene_io/turnover_reader.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "state/live_memory.hpp"
#include "support/paths.hpp"
#include "tools/schema.hpp"

namespace turnover_reader_test {

using namespace dvdx;
using namespace dvdx::tool;
using nlohmann::json;

constexpr const char* live_scene = R"({
  "format": "dvdx-scene/1", "name": "live", "step": 0.25, "duration": 2, "capacity": 100,
  "particles": {"count": 3, "mass": 0.5, "position": {"values": [[0,0,0],[1,1,1],[2,2,2]]}},
  "motions": {"legs": {"keys": [{"time": 0}]}, "arm": {"keys": [{"time": 0}]}},
  "emitters": [
    {"type": "point", "at": [1, 2, 3], "rate": 10, "seed": 7},
    {"type": "disc", "center": [1, 2, 3], "normal": [0, 0, 2], "radius": 0.5, "rate": 2.5, "start": 1, "end": 3,
     "velocity": [4, 5, 6], "spread": 0.25, "lifetime": 2, "seed": 8, "motion": "legs"},
    {"type": "box", "min": [0, 0, 0], "max": [1, 0, 1], "rate": 0, "spread": [1, 0, 2], "lifetime": {"min": 1, "max": 3}, "seed": 9}
  ],
  "removal": {"boundaries": [{"normal": [0, 1, 0], "offset": -1}], "outside": {"min": [-9, -9, -9], "max": [9, 9, 9]},
              "not_finite": "removed", "order": "any"}
})";

const ReadOptions plenty{.memory_bytes = 1000000000};

std::string message_of(const json& scene, const ReadOptions& options = plenty) {
  try {
    (void)parse_scene("live.json", scene.dump(), options);
    return "";
  } catch (const Fault& fault) {
    CHECK(fault.exit() == Exit::bad_scene);
    return fault.what();
  }
}

dvdx::test::Schema scene_schema() {
  std::ifstream file(dvdx::test::schema());
  return dvdx::test::Schema(json::parse(file));
}

struct BadValue {
  const char* where;  // a JSON pointer
  const char* value;  // null: left out
  const char* message;
  bool is_accepted_by_schema = false;
};

constexpr BadValue bad_values[] = {
    {"/capacity", nullptr, "capacity is missing: a scene needs it"},
    {"/capacity", "2", "capacity is 2: must be a whole number from 3 to 4294967295", true},
    {"/capacity", "0.5", "capacity is 0.5: must be a whole number from 3 to 4294967295"},
    {"/emitters", "{}", "emitters is {}: must be a list of emitters"},
    {"/emitters/0", "3", "emitters[0] is 3: must be an object"},
    {"/emitters/0/type", nullptr, "emitters[0].type is missing: an emitter needs it"},
    {"/emitters/0/type", "\"ring\"", "emitters[0].type is \"ring\": must be \"point\", \"disc\" or \"box\""},
    {"/emitters/0/rate", nullptr, "emitters[0].rate is missing: a point that emits needs it"},
    {"/emitters/0/rate", "-1", "emitters[0].rate is -1: must be a finite number >= 0"},
    {"/emitters/0/seed", nullptr, "emitters[0].seed is missing: a point that emits needs it"},
    {"/emitters/0/radius", "1",
     "emitters[0].radius is not a key of a point that emits: Known are type, at, rate, start, end, "
     "velocity, "
     "spread, lifetime, seed, motion"},
    {"/emitters/1/normal", "[0,0,0]", "emitters[1].normal is [0,0,0]: must be a vector of finite length > 0", true},
    {"/emitters/1/radius", "-1", "emitters[1].radius is -1: must be a finite number >= 0"},
    {"/emitters/1/end", "0.5", "emitters[1].end is 0.5: must be at least start, which is 1", true},
    {"/emitters/1/lifetime", "0", "emitters[1].lifetime is 0: must be a finite number > 0"},
    {"/emitters/1/motion", "\"tail\"", "emitters[1].motion is \"tail\": must be \"arm\" or \"legs\"", true},
    {"/emitters/1/spread", "-2", "emitters[1].spread is -2: must be a finite number >= 0"},
    {"/emitters/2/spread/2", "-2", "emitters[2].spread[2] is -2: must be a finite number >= 0"},
    {"/emitters/2/max", "[1,0,-1]", "emitters[2].min[2] is 0: must be at most max[2], which is -1", true},
    {"/emitters/2/lifetime/min", "4", "emitters[2].lifetime.min is 4: must be at most max, which is 3", true},
    {"/removal/boundaries/0/offset", nullptr, "removal.boundaries[0].offset is missing: a boundary needs it"},
    {"/removal/outside/max", "[9,-10,9]", "removal.outside.min[1] is -9: must be at most max[1], which is -10", true},
    {"/removal/not_finite", "true", "removal.not_finite is true: must be \"kept\" or \"removed\""},
    {"/removal/order", "\"first\"", "removal.order is \"first\": must be \"kept\" or \"any\""},
};

json scene_with(const BadValue& bad) { return test::with_value(live_scene, bad.where, bad.value); }

TEST_CASE("emitters, capacity and removal are read as they stand") {
  const auto file = parse_scene("live.json", live_scene, plenty);
  CHECK(is_live(file));
  CHECK(file.particles.count == 3);
  Lifecycle wanted;
  wanted.capacity = 100;
  wanted.emitters.push_back({.shape = Vec3{1, 2, 3}, .rate = 10, .seed = 7});
  wanted.emitters.push_back({.shape = Disc{.center = {1, 2, 3}, .normal = {0, 0, 2}, .radius = 0.5},
                             .rate = 2.5,
                             .start = 1,
                             .end = 3,
                             .velocity = {4, 5, 6},
                             .spread = 0.25,
                             .least_lifetime = 2,
                             .most_lifetime = 2,
                             .seed = 8,
                             .motion = 1});
  wanted.emitters.push_back(
      {.shape = Box{.min = {}, .max = {1, 0, 1}}, .spread = Vec3{1, 0, 2}, .least_lifetime = 1, .most_lifetime = 3, .seed = 9});
  wanted.removal = {.boundaries = {{.normal = {0, 1, 0}, .offset = -1}},
                    .outside = Box{.min = {-9, -9, -9}, .max = {9, 9, 9}},
                    .not_finite = NotFinite::removed,
                    .order = SurvivorOrder::any};
  CHECK(file.turnover == wanted);
}

TEST_CASE("a removal keeps the order and particles that are not finite by default") {
  json scene = json::parse(live_scene);
  scene["removal"] = json::object();
  const Removal removal = parse_scene("live.json", scene.dump(), plenty).turnover.removal;
  CHECK(removal.not_finite == NotFinite::kept);
  CHECK(removal.order == SurvivorOrder::kept);
}

TEST_CASE("a scene with emitters needs no particles of its own, and one without has no turnover") {
  json scene = json::parse(live_scene);
  scene.erase("particles");
  CHECK(parse_scene("live.json", scene.dump(), plenty).particles.count == 0);
  scene["particles"] = {{"mass", 2}};
  CHECK(parse_scene("live.json", scene.dump(), plenty).scene.mass == Scalars(2.0));
  CHECK(scene_schema().accepts(scene));
  CHECK_FALSE(is_live(parse_scene(
      "least.json", R"({"format":"dvdx-scene/1","name":"","step":1,"duration":0,"particles":{"count":2}})", plenty)));
}

TEST_CASE("every bad value of emitters, capacity and removal is refused by its path, and by the schema where it can") {
  const auto schema = scene_schema();
  CHECK(schema.accepts(json::parse(live_scene)));
  for (const auto& bad : bad_values) {
    CAPTURE(std::string(bad.where));
    CHECK(message_of(scene_with(bad)) == std::string("live.json: ") + bad.message);
    CHECK(schema.accepts(scene_with(bad)) == bad.is_accepted_by_schema);
  }
}

TEST_CASE("each rank reads its range of the starting particles, and the capacity is that of all ranks together") {
  const auto second = [](std::uint64_t bytes) { return ReadOptions{.memory_bytes = bytes, .share = {.rank = 1, .ranks = 2}}; };
  const auto file = parse_scene("live.json", live_scene, second(1000000000));
  CHECK(file.particles.count == 1);
  CHECK(file.particles.first == 2);
  CHECK(file.particles.total() == 3);
  CHECK(value_of(file.particles.position, 0) == Vec3{2, 2, 2});
  CHECK(message_of(json::parse(live_scene), second(5199)).starts_with("live.json: capacity is 100: must be at most 99"));
  CHECK(message_of(json::parse(live_scene), second(5200)).empty());
  json fewer = json::parse(live_scene);
  fewer["capacity"] = 2;
  CHECK(message_of(fewer, second(5200)).starts_with("live.json: capacity is 2: must be a whole number from 3"));
}

TEST_CASE("a capacity beyond the memory is refused, and so is a mass for each particle") {
  CHECK(message_of(json::parse(live_scene), {.memory_bytes = 3999})
            .starts_with("live.json: capacity is 100: must be at most 99"));
  json scene = json::parse(live_scene);
  scene["particles"]["mass"] = {{"values", {1, 2, 3}}};
  const auto file = parse_scene("live.json", scene.dump(), plenty);
  CHECK_THROWS_WITH_AS((void)live_plan<float>(file, {.step = file.step}),
                       "live.json: mass is given for each particle: must be alike for all particles where they come and go",
                       Fault);
  CHECK_THROWS_AS(refuse_turnover(file, "report"), Fault);
}

}  // namespace turnover_reader_test
