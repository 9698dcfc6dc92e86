// How a scene's particles stand at time 0, and whether their numbers are finite.
#include "run/start.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "run/health.hpp"
#include "run/state_memory.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"

namespace {

using namespace dvdx;
using namespace dvdx::tool;

constexpr std::size_t particles = 70'001;

SceneFile drawn(const std::string& velocity = R"({"uniform": {"min": [-1, -2, -3], "max": [3, 2, 1], "seed": 8}})") {
  return parse_scene("drawn.json", R"({"format": "dvdx-scene/1", "name": "drawn", "step": 0.5, "duration": 1, "particles": {
    "count": 70001, "position": {"uniform": {"min": [-5, 0, 1], "max": [5, 9, 2], "seed": 7}}, "velocity": )" +
                                       velocity + "}}");
}

// The last one first: what threads may do.
constexpr ParallelFor backwards{.run = [](void*, std::size_t count, ParallelFor::Body body, void* task) {
  while (count-- > 0) body(task, count);
}};

}  // namespace

TEST_CASE_TEMPLATE("particles stand where the scene puts them, whatever the threads", T, float, double) {
  const SceneFile file = drawn();
  for (const auto layout : {Layout::soa, Layout::aos, Layout::aosoa}) {
    StateMemory<T> memory(layout, particles);
    State<T> state = memory.view();
    place_at_start(file, state, backwards);
    for (std::size_t i = 0; i < particles; ++i) {
      const Vec3 position = value_of(file.particles.position, i);
      const Vec3 velocity = value_of(file.particles.velocity, i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        REQUIRE(state.x[axis][i] == static_cast<T>(position[axis]));
        REQUIRE(state.v[axis][i] == static_cast<T>(velocity[axis]));
      }
    }
  }
}

TEST_CASE("the first value beyond float32 is named, whatever the threads") {
  SceneFile file = drawn("[0, 0, 0]");
  std::vector<Vec3> velocities(particles);
  velocities[20'000] = {0, 1e39, 0};
  velocities[60'000] = {-1e40, 0, 0};
  file.particles.velocity = velocities;
  StateMemory<float> memory(Layout::soa, particles);
  State<float> state = memory.view();
  constexpr const char* message =
      "drawn.json: particles.velocity is 1e+39 for particle 20000: must be at most 3.4e+38 in float32";
  CHECK_THROWS_WITH_AS(place_at_start(file, state), message, Fault);
  CHECK_THROWS_WITH_AS(place_at_start(file, state, backwards), message, Fault);
}

TEST_CASE("health: particles that are not finite are counted, and the largest finite number is found") {
  StateMemory<double> memory(Layout::soa, particles);
  State<double> state = memory.view();
  state.x[1][5] = -7;
  state.v[2][particles - 1] = std::numeric_limits<double>::infinity();
  state.v[0][particles - 1] = std::nan("");
  state.x[0][40'000] = std::nan("");
  for (const auto& parallel : {ParallelFor{}, backwards}) {
    const Health health = health_of(state, parallel);
    CHECK(health.bad_particles == 2);
    CHECK(health.largest == 7);
  }
}
