// VTK XML PolyData, a file a state with inline base64, and a .pvd that gives each file its time: what ParaView opens.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <pugixml.hpp>
#include <span>
#include <sstream>
#include <vector>

#include "output/base64.hpp"
#include "output/bytes.hpp"
#include "output/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

// VTK wants the byte count before the data, both in one base64 text (header_type UInt64).
std::string with_size(std::uint64_t size, std::string_view bytes) {
  std::string all(sizeof size, '\0');
  std::memcpy(all.data(), &size, sizeof size);
  return all.append(bytes);
}
std::string inline_binary(std::string_view bytes) { return base64(with_size(bytes.size(), bytes)); }

// The same of what several ranks hold, each `bytes` of it from `place` on: the text of this rank's part. Three bytes make four
// letters, so what does not fill three goes to the next rank.
std::string inline_binary_part(Ranks& ranks, std::uint64_t size, std::uint64_t place, std::string_view part) {
  const bool is_first = ranks.rank() == 0;
  std::string bytes = is_first ? with_size(size, part) : std::string(part);
  const std::uint64_t from = is_first ? 0 : sizeof size + place;
  const std::uint64_t to = from + bytes.size();
  const auto last_two = [&](std::size_t n) { return bytes.size() > n ? bytes[bytes.size() - 1 - n] : '\0'; };
  const std::array<char, 2> passed_on{last_two(1), last_two(0)};
  std::array<char, 2> carried{};
  if (!is_first) ranks.start_receive(ranks.rank() - 1, std::as_writable_bytes(std::span(carried)));
  if (ranks.rank() + 1 < ranks.count()) ranks.start_send(ranks.rank() + 1, std::as_bytes(std::span(passed_on)));
  ranks.finish();
  if (part.empty() && !is_first) return {};
  const auto before = static_cast<std::size_t>(from % 3);
  bytes.insert(bytes.begin(), carried.end() - static_cast<std::ptrdiff_t>(before), carried.end());
  if (to != sizeof size + size) bytes.resize(bytes.size() - bytes.size() % 3);
  return base64(bytes);
}

// A file's text: what is alike for all ranks, and between it arrays of which each rank writes its part.
struct Text {
  std::string skeleton;             // with a mark in each array's place
  std::vector<std::string> arrays;  // in their order
};
constexpr char mark = '@';  // no letter of base64, nor of anything else that is written here

void write_text(PartFile& file, const Text& text) {
  std::string_view left = text.skeleton;
  for (const auto& array : text.arrays) {
    const auto place = left.find(mark);
    file.write(left.substr(0, place));
    file.write_parts(array);
    left.remove_prefix(place + 1);
  }
  file.write(left);
}

template <class T>
std::string_view vtk_type() {
  return sizeof(T) == 4 ? "Float32" : "Float64";
}

void add_array(pugi::xml_node parent, const char* name, std::string_view type, int components, const std::string& encoded) {
  auto array = parent.append_child("DataArray");
  array.append_attribute("type") = std::string(type).c_str();
  array.append_attribute("Name") = name;
  if (components > 1) array.append_attribute("NumberOfComponents") = components;
  array.append_attribute("format") = "binary";
  array.text() = encoded.c_str();
}

// An array of which each rank has the part from element `first` on, of `all`.
template <class Bytes>
std::string encoded_part(const Output& output, std::size_t all, std::size_t first, std::size_t element, const Bytes& bytes) {
  if (output.ranks == nullptr) return inline_binary(bytes);
  return inline_binary_part(*output.ranks, all * element, first * element, bytes);
}

// Cells of one kind. Where the count of particles is, they are the same in every state: encoded once.
struct Cells {
  const char* element;
  const char* count_name;
  std::size_t count;
  std::string connectivity;
  std::string offsets;
  bool is_split = false;  // each rank has a part of both texts
};

template <class Shapes>
Cells cells_of(const char* element, const char* count_name, const Shapes& shapes) {
  std::vector<std::int64_t> corners;
  std::vector<std::int64_t> ends;
  for (const auto& shape : shapes) {
    corners.insert(corners.end(), shape.begin(), shape.end());
    ends.push_back(static_cast<std::int64_t>(corners.size()));
  }
  return {element, count_name, shapes.size(), inline_binary(bytes_of(corners)), inline_binary(bytes_of(ends))};
}

// Cells of one particle each, where nothing joins any: of several ranks each has those of its own.
Cells loose_cells(const Output& output, std::size_t here) {
  std::vector<std::int64_t> corners(here);
  std::iota(corners.begin(), corners.end(), static_cast<std::int64_t>(output.first));
  std::vector<std::int64_t> ends(here);
  std::iota(ends.begin(), ends.end(), static_cast<std::int64_t>(output.first) + 1);
  const auto encoded = [&](const auto& numbers) {
    return encoded_part(output, output.particles, output.first, sizeof(std::int64_t), bytes_of(numbers));
  };
  return {"Verts", "NumberOfVerts", output.particles, encoded(corners), encoded(ends), true};
}

