#include "scene_io/pair_reader.hpp"

namespace dvdx::tool {

std::vector<Pair> read_pairs(const Node& node, const Population& population) {
  std::vector<Pair> pairs;
  for (const auto& element : node.elements("a list of pairs [i, j]")) {
    const auto ids = element.elements("a pair [i, j]");
    if (ids.size() != 2) element.refuse("a pair [i, j]");
    const Pair pair{static_cast<std::uint32_t>(read_particle(ids[0], population)),
                    static_cast<std::uint32_t>(read_particle(ids[1], population))};
    if (pair[0] == pair[1]) ids[1].refuse("another particle than the pair's first");
    pairs.push_back(pair);
  }
  return pairs;
}

std::optional<Scalars> read_lengths(const Node& node, const Population& pairs, const Range& range) {
  if (node.json() == "start") return std::nullopt;
  if (node.json().is_string()) node.refuse("\"start\", a number or an object with one of values, uniform, file");
  return read_scalars(node, pairs, range);
}

Population population_of(const std::vector<Pair>& pairs, const Population& population) {
  return {.count = pairs.size(), .folder = population.folder, .of = "pair"};
}

void add_lines(const std::vector<Pair>& pairs, SceneFile& file) {
  for (const Pair& pair : pairs) file.topology.lines.push_back(file.numbering.numbers_of(pair));
}

}  // namespace dvdx::tool
