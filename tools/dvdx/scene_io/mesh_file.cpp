#include "scene_io/mesh_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "scene_io/text_lines.hpp"

namespace dvdx::tool {
namespace {

using Words = std::span<const std::string_view>;
using Face = std::vector<std::uint32_t>;

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
constexpr std::size_t longest_statement = std::size_t{1} << 24U;  // characters
constexpr double most_vertices = std::numeric_limits<std::uint32_t>::max();

class MeshReader {
 public:
  explicit MeshReader(std::string_view text) : lines_(text) {}

  MeshFile read() {
    while (lines_.more()) read_statement();
    if (mesh_.vertices.empty()) fail("holds no vertex: must hold lines such as \"v 1 0 0.5\"");
    if (largest_.vertex >= mesh_.vertices.size()) fail_index(std::to_string(largest_.vertex + 1), largest_.line);
    return std::move(mesh_);
  }

 private:
  struct Named {
    std::size_t vertex = 0;
    std::size_t line = 0;
  };

  // Reads a statement. A line that ends with a backslash continues in the next.
  void read_statement() {
    std::string_view line = lines_.next();
    if (lines_.number() == 1 && line.starts_with(byte_order_mark)) line.remove_prefix(byte_order_mark.size());
    if (!goes_on(line)) return read(line);
    std::string statement(line);
    while (goes_on(statement)) {
      statement.back() = ' ';
      if (lines_.more()) statement += lines_.next();
      if (statement.size() > longest_statement) fail(here() + " goes on a statement that is longer than 16 MiB");
    }
    read(statement);
  }
  static bool goes_on(std::string_view line) { return line.ends_with('\\') && line.find('#') == std::string_view::npos; }

  void read(std::string_view statement) {
    const auto all = words(statement.substr(0, statement.find('#')));
    if (all.empty()) return;
    const Words values = Words(all).subspan(1);
    if (is_keyword(all[0], "v")) read_vertex(values);
    if (is_keyword(all[0], "f") || is_keyword(all[0], "fo")) read_face(values);
    if (is_keyword(all[0], "l")) read_polyline(values);
  }
  static bool is_keyword(std::string_view word, std::string_view keyword) {
    return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                      [](char a, char b) { return a == b || (a >= 'A' && a <= 'Z' && a - 'A' + 'a' == b); });
  }

  void read_vertex(Words values) {
    // Some programs add a weight or a colour.
    if (values.size() < 3) fail(here() + " has " + std::to_string(values.size()) + " numbers: a vertex must have 3");
    Vec3 vertex{};
    for (std::size_t axis = 0; axis < 3; ++axis) vertex[axis] = finite_number(values[axis], lines_.number());
    mesh_.vertices.push_back(vertex);
  }

  void read_face(Words values) {
    auto face = read_indices(values, 3, "a face");
    auto sorted = face;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) fail(here() + " names vertex " + std::to_string(*twice + 1) + " twice in a face");
    mesh_.faces.push_back(std::move(face));
  }

  void read_polyline(Words values) {
    const auto line = read_indices(values, 2, "a line");
    for (std::size_t k = 1; k < line.size(); ++k) {
      if (line[k - 1] == line[k]) fail(here() + " joins vertex " + std::to_string(line[k] + 1) + " to itself");
      mesh_.lines.push_back({line[k - 1], line[k]});
    }
  }

  Face read_indices(Words values, std::size_t least, std::string_view what) {
    if (values.size() < least) {
      fail(here() + " names " + std::to_string(values.size()) + " vertices: " + std::string(what) + " must name at least " +
           std::to_string(least));
    }
    Face indices;
    for (const auto value : values) indices.push_back(read_index(value.substr(0, value.find('/'))));
    return indices;
  }

