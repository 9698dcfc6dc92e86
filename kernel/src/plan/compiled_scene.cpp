#include "plan/compiled_scene.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "meet/meet_rules.hpp"
#include "plan/validate.hpp"
#include "scene/checker.hpp"
#include "scene/particle_values.hpp"
#include "stability/scalar_range.hpp"
#include "stability/scheme_choice.hpp"

namespace dvdx {

std::optional<Error> check_sources(const System& system) {
  const auto& sources = system.sources();
  const auto apart = std::count_if(sources.begin(), sources.end(), [](const Source& s) { return !s.is_alike(); });
  if (system.is_uniform() || static_cast<std::size_t>(apart) <= max_sources) return std::nullopt;
  return Error{"forces", std::to_string(apart) + " accelerations that act differently on each particle",
               "at most " + std::to_string(max_sources) + " (a sinusoid counts two, a polynomial one a term, a wind one)"};
}

// A radial spring without a rest length pulls alike in every direction: it is linear, and exact as a linear spring. (Its
// damping is not linear: it brakes along the line alone.)
Force with_linear_spring(Force force) {
  const auto* radial = std::get_if<RadialSpring>(&force);
  if (radial == nullptr || radial->damping != 0 || radial->rest_length != Scalars(0.0)) return force;
  return Spring{.stiffness = radial->stiffness, .damping = 0, .anchor = radial->anchor, .method = radial->method};
}

namespace {

Scene with_linear_springs(Scene scene) {
  for (Force& force : scene.forces) {
    if (std::holds_alternative<RadialSpring>(force)) force = with_linear_spring(force);
  }
  return scene;
}

}  // namespace

template <class T>
Expected<typename CompiledScene<T>::Motion> make_motion(const CompiledScene<T>& compiled,
                                                        std::shared_ptr<CompiledNetwork<T>> compiled_network) {
  const auto made = [](auto motion) -> Expected<typename CompiledScene<T>::Motion> {
    if (auto error = motion->refusal()) return tl::unexpected(*error);
    return motion;
  };
  if (compiled_network == nullptr) {
    return made(std::make_unique<FreeMotion<T>>(compiled.scene, compiled.options, compiled.passes->template of<T>().free,
                                                compiled.count, compiled.start, compiled.shapes));
  }
  const Stay stay = compiled.particles == Particles::come_and_meet ? Stay::come_and_go : Stay::all;
  return made(std::make_unique<JoinedMotion<T>>(std::move(compiled_network), compiled.scene, compiled.options, *compiled.passes,
                                                compiled.start, compiled.shapes, stay));
}

namespace {

// before: a scene whose shapes may be shared, or null.
template <class T>
ShapeMemories<T> shapes_of(const std::vector<Contact>& contacts, const CompiledScene<T>* before) {
  ShapeMemories<T> shapes(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!has_memory(contacts[i])) continue;
    const bool is_known = before != nullptr && i < before->shapes.size() &&
                          have_same_memory(contacts[i], contact_of_flows(before->scene.contacts[i], before->scene.meet));
    shapes[i] = is_known ? before->shapes[i] : make_memory<T>(contacts[i]);
  }
  return shapes;
}

// compiled_network(scene, options, start): returns the network of these springs, constraints and step, if something joins.
// before: the scene that this one is a change of, or null.
template <class T, class MakeNetwork>
Expected<SharedScene<T>> build(Scene given, const Options& options, Isa isa, std::optional<std::size_t> count,
                               std::vector<Vec3> start, Particles particles, const MakeNetwork& compiled_network,
                               const CompiledScene<T>* before) {
  const Passes* passes = find_passes(isa, options.arithmetic);
  auto compiled = std::make_shared<CompiledScene<T>>(with_linear_springs(std::move(given)), options, isa, *passes, count,
                                                     std::move(start), particles);
  if (auto error = check_sources(System(compiled->scene, compiled->start, options.step, options.elsewhere)))
    return tl::unexpected(*error);
  if (auto error = check_range<T>(compiled->scene, options, count, compiled->start)) return tl::unexpected(*error);
  if (auto error = check_sweeps(compiled->scene, options.elsewhere, count)) return tl::unexpected(*error);
  if (auto error = check_meet_at_start(compiled->scene, options, compiled->start)) return tl::unexpected(*error);
  std::shared_ptr<CompiledNetwork<T>> made;
  if (particles != Particles::come_and_go && steps_in_columns(compiled->scene)) {
    made = compiled_network(compiled->scene, options, compiled->start);
  }
  if (made != nullptr) {
    if (auto error = made->refusal(compiled->scene, compiled->start, options.unstable)) return tl::unexpected(*error);
    compiled->scene.coupling.longest_substep = made->coupling.longest_substep;
    compiled->scene.coupling.line_forces = made->coupling.line_forces;
  }
  compiled->shapes = shapes_of(contacts_of_flows(compiled->scene), before);
  compiled->lengths =
      before != nullptr ? before->lengths : std::make_shared<const JoinedLengths>(compiled->scene, compiled->start);
  for (const Network& network : compiled->scene.networks) {
    compiled->torn.emplace_back(std::visit([](const auto& of) { return std::span(of.broken); }, network),
                                compiled->start.size());
  }
  if (before != nullptr) compiled->choice = before->choice;
  auto motion = make_motion(*compiled, std::move(made));
  if (!motion) return tl::unexpected(motion.error());
  compiled->motion = std::move(*motion);
  return compiled;
}

// Makes a network that keeps nothing of another.
template <class T>
std::shared_ptr<CompiledNetwork<T>> new_network(const Scene& scene, const Options& options, std::span<const Vec3> start) {
  return std::make_shared<CompiledNetwork<T>>(scene, options, start);
}

}  // namespace

