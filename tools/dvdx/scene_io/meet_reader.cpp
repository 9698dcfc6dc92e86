#include "scene_io/meet_reader.hpp"

#include <fmt/format.h>

#include "scene_io/described.hpp"

namespace dvdx::tool {
namespace {

constexpr std::uint64_t most_group = 1023;

std::uint16_t read_group(const Node& node) { return static_cast<std::uint16_t>(node.whole(0, most_group)); }

// A particle with several numbers belongs to the group of its first number.
std::vector<std::uint16_t> read_group_of_each(const Node& node, const Population& population) {
  const auto list = node.elements("a list of groups, one for each particle");
  if (list.size() != population.count) {
    node.fail(fmt::format("has {} entries: must have {}, one for each particle", list.size(), population.count));
  }
  std::vector<std::uint16_t> given;
  given.reserve(list.size());
  for (const Node& group : list) given.push_back(read_group(group));
  if (population.numbering == nullptr) return given;
  std::vector<std::uint16_t> groups;
  for (const auto number : population.numbering->numbers) groups.push_back(given[number]);
  return groups;
}

MeetGroups read_groups(const Node& node, const Population& population) {
  const Fields fields(node, "groups", {"of", "meet"});
  MeetGroups groups{.of = read_group_of_each(fields.required("of"), population), .meet = {}};
  for (const Node& pair : fields.required("meet").elements("a list of pairs of groups")) {
    const auto ends = pair.elements("two groups");
    if (ends.size() != 2) pair.refuse("two groups");
    groups.meet.push_back({read_group(ends[0]), read_group(ends[1])});
  }
  return groups;
}

}  // namespace

void read_meet(const Fields& scene, SceneFile& file, const Population& population) {
  const auto node = scene.optional("meet");
  if (!node) return;
  const Fields fields = fields_of<Meet>(*node);
  const auto radius = fields.optional("radius");
  const auto thickness = fields.optional("thickness");
  const auto part = fields.optional("part_of_cells");
  if (radius && thickness) thickness->refuse("left out beside radius: particles meet as balls or as cloth");
  if (radius && part) part->refuse("left out beside radius: particles meet as balls or as cloth");
  if (thickness && part) part->refuse("left out beside thickness: cloth has one thickness, or one of each cell");
  if (!radius && !thickness && !part) node->fail("has none of radius, thickness and part_of_cells: must have one of them");
  Meet meet;
  if (radius) meet.radius = read_scalars(*radius, population, Range::positive);
  if (thickness) {
    meet.thickness = thickness->number(Range::positive);
    if (file.scene.networks.empty()) thickness->refuse("left out of a scene without networks: balls have a radius");
  }
  if (part) {
    meet.part_of_cells = part->number(Range::positive);
    if (!(*meet.part_of_cells < 1)) part->refuse("a number > 0 and < 1");
    if (file.scene.networks.empty()) part->refuse("left out of a scene without networks: balls have a radius");
  }
  DescribedReader{}.read_fields(fields, meet);
  if (const auto apart = fields.optional("apart_at_start")) {
    if (!apart->json().is_boolean()) apart->refuse("true or false");
    meet.near_at_start = apart->json().get<bool>() ? NearAtStart::pass : NearAtStart::meet;
    if (meet.near_at_start == NearAtStart::pass && scene.optional("capacity"))
      apart->refuse("false or left out of a scene whose particles come and go");
  }
  if (const auto groups = fields.optional("groups")) meet.groups = read_groups(*groups, population);
  file.scene.add(std::move(meet));
}

}  // namespace dvdx::tool