  std::uint32_t read_index(std::string_view text) {
    const auto number = number_in(text);
    const auto read_so_far = static_cast<double>(mesh_.vertices.size());
    const bool is_whole = number && *number == std::floor(*number);
    if (!is_whole || *number == 0 || *number > most_vertices || -*number > read_so_far) fail_index(text, lines_.number());
    const double index = *number > 0 ? *number - 1 : read_so_far + *number;
    const auto vertex = static_cast<std::uint32_t>(index);
    if (vertex > largest_.vertex) largest_ = {.vertex = vertex, .line = lines_.number()};
    return vertex;
  }

  [[noreturn]] void fail_index(std::string_view text, std::size_t line) const {
    fail(line_name(line) + " names vertex " + std::string(text) + ": must be from 1 to " +
         std::to_string(mesh_.vertices.size()) + ", or count back from -1");
  }

  [[nodiscard]] std::string here() const { return line_name(lines_.number()); }

  Lines lines_;
  MeshFile mesh_;
  Named largest_;  // faces may come before their vertices
};

Pair ordered(std::uint32_t a, std::uint32_t b) { return a < b ? Pair{a, b} : Pair{b, a}; }

std::vector<Pair> unique(std::vector<Pair> pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

// A side of a face, and the face's vertices next to it.
struct HalfEdge {
  Pair ends;
  Pair next;  // to either end
};

std::vector<HalfEdge> sides_of(const MeshFile& mesh) {
  std::vector<HalfEdge> sides;
  for (const auto& face : mesh.faces) {
    const auto n = face.size();
    for (std::size_t k = 0; k < n; ++k) {
      const auto a = face[k];
      const auto b = face[(k + 1) % n];
      const Pair next{face[(k + n - 1) % n], face[(k + 2) % n]};
      sides.push_back({.ends = ordered(a, b), .next = a < b ? next : Pair{next[1], next[0]}});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const HalfEdge& a, const HalfEdge& b) { return a.ends < b.ends; });
  return sides;
}

}  // namespace

MeshFile parse_mesh(std::string_view text) {
  // A carriage return alone ends a line, as on the first Macs, even if a tool has added other line ends.
  const auto ends_line = [&](std::size_t at) { return text[at] == '\r' && (at + 1 == text.size() || text[at + 1] != '\n'); };
  std::string lines;
  for (std::size_t at = text.find('\r'); at != std::string_view::npos; at = text.find('\r', at + 1)) {
    if (!ends_line(at)) continue;
    if (lines.empty()) lines = text;
    lines[at] = '\n';
  }
  return MeshReader(lines.empty() ? text : lines).read();
}

MeshFile read_mesh(const std::filesystem::path& path) { return parse_mesh(contents(path)); }

std::vector<Pair> edges_of(const MeshFile& mesh) {
  std::vector<Pair> edges;
  for (const auto& side : sides_of(mesh)) edges.push_back(side.ends);
  for (const auto& [a, b] : mesh.lines) edges.push_back(ordered(a, b));
  return unique(std::move(edges));
}

std::vector<Pair> diagonals_of(const MeshFile& mesh) {
  std::vector<Pair> diagonals;
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 2; k + 1 < face.size(); ++k) diagonals.push_back(ordered(face[0], face[k]));
    if (face.size() == 4) diagonals.push_back(ordered(face[1], face[3]));
  }
  return unique(std::move(diagonals));
}

std::vector<Pair> bends_of(const MeshFile& mesh) {
  const auto sides = sides_of(mesh);
  std::vector<Pair> bends;
  for (std::size_t k = 1; k < sides.size(); ++k) {
    if (sides[k].ends != sides[k - 1].ends) continue;
    for (std::size_t end = 0; end < 2; ++end) {
      const auto a = sides[k - 1].next[end];
      const auto b = sides[k].next[end];
      if (a != b) bends.push_back(ordered(a, b));
    }
  }
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 2; face.size() > 4 && k + 1 < face.size(); ++k) bends.push_back(ordered(face[k - 1], face[k + 1]));
  }
  return unique(std::move(bends));
}

}  // namespace dvdx::tool
