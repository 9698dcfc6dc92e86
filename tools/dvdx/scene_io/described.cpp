#include "scene_io/described.hpp"

#include <fmt/format.h>

#include <cmath>

namespace dvdx::tool {

Vec3 DescribedReader::unit_vector(const Node& node) {
  const auto normal = node.vector();
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  if (!(length > 0) || !std::isfinite(length)) node.refuse("a vector of finite length > 0");
  return {normal[0] / length, normal[1] / length, normal[2] / length};
}

void DescribedReader::value(const Node& node, const Range& range, int& to) const {
  to = static_cast<int>(node.whole(static_cast<std::uint64_t>(range.min), static_cast<std::uint64_t>(range.max)));
}

void DescribedReader::value(const Node& node, const Range& range, std::array<double, 2>& to) const {
  const bool is_each = node.json().is_array();
  if (is_each && node.json().size() != to.size()) node.refuse("a number, or one for each end");
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = (is_each ? node.at(k) : node).number(range);
}

void DescribedReader::value(const Node& node, const Range& range, std::array<Vec3, 2>& to) const {
  const auto points = node.elements("two points");
  if (points.size() != to.size()) node.refuse("two points");
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = points[k].vector(range);
}

// The terms of a polynomial.
void DescribedReader::value(const Node& node, const Range& range, std::vector<Vec3>& to) const {
  constexpr std::size_t most_terms = 8;
  const auto terms = node.elements("a list of 1 to 8 terms [x, y, z]");
  if (terms.empty() || terms.size() > most_terms) {
    node.fail(fmt::format("has {} terms: must have 1 to {}", terms.size(), most_terms));
  }
  for (const Node& term : terms) to.push_back(term.vector(range));
}

void DescribedReader::value(const Node& node, const Range& /*range*/, std::vector<Face>& to) const {
  const auto planes = node.elements("a list of 4 to 64 planes");
  if (planes.size() < 4 || planes.size() > 64) node.fail(fmt::format("has {} planes: must have 4 to 64", planes.size()));
  for (const Node& plane : planes) to.push_back(read<Face>(plane));
}

void DescribedReader::value(const Node& node, const Range& /*range*/, std::vector<Gust>& to) const {
  for (const Node& gust : node.elements("a list of gusts")) to.push_back(read<Gust>(gust));
}

void DescribedReader::value(const Node& node, const Range& range, PerAxis& to) const {
  to = node.json().is_array() ? PerAxis(node.vector(range)) : PerAxis(read_scalars(node, *population, range));
}

void DescribedReader::value(const Node& node, const Range& /*range*/, Anchor& to) const {
  if (node.json().is_string()) {
    if (node.json() != "start") node.refuse("\"start\", [x, y, z] or an object with one of values, uniform, file, lattice");
    to = at_start;
    return;
  }
  auto vectors = read_vectors(node, *population);
  if (const auto* all = std::get_if<Vec3>(&vectors)) {
    to = *all;
  } else if (auto* each = std::get_if<std::vector<Vec3>>(&vectors)) {
    to = std::move(*each);
  } else {
    to = each_of(vectors, population->run().count);
  }
}

}  // namespace dvdx::tool
