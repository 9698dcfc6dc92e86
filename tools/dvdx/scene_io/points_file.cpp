#include "scene_io/points_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "scene_io/bytes.hpp"
#include "scene_io/text_lines.hpp"

namespace dvdx::tool {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary files read here are little endian");

template <class Value>
constexpr std::size_t width_of = std::tuple_size_v<Value>;
template <>
constexpr std::size_t width_of<double> = 1;

double& part(double& number, std::size_t /*column*/) { return number; }
double& part(Vec3& point, std::size_t column) { return point[column]; }
float& part(Vec3f& point, std::size_t column) { return point[column]; }

bool is_in(const Run& run, std::size_t row) { return row >= run.first && row - run.first < run.count; }

// ---- .csv --------------------------------------------------------------------------------------------------------------

using Columns = std::vector<std::size_t>;

// Returns the columns of a header to read: x, y and z by name if three are wanted, the only column if one is.
Columns columns_of(const std::vector<std::string_view>& header, std::size_t width) {
  if (width == 1) {
    if (header.size() != 1) fail("line 1 names " + std::to_string(header.size()) + " columns: must be 1");
    return {0};
  }
  Columns columns;
  for (const std::string_view name : {"x", "y", "z"}) {
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) fail("line 1 names no column " + std::string(name) + ": must name x, y and z");
    if (std::count(found, header.end(), name) > 1) fail("line 1 names two columns " + std::string(name) + ": must name one");
    columns.push_back(static_cast<std::size_t>(found - header.begin()));
  }
  return columns;
}

template <class List>
using ValueOf = std::decay_t<decltype(std::declval<List&>()[0])>;

template <class List>
KeptOf<List> read_csv(Bytes& bytes, const Run& run) {
  constexpr std::size_t width = width_of<ValueOf<List>>;
  Lines lines(bytes);
  KeptOf<List> kept;
  Columns columns;
  std::size_t cells = 0;
  while (lines.more()) {
    const auto line = lines.next();
    if (line.empty() || line.starts_with('#')) continue;
    if (!columns.empty() && !is_in(run, kept.all)) {
      ++kept.all;
      continue;
    }
    const auto row = split(line, ',');
    if (columns.empty()) {
      cells = row.size();
      if (!number_in(row[0])) {
        columns = columns_of(row, width);
        continue;
      }
      if (cells != width) {
        fail(line_name(lines.number()) + " has " + std::to_string(cells) + " numbers: must have " + std::to_string(width));
      }
      for (std::size_t i = 0; i < width; ++i) columns.push_back(i);
    }
    if (row.size() != cells) {
      fail(line_name(lines.number()) + " has " + std::to_string(row.size()) + " numbers: must have " + std::to_string(cells));
    }
    if (!is_in(run, kept.all++)) continue;
    auto& value = kept.values.emplace_back();
    for (std::size_t i = 0; i < width; ++i) part(value, i) = finite_number(row[columns[i]], lines.number());
  }
  return kept;
}

// ---- binary numbers ----------------------------------------------------------------------------------------------------

template <class T>
T held_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <class T>
double number_at(const char* bytes) {
  return static_cast<double>(held_at<T>(bytes));
}

struct NumberType {
  std::string_view name;
  std::string_view alias;
  std::size_t bytes;
  double (*read)(const char*);
};

constexpr std::array<NumberType, 8> number_types{{{"char", "int8", 1, number_at<std::int8_t>},
                                                  {"uchar", "uint8", 1, number_at<std::uint8_t>},
                                                  {"short", "int16", 2, number_at<std::int16_t>},
                                                  {"ushort", "uint16", 2, number_at<std::uint16_t>},
                                                  {"int", "int32", 4, number_at<std::int32_t>},
                                                  {"uint", "uint32", 4, number_at<std::uint32_t>},
                                                  {"float", "float32", 4, number_at<float>},
                                                  {"double", "float64", 8, number_at<double>}}};

template <class T>
T finite(T value, std::size_t index) {
  if (!std::isfinite(value)) fail("number " + std::to_string(index) + " is not finite");
  return value;
}

// Rows of the same length, of which some numbers are wanted.
template <class Value>
struct BinaryRows {
  struct Number {
    const NumberType* type = nullptr;
    std::size_t offset = 0;
  };
  std::array<Number, width_of<Value>> numbers;
  std::size_t row_bytes = 0;
  std::size_t begins = 0;  // bytes before the first
  std::size_t all = 0;     // as the header promises
};

