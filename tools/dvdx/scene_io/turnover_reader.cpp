#include "scene_io/turnover_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene_io/described.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/json_text.hpp"

namespace dvdx::tool {
namespace {

constexpr std::uint64_t most_alive = 0xffffffff;
constexpr std::size_t most_boundaries = 8;

enum class Shape { point, disc, box };
constexpr std::array<Named<Shape>, 3> shapes{{{"point", Shape::point}, {"disc", Shape::disc}, {"box", Shape::box}}};

// Returns the fields of an emitter: the keys of its shape, and those that all emitters have.
Fields emitter_fields(const Node& node, std::string_view what, std::initializer_list<std::string_view> own) {
  std::vector<std::string_view> keys{"type"};
  keys.insert(keys.end(), own);
  for_each_field<Emitter>([&](const auto& field) { keys.push_back(field.name); });
  return {node, what, std::move(keys)};
}

Vec3 direction(const Node& node) {
  const auto vector = node.vector();
  const double length = std::hypot(vector[0], vector[1], vector[2]);
  if (!(length > 0) || !std::isfinite(length)) node.refuse("a vector of finite length > 0");
  return vector;
}

Box read_box(const Fields& fields) {
  const auto min = fields.required("min");
  const auto max = fields.required("max");
  const Box box{.min = min.vector(), .max = max.vector()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box.min[axis] <= box.max[axis]) continue;
    min.at(axis).refuse(fmt::format("at most max[{}], which is {}", axis, shown(max.at(axis).json())));
  }
  return box;
}

void read_lifetime(const Node& node, Emitter& emitter) {
  if (!node.json().is_object()) {
    emitter.least_lifetime = emitter.most_lifetime = node.number(Range::positive);
    return;
  }
  const Fields fields(node, "a range of lifetimes", {"min", "max"});
  const auto min = fields.required("min");
  const auto max = fields.required("max");
  emitter.least_lifetime = min.number(Range::positive);
  emitter.most_lifetime = max.number(Range::positive);
  if (emitter.least_lifetime > emitter.most_lifetime) min.refuse("at most max, which is " + shown(max.json()));
}

// Reads the fields that all emitters have, whatever their shape.
Emitter with_births(Emitter emitter, const Fields& fields, const MotionNames& motions) {
  DescribedReader{.motions = &motions}.read_fields(fields, emitter);
  if (const auto end = fields.optional("end")) {
    emitter.end = end->number();
    if (emitter.end < emitter.start) end->refuse(fmt::format("at least start, which is {}", emitter.start));
  }
  if (const auto spread = fields.optional("spread")) {
    if (spread->json().is_array()) {
      emitter.spread = spread->vector(Range::non_negative);
    } else {
      emitter.spread = spread->number(Range::non_negative);
    }
  }
  if (const auto lifetime = fields.optional("lifetime")) read_lifetime(*lifetime, emitter);
  emitter.seed = fields.required("seed").whole(0, any_seed);
  return emitter;
}

Emitter read_emitter(const Node& node, const MotionNames& motions) {
  if (!node.json().is_object()) node.refuse("an object");
  if (!node.json().contains("type")) {
    throw Fault(Exit::bad_scene, node.file() + ": " + node.path() + ".type is missing: an emitter needs it");
  }
  Emitter emitter;
  switch (node.at("type").choice(shapes)) {
    case Shape::point: {
      const Fields fields = emitter_fields(node, "a point that emits", {"at"});
      emitter.shape = fields.required("at").vector();
      return with_births(emitter, fields, motions);
    }
    case Shape::disc: {
      const Fields fields = emitter_fields(node, "a disc that emits", {"center", "normal", "radius"});
      emitter.shape = Disc{.center = fields.required("center").vector(),
                           .normal = direction(fields.required("normal")),
                           .radius = fields.required("radius").number(Range::non_negative)};
      return with_births(emitter, fields, motions);
    }
    case Shape::box: {
      const Fields fields = emitter_fields(node, "a box that emits", {"min", "max"});
      emitter.shape = read_box(fields);
      return with_births(emitter, fields, motions);
    }
  }
  node.refuse("an emitter");
}

Removal read_removal(const Node& node) {
  const Fields fields = fields_of<Removal>(node);
  Removal removal;
  DescribedReader{}.read_fields(fields, removal);
  if (const auto boundaries = fields.optional("boundaries")) {
    const auto list = boundaries->elements("a list of boundaries");
    if (list.size() > most_boundaries) {
      boundaries->fail(fmt::format("has {} entries: must have at most {}", list.size(), most_boundaries));
    }
    for (const auto& boundary : list) {
      const Fields of(boundary, "a boundary", {"normal", "offset"});
      removal.boundaries.push_back({.normal = direction(of.required("normal")), .offset = of.required("offset").number()});
    }
  }
  if (const auto outside = fields.optional("outside")) {
    removal.outside = read_box(Fields(*outside, "a box", {"min", "max"}));
  }
  return removal;
}

}  // namespace

bool has_turnover(const Fields& scene) {
  return scene.optional("emitters") || scene.optional("removal") || scene.optional("capacity");
}

void read_turnover(const Fields& scene, SceneFile& file, const MotionNames& motions, const Room& room) {
  if (!has_turnover(scene)) return;
  file.is_origin_free = false;  // births are measured from the world's origin
  const auto capacity = scene.required("capacity");
  file.turnover.capacity = capacity.whole(std::max<std::uint64_t>(file.particles.total(), 1), most_alive);
  if (file.turnover.capacity > room.most()) capacity.refuse(room.limit());
  if (const auto emitters = scene.optional("emitters")) {
    for (const auto& emitter : emitters->elements("a list of emitters")) {
      file.turnover.emitters.push_back(read_emitter(emitter, motions));
    }
  }
  if (const auto removal = scene.optional("removal")) file.turnover.removal = read_removal(*removal);
}

void refuse_turnover(const SceneFile& file, std::string_view command) {
  if (!is_live(file)) return;
  throw Fault(
      Exit::bad_scene,
      fmt::format("{}: capacity is {}: must be left out for dvdx {}, which compares each particle with a reference over "
                  "the whole time; run, explain and verify take scenes whose particles come and go",
                  file.path, file.turnover.capacity, command));
}

}  // namespace dvdx::tool
