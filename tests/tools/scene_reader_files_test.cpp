// Texts that are not scenes, and files that a scene refers to.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/points_file.hpp"
#include "scene_io/scene_reader.hpp"
#include "tools/scene_texts.hpp"
#include "tools/scratch_folder.hpp"

namespace scene_texts::files_test {

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
  // The parser's own words follow. Only the library's words are compared.
  CHECK(message_of("{\"step\": NaN}").starts_with("hail.json: line 1, column 10, in step: not JSON: "));
  CHECK(message_of("{\"step\": 1,}").starts_with("hail.json: line 1, column 12, in step: not JSON: "));
  CHECK(message_of("{} {}").starts_with("hail.json: line 1, column 4: not JSON: "));
  CHECK(message_of("{\"name\": \"\xC3(\"}").starts_with("hail.json: line 1, column 12, in name: not JSON: "));
  CHECK(message_of(std::string(100000, '[')).ends_with("is nested more than 32 deep: no scene is"));
}

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

TEST_CASE("a points file that holds too much is refused") {
  CHECK_THROWS_AS((void)parse_points("1,2,3\n4,5,6,7\n", PointsFormat::csv), FileFault);
  const std::string header(npy_header, sizeof npy_header - 1);
  CHECK(parse_points(header + std::string(72, '\0'), PointsFormat::npy).size() == 3);
  CHECK_THROWS_AS((void)parse_points(header + std::string(80, '\0'), PointsFormat::npy), FileFault);
}

TEST_CASE("an unreadable scene file is an input error, not a fault of the scene") {
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

}  // namespace scene_texts::files_test
