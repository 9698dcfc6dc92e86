#include "output/writer.hpp"

#include <doctest/doctest.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <pugixml.hpp>
#include <type_traits>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "files/part_file.hpp"
#include "output/pieces.hpp"
#include "output/vtp_document.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/points_file.hpp"
#include "tools/scratch_folder.hpp"

namespace writer_test {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::ScratchFolder;

constexpr std::size_t particles = 3;

// Numbers without a short form: all different, some tiny, some with endless decimals.
template <class T>
T number(std::uint64_t state, std::size_t particle, std::size_t field) {
  constexpr std::array<double, 6> hard{1.0 / 3, -0.1, 1e-30, 123456789.123456789, -0.0, 2.5e20};
  return static_cast<T>(hard[(field + particle) % 6] * static_cast<double>(state + 1));
}

template <class T>
class States {
 public:
  // Writes `count` states, 5 steps and a fraction of a second apart.
  void write(const std::filesystem::path& target, std::uint64_t count, const Topology& topology = no_topology) {
    const auto writer = make_writer<T>({.target = target, .particles = particles, .states = count, .topology = &topology});
    for (std::uint64_t i = 0; i < count; ++i) writer->write(moment(i), at(i));
    writer->finish();
  }

  static Moment moment(std::uint64_t index) { return {.step = 5 * index, .time = 0.1 * static_cast<double>(index)}; }

  State<T> at(std::uint64_t index) {
    auto state = memory_.view();
    for (std::size_t i = 0; i < particles; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state.x[axis][i] = number<T>(index, i, axis);
        state.v[axis][i] = number<T>(index, i, 3 + axis);
      }
    }
    return state;
  }

 private:
  Soa<T> memory_{particles};
};

template <class T>
bool same_bits(T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

template <class T>
T parsed(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  REQUIRE(error == std::errc{});
  REQUIRE(end == text.data() + text.size());
  return value;
}

std::vector<std::string> split(const std::string& text, char by) {
  std::vector<std::string> parts;
  std::size_t start = 0;
  for (std::size_t end = text.find(by); end != std::string::npos; start = end + 1, end = text.find(by, start)) {
    parts.push_back(text.substr(start, end - start));
  }
  if (start < text.size()) parts.push_back(text.substr(start));
  return parts;
}

template <class T>
T value_at(const std::string& bytes, std::size_t index) {
  T value;
  REQUIRE((index + 1) * sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + index * sizeof value, sizeof value);
  return value;
}

TEST_CASE_TEMPLATE("a .csv reads back to the same bits", T, float, double) {
  const ScratchFolder folder("csv");
  States<T>().write(folder / "a.csv", 2);
  const auto rows = split(folder.read("a.csv"), '\n');
  REQUIRE(rows.size() == 1 + 2 * particles);
  CHECK(rows[0] == "step,time,particle,x,y,z,vx,vy,vz");
  for (std::size_t row = 0; row < 2 * particles; ++row) {
    const auto cells = split(rows[1 + row], ',');
    REQUIRE(cells.size() == 9);
    const std::uint64_t state = row / particles;
    CHECK(parsed<std::uint64_t>(cells[0]) == 5 * state);
    CHECK(parsed<double>(cells[1]) == States<T>::moment(state).time);
    CHECK(parsed<std::uint64_t>(cells[2]) == row % particles);
    for (std::size_t field = 0; field < 6; ++field) {
      CHECK(same_bits(parsed<T>(cells[3 + field]), number<T>(state, row % particles, field)));
    }
  }
  CHECK(folder.entries() == 1);
}

std::string member(zip_t* archive, const char* name) {
  zip_stat_t stat;
  REQUIRE(zip_stat(archive, name, 0, &stat) == 0);
  std::string bytes(stat.size, '\0');
  zip_file_t* file = zip_fopen(archive, name, 0);
  REQUIRE(file != nullptr);
  CHECK(zip_fread(file, bytes.data(), bytes.size()) == static_cast<zip_int64_t>(bytes.size()));
  CHECK(zip_fclose(file) == 0);  // the checksum is right
  return bytes;
}

// The data after a header, which must have this content.
std::string array_data(const std::string& bytes, const std::string& type, const std::string& shape) {
  CHECK(bytes.starts_with("\x93NUMPY\x01"));
  const auto start = 10 + std::size_t{value_at<std::uint16_t>(bytes, 4)};
  CHECK(start % 64 == 0);
  CHECK(bytes.find("{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }") == 10);
  CHECK(bytes[start - 1] == '\n');
  return bytes.substr(start);
}

TEST_CASE_TEMPLATE("an .npz holds steps, times, positions and velocities", T, float, double) {
  const ScratchFolder folder("npz");
  States<T>().write(folder / "a.npz", 4);
  CHECK(folder.entries() == 1);
  zip_t* archive = zip_open((folder / "a.npz").c_str(), ZIP_RDONLY, nullptr);
  REQUIRE(archive != nullptr);
  CHECK(zip_get_num_entries(archive, 0) == 4);
  const std::string type = sizeof(T) == 4 ? "<f4" : "<f8";
  const auto steps = array_data(member(archive, "steps.npy"), "<i8", "4,");
  const auto times = array_data(member(archive, "times.npy"), "<f8", "4,");
  const auto positions = array_data(member(archive, "positions.npy"), type, "4, 3, 3");
  const auto velocities = array_data(member(archive, "velocities.npy"), type, "4, 3, 3");
  for (std::size_t state = 0; state < 4; ++state) {
    CHECK(value_at<std::int64_t>(steps, state) == static_cast<std::int64_t>(5 * state));
    CHECK(value_at<double>(times, state) == States<T>::moment(state).time);
    for (std::size_t i = 0; i < particles; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t index = (state * particles + i) * 3 + axis;
        CHECK(same_bits(value_at<T>(positions, index), number<T>(state, i, axis)));
        CHECK(same_bits(value_at<T>(velocities, index), number<T>(state, i, 3 + axis)));
      }
    }
  }
  zip_discard(archive);
}