// ParaView draws only what is in a cell: a particle that nothing joins is one of its own.
std::vector<Cells> all_cells(const Output& output, const Topology& topology, std::size_t here) {
  std::vector<Cells> cells;
  if (output.ranks != nullptr && topology == no_topology) return {loose_cells(output, here)};
  const std::size_t particles = output.ranks == nullptr ? here : output.particles;
  const auto add = [&](const char* element, const char* count_name, const auto& shapes) {
    if (!shapes.empty()) cells.push_back(cells_of(element, count_name, shapes));
  };
  add("Verts", "NumberOfVerts", loose_particles(topology, particles));
  add("Lines", "NumberOfLines", topology.lines);
  add("Polys", "NumberOfPolys", topology.faces);
  return cells;
}

pugi::xml_node add_root(pugi::xml_document& document, const char* type) {
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

template <class T>
Text poly_data(const Output& output, const Moment& moment, const State<T>& state, const std::vector<Cells>& all) {
  const std::size_t particles = all_particles(output, state);
  Text text;
  const std::string here(1, mark);
  pugi::xml_document document;
  auto data = add_root(document, "PolyData").append_child("PolyData");
  auto time = data.append_child("FieldData").append_child("DataArray");
  time.append_attribute("type") = "Float64";
  time.append_attribute("Name") = "TimeValue";
  time.append_attribute("NumberOfTuples") = 1;
  time.append_attribute("format") = "ascii";
  time.text() = fmt::format("{}", moment.time).c_str();
  auto piece = data.append_child("Piece");
  piece.append_attribute("NumberOfPoints") = std::to_string(particles).c_str();
  for (const auto& cells : all) piece.append_attribute(cells.count_name) = std::to_string(cells.count).c_str();
  const auto add_columns = [&](pugi::xml_node parent, const char* name, const std::array<Column<T>, 3>& columns) {
    add_array(parent, name, vtk_type<T>(), 3, here);
    text.arrays.push_back(encoded_part(output, particles, output.first, 3 * sizeof(T), interleaved(columns, state.count)));
  };
  add_columns(piece.append_child("PointData"), "velocity", state.v);
  add_columns(piece.append_child("Points"), "position", state.x);
  const auto add_cells = [&](pugi::xml_node element, const char* name, const Cells& cells, const std::string& encoded) {
    add_array(element, name, "Int64", 1, cells.is_split ? here : encoded);
    if (cells.is_split) text.arrays.push_back(encoded);
  };
  for (const auto& cells : all) {
    auto element = piece.append_child(cells.element);
    add_cells(element, "connectivity", cells, cells.connectivity);
    add_cells(element, "offsets", cells, cells.offsets);
  }
  text.skeleton = text_of(document);
  return text;
}

template <class T>
class VtpWriter final : public Writer<T> {
 public:
  explicit VtpWriter(const Output& output) : output_(output), old_frames_(old_frames(output)) {
    const PartFile probe(series(), output.ranks);
  }

  void write(const Moment& moment, const State<T>& state) override {
    const std::size_t torn = tears_until(output_, moment.step);
    if (cells_.empty() || state.count != particles_ || torn != torn_) {
      particles_ = state.count;
      torn_ = torn;
      cells_ = torn == 0 ? all_cells(output_, *output_.topology, particles_)
                         : all_cells(output_, without(*output_.topology, {output_.tears->data(), torn}), particles_);
    }
    files_.emplace_back(numbered(output_.target, files_.size()), output_.ranks);
    write_text(files_.back(), poly_data(output_, moment, state, cells_));
    files_.back().close();
    times_.push_back(moment.time);
  }

  void finish() override {
    pugi::xml_document document;
    auto collection = add_root(document, "Collection").append_child("Collection");
    for (std::size_t i = 0; i < files_.size(); ++i) {
      auto entry = collection.append_child("DataSet");
      entry.append_attribute("timestep") = fmt::format("{}", times_[i]).c_str();
      entry.append_attribute("part") = 0;
      entry.append_attribute("file") = files_[i].target().filename().c_str();
    }
    files_.emplace_back(series(), output_.ranks);
    files_.back().write(text_of(document));
    commit_series(files_, old_frames_);
  }

 private:
  [[nodiscard]] std::filesystem::path series() const {
    auto path = output_.target;
    return path.replace_extension(".pvd");
  }

  Output output_;
  std::vector<std::filesystem::path> old_frames_;
  std::size_t particles_ = 0, torn_ = 0;  // of which cells_ are
  std::vector<Cells> cells_;
  std::vector<PartFile> files_;
  std::vector<double> times_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_vtp_writer(const Output& output) {
  return std::make_unique<VtpWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_vtp_writer(const Output&);
template std::unique_ptr<Writer<double>> make_vtp_writer(const Output&);

}  // namespace dvdx::tool