template <class T>
Expected<SharedScene<T>> compile_scene(Scene scene, const Options& options, Isa isa, std::optional<std::size_t> count,
                                       std::vector<Vec3> start, Particles particles) {
  std::optional<SchemeChoice> choice;
  if (scene.coupling.scheme == Scheme::automatic) {
    choice = take_scheme(scene, options.longest_step.value_or(options.step), start);
  }
  auto made = build<T>(std::move(scene), options, isa, count, std::move(start), particles, new_network<T>, nullptr);
  if (made) (*made)->choice = choice;
  return made;
}

namespace {

// Keeps the network, for changes of forces or contacts.
template <class T>
auto shared_network(const CompiledScene<T>& before) {
  return [&](const Scene&, const Options&, std::span<const Vec3>) { return before.joined()->shared_network(); };
}

// Makes the network again: the number of sub-steps may change, and with it the coefficients of every spring.
template <class T>
auto changed_network(const CompiledScene<T>& before, Changed changed) {
  return [&before, changed](const Scene& scene, const Options& options, std::span<const Vec3> start) {
    return std::make_shared<CompiledNetwork<T>>(scene, options, start, before.joined()->network(), changed);
  };
}

}  // namespace

template <class T>
Expected<SharedScene<T>> with_step(const CompiledScene<T>& before, double h) {
  const Options options = with_other_step(before.options, h);
  if (auto error = check(options)) return tl::unexpected(*error);
  return build<T>(before.scene, options, before.isa, before.count, before.start, before.particles,
                  changed_network(before, Changed::step), &before);
}

template <class T>
Expected<SharedScene<T>> with_scene(const CompiledScene<T>& before, Scene scene) {
  if (auto error = check(scene, before.count, before.options.elsewhere)) return tl::unexpected(*error);
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles,
                  changed_network(before, Changed::springs), &before);
}

template <class T>
Expected<SharedScene<T>> with_contact(const CompiledScene<T>& before, std::size_t index, const Contact& contact) {
  if (index >= before.scene.contacts.size()) {
    return tl::unexpected(no_such("contacts", index, before.scene.contacts.size()));
  }
  Scene scene = before.scene;
  scene.contacts[index] = contact;
  if (auto error = check(scene, before.count, before.options.elsewhere)) return tl::unexpected(*error);
  const bool moves_in_columns = has_followers(before.scene) || has_followers(scene);
  if (before.particles == Particles::come_and_go || !moves_in_columns) {
    return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles,
                    shared_network(before), &before);
  }
  if (before.joined() == nullptr) {
    // A plan that never stepped in columns does not know how many particles there are.
    if (!before.count || before.start.size() != *before.count) {
      return tl::unexpected(
          Error{element("contacts", index) + ".motion", "given", "none where nothing followed one from the first"});
    }
    return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles, new_network<T>,
                    &before);
  }
  // Turning surfaces may ask for more sub-steps.
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles,
                  changed_network(before, Changed::step), &before);
}

