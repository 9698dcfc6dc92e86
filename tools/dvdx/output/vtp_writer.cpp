// VTK XML PolyData, a file a state with inline base64, and a .pvd that gives each file its time: what ParaView opens.
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "output/base64.hpp"
#include "output/bytes.hpp"
#include "output/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

// VTK wants the byte count before the data, both in one base64 text (header_type UInt64).
std::string inline_binary(std::string_view bytes) {
  std::string with_size(sizeof(std::uint64_t), '\0');
  const std::uint64_t size = bytes.size();
  std::memcpy(with_size.data(), &size, sizeof size);
  return base64(with_size.append(bytes));
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

// Cells of one kind. Where the count of particles is, they are the same in every state: encoded once.
struct Cells {
  const char* element;
  const char* count_name;
  std::size_t count;
  std::string connectivity;
  std::string offsets;
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

// ParaView draws only what is in a cell: a particle that nothing joins is one of its own.
std::vector<Cells> all_cells(const Topology& topology, std::size_t particles) {
  std::vector<Cells> cells;
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
std::string poly_data(const Moment& moment, const State<T>& state, const std::vector<Cells>& all) {
  pugi::xml_document document;
  auto data = add_root(document, "PolyData").append_child("PolyData");
  auto time = data.append_child("FieldData").append_child("DataArray");
  time.append_attribute("type") = "Float64";
  time.append_attribute("Name") = "TimeValue";
  time.append_attribute("NumberOfTuples") = 1;
  time.append_attribute("format") = "ascii";
  time.text() = fmt::format("{}", moment.time).c_str();
  auto piece = data.append_child("Piece");
  piece.append_attribute("NumberOfPoints") = std::to_string(state.count).c_str();
  for (const auto& cells : all) piece.append_attribute(cells.count_name) = std::to_string(cells.count).c_str();
  const auto encoded = [&](const auto& columns) { return inline_binary(interleaved(columns, state.count)); };
  add_array(piece.append_child("PointData"), "velocity", vtk_type<T>(), 3, encoded(state.v));
  add_array(piece.append_child("Points"), "position", vtk_type<T>(), 3, encoded(state.x));
  for (const auto& cells : all) {
    auto element = piece.append_child(cells.element);
    add_array(element, "connectivity", "Int64", 1, cells.connectivity);
    add_array(element, "offsets", "Int64", 1, cells.offsets);
  }
  return text_of(document);
}

template <class T>
class VtpWriter final : public Writer<T> {
 public:
  explicit VtpWriter(const Output& output)
      : target_(output.target),
        old_frames_(old_frames(output)),
        topology_(*output.topology),
        particles_(output.particles),
        cells_(all_cells(topology_, particles_)) {
    const PartFile probe(series());
  }

  void write(const Moment& moment, const State<T>& state) override {
    if (state.count != particles_) cells_ = all_cells(topology_, particles_ = state.count);
    files_.emplace_back(numbered(target_, files_.size()));
    files_.back().write(poly_data(moment, state, cells_));
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
    files_.emplace_back(series());
    files_.back().write(text_of(document));
    commit_series(files_, old_frames_);
  }

 private:
  [[nodiscard]] std::filesystem::path series() const {
    auto path = target_;
    return path.replace_extension(".pvd");
  }

  std::filesystem::path target_;
  std::vector<std::filesystem::path> old_frames_;
  const Topology& topology_;
  std::size_t particles_;  // of which cells_ are
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