TEST_CASE("the same states give the same .npz") {
  const ScratchFolder folder("npz-twice");
  States<float>().write(folder / "a.npz", 2);
  States<float>().write(folder / "b.npz", 2);
  CHECK(folder.read("a.npz") == folder.read("b.npz"));
}

TEST_CASE_TEMPLATE("each state is a .ply that the scene reader reads", T, float, double) {
  const ScratchFolder folder("ply");
  States<T>().write(folder / "a.ply", 2);
  CHECK(folder.entries() == 2);
  for (std::uint64_t state = 0; state < 2; ++state) {
    const std::string name = "a-00000" + std::to_string(state) + ".ply";
    const auto points = read_points(folder / name).values;
    REQUIRE(points.size() == particles);
    for (std::size_t i = 0; i < particles; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) CHECK(points[i][axis] == static_cast<double>(number<T>(state, i, axis)));
    }
    const auto bytes = folder.read(name);
    CHECK(bytes.find("comment step " + std::to_string(5 * state) + "\n") != std::string::npos);
    const auto data = bytes.substr(bytes.find("end_header\n") + 11);
    CHECK(data.size() == 6 * particles * sizeof(T));
    CHECK(same_bits(value_at<T>(data, 6 + 5), number<T>(state, 1, 5)));
  }
}

std::string from_base64(const std::string& text) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  REQUIRE(text.size() % 4 == 0);
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); i += 4) {
    std::uint32_t word = 0;
    std::size_t held = 3;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto digit = digits.find(text[i + k]);
      if (text[i + k] == '=') --held;
      word = (word << 6U) | (digit == std::string_view::npos ? 0U : static_cast<std::uint32_t>(digit));
    }
    for (std::size_t k = 0; k < held; ++k) bytes += static_cast<char>((word >> (16 - 8 * k)) & 0xFFU);
  }
  return bytes;
}

// The data of an array, which begins with its size.
std::string inline_data(const pugi::xml_node& array, std::size_t size) {
  const auto bytes = from_base64(array.text().get());
  CHECK(value_at<std::uint64_t>(bytes, 0) == size);
  REQUIRE(bytes.size() == sizeof(std::uint64_t) + size);
  return bytes.substr(sizeof(std::uint64_t));
}