std::string cut_off(std::size_t held, std::size_t promised, std::string_view what) {
  return "holds " + std::to_string(held) + " of the " + std::to_string(promised) + " " + std::string(what) +
         " that its header promises: is it cut off?";
}

template <class Value>
void require_all(const Bytes& bytes, const BinaryRows<Value>& rows, std::string_view what) {
  const std::size_t held = (bytes.size() - std::min(bytes.size(), rows.begins)) / rows.row_bytes;
  if (held < rows.all) fail(cut_off(held, rows.all, what));
}

// number_of(type, bytes) reads a number.
template <class List, class Wanted, class NumberOf>
KeptOf<List> read_rows(Bytes& bytes, const BinaryRows<Wanted>& rows, const Run& run, const NumberOf& number_of) {
  const std::size_t at_once = std::max<std::size_t>(1, (std::size_t{1} << 18U) / rows.row_bytes);
  const std::size_t first = std::min(run.first, rows.all);
  const std::size_t end = first + std::min(run.count, rows.all - first);
  KeptOf<List> kept{.values = List(end - first), .all = rows.all};
  std::vector<char> some(at_once * rows.row_bytes);
  for (std::size_t row = first; row < end; ++row) {
    const std::size_t n = (row - first) % at_once;
    if (n == 0) {
      const std::size_t wanted = std::min(at_once, end - row) * rows.row_bytes;
      if (bytes.read(rows.begins + row * rows.row_bytes, std::span(some).first(wanted)) < wanted) fail("ends while it is read");
    }
    for (std::size_t i = 0; i < width_of<Wanted>; ++i) {
      const auto& [type, offset] = rows.numbers[i];
      const char* const at = some.data() + n * rows.row_bytes + offset;
      part(kept.values[row - first], i) = finite(number_of(*type, at), row * width_of<Wanted> + i);
    }
  }
  return kept;
}

template <class List>
KeptOf<List> read_rows(Bytes& bytes, const BinaryRows<ValueOf<List>>& rows, const Run& run) {
  return read_rows<List>(bytes, rows, run, [](const NumberType& type, const char* at) { return type.read(at); });
}

Points read_points_of(Bytes& bytes, const BinaryRows<Vec3>& rows, const Run& run) {
  const auto is_float = [](const auto& number) { return number.type->name == "float"; };
  if (!std::all_of(rows.numbers.begin(), rows.numbers.end(), is_float)) return read_rows<Chunked<Vec3>>(bytes, rows, run);
  return read_rows<Chunked<Vec3f>>(bytes, rows, run, [](const NumberType&, const char* at) { return held_at<float>(at); });
}

// ---- .ply --------------------------------------------------------------------------------------------------------------

struct PlyHeader {
  enum class Form { ascii, little_endian } form = Form::ascii;
  std::size_t vertices = 0;
  std::vector<const NumberType*> types;  // of the vertex's properties
  std::array<std::size_t, 3> xyz{};      // which of them are x, y, z
};

const NumberType& type_named(std::string_view name) {
  for (const auto& type : number_types) {
    if (name == type.name || name == type.alias) return type;
  }
  fail("property type " + std::string(name) + " is not known to PLY");
}

PlyHeader::Form ply_form(const std::vector<std::string_view>& line) {
  if (line.size() == 3 && line[2] == "1.0") {
    if (line[1] == "ascii") return PlyHeader::Form::ascii;
    if (line[1] == "binary_little_endian") return PlyHeader::Form::little_endian;
  }
  fail("must be of format ascii 1.0 or binary_little_endian 1.0");
}

PlyHeader read_ply_header(Lines& lines) {
  if (!lines.more() || lines.next() != "ply") fail("is not a PLY file");
  PlyHeader header;
  std::array<std::size_t, 3> found{};
  std::size_t elements = 0;
  bool format_seen = false;
  while (lines.more()) {
    const auto line = words(lines.next());
    if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
    if (line[0] == "format") {
      header.form = ply_form(line);
      format_seen = true;
    } else if (line[0] == "element" && line.size() == 3) {
      ++elements;
      if (elements == 1) {
        const auto count = number_in(line[2]);
        if (line[1] != "vertex" || !count || !(*count >= 0 && *count <= 0x1p53)) fail("the first element must be the vertices");
        header.vertices = static_cast<std::size_t>(*count);
      }
    } else if (line[0] == "property" && elements == 1) {
      if (line.size() != 3 || line[1] == "list") fail("a vertex must have plain numbers as properties");
      const auto axis = std::string_view("xyz").find(line[2]);
      if (line[2].size() == 1 && axis != std::string_view::npos) {
        header.xyz[axis] = header.types.size();
        ++found[axis];
      }
      header.types.push_back(&type_named(line[1]));
    } else if (line[0] == "end_header") {
      if (!format_seen) fail("must be of format ascii 1.0 or binary_little_endian 1.0");
      if (found != std::array<std::size_t, 3>{1, 1, 1}) fail("a vertex must have the properties x, y and z");
      return header;
    }
  }
  fail("ends inside its header: is it cut off?");
}

