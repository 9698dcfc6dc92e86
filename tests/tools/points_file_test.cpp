// Ranges of rows read from files of points and numbers, as ranks read them.
#include "scene_io/points_file.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "kernel/passes/cloths.hpp"
#include "scene_io/file_text.hpp"
#include "tools/scratch_folder.hpp"

namespace points_file_test {

using namespace dvdx;
using namespace dvdx::tool;

template <class T>
std::string as_bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string npy(const std::string& descr, const std::string& shape) {
  std::string text = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': " + shape + ", }";
  text.resize(118, ' ');
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + text;
}

struct Case {
  std::string name;
  std::string bytes;
};

// The same points in every format; longer than the part of a text that is held at once.
constexpr std::size_t count = 20011;

std::vector<Case> cases() {
  std::string csv = "step,y,x,z\n# a remark\n", ascii, binary;
  std::vector<float> singles;
  std::vector<double> doubles;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 3> x{};
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis] = static_cast<float>(test::scatter(i, axis));
    const auto text = [](float value) { return std::to_string(static_cast<double>(value) * 1024) + "e0"; };
    csv += "0," + text(x[1]) + "," + text(x[0]) + " ,\t" + text(x[2]) + (i % 7 == 0 ? "\r\n\n" : "\n");
    ascii += text(x[0]) + "  " + text(x[1]) + " 7 " + text(x[2]) + "\n";
    binary += as_bytes<float>({x[0], x[1]}) + "\xFF" + as_bytes<double>({x[2]});
    for (const float value : x) {
      singles.push_back(value);
      doubles.push_back(value);
    }
  }
  const auto ply = [](const std::string& form, const std::string& type_of_z) {
    return "ply\nformat " + form + " 1.0\nelement vertex " + std::to_string(count) +
           "\nproperty float x\nproperty float y\nproperty uchar red\nproperty " + type_of_z + " z\nend_header\n";
  };
  const std::string shape = "(" + std::to_string(count) + ", 3)";
  return {{"a.csv", csv},
          {"ascii.ply", ply("ascii", "float") + ascii},
          {"binary.ply", ply("binary_little_endian", "double") + binary},
          {"single.npy", npy("<f4", shape) + as_bytes(singles)},
          {"double.npy", npy("<f8", shape) + as_bytes(doubles)}};
}

const std::vector<Run> runs = {{0, 0}, {0, 1}, {0, count}, {1, 7000}, {7001, 7001}, {count - 1, 1}, {count, 0}, {count - 3, 9}};

TEST_CASE("points: a run of rows has the values of the whole file there, and all rows are counted") {
  const test::ScratchFolder folder("runs");
  for (const Case& one : cases()) {
    const std::string& name = one.name;
    CAPTURE(name);
    folder.write(name, one.bytes);
    const auto all = read_points(folder / name);
    REQUIRE(all.values.size() == count);
    CHECK(all.all == count);
    CHECK(all.values[12][1] != all.values[13][1]);
    for (const Run& run : runs) {
      CAPTURE(run.first);
      const auto kept = read_points(folder / name, run);
      CHECK(kept.all == count);
      const std::size_t end = std::min(count, run.first + run.count);
      const auto from = all.values.begin() + static_cast<std::ptrdiff_t>(run.first);
      CHECK((kept.values == std::vector<Vec3>(from, all.values.begin() + static_cast<std::ptrdiff_t>(end))));
    }
  }
}