TEST_CASE_TEMPLATE("each state is a .vtp, and a .pvd gives the states' times", T, float, double) {
  const ScratchFolder folder("vtp");
  States<T>().write(folder / "a.vtp", 3);
  CHECK(folder.entries() == 4);
  pugi::xml_document series;
  REQUIRE(series.load_file((folder / "a.pvd").c_str()));
  std::uint64_t state = 0;
  for (const auto& entry : series.child("VTKFile").child("Collection").children("DataSet")) {
    CHECK(entry.attribute("timestep").as_double() == States<T>::moment(state).time);
    pugi::xml_document document;
    REQUIRE(document.load_file((folder / entry.attribute("file").value()).c_str()));
    const auto piece = document.child("VTKFile").child("PolyData").child("Piece");
    CHECK(piece.attribute("NumberOfPoints").as_uint() == particles);
    const auto points = piece.child("Points").child("DataArray");
    CHECK(std::string_view(points.attribute("type").value()) == (sizeof(T) == 4 ? "Float32" : "Float64"));
    const auto positions = inline_data(points, 3 * particles * sizeof(T));
    const auto velocities = inline_data(piece.child("PointData").child("DataArray"), 3 * particles * sizeof(T));
    for (std::size_t i = 0; i < 3 * particles; ++i) {
      CHECK(same_bits(value_at<T>(positions, i), number<T>(state, i / 3, i % 3)));
      CHECK(same_bits(value_at<T>(velocities, i), number<T>(state, i / 3, 3 + i % 3)));
    }
    const auto verts = piece.child("Verts").first_child();
    CHECK(value_at<std::int64_t>(inline_data(verts, particles * 8), 2) == 2);
    CHECK(value_at<std::int64_t>(inline_data(verts.next_sibling(), particles * 8), 2) == 3);
    ++state;
  }
  CHECK(state == 3);
}

// A triangle of the three particles with one of its sides again, and a pair that leaves out the second particle.
const Topology triangle{.lines = {{2, 1}}, .faces = {{0, 1, 2}}};
const Topology pair{.lines = {{0, 2}}, .faces = {}};

TEST_CASE_TEMPLATE("a .ply holds faces and edges after its vertices", T, float, double) {
  const ScratchFolder folder("ply-joints");
  States<T>().write(folder / "a.ply", 2, triangle);
  States<T>().write(folder / "plain.ply", 2);
  CHECK(read_points(folder / "a-000001.ply").values == read_points(folder / "plain-000001.ply").values);
  const auto bytes = folder.read("a-000001.ply");
  const std::string joints =
      "element face 1\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\n"
      "property int vertex2\nend_header\n";
  const auto at = bytes.find(joints);
  REQUIRE(at != std::string::npos);
  const auto data = bytes.substr(at + joints.size() + 6 * particles * sizeof(T));
  REQUIRE(data.size() == 1 + 5 * sizeof(std::int32_t));
  CHECK(data[0] == 3);
  for (std::size_t i = 0; i < 5; ++i) {
    constexpr std::array<std::int32_t, 5> expected{0, 1, 2, 2, 1};
    CHECK(value_at<std::int32_t>(data.substr(1), i) == expected[i]);
  }
}

TEST_CASE("a .ply with a face of more than 255 corners counts corners in four bytes") {
  const ScratchFolder folder("ply-big");
  Topology big;
  big.faces = {{0, 1, 2}, std::vector<std::uint32_t>(256, 1)};
  States<float>().write(folder / "a.ply", 1, big);
  const auto bytes = folder.read("a-000000.ply");
  const auto at = bytes.find("property list int int vertex_indices\nend_header\n");
  REQUIRE(at != std::string::npos);
  const auto data = bytes.substr(bytes.find("end_header\n") + 11 + 6 * particles * sizeof(float));
  REQUIRE(data.size() == (1 + 3 + 1 + 256) * sizeof(std::int32_t));
  CHECK(value_at<std::int32_t>(data, 4) == 256);
}

