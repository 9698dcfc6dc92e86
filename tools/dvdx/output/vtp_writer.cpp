// VTK XML PolyData, a file a state with inline base64, and a .pvd that gives each file its time: what ParaView opens.
#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "output/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U;
  };
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::uint32_t word = (byte(i) << 16U) | (byte(i + 1) << 8U) | byte(i + 2);
    for (unsigned digit = 0; digit < 4; ++digit) {
      const bool is_padding = i + digit > bytes.size();
      text += is_padding ? '=' : digits[(word >> (18 - 6 * digit)) & 63U];
    }
  }
  return text;
}

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

void add_array(pugi::xml_node parent, const char* name, std::string_view type, int components, std::string_view bytes) {
  auto array = parent.append_child("DataArray");
  array.append_attribute("type") = std::string(type).c_str();
  array.append_attribute("Name") = name;
  if (components > 1) array.append_attribute("NumberOfComponents") = components;
  array.append_attribute("format") = "binary";
  array.text() = inline_binary(bytes).c_str();
}

// first, first + 1, ... as bytes.
std::string counting(std::int64_t first, std::size_t count) {
  std::string bytes(count * sizeof(std::int64_t), '\0');
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t value = first + static_cast<std::int64_t>(i);
    std::memcpy(&bytes[i * sizeof value], &value, sizeof value);
  }
  return bytes;
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
std::string poly_data(const Moment& moment, const State<T>& state) {
  pugi::xml_document document;
  auto data = add_root(document, "PolyData").append_child("PolyData");
  auto time = data.append_child("FieldData").append_child("DataArray");
  time.append_attribute("type") = "Float64";
  time.append_attribute("Name") = "TimeValue";
  time.append_attribute("NumberOfTuples") = 1;
  time.append_attribute("format") = "ascii";
  time.text() = fmt::format("{}", moment.time).c_str();
  auto piece = data.append_child("Piece");
  const auto count = std::to_string(state.count);
  piece.append_attribute("NumberOfPoints") = count.c_str();
  piece.append_attribute("NumberOfVerts") = count.c_str();
  add_array(piece.append_child("PointData"), "velocity", vtk_type<T>(), 3, interleaved(state.v, state.count));
  add_array(piece.append_child("Points"), "position", vtk_type<T>(), 3, interleaved(state.x, state.count));
  auto verts = piece.append_child("Verts");
  add_array(verts, "connectivity", "Int64", 1, counting(0, state.count));
  add_array(verts, "offsets", "Int64", 1, counting(1, state.count));
  return text_of(document);
}

template <class T>
class VtpWriter final : public Writer<T> {
 public:
  explicit VtpWriter(const Output& output) : target_(output.target) {
    for (std::uint64_t i = 0; i < output.states; ++i) check_target(numbered(target_, i));
    const PartFile probe(series());
  }

  void write(const Moment& moment, const State<T>& state) override {
    files_.emplace_back(numbered(target_, files_.size()));
    files_.back().write(poly_data(moment, state));
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
    commit_all(files_);
  }

 private:
  [[nodiscard]] std::filesystem::path series() const {
    auto path = target_;
    return path.replace_extension(".pvd");
  }

  std::filesystem::path target_;
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