TEST_CASE("points: a run of numbers has the values of the file, and numbers outside it are not checked") {
  const test::ScratchFolder folder("number-runs");
  std::vector<double> numbers;
  std::string csv = "mass\n";
  for (std::size_t i = 0; i < count; ++i) {
    numbers.push_back(static_cast<double>(i));
    csv += i == 5 ? "none\n" : std::to_string(i) + "\n";
  }
  numbers[5] = std::numeric_limits<double>::quiet_NaN();
  folder.write("a.csv", csv);
  folder.write("a.npy", npy("<f8", "(" + std::to_string(count) + ",)") + as_bytes(numbers));
  for (const char* name : {"a.csv", "a.npy"}) {
    CAPTURE(std::string(name));
    const auto kept = read_numbers(folder / name, {.first = 6, .count = 12000});
    CHECK(kept.all == count);
    REQUIRE(kept.values.size() == 12000);
    for (std::size_t i = 0; i < kept.values.size(); ++i) CHECK(kept.values[i] == static_cast<double>(6 + i));
    CHECK_THROWS_AS((void)read_numbers(folder / name, {.first = 0, .count = 6}), FileFault);
    CHECK_THROWS_AS((void)read_numbers(folder / name), FileFault);
  }
}

TEST_CASE("points: a few rows are read from a binary file of any length") {
  const test::ScratchFolder folder("sparse");
  constexpr std::size_t rows = 120000000;
  const std::string header = npy("<f8", "(" + std::to_string(rows) + ", 3)");
  folder.write("a.npy", header);
  std::filesystem::resize_file(folder / "a.npy", header.size() + rows * 24);  // zeros without disk space
  const auto kept = read_points(folder / "a.npy", {.first = rows - 2, .count = 2});
  CHECK(kept.all == rows);
  CHECK((kept.values == std::vector<Vec3>(2, Vec3{})));
  std::filesystem::resize_file(folder / "a.npy", header.size() + rows * 24 - 1);
  CHECK_THROWS_AS((void)read_points(folder / "a.npy", {.first = 0, .count = 1}), FileFault);
}

TEST_CASE("points: float32 values of a binary file are held as float32, all others as float64") {
  const test::ScratchFolder folder("as-held");
  const std::array<float, 6> numbers{0.1F, -2.5e-30F, 3, 4, 5e30F, -0.7F};
  const std::array<double, 6> doubles{0.1, -2.5e-30, 3, 4, 5e30, -0.7};
  const std::string rows(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
  folder.write("a.npy", npy("<f4", "(2, 3)") + rows);
  folder.write("b.npy", npy("<f8", "(2, 3)") + std::string(reinterpret_cast<const char*>(doubles.data()), sizeof doubles));
  const auto ply = [](const char* z) {
    return std::string(
               "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty ") +
           z + " z\nend_header\n";
  };
  folder.write("a.ply", ply("float32") + rows);
  folder.write("b.ply", ply("double") + rows);
  for (const char* name : {"a.npy", "a.ply"}) {
    const Points points = read_points_as_held(folder / name);
    REQUIRE(std::holds_alternative<KeptOf<Chunked<Vec3f>>>(points));
    const auto& held = std::get<KeptOf<Chunked<Vec3f>>>(points).values;
    CHECK(held[0] == Vec3f{numbers[0], numbers[1], numbers[2]});
    CHECK(value_of(Vectors(held), 0) == Vec3{double{numbers[0]}, double{numbers[1]}, double{numbers[2]}});
    CHECK(read_points(folder / name).values[0] == value_of(Vectors(held), 0));
  }
  for (const char* name : {"b.npy", "b.ply"}) {
    CHECK(std::holds_alternative<KeptOf<Chunked<Vec3>>>(read_points_as_held(folder / name)));
  }
  CHECK(read_points(folder / "b.npy").values[1] == Vec3{4, 5e30, -0.7});
}

TEST_CASE("points: a line may be longer than the part of a file that is held at a time") {
  const test::ScratchFolder folder("long-line");
  const std::string blanks(std::size_t{1} << 20U, ' ');
  folder.write("a.csv", "1,2," + blanks + "3\n" + blanks + "4,5,6");
  CHECK((read_points(folder / "a.csv").values == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}}));
  folder.write("empty.csv", "");
  CHECK(read_points(folder / "empty.csv").all == 0);
}

}  // namespace points_file_test