std::vector<std::int64_t> integers(const pugi::xml_node& array, std::size_t count) {
  const auto bytes = inline_data(array, count * sizeof(std::int64_t));
  std::vector<std::int64_t> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(value_at<std::int64_t>(bytes, i));
  return values;
}

TEST_CASE("a .vtp holds lines and polygons, and a vertex cell for each particle that is in neither") {
  using Ids = std::vector<std::int64_t>;
  const ScratchFolder folder("vtp-joints");
  const auto piece_of = [&](pugi::xml_document& document, const char* name) {
    REQUIRE(document.load_file((folder / name).c_str()));
    return document.child("VTKFile").child("PolyData").child("Piece");
  };
  States<float>().write(folder / "a.vtp", 1, triangle);
  pugi::xml_document joined;
  const auto all = piece_of(joined, "a-000000.vtp");
  CHECK(all.attribute("NumberOfLines").as_uint() == 1);
  CHECK(all.attribute("NumberOfPolys").as_uint() == 1);
  CHECK_FALSE(all.attribute("NumberOfVerts"));
  CHECK_FALSE(all.child("Verts"));
  CHECK(integers(all.child("Lines").first_child(), 2) == Ids{2, 1});
  CHECK(integers(all.child("Lines").last_child(), 1) == Ids{2});
  CHECK(integers(all.child("Polys").first_child(), 3) == Ids{0, 1, 2});
  CHECK(integers(all.child("Polys").last_child(), 1) == Ids{3});

  States<float>().write(folder / "b.vtp", 1, pair);
  pugi::xml_document partly;
  const auto some = piece_of(partly, "b-000000.vtp");
  CHECK(some.attribute("NumberOfVerts").as_uint() == 1);
  CHECK_FALSE(some.attribute("NumberOfPolys"));
  CHECK(integers(some.child("Verts").first_child(), 1) == Ids{1});
  CHECK(integers(some.child("Verts").last_child(), 1) == Ids{1});
  CHECK(integers(some.child("Lines").first_child(), 2) == Ids{0, 2});
}

TEST_CASE("a .pvtp in pieces: each piece has its own particles and cells, and marks particles of other pieces") {
  using Ids = std::vector<std::int64_t>;
  constexpr std::size_t count = 7;
  const ScratchFolder folder("pvtp");
  folder.write("a-000000.pvtp", "of an older run");
  folder.write("a-000000-0001.vtp", "of more pieces");
  folder.write("a-000000-0002.vtp", "of more pieces");
  const Topology quads{.lines = {{5, 0}}, .faces = {{0, 1, 4, 3}, {1, 2, 5, 4}}};  // 6 is unused
  Soa<double> memory(count);
  const auto state = memory.view();
  for (std::size_t i = 0; i < count; ++i) {
    state.x[0][i] = static_cast<double>(i);
    state.v[2][i] = static_cast<double>(10 * i);
  }
  const auto writer = make_writer<double>({.target = folder / "a.pvtp", .particles = count, .states = 1});
  writer->write({.step = 0, .time = 0}, state);
  writer->finish();
  CHECK(folder.entries() == 4);  // one process: one piece, two index files and their times

  // Each of two ranks writes its own particles and those that its cells use.
  const std::vector<std::uint32_t> owner{0, 0, 1, 0, 0, 1, 1};
  int number = 0;
  for (const RankPiece& piece : pieces_of(quads, owner, 2)) {
    Soa<double> own(piece.particles.size());
    auto of_piece = own.view();
    for (std::size_t k = 0; k < piece.particles.size(); ++k) {
      of_piece.x[0][k] = state.x[0][piece.particles[k]];
      of_piece.v[2][k] = state.v[2][piece.particles[k]];
    }
    PartFile file(piece_of(folder / "a.pvtp", 0, number++));
    const Output output{.target = folder / "a.pvtp", .topology = &quads, .owner = owner, .piece = &piece};
    write_poly_data<double>(file, output, {.step = 0, .time = 0}, of_piece);
    file.commit();
  }

  const auto expect = [&](const char* name, const Ids& held, const std::string& ghosts, const char* cells, const Ids& corners) {
    CAPTURE(name);
    pugi::xml_document document;
    REQUIRE(document.load_file((folder / name).c_str()));
    const auto piece = document.child("VTKFile").child("PolyData").child("Piece");
    CHECK(piece.attribute("NumberOfPoints").as_uint() == held.size());
    const auto positions = inline_data(piece.child("Points").first_child(), 3 * held.size() * sizeof(double));
    const auto velocities = inline_data(piece.child("PointData").first_child(), 3 * held.size() * sizeof(double));
    for (std::size_t k = 0; k < held.size(); ++k) {
      CHECK(value_at<double>(positions, 3 * k) == static_cast<double>(held[k]));
      CHECK(value_at<double>(velocities, 3 * k + 2) == static_cast<double>(10 * held[k]));
    }
    CHECK(std::string_view(piece.child("PointData").last_child().attribute("Name").value()) == "vtkGhostType");
    CHECK(inline_data(piece.child("PointData").last_child(), held.size()) == ghosts);
    CHECK(integers(piece.child(cells).first_child(), corners.size()) == corners);
    return piece.child("Verts") ? integers(piece.child("Verts").first_child(), 1) : Ids();
  };
  using namespace std::string_literals;
  CHECK(expect("a-000000-0000.vtp", {0, 1, 3, 4, 2, 5}, "\0\0\0\0\1\1"s, "Polys", {0, 1, 3, 2, 1, 4, 5, 3}).empty());
  CHECK(expect("a-000000-0001.vtp", {2, 5, 6, 0}, "\0\0\0\1"s, "Lines", {1, 3}) == Ids{2});
}

