#include "output/vtp_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include "files/bytes.hpp"
#include "output/base64.hpp"
#include "output/pieces.hpp"

namespace dvdx::tool {
namespace {

using Put = PartFile::Put;

// Passes its input on as base64, some at a time.
class Base64Put {
 public:
  explicit Base64Put(const Put& put) : put_(put) {}

  void operator()(std::string_view bytes) {
    bytes_ += bytes;
    if (bytes_.size() >= most) put_whole();
  }
  // Fewer than three bytes at the end become letters and padding, or are left out.
  enum class End { padded, left_out };
  void finish(End end) {
    put_whole();
    if (end == End::padded) put_(base64(bytes_));
    bytes_.clear();
  }

 private:
  static constexpr std::size_t most = std::size_t{3} << 14U;

  void put_whole() {
    const std::size_t whole = bytes_.size() / 3 * 3;
    put_(base64(std::string_view(bytes_).substr(0, whole)));
    bytes_.erase(0, whole);
  }

  const Put& put_;
  std::string bytes_;
};

// Numbers of a DataArray, of which each rank has a part.
struct Array {
  std::uint64_t all = 0, place = 0, here = 0;  // bytes: of all ranks, of those before this one, of this one
  std::array<char, 2> last{};                  // of this rank's bytes
  std::function<void(const Put&)> feed{};
};

std::array<char, 2> last_two(const void* end_of_number, std::size_t size) {
  std::array<char, 2> two{};
  std::memcpy(two.data(), static_cast<const char*>(end_of_number) + size - two.size(), two.size());
  return two;
}

// Returns the last two bytes of the nearest rank before this one that has any. Three bytes make four letters, so bytes that do
// not fill three go to the next rank.
std::array<char, 2> bytes_before(Ranks& ranks, bool has_bytes, const std::array<char, 2>& last) {
  constexpr std::uint64_t has = std::uint64_t{1} << 16U;
  std::vector<std::uint64_t> all(static_cast<std::size_t>(ranks.count()), 0);
  std::uint16_t two = 0;
  std::memcpy(&two, last.data(), sizeof two);
  all[static_cast<std::size_t>(ranks.rank())] = has_bytes ? has | two : 0;
  ranks.sum(all);
  std::uint16_t found = 0;
  for (int rank = 0; rank < ranks.rank(); ++rank) {
    if (const auto value = all[static_cast<std::size_t>(rank)]; value != 0) found = static_cast<std::uint16_t>(value);
  }
  std::array<char, 2> before{};
  std::memcpy(before.data(), &found, sizeof found);
  return before;
}

// VTK wants the byte count before the data, both in one base64 text (header_type UInt64).
void write_array(PartFile& file, Ranks* ranks, const Array& array) {
  constexpr std::uint64_t head = sizeof(std::uint64_t);
  const bool is_first = ranks == nullptr || ranks->rank() == 0;
  const auto size = std::bit_cast<std::array<char, head>>(array.all);
  const std::uint64_t from = is_first ? 0 : head + array.place;
  const std::uint64_t to = head + array.place + array.here;
  std::array<char, 2> before{};
  if (ranks != nullptr) {
    before = bytes_before(*ranks, is_first || array.here > 0, array.here > 0 ? array.last : std::array{size[6], size[7]});
  }
  const std::uint64_t letters = (head + array.all + 2) / 3 * 4;
  file.write_share(from / 3 * 4, letters, [&](const Put& put) {
    if (!is_first && array.here == 0) return;
    Base64Put text(put);
    const auto carried = static_cast<std::size_t>(from % 3);
    text(std::string_view(before.data(), before.size()).substr(before.size() - carried));
    if (is_first) text(std::string_view(size.data(), size.size()));
    array.feed([&](std::string_view bytes) { text(bytes); });
    text.finish(to == head + array.all ? Base64Put::End::padded : Base64Put::End::left_out);
  });
}

template <class T>
Array columns_array(const Stretch& stretch, const std::array<Column<T>, 3>& columns, std::size_t here) {
  constexpr std::size_t element = 3 * sizeof(T);
  Array array{.all = stretch.all * element, .place = stretch.first * element, .here = here * element};
  if (here > 0) array.last = last_two(columns[2].at(here - 1), sizeof(T));
  array.feed = [&columns, here](const Put& put) { put_interleaved<T>(columns, here, put); };
  return array;
}

// Returns the array whose i-th number of all is number(i).
template <class Number>
Array numbers_array(const Stretch& stretch, std::size_t here, const Number& number) {
  constexpr std::size_t element = sizeof(std::int64_t);
  const std::size_t first = stretch.first;
  Array array{.all = stretch.all * element, .place = first * element, .here = here * element};
  if (here > 0) {
    const std::int64_t last = number(first + here - 1);
    array.last = last_two(&last, sizeof last);
  }
  array.feed = [=](const Put& put) {
    std::array<std::int64_t, 4096> some;
    for (std::size_t from = 0; from < here; from += some.size()) {
      const std::size_t n = std::min(some.size(), here - from);
      for (std::size_t i = 0; i < n; ++i) some[i] = number(first + from + i);
      put({reinterpret_cast<const char*>(some.data()), n * sizeof(std::int64_t)});
    }
  };
  return array;
}

// Cells of one kind.
struct Cells {
  const char* element;
  const char* count_name;
  std::size_t count;
  Array connectivity, offsets;
};

// The first of several ranks has all cells.
template <class Shapes>
Cells cells_of(const Output& output, const char* element, const char* count_name, const Shapes& shapes) {
  constexpr std::size_t size = sizeof(std::int64_t);
  std::uint64_t corners = 0;
  for (const auto& shape : shapes) corners += shape.size();
  const bool is_first = output.ranks == nullptr || output.ranks->rank() == 0;
  const auto array = [&](std::uint64_t numbers, const auto& each) {
    Array made{.all = numbers * size, .place = is_first ? 0 : numbers * size, .here = is_first ? numbers * size : 0};
    made.feed = [&shapes, each](const Put& put) {
      std::string bytes;
      std::int64_t end = 0;
      for (const auto& shape : shapes) {
        each(bytes, shape, end);
        if (bytes.size() < std::size_t{1} << 15U) continue;
        put(bytes);
        bytes.clear();
      }
      put(bytes);
    };
    return made;
  };
  return {element, count_name, shapes.size(),
          array(corners,
                [](std::string& bytes, const auto& shape, std::int64_t&) {
                  for (const auto corner : shape) {
                    append_bytes(bytes, static_cast<std::int64_t>(corner));
                  }
                }),
          array(shapes.size(), [](std::string& bytes, const auto& shape, std::int64_t& end) {
            append_bytes(bytes, end += static_cast<std::int64_t>(shape.size()));
          })};
}

// ParaView draws only points of cells, so a particle that nothing joins is a cell of its own. If nothing joins any particles,
// each of several ranks has the cells of its own.
Cells loose_cells(const Stretch& stretch, std::size_t here) {
  const auto corner = [](std::size_t i) { return static_cast<std::int64_t>(i); };
  const auto end = [](std::size_t i) { return static_cast<std::int64_t>(i) + 1; };
  return {"Verts", "NumberOfVerts", stretch.all, numbers_array(stretch, here, corner), numbers_array(stretch, here, end)};
}

using Loose = std::vector<std::array<std::size_t, 1>>;

Loose loose_where_joined(const Topology& topology, std::size_t particles) {
  return topology == no_topology ? Loose() : loose_particles(topology, particles);
}

Array ghosts_array(const RankPiece& piece) {
  const std::size_t all = piece.particles.size();
  return {.all = all, .here = all, .feed = [&piece, all](const Put& put) {
            put(std::string(piece.own, '\0'));
            put(std::string(all - piece.own, '\1'));
          }};
}

// loose: the particles that nothing joins, if others are joined. The cells refer to it and to the topology.
std::vector<Cells> all_cells(const Output& output, const Topology& topology, const Loose& loose, const Stretch& stretch,
                             std::size_t here) {
  std::vector<Cells> all;
  if (topology == no_topology && output.piece == nullptr) {
    if (stretch.all > 0) all.push_back(loose_cells(stretch, here));
    return all;
  }
  const auto add = [&](const char* element, const char* count_name, const auto& shapes) {
    if (!shapes.empty()) all.push_back(cells_of(output, element, count_name, shapes));
  };
  add("Verts", "NumberOfVerts", loose);
  add("Lines", "NumberOfLines", topology.lines);
  add("Polys", "NumberOfPolys", topology.faces);
  return all;
}

void add_array(pugi::xml_node parent, const char* name, const char* type, int components, const char* text) {
  auto array = parent.append_child("DataArray");
  array.append_attribute("type") = type;
  array.append_attribute("Name") = name;
  if (components > 1) array.append_attribute("NumberOfComponents") = components;
  array.append_attribute("format") = "binary";
  array.text() = text;
}

// A file's text is a skeleton, the same on all ranks, with a mark in each array's place.
constexpr char mark = '@';  // nothing else that is written here has one

void write_text(PartFile& file, Ranks* ranks, std::string_view skeleton, std::span<const Array* const> arrays) {
  for (const Array* array : arrays) {
    const auto place = skeleton.find(mark);
    file.write(skeleton.substr(0, place));
    write_array(file, ranks, *array);
    skeleton.remove_prefix(place + 1);
  }
  file.write(skeleton);
}

}  // namespace

pugi::xml_node add_vtk_root(pugi::xml_document& document, const char* type) {
  auto root = document.append_child("VTKFile");
  root.append_attribute("type") = type;
  root.append_attribute("version") = "1.0";
  root.append_attribute("byte_order") = "LittleEndian";
  root.append_attribute("header_type") = "UInt64";
  return root;
}

std::string text_of(const pugi::xml_document& document) {
  std::ostringstream text;
  document.save(text, " ");
  return std::move(text).str();
}

void add_time(pugi::xml_node data, const Moment& moment) {
  auto time = data.append_child("FieldData").append_child("DataArray");
  time.append_attribute("type") = "Float64";
  time.append_attribute("Name") = "TimeValue";
  time.append_attribute("NumberOfTuples") = 1;
  time.append_attribute("format") = "ascii";
  time.text() = fmt::format("{}", moment.time).c_str();
}

template <class T>
void write_poly_data(PartFile& file, const Output& output, const Moment& moment, const State<T>& state) {
  const Stretch stretch = stretch_of(output, state.count);
  const std::size_t torn = tears_until(output, moment.step);
  const Topology left = torn == 0 ? Topology() : without(*output.topology, {output.tears->data(), torn});
  const Topology& topology = output.piece != nullptr ? output.piece->topology : torn == 0 ? *output.topology : left;
  const auto loose = output.piece != nullptr ? output.piece->loose : loose_where_joined(topology, stretch.all);
  const std::vector<Cells> all = all_cells(output, topology, loose, stretch, state.count);
  pugi::xml_document document;
  auto data = add_vtk_root(document, "PolyData").append_child("PolyData");
  add_time(data, moment);
  auto piece = data.append_child("Piece");
  piece.append_attribute("NumberOfPoints") = std::to_string(stretch.all).c_str();
  for (const auto& cells : all) piece.append_attribute(cells.count_name) = std::to_string(cells.count).c_str();
  const std::string here(1, mark);
  const Array velocity = columns_array(stretch, state.v, state.count);
  const Array position = columns_array(stretch, state.x, state.count);
  Array ghosts;
  std::vector<const Array*> arrays{&velocity};
  auto point_data = piece.append_child("PointData");
  add_array(point_data, "velocity", vtk_type<T>(), 3, here.c_str());
  if (output.piece != nullptr && !output.owner.empty()) {
    ghosts = ghosts_array(*output.piece);
    add_array(point_data, vtk_ghosts, "UInt8", 1, here.c_str());
    arrays.push_back(&ghosts);
  }
  arrays.push_back(&position);
  add_array(piece.append_child("Points"), "position", vtk_type<T>(), 3, here.c_str());
  for (const auto& cells : all) {
    auto element = piece.append_child(cells.element);
    add_array(element, "connectivity", "Int64", 1, here.c_str());
    add_array(element, "offsets", "Int64", 1, here.c_str());
    arrays.insert(arrays.end(), {&cells.connectivity, &cells.offsets});
  }
  write_text(file, output.ranks, text_of(document), arrays);
}

std::string collection_of(const std::vector<TimedFile>& files) {
  pugi::xml_document document;
  auto collection = add_vtk_root(document, "Collection").append_child("Collection");
  for (const auto& [time, file] : files) {
    auto entry = collection.append_child("DataSet");
    entry.append_attribute("timestep") = fmt::format("{}", time).c_str();
    entry.append_attribute("part") = 0;
    entry.append_attribute("file") = file.c_str();
  }
  return text_of(document);
}

template void write_poly_data(PartFile&, const Output&, const Moment&, const State<float>&);
template void write_poly_data(PartFile&, const Output&, const Moment&, const State<double>&);

}  // namespace dvdx::tool
