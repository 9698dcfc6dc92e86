// The parts of a plan: a compiled scene, which its clones share, and a workspace of its own.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>
#include <variant>

#include "plan/changes.hpp"
#include "plan/compiled_scene.hpp"
#include "plan/in_place.hpp"
#include "plan/undo.hpp"
#include "plan/validate.hpp"
#include "plan/workspace.hpp"
#include "scene/checker.hpp"
#include "stability/scalar_range.hpp"
#include "work/environment.hpp"
#include "work/stepping.hpp"

namespace dvdx {

// Null if nothing joins particles.
template <class A>
std::unique_ptr<JoinedWorkspace<A>> make_workspace(const CompiledScene<A>& scene) {
  if (scene.joined() == nullptr) return nullptr;
  return std::make_unique<JoinedWorkspace<A>>(scene.joined()->shape(), scene.options.memory);
}

// Scenes that differ from a base in their step alone, shared by all instances of a plan. It keeps the latest ones.
template <class A>
class StepPool {
 public:
  // Returns base with the step h, or with the longest that its limit allows, made from `from`: base or one of these scenes.
  Expected<SharedScene<A>> with_step(const SharedScene<A>& base, const SharedScene<A>& from, double h);

 private:
  struct Kept {
    std::weak_ptr<CompiledScene<A>> base;
    double asked = 0;     // s
    bool varies = false;  // whether steps had varied before
    SharedScene<A> scene;
  };
  std::mutex mutex_;
  std::array<Kept, 4> kept_{};
  std::size_t next_ = 0;
};

// A: the scalar of the computation.
template <class A>
struct PlanIn {
  explicit PlanIn(SharedScene<A> scene_) : scene(std::move(scene_)), workspace(make_workspace(*scene)) {}

  // All or nothing. A workspace that still fits is kept, with all that it remembers.
  Expected<void> become(Expected<SharedScene<A>> changed) {
    if (!changed) return tl::unexpected(changed.error());
    auto more = room_for((*changed)->joined());
    scene = std::move(*changed);
    take(std::move(more));
    if (scene->joined() == nullptr) workspace = nullptr;
    return {};
  }

  // A change of particles or springs: see plan/changes.hpp.
  template <class Change>
  Expected<void> change(const Change& change) {
    if (auto error = change.refusal(scene->scene, scene->count)) return tl::unexpected(*error);
    if (is_only_owner(scene)) {
      if (scene->joined() != nullptr) workspace->reserve_held(scene->joined()->network().fixed.size() + 1);
      const Expected<InPlace> done = change_in_place(*scene, change);
      if (!done) return tl::unexpected(done.error());
      if (*done == InPlace::done) return {};
    }
    Scene changed = scene->scene;
    change.apply(changed, scene->count.value_or(0));
    return become(with_scene(*scene, std::move(changed)));
  }

  Expected<void> set_contact(std::size_t index, const Contact& contact) {
    if (is_only_owner(scene)) {
      const Expected<InPlace> done = replace_in_place(*scene, index, contact);
      if (!done) return tl::unexpected(done.error());
      if (*done == InPlace::done) return {};
    }
    return become(with_contact(*scene, index, contact));
  }

  Expected<void> set_wind(const Wind& wind) {
    if (auto error = check(wind)) return tl::unexpected(*error);
    if (auto error = check_range<A>(wind)) return tl::unexpected(*error);
    if (!is_only_owner(scene)) return become(with_wind(*scene, wind));
    set_wind_in_place(*scene, wind);
    return {};
  }

  Expected<void> set_force(std::size_t index, const Force& force) {
    if (!is_only_owner(scene)) return become(with_force(*scene, index, force));
    if (auto error = refusal_of(*scene, index, force)) return tl::unexpected(*error);
    if (asks_for_substeps(*scene, index, force)) return become(with_force(*scene, index, force));
    Force other = with_linear_spring(force);
    Force& place = scene->scene.forces[index];
    std::swap(place, other);
    Undo undo([&] { std::swap(place, other); });
    if (auto error = check_sources(System(scene->scene, scene->start, scene->options.step, scene->options.elsewhere)))
      return tl::unexpected(*error);
    if (auto error = check_range_of_forces<A>(scene->scene, scene->options, scene->count, scene->start)) {
      return tl::unexpected(*error);
    }
    return take_motion(undo, network());
  }

  Expected<void> set_network(std::size_t index, const Network& network) {
    if (auto error = refusal_of(scene->scene, index, network)) return tl::unexpected(*error);
    Scene changed = scene->scene;
    changed.networks[index] = with_broken_of(changed.networks[index], network);
    return become(with_scene(*scene, std::move(changed)));
  }