KeptOf<Chunked<Vec3>> read_ply_ascii(const PlyHeader& header, Lines& lines, const Run& run) {
  KeptOf<Chunked<Vec3>> kept{.values = {}, .all = header.vertices};
  for (std::size_t vertex = 0; vertex < header.vertices; ++vertex) {
    if (!lines.more()) fail(cut_off(vertex, header.vertices, "vertices"));
    const auto line = lines.next();
    if (!is_in(run, vertex)) continue;
    const auto row = words(line);
    if (row.size() != header.types.size()) {
      fail(line_name(lines.number()) + " has " + std::to_string(row.size()) + " numbers: must have " +
           std::to_string(header.types.size()));
    }
    Vec3& point = kept.values.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = finite_number(row[header.xyz[axis]], lines.number());
  }
  return kept;
}

BinaryRows<Vec3> rows_of(const PlyHeader& header, std::size_t begins) {
  BinaryRows<Vec3> rows{.numbers = {}, .row_bytes = 0, .begins = begins, .all = header.vertices};
  for (std::size_t property = 0; property < header.types.size(); ++property) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (header.xyz[axis] == property) rows.numbers[axis] = {header.types[property], rows.row_bytes};
    }
    rows.row_bytes += header.types[property]->bytes;
  }
  return rows;
}

Points read_ply(Bytes& bytes, const Run& run) {
  Lines lines(bytes);
  const auto header = read_ply_header(lines);
  if (header.form == PlyHeader::Form::ascii) return read_ply_ascii(header, lines, run);
  const auto rows = rows_of(header, lines.next_begins());
  require_all(bytes, rows, "vertices");
  return read_points_of(bytes, rows, run);
}

// ---- .npy --------------------------------------------------------------------------------------------------------------

struct NpyHeader {
  const NumberType* type = nullptr;
  std::vector<std::size_t> shape;
};

// The text of a key of the header, which is a Python literal: {'descr': '<f4', 'fortran_order': False, 'shape': (5, 3), }
std::string_view npy_field(std::string_view header, std::string_view key) {
  const auto at = header.find("'" + std::string(key) + "':");
  if (at == std::string_view::npos) fail("has a header without " + std::string(key));
  return trimmed(header.substr(at + key.size() + 3));
}

std::vector<std::size_t> npy_shape(std::string_view text) {
  const auto end = text.find(')');
  if (!text.starts_with('(') || end == std::string_view::npos) fail("has a header without a shape");
  std::vector<std::size_t> shape;
  for (const auto part : split(text.substr(1, end - 1), ',')) {
    if (part.empty()) continue;
    std::size_t size = 0;
    const auto [last, error] = std::from_chars(part.data(), part.data() + part.size(), size);
    if (error != std::errc{} || last != part.data() + part.size()) fail("has a header without a shape");
    shape.push_back(size);
  }
  return shape;
}

NpyHeader parse_npy_header(std::string_view text) {
  NpyHeader header;
  const auto descr = npy_field(text, "descr");
  if (descr.starts_with("'<f4'")) header.type = &type_named("float");
  if (descr.starts_with("'<f8'")) header.type = &type_named("double");
  if (header.type == nullptr) fail("must hold little-endian float32 or float64 ('<f4' or '<f8')");
  if (!npy_field(text, "fortran_order").starts_with("False")) fail("must be in C order, and is in Fortran order");
  header.shape = npy_shape(npy_field(text, "shape"));
  return header;
}

std::string shape_text(const std::vector<std::size_t>& shape) {
  std::string text = "(";
  for (const auto size : shape) text += (text.size() > 1 ? ", " : "") + std::to_string(size);
  return text + (shape.size() == 1 ? ",)" : ")");
}

