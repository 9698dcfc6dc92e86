#include "report/sample.hpp"

#include <algorithm>

#include "closed_form/closed_form.hpp"

namespace dvdx::tool::report {
namespace {

using Picks = std::vector<std::size_t>;

Picks evenly_spread(std::size_t count, std::size_t wanted) {
  Picks picks(wanted);
  for (std::size_t k = 0; k < picks.size(); ++k) picks[k] = k * count / picks.size();
  return picks;
}

template <class T>
std::vector<T> picked(const std::vector<T>& each, const Picks& picks) {
  std::vector<T> values;
  values.reserve(picks.size());
  for (const auto i : picks) values.push_back(each[i]);
  return values;
}

Scalars picked(const Scalars& scalars, const Picks& picks) {
  return scalars.is_uniform() ? scalars : Scalars(picked(scalars.each(), picks));
}

PerAxis picked(const PerAxis& values, const Picks& picks) {
  return values.is_uniform() ? values : PerAxis(picked(values.scalars(), picks));
}

Anchor picked(const Anchor& anchor, const Picks& picks) {
  if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) return picked(*each, picks);
  return anchor;
}

Vectors picked(const Vectors& vectors, const Picks& picks) {
  if (std::holds_alternative<Vec3>(vectors)) return vectors;
  std::vector<Vec3> values;
  values.reserve(picks.size());
  for (const auto i : picks) values.push_back(value_of(vectors, i));
  return values;
}

Origin picked(const Origin& origin, const Picks& picks) {
  return origin.is_each() ? Origin(picked(origin.each(), picks)) : origin;
}

void pick_values(Force& force, const Picks& picks) {
  const auto pick = [&](auto& f) {
    if constexpr (requires { f.anchor; }) f.anchor = picked(f.anchor, picks);
    if constexpr (requires { f.stiffness; }) f.stiffness = picked(f.stiffness, picks);
    if constexpr (requires { f.coefficient; }) f.coefficient = picked(f.coefficient, picks);
    if constexpr (requires { f.rest_length; }) f.rest_length = picked(f.rest_length, picks);
  };
  std::visit(pick, force);
}

std::vector<std::size_t> places_of(std::vector<std::size_t> ids, const Picks& picks) {
  std::sort(ids.begin(), ids.end());
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < picks.size(); ++k) {
    if (std::binary_search(ids.begin(), ids.end(), picks[k])) places.push_back(k);
  }
  return places;
}

}  // namespace

SceneFile sample_of(const SceneFile& file, std::size_t most) {
  return file.particles.count <= most || is_joined(file.scene) ? file : resized(file, most);
}

SceneFile resized(const SceneFile& file, std::size_t count) {
  const auto picks = evenly_spread(file.particles.count, count);
  // Copies field by field: a copy of the whole would needlessly hold millions of values.
  SceneFile sample{.path = file.path,
                   .name = file.name,
                   .about = file.about,
                   .step = file.step,
                   .duration = file.duration,
                   .particles = {.count = picks.size(),
                                 .position = picked(file.particles.position, picks),
                                 .velocity = picked(file.particles.velocity, picks)},
                   .scene = {},
                   .topology = {}};
  sample.scene.method = file.scene.method;
  sample.scene.mass = picked(file.scene.mass, picks);
  sample.scene.origin = picked(file.scene.origin, picks);
  sample.is_origin_free = file.is_origin_free;
  sample.scene.contacts = file.scene.contacts;
  sample.scene.motions = file.scene.motions;
  sample.scene.forces = file.scene.forces;
  for (auto& force : sample.scene.forces) pick_values(force, picks);
  sample.scene.fixed = places_of(file.scene.fixed, picks);
  return sample;
}

std::size_t most_error_particles(const SceneFile& file, Effort effort) {
  const bool is_stepped = closed_form_of(file) == ClosedForm::none;
  if (effort == Effort::quick) return is_stepped ? 128 : 1024;
  return is_stepped ? 1024 : 4096;
}

Scene with_method(Scene scene, Method method) {
  scene.method = method;
  for (auto& force : scene.forces) {
    std::visit([](auto& each) { each.method.reset(); }, force);
  }
  return scene;
}

}  // namespace dvdx::tool::report