template <class T>
std::optional<Error> refusal_of(const CompiledScene<T>& compiled, std::size_t index, const Force& force) {
  if (index >= compiled.scene.forces.size()) {
    return no_such("forces", index, compiled.scene.forces.size());
  }
  if (auto error = check(force, index, compiled.count)) return error;
  if (!is_at_start(force) || !compiled.start.empty()) return std::nullopt;
  return Error{element("forces", index) + ".anchor", "at_start", "given, or at the start from the first"};
}

template <class T>
bool asks_for_substeps(const CompiledScene<T>& before, std::size_t index, const Force& force) noexcept {
  if (before.joined() == nullptr || !before.joined()->network().depends_on_weight()) return false;
  return std::holds_alternative<Constant>(force) || std::holds_alternative<Constant>(before.scene.forces[index]);
}

template <class T>
Expected<SharedScene<T>> with_force(const CompiledScene<T>& before, std::size_t index, const Force& force) {
  if (auto error = refusal_of(before, index, force)) return tl::unexpected(*error);
  Scene scene = before.scene;
  scene.forces[index] = force;
  if (auto error = check(scene, before.count, before.options.elsewhere)) return tl::unexpected(*error);
  if (asks_for_substeps(before, index, force)) {
    return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles,
                    changed_network(before, Changed::step), &before);
  }
  // A force that changes every frame must not compute the springs' frequencies again.
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles,
                  shared_network(before), &before);
}

template <class T>
Expected<SharedScene<T>> with_wind(const CompiledScene<T>& before, const Wind& wind) {
  Scene scene = before.scene;
  scene.wind = wind;
  return build<T>(std::move(scene), before.options, before.isa, before.count, before.start, before.particles,
                  shared_network(before), &before);
}

template std::optional<Error> refusal_of(const CompiledScene<float>&, std::size_t, const Force&);
template std::optional<Error> refusal_of(const CompiledScene<double>&, std::size_t, const Force&);
template bool asks_for_substeps(const CompiledScene<float>&, std::size_t, const Force&) noexcept;
template bool asks_for_substeps(const CompiledScene<double>&, std::size_t, const Force&) noexcept;
template struct CompiledScene<float>;
template Expected<CompiledScene<float>::Motion> make_motion<float>(const CompiledScene<float>&,
                                                                   std::shared_ptr<CompiledNetwork<float>>);
template Expected<CompiledScene<double>::Motion> make_motion<double>(const CompiledScene<double>&,
                                                                     std::shared_ptr<CompiledNetwork<double>>);
template struct CompiledScene<double>;
template Expected<SharedScene<float>> compile_scene<float>(Scene, const Options&, Isa, std::optional<std::size_t>,
                                                           std::vector<Vec3>, Particles);
template Expected<SharedScene<double>> compile_scene<double>(Scene, const Options&, Isa, std::optional<std::size_t>,
                                                             std::vector<Vec3>, Particles);
template Expected<SharedScene<float>> with_step<float>(const CompiledScene<float>&, double);
template Expected<SharedScene<double>> with_step<double>(const CompiledScene<double>&, double);
template Expected<SharedScene<float>> with_force<float>(const CompiledScene<float>&, std::size_t, const Force&);
template Expected<SharedScene<double>> with_force<double>(const CompiledScene<double>&, std::size_t, const Force&);
template Expected<SharedScene<float>> with_wind<float>(const CompiledScene<float>&, const Wind&);
template Expected<SharedScene<double>> with_wind<double>(const CompiledScene<double>&, const Wind&);
template Expected<SharedScene<float>> with_contact<float>(const CompiledScene<float>&, std::size_t, const Contact&);
template Expected<SharedScene<float>> with_scene<float>(const CompiledScene<float>&, Scene);
template Expected<SharedScene<double>> with_contact<double>(const CompiledScene<double>&, std::size_t, const Contact&);
template Expected<SharedScene<double>> with_scene<double>(const CompiledScene<double>&, Scene);

}  // namespace dvdx