std::size_t npy_rows(const NpyHeader& header, std::size_t width) {
  const auto& shape = header.shape;
  const bool matches =
      width == 1 ? shape.size() == 1 || (shape.size() == 2 && shape[1] == 1) : shape.size() == 2 && shape[1] == width;
  if (!matches) {
    fail("has the shape " + shape_text(shape) + ": must be " + (width == 1 ? "(n,)" : "(n, " + std::to_string(width) + ")"));
  }
  return shape[0];
}

template <class Value>
BinaryRows<Value> npy_rows_of(Bytes& bytes) {
  constexpr std::string_view magic = "\x93NUMPY";
  constexpr std::size_t width = width_of<Value>;
  std::array<char, 12> start{};
  const std::size_t got = bytes.read(0, start);
  if (!std::string_view(start.data(), got).starts_with(magic)) fail("is not a NumPy array file");
  const auto ends = [] { fail("ends inside its header: is it cut off?"); };
  if (got < start.size()) ends();
  const int version = start[6];
  if (version != 1 && version != 2) fail("must be of format version 1 or 2");
  const std::size_t text_begins = version == 1 ? 10 : 12;
  const double length = version == 1 ? number_at<std::uint16_t>(&start[8]) : number_at<std::uint32_t>(&start[8]);
  const std::size_t begins = text_begins + static_cast<std::size_t>(length);
  if (bytes.size() < begins) ends();
  std::string text(begins - text_begins, '\0');
  if (bytes.read(text_begins, text) < text.size()) ends();
  const auto header = parse_npy_header(text);
  BinaryRows<Value> rows{
      .numbers = {}, .row_bytes = width * header.type->bytes, .begins = begins, .all = npy_rows(header, width)};
  for (std::size_t i = 0; i < width; ++i) rows.numbers[i] = {header.type, i * header.type->bytes};
  require_all(bytes, rows, "rows");
  if (bytes.size() - begins != rows.all * rows.row_bytes) {
    fail("holds more than the " + std::to_string(rows.all) + " rows that its header promises");
  }
  return rows;
}

// ---- any of them -------------------------------------------------------------------------------------------------------

std::optional<PointsFormat> format_of(const std::filesystem::path& path) {
  const auto extension = path.extension();
  if (extension == ".csv") return PointsFormat::csv;
  if (extension == ".ply") return PointsFormat::ply;
  if (extension == ".npy") return PointsFormat::npy;
  return std::nullopt;
}

Points points_in(Bytes& bytes, PointsFormat format, const Run& run) {
  switch (format) {
    case PointsFormat::csv:
      return read_csv<Chunked<Vec3>>(bytes, run);
    case PointsFormat::ply:
      return read_ply(bytes, run);
    case PointsFormat::npy:
      return read_points_of(bytes, npy_rows_of<Vec3>(bytes), run);
  }
  return {};
}

Kept<Vec3> in_float64(const Points& points) {
  return std::visit(
      [](const auto& held) {
        Kept<Vec3> kept{.values = {}, .all = held.all};
        kept.values.reserve(held.values.size());
        for (std::size_t n = 0; n < held.values.size(); ++n) {
          const auto& [x, y, z] = held.values[n];
          kept.values.push_back({double{x}, double{y}, double{z}});
        }
        return kept;
      },
      points);
}

Kept<double> numbers_in(Bytes& bytes, std::optional<PointsFormat> format, const Run& run) {
  if (format == PointsFormat::csv) return read_csv<std::vector<double>>(bytes, run);
  if (format == PointsFormat::npy) return read_rows<std::vector<double>>(bytes, npy_rows_of<double>(bytes), run);
  fail("must end in .csv or .npy");
}

}  // namespace

std::vector<Vec3> parse_points(std::string_view text, PointsFormat format) {
  HeldBytes bytes(text);
  return in_float64(points_in(bytes, format, {})).values;
}

std::vector<double> parse_numbers(std::string_view text, PointsFormat format) {
  HeldBytes bytes(text);
  return numbers_in(bytes, format, {}).values;
}

Points read_points_as_held(const std::filesystem::path& path, const Run& run) {
  const auto format = format_of(path);
  if (!format) fail("must end in .csv, .ply or .npy");
  return points_in(*bytes_of(path), *format, run);
}

Kept<Vec3> read_points(const std::filesystem::path& path, const Run& run) { return in_float64(read_points_as_held(path, run)); }

Kept<double> read_numbers(const std::filesystem::path& path, const Run& run) {
  const auto format = format_of(path);
  if (!format || format == PointsFormat::ply) fail("must end in .csv or .npy");
  return numbers_in(*bytes_of(path), format, run);
}

}  // namespace dvdx::tool
