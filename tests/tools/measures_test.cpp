// Energy, state hash and steps: a run's figures of a state.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "scene_io/steps.hpp"
#include "support/close.hpp"
#include "watch/energy.hpp"

namespace measures_test {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::is_close;

// Two particles whose twelve numbers are 1, 2, ... 12.
template <class T>
void fill(State<T>& state) {
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(6 * i + axis + 1);
      state.v[axis][i] = static_cast<T>(6 * i + axis + 4);
    }
  }
}

template <class Memory>
std::uint64_t hash_in() {
  Memory memory(2);
  auto state = memory.view();
  fill(state);
  return state_hash(state);
}

TEST_CASE("the hash is that of docs/scene.md, and the same for every layout") {
  CHECK(hash_text(hash_in<Soa<float>>()) == "7efedf7f47d2eb8b");
  CHECK(hash_text(hash_in<Soa<double>>()) == "bb89e02c7537b058");
  CHECK(hash_in<Aosoa<float, 8>>() == hash_in<Soa<float>>());
  CHECK(hash_in<Aosoa<double, 16>>() == hash_in<Soa<double>>());
  CHECK(hash_text(1) == "0000000000000001");
}

SceneFile two_particles() {
  SceneFile file;
  file.particles.count = 2;
  file.particles.position = Vec3{1, 1, 1};
  file.scene.mass = std::vector<double>{2, 3};
  return file;
}

double energy_of(const SceneFile& file) {
  Soa<double> memory(2);
  auto state = memory.view();
  fill(state);
  return energy(file, state);
}

constexpr double kinetic = 0.5 * 2 * (16 + 25 + 36) + 0.5 * 3 * (100 + 121 + 144);

TEST_CASE("energy is kinetic plus the potential of constant forces and springs") {
  auto file = two_particles();
  CHECK(energy_of(file) == kinetic);
  file.scene.add(Constant{.acceleration = {0, -10, 1}});
  CHECK(energy_of(file) == kinetic + 2 * (10 * 2 - 3) + 3 * (10 * 8 - 9));
  file = two_particles();
  file.scene.add(Spring{.stiffness = PerAxis(2, 4, 6), .damping = 9, .anchor = Vec3{0, 0, 1}});
  CHECK(energy_of(file) == kinetic + (1 + 2 * 4 + 3 * 4) + (49 + 2 * 64 + 3 * 64));
  file = two_particles();
  file.scene.add(Spring{.stiffness = std::vector<double>{2, 4}, .anchor = at_start});
  CHECK(energy_of(file) == kinetic + (0 + 1 + 4) + 2 * (36 + 49 + 64));
  file = two_particles();
  file.scene.add(RadialSpring{.stiffness = 2, .anchor = std::vector<Vec3>{{1, 2, 0}, {7, 8, 9}}, .rest_length = 2.0});
  CHECK(energy_of(file) == kinetic + 1 + 4);
  file = two_particles();
  file.scene.add(Drag{.coefficient = 3.0})
      .add(Sinusoid{.acceleration = {1, 0, 0}})
      .add(Polynomial{.acceleration = {{1, 0, 0}}});
  CHECK(energy_of(file) == kinetic);
}

TEST_CASE("energy holds the springs of networks") {
  auto file = two_particles();
  const double apart = std::sqrt(108.0);
  file.scene.add(Network(Springs{.pairs = {{0, 1}, {1, 0}}, .stiffness = std::vector<double>{2, 6}, .rest_length = 10.0}));
  CHECK(is_close(energy_of(file), kinetic + 4 * (apart - 10) * (apart - 10), 1e-14));
  // "start": both particles start at the same place.
  std::get<Springs>(file.scene.networks[0]).rest_length.reset();
  CHECK(is_close(energy_of(file), kinetic + 4 * 108, 1e-14));
}

TEST_CASE("a grid's energy counts every one of its springs once") {
  // Stretched to twice its length in both directions: a spring of rest length l is stretched by l.
  constexpr std::size_t rows = 4;
  constexpr std::size_t columns = 5;
  SceneFile file;
  file.particles.count = rows * columns;
  file.scene.add(Network(Grid{.rows = rows,
                              .columns = columns,
                              .edge_u = {columns - 1, 0, 0},
                              .edge_v = {0, 0, 2 * (rows - 1)},
                              .structural = 1,
                              .shear = 100,
                              .bend = 10000}));
  Soa<double> memory(file.particles.count);
  auto state = memory.view();
  for (std::size_t i = 0; i < state.count; ++i) {
    state.x[0][i] = 2 * static_cast<double>(i % columns);
    state.x[2][i] = 4 * static_cast<double>(i / columns);
  }
  const double structural = 4 * 4 * 1 + 3 * 5 * 4;
  const double shear = 2 * 3 * 4 * 5;
  const double bend = 4 * 3 * 4 + 2 * 5 * 16;
  CHECK(is_close(energy(file, state), 0.5 * (structural + 100 * shear + 10000 * bend), 1e-12));
}

TEST_CASE("a grid whose edges are not at right angles stores energy in each of its diagonals") {
  // Stretched to twice its length: a spring of rest length l is stretched by l. The diagonals are (1.5, 0, 1) and (-0.5, 0, 1).
  SceneFile file;
  file.particles.count = 4;
  file.scene.add(Network(Grid{.rows = 2, .columns = 2, .edge_u = {1, 0, 0}, .edge_v = {0.5, 0, 1}, .shear = 8}));
  Soa<double> memory(4);
  auto state = memory.view();
  for (std::size_t i = 0; i < 4; ++i) {
    state.x[0][i] = 2 * static_cast<double>(i % 2) + static_cast<double>(i / 2);
    state.x[2][i] = 2 * static_cast<double>(i / 2);
  }
  CHECK(dvdx::test::is_close(energy(file, state), 0.5 * 8 * (3.25 + 1.25), 1e-14));
}

TEST_CASE("energy of many particles is summed without loss") {
  constexpr std::size_t count = 1000001;
  Soa<float> memory(count);
  auto state = memory.view();
  for (std::size_t i = 0; i < count; ++i) state.v[0][i] = i == 0 ? 1e8F : 1.0F;  // 1e16 and 1 J, twice
  SceneFile file;
  file.particles.count = count;
  file.scene.mass = 2.0;
  const double first = static_cast<double>(1e8F) * static_cast<double>(1e8F);
  CHECK(energy(file, state) == first + 1e6);
  state.v[0][7] = std::numeric_limits<float>::quiet_NaN();
  CHECK(std::isnan(energy(file, state)));
}

TEST_CASE("a duration is a whole number of steps within 1e-6") {
  CHECK(steps_in(10, 0.005) == 2000U);
  CHECK(steps_in(60, 0.016666666666666666) == 3600U);
  CHECK(steps_in(1, -0.1) == 10U);
  CHECK(steps_in(0, 0.1) == 0U);
  CHECK_FALSE(steps_in(1, 1e9).has_value());
  CHECK(steps_in(1 + 0.9e-7, 0.1) == 10U);
  CHECK_FALSE(steps_in(1 + 1.1e-7, 0.1).has_value());
  CHECK_FALSE(steps_in(1, 1e-300).has_value());
}

}  // namespace measures_test
