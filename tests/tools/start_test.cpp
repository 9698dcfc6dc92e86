// The places of a scene's particles at time 0, and the check that their numbers are finite.
#include "state/start.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "state/health.hpp"
#include "state/state_memory.hpp"

namespace start_test {

using namespace dvdx;
using namespace dvdx::tool;

constexpr std::size_t particles = 70'001;

SceneFile drawn(const std::string& velocity = R"({"uniform": {"min": [-1, -2, -3], "max": [3, 2, 1], "seed": 8}})") {
  return parse_scene("drawn.json", R"({"format": "dvdx-scene/1", "name": "drawn", "step": 0.5, "duration": 1, "particles": {
    "count": 70001, "position": {"uniform": {"min": [-5, 0, 1], "max": [5, 9, 2], "seed": 7}}, "velocity": )" +
                                       velocity + "}}");
}

// Runs the last task first, as threads may.
constexpr ParallelFor backwards{.run = [](void*, std::size_t count, ParallelFor::Body body, void* task) {
  while (count-- > 0) body(task, count);
}};

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

TEST_CASE_TEMPLATE("values read from files are given back while particles are put to their start", Value, Vec3, Vec3f) {
  SceneFile file = drawn("[1, 2, 3]");
  Chunked<Value> points;
  for (std::size_t i = 0; i < particles; ++i) {
    auto& point = points.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(i) + 0.25F * static_cast<float>(axis);
  }
  REQUIRE(points.size() == particles);
  REQUIRE(points.held() == particles);
  file.particles.position = points;
  file.particles.velocity = points;
  for (const ParallelFor& parallel : {ParallelFor{}, backwards}) {
    SceneFile given = file;
    StateMemory<float> memory(Layout::soa, particles), other(Layout::soa, particles);
    State<float> state = memory.view();
    State<float> kept = other.view();
    place_at_start(file, kept);
    move_to_start(given, state, parallel);
    for (std::size_t i = 0; i < particles; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        REQUIRE(state.x[axis][i] == kept.x[axis][i]);
        REQUIRE(state.v[axis][i] == kept.v[axis][i]);
      }
    }
    CHECK(std::get<Chunked<Value>>(given.particles.position).held() == 0);
    CHECK(std::get<Chunked<Value>>(given.particles.velocity).held() == 0);
  }
  CHECK(std::get<Chunked<Value>>(file.particles.position) == points);
}

TEST_CASE("chunks of a list that lie within a range are given back") {
  constexpr std::size_t each = Chunked<Vec3f>::chunk;
  Chunked<Vec3f> points(3 * each + 5);
  points[2 * each] = {1, 2, 3};
  points.release(1, 2 * each);
  CHECK(points.held() == 2 * each + 5);
  CHECK(points[2 * each] == Vec3f{1, 2, 3});
  points.release(3 * each, 3 * each + 4);
  CHECK(points.held() == 2 * each + 5);
  points.release(3 * each, 3 * each + 5);
  CHECK(points.held() == 2 * each);
  CHECK(points.size() == 3 * each + 5);
}

TEST_CASE("fresh memory is aligned, zero, and given back") {
  for (const std::size_t count : {1U, 100U, 1'000'000U}) {
    const AlignedArray<float> array = aligned_array<float>(count, fresh_memory);
    CHECK(reinterpret_cast<std::uintptr_t>(array.get()) % 64 == 0);
    CHECK(std::count(array.get(), array.get() + count, 0.0F) == static_cast<std::ptrdiff_t>(count));
  }
}

TEST_CASE("a scene asks for the start if a spring is anchored there") {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Spring{.stiffness = 1.0, .anchor = Vec3{1, 2, 3}});
  CHECK_FALSE(is_start_asked_for(scene));
  scene.add(RadialSpring{.stiffness = 1.0, .anchor = at_start});
  CHECK(is_start_asked_for(scene));
}

TEST_CASE("the first value beyond float32 is named, whatever the threads") {
  SceneFile file = drawn("[0, 0, 0]");
  Chunked<Vec3> velocities(particles);
  velocities[20'000] = {0, 1e39, 0};
  velocities[60'000] = {-1e40, 0, 0};
  file.particles.velocity = velocities;
  StateMemory<float> memory(Layout::soa, particles);
  State<float> state = memory.view();
  constexpr const char* message =
      "drawn.json: particles.velocity is 1e+39 for particle 20000: must be at most 3.4e+38 in float32";
  CHECK_THROWS_WITH_AS(place_at_start(file, state), message, Fault);
  CHECK_THROWS_WITH_AS(place_at_start(file, state, backwards), message, Fault);
  CHECK_THROWS_WITH_AS(move_to_start(file, state, backwards), message, Fault);
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

}  // namespace start_test
