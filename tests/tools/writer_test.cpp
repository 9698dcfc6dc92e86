#include "output/writer.hpp"

#include <doctest/doctest.h>
#include <zip.h>

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <pugixml.hpp>
#include <type_traits>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "fault.hpp"
#include "points_file.hpp"
#include "tools/scratch_folder.hpp"

namespace {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::ScratchFolder;

constexpr std::size_t particles = 3;

// Numbers that are hard to write short: all different, some tiny, some without an end in decimals.
template <class T>
T number(std::uint64_t state, std::size_t particle, std::size_t field) {
  constexpr std::array<double, 6> hard{1.0 / 3, -0.1, 1e-30, 123456789.123456789, -0.0, 2.5e20};
  return static_cast<T>(hard[(field + particle) % 6] * static_cast<double>(state + 1));
}

template <class T>
class States {
 public:
  // Writes `count` states, 5 steps and a fraction of a second apart.
  void write(const std::filesystem::path& target, std::uint64_t count) {
    const auto writer = make_writer<T>({.target = target, .particles = particles, .states = count});
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

// The data behind a header that must say this.
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

TEST_CASE_TEMPLATE("a .ply a state, which the scene reader reads", T, float, double) {
  const ScratchFolder folder("ply");
  States<T>().write(folder / "a.ply", 2);
  CHECK(folder.entries() == 2);
  for (std::uint64_t state = 0; state < 2; ++state) {
    const std::string name = "a-00000" + std::to_string(state) + ".ply";
    const auto points = read_points(folder / name);
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

// The data of an array, whose size stands before it.
std::string inline_data(const pugi::xml_node& array, std::size_t size) {
  const auto bytes = from_base64(array.text().get());
  CHECK(value_at<std::uint64_t>(bytes, 0) == size);
  REQUIRE(bytes.size() == sizeof(std::uint64_t) + size);
  return bytes.substr(sizeof(std::uint64_t));
}

TEST_CASE_TEMPLATE("a .vtp a state and a .pvd that gives them their times", T, float, double) {
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

TEST_CASE("nothing is left of a run that does not finish, and what was there stays") {
  for (const char* name : {"a.csv", "a.npz", "a.ply", "a.vtp"}) {
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

Exit exit_of(const std::filesystem::path& target, std::uint64_t states = 2) {
  try {
    (void)make_writer<float>({.target = target, .particles = particles, .states = states});
    return Exit::done;
  } catch (const Fault& fault) {
    return fault.exit();
  }
}

TEST_CASE("a target that cannot be written is known before the run") {
  const ScratchFolder folder("targets");
  for (const char* name : {"none/a.csv", "none/a.npz", "none/a.ply", "none/a.vtp"}) {
    CHECK(exit_of(folder / name) == Exit::input_output);
  }
  for (const char* name : {"there.csv", "there.npz", "there-000001.ply", "there-000001.vtp", "other.pvd"}) {
    std::filesystem::create_directories(folder / name);
  }
  for (const char* name : {"there.csv", "there.npz", "there.ply", "there.vtp", "other.vtp"}) {
    CAPTURE(std::string(name));
    CHECK(exit_of(folder / name) == Exit::input_output);
  }
  CHECK(folder.entries() == 5);
}

TEST_CASE("an extension that nothing writes is a matter of usage, and the known ones are listed") {
  CHECK_THROWS_WITH_AS(check_extension("a.xyz"), "--out a.xyz: must end in .csv, .npz, .ply or .vtp", Fault);
  CHECK_THROWS_WITH_AS(
      check_extension("a.pc2"),
      "--out a.pc2: .pc2 comes with networks, which this version does not run: must end in .csv, .npz, .ply or .vtp", Fault);
  CHECK_THROWS_WITH_AS(
      check_extension("a.html"),
      "--out a.html: .html comes with the viewer, which is not in this version: must end in .csv, .npz, .ply or .vtp", Fault);
  CHECK(exit_of("a") == Exit::usage);
}

}  // namespace
