// Views over the caller's memory: where each element lies, and what a view may touch.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/layouts/aos.hpp"
#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/layouts/soa.hpp"

namespace column_test {

using namespace dvdx;

struct Small {
  float position[3];
  float velocity[3];
};
struct Mixed {  // of a game: other fields before, between and behind
  std::uint8_t kind;
  float position[3];
  double age;
  float velocity[3];
  std::uint16_t flags;
};
struct Wide {
  double mass;
  double velocity[3];
  float colour[4];
  double position[3];
};

template <class Struct>
auto view_of(std::vector<Struct>& particles) {
  return aos(&particles[0].position[0], &particles[0].velocity[0], sizeof(Struct), particles.size());
}

TEST_CASE("a view of six arrays reads and writes them and no element more") {
  std::vector<std::vector<float>> arrays(6, std::vector<float>(7));
  const State<float> state =
      soa(arrays[0].data(), arrays[1].data(), arrays[2].data(), arrays[3].data(), arrays[4].data(), arrays[5].data(), 7);
  CHECK(state.count == 7);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(state.x[axis].is_contiguous());
    CHECK(state.x[axis].capacity == 7);
    CHECK(state.x[axis].at(5) == &arrays[axis][5]);
    CHECK(state.v[axis].at(6) == &arrays[3 + axis][6]);
  }
}

TEST_CASE_TEMPLATE("a view of structs finds each field", Struct, Small, Mixed, Wide) {
  std::vector<Struct> particles(9);
  const auto state = view_of(particles);
  CHECK(state.count == 9);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(state.x[axis].at(i) == &particles[i].position[axis]);
      CHECK(state.v[axis].at(i) == &particles[i].velocity[axis]);
    }
  }
  CHECK(state.x[0].run == 1);
  CHECK(state.x[0].capacity == 9);
}

struct Vector {
  float x, y, z;
};
struct Typed {  // vectors as games, glm and the standard library have them
  std::uint8_t kind;
  Vector position;
  double age;
  std::array<float, 3> velocity;
};

TEST_CASE("a view of structs takes the vectors of three that a struct names") {
  std::vector<Typed> typed(5);
  const State<float> state = aos(typed, &Typed::position, &Typed::velocity);
  CHECK(state.count == 5);
  CHECK(state.x[0].at(0) == &typed[0].position.x);
  CHECK(state.x[2].at(4) == &typed[4].position.z);
  CHECK(state.v[1].at(3) == &typed[3].velocity[1]);
  std::vector<Wide> wide(4);
  const State<double> doubles = aos(wide, &Wide::position, &Wide::velocity);
  CHECK(doubles.x[1].at(2) == &wide[2].position[1]);
  CHECK(doubles.v[0].at(3) == &wide[3].velocity[0]);
  const State<double> some = aos(std::span(wide).subspan(1, 2), &Wide::position, &Wide::velocity);
  CHECK(some.count == 2);
  CHECK(some.x[0].at(0) == &wide[1].position[0]);
  wide.clear();
  CHECK(aos(wide, &Wide::position, &Wide::velocity).count == 0);
}

TEST_CASE("a column of an array ends with it") {
  const std::vector<double> values = {1, 2, 3, 4};
  const Column<const double> all = column(values.data(), values.size());
  CHECK(all.is_contiguous());
  CHECK(all.capacity == 4);
  CHECK(all[3] == 4);
}

TEST_CASE("a field may be const, and a stride negative") {
  const std::vector<double> values = {1, 2, 3, 4};
  const Column<const double> forwards = field(values.data(), sizeof(double), 4);
  CHECK(forwards[2] == 3);
  const Column<const double> backwards{&values[3], -static_cast<std::ptrdiff_t>(sizeof(double)), 1, 4};
  CHECK(backwards[3] == 1);
}

TEST_CASE_TEMPLATE("tiles hold the six columns side by side", T, float, double) {
  std::vector<T> memory(3 * 6 * 8);
  const State<T> state = aosoa<8>(memory.data(), 17);
  CHECK(state.x[0].capacity == 24);
  CHECK(state.x[0].at(0) == &memory[0]);
  CHECK(state.v[2].at(7) == &memory[5 * 8 + 7]);
  CHECK(state.x[1].at(16) == &memory[2 * 48 + 8]);
}

TEST_CASE_TEMPLATE("our own arrays are aligned to 64 bytes, padded to whole lines and zero", T, float, double) {
  for (const std::size_t count : {0U, 1U, 7U, 8U, 9U, 16U, 17U, 1000U}) {
    Soa<T> memory(count);
    const State<T> state = memory.view();
    CHECK(state.count == count);
    for (const auto* columns : {&state.x, &state.v}) {
      for (const Column<T>& column : *columns) {
        CHECK(reinterpret_cast<std::uintptr_t>(column.base) % 64 == 0);
        CHECK(column.capacity % padding<T> == 0);
        CHECK(column.capacity >= count);
        CHECK(column.capacity < count + padding<T>);
        for (std::size_t i = 0; i < column.capacity; ++i) CHECK(column[i] == 0);
      }
    }
  }
  CHECK(padding<float> == 16);
  CHECK(padding<double> == 8);
}

TEST_CASE_TEMPLATE("the columns of our own arrays neither overlap nor collide in the cache", T, float, double) {
  for (const std::size_t count : {1U, 100U, 1024U, 4096U, 65536U}) {
    Soa<T> memory(count);
    const State<T> state = memory.view();
    const T* columns[] = {state.x[0].base, state.x[1].base, state.x[2].base, state.v[0].base, state.v[1].base, state.v[2].base};
    for (int a = 0; a < 6; ++a) {
      for (int b = a + 1; b < 6; ++b) {
        CHECK(columns[b] - columns[a] >= static_cast<std::ptrdiff_t>(padded<T>(count)));
        CHECK((reinterpret_cast<std::uintptr_t>(columns[b]) - reinterpret_cast<std::uintptr_t>(columns[a])) % 4096 >= 64);
      }
    }
  }
}

TEST_CASE_TEMPLATE("our own tiles are aligned to 64 bytes and whole", T, float, double) {
  Aosoa<T, 8> narrow(11);
  Aosoa<T, 16> wide(33);
  CHECK(reinterpret_cast<std::uintptr_t>(narrow.view().x[0].base) % 64 == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(wide.view().x[0].base) % 64 == 0);
  CHECK(narrow.size() == 11);
  CHECK(narrow.view().x[0].capacity == 16);
  CHECK(wide.view().v[2].capacity == 48);
  wide.view().v[2][47] = 1;  // the last element of the memory
}

}  // namespace column_test