  // Keeps springs whose form does not depend on h. Makes other forms again, with the frequencies found before.
  Expected<void> set_step(double h) {
    const std::shared_ptr<CompiledNetwork<A>> of = network();
    const bool is_alone = is_only_owner(scene) && (of == nullptr || of.use_count() == 2);
    Options options = with_other_step(scene->options, h);
    if (of != nullptr && std::isfinite(h)) {
      h = of->step_within_limit(options);
      options = with_other_step(scene->options, h);
    }
    if (!is_alone || (of != nullptr && !of->can_change_step(options))) return become(with_step(*scene, h));
    if (auto error = check(options)) return tl::unexpected(*error);
    if (of != nullptr) of->reserve_step(scene->scene, scene->start);
    std::swap(scene->options, options);
    std::optional<std::tuple<double, std::optional<double>, Substeps>> before;
    Undo undo([&] {
      std::swap(scene->options, options);
      if (before) std::tie(of->step, of->longest_step, of->chosen) = *before;
    });
    if (auto error = check_range<A>(scene->scene, scene->options, scene->count, scene->start)) return tl::unexpected(*error);
    if (of != nullptr) {
      before.emplace(of->step, of->longest_step, of->chosen);
      of->change_step(scene->options);
      if (auto error = of->refusal(scene->scene, scene->start, options.unstable)) return tl::unexpected(*error);
    }
    Expected<void> taken = take_motion(undo, of);
    if (taken && of != nullptr) of->take_step(std::get<Substeps>(*before));
    return taken;
  }

  // Returns another workspace, driven as this plan's own. If another thread is stepping in that, nothing is driven, and a step
  // in the new one returns driven_elsewhere.
  [[nodiscard]] std::unique_ptr<JoinedWorkspace<A>> another_workspace() const {
    auto other = make_workspace(*scene);
    drive(other.get());
    return other;
  }
  // Drives the workspace of this plan, just cloned from `other`, likewise.
  void drive_as(const PlanIn& other) { other.drive(workspace.get()); }

  SharedScene<A> scene;
  std::unique_ptr<JoinedWorkspace<A>> workspace;
  std::uint64_t drives = 0;  // number of calls of set_pose() and its like
  std::shared_ptr<StepPool<A>> pool = std::make_shared<StepPool<A>>();

 private:
  void drive(JoinedWorkspace<A>* other) const {
    if (other == nullptr || drives == 0) return;
    const Stepping stepping(workspace->is_stepping);
    if (!stepping) return;
    other->motions = workspace->motions;
    other->groups = workspace->groups;
    other->skins = workspace->skins;
    other->known = drives;
  }

  [[nodiscard]] std::shared_ptr<CompiledNetwork<A>> network() const {
    return scene->joined() != nullptr ? scene->joined()->shared_network() : nullptr;
  }

  // Returns a new workspace if the present one does not fit, otherwise null.
  std::unique_ptr<JoinedWorkspace<A>> room_for(const JoinedMotion<A>* joined) {
    if (joined == nullptr) return nullptr;
    const WorkspaceShape shape = joined->shape();
    if (workspace == nullptr || !workspace->has_columns_of(shape))
      return std::make_unique<JoinedWorkspace<A>>(shape, scene->options.memory);
    workspace->reserve_held(shape.fixed);
    return nullptr;
  }
  void take(std::unique_ptr<JoinedWorkspace<A>> more) noexcept {
    if (more == nullptr) return;
    if (workspace != nullptr) more->go_on_from(std::move(*workspace));
    workspace = std::move(more);
  }

  template <class TakeBack>
  Expected<void> take_motion(Undo<TakeBack>& undo, std::shared_ptr<CompiledNetwork<A>> network) {
    auto motion = make_motion(*scene, std::move(network));
    if (!motion) return tl::unexpected(motion.error());
    const auto* joined = std::get_if<std::unique_ptr<JoinedMotion<A>>>(&*motion);
    auto more = room_for(joined != nullptr ? joined->get() : nullptr);
    scene->motion = std::move(*motion);
    take(std::move(more));
    undo.dismiss();
    return {};
  }
};

// The parts for states of T. The computation is in float64 if T is, or if float32 is compensated.
template <class T>
struct Plan<T>::Parts {
  template <class A>
  explicit Parts(SharedScene<A> scene) : in(PlanIn<A>(std::move(scene))) {}

  std::variant<PlanIn<float>, PlanIn<double>> in;
};

template <class T>
struct Workspace<T>::Parts {
  template <class A>
  explicit Parts(std::unique_ptr<JoinedWorkspace<A>> workspace) : in(std::move(workspace)) {}

  // Calls drive(workspace). From then on the workspace is driven by itself.
  template <class Drive>
  static Expected<void> driven(Parts* parts, const Drive& drive);

  std::variant<std::unique_ptr<JoinedWorkspace<float>>, std::unique_ptr<JoinedWorkspace<double>>> in;
};

// Returns change(parts->in), or an error if parts is null.
template <class Parts, class Change>
auto changed(Parts* parts, const char* what, const Change& change) -> decltype(std::visit(change, parts->in)) {
  if (parts == nullptr) return tl::unexpected(moved_from(what));
  const StepEnvironment environment;
  return std::visit(change, parts->in);
}

}  // namespace dvdx
