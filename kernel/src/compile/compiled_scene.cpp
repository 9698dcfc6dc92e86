#include "compile/compiled_scene.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "compile/checker.hpp"
#include "compile/particle_values.hpp"
#include "compile/range.hpp"
#include "compile/validate.hpp"

namespace dvdx {
namespace {

std::optional<Error> check_sources(const System& system) {
  const auto& sources = system.sources();
  const auto apart = std::count_if(sources.begin(), sources.end(), [](const Source& s) { return !s.is_alike(); });
  if (system.is_uniform() || static_cast<std::size_t>(apart) <= max_sources) return std::nullopt;
  return Error{"forces", std::to_string(apart) + " accelerations that act differently on each particle",
               "at most " + std::to_string(max_sources) + " (a sinusoid counts two, a polynomial one a term, a wind one)"};
}

// Radial springs without a rest length pull alike in every direction: they are linear, and exact as such. (Their damping is
// not: it brakes along the line alone.)
Scene with_linear_springs(Scene scene) {
  for (Force& force : scene.forces) {
    const auto* radial = std::get_if<RadialSpring>(&force);
    if (radial == nullptr || radial->damping != 0 || radial->rest_length != Scalars(0.0)) continue;
    force = Spring{.stiffness = radial->stiffness, .damping = 0, .anchor = radial->anchor, .method = radial->method};
  }
  return scene;
}

template <class T>
std::optional<Error> make_free(CompiledScene<T>& compiled) {
  auto motion =
      std::make_unique<const FreeMotion<T>>(compiled.scene, compiled.options, *compiled.passes, compiled.count, compiled.start);
  auto error = motion->refusal();
  compiled.motion = std::move(motion);
  return error;
}

template <class T>
std::optional<Error> make_joined(CompiledScene<T>& compiled, std::shared_ptr<const Joints<T>> joints) {
  if (joints == nullptr) joints = std::make_shared<const Joints<T>>(compiled.scene, compiled.options, compiled.start);
  if (auto error = joints->refusal(compiled.scene, compiled.start, compiled.options.unstable)) return error;
  auto motion = std::make_unique<const JoinedMotion<T>>(std::move(joints), compiled.scene, compiled.options, *compiled.passes,
                                                        compiled.start);
  auto error = motion->refusal();
  compiled.motion = std::move(motion);
  return error;
}

// joints: those of the same networks and constraints at the same step, or null.
template <class T>
Expected<SharedScene<T>> build(Scene given, const Options& options, Isa isa, std::optional<std::size_t> count,
                               std::vector<Vec3> start, std::shared_ptr<const Joints<T>> joints) {
  const Passes* passes = find_passes(isa, options.arithmetic);
  auto compiled =
      std::make_shared<CompiledScene<T>>(with_linear_springs(std::move(given)), options, isa, *passes, count, std::move(start));
  if (auto error = check_sources(System(compiled->scene, compiled->start, options.step))) return tl::unexpected(*error);
  if (auto error = check_range<T>(compiled->scene, options, count, compiled->start)) return tl::unexpected(*error);
  const bool is_joined = steps_in_columns(compiled->scene);
  if (auto error = is_joined ? make_joined(*compiled, std::move(joints)) : make_free(*compiled)) return tl::unexpected(*error);
  return SharedScene<T>(std::move(compiled));
}

}  // namespace

template <class T>
Expected<SharedScene<T>> compile_scene(Scene scene, const Options& options, Isa isa, std::optional<std::size_t> count,
                                       std::vector<Vec3> start) {
  return build<T>(std::move(scene), options, isa, count, std::move(start), nullptr);
}

namespace {

// joints: those of `before` where springs and step are the same, or others.
template <class T>
std::shared_ptr<const Joints<T>> shared_joints(const CompiledScene<T>& before) {
  return before.joined() != nullptr ? before.joined()->shared_joints() : nullptr;
}

// Joined particles may get another number of sub-steps, and with it other coefficients of every spring.
template <class T>
std::shared_ptr<const Joints<T>> changed_joints(const CompiledScene<T>& before, const Scene& scene, const Options& options,
                                                Changed changed) {
  if (before.joined() == nullptr) return nullptr;
  return std::make_shared<const Joints<T>>(scene, options, before.start, before.joined()->joints(), changed);
}

Error no_such(const std::string& field, const std::string& what, std::size_t count) {
  return {field, "no " + what, "an index below " + std::to_string(count)};
}

}  // namespace

template <class T>
Expected<SharedScene<T>> with_step(const CompiledScene<T>& before, double h) {
  Options options = before.options;
  options.step = h;
  if (auto error = check(options)) return tl::unexpected(*error);
  if (auto error = check_range<T>(before.scene, options, before.count, before.start)) return tl::unexpected(*error);
  auto joints = changed_joints(before, before.scene, options, Changed::step);
  return build<T>(before.scene, options, before.isa, before.count, before.start, std::move(joints));
}

template <class T>
Expected<SharedScene<T>> with_scene(const CompiledScene<T>& before, Scene scene) {
  if (auto error = check(scene, before.count)) return tl::unexpected(*error);
  if (auto error = check_range<T>(scene, before.options, before.count, before.start)) return tl::unexpected(*error);
  auto joints = changed_joints(before, scene, before.options, Changed::springs);
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, std::move(joints));
}

