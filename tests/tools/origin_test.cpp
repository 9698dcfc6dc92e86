// The origin of float32 states.
#include "state/origin.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "scene_io/scene_reader.hpp"
#include "state/start.hpp"
#include "state/state_memory.hpp"

namespace origin_command_test {

using namespace dvdx;
using namespace dvdx::tool;

SceneFile scene(const std::string& particles, const std::string& more, Precision precision = Precision::float32) {
  auto file = parse_scene("test", R"({"format": "dvdx-scene/1", "name": "far", "step": 0.5, "duration": 1, "particles": )" +
                                      particles + more + "}");
  choose_origin(file, precision);
  return file;
}

constexpr const char* here_and_far = R"({"count": 2, "position": {"values": [[1, 0.5, 0], [10001, 0.5, 0]]}})";
constexpr const char* both_far = R"({"count": 2, "position": {"values": [[10002.25, 0.5, 0], [10001, 0.5, 0]]}})";
constexpr const char* springs =
    R"(, "forces": [{"type": "spring", "stiffness": 36, "anchor": {"values": [[0, 0, 0], [10000.25, 0, 0]]}}])";
constexpr const char* ground = R"(, "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0}])";

TEST_CASE("origin of a scene: each particle far out has its own, near its anchor or its start") {
  const auto held = scene(here_and_far, springs);
  REQUIRE(held.scene.origin.is_each());
  CHECK(held.scene.origin.at(0) == Vec3{0, 0, 0});
  CHECK(held.scene.origin.at(1) == Vec3{10000, 0, 0});
  CHECK(scene(here_and_far, "").scene.origin.at(1) == Vec3{10001, 1, 0});
}

TEST_CASE("origin of a scene: contacts or springs give all particles one, if it brings them nearer") {
  CHECK(scene(both_far, ground).scene.origin == Origin(Vec3{10002, 1, 0}));
  CHECK(scene(here_and_far, ground).scene.origin.is_world());
  CHECK(scene(both_far, R"(, "network": {"type": "springs", "pairs": [[0, 1]], "stiffness": 3, "rest_length": "start"})")
            .scene.origin == Origin(Vec3{10002, 1, 0}));
}

TEST_CASE("origin of a scene: a shared one lies in the middle of all drawn particles, not of the first ones") {
  const auto drawn = [](const char* bounds) {
    return scene(std::string(R"({"count": 100000, "position": {"uniform": {)") + bounds + R"(, "seed": 1}}})", ground);
  };
  const auto far = drawn(R"("min": [1000000, 1, 1], "max": [1200000, 1.4, 1.4])");
  double low = 1e9, high = 0;
  for (std::size_t i = 0; i < 100000; ++i) {
    const double x = value_of(far.particles.position, i)[0];
    low = std::min(low, x);
    high = std::max(high, x);
  }
  CHECK(far.scene.origin == Origin(Vec3{std::round((low + high) / 2), 1, 1}));
  CHECK(drawn(R"("min": [-500, 1, 1], "max": [500, 2, 2])").scene.origin.is_world());
}

TEST_CASE("origin of a scene: the world's own is kept near home, in float64, compensated, and where the file says so") {
  CHECK(scene(R"({"count": 1, "position": [60, 0, 0]})", "").scene.origin.is_world());
  CHECK(scene(both_far, springs, Precision::float64).scene.origin.is_world());
  CHECK(scene(both_far, springs, Precision::float32_compensated).scene.origin.is_world());
  CHECK(scene(both_far, R"(, "origin": [0, 0, 0])").scene.origin.is_world());
  CHECK(scene(both_far, R"(, "origin": [10000, 0, 0])").scene.origin == Origin(Vec3{10000, 0, 0}));
  CHECK(scene(both_far, R"(, "origin": "auto")").scene.origin.is_each());
}

TEST_CASE("a start stored relative to its origin reads back where the scene puts it") {
  const auto file = scene(here_and_far, springs);
  StateMemory<float> memory(Layout::aos, 2);
  auto state = memory.view();
  place_at_start(file, state);
  CHECK(state.x[0][1] == 1.0F);
  Soa<double> world(2);
  auto seen = world.view();
  to_world(file.scene, state, seen);
  CHECK(seen.x[0][1] == 10001);
  CHECK(seen.x[0][0] == 1);
}

TEST_CASE("a compensated start keeps digits that float32 cannot hold") {
  const auto file =
      scene(R"({"count": 1, "position": [10000.1, 0, 0], "velocity": [0.1, 0, 0]})", "", Precision::float32_compensated);
  StateMemory<float> memory(Layout::aosoa, 1, Rounding::compensated);
  auto state = memory.view();
  place_at_start(file, state);
  Soa<double> world(1);
  auto seen = world.view();
  to_world(file.scene, state, seen);
  CHECK(std::abs(seen.x[0][0] - 10000.1) < 1e-10);
  CHECK(std::abs(seen.v[0][0] - 0.1) < 1e-15);
}

}  // namespace origin_command_test
