// What a plan holds: a compiled scene, which its clones share, and a workspace of its own.
#pragma once

#include <memory>
#include <utility>
#include <variant>

#include "compile/compiled_scene.hpp"
#include "execute/workspace.hpp"

namespace dvdx {

// Null where nothing joins particles.
template <class A>
std::unique_ptr<JoinedWorkspace<A>> make_workspace(const CompiledScene<A>& scene) {
  if (scene.joined() == nullptr) return nullptr;
  return std::make_unique<JoinedWorkspace<A>>(scene.joined()->shape(), scene.options.memory);
}

// Worked out in A.
template <class A>
struct PlanIn {
  explicit PlanIn(SharedScene<A> scene_) : scene(std::move(scene_)), workspace(make_workspace(*scene)) {}

  // All or nothing: a workspace that still fits is kept, and what it remembers with it.
  Expected<void> become(Expected<SharedScene<A>> changed) {
    if (!changed) return tl::unexpected(changed.error());
    const JoinedMotion<A>* joined = (*changed)->joined();
    if (joined != nullptr && !workspace->fits(joined->shape())) {
      auto made = make_workspace(**changed);
      made->go_on_from(std::move(*workspace));
      workspace = std::move(made);
    }
    scene = std::move(*changed);
    return {};
  }

  SharedScene<A> scene;
  std::unique_ptr<JoinedWorkspace<A>> workspace;
};

// Of states of T: in float64 where T is, or where float32 is compensated.
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

  std::variant<std::unique_ptr<JoinedWorkspace<float>>, std::unique_ptr<JoinedWorkspace<double>>> in;
};

}  // namespace dvdx