// A sheet of two rows and three columns, in the x-y plane, with one edge sliding away.
class Sheet {
 public:
  static constexpr std::size_t count = 6;
  static constexpr std::uint64_t states = 2;
  const Topology topology{.lines = {}, .faces = {{0, 1, 4, 3}, {1, 2, 5, 4}}};

  template <class T>
  void write(const std::filesystem::path& target) const {
    Soa<T> memory(count);
    const auto writer = make_writer<T>({.target = target, .particles = count, .states = states, .topology = &topology});
    for (std::uint64_t k = 0; k < states; ++k) {
      auto state = memory.view();
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = static_cast<T>(coordinate(k, i, axis));
      }
      writer->write({.step = k, .time = 0}, state);
    }
    writer->finish();
  }

  static double coordinate(std::uint64_t state, std::size_t particle, std::size_t axis) {
    const auto column = static_cast<double>(particle % 3);
    if (axis == 0) return column;
    if (axis == 1) return particle < 3 ? 0.0 : 0.5;
    return 0.1 * static_cast<double>(state) * column;
  }
};

TEST_CASE("a .vtp of several faces lists where each face ends") {
  using Ids = std::vector<std::int64_t>;
  const ScratchFolder folder("vtp-faces");
  Sheet().write<float>(folder / "sheet.vtp");
  pugi::xml_document document;
  REQUIRE(document.load_file((folder / "sheet-000000.vtp").c_str()));
  const auto faces = document.child("VTKFile").child("PolyData").child("Piece").child("Polys");
  CHECK(integers(faces.first_child(), 8) == Ids{0, 1, 4, 3, 1, 2, 5, 4});
  CHECK(integers(faces.last_child(), 2) == Ids{4, 8});
}

TEST_CASE_TEMPLATE("a .pc2 of a grid, byte by byte, in float32 whatever the run's precision", T, float, double) {
  const ScratchFolder folder("pc2");
  Sheet().write<T>(folder / "a.pc2");
  CHECK(folder.entries() == 2);
  const auto bytes = folder.read("a.pc2");
  REQUIRE(bytes.size() == 32 + Sheet::states * Sheet::count * 12);
  CHECK(bytes.substr(0, 12) == std::string("POINTCACHE2\0", 12));
  CHECK(bytes.substr(12, 8) == std::string("\1\0\0\0\6\0\0\0", 8));                // version, points
  CHECK(bytes.substr(20, 12) == std::string("\0\0\0\0\0\0\x80\x3F\2\0\0\0", 12));  // first frame, rate 1, samples
  for (std::size_t i = 0; i < Sheet::states * Sheet::count * 3; ++i) {
    const auto expected = Sheet::coordinate(i / 18, i / 3 % 6, i % 3);
    CHECK(same_bits(value_at<float>(bytes.substr(32), i), static_cast<float>(expected)));
  }
}