template <class T>
Expected<SharedScene<T>> with_contact(const CompiledScene<T>& before, std::size_t index, const Contact& contact) {
  if (index >= before.scene.contacts.size()) {
    return tl::unexpected(no_such(element("contacts", index), "contact", before.scene.contacts.size()));
  }
  Scene scene = before.scene;
  scene.contacts[index] = contact;
  if (auto error = check(scene, before.count)) return tl::unexpected(*error);
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, shared_joints(before));
}

template <class T>
Expected<SharedScene<T>> with_force(const CompiledScene<T>& before, std::size_t index, const Force& force) {
  const std::string field = element("forces", index);
  if (index >= before.scene.forces.size()) return tl::unexpected(no_such(field, "force", before.scene.forces.size()));
  Scene scene = before.scene;
  scene.forces[index] = force;
  if (auto error = check(scene, before.count)) return tl::unexpected(*error);
  if (is_at_start(force) && before.start.empty()) {
    return tl::unexpected(Error{field + ".anchor", "at_start", "given, or at the start from the first"});
  }
  // A gust each frame must not look for the springs' frequency again.
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, shared_joints(before));
}

template struct CompiledScene<float>;
template struct CompiledScene<double>;
template Expected<SharedScene<float>> compile_scene<float>(Scene, const Options&, Isa, std::optional<std::size_t>,
                                                           std::vector<Vec3>);
template Expected<SharedScene<double>> compile_scene<double>(Scene, const Options&, Isa, std::optional<std::size_t>,
                                                             std::vector<Vec3>);
template Expected<SharedScene<float>> with_step<float>(const CompiledScene<float>&, double);
template Expected<SharedScene<double>> with_step<double>(const CompiledScene<double>&, double);
template Expected<SharedScene<float>> with_force<float>(const CompiledScene<float>&, std::size_t, const Force&);
template Expected<SharedScene<double>> with_force<double>(const CompiledScene<double>&, std::size_t, const Force&);
template Expected<SharedScene<float>> with_contact<float>(const CompiledScene<float>&, std::size_t, const Contact&);
template Expected<SharedScene<float>> with_scene<float>(const CompiledScene<float>&, Scene);
template Expected<SharedScene<double>> with_contact<double>(const CompiledScene<double>&, std::size_t, const Contact&);
template Expected<SharedScene<double>> with_scene<double>(const CompiledScene<double>&, Scene);

}  // namespace dvdx
