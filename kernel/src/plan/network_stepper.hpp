// A call of step() where something joins particles.
#pragma once

#include <cstddef>

#include "contact/report/contact_recorder.hpp"
#include "dvdx/layouts/state.hpp"
#include "plan/compiled_scene.hpp"
#include "plan/workspace.hpp"

namespace dvdx {

// T: what the scene is worked out in; Kept: what the state is kept in, float32 and residuals where they differ. The workspace
// fits the motion. report: null where nobody asks what contacts do.
template <class T, class Kept>
StepResult step_joined(const CompiledScene<T>& scene, const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace,
                       State<Kept>& state, std::size_t steps, const ParallelFor& parallel,
                       ContactReport::Parts* report) noexcept;

}  // namespace dvdx