// The rest of the lines of a .obj that start with `element` and a space.
std::vector<std::string> elements(const std::string& obj, char element) {
  std::vector<std::string> found;
  for (const auto& line : split(obj, '\n')) {
    if (line.starts_with(std::string{element, ' '})) found.push_back(line.substr(2));
  }
  return found;
}

TEST_CASE_TEMPLATE("the .obj beside a .pc2 is its first state, with indices from 1", T, float, double) {
  using Lines = std::vector<std::string>;
  const ScratchFolder folder("pc2-obj");
  Sheet().write<T>(folder / "a.pc2");
  const auto obj = folder.read("a.obj");
  CHECK(elements(obj, 'v') == Lines{"0 0 0", "1 0 0", "2 0 0", "0 0.5 0", "1 0.5 0", "2 0.5 0"});
  CHECK(elements(obj, 'f') == Lines{"1 2 5 4", "2 3 6 5"});
  CHECK(elements(obj, 'l').empty());

  States<T>().write(folder / "b.pc2", 2);
  const auto vertices = elements(folder.read("b.obj"), 'v');
  REQUIRE(vertices.size() == particles);
  for (std::size_t i = 0; i < 3 * particles; ++i) {
    CHECK(same_bits(parsed<T>(split(vertices[i / 3], ' ')[i % 3]), number<T>(0, i / 3, i % 3)));
  }
  CHECK(elements(folder.read("b.obj"), 'l').empty());

  States<T>().write(folder / "c.pc2", 2, triangle);
  CHECK(elements(folder.read("c.obj"), 'f') == Lines{"1 2 3"});
  CHECK(elements(folder.read("c.obj"), 'l') == Lines{"3 2"});
  // A particle without a joint gets a line to itself, because Blender would drop it.
  States<T>().write(folder / "d.pc2", 2, pair);
  CHECK(elements(folder.read("d.obj"), 'l') == Lines{"1 3", "2 2"});
}

TEST_CASE("an .obj is replaced only if dvdx wrote it") {
  const ScratchFolder folder("pc2-mine");
  const Output output{.target = folder / "a.pc2", .particles = particles, .states = 2};
  folder.write("a.obj", "v 0 0 0\n");
  CHECK_THROWS_WITH_AS((void)make_writer<float>(output),
                       ((folder / "a.pc2") + ": cannot be written: " + (folder / "a.obj") +
                        " goes with it, and one that dvdx did not write is there")
                           .c_str(),
                       Fault);
  CHECK(folder.entries() == 1);
  States<float>().write(folder / "b.pc2", 1);
  const auto first = folder.read("b.obj");
  Sheet().write<float>(folder / "b.pc2");
  CHECK(folder.read("b.obj") != first);
}

TEST_CASE("a count too large for a .pc2 is refused before the run") {
  const ScratchFolder folder("pc2-most");
  for (const auto& [count, states] : {std::pair<std::size_t, std::uint64_t>{1, 1ULL << 31U}, {1ULL << 31U, 1}}) {
    CHECK_THROWS_AS((void)make_writer<float>({.target = folder / "a.pc2", .particles = count, .states = states}), Fault);
  }
  CHECK(folder.entries() == 0);
}

TEST_CASE("an unfinished run leaves no file, and an earlier file stays") {
  for (const char* name : {"a.csv", "a.npz", "a.ply", "a.vtp", "a.pc2"}) {
    CAPTURE(std::string(name));
    const ScratchFolder folder("unfinished");
    folder.write(name, "before");
    {
      States<float> states;
      const auto writer = make_writer<float>({.target = folder / name, .particles = particles, .states = 3});
      writer->write({}, states.at(0));
      writer->write({}, states.at(1));
    }
    CHECK(folder.entries() == 1);
    CHECK(folder.read(name) == "before");
  }
}

TEST_CASE("either all of several files are put in place, or none of them") {
  const ScratchFolder folder("all-or-none");
  std::vector<PartFile> files;
  for (const char* name : {"a", "b", "c"}) files.emplace_back(folder / name);
  std::filesystem::create_directory(folder.path() / "c");
  CHECK_THROWS_AS(commit_all(files), Fault);
  files.clear();
  CHECK(folder.entries() == 1);  // the directory
}

Exit exit_of(const std::filesystem::path& target, std::uint64_t states = 2) {
  try {
    (void)make_writer<float>({.target = target, .particles = particles, .states = states});
    return Exit::done;
  } catch (const Fault& fault) {
    return fault.exit();
  }
}

TEST_CASE("a target that cannot be written is refused before the run") {
  const ScratchFolder folder("targets");
  for (const char* name : {"none/a.csv", "none/a.npz", "none/a.ply", "none/a.vtp", "none/a.pc2"}) {
    CHECK(exit_of(folder / name) == Exit::input_output);
  }
  for (const char* name :
       {"there.csv", "there.npz", "there-000001.ply", "there-000001.vtp", "other.pvd", "there.pc2", "other.obj"}) {
    std::filesystem::create_directories(folder / name);
  }
  for (const char* name : {"there.csv", "there.npz", "there.ply", "there.vtp", "other.vtp", "there.pc2", "other.pc2"}) {
    CAPTURE(std::string(name));
    CHECK(exit_of(folder / name) == Exit::input_output);
  }
  CHECK(folder.entries() == 7);
}

// Two states, with three particles and with one.
void write_changing(const std::filesystem::path& target) {
  const auto writer = make_writer<float>({.target = target, .particles = particles, .states = 2, .counts = Counts::changing});
  States<float> states;
  auto state = states.at(0);
  writer->write({}, state);
  state.count = 1;
  writer->write({.step = 5, .time = 0.5}, state);
  writer->finish();
}

TEST_CASE("a particle count that changes is written if the format has one for each state, else refused with the reason") {
  const ScratchFolder folder("changing");
  write_changing(folder / "a.csv");
  const auto rows = folder.read("a.csv");
  CHECK(std::count(rows.begin(), rows.end(), '\n') == 1 + 3 + 1);
  write_changing(folder / "a.ply");
  CHECK(read_points(folder / "a-000001.ply").all == 1);
  write_changing(folder / "a.vtp");
  const auto counts = [&](const char* name) {
    pugi::xml_document document;
    REQUIRE(document.load_file((folder / name).c_str()));
    const auto piece = document.child("VTKFile").child("PolyData").child("Piece");
    return std::pair(piece.attribute("NumberOfPoints").as_int(), piece.attribute("NumberOfVerts").as_int());
  };
  CHECK(counts("a-000000.vtp") == std::pair(3, 3));
  CHECK(counts("a-000001.vtp") == std::pair(1, 1));
  for (const char* name : {"a.npz", "a.pc2"}) {
    CHECK_THROWS_AS(write_changing(folder / name), Fault);
  }
  CHECK_THROWS_WITH_AS(write_changing("a.pc2"),
                       "--out a.pc2: a .pc2 holds as many particles in every state, and those of this scene come and go: "
                       ".csv, .ply, .obj, .vtp, .pvtp, .html, .png and .apng hold them",
                       Fault);
}

TEST_CASE("an unknown extension is a usage error, and the message lists the known ones") {
  CHECK_THROWS_WITH_AS(check_extension("a.xyz"),
                       "--out a.xyz: must end in .csv, .npz, .ply, .vtp, .pvtp, .pc2, .html, .obj, .png or .apng", Fault);
  CHECK_NOTHROW(check_extension("a.pc2"));
  CHECK_NOTHROW(check_extension("a.html"));
  CHECK(exit_of("a") == Exit::usage);
}

}  // namespace writer_test
